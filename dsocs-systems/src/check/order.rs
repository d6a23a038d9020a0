//! The order of the scheme, by a fit of its errors against the Taylor flow.
//!
//! Errors are compared up to the time until which the largest step follows the motion. Beyond, a chaotic
//! motion loses its start within the error of any step, and a fit would measure chaos and not the scheme.

use dsocs_core::geometry::{
    Triple, constraint_force, constraint_multipliers, continuous_multipliers, legendre_plus, multipliers_of,
    roundings, state_displacements,
};
use dsocs_core::{Declaration, Kernel, OwnedPoint, RunError};

use super::motions::{SecondNode, State, less};
use super::rest;
use super::{CheckedMotion, Finding, Measured, Report, larger, motions};
use crate::entry::Kind;
use crate::stability::{Bar, number};

/// The number of steps, each half of the one before.
const HALVINGS: u32 = 6;

/// An error of position below this part of the motion's extent may be rounding, and is left out of the fit.
const PLATEAU: f64 = 1e-11;

/// As `PLATEAU`, for velocities, forces and multipliers, which are quotients of differences of nodes.
const PLATEAU_OF_QUOTIENTS: f64 = 1e-8;

/// The rounding of a force, in roundings of the momentum of a leg over its step.
const ROUNDINGS: f64 = 8.0;

/// An error is also rounding, where it stops falling, if it is below the first number, and more than the
/// second times the error with twice the step. Where a factor that was divided out passes through zero,
/// rounding is divided by it.
const STOPPED_FALLING: [f64; 2] = [1e-6, core::f64::consts::FRAC_1_SQRT_2];

/// Divisors of the step that are tried where a fit misses its bar.
pub const DIVISORS: [u32; 2] = [4, 16];

/// Further divisors, for a step that follows the motion for a small part of the window only; the window is
/// then as long as that part.
const FURTHER_DIVISORS: [u32; 5] = [64, 256, 1024, 4096, 16384];

/// Slopes of finer steps that differ by more show no power.
const SLOPE_SPREAD: f64 = 0.1;

/// One of them has to come this near to the required slope.
const NEAR_SLOPE: f64 = 0.5;

/// A small part of the window is less than one over this number.
const SMALL_PART: usize = 8;

/// Relative changes of the start, in roundings, alternating by component: a start that is as good. The
/// resulting change of the motion is no error of a step.
const START_CHANGES: [f64; 2] = [4.0, 3.0];

/// A change of the motion above this part of its extent means that rounding of the start decides it.
const DECIDED_BY_ROUNDING: f64 = 1e-3;

/// An error up to this many times the change by rounding is rounding.
const ROUNDING_FACTOR: f64 = 10.0;

/// The largest distance of the fitted order from the declared one.
const ORDER_DISTANCE: f64 = 0.1;

/// The distance that is allowed where the motion passes corners. The error of a step across a corner has the
/// order of the others, with a factor between zero and its largest value that depends on where the nodes lie.
/// So errors stay below a multiple of the power and do not follow it, and their fit scatters; an order that
/// is lower by one is still found.
pub const SCATTER: f64 = 0.9;

/// Slopes from error to error that differ by more are those of no power.
const SCATTERS: f64 = 0.5;

/// The loss of order of each quantity of [`Errors`] at the node beside a corner, where the acceleration may
/// jump and, with the corner of a constraint, the force.
pub const CORNER_LOSS: [f64; 4] = [0.0, 1.0, 2.0, 2.0];

/// The tolerance of the continuous motion.
const TOLERANCE: f64 = 1e-15;

/// The largest error of the largest step, relative to the motion's extent, up to which the motion is
/// followed.
const FOLLOWED_ERROR: f64 = 0.02;

/// The number of errors in a fit: the smallest that are above rounding. Larger steps may be too large for a
/// power law.
const FITTED_POINTS: usize = 4;

/// The largest number of steps over which errors are taken: more add nothing to the order, and the finest
/// steps are 32 times as many.
const MOST_STEPS: usize = 20_000;

