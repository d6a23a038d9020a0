//! Detects arguments of sines that change too far in a step: the nodes see the same of a rotor that makes a whole turn in each.

use dsocs_core::AnyNode;

use crate::entry::Row;
use crate::stability::written_time;

use super::is_tested;
use super::turns::{LARGE_TURN, RESOLVED_TURN, rounded};

/// The arguments are looked at again where a velocity is larger than at all nodes so far that were looked at, by this factor; so is a change that
/// takes the place of one before.
const FASTER: f64 = 1.25;

/// The argument of a run that changes most in a step.
#[derive(Default)]
pub struct Arguments {
    /// The number of the next node that is looked at in any case: each is twice that of the one before.
    next: u64,
    /// The speed of each coordinate above which a node is looked at.
    speeds: Vec<f64>,
    /// The argument, as in the declaration, its change in a step, in rad, and the time.
    largest: Option<(String, f64, f64)>,
}

impl Arguments {
    /// Looks at a node.
    #[inline]
    pub fn look<'r>(&mut self, node: &AnyNode<'_>, row: &impl Fn() -> Row<'r>) {
        let is_faster = |(v, speed): (&f64, &f64)| v.abs() > *speed;
        if is_tested(node.index)
            && (node.index >= self.next || node.v.iter().zip(&self.speeds).any(is_faster))
        {
            self.look_at(&row());
        }
    }

    #[cold]
    fn look_at(&mut self, row: &Row<'_>) {
        let node = &row.node;
        self.speeds.resize(node.v.len(), 0.0);
        let Some(before) = row.before else {
            self.next = 1;
            return;
        };
        self.next = 2 * node.index;
        for (speed, v) in self.speeds.iter_mut().zip(node.v) {
            *speed = speed.max(FASTER * v.abs());
        }
        let least = (self.largest.as_ref()).map_or(LARGE_TURN, |(_, change, _)| FASTER * change);
        let turned = row
            .declaration
            .largest_turn(before.any().point(), node.point(), least);
        if let Some((text, change)) = turned {
            self.largest = Some((text, change, node.t));
        }
    }

    /// The warning for steps of the length `h`.
    pub fn note(&self, h: f64) -> Option<String> {
        let (text, change, t) = self.largest.as_ref()?;
        let shorter = rounded(RESOLVED_TURN * h.abs() / change);
        Some(format!(
            "warning: `{text}` changes by {change:.1} rad in a step at t = {}, and its sine or cosine has hardly four nodes in a period: \
                 what depends on it in between is lost; take `--step {shorter}` or less, {RESOLVED_TURN} rad a step",
            written_time(*t)
        ))
    }
}
