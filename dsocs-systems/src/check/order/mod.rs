//! The order of the scheme, by a fit of its errors against the Taylor flow.
//!
//! Errors are compared up to the time until which the largest step follows the motion. Beyond, a chaotic
//! motion loses its start within the error of any step, and a fit would measure chaos and not the scheme.

pub mod between_steps;
mod errors;
mod finer_steps;
mod slope;
mod start;

use crate::check::motion::motions::SecondNode;
use crate::check::reasons::rest;
use crate::check::{CheckedMotion, Report, larger};
use crate::stability::{Bar, written_time};

use errors::{HALVINGS, MOST_STEPS, PLATEAU_OF_QUOTIENTS};
use slope::{FITTED_POINTS, scatter, start_of_rounding};
use start::{reason_beyond, starts_at_rounding};

pub use errors::{Compared, FOLLOWING_HALVINGS, Shared, errors, followed_nodes, followed_until};
pub use finer_steps::{DIVISORS, with_finer_steps};
pub use slope::{above_plateau, fitted_slope};

/// An error of position below this part of the motion's extent may be rounding, and is left out of the fit.
const PLATEAU: f64 = 1e-11;

/// The largest distance of the fitted order from the declared one.
const ORDER_DISTANCE: f64 = 0.1;

/// The distance that is allowed where the motion passes corners. The error of a step across a corner has the
/// order of the others, with a factor between zero and its largest value that depends on where the nodes lie.
/// So errors stay below a multiple of the power and do not follow it, and their fit scatters; an order that
/// is lower by one is still found.
pub const SCATTER: f64 = 0.9;

/// The loss of order of each quantity of [`errors::Errors`] at the node beside a corner, where the acceleration may
/// jump and, with the corner of a constraint, the force.
pub const CORNER_LOSS: [f64; 4] = [0.0, 1.0, 2.0, 2.0];

/// The quantities that are compared.
const QUANTITIES: [&str; 4] = ["position", "velocity", "force", "multipliers"];

/// The order on the system's own motion.
pub fn order(motion: &CheckedMotion<'_>, report: &mut Report) {
    let is_too_long = || motion.followed_until().is_some();
    let of = (motion.h, motion.excuse().is_some());
    with_finer_steps(of, report, &is_too_long, &|parts, report| {
        fit(motion, parts, report);
    });
    let missed = report.findings.iter().any(|finding| !finding.ok());
    // a singularity that the run itself has detected is the more precise reason
    let at_rest = || motion.excuse().is_none().then(|| rest::passed(motion)).flatten();
    if missed && let Some(excuse) = at_rest().or_else(|| starts_at_rounding(motion)) {
        for finding in report.findings.iter_mut().filter(|finding| !finding.ok()) {
            finding.excuse = Some(excuse.clone());
        }
    }
}

/// The fit with parts of the motion's step.
fn fit(motion: &CheckedMotion<'_>, parts: u32, report: &mut Report) {
    let measured = errors(motion, parts);
    let declared = motion.expected.order;
    let compared = match measured {
        Ok(compared) => compared,
        Err(error) => {
            report.push("slope of the errors of position", Bar::Reported, Err(error));
            return;
        }
    };
    let (times, errors, ended) = &*compared;
    let last = followed_nodes(&errors[0][FOLLOWING_HALVINGS]);
    for (k, (name, errors)) in QUANTITIES.into_iter().zip(errors).enumerate() {
        if errors[0].is_empty() {
            continue;
        }
        let plateau = if k == 0 { PLATEAU } else { PLATEAU_OF_QUOTIENTS };
        let mut points: Vec<[f64; 2]> = (0..HALVINGS)
            .zip(errors)
            .map(|(halving, errors)| {
                let h = (motion.h / f64::from(parts << halving)).abs();
                [
                    h,
                    errors[..last]
                        .iter()
                        .fold(0.0, |most, &error| larger(most, error)),
                ]
            })
            .filter(|[_, error]| *error > plateau || error.is_nan())
            .collect();
        if let Some(stop) = start_of_rounding(&points) {
            report.note(&format!(
                "the errors of {name} stop falling at h = {:.1e}, {:.0e} of the largest value: rounding",
                points[stop][0], points[stop][1]
            ));
            points.truncate(stop);
        }
        if points.len() < 3 {
            let compared = errors.iter().flat_map(|errors| &errors[..last]);
            let largest = compared.fold(0.0, |most, &error| larger(most, error));
            let until = (last < times.len() || ends_before(motion, times)).then(|| times[last - 1]);
            report_too_few(k, &points, (largest, plateau), until, report);
            continue;
        }
        let points = &points[points.len().saturating_sub(FITTED_POINTS)..];
        let slope = fitted_slope(points);
        let [[first, _], .., [least, _]] = points else {
            continue;
        };
        let by_first_order = motion.first == SecondNode::Paper;
        let what = format!("slope of the errors of {name}, h = {first:.1e} to {least:.1e}");
        if k == 0 {
            report.push(what, Bar::Reported, Ok(slope));
            if by_first_order {
                report.note("the paper's start has an error of order 1, which lowers the order of the motion as h goes to 0. At these steps it may be too small to show in \
                     the slope; no order is required");
                continue;
            }
            let distance = (slope - declared).abs();
            // errors that fall faster than they have to, and follow no power
            let allowed = if slope > declared && scatter(points) {
                f64::INFINITY
            } else {
                SCATTER
            };
            report.push(
                format!("distance of that from {declared}"),
                Bar::AtMost(ORDER_DISTANCE),
                Ok(distance),
            );
            excuse(motion, distance, allowed, report);
        } else {
            let bar = if by_first_order {
                Bar::Reported
            } else {
                Bar::AtLeast(declared - ORDER_DISTANCE)
            };
            report.push(what, bar, Ok(slope));
            excuse(motion, declared - slope, SCATTER + CORNER_LOSS[k], report);
        }
    }
    if last < times.len() {
        report.note(&reason_beyond(motion, parts, times[last - 1]));
    } else if ended.is_none() && ends_before(motion, times) {
        report.note(&reason_beyond(motion, 1, times[last - 1]));
    }
    if motion.legs.len() > MOST_STEPS + 1 {
        report.note(&format!("errors are compared over the first {MOST_STEPS} steps"));
    }
    if let (Some(ended), Some(reached)) = (ended, times.last()) {
        let reached = written_time(*reached);
        report.note(&format!(
            "compared up to t = {reached}, since the continuous motion ends: {ended}"
        ));
    }
}

