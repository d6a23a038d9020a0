//! Noether's theorem, and the momentum equation.

use dsocs_core::Kernel;
use dsocs_core::geometry::{asymmetry, constraint_forms, momentum_equation, momentum_map, momentum_plus};

use crate::check::{CheckedMotion, Report, larger, largest};
use crate::entry::{Kind, Symmetry};
use crate::stability::Bar;

/// The largest change of the discrete Lagrangian along a symmetry, and the largest defect of the momentum
/// equation, relative to their terms.
pub const LARGEST_CHANGE: f64 = 1e-13;

/// The largest drift of a conserved momentum, relative to its terms.
pub const LARGEST_DRIFT: f64 = 1e-12;

/// The momentum equation of each declared symmetry: an identity where `L_d` is invariant.
pub fn identity(motion: &CheckedMotion<'_>, report: &mut Report) {
    for symmetry in motion.symmetries {
        let equation = largest(&motion.triples, |triple| {
            let [missed, terms] = momentum_equation(&motion.flow, triple, &|q| symmetry.at(q));
            Ok(if missed == 0.0 { 0.0 } else { missed.abs() / terms })
        });
        report.push(
            format!("{}: ΔJ − h⟨Q + f, ξ⟩, relative to the terms", symmetry.name()),
            Bar::AtMost(LARGEST_CHANGE),
            equation,
        );
    }
}

/// The invariance of `L_d` under each declared symmetry, and the drift of its momentum along the motion.
pub fn law(motion: &CheckedMotion<'_>, report: &mut Report) {
    if motion.symmetries.is_empty() {
        report.push("symmetries that are declared", Bar::Reported, Ok(0.0));
    }
    for symmetry in motion.symmetries {
        let generator = |q: &[f64]| symmetry.at(q);
        let name = symmetry.name();
        let invariance = largest(&motion.triples, |triple| {
            Ok(asymmetry(&motion.flow, triple.leg.any(), &generator))
        });
        report.push(
            format!("{name}: change of L_d, relative to its terms"),
            Bar::AtMost(LARGEST_CHANGE),
            invariance,
        );
        let free = motion.expected.kind == Kind::Unconstrained || is_allowed(motion, symmetry);
        let bar = if free && !motion.kernel.shape().external_forces {
            Bar::AtMost(LARGEST_DRIFT)
        } else {
            Bar::Reported
        };
        report.push(
            format!("{name}: variation of J along the motion, relative to its terms"),
            bar,
            Ok(drift(motion, symmetry)),
        );
    }
}

/// Whether a symmetry is a virtual displacement along the motion, on which no constraint force does work.
///
/// Where the declaration gives the displacements by fields this is not known.
fn is_allowed(motion: &CheckedMotion<'_>, symmetry: &Symmetry) -> bool {
    motion.triples.iter().all(|triple| {
        let forms = constraint_forms(motion.kernel, motion.h, triple);
        let generator = symmetry.at(&triple.leg.q);
        !forms.is_empty()
            && forms.iter().all(|form| {
                let terms = form.iter().zip(&generator).map(|(form, along)| form * along);
                let (sum, size) = terms.fold((0.0, 0.0), |(sum, size), term| {
                    (sum + term, size + f64::abs(term))
                });
                sum.abs() <= LARGEST_CHANGE * size
            })
    })
}

/// The variation of the momentum along the motion, relative to its terms.
fn drift(motion: &CheckedMotion<'_>, symmetry: &Symmetry) -> f64 {
    relative_variation(motion.legs.iter().map(|leg| {
        let momentum = momentum_map(&motion.flow, leg.any(), &|q| symmetry.at(q));
        let arriving = momentum_plus(motion.kernel, motion.h, leg.any());
        [momentum, terms(motion.kernel, &arriving, &symmetry.at(&leg.q))]
    }))
}

/// The largest minus the smallest value of a momentum, over its largest terms: it may be a small difference
/// of large ones.
pub fn relative_variation(momenta: impl Iterator<Item = [f64; 2]>) -> f64 {
    let (mut least, mut most, mut size) = (f64::INFINITY, f64::NEG_INFINITY, 0.0);
    for [momentum, terms] in momenta {
        (least, most) = (least.min(momentum), larger(most, momentum));
        size = larger(size, terms);
    }
    if most > least || most.is_nan() {
        (most - least) / size
    } else {
        0.0
    }
}

/// The size of the terms of a momentum along a generator. For a rotation it is the product of their norms:
/// its components depend on the frame of the body, and the momentum about one axis is known no better than
/// that about the others.
pub fn terms(kernel: &dyn Kernel, momentum: &[f64], along: &[f64]) -> f64 {
    let shape = kernel.shape();
    let length = |x: &[f64]| x.iter().fold(0.0_f64, |length, x| length.hypot(*x));
    let of_rotation = |first: usize| {
        let own = |x| -> f64 { length(<[f64]>::get(x, first..first + 4).unwrap_or_default()) };
        own(momentum) * own(along)
    };
    let numbers = momentum.iter().zip(along).enumerate();
    let numbers = numbers.filter(|(place, _)| shape.rotation_of(*place).is_none());
    let numbers: f64 = numbers
        .map(|(_, (momentum, along))| (momentum * along).abs())
        .sum();
    numbers
        + shape
            .rotations
            .iter()
            .map(|&first| of_rotation(first))
            .sum::<f64>()
}
