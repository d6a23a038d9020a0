//! Multipliers: what each constraint contributes to the constraint force.

use nalgebra::{DMatrix, DVector};

use crate::step::unknown::Unknown as _;
use crate::system::{Leg, Point, System};

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

/// The multipliers that are unknown in a step, at the triple of a leg and a second difference: those that come nearest to the
/// constraint force there. None where there are fields instead.
pub(crate) fn of_step<S: System<N> + ?Sized, const N: usize>(
    system: &S,
    h: f64,
    leg: &Leg<f64, N>,
    e: &[f64; N],
) -> Vec<f64> {
    if !has_multipliers::<S, N>() {
        return Vec::new();
    }
    let constants = system.constants(h);
    let known = system.known(&constants, leg);
    of_known(system, &constants, &known, leg, e)
}

/// The same with what is known of the step.
pub(crate) fn of_known<S: System<N> + ?Sized, const N: usize>(
    system: &S,
    constants: &S::Constants<f64>,
    known: &S::Known<f64>,
    leg: &Leg<f64, N>,
    e: &[f64; N],
) -> Vec<f64> {
    let force = system.force(constants, known, leg, e);
    let mut forms = vec![[0.0; N]; S::FORMS];
    system.forms(constants, known, leg, e, &mut forms);
    multipliers(&force, &forms)
}

/// The multipliers of the continuous system at a point.
pub(crate) fn of_point<S: System<N> + ?Sized, const N: usize>(system: &S, point: &Point<f64, N>) -> Vec<f64> {
    let mut forms = vec![[0.0; N]; S::FORMS];
    system.continuous_forms(point, &mut forms);
    multipliers(&system.continuous_force(point), &forms)
}

/// How many multipliers are left among the unknowns of a step.
pub(crate) fn count_unknown<S: System<N> + ?Sized, const N: usize>(system: &S) -> usize {
    let ones = vec![1.0; S::FORMS];
    let unknown = system.unknown(&[0.0; N], &ones);
    unknown.as_ref().iter().filter(|&&x| x != 0.0).count()
}
