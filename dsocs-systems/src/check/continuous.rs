//! The continuous law `(Fᵗ)*Ω_L = Ω_L + dν` (paper, section 2), by quadrature along the flow.
//!
//! The motion, its variational equation and the integral `dν` are one system of differential equations, solved by
//! [extrapolation](super::extrapolation), which does not conserve the law by itself.

use dsocs_core::geometry::{
    Displacement, Solvable, TwoForm, Variation, canonical_form, motion_near, state_displacements, variation,
};

use super::extrapolation::integrate;
use super::probe::State;
use super::{Measured, larger};

/// The tolerance of the integration, relative and absolute.
const TOLERANCE: f64 = 1e-13;

/// Terms below this part of the largest are faint.
const FAINT: f64 = 1e-4;

/// The motion with its variations and `dν` for every pair of them.
struct Equations<'a, const N: usize> {
    /// The system.
    system: &'a dyn Solvable<N>,
    /// The number of variations.
    count: usize,
    /// Near which the acceleration is, where there may be several.
    near: Option<[f64; N]>,
}

/// The parts of a state: `(q, v)`, the displacements, `dν` for every pair, and the time.
fn part<const N: usize>(state: &[f64], from: usize) -> [f64; N] {
    core::array::from_fn(|i| state[from + i])
}

/// The displacement number `k` of a state.
fn displacement<const N: usize>(state: &[f64], k: usize) -> Displacement<N> {
    let from = 2 * N * (1 + k);
    Displacement {
        first: part(state, from),
        second: part(state, from + N),
    }
}

impl<const N: usize> Equations<'_, N> {
    /// The rate of change of a state.
    fn rate(&self, state: &[f64], rate: &mut [f64]) {
        // the last of a state is the time
        let (Some(&t), Some(clock)) = (state.last(), rate.last_mut()) else {
            return;
        };
        *clock = 1.0;
        let here = (t, part::<N>(state, 0), part(state, N));
        let Ok(point) = motion_near(self.system, here, self.near.as_ref()) else {
            rate.fill(f64::NAN);
            return;
        };
        let mut variations = Vec::with_capacity(self.count);
        for k in 0..self.count {
            let moved = displacement::<N>(state, k);
            let Some(variation) = variation(self.system, &point, &moved) else {
                rate.fill(f64::NAN);
                return;
            };
            variations.push((moved, variation));
        }
        for i in 0..N {
            (rate[i], rate[N + i]) = (point.v[i], point.a[i]);
            for (k, (moved, variation)) in variations.iter().enumerate() {
                let from = 2 * N * (1 + k);
                (rate[from + i], rate[from + N + i]) = (moved.second[i], variation.a[i]);
            }
        }
        let mut place = 2 * N * (1 + self.count);
        for (k, u) in variations.iter().enumerate() {
            for w in &variations[..k] {
                rate[place] = Variation::rate((&u.0, &u.1), (&w.0, &w.1));
                place += 1;
            }
        }
    }
}

/// By how much the law is missed after the time `until`, and how large `dν` is, both relative to the terms of the law, on the
/// displacements that constraints of lower order allow.
pub fn law<const N: usize>(
    system: &dyn Solvable<N>,
    State {
        t,
        q: q0,
        v: v0,
        near,
    }: &State<N>,
    until: f64,
) -> Measured<[f64; 2]> {
    let allowed = state_displacements(system, *t, q0, v0);
    let count = allowed.len();
    let mut start = vec![0.0; 2 * N * (1 + count) + count * count.saturating_sub(1) / 2];
    start.push(*t);
    for i in 0..N {
        (start[i], start[N + i]) = (q0[i], v0[i]);
        for (k, displacement) in allowed.iter().enumerate() {
            let from = 2 * N * (1 + k);
            (start[from + i], start[from + N + i]) = (displacement.first[i], displacement.second[i]);
        }
    }
    let near = *near;
    let equations = Equations { system, count, near };
    let end = integrate(
        &mut |state, rate| equations.rate(state, rate),
        start,
        until,
        TOLERANCE,
    )?;
    let before = canonical_form(system, *t, q0, v0);
    let after = canonical_form(system, t + until, &part(&end, 0), &part(&end, N));
    let mut entries = Vec::new();
    let mut place = 2 * N * (1 + count);
    for (k, first) in allowed.iter().enumerate() {
        for (l, second) in allowed[..k].iter().enumerate() {
            let (u, w) = (displacement::<N>(&end, k), displacement(&end, l));
            let first = before.of(first, second);
            let d_nu = end[place];
            let terms = size(&after, &u, &w) + first.abs() + d_nu.abs();
            let apart = (after.of(&u, &w) - first - d_nu).abs();
            entries.push([apart, d_nu.abs(), terms]);
            place += 1;
        }
    }
    // where terms nearly vanish, what the quadrature leaves does not
    let least = FAINT * entries.iter().fold(0.0, |most, entry| larger(most, entry[2]));
    let (mut missed, mut change) = (0.0, 0.0);
    for [apart, d_nu, terms] in entries {
        if terms != 0.0 {
            missed = larger(missed, apart / larger(terms, least));
            change = larger(change, d_nu / terms);
        }
    }
    Ok([missed, change])
}

/// The sum of the absolute values of a form's terms.
fn size<const N: usize>(form: &TwoForm<N>, u: &Displacement<N>, w: &Displacement<N>) -> f64 {
    let (u, w) = ([u.first, u.second], [w.first, w.second]);
    let mut sum = 0.0;
    for (a, u) in u.iter().enumerate() {
        for (b, w) in w.iter().enumerate() {
            for (row, u) in form.blocks[a][b].iter().zip(u) {
                sum += row.iter().zip(w).map(|(x, w)| (u * x * w).abs()).sum::<f64>();
            }
        }
    }
    sum
}