/// The largest number of nodes at which errors are taken.
const MOST_NODES: usize = 2000;

/// The change of the start from which its growth is measured, relative to the extent.
const START_CHANGE: f64 = 1e-9;

/// A change of the start grows exponentially if it grows by more than the first factor, and in the second
/// half of the window to more than the second times that of the first half; or by more than the third factor,
/// at which it is as large as the motion.
const CHAOTIC_GROWTH: [f64; 3] = [1e3, 30.0, 1e7];

/// The number of halvings of the step that has to follow the motion: the largest one in the fit, if all
/// errors are above rounding.
pub const FOLLOWING_HALVINGS: usize = 2;

/// The quantities that are compared.
const QUANTITIES: [&str; 4] = ["position", "velocity", "force", "multipliers"];

/// Errors by quantity, step and node, each relative to the component's scale.
pub type Errors = [Vec<Vec<f64>>; 4];

/// The order on the system's own motion.
pub fn order(motion: &CheckedMotion<'_>, report: &mut Report) {
    let is_too_long = || motion.followed_until().is_some();
    let of = (motion.h, motion.excuse().is_some());
    with_finer_steps(of, report, &is_too_long, &|parts, report| {
        fit(motion, parts, report);
    });
    let missed = report.findings.iter().any(|finding| !finding.ok());
    // what the run itself has seen of a singularity says more
    let at_rest = || motion.excuse().is_none().then(|| rest::passed(motion)).flatten();
    if missed && let Some(excuse) = at_rest().or_else(|| starts_at_rounding(motion)) {
        for finding in report.findings.iter_mut().filter(|finding| !finding.ok()) {
            finding.excuse = Some(excuse.clone());
        }
    }
}

/// The time up to which the step follows the motion, if it is a small part of the window.
pub fn followed_until(motion: &CheckedMotion<'_>) -> Option<f64> {
    let (times, errors, _) = errors(motion, 1).ok()?;
    let last = followed_nodes(&errors[0][FOLLOWING_HALVINGS]);
    (last * SMALL_PART <= times.len()).then(|| times[last - 1])
}

/// Measures with the step and, where a bar is missed on a motion without jumps, with parts of it: errors fall
/// as a power of the step only where it is short enough. A figure that misses its bar with all parts is
/// reported as first measured. Still smaller parts are tried where the step is too long to follow the motion.
pub fn with_finer_steps(
    (h, is_excused): (f64, bool),
    report: &mut Report,
    is_too_long: &dyn Fn() -> bool,
    measure: &dyn Fn(u32, &mut Report),
) {
    let attempt = |parts: u32| {
        let mut attempt = Report {
            check: report.check,
            findings: Vec::new(),
        };
        measure(parts, &mut attempt);
        attempt
    };
    let mut first = attempt(1);
    let holds = |attempt: &Report| attempt.findings.iter().all(Finding::holds);
    let is_open = is_excused || first.findings.iter().any(|finding| finding.failure.is_some());
    if holds(&first) || is_open {
        report.findings.extend(first.findings);
        return;
    }
    let fitted_from = |mut finer: Report, parts: u32| {
        finer.note(&format!(
            "fitted from h = {:.1e} on: with larger steps the errors do not fall as a power of the step yet",
            h.abs() / f64::from(parts)
        ));
        finer.findings
    };
    for parts in DIVISORS {
        let finer = attempt(parts);
        if holds(&finer) {
            report.findings.extend(fitted_from(finer, parts));
            return;
        }
    }
    // the slopes, and the least distance of each from its bar
    let figures = |attempt: &Report| {
        attempt
            .findings
            .iter()
            .map(|finding| finding.figure)
            .collect::<Vec<f64>>()
    };
    let missed = |finding: &Finding, figure: f64| match finding.bar {
        Bar::AtMost(bar) => figure - bar,
        Bar::AtLeast(bar) => bar - figure,
        Bar::Reported => f64::NEG_INFINITY,
    };
    let (mut before, mut range) = (figures(&first), [f64::INFINITY, f64::NEG_INFINITY]);
    let mut best: Vec<f64> = first
        .findings
        .iter()
        .map(|finding| missed(finding, finding.figure))
        .collect();
    let mut rounding = None;
    for parts in FURTHER_DIVISORS.into_iter().take_while(|_| is_too_long()) {
        let finer = attempt(parts);
        let now = figures(&finer);
        // errors at rounding have no slope, or that of the same steps as before
        let is_rounding = now.len() < first.findings.len() || now == before;
        if holds(&finer) && !is_rounding {
            report.findings.extend(fitted_from(finer, parts));
            return;
        }
        if let Some(slope) = now.first() {
            range = [range[0].min(*slope), range[1].max(*slope)];
        }
        for ((best, finding), figure) in best.iter_mut().zip(&first.findings).zip(&now) {
            *best = best.min(missed(finding, *figure));
        }
        if is_rounding && rounding.is_none() {
            rounding = Some(h.abs() / f64::from(parts));
        }
        if now.is_empty() || now == before {
            break;
        }
        before = now;
    }
    if let Some(rounding) = rounding.filter(|_| range[1] - range[0] > SLOPE_SPREAD) {
        let open = first.findings.iter_mut().zip(&best);
        for (finding, _) in open.filter(|(finding, best)| !finding.holds() && **best < NEAR_SLOPE) {
            finding.excuse = Some(format!(
                "not required here: errors fall as a power of the step where it is short enough, and the motion changes so quickly somewhere that they are rounding before: the step h = {:.1e} \
                 follows it for a small part of the window only, the slopes of finer ones lie between {:.1} and {:.1}, and with h = {rounding:.0e} errors are rounding; to see it required, start \
                 beside the place, as one where a mass nearly vanishes",
                h.abs(),
                range[0],
                range[1],
            ));
        }
    }
    report.findings.extend(first.findings);
}

