//! Tangents of rotations: small turns `ξ`, three numbers in the frame of the body with `δq = ½ q∘(0, ξ)`, and
//! covectors of them.
//!
//! In vectors of slots they stand behind a zero, as angular velocities do.

use super::{Arithmetic, SLOTS, product, put, slots};

/// Numbers for computations with small turns.
pub(crate) trait Number: Arithmetic {
    /// A constant.
    fn of(value: f64) -> Self;
}

impl Number for f64 {
    #[inline(always)]
    fn of(value: f64) -> Self {
        value
    }
}

/// A matrix, by rows.
type Matrix<T> = [[T; 3]; 3];

/// Derivatives of the second node of a leg, `q∘τ(x)`, by its first node and by its increment `x`, as small
/// turns.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LegTangent<T> {
    /// By a turn of the first node: the inverse of the rotation `τ(x)`.
    pub by_node: Matrix<T>,
    /// By the increment: the left tangent of `τ`.
    pub by_increment: Matrix<T>,
}

/// `w I + f u uᵀ - g û`
#[inline(always)]
fn axial<T: Number>(u: [T; 3], [w, f, g]: [T; 3]) -> Matrix<T> {
    let [x, y, z] = u.map(|u| g * u);
    let outer = |i: usize, j: usize| f * u[i] * u[j];
    [
        [w + outer(0, 0), outer(0, 1) + z, outer(0, 2) - y],
        [outer(1, 0) - z, w + outer(1, 1), outer(1, 2) + x],
        [outer(2, 0) + y, outer(2, 1) - x, w + outer(2, 2)],
    ]
}

/// A matrix times a vector.
#[inline(always)]
fn times<T: Number>(matrix: &Matrix<T>, v: [T; 3]) -> [T; 3] {
    matrix.map(|[x, y, z]| x * v[0] + y * v[1] + z * v[2])
}

impl<T: Number> LegTangent<T> {
    /// The derivatives for a leg with the increment `x`.
    #[inline(always)]
    pub fn of(x: [T; 3]) -> Self {
        let [one, two, part, sixteenth] = [1.0, 2.0, 1.0 / 48.0, 1.0 / 16.0].map(T::of);
        let square = x[0] * x[0] + x[1] * x[1] + x[2] * x[2];
        let (a, b) = (one - square * part, square * sixteenth);
        let denominator = a * a + b;
        // τ(x) = (c, s x), and their derivatives by the square of x
        let (c, s) = (one - two * b / denominator, a / (two * denominator));
        let rate = sixteenth - two * part * a;
        let squared = denominator * denominator;
        let c_rate = two * (b * rate - sixteenth * denominator) / squared;
        let s_rate = T::of(-0.5) * (part * denominator + a * rate) / squared;
        let (turn, four) = (x.map(|x| s * x), T::of(4.0));
        Self {
            by_node: axial(turn, [two * c * c - one, two, two * c]),
            by_increment: axial(x, [two * c * s, four * (c * s_rate - c_rate * s), two * s * s]),
        }
    }

    /// The turn of the second node, for those of the first node and of the increment.
    #[inline(always)]
    pub fn forward(&self, node: [T; 3], increment: [T; 3]) -> [T; 3] {
        let (of_node, of_increment) = (times(&self.by_node, node), times(&self.by_increment, increment));
        [0, 1, 2].map(|i| of_node[i] + of_increment[i])
    }
}

/// The change of the second node of a leg, for those of its first node and of its increment; coordinates that
/// are no rotations add.
pub(crate) fn carried(rotations: &[usize], d: &[f64], node: &[f64], increment: &[f64]) -> Vec<f64> {
    let mut sum: Vec<f64> = node.iter().zip(increment).map(|(q, d)| q + d).collect();
    for &first in rotations {
        let (Some([_, x @ ..]), Some([_, q @ ..]), Some([_, d @ ..])) =
            (slots(d, first), slots(node, first), slots(increment, first))
        else {
            continue;
        };
        let [x, y, z] = LegTangent::of(x).forward(q, d);
        put([0.0, x, y, z], first, &mut sum);
    }
    sum
}

/// The derivatives of a leg's increment by the turns of its first and of its second node.
pub(crate) fn of_nodes(x: [f64; 3]) -> [Matrix<f64>; 2] {
    let square: f64 = x.iter().map(|x| x * x).sum();
    let (a, b) = (1.0 - square / 48.0, square / 16.0);
    let c = (a * a - b) / a;
    let d = (0.125 - a * a / 24.0) / (a * (1.0 + square / 48.0));
    let by_first = axial(x, [c, d, 0.5]).map(|row| row.map(|entry| -entry));
    [by_first, axial(x, [c, d, -0.5])]
}

