//! Derivatives of a leg by its nodes: numbers change by themselves, rotations by small turns in the frame of
//! their body.

use super::array::{along, moving};
use crate::number::point::{AnyLeg, OwnedLeg};
use crate::number::tangent::Tangent;
use crate::solve::rotation;

/// The first slot of the rotation that contains a coordinate.
fn rotation_of(rotations: &[usize], coordinate: usize) -> Option<usize> {
    let before = rotations.iter().rfind(|&&first| first <= coordinate);
    before
        .copied()
        .filter(|first| coordinate < first + rotation::SLOTS)
}

/// Whether a coordinate has a velocity; the first slot of a rotation has none, since a turn is three numbers.
pub(super) fn moves(rotations: &[usize], coordinate: usize) -> bool {
    !rotations.contains(&coordinate)
}

/// The length of an increment in a coordinate; for a rotation the length of its turn, whatever the axis.
pub(super) fn extent(rotations: &[usize], d: &[f64], coordinate: usize) -> f64 {
    let own = d.get(coordinate).copied().unwrap_or(0.0);
    rotation_of(rotations, coordinate).map_or(own, |first| {
        let turn = d.iter().skip(first).take(rotation::SLOTS);
        turn.fold(0.0_f64, |length, part| length.hypot(*part))
    })
}

/// A position as tangents along a coordinate; for a rotation, a turn about an axis of its body.
pub(super) fn moving_position(rotations: &[usize], q: &[f64], coordinate: usize) -> Vec<Tangent> {
    let by = along(q.len(), coordinate, 1.0);
    moving(q, &rotation::rate(rotations, q, &by))
}

/// A leg as tangents along a coordinate, with given parts for its first and its second node.
pub(super) fn moving_nodes(
    rotations: &[usize],
    leg: AnyLeg<'_, f64>,
    coordinate: usize,
    [first, second]: [f64; 2],
) -> OwnedLeg<Tangent> {
    let n = leg.d.len();
    let q = along(n, coordinate, second);
    let mut d = along(n, coordinate, second - first);
    let mut by_node = q.clone();
    if let Some(place) = rotation_of(rotations, coordinate) {
        by_node = rotation::rate(rotations, leg.q, &q).to_vec();
        d = vec![0.0; n];
        let axis = coordinate - place;
        if let (Some(&[_, x, y, z]), Some(to)) = (
            leg.d.get(place..).and_then(|d| d.first_chunk()),
            d.get_mut(place + 1..place + rotation::SLOTS),
        ) && let Some(column) = axis.checked_sub(1)
        {
            let [by_first, by_second] = rotation::of_nodes([x, y, z]);
            for (to, (by_first, by_second)) in to.iter_mut().zip(by_first.iter().zip(&by_second)) {
                *to = first * by_first[column] + second * by_second[column];
            }
        }
    }
    OwnedLeg {
        t: Tangent::new(leg.t, 0.0),
        q: moving(leg.q, &by_node),
        d: moving(leg.d, &d),
    }
}
