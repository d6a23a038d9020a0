//! Times of nodes, by multiplication: adding up steps would add up rounding errors.

/// The numbers of nodes and their times.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Clock {
    /// The time of the start.
    t0: f64,
    /// The step that the run was set up with.
    h: f64,
    /// How many steps after the start node 0 lies.
    origin: i64,
    /// 1, or -1 while the run goes back.
    direction: i64,
}

impl Clock {
    /// The clock of a run with the step `h` whose node 0 lies at `t0`.
    pub fn new(t0: f64, h: f64) -> Self {
        Self {
            t0,
            h,
            origin: 0,
            direction: 1,
        }
    }

    /// Turns round at node `index`, which becomes number 0.
    pub fn turn(&mut self, index: u64) {
        self.origin = self.tick(index);
        self.direction = -self.direction;
    }

    /// How many steps after the start node `index` lies.
    fn tick(&self, index: u64) -> i64 {
        self.origin.saturating_add(
            self.direction
                .saturating_mul(i64::try_from(index).unwrap_or(i64::MAX)),
        )
    }

    /// The time of node `index`.
    pub fn time(&self, index: u64) -> f64 {
        self.t0 + self.tick(index) as f64 * self.h
    }

    /// The number of the last node at or before `t` in the direction of the run, to within rounding; `None` if it
    /// would lie before node 0.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a cast saturates, which is what is wanted
    pub fn last_index(&self, t: f64) -> Option<u64> {
        let steps = ((t - self.t0) / self.h - self.origin as f64) * self.direction as f64;
        let rounding = 4.0 * f64::EPSILON * ((t.abs() + self.t0.abs()) / self.h.abs() + self.origin as f64);
        let nearest = steps.round();
        let whole = if (steps - nearest).abs() <= rounding.abs().max(f64::EPSILON) {
            nearest
        } else {
            steps.floor()
        };
        (whole >= 0.0).then_some(whole as u64)
    }
}
