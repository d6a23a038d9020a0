//! Rotations in derivatives: propagation of small turns from node to node, forward and backward, for eight
//! steps at once.
//!
//! The change of a rotation is three numbers in the frame of its body, behind a zero; so are derivatives by it.

use crate::solve::rotation::{self, LegTangent, Number, SLOTS};
use crate::tape::Eight;

impl Number for Eight {
    #[inline(always)]
    #[allow(clippy::inline_always)] // for the machine's own instructions
    fn of(value: f64) -> Self {
        Self::splat(value)
    }
}

/// The tangents of the rotations on the legs to the next nodes.
pub(super) type Legs = [LegTangent<Eight>];

/// The three numbers of a rotation.
fn vector<T: Copy>(numbers: &[T], first: usize) -> Option<[T; 3]> {
    numbers.get(first + 1..first + SLOTS)?.first_chunk().copied()
}

/// The legs from the middle nodes of some steps on, from their increments.
#[inline(always)]
#[allow(clippy::inline_always)] // for the machine's own instructions
pub(super) fn legs(
    rotations: &[usize],
    increment: impl Fn(usize) -> Eight,
    legs: &mut Vec<LegTangent<Eight>>,
) {
    legs.clear();
    for &first in rotations {
        legs.push(LegTangent::of([1, 2, 3].map(|k| increment(first + k))));
    }
}

/// The turns of the last node of a step, from those of the middle node and of the increment that leads there.
#[inline]
pub(super) fn forward(rotations: &[usize], legs: &Legs, lane: usize, q: &mut [f64], d: &[f64]) {
    let (mut left, mut legs, mut i) = (rotations, legs.iter(), 0);
    while i < q.len() {
        if let (Some((&first, others)), true) = (left.split_first(), left.first() == Some(&i)) {
            if let (Some(leg), Some(node), Some(increment)) =
                (legs.next(), vector(q, first), vector(d, first))
            {
                let turned = lane_of(leg, lane).forward(node, increment);
                q[first + 1..first + SLOTS].copy_from_slice(&turned);
            }
            left = others;
            i += SLOTS;
        } else {
            q[i] += d[i];
            i += 1;
        }
    }
}

/// [`forward`] transposed: derivatives by the last node become those by the middle one, and are added to
/// those by the increment.
#[inline]
pub(super) fn back(rotations: &[usize], legs: &Legs, lane: usize, q: &mut [f64], d: &mut [f64]) {
    let (mut left, mut legs, mut i) = (rotations, legs.iter(), 0);
    while i < q.len() {
        if let (Some((&first, others)), true) = (left.split_first(), left.first() == Some(&i)) {
            if let (Some(leg), Some(by_turn)) = (legs.next(), vector(q, first)) {
                let leg = lane_of(leg, lane);
                for j in 0..3 {
                    let product = |matrix: &[[f64; 3]; 3]| -> f64 {
                        matrix
                            .iter()
                            .zip(by_turn)
                            .map(|(row, slope)| slope * row[j])
                            .sum()
                    };
                    q[first + 1 + j] = product(&leg.by_node);
                    d[first + 1 + j] += product(&leg.by_increment);
                }
            }
            left = others;
            i += SLOTS;
        } else {
            d[i] += q[i];
            i += 1;
        }
    }
}

/// The leg of one step.
fn lane_of(leg: &LegTangent<Eight>, lane: usize) -> LegTangent<f64> {
    let of = |matrix: &[[Eight; 3]; 3]| matrix.map(|row| row.map(|entry| entry.0[lane]));
    LegTangent {
        by_node: of(&leg.by_node),
        by_increment: of(&leg.by_increment),
    }
}

/// Replaces derivatives by the components of quaternions with those by turns; both begin at some place of
/// each row of a matrix.
#[inline(always)]
#[allow(clippy::inline_always)] // for the machine's own instructions
pub(super) fn by_turns(
    rotations: &[usize],
    quaternion: impl Fn(usize) -> [Eight; SLOTS],
    entries: &mut [Eight],
    (width, begin): (usize, usize),
) {
    for &first in rotations {
        let q = quaternion(first);
        for row in entries.chunks_exact_mut(width) {
            let own = &mut row[begin + first..begin + first + SLOTS];
            own.copy_from_slice(&rotation::body_covector(q, [own[0], own[1], own[2], own[3]]));
        }
    }
}

/// The change `½ q∘(0, e)` of a quaternion whose body turns about one of its axes; zero for the place of the
/// zero.
pub(super) fn along(rotations: &[usize], q: &[f64], place: usize) -> Vec<f64> {
    let turn: Vec<f64> = (0..q.len())
        .map(|i| f64::from(u8::from(i == place && !rotations.contains(&i))))
        .collect();
    rotation::rate(rotations, q, &turn).to_vec()
}
