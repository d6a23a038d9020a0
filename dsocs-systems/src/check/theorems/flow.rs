//! The conditions for a discrete flow, and its inverse: the step with `−h`.

use dsocs_core::AnyLeg;
use dsocs_core::geometry::{FlowTheorem, Triple, roundings, rows_at_given_nodes};

use crate::check::motion::motions::less;
use crate::check::theorems::equations::LARGEST_RESIDUAL;
use crate::check::{CheckedMotion, Measured, Report, larger, smallest};
use crate::stability::Bar;

/// The largest distance, in legs, between the first node and that of the step with `−h` or of the inverse
/// flow.
const DISTANCE_BACK: f64 = 1e-12;

/// The error of the equations of a step, in units of rounding: each is a sum of some terms.
const ROUNDINGS: f64 = 8.0;

/// Distances from the known solution at which the search for it begins, relative to the second difference.
const SEARCH_DISTANCES: [f64; 4] = [1e-4, 1e-6, 1e-8, 1e-10];

/// A first node that is nearer by this factor is another solution.
const OTHER_SOLUTION: f64 = 1e-3;

/// The conditions of the discrete-flow theorem along the motion.
pub fn regularity(motion: &CheckedMotion<'_>, report: &mut Report) {
    let theorems: Vec<FlowTheorem> = motion
        .triples
        .iter()
        .map(|triple| FlowTheorem::at(motion.kernel, motion.h, triple.leg.any(), &triple.e))
        .collect();
    let count = |lost: fn(&FlowTheorem) -> bool| {
        let lost = theorems.iter().filter(|theorem| lost(theorem)).count();
        Ok(lost as f64)
    };
    let smallest = |value: fn(&FlowTheorem) -> f64| smallest(theorems.iter().map(value));
    report.push(
        format!(
            "of {} triples, those where φ∘β on D_K has no constant rank",
            theorems.len()
        ),
        Bar::AtMost(0.0),
        count(|theorem| !theorem.has_constant_rank() || !theorem.declared),
    );
    if motion.without_derivative > 0 {
        report.note(&format!(
            "{} triples are left out of all that is about single triples: there the equations have a value, but no derivatives, as those of a root have \
             none at its zero",
            motion.without_derivative
        ));
    }
    report.push(
        "triples where D₃ is not injective",
        Bar::AtMost(0.0),
        count(|theorem| !theorem.regularity.grants_forward()),
    );
    report.push(
        "triples where D₁ is not injective",
        Bar::AtMost(0.0),
        count(|theorem| !theorem.regularity.grants_backward()),
    );
    if theorems.is_empty() {
        report.note(
            "no triple is left to be looked at: in every step something rests or jumps, or has no derivative",
        );
        return;
    }
    report.push(
        "smallest singular value of D₃",
        Bar::Reported,
        smallest(|theorem| theorem.regularity.forward),
    );
    report.push(
        "smallest singular value of D₁",
        Bar::Reported,
        smallest(|theorem| theorem.regularity.backward),
    );
}

/// The distance of a first node that was found from the first node of a triple.
#[derive(Clone, Copy)]
struct DistanceFromFirstNode {
    /// The distance, in legs.
    legs: f64,
    /// Whether it is rounding: no larger than the condition of `D₁` allows, with all equations satisfied.
    is_rounding: bool,
}

/// The step with `−h` from each node. A whole run back would measure the motion and not the step: a mode that
/// is damped forward grows backward.
pub fn step_back(motion: &CheckedMotion<'_>, report: &mut Report) {
    let bar = if motion.expected.reversible {
        Bar::AtMost(DISTANCE_BACK)
    } else {
        Bar::Reported
    };
    let turned = |triple: &Triple| {
        let back = motion.flow.with_step(-motion.h)?;
        let d: Vec<f64> = triple.last(motion.h).d.iter().map(|d| -d).collect();
        let leg = AnyLeg {
            d: &d,
            ..triple.leg.any()
        };
        Ok(distance_from_first_node(
            motion,
            triple,
            &back.forward_near(leg, &triple.e)?.e,
        ))
    };
    push(
        report,
        "distance of the step with −h from the first node, in legs",
        bar,
        motion.spread.iter().map(turned),
    );
}

