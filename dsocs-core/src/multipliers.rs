//! Multipliers: what each constraint contributes to the constraint force.

use crate::declaration::Declaration;
use crate::dense::Matrix;
use crate::regularity;
use crate::system::{Leg, Point};

/// Components of forms below this part of the largest are not scaled up.
const FAINT: f64 = 1e-3;

/// The multipliers `λ` of the forms with which `Σ λ_j α_j` comes nearest to a force `Q`; where the equations of the step hold,
/// the two are equal. NaN if the force or a form is not finite.
pub(crate) fn multipliers<const N: usize>(force: &[f64; N], forms: &[[f64; N]]) -> Vec<f64> {
    let count = forms.len();
    if count == 0 {
        return Vec::new();
    }
    // coordinates with their own units: a row of forms and force is scaled by its largest form
    let scales: [f64; N] = core::array::from_fn(|i| {
        forms
            .iter()
            .fold(0.0_f64, |largest, form| largest.max(form[i].abs()))
    });
    // a component that passes through zero is not to be blown up to the size of the others: its force is rounding
    let least = FAINT * scales.iter().fold(0.0_f64, |largest, scale| largest.max(*scale));
    let scaled = |i: usize, x: f64| {
        if scales[i] > 0.0 {
            x / scales[i].max(least)
        } else {
            0.0
        }
    };
    let matrix = Matrix::from_fn(N, count, |i, j| scaled(i, forms[j][i]));
    let right: [f64; N] = core::array::from_fn(|i| scaled(i, force[i]));
    if !matrix.is_finite() || right.iter().any(|entry| !entry.is_finite()) {
        return vec![f64::NAN; count];
    }
    matrix.decomposed().solve(&right, f64::EPSILON)
}

/// The multipliers among the unknowns of the continuous system.
pub(crate) fn of_motion<const N: usize>(motion: &[f64]) -> &[f64] {
    motion.get(N..).unwrap_or_default()
}

/// The multipliers that are unknown in a step, at the triple of a leg and a second difference: those that come nearest to the
/// constraint force there. None where there are fields instead.
pub(crate) fn of_step<const N: usize>(
    declaration: &Declaration<'_, N>,
    h: f64,
    leg: &Leg<f64, N>,
    e: &[f64; N],
) -> Vec<f64> {
    if !declaration.has_multipliers() {
        return Vec::new();
    }
    // components for the lengths that coordinates move, not for their units: then it is no matter of units which form is faint
    let forms = declaration.forms(h, leg, e);
    let lengths = regularity::measured(declaration, h, leg, e);
    let largest = |i: usize| {
        forms
            .iter()
            .fold(0.0_f64, |largest, form| largest.max(form[i].abs()))
    };
    let all = (0..N).fold(0.0_f64, |most, i| {
        most.max(lengths[i].map_or(0.0, |length| length * largest(i)))
    });
    let units: [f64; N] = core::array::from_fn(|i| {
        // the forms of a coordinate that has no length are not
        let unit = lengths[i].unwrap_or_else(|| if all > 0.0 { all } else { 1.0 } / largest(i));
        if unit.is_normal() { unit } else { 1.0 }
    });
    let works = |x: &[f64; N]| -> [f64; N] { core::array::from_fn(|i| x[i] * units[i]) };
    let forms: Vec<[f64; N]> = forms.iter().map(works).collect();
    multipliers(&works(&declaration.force(h, leg, e)), &forms)
}

/// The multipliers of the continuous system at a point.
pub(crate) fn of_point<const N: usize>(declaration: &Declaration<'_, N>, point: &Point<f64, N>) -> Vec<f64> {
    multipliers(
        &declaration.continuous_force(point),
        &declaration.continuous_forms(point),
    )
}

/// How many multipliers are left among the unknowns of a step.
pub(crate) fn count_unknown<const N: usize>(declaration: &Declaration<'_, N>) -> usize {
    let ones = vec![1.0; declaration.forms_count()];
    let unknown = declaration.unknown(&[0.0; N], &ones);
    unknown.iter().filter(|&&x| x != 0.0).count()
}
