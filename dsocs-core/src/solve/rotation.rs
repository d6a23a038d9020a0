//! Coordinates that are rotations: unit quaternions, moved by increments in the frame of the body.
//!
//! A rotation takes four slots among the coordinates. A position holds its quaternion `(w, x, y, z)`; an increment holds a zero and three numbers
//! `x`, and leads from `q` to `q τ(x)` with the Padé map `τ(x) = ((a² - b) + a x/2)/(a² + b)`, `a = 1 - |x|²/48`, `b = |x|²/16`: it is `exp` up to `|x|⁵/11520`
//! in the angle.

#![allow(clippy::inline_always)] // parts of steps in lanes, which are compiled for each kind of register

mod series;
mod tangent;
mod update;

use core::ops::{Add, Div, Mul, Sub};

use crate::number::compensated::{add, plus};
use crate::number::scalar::Scalar;
use crate::solve::Vector;
use crate::solve::sum::Sum;

pub(crate) use series::{Coefficient, about};
pub(crate) use tangent::{LegTangent, Number, body, body_covector, carried, of_nodes, turn_rates};
pub(crate) use update::part_of_update;

/// Number of slots of a rotation.
pub(crate) const SLOTS: usize = 4;

/// Largest deviation from 1 of the norm of a start's quaternion.
const NEARLY_ONE: f64 = 1e-6;

/// Longest increment of a step; half a turn has the length 3.165.
const LONGEST: f64 = 3.0;

/// Numbers with the operations of quaternion products.
pub(crate) trait Arithmetic:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
}

impl<T: Copy + Add<Output = T> + Sub<Output = T> + Mul<Output = T> + Div<Output = T>> Arithmetic for T {}

/// `p∘q`
#[inline(always)]
fn product<T: Arithmetic>(p: [T; 4], q: [T; 4]) -> [T; 4] {
    let ([a, b, c, d], [w, x, y, z]) = (p, q);
    [
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y + c * w + d * x - b * z,
        a * z + d * w + b * y - c * x,
    ]
}

/// `τ(x) - 1`
#[inline(always)]
fn less_one<T: Scalar>([x, y, z]: [T; 3]) -> [T; 4] {
    let square = x * x + y * y + z * z;
    let a = T::splat(1.0) - square * T::splat(1.0 / 48.0);
    let b = square * T::splat(1.0 / 16.0);
    let denominator = a * a + b;
    let half = T::splat(0.5) * a / denominator;
    [T::splat(-2.0) * b / denominator, half * x, half * y, half * z]
}

/// The change of a quaternion that is moved by an increment.
fn change<T: Scalar>(q: [T; 4], x: [T; 3]) -> [T; 4] {
    product(q, less_one(x))
}

/// The four slots of a rotation, from its first place on.
#[inline(always)]
fn slots<T: Copy>(numbers: &[T], first: usize) -> Option<[T; 4]> {
    numbers.get(first..)?.first_chunk().copied()
}

/// The position that an increment leads to, for any type of number.
pub(crate) fn moved<T: Scalar>(rotations: &[usize], q: &[T], d: &[T]) -> Vec<T> {
    let mut moved: Vec<T> = q.iter().zip(d).map(|(&q, &d)| q + d).collect();
    place(rotations, q, d, &mut moved);
    moved
}

/// [`moved`] for doubles, without an allocation.
pub(crate) fn moved_vector(rotations: &[usize], q: &[f64], d: &Vector) -> Vector {
    let mut moved = Vector::of(q).zip(d, |q, d| q + d);
    place(rotations, q, d, &mut moved);
    moved
}

/// Writes the rotations to which increments lead.
fn place<T: Scalar>(rotations: &[usize], q: &[T], d: &[T], to: &mut [T]) {
    for &first in rotations {
        let (Some(q), Some([_, x, y, z])) = (slots(q, first), slots(d, first)) else {
            continue;
        };
        let changes = change(q, [x, y, z]);
        for ((to, q), change) in to.iter_mut().skip(first).zip(q).zip(changes) {
            *to = q + change;
        }
    }
}

