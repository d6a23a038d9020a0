//! Noether's theorem, and the momentum equation.

use dsocs_core::geometry::{asymmetry, constraint_forms, momentum_equation, momentum_map};

use super::{Report, Subject, larger, largest};
use crate::entry::{Kind, Symmetry};
use crate::stability::Bar;

/// The discrete Lagrangian may change by this much along a symmetry, and the momentum equation be missed by it, relative to
/// their terms.
const ROUNDING: f64 = 1e-13;

/// A momentum that is conserved may drift by this much, relative to its largest value.
const DRIFT: f64 = 1e-12;

/// The momentum equation of each declared symmetry: an identity where `L_d` is invariant.
pub fn identity(subject: &Subject<'_>, report: &mut Report) {
    for symmetry in subject.symmetries {
        let equation = largest(&subject.triples, |triple| {
            let [missed, terms] = momentum_equation(&subject.flow, triple, &|q| symmetry.at(q));
            Ok(if missed == 0.0 { 0.0 } else { missed.abs() / terms })
        });
        report.push(
            format!("{}: ΔJ − h⟨Q + f, ξ⟩, relative to the terms", symmetry.name()),
            Bar::AtMost(ROUNDING),
            equation,
        );
    }
}

/// The invariance of `L_d` under each declared symmetry, and what the motion does to its momentum.
pub fn law(subject: &Subject<'_>, report: &mut Report) {
    if subject.symmetries.is_empty() {
        report.push("symmetries that are declared", Bar::Reported, Ok(0.0));
    }
    for symmetry in subject.symmetries {
        let generator = |q: &[f64]| symmetry.at(q);
        let name = symmetry.name();
        let invariance = largest(&subject.triples, |triple| {
            Ok(asymmetry(&subject.flow, triple.leg.any(), &generator))
        });
        report.push(
            format!("{name}: change of L_d, relative to its terms"),
            Bar::AtMost(ROUNDING),
            invariance,
        );
        let free = subject.expected.kind == Kind::Unconstrained || is_allowed(subject, symmetry);
        let bar = if free && !subject.kernel.shape().external_forces {
            Bar::AtMost(DRIFT)
        } else {
            Bar::Reported
        };
        report.push(
            format!("{name}: variation of J along the motion, relative to the largest"),
            bar,
            Ok(drift(subject, symmetry)),
        );
    }
}

/// Whether a symmetry is a virtual displacement along the motion, on which no constraint force does work.
///
/// Where the declaration gives the displacements by fields this is not known.
fn is_allowed(subject: &Subject<'_>, symmetry: &Symmetry) -> bool {
    subject.triples.iter().all(|triple| {
        let forms = constraint_forms(subject.kernel, subject.h, triple);
        let generator = symmetry.at(&triple.leg.q);
        !forms.is_empty()
            && forms.iter().all(|form| {
                let terms = form.iter().zip(&generator).map(|(form, along)| form * along);
                let (sum, size) = terms.fold((0.0, 0.0), |(sum, size), term| {
                    (sum + term, size + f64::abs(term))
                });
                sum.abs() <= ROUNDING * size
            })
    })
}

/// How much the momentum varies along the motion, relative to its largest value.
fn drift(subject: &Subject<'_>, symmetry: &Symmetry) -> f64 {
    let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
    for leg in &subject.legs {
        let momentum = momentum_map(&subject.flow, leg.any(), &|q| symmetry.at(q));
        (least, most) = (least.min(momentum), larger(most, momentum));
    }
    let size = least.abs().max(most.abs());
    if most > least || most.is_nan() {
        (most - least) / size
    } else {
        0.0
    }
}
