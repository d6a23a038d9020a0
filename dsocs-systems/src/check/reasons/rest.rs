//! Motions that pass through rest where their law depends on the direction of the velocity.

use crate::check::motion::motions::{State, expansion};
use crate::check::reasons::beginning::size;
use crate::check::{CheckedMotion, larger};
use crate::stability::written_time;

/// A leg below this part of the longest is that of a motion near rest.
const NEAR_REST: f64 = 0.1;

/// The speeds beside rest at which accelerations are compared, relative to the largest.
const SPEEDS: [f64; 2] = [1e-3, 1e-5];

/// A difference that does not fall below this part of itself with the speed is one at rest.
const STAYS_AT_REST: f64 = 0.5;

/// A difference below this part of the accelerations is none.
const NO_DIFFERENCE: f64 = 1e-3;

/// The reason why no order is required of a motion that passes through rest, where another direction of the
/// velocity, however small it is, gives another acceleration: the law has no value at rest itself.
pub fn passed(motion: &CheckedMotion<'_>) -> Option<String> {
    let legs = &motion.legs;
    let longest = legs.iter().fold(0.0, |most, leg| larger(most, size(&leg.d)));
    let slowest = legs.windows(2).filter(|pair| {
        // the velocity turns back, or nearly vanishes
        let along: f64 = pair[0].d.iter().zip(&pair[1].d).map(|(x, y)| x * y).sum();
        let least = size(&pair[0].d).min(size(&pair[1].d));
        least < NEAR_REST * longest && along <= 0.0
    });
    let leg = &slowest.into_iter().next()?[1];
    let fastest = longest / motion.h.abs();
    let v = |speed: f64, turned: Option<usize>| -> Vec<f64> {
        let length = size(&leg.d);
        let mut v: Vec<f64> = leg.d.iter().map(|d| d / length).collect();
        if let Some(i) = turned {
            v[i] += 1.0;
        }
        v.iter().map(|v| speed * fastest * v).collect()
    };
    let acceleration = |v: Vec<f64>| -> Option<Vec<f64>> {
        let state = State {
            t: leg.t,
            q: leg.q.clone(),
            v,
            near: None,
            expansion: None,
        };
        let series = expansion(motion.system, &state).ok()?;
        Some(series.coefficients.get(2)?.clone())
    };
    let apart = |speed: f64, i: usize| -> Option<[f64; 2]> {
        let (own, other) = (acceleration(v(speed, None))?, acceleration(v(speed, Some(i)))?);
        let apart = own
            .iter()
            .zip(&other)
            .fold(0.0, |most, (x, y)| larger(most, (x - y).abs()));
        Some([apart, larger(size(&own), size(&other))])
    };
    let depends = |i: usize| {
        let [Some([first, _]), Some([nearer, of])] = SPEEDS.map(|speed| apart(speed, i)) else {
            return false;
        };
        nearer > STAYS_AT_REST * first && nearer > NO_DIFFERENCE * of
    };
    (0..leg.d.len()).any(depends).then(|| {
        format!(
            "not required here: the theorem is about functions that are smooth along the motion, and about t = {} it passes through rest, where the acceleration depends on the direction of \
             the velocity however slow it is, so that the law has no value at rest itself; to see it required, end before (`--until`)",
            written_time(leg.t)
        )
    })
}
