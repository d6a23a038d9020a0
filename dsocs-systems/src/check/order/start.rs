//! The growth of a small change of the start: chaos, and starts that are known to rounding only.

use dsocs_core::OwnedPoint;
use dsocs_core::geometry::state_displacements;

use super::errors::{FOLLOWED_ERROR, FOLLOWING_HALVINGS, TOLERANCE, errors, followed_nodes, moving_extents};
use crate::check::motion::motions::{self, State, less};
use crate::check::{CheckedMotion, Measured, larger};
use crate::stability::written_time;
/// Relative changes of the start, in roundings, alternating by component: a start that is as good. The
/// resulting change of the motion is no error of a step.
const START_CHANGES: [f64; 2] = [4.0, 3.0];

/// A change of the motion above this part of its extent means that rounding of the start decides it.
const DECIDED_BY_ROUNDING: f64 = 1e-3;

/// An error up to this many times the change by rounding is rounding.
const ROUNDING_FACTOR: f64 = 10.0;

/// The change of the start from which its growth is measured, relative to the extent.
const START_CHANGE: f64 = 1e-9;

/// A change of the start grows exponentially if it grows by more than the first factor, and in the second
/// half of the window to more than the second times that of the first half; or by more than the third factor,
/// at which it is as large as the motion.
const CHAOTIC_GROWTH: [f64; 3] = [1e3, 30.0, 1e7];

/// The reason why no order is required of a motion that the rounding of its start decides, as near an
/// unstable equilibrium: another start within rounding leads as far from the motion as the errors of the
/// steps are.
pub fn starts_at_rounding(motion: &CheckedMotion<'_>) -> Option<String> {
    let compared = errors(motion, 1).ok()?;
    let (times, errors, _) = &*compared;
    let last = followed_nodes(&errors[0][FOLLOWING_HALVINGS]);
    let finest = errors[0].last()?[..last]
        .iter()
        .fold(0.0, |most, &error| larger(most, error));
    let State { t, q, v, .. } = &motion.start;
    let moved = |x: &[f64]| -> Vec<f64> {
        let parts = x.iter().zip(START_CHANGES.into_iter().cycle());
        parts.map(|(x, by)| x * (1.0 + by * f64::EPSILON)).collect()
    };
    let beside = State {
        q: moved(q),
        v: moved(v),
        ..motion.start.clone()
    };
    let times = &times[..last];
    let exact = |start| motions::exact(motion.system, motion.h, start, times, TOLERANCE);
    let (here, beside) = (exact(&motion.start).ok()?, exact(&beside).ok()?);
    let extent = |i: usize| {
        here.iter()
            .fold(0.0, |most, at| larger(most, (at.any().q[i] - q[i]).abs()))
    };
    let extents: Vec<f64> = (0..q.len()).map(extent).collect();
    let apart = here.iter().zip(&beside).map(|(here, beside)| {
        let apart = less(here.any().q, beside.any().q);
        let relative = apart.iter().zip(&extents).filter(|(apart, _)| **apart != 0.0);
        // a coordinate that does not move has no extent: any difference counts as its whole extent
        let part = |(apart, extent): (&f64, &f64)| match extent {
            0.0 => 1.0,
            extent => apart.abs() / extent,
        };
        relative.map(part).fold(0.0, larger)
    });
    let apart = apart.fold(0.0, larger);
    // a small change is rounding of a step that is too short, unless dependent constraints enlarge it
    let dependent = motion.dependent.as_ref();
    if finest > ROUNDING_FACTOR * apart || (apart < DECIDED_BY_ROUNDING && dependent.is_none()) {
        return None;
    }
    if let Some(dependent) = dependent {
        return Some(dependent.reason());
    }
    Some(format!(
        "not required here: the theorem is about the motion from a start, and this one is known to rounding only: a start that differs from t = {} on by its last digits leads to a \
             motion that is {apart:.0e} of its extent away by t = {}, as those of other steps are: so it is beside an unstable equilibrium; to see it required, start a little beside it",
        written_time(*t),
        written_time(times[last - 1])
    ))
}

/// The largest growth of a small change of the start over the window; and that in its second half relative to
/// its first.
fn growth(motion: &CheckedMotion<'_>) -> Measured<[f64; 2]> {
    let State {
        t,
        q: q0,
        v: v0,
        near,
        ..
    } = &motion.start;
    let t = *t;
    let times = |k: u32| t + (motion.until - t) * f64::from(k) / 200.0;
    let times: Vec<f64> = (1..=200).map(times).collect();
    let exact = motions::exact(motion.system, motion.h, &motion.start, &times, TOLERANCE)?;
    // positions in units of their extents, velocities in units of the largest speeds, whatever the units of
    // the declaration
    let sizes = |of: &dyn Fn(usize) -> f64| -> Vec<f64> {
        let own: Vec<f64> = (0..q0.len()).map(of).collect();
        moving_extents(own)
    };
    let most_of = |of: &dyn Fn(&OwnedPoint<f64>) -> f64| exact.iter().map(of).fold(0.0, larger);
    let extents = sizes(&|i| most_of(&|point| (point.any().q[i] - q0[i]).abs()));
    let speeds = sizes(&|i| most_of(&|point| point.any().v[i].abs()));
    let size = |x: &[f64], units: &[f64]| {
        let parts = x.iter().zip(units).filter(|(x, _)| **x != 0.0);
        parts.fold(0.0, |most, (x, unit)| larger(most, x.abs() / unit))
    };
    let mut most = [0.0; 2];
    for displacement in state_displacements(motion.kernel, t, q0, v0) {
        let own = larger(
            size(&displacement.first, &extents),
            size(&displacement.second, &speeds),
        );
        let moved = |x: &[f64], by: &[f64]| -> Vec<f64> {
            x.iter()
                .zip(by)
                .map(|(x, by)| x + START_CHANGE / own * by)
                .collect()
        };
        let start = State {
            t,
            q: moved(q0, &displacement.first),
            v: moved(v0, &displacement.second),
            near: near.clone(),
            expansion: None,
        };
        let Ok(other) = motions::exact(motion.system, motion.h, &start, &times, TOLERANCE) else {
            continue;
        };
        for (k, (point, other)) in exact.iter().zip(&other).enumerate() {
            let apart = size(&less(point.any().q, other.any().q), &extents);
            let half = usize::from(2 * k >= exact.len());
            most[half] = larger(most[half], apart / START_CHANGE);
        }
    }
    Ok([larger(most[0], most[1]), most[1] / most[0]])
}

/// The reason why errors are not compared beyond a time.
pub fn reason_beyond(motion: &CheckedMotion<'_>, parts: u32, until: f64) -> String {
    let compared_until = format!(
        "errors are compared up to t = {}: beyond, that of h = {} is more than {FOLLOWED_ERROR} of the motion's extent",
        written_time(until),
        motion.h / f64::from(parts << FOLLOWING_HALVINGS)
    );
    match growth(motion) {
        Ok([growth, late])
            if growth > CHAOTIC_GROWTH[2] || (growth > CHAOTIC_GROWTH[0] && late > CHAOTIC_GROWTH[1]) =>
        {
            format!(
                "{compared_until}; by t = {} a small change of the start has grown {growth:.0e} times: that is chaos, and no failure of the scheme",
                written_time(motion.until)
            )
        }
        Ok([growth, _]) => format!(
            "{compared_until}; by t = {} a small change of the start has grown {growth:.0e} times",
            written_time(motion.until)
        ),
        Err(_) => compared_until,
    }
}
