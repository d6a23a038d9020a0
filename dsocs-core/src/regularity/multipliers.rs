//! Multipliers: the contribution of each constraint to the constraint force.

use crate::number::point::{AnyLeg, AnyPoint};
use crate::regularity::lengths;
use crate::solve::dense::Matrix;
use crate::tape::declaration::Declaration;

/// Components of forms below this part of the largest are not scaled up.
const FAINT: f64 = 1e-3;

/// The multipliers `λ` for which `Σ λ_j α_j` is closest to a force `Q`; equal to it if the equations of the
/// step hold. NaN if the force or a form is not finite.
pub(crate) fn multipliers(force: &[f64], forms: &[Vec<f64>]) -> Vec<f64> {
    let (n, count) = (force.len(), forms.len());
    if count == 0 {
        return Vec::new();
    }
    // coordinates may have different units: each component of forms and force is scaled by its largest form
    let scale = |i: usize| {
        forms
            .iter()
            .fold(0.0_f64, |largest, form| largest.max(form[i].abs()))
    };
    // a component that passes through zero is not scaled up to the size of the others: its force is rounding
    let least = FAINT * (0..n).fold(0.0_f64, |largest, i| largest.max(scale(i)));
    let scaled = |i: usize, x: f64| {
        let scale = scale(i);
        if scale > 0.0 { x / scale.max(least) } else { 0.0 }
    };
    let mut matrix = Matrix::from_fn(n, count, |i, j| scaled(i, forms[j][i]));
    let right: Vec<f64> = (0..n).map(|i| scaled(i, force[i])).collect();
    if !matrix.is_finite() || right.iter().any(|entry| !entry.is_finite()) {
        return vec![f64::NAN; count];
    }
    // forms may be short, or zero
    let lengths: Vec<f64> = matrix
        .normalize_columns()
        .into_iter()
        .enumerate()
        .map(|(j, length)| {
            if length > 0.0 {
                return length;
            }
            for i in 0..n {
                matrix[(i, j)] = 0.0;
            }
            1.0
        })
        .collect();
    let mut multipliers = matrix.decomposed().solve(&right, f64::EPSILON);
    for (multiplier, length) in multipliers.iter_mut().zip(lengths) {
        *multiplier /= length;
    }
    multipliers
}

/// The multipliers among the unknowns of the continuous system.
pub(crate) fn of_motion(coordinates: usize, motion: &[f64]) -> &[f64] {
    motion.get(coordinates..).unwrap_or_default()
}

/// The multipliers among the unknowns of a step, for a leg and a second difference: those that fit the
/// constraint force best. Empty if there are fields instead.
pub(crate) fn of_step(declaration: &Declaration<'_>, h: f64, leg: AnyLeg<'_, f64>, e: &[f64]) -> Vec<f64> {
    if !declaration.has_multipliers() {
        return Vec::new();
    }
    // components in units of the coordinates' lengths, not of their units: then whether a form is faint does
    // not depend on units
    let forms = declaration.forms(h, leg, e);
    let lengths = lengths::measured(declaration, h, leg, e);
    let largest = |i: usize| {
        forms
            .iter()
            .fold(0.0_f64, |largest, form| largest.max(form[i].abs()))
    };
    let n = declaration.dimension();
    let all = (0..n).fold(0.0_f64, |most, i| {
        most.max(lengths[i].map_or(0.0, |length| length * largest(i)))
    });
    let unit = |i: usize| {
        // the forms of a coordinate without a length are scaled to the common size
        let unit = lengths[i].unwrap_or_else(|| if all > 0.0 { all } else { 1.0 } / largest(i));
        if unit.is_normal() { unit } else { 1.0 }
    };
    let units: Vec<f64> = (0..n).map(unit).collect();
    let works = |x: &[f64]| -> Vec<f64> { x.iter().zip(&units).map(|(x, unit)| x * unit).collect() };
    let forms: Vec<Vec<f64>> = forms.iter().map(|form| works(form)).collect();
    multipliers(&works(&declaration.force(h, leg, e)), &forms)
}

/// The multipliers of the continuous system at a point.
pub(crate) fn of_point(declaration: &Declaration<'_>, point: AnyPoint<'_, f64>) -> Vec<f64> {
    multipliers(
        &declaration.continuous_force(point),
        &declaration.continuous_forms(point),
    )
}

/// The number of multipliers among the unknowns of a step.
pub(crate) fn count_unknown(declaration: &Declaration<'_>) -> usize {
    let ones = vec![1.0; declaration.forms_count()];
    let unknown = declaration.unknown(&vec![0.0; declaration.dimension()], &ones);
    unknown.iter().filter(|&&x| x != 0.0).count()
}
