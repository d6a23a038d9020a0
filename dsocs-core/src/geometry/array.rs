//! Vectors of plain numbers and of tangents, for any number of coordinates.

use crate::number::point::{AnyLeg, OwnedLeg};
use crate::number::tangent::{Tangent, Tangent2};

/// The sum.
pub(super) fn plus(x: &[f64], y: &[f64]) -> Vec<f64> {
    x.iter().zip(y).map(|(x, y)| x + y).collect()
}

/// The difference.
pub(super) fn minus(x: &[f64], y: &[f64]) -> Vec<f64> {
    x.iter().zip(y).map(|(x, y)| x - y).collect()
}

/// A multiple of a vector.
pub(super) fn times(factor: f64, x: &[f64]) -> Vec<f64> {
    x.iter().map(|x| x * factor).collect()
}

/// The zero vector.
pub(super) fn zero(coordinates: usize) -> Vec<f64> {
    vec![0.0; coordinates]
}

/// The vector with the component `part` at `coordinate` and zeros elsewhere.
pub(super) fn along(coordinates: usize, coordinate: usize, part: f64) -> Vec<f64> {
    let mut along = zero(coordinates);
    if let Some(along) = along.get_mut(coordinate) {
        *along = part;
    }
    along
}

/// The square matrix of zeros.
pub(super) fn square(coordinates: usize) -> Vec<Vec<f64>> {
    vec![zero(coordinates); coordinates]
}

/// A vector as constants.
pub(super) fn fixed(x: &[f64]) -> Vec<Tangent> {
    x.iter().map(|&x| Tangent::new(x, 0.0)).collect()
}

/// A vector as tangents, with the derivative `by`.
pub(super) fn moving(x: &[f64], by: &[f64]) -> Vec<Tangent> {
    x.iter().zip(by).map(|(&x, &by)| Tangent::new(x, by)).collect()
}

/// A vector with derivatives in two directions.
pub(super) fn moving_twice(x: &[f64], [first, other]: [&[f64]; 2]) -> Vec<Tangent2> {
    let directions = first.iter().zip(other);
    x.iter()
        .zip(directions)
        .map(|(&x, (&first, &other))| Tangent2::second(x, [first, other]))
        .collect()
}

/// A leg as tangents, with the derivatives of node and increment.
pub(super) fn moving_leg(leg: AnyLeg<'_, f64>, q: &[f64], d: &[f64]) -> OwnedLeg<Tangent> {
    OwnedLeg {
        t: Tangent::new(leg.t, 0.0),
        q: moving(leg.q, q),
        d: moving(leg.d, d),
    }
}

/// The first node of a leg of the length `h` as a node, with the leg's increment.
pub(super) fn first_node(h: Tangent, leg: &OwnedLeg<Tangent>) -> OwnedLeg<Tangent> {
    OwnedLeg {
        t: leg.t - h,
        q: leg.q.iter().zip(&leg.d).map(|(&q, &d)| q - d).collect(),
        d: leg.d.clone(),
    }
}

/// The derivatives, divided by the unit of the direction.
pub(super) fn slopes(x: &[Tangent], unit: f64) -> Vec<f64> {
    x.iter().map(|x| x.derivative() / unit).collect()
}
