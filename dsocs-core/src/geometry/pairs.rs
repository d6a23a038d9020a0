//! The pairs of nodes, and the states, that constraints of lower order allow.

use super::array::{first_node, minus, moving, moving_leg, times};
use super::form::Displacement;
use super::map::Triple;
use super::units;
use crate::kernel::Kernel;
use crate::number::point::AnyLeg;
use crate::number::scalar::Scalar as _;
use crate::number::tangent::Tangent;
use crate::solve::dense::{Matrix, length};
use crate::tape::declaration::Declaration;

/// A singular value of the constraints' derivative below this part of the largest is zero.
const INDEPENDENT: f64 = 1e-10;

/// An orthonormal basis of the displacements `(δq0, δq1)` of a pair along which holonomic constraints of both nodes and
/// nonholonomic ones of the pair keep their values: the tangent space of the discrete flow's domain `C_d`. (Holonomic constraints are
/// kept at their values, so the submanifold is the one through the pair; paper, remark on discrete holonomic systems.)
///
/// Constraints of second order do not restrict pairs. If there are no others, the basis has all directions, two for each coordinate.
#[must_use]
pub fn pair_displacements(system: &dyn Kernel, h: f64, leg: AnyLeg<'_, f64>) -> Vec<Displacement> {
    let (declaration, units, h) = (Declaration::of(system), units(leg), Tangent::splat(h));
    let n = units.len();
    kernel(n, declaration.lower(), &|k| {
        let (unit, size) = (Displacement::unit(n, k), units[k % n]);
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
/// constraint, or none if the declaration gives the virtual displacements by fields. A form has one component for each coordinate.
#[must_use]
pub fn constraint_forms(system: &dyn Kernel, h: f64, triple: &Triple) -> Vec<Vec<f64>> {
    Declaration::of(system).forms(h, triple.leg.any(), &triple.e)
}

/// An orthonormal basis of the displacements `(δq, δv)` of a state at the time `t` along which holonomic constraints, their derivatives in
/// time and nonholonomic constraints keep their values.
#[must_use]
pub fn state_displacements(system: &dyn Kernel, t: f64, q: &[f64], v: &[f64]) -> Vec<Displacement> {
    let declaration = Declaration::of(system);
    let rows = declaration.holonomic() + declaration.lower();
    kernel(declaration.dimension(), rows, &|k| {
        let unit = Displacement::unit(declaration.dimension(), k);
        let (q, v) = (moving(q, &unit.first), moving(v, &unit.second));
        let rows = declaration.phase(Tangent::splat(t), &q, &v);
        rows.into_iter().map(Tangent::derivative).collect()
    })
}

/// An orthonormal basis of the kernel of rows on displacements of `n` coordinates, of which `column` gives the entries for one
/// coordinate; all units where there are none.
fn kernel(n: usize, rows: usize, column: &dyn Fn(usize) -> Vec<f64>) -> Vec<Displacement> {
    if rows == 0 {
        return (0..2 * n).map(|k| Displacement::unit(n, k)).collect();
    }
    let columns: Vec<Vec<f64>> = (0..2 * n).map(column).collect();
    // with rows of zeros the decomposition gives a basis of the whole space
    let height = columns.iter().map(Vec::len).fold(2 * n, usize::max);
    let entry = |i: usize, j: usize| columns[j].get(i).copied().unwrap_or(0.0);
    let mut matrix = Matrix::from_fn(height, 2 * n, entry);
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
        .map(|(_, row)| displacement(n, row))
        .collect()
}

/// The displacement of `n` coordinates with some components, those of the first part first.
fn displacement(n: usize, components: &[f64]) -> Displacement {
    let (first, second) = components.split_at(n.min(components.len()));
    Displacement {
        first: first.to_vec(),
        second: second.to_vec(),
    }
}
