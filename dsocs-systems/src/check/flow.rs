//! Whether there is a discrete flow, and whether time can be turned round.

use dsocs_core::geometry::{FlowTheorem, Triple};

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
pub fn regularity<const N: usize>(subject: &Subject<'_, N>, report: &mut Report) {
    let theorems: Vec<FlowTheorem> = subject
        .triples
        .iter()
        .map(|triple| FlowTheorem::at(subject.system, subject.h, &triple.leg, &triple.e))
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

/// How far a first node that was found is from the first node of a triple: in legs, and relative to what may be missed there.
struct Missed {
    legs: f64,
    relative: f64,
}

/// The step with `−h` and the inverse flow along the motion.
pub fn reversibility<const N: usize>(subject: &Subject<'_, N>, report: &mut Report) {
    let bar = if subject.expected.reversible {
        Bar::AtMost(REVERSED)
    } else {
        Bar::Reported
    };
    let turned = |triple: &Triple<N>| Ok(allowed(subject, triple, subject.flow.irreversibility(triple)?));
    push(
        report,
        "distance of the step with −h from the first node, in legs",
        bar,
        subject.spread.iter().map(turned),
    );
    let mut others = 0;
    let mut back = |triple: &Triple<N>| {
        let last = triple.last(subject.h);
        let mut apart = distance(subject, triple, &subject.flow.backward(&last)?.e);
        if allowed(subject, triple, apart).relative > REVERSED {
            // where another first node leads to the same pair, this one has to be found from nearby, in a neighbourhood that may be small
            let mut nearby = apart;
            for part in NEARBY {
                let near = triple.e.map(|e| e + part * e.abs());
                nearby = distance(subject, triple, &subject.flow.backward_near(&last, &near)?.e);
                if nearby < NEW * apart {
                    others += 1;
                    break;
                }
            }
            apart = nearby;
        }
        Ok(allowed(subject, triple, apart))
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

/// Takes in the largest distance. What it may be where rounding moves the first node by more than [`REVERSED`] is told.
fn push(report: &mut Report, what: &str, bar: Bar, distances: impl Iterator<Item = Measured<Missed>>) {
    let (mut legs, mut relative) = (0.0, 0.0);
    for missed in distances {
        match missed {
            Ok(missed) => {
                legs = larger(legs, missed.legs);
                relative = larger(relative, missed.relative);
            }
            Err(error) => {
                report.push(what, bar, Err(error));
                return;
            }
        }
    }
    let is_rounding = legs > REVERSED && relative <= REVERSED;
    report.push(what, bar, Ok(if is_rounding { relative } else { legs }));
    if is_rounding && bar != Bar::Reported {
        report.note(&format!(
            "the figure is less than the distance, {legs:.0e}, where D₁ is so nearly singular that rounding alone moves the first node by more than {REVERSED:e} legs: \
             there the distance is divided by how many times more that is"
        ));
    }
}

/// The distance of a second difference from that of a triple, in legs.
fn distance<const N: usize>(subject: &Subject<'_, N>, triple: &Triple<N>, e: &[f64; N]) -> f64 {
    let norm = |x: [f64; N]| x.iter().fold(0.0_f64, |sum, x| sum.hypot(*x));
    let apart = norm(core::array::from_fn(|i| e[i] - triple.e[i]));
    apart / norm(triple.leg.d).max(norm(triple.last(subject.h).d))
}

/// A distance with what rounding makes of it: the equations are known to some units of rounding, and the first node to these times the condition of
/// `D₁`.
fn allowed<const N: usize>(subject: &Subject<'_, N>, triple: &Triple<N>, legs: f64) -> Missed {
    let at = FlowTheorem::at(subject.system, subject.h, &triple.leg, &triple.e).regularity;
    let rounding = ROUNDINGS * f64::EPSILON * at.largest_backward / at.backward;
    let more = if rounding.is_finite() {
        (rounding / REVERSED).max(1.0)
    } else {
        1.0
    };
    Missed {
        legs,
        relative: legs / more,
    }
}
