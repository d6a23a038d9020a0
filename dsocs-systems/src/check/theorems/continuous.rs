//! The continuous law `(Fᵗ)*Ω_L = Ω_L + dν` (paper, section 2), by quadrature along the flow.
//!
//! The motion, its variational equation and the integral `dν` are one system of differential equations, solved by
//! [extrapolation](crate::check::motion::extrapolation), which does not conserve the law by itself.

use dsocs_core::Kernel;
use dsocs_core::geometry::{
    Displacement, TwoForm, Variation, canonical_form, motion_near, state_displacements, variations,
};

use crate::check::motion::extrapolation::integrate;
use crate::check::motion::motions::State;
use crate::check::{Measured, larger};

/// The tolerance of the integration, relative to the sizes of the components.
const TOLERANCE: f64 = 1e-13;

/// Where the time is large beside the window, the tolerance is this many roundings of the time.
const ROUNDINGS: f64 = 8.0;

/// Terms below this part of the largest are replaced by it: the error of the quadrature does not shrink with
/// them.
const SMALLEST_TERMS: f64 = 1e-4;

/// The equations of the motion with its variations and `dν` for every pair of them.
struct Equations<'a> {
    /// The system.
    system: &'a dyn Kernel,
    /// The number of coordinates.
    n: usize,
    /// The number of variations.
    count: usize,
    /// The acceleration near which a solution is looked for, where there may be several.
    near: Option<&'a [f64]>,
}

/// The displacement number `k` of a state, whose parts are `(q, v)`, the displacements, `dν` for every pair, and the time.
fn displacement(n: usize, state: &[f64], k: usize) -> Displacement {
    let from = 2 * n * (1 + k);
    Displacement {
        first: state[from..from + n].to_vec(),
        second: state[from + n..from + 2 * n].to_vec(),
    }
}

impl Equations<'_> {
    /// The rate of change of a state.
    fn rate(&self, state: &[f64], rate: &mut [f64]) {
        // the last component of a state is the time
        let (Some(&t), Some(clock)) = (state.last(), rate.last_mut()) else {
            return;
        };
        *clock = 1.0;
        let n = self.n;
        let here = (t, &state[..n], &state[n..2 * n]);
        let Ok(point) = motion_near(self.system, here, self.near) else {
            rate.fill(f64::NAN);
            return;
        };
        let point = point.any();
        let moved: Vec<Displacement> = (0..self.count).map(|k| displacement(n, state, k)).collect();
        let Some(variations) = variations(self.system, point, &moved) else {
            rate.fill(f64::NAN);
            return;
        };
        let variations: Vec<_> = moved.iter().zip(&variations).collect();
        for i in 0..n {
            (rate[i], rate[n + i]) = (point.v[i], point.a[i]);
            for (k, (moved, variation)) in variations.iter().enumerate() {
                let from = 2 * n * (1 + k);
                (rate[from + i], rate[from + n + i]) = (moved.second[i], variation.a[i]);
            }
        }
        let mut place = 2 * n * (1 + self.count);
        for (k, u) in variations.iter().enumerate() {
            for w in &variations[..k] {
                rate[place] = Variation::rate(*u, *w);
                place += 1;
            }
        }
    }
}

/// The units in which coordinates, displacements and `dν` are compared, whatever those of the declaration are: the unit of time is the
/// window, and a coordinate `q_i` is `sqrt(m_ii) q_i` with its mass, so that all have the same unit, and products of two the unit of the form.
struct Units {
    /// The unit of each coordinate.
    lengths: Vec<f64>,
    /// The unit of time.
    time: f64,
}

impl Units {
    /// The units for a form at the start.
    fn new(form: &TwoForm, time: f64) -> Self {
        let masses = form.blocks[0][1].iter().enumerate();
        let masses: Vec<f64> = masses.map(|(i, row)| row[i].abs()).collect();
        let most = masses.iter().fold(0.0_f64, |most, mass| most.max(*mass));
        let length = |&mass: &f64| {
            // a coordinate without a mass of its own is measured with the largest mass
            let mass = if mass > 0.0 { mass } else { most };
            if mass > 0.0 { mass.sqrt().recip() } else { 1.0 }
        };
        Self {
            lengths: masses.iter().map(length).collect(),
            time: time.abs(),
        }
    }

