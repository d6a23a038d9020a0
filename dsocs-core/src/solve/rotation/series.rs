//! Taylor series of rotations: coefficients of a quaternion, and increments between nodes on a series.

#![allow(clippy::inline_always)] // parts of recurrences, which are compiled for each kind of register

use super::{SLOTS, product, put, slots};
use crate::number::fours::{Fours, OnFours};
use crate::number::scalar::Scalar;

/// The Taylor coefficient of order `k + 1` of a quaternion, from its coefficients and those of its angular velocity, up to order `k`:
/// `(k + 1) q_{k+1} = ½ Σ q_j∘(0, ω_{k-j})`.
pub(crate) struct Coefficient<T, I> {
    /// The unit of time, divided by `k + 1`.
    pub scale: T,
    /// The coefficients of the quaternion in ascending order, each with the coefficient of the angular velocity that
    /// multiplies it; two at a time.
    pub pairs: I,
    /// The last one, if their number is odd.
    pub last: Option<Term<T>>,
}

/// A coefficient of a quaternion, and one of the angular velocity behind an unused number.
pub(crate) type Term<T> = [[T; SLOTS]; 2];

/// Where the components of a quaternion go when it is multiplied by a unit vector, and their signs.
const TURNS: [([usize; SLOTS], [f64; SLOTS]); 3] = [
    ([1, 0, 3, 2], [-1.0, 1.0, 1.0, -1.0]),
    ([2, 3, 0, 1], [-1.0, -1.0, 1.0, 1.0]),
    ([3, 2, 1, 0], [-1.0, 1.0, -1.0, 1.0]),
];

impl<T: Scalar, I: Iterator<Item = [Term<T>; 2]>> OnFours<T> for Coefficient<T, I> {
    type Output = [T; SLOTS];

    /// The sums are the products of each component of `ω` with all four components of `q`, which fill a register.
    /// Even and odd `j` are summed apart, so that additions need not wait for each other.
    #[inline(always)]
    fn run<F: Fours<T>>(self, fours: F) -> [T; SLOTS] {
        let Self { scale, pairs, last } = self;
        let zero = fours.row([T::splat(0.0); SLOTS]);
        let [mut even, mut odd] = [[zero; 3]; 2];
        for [one, other] in pairs {
            add_turn(fours, &mut even, one);
            add_turn(fours, &mut odd, other);
        }
        if let Some(last) = last {
            add_turn(fours, &mut even, last);
        }
        let mut turned = zero;
        for (axis, (from, signs)) in TURNS.into_iter().enumerate() {
            let sum = fours.numbers(fours.add(even[axis], odd[axis]));
            let moved = fours.row([sum[from[0]], sum[from[1]], sum[from[2]], sum[from[3]]]);
            turned = fours.add_product(turned, moved, fours.row(signs.map(T::splat)));
        }
        let half = fours.row([T::splat(0.5) * scale; SLOTS]);
        fours.numbers(fours.add_product(zero, turned, half))
    }
}

/// Adds the products of each component of an angular velocity with a quaternion.
#[inline(always)]
fn add_turn<T: Scalar, F: Fours<T>>(fours: F, sums: &mut [F::Row; 3], [q, w]: Term<T>) {
    let q = fours.row(q);
    for axis in 0..3 {
        sums[axis] = fours.add_product(sums[axis], q, fours.row([w[axis + 1]; SLOTS]));
    }
}

/// The increments of rotations before and after a node `q`, whose quaternion changes by `even ∓ odd` to the
/// node before and to the one after: `d` leads from the first to `q`, and `e` is the second difference. Both
/// have as many digits as the two parts.
pub(crate) fn about(rotations: &[usize], q: &[f64], [even, odd]: [&[f64]; 2], [d, e]: [&mut [f64]; 2]) {
    for &first in rotations {
        let (Some([w, x, y, z]), Some(even), Some(odd)) =
            (slots(q, first), slots(even, first), slots(odd, first))
        else {
            continue;
        };
        let [even, odd] = [even, odd].map(|part| product([w, -x, -y, -z], part));
        // with the ratio r = v/(1 + c) of vector and scalar an increment is 8 r/(1 + √(1 + 4/3 |r|²));
        // computed by sums and differences of both sides
        let shares = [1.0, -1.0].map(|side| 1.0 / (2.0 + even[0] + side * odd[0]));
        let [share, by_share] = halves(shares, -2.0 * odd[0] * shares[0] * shares[1]);
        let sum = [1, 2, 3].map(|i| share * even[i] + by_share * odd[i]);
        let difference = [1, 2, 3].map(|i| share * odd[i] + by_share * even[i]);
        let roots = [1.0, -1.0].map(|side| {
            let ratio = [0, 1, 2].map(|i| sum[i] + side * difference[i]);
            (1.0 + 4.0 / 3.0 * ratio.iter().map(|r| r * r).sum::<f64>()).sqrt()
        });
        let along: f64 = sum.iter().zip(&difference).map(|(x, y)| x * y).sum();
        let apart = 16.0 / 3.0 * along / (roots[0] + roots[1]);
        let factors = roots.map(|root| 8.0 / (1.0 + root));
        let [factor, by_factor] = halves(factors, -apart * factors[0] * factors[1] / 8.0);
        let before = [0, 1, 2].map(|i| factors[1] * (difference[i] - sum[i]));
        let longer = [0, 1, 2].map(|i| 2.0 * (factor * sum[i] + by_factor * difference[i]));
        put([0.0, before[0], before[1], before[2]], first, d);
        put([0.0, longer[0], longer[1], longer[2]], first, e);
    }
}

/// Half the sum of two numbers, and half their difference, which is given.
fn halves([one, other]: [f64; 2], difference: f64) -> [f64; 2] {
    [f64::midpoint(one, other), difference / 2.0]
}
