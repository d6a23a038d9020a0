//! Displacements of pairs of nodes, and of states, that constraints of lower order admit.

use super::array::{first_node, minus, moving, moving_leg, times};
use super::form::Displacement;
use super::map::Triple;
use super::units;
use crate::kernel::Kernel;
use crate::number::point::AnyLeg;
use crate::number::scalar::Scalar as _;
use crate::number::tangent::Tangent;
use crate::regularity::lengths::weights;
use crate::solve::dense::{Matrix, length};
use crate::tape::declaration::Declaration;

/// A singular value of the constraints' derivative below this part of the largest is zero.
const INDEPENDENT: f64 = 1e-10;

/// A basis of the displacements `(δq0, δq1)` of a pair along which holonomic constraints of both nodes and
/// nonholonomic ones of the pair keep their values: the tangent space of the discrete flow's domain `C_d`. (Holonomic constraints are
/// kept at their values, so the submanifold is the one through the pair; paper, remark on discrete holonomic systems.)
///
/// Coordinates may have different units. So the basis is orthogonal after each coordinate is multiplied by
/// the square root of its mass. Constraints of second order do not restrict pairs. If there are no others,
/// the basis has all directions, two for each coordinate.
#[must_use]
pub fn pair_displacements(system: &dyn Kernel, h: f64, leg: AnyLeg<'_, f64>) -> Vec<Displacement> {
    let (declaration, units, h) = (Declaration::of(system), units(leg), Tangent::splat(h));
    let n = units.len();
    let weights = weights(&declaration, h.value(), leg);
    let most = weights.iter().copied().fold(0.0, f64::max);
    let length = |&weight: &f64| {
        // a coordinate without mass is scaled like the heaviest one
        let length = if weight > 0.0 {
            weight.recip()
        } else {
            most.recip()
        };
        if length.is_finite() { length } else { 1.0 }
    };
    let lengths: Vec<f64> = weights.iter().map(length).collect();
    kernel(&lengths, declaration.lower(), &|k| {
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
    let ones = vec![1.0; declaration.dimension()];
    kernel(&ones, rows, &|k| {
        let unit = Displacement::unit(declaration.dimension(), k);
        let (q, v) = (moving(q, &unit.first), moving(v, &unit.second));
        let rows = declaration.phase(Tangent::splat(t), &q, &v);
        rows.into_iter().map(Tangent::derivative).collect()
    })
}

/// A basis of the kernel of constraint rows on displacements; `column` gives the entries for one coordinate.
/// It is orthonormal with coordinates in units of their `lengths`; without rows, it has all unit
/// displacements.
fn kernel(lengths: &[f64], rows: usize, column: &dyn Fn(usize) -> Vec<f64>) -> Vec<Displacement> {
    let n = lengths.len();
    if rows == 0 {
        return (0..2 * n).map(|k| Displacement::unit(n, k)).collect();
    }
    let columns: Vec<Vec<f64>> = (0..2 * n).map(column).collect();
    // with rows of zeros the decomposition gives a basis of the whole space
    let height = columns.iter().map(Vec::len).fold(2 * n, usize::max);
    let entry = |i: usize, j: usize| columns[j].get(i).map_or(0.0, |entry| entry * lengths[j % n]);
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
        .map(|(_, row)| {
            let own = row.iter().enumerate();
            let own: Vec<f64> = own.map(|(j, part)| part * lengths[j % n]).collect();
            displacement(n, &own)
        })
        .collect()
}

/// The displacement of `n` coordinates with given components, those of the first part first.
fn displacement(n: usize, components: &[f64]) -> Displacement {
    let (first, second) = components.split_at(n.min(components.len()));
    Displacement {
        first: first.to_vec(),
        second: second.to_vec(),
    }
}
