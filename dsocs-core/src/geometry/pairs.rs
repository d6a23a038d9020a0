//! The pairs of nodes that constraints of lower order allow.

use nalgebra::DMatrix;

use super::form::Displacement;
use super::units;
use crate::scalar::Scalar as _;
use crate::system::{Leg, System};
use crate::tangent::Tangent;

/// A singular value of the constraints' derivative below this part of the largest is zero.
const INDEPENDENT: f64 = 1e-10;

/// An orthonormal basis of the displacements `(δq0, δq1)` of a pair along which holonomic constraints of both nodes and
/// nonholonomic ones of the pair keep their values: the tangent space of the discrete flow's domain `C_d`. (Holonomic constraints are
/// kept at their values, so the submanifold is the one through the pair; paper, remark on discrete holonomic systems.)
///
/// Constraints of second order bind no pairs: without others all `2N` directions are given.
#[must_use]
pub fn pair_displacements<S: System<N>, const N: usize>(
    system: &S,
    h: f64,
    leg: &Leg<f64, N>,
) -> Vec<Displacement<N>> {
    let all = || (0..2 * N).map(Displacement::unit).collect();
    let rows = S::HOLONOMIC + S::NONHOLONOMIC;
    if rows == 0 {
        return all();
    }
    let units = units(leg);
    let mut matrix = DMatrix::zeros((rows + S::HOLONOMIC).max(2 * N), 2 * N);
    for column in 0..2 * N {
        let unit = Displacement::<N>::unit(column);
        let size = units[column % N];
        // q0 = q1 − d
        let moved = Leg {
            q: core::array::from_fn(|i| Tangent::new(leg.q[i], size * unit.second[i])),
            d: core::array::from_fn(|i| Tangent::new(leg.d[i], size * (unit.second[i] - unit.first[i]))),
        };
        let mut of_pair = vec![Tangent::splat(0.0); rows];
        system.pair(Tangent::splat(h), &moved, &mut of_pair);
        let first = Leg {
            q: core::array::from_fn(|i| moved.q[i] - moved.d[i]),
            d: moved.d,
        };
        let mut of_first = vec![Tangent::splat(0.0); rows];
        system.pair(Tangent::splat(h), &first, &mut of_first);
        let both = of_pair.iter().chain(&of_first[..S::HOLONOMIC]);
        for (row, value) in both.enumerate() {
            matrix[(row, column)] = value.derivative() / size;
        }
    }
    for mut row in matrix.row_iter_mut() {
        let size = row.norm();
        if size > 0.0 {
            row /= size;
        }
    }
    let decomposed = matrix.svd(false, true);
    let largest = decomposed.singular_values.max();
    let Some(basis) = decomposed.v_t else {
        return all();
    };
    let kernel = decomposed.singular_values.iter().zip(basis.row_iter());
    kernel
        .filter(|(value, _)| **value <= INDEPENDENT * largest)
        .map(|(_, row)| Displacement {
            first: core::array::from_fn(|i| row[i]),
            second: core::array::from_fn(|i| row[N + i]),
        })
        .collect()
}