/// Writes the increments of the rotations between two positions, of at most half a turn; `q` and `-q` are the
/// same attitude.
pub(crate) fn difference(rotations: &[usize], [from, to]: [&[f64]; 2], d: &mut [f64]) {
    for &first in rotations {
        let (Some([w, x, y, z]), Some(to)) = (slots(from, first), slots(to, first)) else {
            continue;
        };
        let turned = product([w, -x, -y, -z], to);
        let turned = if turned[0] < 0.0 {
            turned.map(|component| -component)
        } else {
            turned
        };
        put(increment(turned), first, d);
    }
}

/// Writes the rotation vectors, in the frame of the body, between two positions, of at most half a turn; `q`
/// and `-q` are the same attitude.
pub(crate) fn turns(rotations: &[usize], [from, to]: [&[f64]; 2], d: &mut [f64]) {
    for &first in rotations {
        let (Some([w, x, y, z]), Some(to)) = (slots(from, first), slots(to, first)) else {
            continue;
        };
        let [scalar, vector @ ..] = product([w, -x, -y, -z], to);
        let size = vector.iter().map(|x| x * x).sum::<f64>().sqrt();
        let angle = 2.0 * size.atan2(scalar.abs());
        // a turn so small that its square vanishes is twice the vector
        let factor = if size > 0.0 { angle / size } else { 2.0 };
        let [x, y, z] = vector.map(|component| component * factor.copysign(scalar));
        put([0.0, x, y, z], first, d);
    }
}

/// Replaces the changes of quaternions, which are sums, by the increments of the rotations, to as many digits
/// as the changes have. Beyond half a turn an increment is too long.
pub(crate) fn from_changes(rotations: &[usize], from: &[f64], [d, d_low]: [&mut [f64]; 2]) {
    for &first in rotations {
        let (Some([w, x, y, z]), Some(change), Some(low)) =
            (slots(from, first), slots(d, first), slots(d_low, first))
        else {
            continue;
        };
        let back = [w, -x, -y, -z];
        let [change, low] = [change, low].map(|change| product(back, change));
        let [scalar, x, y, z] = [0, 1, 2, 3].map(|k| change[k] + low[k]);
        put(increment([1.0 + scalar, x, y, z]), first, d);
    }
    forget(rotations, d_low);
}

/// The increment of a quaternion, the inverse of `τ`.
fn increment([scalar, vector @ ..]: [f64; 4]) -> [f64; 4] {
    // the half way is (a + x/4)/√(a² + b), and the square of it the whole: with t = |x|/(4 a), a = 1 - a² t²/3
    let ratio = vector.map(|component| component / (1.0 + scalar));
    let square: f64 = ratio.iter().map(|ratio| ratio * ratio).sum();
    let a = 2.0 / (1.0 + (1.0 + 4.0 / 3.0 * square).sqrt());
    [0.0, 4.0 * a * ratio[0], 4.0 * a * ratio[1], 4.0 * a * ratio[2]]
}

/// Writes the numbers of a rotation.
#[inline(always)]
fn put<T: Copy>(numbers: [T; SLOTS], first: usize, to: &mut [T]) {
    for (to, number) in to.iter_mut().skip(first).zip(numbers) {
        *to = number;
    }
}

/// Sets the low parts of rotations to zero.
pub(crate) fn forget(rotations: &[usize], low: &mut [f64]) {
    for &first in rotations {
        for low in low.iter_mut().skip(first).take(SLOTS) {
            *low = 0.0;
        }
    }
}

/// [`moved`] for compensated sums.
pub(crate) fn moved_sum(rotations: &[usize], q: &Sum, d: &Sum) -> Sum {
    let mut sum = q.plus(d);
    turn(
        rotations,
        [&q.hi, &q.lo],
        [&d.hi, &d.lo],
        [&mut sum.hi, &mut sum.lo],
    );
    sum
}

/// Writes the rotations that increments lead to; positions and increments are compensated sums.
pub(crate) fn turn(
    rotations: &[usize],
    [q, q_low]: [&[f64]; 2],
    [d, d_low]: [&[f64]; 2],
    [to, to_low]: [&mut [f64]; 2],
) {
    turn_in(rotations, [q, q_low], [d, d_low], [to, to_low]);
}

