//! Whether there is a discrete flow, and whether time can be turned round.

use dsocs_core::geometry::{FlowTheorem, Triple};

use super::{Report, Subject, largest};
use crate::stability::Bar;

/// The step with `−h`, and the inverse flow, may miss the first node by this part of a leg.
const REVERSED: f64 = 1e-12;

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
    let smallest = |value: fn(&FlowTheorem) -> f64| {
        let values = theorems.iter().map(value);
        Ok(values.fold(
            f64::INFINITY,
            |least, value| if value < least { value } else { least },
        ))
    };
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

/// The step with `−h` and the inverse flow along the motion.
pub fn reversibility<const N: usize>(subject: &Subject<'_, N>, report: &mut Report) {
    let bar = if subject.expected.reversible {
        Bar::AtMost(REVERSED)
    } else {
        Bar::Reported
    };
    let turned = largest(&subject.spread, |triple| {
        Ok(subject.flow.irreversibility(triple)?)
    });
    report.push(
        "distance of the step with −h from the first node, in legs",
        bar,
        turned,
    );
    let back = |triple: &Triple<N>| {
        let found = subject.flow.backward(&triple.last(subject.h))?;
        let norm = |x: [f64; N]| x.iter().fold(0.0_f64, |sum, x| sum.hypot(*x));
        let apart = norm(core::array::from_fn(|i| found.e[i] - triple.e[i]));
        Ok(apart / norm(triple.leg.d).max(norm(triple.last(subject.h).d)))
    };
    let inverse = largest(&subject.spread, back);
    report.push(
        "distance of F⁻¹(F(q0, q1)) from (q0, q1), in legs",
        Bar::AtMost(REVERSED),
        inverse,
    );
    // what a step across a switch forgets, no step back remembers
    report.push(
        "the same where the second difference changes most",
        Bar::Reported,
        largest(&subject.triples, back),
    );
}