/// The fit with parts of the motion's step.
fn fit(motion: &CheckedMotion<'_>, parts: u32, report: &mut Report) {
    let measured = errors(motion, parts);
    let declared = motion.expected.order;
    let (times, errors, ended) = match measured {
        Ok(found) => found,
        Err(error) => {
            report.push("slope of the errors of position", Bar::Reported, Err(error));
            return;
        }
    };
    let last = followed_nodes(&errors[0][FOLLOWING_HALVINGS]);
    for (k, (name, errors)) in QUANTITIES.into_iter().zip(&errors).enumerate() {
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
            report_too_few(k, &points, (errors, plateau), report);
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
    }
    if motion.legs.len() > MOST_STEPS + 1 {
        report.note(&format!("errors are compared over the first {MOST_STEPS} steps"));
    }
    if let (Some(ended), Some(reached)) = (ended, times.last()) {
        let reached = number(*reached);
        report.note(&format!(
            "compared up to t = {reached}, since the continuous motion ends: {ended}"
        ));
    }
}

/// Reports that fewer than three errors of a quantity are above rounding.
fn report_too_few(k: usize, points: &[[f64; 2]], (errors, plateau): (&[Vec<f64>], f64), report: &mut Report) {
    if k == 0 && points.is_empty() {
        // constraints may leave no free motion, or every step may follow the motion exactly, as on a
        // parabola
        report.push(
            "errors of position, which are rounding at every step",
            Bar::AtMost(plateau),
            Ok(largest_error(errors)),
        );
        report.note("no order is fitted; a larger step may show one");
    } else if k == 0 {
        let error = "fewer than three errors are above rounding: give a larger step";
        report.push(
            "slope of the errors of position",
            Bar::Reported,
            Err(error.into()),
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
    let corners = motion.corners();
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

/// The reason why no order is required of a motion that the rounding of its start decides, as near an
/// unstable equilibrium: another start within rounding leads as far from the motion as the errors of the
/// steps are.
fn starts_at_rounding(motion: &CheckedMotion<'_>) -> Option<String> {
    let (times, errors, _) = errors(motion, 1).ok()?;
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
        let relative = apart.iter().zip(&extents);
        relative.fold(0.0, |most, (apart, extent)| larger(most, apart.abs() / extent))
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
        number(*t),
        number(times[last - 1])
    ))
}

/// The index from which on errors have stopped falling and are rounding.
fn start_of_rounding(points: &[[f64; 2]]) -> Option<usize> {
    let stops =
        |pair: &[[f64; 2]]| pair[1][1] < STOPPED_FALLING[0] && pair[1][1] > STOPPED_FALLING[1] * pair[0][1];
    Some(points.windows(2).position(stops)? + 1)
}

/// The largest of errors by step and node.
fn largest_error(errors: &[Vec<f64>]) -> f64 {
    errors
        .iter()
        .flatten()
        .fold(0.0, |most, &error| larger(most, error))
}

/// The reason why errors are not compared beyond a time.
fn reason_beyond(motion: &CheckedMotion<'_>, parts: u32, until: f64) -> String {
    let compared_until = format!(
        "errors are compared up to t = {}: beyond, that of h = {} is more than {FOLLOWED_ERROR} of the motion's extent",
        number(until),
        motion.h / f64::from(parts << FOLLOWING_HALVINGS)
    );
    match growth(motion) {
        Ok([growth, late])
            if growth > CHAOTIC_GROWTH[2] || (growth > CHAOTIC_GROWTH[0] && late > CHAOTIC_GROWTH[1]) =>
        {
            format!(
                "{compared_until}; by t = {} a small change of the start has grown {growth:.0e} times: that is chaos, and no failure of the scheme",
                number(motion.until)
            )
        }
        Ok([growth, _]) => format!(
            "{compared_until}; by t = {} a small change of the start has grown {growth:.0e} times",
            number(motion.until)
        ),
        Err(_) => compared_until,
    }
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

/// The number of nodes over which the largest step follows the motion, at least two.
pub fn followed_nodes(errors: &[f64]) -> usize {
    let lost = errors
        .iter()
        .position(|error| error.is_nan() || *error > FOLLOWED_ERROR);
    lost.unwrap_or(errors.len()).max(2).min(errors.len())
}

/// The times, and the errors there of every quantity with every step. The first step is the motion's over
/// `finest`.
pub fn errors(motion: &CheckedMotion<'_>, finest: u32) -> Measured<(Vec<f64>, Errors, Option<RunError>)> {
    let h = motion.h;
    let steps = match motion.followed_until.get() {
        Some(Some(until)) if finest > DIVISORS[1] => steps_to(motion, *until),
        _ => motion.legs.len().saturating_sub(1).clamp(2, MOST_STEPS),
    };
    let part = u32::try_from(steps.div_ceil(MOST_NODES))?;
    let count = steps / part as usize;
    let mut times: Vec<f64> = (1..=count)
        .map(|k| motion.start.t + (k as f64 * f64::from(part)) * h)
        .collect();
    let (exact, ended) = motions::exact_as_far(motion.system, h, &motion.start, &times, TOLERANCE)?;
    // just before the end of a motion, errors need not fall as a power of the step yet
    let count = match &ended {
        Some(_) => exact.len() * 3 / 4,
        None => exact.len(),
    };
    times.truncate(count);
    if let (0, Some(ended)) = (count, &ended) {
        return Err(ended.to_string().into());
    }
    let system = motion.kernel;
    let constrained = motion.expected.kind != Kind::Unconstrained;
    let truth: Vec<[Vec<f64>; 4]> = exact
        .iter()
        .take(count)
        .map(|point| {
            let point = point.any();
            let [mut force, mut multipliers] = [Vec::new(), Vec::new()];
            if constrained {
                force = constraint_force(system, point);
                multipliers = continuous_multipliers(system, point);
            }
            [point.q.to_vec(), point.v.to_vec(), force, multipliers]
        })
        .collect();
    let scales: [Vec<f64>; 4] = core::array::from_fn(|k| scales(k, &truth, &motion.start.q));
    let has_large_numbers = motion.large_numbers.relative_error().is_some();
    let mut errors: Errors = Default::default();
    for halving in 0..HALVINGS {
        let parts = finest << halving;
        let h = h / f64::from(parts);
        let nodes = motions::nodes(
            motion.kernel,
            h,
            (&motion.start, motion.first),
            (part * parts, count),
        )?;
        let mut found: [Vec<f64>; 4] = Default::default();
        for (node, truth) in nodes.iter().zip(&truth) {
            let declaration = Declaration::of(system);
            let values = [
                node.leg.q.clone(),
                declaration.point(h, node.leg.any(), &node.e).any().v.to_vec(),
                if truth[2].is_empty() {
                    Vec::new()
                } else {
                    declaration.force(h, node.leg.any(), &node.e)
                },
                if truth[3].is_empty() {
                    Vec::new()
                } else {
                    constraint_multipliers(system, h, node)
                },
            ];
            // a force is the difference of two momenta over a step
            let momenta = legendre_plus(system, h, node.leg.any());
            // the rounding of the forces adds up to a motion
            let moves = roundings(system, h, node);
            let steps = ((node.leg.t - motion.start.t) / h).abs();
            for (k, (values, truth)) in values.iter().zip(truth).enumerate() {
                if values.is_empty() {
                    continue;
                }
                // a bound that adds all roundings with one sign would leave no error where the time is large:
                // there the fit finds the rounding
                let worst = if has_large_numbers { 0.0 } else { ROUNDINGS };
                let moved = |i: usize| worst * moves.get(i).copied().unwrap_or(0.0);
                let rounding = |i: usize| match k {
                    0 => moved(i) * steps * steps / 2.0,
                    1 => moved(i) * steps / h.abs(),
                    2 => ROUNDINGS * f64::EPSILON * momenta.get(i).map_or(0.0, |momentum| momentum.abs()),
                    _ => 0.0,
                };
                let apart = values.iter().zip(truth).zip(&scales[k]).enumerate();
                let relative = apart.map(|(i, ((value, truth), scale))| {
                    let apart = (value - truth).abs();
                    if apart <= rounding(i) { 0.0 } else { apart / scale }
                });
                found[k].push(relative.fold(0.0, larger));
            }
        }
        zero_rounding((system, h, has_large_numbers), &nodes, &mut found, &scales);
        for (errors, found) in errors.iter_mut().zip(found) {
            errors.push(found);
        }
    }
    Ok((times, errors, ended))
}

/// Sets errors that are rounding to zero: of forces, where positions or times are large, and of multipliers.
fn zero_rounding(
    (system, h, has_large_numbers): (&dyn Kernel, f64, bool),
    nodes: &[Triple],
    found: &mut [Vec<f64>; 4],
    scales: &[Vec<f64>; 4],
) {
    let [.., forces, of_multipliers] = found;
    let mut of_forces = 0.0;
    for node in nodes.iter().filter(|_| has_large_numbers) {
        let momenta = legendre_plus(system, h, node.leg.any());
        for (i, (momentum, scale)) in momenta.iter().zip(&scales[2]).enumerate() {
            let rounding = ROUNDINGS * f64::EPSILON * momentum.abs();
            of_forces = larger(of_forces, rounding_factor(node, h, i) * rounding / scale);
        }
    }
    for error in forces.iter_mut().filter(|error| **error <= of_forces) {
        *error = 0.0;
    }
    let largest = of_multipliers.iter().enumerate();
    if let Some((place, largest)) = largest.max_by(|(_, one), (_, other)| one.total_cmp(other))
        && *largest > PLATEAU_OF_QUOTIENTS
    {
        let rounding = multiplier_rounding(system, h, &nodes[place], &scales[3], has_large_numbers);
        for error in of_multipliers.iter_mut().filter(|error| **error <= rounding) {
            *error = 0.0;
        }
    }
}

/// The number of steps up to a time, at least two.
fn steps_to(motion: &CheckedMotion<'_>, until: f64) -> usize {
    let times = motion.legs.iter().map(|leg| (leg.t - motion.start.t).abs());
    times
        .take_while(|t| *t <= (until - motion.start.t).abs())
        .count()
        .clamp(2, MOST_STEPS)
}

/// The rounding of multipliers at a triple of nodes, in units of their scales: it comes from that of the
/// force, which is that of momenta over a step.
fn multiplier_rounding(
    system: &dyn Kernel,
    h: f64,
    node: &Triple,
    scales: &[f64],
    has_large_numbers: bool,
) -> f64 {
    let momenta = legendre_plus(system, h, node.leg.any());
    let mut all = vec![0.0; scales.len()];
    for (i, momentum) in momenta.iter().enumerate() {
        let mut force = vec![0.0; momenta.len()];
        let known = if has_large_numbers {
            rounding_factor(node, h, i)
        } else {
            1.0
        };
        force[i] = ROUNDINGS * f64::EPSILON * known * momentum.abs();
        let multipliers = multipliers_of(system, h, node, &force);
        for (all, multiplier) in all.iter_mut().zip(multipliers) {
            *all += multiplier.abs();
        }
    }
    let relative = all.iter().zip(scales).map(|(all, scale)| all / scale);
    relative.fold(0.0, larger)
}

/// The factor by which the rounding of a momentum is larger than that of its own digits, where constraints
/// hold positions: that of the position relative to a leg, and of the time relative to a step.
fn rounding_factor(node: &Triple, h: f64, i: usize) -> f64 {
    let component = |x: &[f64]| x.get(i).map_or(0.0, |x| x.abs());
    let (q, d) = (component(&node.leg.q), component(&node.leg.d));
    if d > 0.0 {
        1.0 + q / d + (node.leg.t / h).abs()
    } else {
        1.0
    }
}

/// The scale of each component of a quantity: its largest value, and for positions the largest distance from
/// the start.
fn scales(k: usize, truth: &[[Vec<f64>; 4]], q0: &[f64]) -> Vec<f64> {
    let components = truth.first().map_or(0, |truth| truth[k].len());
    let extent = |i: usize| {
        let from = if k == 0 { q0[i] } else { 0.0 };
        truth
            .iter()
            .map(|truth| (truth[k][i] - from).abs())
            .fold(0.0, larger)
    };
    moving_extents((0..components).map(extent).collect())
}

/// The extents of components; one that stands still has that of the component that moves most.
fn moving_extents(extents: Vec<f64>) -> Vec<f64> {
    let most = extents.iter().fold(0.0, |most, &x| larger(most, x));
    let own = extents.into_iter();
    own.map(|extent| if extent > 1e-3 * most { extent } else { most })
        .collect()
}

/// The last points, in order of decreasing steps, that are above the plateau of rounding; `None` if they are
/// too few for a slope.
pub fn above_plateau(plateau: f64, mut points: Vec<[f64; 2]>) -> Option<Vec<[f64; 2]>> {
    points.retain(|[_, value]| *value > plateau || value.is_nan());
    let last = points.split_off(points.len().saturating_sub(FITTED_POINTS));
    (last.len() > 2).then_some(last)
}

/// Whether points are on no line: the slopes from each to the next differ.
fn scatter(points: &[[f64; 2]]) -> bool {
    let slopes = points.windows(2).map(fitted_slope);
    let [least, most] = slopes.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], slope| {
        [least.min(slope), most.max(slope)]
    });
    most - least > SCATTERS
}

/// The slope of the line through the logarithms of some points.
pub fn fitted_slope(points: &[[f64; 2]]) -> f64 {
    let count = points.len() as f64;
    let logarithm = |k: usize| points.iter().map(move |point| point[k].ln());
    let mean = |k: usize| logarithm(k).sum::<f64>() / count;
    let (x, y) = (mean(0), mean(1));
    let (mut above, mut below) = (0.0, 0.0);
    for (h, error) in logarithm(0).zip(logarithm(1)) {
        above += (h - x) * (error - y);
        below += (h - x).powi(2);
    }
    above / below
}