/// [`turn`] for any type of number.
#[inline(always)]
pub(crate) fn turn_in<T: Scalar>(
    rotations: &[usize],
    [q, q_low]: [&[T]; 2],
    [d, d_low]: [&[T]; 2],
    [to, to_low]: [&mut [T]; 2],
) {
    for &first in rotations {
        let (Some(hi), Some(lo)) = (slots(q, first), slots(q_low, first)) else {
            continue;
        };
        let (Some(d), Some(d_low)) = (slots(d, first), slots(d_low, first)) else {
            continue;
        };
        let [next, next_low] = turned([hi, lo], [d, d_low]);
        put(next, first, to);
        put(next_low, first, to_low);
    }
}

/// The quaternion that an increment leads to, as a compensated sum.
#[inline(always)]
pub(crate) fn turned<T: Scalar>(
    [hi, lo]: [[T; SLOTS]; 2],
    [[_, x, y, z], [_, x_low, y_low, z_low]]: [[T; SLOTS]; 2],
) -> [[T; SLOTS]; 2] {
    let half = |low: T| T::splat(0.5) * low;
    let by = less_one([x, y, z]);
    let (moves, low, of_low) = (
        product(hi, by),
        product(lo, by),
        product(hi, [T::splat(0.0), half(x_low), half(y_low), half(z_low)]),
    );
    let mut sums = [hi, lo];
    for k in 0..SLOTS {
        (sums[0][k], sums[1][k]) = plus((hi[k], lo[k]), (moves[k], low[k] + of_low[k]));
    }
    of_norm_one(sums)
}

/// Brings a quaternion, as a compensated sum, back to the norm 1, from which rounding moves it.
#[inline(always)]
fn of_norm_one<T: Scalar>([hi, lo]: [[T; SLOTS]; 2]) -> [[T; SLOTS]; 2] {
    let two = T::splat(2.0);
    let excess = (hi.iter().zip(&lo)).fold(T::splat(-1.0), |sum, (&hi, &lo)| sum + hi * (hi + two * lo));
    // the inverse root to second order, for the error of a coarse series, too
    let part = (T::splat(0.375) * excess - T::splat(0.5)) * excess;
    let mut sums = [hi, lo];
    for k in 0..SLOTS {
        (sums[0][k], sums[1][k]) = plus((hi[k], lo[k]), (part * hi[k], T::splat(0.0)));
    }
    sums
}

/// The square of the longest increment of a rotation; zero if there is none.
#[inline(always)]
pub(crate) fn longest_square<T: Scalar>(rotations: &[usize], d: &[T]) -> T {
    let mut longest = T::splat(0.0);
    for &first in rotations {
        if let Some([_, x, y, z]) = slots(d, first) {
            longest = longest.larger(x * x + y * y + z * z);
        }
    }
    longest
}

/// The square of the length beyond which an increment turns too far.
pub(crate) const TOO_FAR: f64 = LONGEST * LONGEST;

/// Moves positions, as sums, by increments. Nothing is allocated.
pub(crate) fn move_sum(rotations: &[usize], [q, q_low]: [&mut [f64]; 2], d: &[f64]) {
    let mut rotations_left = rotations;
    let mut i = 0;
    while i < d.len() {
        if let Some((&first, others)) = rotations_left.split_first()
            && first == i
            && let (Some(hi), Some(lo), Some(by)) = (slots(q, i), slots(q_low, i), slots(d, i))
        {
            let [hi, lo] = turned([hi, lo], [by, [0.0; SLOTS]]);
            put(hi, i, q);
            put(lo, i, q_low);
            rotations_left = others;
            i += SLOTS;
        } else {
            (q[i], q_low[i]) = add((q[i], q_low[i]), d[i]);
            i += 1;
        }
    }
}

/// Brings quaternions, as compensated sums, back to the norm 1. Errors of rounding, or of the truncation of a
/// series, would add up without it.
pub(crate) fn keep_norm(rotations: &[usize], q: [&mut [f64]; 2]) {
    keep_norm_in(rotations, q);
}

/// The first rotation that an increment turns by nearly half a turn or more, and the length of its increment.
pub(crate) fn turns_too_far(rotations: &[usize], d: &[f64]) -> Option<(usize, f64)> {
    rotations.iter().find_map(|&first| {
        let [_, x, y, z] = slots(d, first)?;
        let size = (x * x + y * y + z * z).sqrt();
        // false also for a NaN
        let is_short = size < LONGEST;
        (!is_short).then_some((first, size))
    })
}