/// Replaces changes of quaternions by turns.
pub(crate) fn body(rotations: &[usize], q: &[f64], change: &[f64]) -> Vec<f64> {
    let mut turns = change.to_vec();
    for &first in rotations {
        if let (Some([w, x, y, z]), Some(change)) = (slots(q, first), slots(change, first)) {
            let [_, turn @ ..] = product([w, -x, -y, -z], change).map(|component| 2.0 * component);
            put([0.0, turn[0], turn[1], turn[2]], first, &mut turns);
        }
    }
    turns
}

/// The rates of turns, `ξ' = δω + ξ×ω`, and of other coordinates, from changes of the velocities.
pub(crate) fn turn_rates(rotations: &[usize], v: &[f64], turns: &[f64], velocities: &[f64]) -> Vec<f64> {
    let mut rates = velocities.to_vec();
    for &first in rotations {
        let (Some([_, a, b, c]), Some([_, x, y, z]), Some([_, p, q, r])) =
            (slots(v, first), slots(turns, first), slots(velocities, first))
        else {
            continue;
        };
        put(
            [0.0, p + y * c - z * b, q + z * a - x * c, r + x * b - y * a],
            first,
            &mut rates,
        );
    }
    rates
}

/// The derivatives by the turn of a quaternion, from those by its components.
#[inline(always)]
pub(crate) fn body_covector<T: Number>([w, x, y, z]: [T; SLOTS], slopes: [T; SLOTS]) -> [T; SLOTS] {
    let zero = T::of(0.0);
    let [_, turn @ ..] = product([w, zero - x, zero - y, zero - z], slopes);
    let half = T::of(0.5);
    [zero, half * turn[0], half * turn[1], half * turn[2]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::number::tangent::Tangent;
    use crate::solve::rotation::{difference, moved, rate};

    const LEGS: [[f64; 4]; 4] = [
        [0.0; 4],
        [0.0, 0.3, -0.7, 0.2],
        [0.0, 1.5, 2.0, -1.2],
        [0.0, 1e-9, 0.0, 2e-10],
    ];
    const NODE: [f64; 4] = [0.5, 0.5, -0.5, 0.5];

    #[test]
    fn a_turn_is_carried_as_the_leg_itself_moves() {
        let (node, increment) = ([0.0, 0.3, -0.2, 0.7], [0.0, -0.4, 0.9, 0.1]);
        for x in LEGS {
            let turned = rate(&[0], &NODE, &node);
            let lift = |numbers: &[f64], rates: &[f64]| -> Vec<Tangent> {
                let both = numbers.iter().zip(rates);
                both.map(|(number, rate)| Tangent::new(*number, *rate)).collect()
            };
            let next = moved(&[0], &lift(&NODE, &turned), &lift(&x, &increment));
            let (q, change): (Vec<f64>, Vec<f64>) = next.iter().map(|q| (q.value(), q.derivative())).unzip();
            let expected = body(&[0], &q, &change);
            let found = carried(&[0], &x, &node, &increment);
            for (found, expected) in found.iter().zip(expected) {
                assert!((found - expected).abs() < 2e-15, "{x:?}: {found} {expected}");
            }
        }
    }

    #[test]
    fn the_increment_between_two_nodes_moves_with_both() {
        let (first, second) = ([0.3, -0.2, 0.7], [-0.4, 0.9, 0.1]);
        let of = |turn: [f64; 3]| [0.0, turn[0], turn[1], turn[2]];
        for x in LEGS {
            let [by_first, by_second] = of_nodes([x[1], x[2], x[3]]);
            let (one, other) = (times(&by_first, first), times(&by_second, second));
            let d = of([0, 1, 2].map(|i| one[i] + other[i]));
            // the increment's change leads to the turn of the second node
            let found = carried(&[0], &x, &of(first), &d);
            for (found, expected) in found.iter().zip(of(second)) {
                assert!((found - expected).abs() < 1e-14, "{x:?}: {found} {expected}");
            }
        }
    }

    #[test]
    fn derivatives_by_a_turn_are_those_of_what_is_computed() {
        let slopes = [0.3, -1.2, 0.4, 2.0];
        let by_turn = body_covector(NODE, slopes);
        for k in 1..4 {
            let mut turn = [0.0; 4];
            turn[k] = 1.0;
            let change = rate(&[0], &NODE, &turn);
            let expected: f64 = slopes.iter().zip(change.iter()).map(|(slope, q)| slope * q).sum();
            assert!((by_turn[k] - expected).abs() < 1e-15);
        }
        // for a small turn, the increment is the turn
        let mut d = [0.0; 4];
        let small = [0.0, 1e-7, -2e-7, 3e-8];
        difference(&[0], [&NODE, &moved(&[0], &NODE, &small)], &mut d);
        let change: Vec<f64> = rate(&[0], &NODE, &small).to_vec();
        for (turn, d) in body(&[0], &NODE, &change).iter().zip(d) {
            assert!((turn - d).abs() < 1e-15);
        }
    }
}
