//! The clock of a run: the number and the time of its current node.

/// The number of a run's current node, its time, and whether it has been handed out.
///
/// If the nodes lie at a fixed distance in time, their times are computed as products, because a sum of steps would add up rounding errors.
/// A method that chooses its steps gives the clock the time of each node.
///
/// A new method owns a clock and calls [`Clock::tick`] or [`Clock::arrive`] at every step; the functions of
/// [`crate::Stepper`] do the rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    /// The times of the nodes.
    node_times: NodeTimes,
    /// The number of the current node.
    index: u64,
    /// Whether the node has been handed out, or passed.
    handed: bool,
    /// Whether the iterator has ended.
    ended: bool,
}

/// The times of the nodes of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
enum NodeTimes {
    /// Equidistant, a step `h` apart.
    Even {
        /// The time of the start.
        t0: f64,
        /// The step at the beginning of the run.
        h: f64,
        /// The number of steps from the start to node 0.
        origin: i64,
        /// 1, or -1 while the run goes back.
        direction: i64,
    },
    /// Chosen by the method.
    Free {
        /// The time of the current node.
        now: f64,
        /// 1, or -1 back in time.
        direction: f64,
    },
}

/// The end of a run: the last node at or before a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct End {
    /// The number of the last node, if the nodes are a step apart.
    pub(crate) index: Option<u64>,
    /// The end in time; the run need not go beyond.
    pub(crate) time: f64,
}

impl End {
    /// The time of the last node; infinite if an observer is to end the run.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.time
    }

    /// The number of the last node, if the nodes are a step apart.
    pub(crate) fn index(&self) -> Option<u64> {
        self.index
    }
}

impl Clock {
    /// The clock of a run whose nodes lie the step `h` apart. Node 0 is at `t0`.
    #[must_use]
    pub fn even(t0: f64, h: f64) -> Self {
        Self::at(NodeTimes::Even {
            t0,
            h,
            origin: 0,
            direction: 1,
        })
    }

    /// The clock of a run forward in time whose method chooses its steps. Node 0 is at `t0`.
    #[must_use]
    pub fn free(t0: f64) -> Self {
        Self::at(NodeTimes::Free {
            now: t0,
            direction: 1.0,
        })
    }

    /// A clock at a node 0 that has not been handed out.
    fn at(node_times: NodeTimes) -> Self {
        Self {
            node_times,
            index: 0,
            handed: false,
            ended: false,
        }
    }

    /// The number of the current node.
    #[must_use]
    pub fn index(&self) -> u64 {
        self.index
    }

    /// The time of the current node.
    #[must_use]
    pub fn time(&self) -> f64 {
        match self.node_times {
            NodeTimes::Even { .. } => self.time_of(self.index),
            NodeTimes::Free { now, .. } => now,
        }
    }

    /// The time of node `index` if the nodes are a step apart; NaN if the method chooses its steps.
    #[must_use]
    pub fn time_of(&self, index: u64) -> f64 {
        match self.node_times {
            NodeTimes::Even {
                t0,
                h,
                origin,
                direction,
            } => t0 + tick(origin, direction, index) as f64 * h,
            NodeTimes::Free { .. } => f64::NAN,
        }
    }

    /// The step in the direction of the run; `None` if the method chooses it.
    #[must_use]
    pub fn step(&self) -> Option<f64> {
        match self.node_times {
            NodeTimes::Even { h, direction, .. } => Some(direction as f64 * h),
            NodeTimes::Free { .. } => None,
        }
    }

    /// Whether the run goes forward in time.
    #[must_use]
    pub fn is_forward(&self) -> bool {
        match self.node_times {
            NodeTimes::Even { h, direction, .. } => (direction > 0) == (h > 0.0),
            NodeTimes::Free { direction, .. } => direction > 0.0,
        }
    }

    /// Moves on to the next node, a step later. It counts as handed out, because [`crate::Stepper::node`] gives it.
    #[inline]
    pub fn tick(&mut self) {
        self.index += 1;
        self.handed = true;
    }

    /// Moves on to the next node, at the time `t` that the method has chosen.
    #[inline]
    pub fn arrive(&mut self, t: f64) {
        if let NodeTimes::Free { now, .. } = &mut self.node_times {
            *now = t;
        }
        self.tick();
    }

    /// Reverses the run at the current node, which becomes number 0. If it was handed out before, it is not
    /// handed out again.
    pub fn turn(&mut self) {
        match &mut self.node_times {
            NodeTimes::Even {
                origin, direction, ..
            } => {
                *origin = tick(*origin, *direction, self.index);
                *direction = -*direction;
            }
            NodeTimes::Free { direction, .. } => *direction = -*direction,
        }
        (self.index, self.ended) = (0, false);
    }

    /// Whether the current node has been handed out or passed.
    #[inline]
    #[must_use]
    pub fn is_handed_out(&self) -> bool {
        self.handed
    }

    /// Sets whether the current node counts as handed out.
    pub(crate) fn hand_out(&mut self, handed: bool) {
        self.handed = handed;
    }

    /// Whether the iterator has ended.
    pub(crate) fn has_ended(&self) -> bool {
        self.ended
    }

    /// Ends the iterator.
    pub(crate) fn end(&mut self) {
        self.ended = true;
    }

    /// Sets the current node of a run to one that it has not stepped to.
    pub(crate) fn jump(&mut self, index: u64) {
        (self.index, self.handed) = (index, true);
    }

    /// Whether the last node has been handed out.
    #[inline]
    #[allow(clippy::float_cmp)] // times are reached exactly
    pub(crate) fn has_reached(&self, end: &End) -> bool {
        self.handed
            && match end.index {
                Some(last) => self.index >= last,
                None => self.time() == end.time,
            }
    }

    /// The number of the last node at or before `t` in the direction of the run, to within rounding; `None` if it
    /// would lie before node 0, or if the method chooses its steps.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // the cast saturates, as intended
    pub(crate) fn last_index(&self, t: f64) -> Option<u64> {
        let NodeTimes::Even {
            t0,
            h,
            origin,
            direction,
        } = self.node_times
        else {
            return None;
        };
        let steps = ((t - t0) / h - origin as f64) * direction as f64;
        let rounding = 4.0 * f64::EPSILON * ((t.abs() + t0.abs()) / h.abs() + origin as f64);
        let nearest = steps.round();
        let whole = if (steps - nearest).abs() <= rounding.abs().max(f64::EPSILON) {
            nearest
        } else {
            steps.floor()
        };
        (whole >= 0.0).then_some(whole as u64)
    }
}

/// More steps than any run makes; twice the number does not overflow.
const MANY: u64 = 1 << 62;

/// The number of steps from the start to node `index`.
#[allow(clippy::cast_possible_wrap)] // less than half of the largest value
fn tick(origin: i64, direction: i64, index: u64) -> i64 {
    origin.wrapping_add(direction.wrapping_mul(index.min(MANY) as i64))
}
