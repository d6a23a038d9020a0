//! The end of a run up to a time.

use super::error::{RunError, TimeBehind};
use crate::kernel::clock::{Clock, End};

impl Clock {
    /// The end of a run up to the time `t`: the last node at or before it (at or after, back in time). A node
    /// whose time is `t` to within rounding counts as at `t`: 500 with the step 0.1 is node 5000. Infinite
    /// times are allowed.
    ///
    /// # Errors
    ///
    /// [`RunError::Until`] if `t` is not a number, [`RunError::TimeBehind`] if that node lies behind the current one.
    pub fn until(&self, t: f64) -> Result<End, RunError> {
        if t.is_nan() {
            return Err(RunError::Until { until: t });
        }
        let behind = || {
            RunError::time_behind(TimeBehind {
                until: t,
                time: self.time(),
                h: self.step(),
            })
        };
        if self.step().is_none() {
            let ahead = if self.is_forward() {
                t >= self.time()
            } else {
                t <= self.time()
            };
            return if ahead {
                Ok(End { index: None, time: t })
            } else {
                Err(behind())
            };
        }
        // nodes that have been handed out cannot be undone
        match self.last_index(t) {
            Some(last) if last >= self.index() => Ok(End {
                index: Some(last),
                time: if t.is_infinite() { t } else { self.time_of(last) },
            }),
            _ => Err(behind()),
        }
    }
}
