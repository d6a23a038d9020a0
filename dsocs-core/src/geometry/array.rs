//! Vectors, and numbers that carry derivatives, of each number of coordinates.

use crate::system::Leg;
use crate::tangent::{Tangent, Tangent2};

/// The sum.
pub(super) fn plus<const N: usize>(x: &[f64; N], y: &[f64; N]) -> [f64; N] {
    let mut sum = *x;
    for (sum, y) in sum.iter_mut().zip(y) {
        *sum += y;
    }
    sum
}

/// The difference.
pub(super) fn minus<const N: usize>(x: &[f64; N], y: &[f64; N]) -> [f64; N] {
    let mut difference = *x;
    for (difference, y) in difference.iter_mut().zip(y) {
        *difference -= y;
    }
    difference
}

/// A multiple.
pub(super) fn times<const N: usize>(factor: f64, x: &[f64; N]) -> [f64; N] {
    let mut multiple = *x;
    for multiple in &mut multiple {
        *multiple *= factor;
    }
    multiple
}

/// So much along one coordinate, and nothing along the others.
pub(super) fn along<const N: usize>(coordinate: usize, part: f64) -> [f64; N] {
    let mut along = [0.0; N];
    if let Some(along) = along.get_mut(coordinate) {
        *along = part;
    }
    along
}

/// A vector that moves.
pub(super) fn moving<const N: usize>(x: &[f64; N], by: &[f64; N]) -> [Tangent; N] {
    let mut moving = [Tangent::new(0.0, 0.0); N];
    for (moving, (&x, &by)) in moving.iter_mut().zip(x.iter().zip(by)) {
        *moving = Tangent::new(x, by);
    }
    moving
}

/// A vector that moves in two directions.
pub(super) fn moving_twice<const N: usize>(x: &[f64; N], [first, other]: [&[f64; N]; 2]) -> [Tangent2; N] {
    let mut moving = [Tangent2::second(0.0, [0.0; 2]); N];
    for (k, moving) in moving.iter_mut().enumerate() {
        *moving = Tangent2::second(x[k], [first[k], other[k]]);
    }
    moving
}

/// A leg whose node and increment move.
pub(super) fn moving_leg<const N: usize>(leg: &Leg<f64, N>, q: &[f64; N], d: &[f64; N]) -> Leg<Tangent, N> {
    Leg {
        t: Tangent::new(leg.t, 0.0),
        q: moving(&leg.q, q),
        d: moving(&leg.d, d),
    }
}

/// The first node of a leg of the length `h` as a node, with the leg's increment.
pub(super) fn first_node<const N: usize>(h: Tangent, leg: &Leg<Tangent, N>) -> Leg<Tangent, N> {
    let mut first = *leg;
    first.t = first.t - h;
    for (q, &d) in first.q.iter_mut().zip(&leg.d) {
        *q = *q - d;
    }
    first
}

/// The derivatives, over the unit of the direction.
pub(super) fn slopes<const N: usize>(x: &[Tangent; N], unit: f64) -> [f64; N] {
    let mut slopes = [0.0; N];
    for (slope, x) in slopes.iter_mut().zip(x) {
        *slope = x.derivative() / unit;
    }
    slopes
}
