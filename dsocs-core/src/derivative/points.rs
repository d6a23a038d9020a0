//! The points of a path's nodes (positions, velocities and accelerations) with their derivatives. Those of
//! rotations are by turns in the frames of the bodies.

use super::block::{Equations, Role, Rooms, Steps, quaternion, set};
use crate::solve::rotation::{SLOTS, body_covector};
use crate::tape::Eight;

impl Equations {
    /// The points of up to eight nodes of the stretch that was entered: positions, velocities, accelerations.
    pub fn points(&self, steps: &Steps<'_>, rooms: &mut Rooms, points: &mut [Eight]) {
        set(&self.point, &self.of_point, steps, &mut rooms.point);
        let (source, count) = (steps.declaration.source(), steps.recorded.count());
        self.point.evaluate_again(source, &mut rooms.point, count);
        rooms.quaternions.clear();
        for &first in &self.rotations {
            rooms.quaternions.push(quaternion(&steps.recorded, first));
        }
        for (k, point) in points.iter_mut().enumerate() {
            *point = self.point.result(&rooms.point, k);
        }
    }

    /// The changes of the points that were evaluated last.
    pub fn change_points(&self, rooms: &mut Rooms, change: &dyn Fn(Role) -> Eight, points: &mut [Eight]) {
        let Rooms {
            point, quaternions, ..
        } = rooms;
        let mut place = 0;
        let mut change_of = |_| {
            place += 1;
            let role = self.of_point[place - 1];
            self.of_rotation(role)
                .and_then(|(k, rotation, first)| {
                    let turn = [1, 2, 3].map(|k| change(Role::Node(first + k)));
                    Some(component(*quaternions.get(rotation)?, turn, k))
                })
                .unwrap_or_else(|| change(role))
        };
        self.point.forward(point, &mut change_of, &mut |k, change| {
            if let Some(to) = points.get_mut(k) {
                *to = change;
            }
        });
        for &first in &self.rotations {
            for k in first..first + SLOTS {
                points[k] = change(Role::Node(k));
            }
        }
    }

    /// The derivatives of a weighted sum of the components of the points that were evaluated last.
    pub fn back_from_points(&self, rooms: &mut Rooms, weights: &[Eight], take: &mut dyn FnMut(Role, Eight)) {
        let Rooms {
            point, quaternions, ..
        } = rooms;
        let is_turn = |k: usize| self.of_rotation(Role::Node(k)).is_some();
        let weight = |k: usize| match weights.get(k) {
            // a turn of the node is added directly
            Some(_) if is_turn(k) => Eight::ZERO,
            Some(weight) => *weight,
            None => Eight::ZERO,
        };
        let mut of_quaternions = vec![[Eight::ZERO; SLOTS]; self.rotations.len()];
        self.point.back_from_all(point, &weight, &mut |input, slope| {
            let role = self.of_point[input];
            match self.of_rotation(role) {
                Some((k, rotation, _)) => of_quaternions[rotation][k] = slope,
                None => take(role, slope),
            }
        });
        let both = quaternions.iter().zip(&of_quaternions);
        for (&first, (q, slopes)) in self.rotations.iter().zip(both) {
            let by_turn = body_covector(*q, *slopes);
            for k in 1..SLOTS {
                let weight = weights.get(first + k).copied().unwrap_or(Eight::ZERO);
                take(Role::Node(first + k), by_turn[k] + weight);
            }
        }
    }

    /// The rotation of a node's quaternion component: its number among the four, the number of the rotation, and the rotation's first place.
    /// `None` for another role.
    fn of_rotation(&self, role: Role) -> Option<(usize, usize, usize)> {
        let Role::Node(i) = role else { return None };
        let mut rotations = self.rotations.iter().enumerate();
        rotations.find_map(|(rotation, &first)| {
            let k = i.checked_sub(first)?;
            (k < SLOTS).then_some((k, rotation, first))
        })
    }
}

/// A component of `½ q∘(0, turn)`.
fn component([w, x, y, z]: [Eight; SLOTS], [a, b, c]: [Eight; 3], k: usize) -> Eight {
    let sum = match k {
        0 => -(x * a + y * b + z * c),
        1 => w * a + y * c - z * b,
        2 => w * b + z * a - x * c,
        _ => w * c + x * b - y * a,
    };
    Eight::splat(0.5) * sum
}