/// The step with `−h` and the inverse flow along the motion.
pub fn reversibility(motion: &CheckedMotion<'_>, report: &mut Report) {
    step_back(motion, report);
    let mut others = 0;
    let mut back = |triple: &Triple| {
        let last = triple.last(motion.h);
        // where two first nodes lead to the pair, a search from a straight line may find neither
        let first = motion.flow.backward(last.any());
        let first = first.map(|found| distance_from_first_node(motion, triple, &found.e));
        let apart = match &first {
            Ok(first) if first.legs <= DISTANCE_BACK || first.is_rounding => return Ok(*first),
            Ok(first) => first.legs,
            Err(_) => f64::INFINITY,
        };
        // where another first node leads to the same pair, the search has to begin near this one: its
        // neighbourhood may be small
        let mut nearby = first;
        for part in SEARCH_DISTANCES {
            let near: Vec<f64> = triple.e.iter().map(|e| e + part * e.abs()).collect();
            let found =
                distance_from_first_node(motion, triple, &motion.flow.backward_near(last.any(), &near)?.e);
            let is_another = found.legs < OTHER_SOLUTION * apart;
            nearby = Ok(found);
            if is_another {
                others += 1;
                break;
            }
        }
        Ok(nearby?)
    };
    let inverse: Vec<Measured<DistanceFromFirstNode>> = motion.spread.iter().map(&mut back).collect();
    // a step across a switch loses information, so no step back needs to find its first node
    let hardest: Vec<Measured<DistanceFromFirstNode>> = motion.triples.iter().map(back).collect();
    push(
        report,
        "distance of F⁻¹(F(q0, q1)) from (q0, q1), in legs",
        Bar::AtMost(DISTANCE_BACK),
        inverse.into_iter(),
    );
    push(
        report,
        "the same where the second difference changes most",
        Bar::Reported,
        hardest.into_iter(),
    );
    if others > 0 {
        report.note(&format!(
            "at {others} of these triples another first node leads to the same second and last one, as where a steep function is followed backward: \
             there F⁻¹ is the inverse nearby"
        ));
    }
}

/// Reports the largest distance, without those that are rounding.
fn push(
    report: &mut Report,
    what: &str,
    bar: Bar,
    distances: impl Iterator<Item = Measured<DistanceFromFirstNode>>,
) {
    let (mut largest, mut rounding, mut count) = (0.0, 0.0, 0);
    for missed in distances {
        match missed {
            Ok(missed) if missed.legs > DISTANCE_BACK && missed.is_rounding => {
                rounding = larger(rounding, missed.legs);
                count += 1;
            }
            Ok(missed) => largest = larger(largest, missed.legs),
            Err(error) => {
                report.push(what, bar, Err(error));
                return;
            }
        }
    }
    report.push(what, bar, Ok(largest));
    if count > 0 && bar != Bar::Reported {
        report.note(&format!(
            "{count} of these triples are left out: there D₁ is so nearly singular that the node found, up to {rounding:.0e} legs away, \
             obeys the equations to rounding, too"
        ));
    }
}

/// The distance of the first node that belongs to the second difference `e` from that of a triple.
fn distance_from_first_node(motion: &CheckedMotion<'_>, triple: &Triple, e: &[f64]) -> DistanceFromFirstNode {
    let norm = |x: &[f64]| x.iter().fold(0.0_f64, |sum, x| sum.hypot(*x));
    let last = triple.last(motion.h).d;
    let apart = norm(&less(e, &triple.e));
    // at rest the legs are zero, and the step back is exact
    let mut legs = match apart {
        0.0 => 0.0,
        apart => apart / norm(&triple.leg.d).max(norm(&last)),
    };
    // where forces balance, the node moves by rounding
    if legs > DISTANCE_BACK {
        let roundings = roundings(motion.kernel, motion.h, triple);
        let mut pairs = e.iter().zip(&triple.e).zip(roundings);
        if pairs.all(|((found, known), rounding)| (found - known).abs() <= ROUNDINGS * rounding) {
            legs = 0.0;
        }
    }
    let d = less(&last, e);
    DistanceFromFirstNode {
        legs,
        is_rounding: legs > DISTANCE_BACK
            && motion.kernel.shape().rotations.is_empty()
            && legs <= effect_of_rounding(motion, triple)
            && satisfies_equations(motion, triple, &d),
    }
}

/// The effect of rounding in the equations on the first node, in legs.
fn effect_of_rounding(motion: &CheckedMotion<'_>, triple: &Triple) -> f64 {
    let at = FlowTheorem::at(motion.kernel, motion.h, triple.leg.any(), &triple.e).regularity;
    ROUNDINGS * f64::EPSILON * at.largest_backward / at.backward
}

/// Whether a triple with another first increment `d` satisfies the equations to rounding: those of the step
/// and, at the time before, the constraints of the first pair of nodes.
///
/// The condition of `D₁` alone would also excuse errors in directions in which it is not singular.
fn satisfies_equations(motion: &CheckedMotion<'_>, triple: &Triple, d: &[f64]) -> bool {
    let AnyLeg { t, q: q1, .. } = triple.leg.any();
    let after = triple.last(motion.h).d;
    let node =
        |parts: f64, by: &[f64]| -> Vec<f64> { q1.iter().zip(by).map(|(q, by)| q + parts * by).collect() };
    let [before, first, last] = [&node(-2.0, d), &node(-1.0, d), &node(1.0, &after)];
    let holds = |rows: &[[f64; 2]]| {
        let mut rows = rows.iter();
        rows.all(|[row, explained]| row.abs() <= LARGEST_RESIDUAL * explained)
    };
    let [holonomic, nonholonomic, _] = motion.constraints();
    let pair = rows_at_given_nodes(motion.kernel, t - motion.h, motion.h, [before, first, q1]);
    holds(&rows_at_given_nodes(
        motion.kernel,
        t,
        motion.h,
        [first, q1, last],
    )) && holds(&pair[..holonomic + nonholonomic])
}
