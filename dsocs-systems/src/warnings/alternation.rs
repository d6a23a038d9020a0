//! Detects a coordinate whose increments alternate from step to step.
//!
//! No motion that the step resolves does so: its period is many steps. Where a spring or a damper is too
//! stiff for the step, the remainder of the fast motion changes its sign in every step, and may grow.

use crate::entry::{Method, Row};
use crate::stability::written_time;

use super::is_tested;

/// The number of increments in a row with opposite signs, none much smaller than the one before, that counts
/// as alternation.
const LEAST_STREAK: u32 = 20;

/// The smallest ratio of an increment to the one before: after a streak an eighth is left.
const LEAST_RATIO: f64 = 0.9;

/// An alternation counts if the energy of the velocity is above this part of the largest energy so far; less
/// may be rounding.
const LEAST_ENERGY: f64 = 1e-6;

/// The increments of the last step, and the number of times they have alternated.
#[derive(Default)]
pub struct Alternation {
    /// The number and the time of the last node, and its position.
    last: Option<(u64, f64)>,
    position: Vec<f64>,
    /// The increments to it.
    increments: Vec<f64>,
    /// The number of alternations in a row, by coordinate.
    streaks: Vec<u32>,
    /// The largest energy so far.
    energy: f64,
    /// The first coordinate that has alternated for a streak, and the time at which that began.
    found: Option<(usize, f64)>,
}

impl Alternation {
    /// Looks at a node: at all of the first ones, and then at a window of consecutive ones now and again.
    #[inline]
    pub fn look<'r>(&mut self, index: u64, row: &impl Fn() -> Row<'r>) {
        if is_tested(index) {
            self.look_at(&row());
        }
    }

    #[inline(never)]
    fn look_at(&mut self, row: &Row<'_>) {
        let (node, q) = (&row.node, row.node.q);
        self.energy = self.energy.max(node.energy.abs());
        let follows = self.last.filter(|(index, _)| index + 1 == node.index);
        if self.found.is_some() || follows.is_none() {
            self.position.clear();
            self.position.extend(q);
            self.increments = vec![0.0; q.len()];
            self.streaks = vec![0; q.len()];
        }
        if let Some((_, before)) = follows
            && self.found.is_none()
        {
            let h = node.t - before;
            for (i, x) in q.iter().enumerate() {
                let increment = x - self.position[i];
                let last = core::mem::replace(&mut self.increments[i], increment);
                let alternates = increment * last < 0.0 && increment.abs() > LEAST_RATIO * last.abs();
                self.streaks[i] = if alternates { self.streaks[i] + 1 } else { 0 };
                if self.streaks[i] == LEAST_STREAK {
                    if energy_of(row, i, increment / h) > LEAST_ENERGY * self.energy {
                        self.found = Some((i, node.t - f64::from(LEAST_STREAK) * h));
                    }
                    self.streaks[i] = 0;
                }
            }
            self.position.copy_from_slice(q);
        }
        self.last = Some((node.index, node.t));
    }

    /// The warning for a run with steps of a fixed length, with the names of the coordinates.
    pub fn note<'n>(&self, mut names: impl Iterator<Item = &'n str>, method: Method) -> Option<String> {
        let (place, time) = self.found?;
        if matches!(method, Method::Tolerance(_)) {
            return None;
        }
        let name = names.nth(place).unwrap_or_default();
        Some(format!(
            "warning: `{name}` goes to and fro from step to step, from about t = {} on: something moves or is damped there too fast for this step, and what the step makes of it is not \
             the motion (a smaller `--step`; or declare what is so stiff as a constraint)",
            written_time(time)
        ))
    }
}

/// The part of the energy that is due to a velocity of one coordinate.
fn energy_of(row: &Row<'_>, coordinate: usize, velocity: f64) -> f64 {
    let (node, declaration) = (&row.node, &row.declaration);
    let energy = |velocity: f64| {
        let mut v = node.v.to_vec();
        v[coordinate] = velocity;
        declaration.energy::<f64>(node.t, node.q, &v)
    };
    (energy(velocity) - energy(0.0)).abs()
}
