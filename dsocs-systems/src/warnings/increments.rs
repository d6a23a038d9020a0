//! Detects a coordinate that moves otherwise than its velocity says.
//!
//! The legs of a composition are joined by momenta. Where a direction has hardly any inertia, as the axis of a slender
//! body, errors of a leg's other momenta in this direction are as large as its own momentum: the velocities at the nodes, which follow from the
//! momenta, are right, and the increments between them are not.

use dsocs_core::geometry::position_changes;
use dsocs_core::{OwnedNode, Stop};

use crate::entry::Row;
use crate::stability::written_time;

use super::is_tested;

/// A coordinate is reported if this many increments in a row differ from the integral of its velocity. A
/// force that grows from rest differs in a few.
const LEAST_STREAK: u32 = 12;

/// The least difference, relative to the step times the largest velocity so far. Where a period has ten steps the integral has
/// an error of 2e-4.
const LEAST: f64 = 2e-3;

/// A motion begins in a step in which the largest velocity so far grows by more than this factor.
const BEGINS: f64 = 1.5;

/// The increments of a composition.
#[derive(Default)]
pub struct Increments {
    /// The last node.
    last: Option<OwnedNode>,
    /// The largest velocities so far, and the number of increments in a row that differ, by coordinate.
    largest: Vec<f64>,
    streaks: Vec<u32>,
    /// The first coordinate whose increments differ, the time, its increment, and the integral of its velocity.
    found: Option<(usize, f64, [f64; 2])>,
}

impl Increments {
    /// Looks at a node: at all of the first ones, and then at a window of consecutive ones now and again.
    #[inline]
    pub fn look<'r>(&mut self, index: u64, row: &impl Fn() -> Row<'r>) {
        if self.found.is_none() && is_tested(index) {
            self.look_at(&row());
        }
    }

    #[inline(never)]
    fn look_at(&mut self, row: &Row<'_>) {
        let (node, shape) = (&row.node, row.declaration.shape());
        let n = node.q.len();
        let Some(last) = &mut self.last else {
            self.last = Some(OwnedNode::of(node));
            (self.largest, self.streaks) = (vec![0.0; n], vec![0; n]);
            return;
        };
        let before = last.any();
        if before.index + 1 == node.index {
            let [increments, integrals] = position_changes(shape, [before.point(), node.point()]);
            let h = (node.t - before.t).abs();
            for (i, (increment, integral)) in increments.into_iter().zip(integrals).enumerate() {
                let earlier = self.largest[i];
                self.largest[i] = earlier.max(node.v[i].abs());
                // a force that grows from nothing, as that of a feature far away, does so by large factors
                let begins = self.largest[i] > BEGINS * earlier;
                // what rests moves by rounding
                let rounding = f64::EPSILON * (before.q[i].abs() + node.q[i].abs());
                let differs = node.stop != Stop::Sticks
                    && !begins
                    && (increment - integral).abs() > (LEAST * h * self.largest[i]).max(rounding);
                self.streaks[i] = if differs { self.streaks[i] + 1 } else { 0 };
                if self.streaks[i] == LEAST_STREAK {
                    self.found = Some((i, node.t, [increment, integral]));
                }
            }
        }
        last.as_node_mut().write(node);
    }

    /// The warning for a run by a composition with the step `h`, with the names of the coordinates.
    pub fn note(&self, names: &[&str], h: f64) -> Option<String> {
        let (place, time, [increment, integral]) = self.found?;
        let name = names.get(place).copied().unwrap_or_default();
        Some(format!(
            "warning: `{name}` moves by {increment:.2e} in the step to t = {}, where its velocity gives {integral:.2e}: the legs of a composition \
             are joined by momenta, and where something has hardly any inertia, as a slender body about its axis, moves too fast, or is driven by a force \
             that changes within the step, they do not tell how it moves with the step h = {h} (`--tolerance`, or a smaller `--step`; \
             with hardly any inertia also `--order 2`)",
            written_time(time)
        ))
    }
}
