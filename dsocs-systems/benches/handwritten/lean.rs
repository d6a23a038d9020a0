//! A step with all tests of a smooth step of `Flow`, written by hand around the generated code, behind an
//! object-safe trait: a measure of what the library's step may cost.

use dsocs_core::__private::Unknown;
use dsocs_core::{Leg, System};

use super::{LAST_UPDATE, Path, SECOND_DIFFERENCE, SETTLED};

/// A run as the library's rarely used code would see it, on slices.
pub trait Kernel {
    /// Takes up to `count` steps; `false` where a test of a step fails.
    fn steps(&mut self, count: u64) -> bool;

    /// The last position.
    fn place(&self) -> &[f64];
}

/// The largest relative distance of a determinant from its extrapolations; and the largest relative change,
/// after another one as small, that is accepted without an extrapolation.
const FITS: f64 = 0.5;
const STEADY: f64 = 0.25;

/// The steps of one system.
#[derive(Clone)]
pub struct Lean<'s, S: System<N>, const N: usize> {
    system: &'s S,
    constants: S::Constants<f64>,
    h: f64,
    t: f64,
    path: Path<N>,
    /// Backward differences of the last unknowns; NaN where the past is too short.
    past: [S::Unknown<f64>; 6],
    size: S::Unknown<f64>,
    determinants: [f64; 3],
    steady: bool,
    scales: S::Unknown<f64>,
}

impl<'s, S: System<N>, const N: usize> Lean<'s, S, N> {
    /// Begins at the second node `leg.q` with the increment that led to it.
    pub fn new(system: &'s S, h: f64, leg: &Leg<f64, N>) -> Self {
        let zero = S::Unknown::<f64>::zero();
        let nothing = zero.zip(&zero, |_, _| f64::NAN);
        Self {
            system,
            constants: system.constants(&system.parameters(), h),
            h,
            t: leg.t,
            path: Path {
                q: leg.q,
                q_low: [0.0; N],
                d: leg.d,
                d_low: [0.0; N],
            },
            past: [nothing; 6],
            size: zero,
            determinants: [f64::NAN; 3],
            steady: false,
            scales: nothing,
        }
    }

    #[inline(always)]
    fn predict(&self) -> S::Unknown<f64> {
        let last = self.past[0];
        let sizes = last.zip(&last, |z, _| z.abs());
        let (mut guess, mut sum, mut smallest, mut before) = (last, last, sizes, sizes);
        for difference in &self.past[1..] {
            let (guess, sum, smallest, before) =
                (guess.as_mut(), sum.as_mut(), smallest.as_mut(), before.as_mut());
            for (i, &x) in difference.as_ref().iter().enumerate() {
                sum[i] += x;
                let size = x.abs();
                let larger = if before[i] > size { before[i] } else { size };
                guess[i] = if larger <= smallest[i] { sum[i] } else { guess[i] };
                smallest[i] = if larger < smallest[i] { larger } else { smallest[i] };
                before[i] = size;
            }
        }
        guess
    }

    #[inline(always)]
    fn is_declared(&mut self, known: &S::Known<f64>, z: &S::Unknown<f64>, nearby: &S::Unknown<f64>) -> bool {
        if !S::SCALED {
            return true;
        }
        let here = self.system.scales(&self.constants, known, z);
        let last = std::mem::replace(&mut self.scales, here);
        let near = |there: &S::Unknown<f64>, part: f64| {
            let mut scales = here.as_ref().iter().zip(there.as_ref());
            scales.all(|(here, there)| (here - there).abs() < part * here.abs())
        };
        near(&last, 0.5) || near(&self.system.scales(&self.constants, known, nearby), 1e-2)
    }

    #[inline(always)]
    fn continues(&mut self, now: f64) -> bool {
        let [a, b, c] = self.determinants;
        let nearly = (a - now).abs() <= STEADY * now.abs();
        let continued = [2.0 * a - b, if c.is_nan() { a } else { 3.0 * (a - b) + c }];
        let fits = (self.steady && nearly)
            || a.is_nan()
            || b.is_nan()
            || continued.iter().all(|x| (x - now).abs() <= FITS * now.abs());
        self.steady = nearly;
        self.determinants = [now, a, b];
        fits
    }

    #[inline(always)]
    fn step(&mut self) -> bool {
        let leg = Leg {
            t: if S::DEPENDS_ON_TIME { self.t } else { 0.0 },
            q: self.path.q,
            d: self.path.d,
        };
        let known = self.system.known(&self.constants, &leg);
        let guess = self.predict();
        let begins = guess.as_ref().iter().any(|z| z.is_nan());
        let mut z = if begins { S::Unknown::<f64>::zero() } else { guess };
        let increment = self.system.unknown(&leg.d, &[]);
        let size = self
            .size
            .zip(&increment, |size, d| size.max(SECOND_DIFFERENCE * d.abs()));
        let (mut before, mut evaluations) = (z, 0);
        let determinant = loop {
            let mut linear = self.system.linearize(&self.constants, &known, &z);
            let mut update = linear.rows;
            let (safe, determinant) = S::Unknown::<f64>::solve_quick(&mut linear.jacobian, &mut update);
            let update = update.zip(&update, |x, _| -x);
            evaluations += 1;
            if !safe {
                return false;
            }
            let settled = if evaluations == 1 {
                small(&update, &z, &size, LAST_UPDATE)
            } else {
                SETTLED.iter().any(|&(largest, smallest)| {
                    small(&update, &z, &size, largest) && !small(&before, &z, &size, smallest)
                }) || evaluations > 3 && small(&update, &z, &size, LAST_UPDATE)
            };
            let next = z.zip(&update, |z, update| z + update);
            if settled {
                if !self.is_declared(&known, &z, &next) {
                    return false;
                }
                if !begins && !S::DIVIDED && evaluations > 2 && relative(&update, &z, &size) > 0.5 {
                    return false;
                }
                z = next;
                break determinant;
            }
            if evaluations > 8 && !begins {
                return false;
            }
            (before, z) = (update, next);
        };
        if !S::DIVIDED && !self.continues(determinant.value) {
            return false;
        }
        let e = self.system.second_difference(&self.constants, &known, &z);
        let mut path = self.path;
        path.advance(e);
        if !path.q.iter().all(|q| q.is_finite()) {
            return false;
        }
        self.path = path;
        let mut difference = z;
        for entry in &mut self.past {
            let last = std::mem::replace(entry, difference);
            difference = difference.zip(&last, |new, old| new - old);
        }
        self.size = self.size.zip(&z, |size, z| (0.75 * size).max(z.abs()));
        self.t += self.h;
        true
    }
}

#[inline(always)]
fn small<U: Unknown<f64>>(update: &U, z: &U, size: &U, tolerance: f64) -> bool {
    let mut sizes = update.as_ref().iter().zip(z.as_ref()).zip(size.as_ref());
    sizes.all(|((update, z), size)| update.abs() <= tolerance * z.abs().max(*size))
}

#[inline(always)]
fn relative<U: Unknown<f64>>(update: &U, z: &U, size: &U) -> f64 {
    let sizes = update.as_ref().iter().zip(z.as_ref()).zip(size.as_ref());
    sizes.fold(0.0, |most, ((update, z), size)| {
        f64::max(most, update.abs() / z.abs().max(*size))
    })
}

impl<S: System<N>, const N: usize> Kernel for Lean<'_, S, N> {
    fn steps(&mut self, count: u64) -> bool {
        (0..count).all(|_| self.step())
    }

    fn place(&self) -> &[f64] {
        &self.path.q
    }
}