/// A quaternion and its first two rates, from position, velocity and acceleration: `q' = ½ q∘(0, ω)`.
pub(crate) fn rates(first: usize, [q, v, a]: [&[f64]; 3]) -> [[f64; SLOTS]; 3] {
    let nothing = [f64::NAN; SLOTS];
    let [q, v, a] = [q, v, a].map(|numbers| slots(numbers, first).unwrap_or(nothing));
    let rate = product(q, v).map(|component| 0.5 * component);
    let [turned, changed] = [product(rate, v), product(q, a)];
    let second = [0, 1, 2, 3].map(|k| 0.5 * (turned[k] + changed[k]));
    [q, rate, second]
}

/// [`keep_norm`] for any type of number.
#[inline(always)]
pub(crate) fn keep_norm_in<T: Scalar>(rotations: &[usize], [q, q_low]: [&mut [T]; 2]) {
    for &first in rotations {
        let (Some(hi), Some(lo)) = (slots(q, first), slots(q_low, first)) else {
            continue;
        };
        let [hi, lo] = of_norm_one([hi, lo]);
        put(hi, first, q);
        put(lo, first, q_low);
    }
}

/// Divides quaternions by their norms.
pub(crate) fn unit(rotations: &[usize], q: &mut [f64]) {
    for &first in rotations {
        if let Some(quaternion) = q.get_mut(first..first + SLOTS) {
            let norm = quaternion.iter().map(|q| q * q).sum::<f64>().sqrt();
            for q in quaternion {
                *q /= norm;
            }
        }
    }
}

/// The rate of a position, from its velocity: that of a quaternion is `½ q∘(0, ω)`.
pub(crate) fn rate(rotations: &[usize], q: &[f64], v: &[f64]) -> Vector {
    let mut rate = Vector::of(v);
    for &first in rotations {
        if let (Some(q), Some(v)) = (slots(q, first), slots(v, first)) {
            for (rate, component) in rate.iter_mut().skip(first).zip(product(q, v)) {
                *rate = 0.5 * component;
            }
        }
    }
    rate
}

