//! Differential equations by extrapolation, of order 16.
//!
//! Gragg's modified midpoint rule with 2, 4, … substeps, its even powers of the step removed one by one by the scheme of Aitken and
//! Neville (Hairer, Nørsett and Wanner, *Solving Ordinary Differential Equations I*, section II.9). It knows nothing of
//! mechanics and conserves nothing by itself.

use std::fmt;

use crate::check::larger;

/// The number of runs of the midpoint rule from which a step is extrapolated.
const RUNS: usize = 8;

/// The largest number of refusals of a step in a row, and of steps.
const LIMITS: [usize; 2] = [60, 1_000];

/// The reason why an integral is not reached.
pub enum QuadratureError {
    /// No step is small enough at a time, or the rates are not finite there.
    NoStep(f64),
    /// The largest number of steps is done at a time.
    TooManySteps(f64),
}

impl fmt::Display for QuadratureError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoStep(t) => write!(f, "the quadrature finds no step at t = {t}"),
            Self::TooManySteps(t) => {
                write!(
                    f,
                    "the quadrature does not end within {} steps: it is at t = {t}",
                    LIMITS[1]
                )
            }
        }
    }
}

impl std::error::Error for QuadratureError {}

dsocs_core::debug_is_message!(QuadratureError);

/// Writes the rate of change of a state, its first argument, into the second.
pub type Rate<'r> = &'r mut dyn FnMut(&[f64], &mut [f64]);

/// The sizes of a state's components; errors are relative to them.
pub type Sizes<'s> = &'s dyn Fn(&[f64]) -> Vec<f64>;

/// The state after the time `until`, with an error per step below `tolerance`, relative to the sizes of the state's components.
///
/// # Errors
///
/// [`QuadratureError`] if the rates are not finite, no step is small enough, or there would be too many.
pub fn integrate(
    rate: Rate<'_>,
    sizes: Sizes<'_>,
    mut state: Vec<f64>,
    until: f64,
    tolerance: f64,
) -> Result<Vec<f64>, QuadratureError> {
    let (mut t, mut h) = (0.0, until);
    let mut refused = 0;
    for _ in 0..LIMITS[1] {
        #[allow(clippy::float_cmp)] // the last step ends exactly there
        if t == until {
            return Ok(state);
        }
        // a remainder that is hardly longer than the step is done in one
        let last = (until - t).abs() <= 1.01 * h.abs();
        if last {
            h = until - t;
        }
        let (next, error) = step(rate, sizes, &state, h);
        let error = error / tolerance;
        let factor = if error.is_finite() {
            0.9 * error.max(1e-12).powf(-1.0 / (2 * RUNS - 1) as f64)
        } else {
            0.2
        };
        if error <= 1.0 {
            (state, refused) = (next, 0);
            t = if last { until } else { t + h };
        } else {
            refused += 1;
            if refused > LIMITS[0] {
                return Err(QuadratureError::NoStep(t));
            }
        }
        h *= factor.clamp(0.2, 4.0);
    }
    Err(QuadratureError::TooManySteps(t))
}

/// A step: the state at its end, and the last correction of the extrapolation, relative to the sizes of the state's components.
fn step(rate: Rate<'_>, sizes: Sizes<'_>, state: &[f64], h: f64) -> (Vec<f64>, f64) {
    // the last row of the scheme: entry `k` is free of the first `k` even powers
    let mut row: Vec<Vec<f64>> = Vec::with_capacity(RUNS);
    let substeps = |run: usize| 2 * (run + 1);
    for run in 0..RUNS {
        let mut improved = midpoint(rate, state, h, substeps(run));
        for (k, before) in row.iter_mut().enumerate() {
            let ratio = substeps(run) as f64 / substeps(run - k - 1) as f64;
            let part = 1.0 / (ratio * ratio - 1.0);
            let further = improved
                .iter()
                .zip(&*before)
                .map(|(new, old)| new + part * (new - old))
                .collect();
            *before = std::mem::replace(&mut improved, further);
        }
        row.push(improved);
    }
    let (best, second) = (&row[RUNS - 1], &row[RUNS - 2]);
    let apart = best.iter().zip(second).map(|(x, y)| (x - y).abs());
    let relative = apart.zip(sizes(best)).map(|(apart, size)| match apart {
        0.0 => 0.0,
        apart => apart / size,
    });
    let error = relative.fold(0.0, larger);
    (row.swap_remove(RUNS - 1), error)
}

/// Gragg's modified midpoint rule with an even number of substeps and his smoothing at the end.
fn midpoint(rate: Rate<'_>, state: &[f64], h: f64, substeps: usize) -> Vec<f64> {
    let part = h / substeps as f64;
    let mut change = vec![0.0; state.len()];
    let mut before = state.to_vec();
    rate(&before, &mut change);
    let mut now: Vec<f64> = before
        .iter()
        .zip(&change)
        .map(|(x, rate)| x + part * rate)
        .collect();
    for _ in 1..substeps {
        rate(&now, &mut change);
        for ((before, now), rate) in before.iter_mut().zip(&mut now).zip(&change) {
            let after = *before + 2.0 * part * rate;
            (*before, *now) = (*now, after);
        }
    }
    // the mean of the last point, and of the means of its neighbours
    rate(&now, &mut change);
    let ends = before.iter().zip(&now).zip(&change);
    ends.map(|((before, now), rate)| 0.5 * (now + before + part * rate))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_kepler_orbit_closes() -> Result<(), QuadratureError> {
        // eccentricity 0.6, period 2π
        let start = [0.4, 0.0, 0.0, 2.0];
        let mut orbit = |state: &[f64], rate: &mut [f64]| {
            let cube = state[0].hypot(state[1]).powi(3);
            rate.copy_from_slice(&[state[2], state[3], -state[0] / cube, -state[1] / cube]);
        };
        for until in [std::f64::consts::TAU, -std::f64::consts::TAU] {
            let end = integrate(&mut orbit, &|_| vec![1.0; 4], start.to_vec(), until, 1e-13)?;
            let apart = end
                .iter()
                .zip(start)
                .fold(0.0, |apart, (x, y)| larger(apart, (x - y).abs()));
            assert!(apart < 1e-10, "{until}: {apart:e}");
        }
        Ok(())
    }

    #[test]
    fn a_rate_that_is_no_number_is_an_error() {
        let mut none = |_: &[f64], rate: &mut [f64]| rate.fill(f64::NAN);
        assert!(integrate(&mut none, &|_| vec![1.0], vec![1.0], 1.0, 1e-9).is_err());
    }
}
