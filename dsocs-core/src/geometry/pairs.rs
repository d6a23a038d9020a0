//! The pairs of nodes, and the states, that constraints of lower order allow.

use super::array::{first_node, minus, moving, moving_leg, times};
use super::form::Displacement;
use super::map::Triple;
use super::solvable::Declared;
use super::units;
use crate::any::sized;
use crate::dense::{Matrix, length};
use crate::scalar::Scalar as _;
use crate::system::Leg;
use crate::tangent::Tangent;

/// A singular value of the constraints' derivative below this part of the largest is zero.
const INDEPENDENT: f64 = 1e-10;

/// An orthonormal basis of the displacements `(δq0, δq1)` of a pair along which holonomic constraints of both nodes and
/// nonholonomic ones of the pair keep their values: the tangent space of the discrete flow's domain `C_d`. (Holonomic constraints are
/// kept at their values, so the submanifold is the one through the pair; paper, remark on discrete holonomic systems.)
///
/// Constraints of second order do not restrict pairs. If there are no others, the basis has all `2N` directions.
#[must_use]
pub fn pair_displacements<const N: usize>(
    system: &dyn Declared<N>,
    h: f64,
    leg: &Leg<f64, N>,
) -> Vec<Displacement<N>> {
    let (declaration, units, h) = (system.declaration(), units(leg), Tangent::splat(h));
    kernel(declaration.lower(), &|k| {
        let (unit, size) = (Displacement::<N>::unit(k), units[k % N]);
        // q0 = q1 − d
        let by = minus(&unit.second, &unit.first);
        let moved = moving_leg(leg, &times(size, &unit.second), &times(size, &by));
        let first = declaration.pair(h, first_node(h, &moved).any());
        let holonomic = first.into_iter().take(declaration.holonomic());
        let rows = declaration.pair(h, moved.any()).into_iter().chain(holonomic);
        rows.map(|row| row.derivative() / size).collect()
    })
}

/// The forms `α_j` in whose directions the constraint forces of a step act, `Q = Σ λ_j α_j`, at a triple: one for each
/// constraint, or none if the declaration gives the virtual displacements by fields.
#[must_use]
pub fn constraint_forms<const N: usize>(
    system: &dyn Declared<N>,
    h: f64,
    triple: &Triple<N>,
) -> Vec<[f64; N]> {
    let forms = system.declaration().forms(h, triple.leg.any(), &triple.e);
    forms.iter().map(|form| sized(form)).collect()
}

/// An orthonormal basis of the displacements `(δq, δv)` of a state at the time `t` along which holonomic constraints, their derivatives in
/// time and nonholonomic constraints keep their values.
#[must_use]
pub fn state_displacements<const N: usize>(
    system: &dyn Declared<N>,
    t: f64,
    q: &[f64; N],
    v: &[f64; N],
) -> Vec<Displacement<N>> {
    let declaration = system.declaration();
    kernel(declaration.holonomic() + declaration.lower(), &|k| {
        let unit = Displacement::<N>::unit(k);
        let rows = declaration.phase(
            Tangent::splat(t),
            &moving(q, &unit.first),
            &moving(v, &unit.second),
        );
        rows.into_iter().map(Tangent::derivative).collect()
    })
}

/// An orthonormal basis of the kernel of rows, of which `column` gives the entries for one coordinate; all units where there
/// are none.
fn kernel<const N: usize>(rows: usize, column: &dyn Fn(usize) -> Vec<f64>) -> Vec<Displacement<N>> {
    let all = || (0..2 * N).map(Displacement::unit).collect();
    if rows == 0 {
        return all();
    }
    let columns: Vec<Vec<f64>> = (0..2 * N).map(column).collect();
    // with rows of zeros the decomposition gives a basis of the whole space
    let height = columns.iter().map(Vec::len).fold(2 * N, usize::max);
    let entry = |i: usize, j: usize| columns[j].get(i).copied().unwrap_or(0.0);
    let mut matrix = Matrix::from_fn(height, 2 * N, entry);
    for i in 0..height {
        let size = length(&matrix.row(i).collect::<Vec<_>>());
        if size > 0.0 {
            matrix.divide_row(i, size);
        }
    }
    let decomposed = matrix.decomposed();
    let [_, largest] = decomposed.extremes();
    let kernel = decomposed.values.iter().zip(&decomposed.right);
    kernel
        .filter(|(value, _)| **value <= INDEPENDENT * largest)
        .map(|(_, row)| displacement(row))
        .collect()
}

/// The displacement with some components, those of the first part first.
fn displacement<const N: usize>(components: &[f64]) -> Displacement<N> {
    let mut displacement = Displacement::unit(2 * N);
    let parts = displacement.first.iter_mut().chain(&mut displacement.second);
    for (part, &component) in parts.zip(components) {
        *part = component;
    }
    displacement
}