/// Brings the quaternions of a start to the norm 1. The error is the place and the norm of the first one that
/// is not [`NEARLY_ONE`].
pub(crate) fn normalize(rotations: &[usize], q: &mut [f64]) -> Result<(), (usize, f64)> {
    for &first in rotations {
        let Some(quaternion) = q.get_mut(first..first + SLOTS) else {
            continue;
        };
        let norm = quaternion.iter().map(|q| q * q).sum::<f64>().sqrt();
        // false also for a NaN
        if (norm - 1.0).abs() < NEARLY_ONE {
            for q in quaternion {
                *q /= norm;
            }
        } else {
            return Err((first, norm));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turn_is_that_of_the_exponential_up_to_the_fifth_power() {
        for size in [0.02_f64, 0.1, 0.4] {
            let angle = size;
            let axis = [0.36, -0.48, 0.8];
            let turned = moved(
                &[0],
                &[1.0, 0.0, 0.0, 0.0],
                &[0.0, axis[0] * size, axis[1] * size, axis[2] * size],
            );
            let norm: f64 = turned.iter().map(|q| q * q).sum();
            assert!((norm - 1.0).abs() < 4e-16);
            let found = 2.0
                * turned[1..]
                    .iter()
                    .zip(axis)
                    .map(|(q, a)| q * a)
                    .sum::<f64>()
                    .atan2(turned[0]);
            let error = (found - angle).abs();
            assert!(
                (error / (size.powi(5) / 11520.0) - 1.0).abs() < 0.05,
                "{size}: {error:e}"
            );
        }
    }

    #[test]
    fn increments_about_a_node_are_those_to_both_sides() {
        let q = [0.5, 0.5, -0.5, 0.5];
        for (x, longer) in [
            ([0.0, 0.3, -0.7, 0.2], [0.0, 0.02, 0.1, -0.05]),
            ([0.0, 1.1, 0.9, -1.2], [0.0, -0.3, 0.2, 0.1]),
        ] {
            let back: Vec<f64> = x.iter().map(|x| -x).collect();
            let next: Vec<f64> = x.iter().zip(longer).map(|(x, e)| x + e).collect();
            let [before, after] = [moved(&[0], &q, &back), moved(&[0], &q, &next)];
            let part = |i: usize, side: f64| f64::midpoint(after[i] - q[i], side * (before[i] - q[i]));
            let [even, odd] = [1.0, -1.0].map(|side| [0, 1, 2, 3].map(|i| part(i, side)));
            let (mut d, mut e) = ([f64::NAN; 4], [f64::NAN; 4]);
            about(&[0], &q, [&even, &odd], [&mut d, &mut e]);
            for i in 0..4 {
                assert!(
                    (d[i] - x[i]).abs() < 4e-15 && (e[i] - longer[i]).abs() < 4e-15,
                    "{d:?} {e:?}"
                );
            }
        }
        // of a short step the difference has all digits, too
        let (even, odd) = ([-2e-16, 3e-16, 0.0, 1e-16], [0.0, 1e-8, 2e-8, 0.0]);
        let (mut d, mut e) = ([f64::NAN; 4], [f64::NAN; 4]);
        about(&[0], &[1.0, 0.0, 0.0, 0.0], [&even, &odd], [&mut d, &mut e]);
        // q± = 1 + even ± odd, so that x± = 2 v± up to the third power
        let expected = [0.0, 4.0 * 3e-16, 0.0, 4.0 * 1e-16];
        for i in 0..4 {
            assert!((e[i] - expected[i]).abs() < 1e-22, "{e:?}");
        }
    }

    #[test]
    fn a_turn_between_two_positions_is_its_axis_times_its_angle() {
        let from = [0.6, 0.0, 0.8, 0.0];
        for angle in [1e-9_f64, 0.3, 1.0, 3.0, 3.1] {
            let axis = [0.36, -0.48, 0.8].map(|a| a * (angle / 2.0).sin());
            let to = product(from, [(angle / 2.0).cos(), axis[0], axis[1], axis[2]]);
            for to in [to, to.map(|q| -q)] {
                let mut turn = [f64::NAN; 4];
                turns(&[0], [&from, &to], &mut turn);
                for (turn, axis) in turn.iter().zip([0.0, 0.36, -0.48, 0.8]) {
                    assert!((turn - axis * angle).abs() < 4e-15, "{angle}: {turn:?}");
                }
            }
        }
        let mut turn = [f64::NAN; 4];
        turns(&[0], [&from, &from.map(|q| -q)], &mut turn);
        assert!(turn.iter().all(|turn| turn.abs() < 1e-16), "{turn:?}");
    }

    #[test]
    fn the_increment_between_two_positions_leads_from_one_to_the_other() {
        let from = [0.5, 0.5, -0.5, 0.5];
        for x in [
            [0.0, 0.3, -0.7, 0.2],
            [0.0, 1.5, 2.0, -1.2],
            [0.0, 1e-9, 0.0, 0.0],
        ] {
            let to = moved(&[0], &from, &x);
            for to in [to.clone(), to.iter().map(|q| -q).collect()] {
                let mut d = [f64::NAN; 4];
                difference(&[0], [&from, &to], &mut d);
                for (d, x) in d.iter().zip(x) {
                    assert!((d - x).abs() < 2e-15, "{d} {x}");
                }
            }
        }
    }

    #[test]
    fn an_increment_and_its_negative_lead_back_and_the_norm_stays() {
        let x = [0.0, 0.3, -0.7, 0.2];
        let start = Vector::of(&[0.5, 0.5, -0.5, 0.5]);
        let mut q = Sum::exact(start.clone());
        let d = Sum::exact(Vector::of(&x));
        for _ in 0..10_000 {
            q = moved_sum(&[0], &q, &d);
        }
        let norm: f64 = q.hi.iter().map(|q| q * q).sum::<f64>().sqrt();
        assert!((norm - 1.0).abs() <= 4.0 * f64::EPSILON, "{norm}");
        for _ in 0..10_000 {
            q = moved_sum(&[0], &q, &d.negated());
        }
        for (q, start) in q.hi.iter().zip(start.iter()) {
            assert!((q - start).abs() < 1e-13);
        }
    }
}
