//! Multipliers: what each constraint contributes to the constraint force.

use nalgebra::{DMatrix, DVector};

use crate::system::System;
use crate::unknown::Unknown as _;

/// Whether multipliers are among the unknowns of a system.
pub(crate) fn has_multipliers<S: System<N> + ?Sized, const N: usize>() -> bool {
    S::Motion::<f64>::zero().as_ref().len() > N
}

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
    let scaled = |i: usize, x: f64| if scales[i] > 0.0 { x / scales[i] } else { 0.0 };
    let matrix = DMatrix::from_fn(N, count, |i, j| scaled(i, forms[j][i]));
    let right = DVector::from_fn(N, |i, _| scaled(i, force[i]));
    if matrix.iter().chain(&right).any(|entry| !entry.is_finite()) {
        return vec![f64::NAN; count];
    }
    let solution = matrix.svd(true, true).solve(&right, f64::EPSILON);
    solution.map_or_else(
        |_| vec![f64::NAN; count],
        |solution| solution.iter().copied().collect(),
    )
}

/// The multipliers among the unknowns of the continuous system.
pub(crate) fn of_motion<const N: usize>(motion: &[f64]) -> &[f64] {
    motion.get(N..).unwrap_or_default()
}