/// Whether errors are compared over less than the window, because larger steps do not follow the motion.
fn ends_before(motion: &CheckedMotion<'_>, times: &[f64]) -> bool {
    let left = times.last().map_or(0.0, |last| (motion.until - last).abs());
    motion.legs.len() <= MOST_STEPS + 1 && left > 2.0 * motion.h.abs()
}

/// Fewer than three errors are above rounding, too few for a slope.
#[derive(thiserror::Error)]
#[error("fewer than three errors are above rounding")]
pub struct FewErrors;

dsocs_core::debug_is_message!(FewErrors);

/// Reports that fewer than three errors of a quantity are above rounding; `until` is the time up to which errors are compared, if the window is
/// longer.
fn report_too_few(
    k: usize,
    points: &[[f64; 2]],
    (largest, plateau): (f64, f64),
    until: Option<f64>,
    report: &mut Report,
) {
    if k == 0 && points.is_empty() {
        // constraints may leave no free motion, or every step may follow the motion exactly, as on a
        // parabola
        let until = until.map_or(String::new(), |until| {
            format!(" up to t = {}", written_time(until))
        });
        report.push(
            format!("errors of position{until}, which are rounding at every step"),
            Bar::AtMost(plateau),
            Ok(largest),
        );
        report.note("no order is fitted; a larger step may show one");
    } else if k == 0 {
        report.push(
            "slope of the errors of position",
            Bar::Reported,
            Err(FewErrors.into()),
        );
    } else {
        report.note(&format!(
            "the errors of {} are at rounding: no order is fitted",
            QUANTITIES[k]
        ));
    }
}

/// Excuses the last figure, an order that misses its bar by `distance`, if the motion passes corners.
pub fn excuse(motion: &CheckedMotion<'_>, distance: f64, allowed: f64, report: &mut Report) {
    let Some(last) = report.findings.last_mut().filter(|last| !last.holds()) else {
        return;
    };
    // a jump, or a root at its zero, lowers the order more, and is the reason
    let corners = if motion.excuse().is_some() {
        0
    } else {
        motion.corners()
    };
    if corners > 0 && distance < allowed {
        let what = if allowed > SCATTER && allowed.is_finite() {
            "at a node beside it, where the acceleration jumps and, with the corner of a constraint, the force, the error is of a lower order".to_owned()
        } else {
            format!(
                "errors stay of the order of h^{}, by a factor that depends on where the nodes lie, so that a fit of the order scatters",
                motion.expected.order
            )
        };
        let passed = match corners {
            1 => "a corner".to_owned(),
            _ => format!("{corners} corners"),
        };
        last.excuse = Some(format!(
            "not required here: the theorem is about functions that are smooth along the motion, and it passes {passed}, as of `abs`, `max`, a \
             comparison or samples: {what}; to see it required, end before (`--until`), or declare a smooth function in the place of the corner"
        ));
    }
}
