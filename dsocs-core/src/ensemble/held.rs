//! Parameters that change during the runs, on each trajectory in its own way.

use crate::kernel::clock::Clock;
use crate::run::held_value;

/// A parameter that changes during the runs.
#[derive(Clone, Debug)]
pub(super) struct HeldInputs {
    /// The index of the parameter.
    pub place: usize,
    /// For each start, times and the values that hold from them on.
    pub plans: Vec<Vec<[f64; 2]>>,
}

impl HeldInputs {
    /// The value on a trajectory after a time; `None` before the first.
    pub fn at(&self, trajectory: usize, t: f64, h: f64) -> Option<f64> {
        held_value(self.plans.get(trajectory)?, t, h)
    }
}

/// A new value of a parameter.
#[derive(Clone, Copy, Debug)]
pub(super) struct ParameterChange {
    /// The number of the position from which on it holds.
    pub index: u64,
    /// The place of the parameter.
    pub place: usize,
    /// The value.
    pub value: f64,
}

/// The changes on a trajectory after its start, the first one last. Before the first time of a plan, `own`
/// gives a parameter's value.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // the cast saturates, as intended
pub(super) fn changes(
    held: &[HeldInputs],
    trajectory: usize,
    (clock, h): (&Clock, f64),
    own: impl Fn(usize) -> f64,
) -> Vec<ParameterChange> {
    let mut changes = Vec::new();
    for input in held {
        let value = |index: u64| {
            let value = input.at(trajectory, clock.time_of(index), h);
            value.unwrap_or_else(|| own(input.place))
        };
        let times = input.plans.get(trajectory).into_iter().flatten();
        for [time, _] in times {
            let before = ((time - clock.time_of(0)) / h).floor();
            let candidates = [before, before + 1.0, before + 2.0];
            for index in candidates.into_iter().filter(|&index| index >= 1.0) {
                let index = index as u64;
                let (old, new) = (value(index - 1), value(index));
                if old.to_bits() != new.to_bits() {
                    changes.push(ParameterChange {
                        index,
                        place: input.place,
                        value: new,
                    });
                }
            }
        }
    }
    changes.sort_by_key(|change| (core::cmp::Reverse(change.index), change.place));
    changes.dedup_by_key(|change| (change.index, change.place));
    changes
}