    /// The size of a displacement, or of a position with its velocity.
    fn size(&self, first: &[f64], second: &[f64]) -> f64 {
        let parts = self.lengths.iter().zip(first.iter().zip(second));
        let parts = parts.map(|(length, (q, v))| larger(q.abs(), (v * self.time).abs()) / length);
        parts.fold(0.0, larger)
    }

    /// The sizes of the components of a state with `count` displacements.
    fn sizes(&self, state: &[f64], count: usize) -> Vec<f64> {
        let n = self.lengths.len();
        let (moved, rest) = state.split_at(2 * n * (1 + count));
        let blocks: Vec<f64> = moved
            .chunks((2 * n).max(1))
            .map(|block| self.size(&block[..n], &block[n..]))
            .collect();
        let mut sizes = Vec::with_capacity(state.len());
        for size in &blocks {
            sizes.extend(self.lengths.iter().map(|length| size * length));
            sizes.extend(self.lengths.iter().map(|length| size * length / self.time));
        }
        for (k, first) in blocks.iter().skip(1).enumerate() {
            let others = blocks.iter().skip(1).take(k);
            sizes.extend(others.map(|second| first * second / self.time));
        }
        // the last component of a state is the time
        sizes.extend(rest.last().map(|t| larger(t.abs(), self.time)));
        sizes
    }
}

/// The defect of the law after the time `until`, and the size of `dν`, both relative to the terms of the law,
/// on the displacements that constraints of lower order allow.
pub fn law(system: &dyn Kernel, start: &State, until: f64) -> Measured<[f64; 2]> {
    let (kernel, t, near) = (system, start.t, start.near.as_deref());
    let allowed = state_displacements(kernel, t, &start.q, &start.v);
    let (n, count) = (start.q.len(), allowed.len());
    let before = canonical_form(kernel, t, &start.q, &start.v);
    let mut state = [&start.q[..], &start.v].concat();
    for Displacement { first, second } in &allowed {
        state.extend(first.iter().chain(second));
    }
    state.resize(state.len() + count * count.saturating_sub(1) / 2, 0.0);
    state.push(t);
    let equations = Equations {
        system,
        n,
        count,
        near,
    };
    let units = Units::new(&before, until);
    let run = |tolerance| {
        integrate(
            &mut |state, rate| equations.rate(state, rate),
            &|state| units.sizes(state, count),
            state.clone(),
            until,
            tolerance,
        )
    };
    // no rate is known better than the time at which it is taken
    let of_time = ROUNDINGS * f64::EPSILON * t.abs() / until.abs();
    let end = match run(TOLERANCE) {
        Err(_) if of_time > TOLERANCE => run(of_time)?,
        end => end?,
    };
    let after = canonical_form(kernel, t + until, &end[..n], &end[n..2 * n]);
    let mut entries = Vec::new();
    let mut place = 2 * n * (1 + count);
    for (k, first) in allowed.iter().enumerate() {
        for (l, second) in allowed[..k].iter().enumerate() {
            let (u, w) = (displacement(n, &end, k), displacement(n, &end, l));
            let first = before.of(first, second);
            let d_nu = end[place];
            let terms = size(&after, &u, &w) + first.abs() + d_nu.abs();
            let apart = (after.of(&u, &w) - first - d_nu).abs();
            entries.push([apart, d_nu.abs(), terms]);
            place += 1;
        }
    }
    // where the terms nearly vanish, the error of the quadrature does not
    let least = SMALLEST_TERMS * entries.iter().fold(0.0, |most, entry| larger(most, entry[2]));
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
fn size(form: &TwoForm, u: &Displacement, w: &Displacement) -> f64 {
    let (u, w) = ([&u.first[..], &u.second], [&w.first[..], &w.second]);
    let mut sum = 0.0;
    for (a, u) in u.into_iter().enumerate() {
        for (b, w) in w.into_iter().enumerate() {
            for (row, u) in form.blocks[a][b].iter().zip(u) {
                sum += row.iter().zip(w).map(|(x, w)| (u * x * w).abs()).sum::<f64>();
            }
        }
    }
    sum
}
