//! Whether there is a discrete flow, and whether time can be turned round.

use dsocs_core::AnyLeg;
use dsocs_core::geometry::{FlowTheorem, Triple, roundings, rows_of_written};

use super::equations::WRITTEN;
use super::probe::less;
use super::{Measured, Report, Subject, larger, smallest};
use crate::stability::Bar;

/// The step with `−h`, and the inverse flow, may miss the first node by this part of a leg.
const REVERSED: f64 = 1e-12;

/// So many units of rounding are in the equations of a step, of which each is a sum of some terms.
const ROUNDINGS: f64 = 8.0;

/// How far from a first node its neighbourhood is looked at, relative to the second difference.
const NEARBY: [f64; 4] = [1e-4, 1e-6, 1e-8, 1e-10];

/// A first node that is so much nearer is another one.
const NEW: f64 = 1e-3;

/// The conditions of the discrete-flow theorem along the motion.
pub fn regularity(subject: &Subject<'_>, report: &mut Report) {
    let theorems: Vec<FlowTheorem> = subject
        .triples
        .iter()
        .map(|triple| FlowTheorem::at(subject.kernel, subject.h, triple.leg.any(), &triple.e))
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
        report.note("no triple is left to be looked at: in every step something rests or jumps");
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

/// How far a first node that was found is from the first node of a triple.
#[derive(Clone, Copy)]
struct Missed {
    /// In legs.
    legs: f64,
    /// Whether that is rounding: it may be so far, by the condition of `D₁`, and all equations hold there, too.
    is_rounding: bool,
}

/// The step with `−h` from each node. A run back as a whole would tell of the motion and not of the step: what is damped on the way there grows on the way back.
pub fn step_back(subject: &Subject<'_>, report: &mut Report) {
    let bar = if subject.expected.reversible {
        Bar::AtMost(REVERSED)
    } else {
        Bar::Reported
    };
    let turned = |triple: &Triple| {
        let back = subject.flow.with_step(-subject.h)?;
        let d: Vec<f64> = triple.last(subject.h).d.iter().map(|d| -d).collect();
        let leg = AnyLeg {
            d: &d,
            ..triple.leg.any()
        };
        Ok(missed(subject, triple, &back.forward_near(leg, &triple.e)?.e))
    };
    push(
        report,
        "distance of the step with −h from the first node, in legs",
        bar,
        subject.spread.iter().map(turned),
    );
}

/// The step with `−h` and the inverse flow along the motion.
pub fn reversibility(subject: &Subject<'_>, report: &mut Report) {
    step_back(subject, report);
    let mut others = 0;
    let mut back = |triple: &Triple| {
        let last = triple.last(subject.h);
        // where two first nodes lead to the pair, a search from a straight line may find neither
        let first = subject.flow.backward(last.any());
        let first = first.map(|found| missed(subject, triple, &found.e));
        let apart = match &first {
            Ok(first) if first.legs <= REVERSED || first.is_rounding => return Ok(*first),
            Ok(first) => first.legs,
            Err(_) => f64::INFINITY,
        };
        // where another first node leads to the same pair, this one has to be found from nearby, in a neighbourhood that may be small
        let mut nearby = first;
        for part in NEARBY {
            let near: Vec<f64> = triple.e.iter().map(|e| e + part * e.abs()).collect();
            let found = missed(subject, triple, &subject.flow.backward_near(last.any(), &near)?.e);
            let is_another = found.legs < NEW * apart;
            nearby = Ok(found);
            if is_another {
                others += 1;
                break;
            }
        }
        Ok(nearby?)
    };
    let inverse: Vec<Measured<Missed>> = subject.spread.iter().map(&mut back).collect();
    // what a step across a switch forgets, no step back remembers
    let hardest: Vec<Measured<Missed>> = subject.triples.iter().map(back).collect();
    push(
        report,
        "distance of F⁻¹(F(q0, q1)) from (q0, q1), in legs",
        Bar::AtMost(REVERSED),
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

/// Takes in the largest distance, but for those that are rounding.
fn push(report: &mut Report, what: &str, bar: Bar, distances: impl Iterator<Item = Measured<Missed>>) {
    let (mut largest, mut rounding, mut count) = (0.0, 0.0, 0);
    for missed in distances {
        match missed {
            Ok(missed) if missed.legs > REVERSED && missed.is_rounding => {
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

/// How far the first node that belongs to a second difference is from that of a triple.
fn missed(subject: &Subject<'_>, triple: &Triple, e: &[f64]) -> Missed {
    let norm = |x: &[f64]| x.iter().fold(0.0_f64, |sum, x| sum.hypot(*x));
    let last = triple.last(subject.h).d;
    let apart = norm(&less(e, &triple.e));
    // what rests has no legs, and steps back to itself exactly
    let mut legs = match apart {
        0.0 => 0.0,
        apart => apart / norm(&triple.leg.d).max(norm(&last)),
    };
    // and where forces balance it is rounding that moves it
    if legs > REVERSED {
        let roundings = roundings(subject.kernel, subject.h, triple);
        let mut pairs = e.iter().zip(&triple.e).zip(roundings);
        if pairs.all(|((found, known), rounding)| (found - known).abs() <= ROUNDINGS * rounding) {
            legs = 0.0;
        }
    }
    let d = less(&last, e);
    Missed {
        legs,
        is_rounding: legs > REVERSED
            && subject.kernel.shape().rotations.is_empty()
            && legs <= magnified(subject, triple)
            && obeys(subject, triple, &d),
    }
}

/// How far rounding in the equations may move the first node, in legs.
fn magnified(subject: &Subject<'_>, triple: &Triple) -> f64 {
    let at = FlowTheorem::at(subject.kernel, subject.h, triple.leg.any(), &triple.e).regularity;
    ROUNDINGS * f64::EPSILON * at.largest_backward / at.backward
}

/// Whether a triple with another first increment obeys the equations to rounding: those of the step and, by the step before, the
/// constraints of the first pair of nodes.
///
/// The condition of `D₁` alone would let pass, in the directions in which it is not singular, what is no rounding there.
fn obeys(subject: &Subject<'_>, triple: &Triple, d: &[f64]) -> bool {
    let AnyLeg { t, q: q1, .. } = triple.leg.any();
    let after = triple.last(subject.h).d;
    let node =
        |parts: f64, by: &[f64]| -> Vec<f64> { q1.iter().zip(by).map(|(q, by)| q + parts * by).collect() };
    let [before, first, last] = [&node(-2.0, d), &node(-1.0, d), &node(1.0, &after)];
    let holds = |rows: &[[f64; 2]]| {
        let mut rows = rows.iter();
        rows.all(|[row, explained]| row.abs() <= WRITTEN * explained)
    };
    let [holonomic, nonholonomic, _] = subject.constraints();
    let pair = rows_of_written(subject.kernel, t - subject.h, subject.h, [before, first, q1]);
    holds(&rows_of_written(subject.kernel, t, subject.h, [first, q1, last]))
        && holds(&pair[..holonomic + nonholonomic])
}
