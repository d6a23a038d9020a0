//! Times at which steps end, because the motion has no series there.

use super::integrator::Integrator;

impl Integrator {
    /// The next knot in the direction of the run, if it comes before a time; else that time.
    pub(super) fn before_knot(&self, until: f64) -> f64 {
        if self.knots.is_empty() {
            return until;
        }
        let now = self.t.hi[0];
        if self.clock.is_forward() {
            let next = self.knots.partition_point(|&knot| knot <= now);
            self.knots.get(next).map_or(until, |knot| knot.min(until))
        } else {
            let next = self.knots.partition_point(|&knot| knot < now);
            let knot = next.checked_sub(1).and_then(|next| self.knots.get(next));
            knot.map_or(until, |knot| knot.max(until))
        }
    }

    /// Whether a time is a knot.
    #[inline]
    pub(super) fn is_knot(&self, t: f64) -> bool {
        !self.knots.is_empty() && self.knots.binary_search_by(|knot| knot.total_cmp(&t)).is_ok()
    }

    /// A time seen from ahead or from behind, in the direction of the run, so that piecewise functions of
    /// time use the right piece at a knot.
    pub(super) fn side(&self, t: f64, ahead: bool) -> f64 {
        if self.is_knot(t) && ahead != self.clock.is_forward() {
            t.next_down()
        } else {
            t
        }
    }

    /// Adds knots.
    pub(super) fn add_knots(&mut self, knots: impl IntoIterator<Item = f64>) {
        self.knots
            .extend(knots.into_iter().filter(|knot| knot.is_finite()));
        self.knots.sort_by(f64::total_cmp);
    }
}
