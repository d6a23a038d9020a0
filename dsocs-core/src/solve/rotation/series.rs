//! Taylor series of rotations: coefficients of a quaternion, and increments between nodes on a series.

#![allow(clippy::inline_always)] // parts of recurrences, which are compiled for each kind of register

use super::{SLOTS, product, put, slots};
use crate::number::scalar::Scalar;

/// The Taylor coefficient of order `k + 1` of a quaternion, from its coefficients and those of its angular velocity, up to order `k`:
/// `(k + 1) q_{k+1} = ½ Σ q_j∘(0, ω_{k-j})`.
///
/// The sums are the products of each component of `ω` with all four components of `q`, which fill a register.
/// Even and odd `j` are summed apart, so that additions need not wait for each other. `add_product` adds to
/// its first argument the product of the others.
#[inline(always)]
pub(crate) fn coefficient<T: Scalar>(
    k: usize,
    scale: T,
    q: impl Fn(usize) -> [T; SLOTS],
    w: impl Fn(usize) -> [T; SLOTS],
    add_product: impl Fn(T, T, T) -> T + Copy,
) -> [T; SLOTS] {
    let mut sums = [[[T::splat(0.0); SLOTS]; 3]; 2];
    let mut j = 0;
    while j < k {
        let [even, odd] = &mut sums;
        add_turn(even, q(j), w(k - j), add_product);
        add_turn(odd, q(j + 1), w(k - j - 1), add_product);
        j += 2;
    }
    if j == k {
        add_turn(&mut sums[0], q(j), w(0), add_product);
    }
    // the vectorised form of the loop ends here; without this the compiler would give it up
    let [[x, y, z], [x_odd, y_odd, z_odd]] = core::hint::black_box(sums);
    let of = |sum: [T; SLOTS], odd: [T; SLOTS]| move |i: usize| sum[i] + odd[i];
    let (x, y, z) = (of(x, x_odd), of(y, y_odd), of(z, z_odd));
    let half = T::splat(0.5) * scale;
    [
        half * (T::splat(0.0) - (x(1) + y(2) + z(3))),
        half * (x(0) + z(2) - y(3)),
        half * (y(0) + x(3) - z(1)),
        half * (z(0) + y(1) - x(2)),
    ]
}

/// Adds the products of each component of an angular velocity with a quaternion.
#[inline(always)]
fn add_turn<T: Scalar>(
    sums: &mut [[T; SLOTS]; 3],
    q: [T; SLOTS],
    w: [T; SLOTS],
    add_product: impl Fn(T, T, T) -> T,
) {
    for a in 0..3 {
        for i in 0..SLOTS {
            sums[a][i] = add_product(sums[a][i], q[i], w[a + 1]);
        }
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
