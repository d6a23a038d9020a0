//! Continuation of a motion beyond the corner of a root.
//!
//! The series of `√(u²)` is that of `u` or of `-u`: it leads to where it would become negative, and the other
//! one takes over there. No series can begin at this place, since the root and quotients by it lose their
//! digits there. But a series that begins some way beyond leads back to it. So the first step beyond a corner
//! has the series of its end: the one whose motion comes from the end of the last step.

use super::control::Control;
use super::integrator::{Integrator, Outcome};
use super::recurrences::SeriesKernel;
use super::state::State;
use super::watch;
use crate::number::compensated::Compensated;
use crate::series::rows::Series;
use crate::series::switch::Reach;
use crate::solve::rotation;

/// The part of a step to a corner at which it is assessed.
pub(super) const JUDGED_AT: f64 = 0.9;

/// The part of the allowed length that the first step beyond has, so that the point that leads back is found
/// in a few iterations.
const PART: f64 = 0.5;

/// Largest number of times that this point is searched closer to the corner, and of iterations each time.
const NEARER: u32 = 40;
const ROUNDS: u32 = 24;

/// Largest and least factor by which the distance is shortened if the point is not found.
const SHORTER: f64 = 0.5;
const LEAST_PART: f64 = 0.1;

/// The point is found if its series leads back to this part of the tolerance.
const FOUND: f64 = 1e-3;

/// Roots vanish at the corner, and are evaluated up to this part of the way to it.
const UP_TO: f64 = 0.98;

/// A value that comes within this part of its distance from a bound reaches it. It is searched within the next part
/// of the step, in so many sections.
const REACHED: f64 = 1e-9;
const AROUND: f64 = 0.2;
const SECTIONS: u32 = 60;

/// If a step ends closer to a corner than this many times its length, it may go to the corner itself.
const NEAR: f64 = 4.0;

impl Integrator {
    /// The distance of a corner that is not much farther than a step of the length `|h|`. Near it the last
    /// orders of the motion are rounding, and the steps that they allow would become shorter and shorter
    /// without reaching it.
    pub(super) fn comes_to_corner(&mut self, equations: &mut dyn SeriesKernel, h: f64) -> Option<f64> {
        let (order, limits) = (self.series.order(), self.control.limits);
        let mut watch = self.watch.take_if(|watch| watch.has_bounds)?;
        let mut nearest = f64::INFINITY;
        watch::each(equations, |_, _, switch| {
            if switch.is_bounded()
                && let Reach::Corner(place) = switch.reach(order, NEAR * h, &limits, watch.crossings())
            {
                nearest = nearest.min(NEAR * place * h.abs());
            }
        });
        self.watch = Some(watch);
        (nearest < f64::INFINITY).then_some(nearest)
    }

    /// Whether a value reaches its bound about a time `h` after the beginning of the step, as its series tells. A
    /// root of a square plus something small, as `√(u² + e)`, nearly vanishes and has no corner.
    #[cold]
    pub(super) fn is_corner(&self, equations: &mut dyn SeriesKernel, h: f64) -> bool {
        let mut switches = Vec::new();
        watch::each(equations, |_, _, switch| switches.push(switch.clone()));
        let mut scratch = Series::new(self.now.q().len(), 2);
        let mut distances = |s: f64| {
            let (place, a) = self.place_after(s);
            scratch.begin(place.t, &place.q, &place.v);
            scratch.expect(&a);
            equations.expand(&mut scratch);
            let mut distances = Vec::new();
            watch::each(equations, |_, _, switch| {
                distances.extend(switch.distance_from_bound());
            });
            distances
        };
        let reaches = distances(0.0).into_iter().enumerate().any(|(which, first)| {
            let [mut from, mut to] = [(1.0 - AROUND) * h, (1.0 + AROUND) * h];
            let mut distance = |s: f64| distances(s).get(which).copied().unwrap_or(f64::NAN);
            for _ in 0..SECTIONS {
                let thirds = [from + (to - from) / 3.0, to - (to - from) / 3.0];
                let [left, right] = thirds.map(&mut distance);
                if left < right {
                    to = thirds[1];
                } else {
                    from = thirds[0];
                }
            }
            // a value that is not a number is no proof of the contrary
            let least = distance(0.5 * (from + to));
            least.is_nan() || least <= REACHED * first
        });
        // the step is made with its own switches
        let mut switches = switches.into_iter();
        watch::each(equations, |_, _, switch| {
            if let Some(own) = switches.next() {
                *switch = own;
            }
        });
        reaches
    }

    /// The order of the series up to which its terms decrease after a time `h`, if the last two are as small
    /// as the tolerance requires.
    pub(super) fn tells_up_to(&self, h: f64) -> Option<usize> {
        let size = |k: usize| self.control.size(self.series.velocity_of(k));
        let way = size(0).max(size(1) * h);
        // a single term may be small by chance
        let mut least = (2, f64::INFINITY);
        let (mut power, mut before) = (h, f64::INFINITY);
        for k in 2..=self.series.order() {
            power *= h;
            let term = power * size(k);
            if term.max(before) < least.1 {
                least = (k, term.max(before));
            }
            before = term;
        }
        (least.1 <= self.control.relative() * way).then_some(least.0)
    }

    /// Moves the end of the trial step to a corner, a time `h` after its beginning, where its own series is
    /// all that is known.
    #[cold]
    pub(super) fn arrive_at_corner(&mut self, equations: &mut dyn SeriesKernel, h: f64) {
        let t = self.t.hi[0] + h;
        equations.along(&self.series, h, &self.now, &mut self.tried);
        if let Some(projection) = &mut self.projection {
            projection.apply(equations, t, &mut self.tried);
        }
        self.wait_beside_corner(t);
        self.corner = Some(h);
    }

    /// Sets the trial state, without a series there.
    fn wait_beside_corner(&mut self, t: f64) {
        self.next.begin(t, self.tried.q(), self.tried.v());
        self.next.expect(self.tried.a());
    }

    /// Makes the first step beyond a corner, after a step of the length `last`; `left` is the distance to the
    /// time `until`.
    #[cold]
    pub(super) fn step_from_corner(
        &mut self,
        equations: &mut dyn SeriesKernel,
        (until, left): (f64, f64),
        last: f64,
    ) -> Outcome {
        self.next.set_order(self.order.next());
        let natural = self.control.first_step(&self.series, self.order.current());
        let longest = if natural.is_finite() {
            natural.max(last.abs())
        } else {
            last.abs()
        };
        let mut size = PART * longest;
        let mut back = self.now.clone();
        for _ in 0..NEARER {
            match self.lead_back(equations, size.copysign(left), &mut back) {
                Ok(()) => {
                    self.go_beyond(equations, size.copysign(left), (until, left), last);
                    return Outcome::Good;
                }
                Err(part) => size *= part.clamp(LEAST_PART, 0.9),
            }
        }
        // the state is again that before the step
        self.tried.copy(&self.now);
        self.wait_beside_corner(self.t.hi[0]);
        self.corner = Some(last);
        Outcome::NotFinite
    }

    /// Expands the motion a time `h` later, so that it comes from the current point. If this fails, returns
    /// the part of that time to try.
    fn lead_back(&mut self, equations: &mut dyn SeriesKernel, h: f64, back: &mut State) -> Result<(), f64> {
        let rotations = equations.kernel().shape().rotations.clone();
        let (t, n) = (self.t.hi[0] + h, self.now.q().len());
        let Self {
            now, tried, control, ..
        } = self;
        tried.copy(now);
        let way: Vec<f64> = now.v().iter().map(|v| v * h).collect();
        tried.turn_position(&rotations, &way);
        let allowed = (FOUND * control.relative()).max(4.0 * f64::EPSILON);
        let (mut dq, mut dv) = (vec![0.0; n], vec![0.0; n]);
        let mut least = f64::INFINITY;
        for _ in 0..ROUNDS {
            if let Some(projection) = &mut self.projection {
                projection.apply(equations, t, tried);
            }
            watch::each(equations, |_, _, switch| {
                switch.set(0.0);
                switch.begins_with(0);
            });
            equations.begin(&mut self.next, t, tried);
            if !self.next.is_finite() {
                return Err(SHORTER);
            }
            equations.along(&self.next, -h, tried, back);
            for (d, [to, from]) in [(&mut dq, [now.q(), back.q()]), (&mut dv, [now.v(), back.v()])] {
                for ((d, to), from) in d.iter_mut().zip(to).zip(from) {
                    *d = to - from;
                }
            }
            rotation::difference(&rotations, [back.q(), now.q()], &mut dq);
            let error = missed(control, (&dq, &dv), (now.v(), self.next.velocity_of(1)), h);
            if error <= allowed || (error >= least && error <= 0.1 * control.relative()) {
                return self.reaches_back(equations, h);
            }
            if error.is_nan() || error > 2.0 * least {
                return Err(SHORTER);
            }
            least = least.min(error);
            for (d, dv) in dq.iter_mut().zip(&dv) {
                *d += h * dv;
            }
            tried.turn_position(&rotations, &dq);
            tried.move_velocity(&dv);
        }
        Err(SHORTER)
    }

    /// Whether the new series is accurate back to the corner, a time `h` before, and all arguments keep their
    /// signs on the way. If not, returns the part of that time to try.
    fn reaches_back(&mut self, equations: &mut dyn SeriesKernel, h: f64) -> Result<(), f64> {
        let order = self.next.order();
        let longest = self
            .control
            .first_step(&self.next, order.min(self.order.current()));
        if h.abs() > longest {
            return Err(longest / h.abs());
        }
        let limits = self.control.limits;
        let mut watch = self.watch.take().unwrap_or_default();
        let mut part = 1.0_f64;
        watch::each(equations, |_, _, switch| {
            match switch.reach(order, -UP_TO * h, &limits, watch.crossings()) {
                Reach::Whole => {}
                Reach::Shorter(shorter) => part = part.min(shorter),
                Reach::Crossing(place) | Reach::Corner(place) => part = part.min(0.9 * (1.0 - UP_TO * place)),
            }
            switch.hold();
        });
        self.watch = Some(watch);
        if part < 1.0 { Err(part) } else { Ok(()) }
    }

    /// Commits the step to the beginning of the new series, or to the time `until` if that comes before.
    fn go_beyond(&mut self, equations: &dyn SeriesKernel, h: f64, (until, left): (f64, f64), last: f64) {
        self.series.clone_from(&self.next);
        self.series.begin_later(-h);
        let is_before = left.abs() < h.abs();
        let h = if is_before { left } else { h };
        self.last = Some((self.t, h));
        self.keep(h, true);
        if is_before {
            equations.along(&self.series, h, &self.now, &mut self.tried);
            self.wait_beside_corner(until);
            self.corner = Some(last);
        }
        if h == left {
            self.t = Compensated::exact([until]);
        } else {
            self.t.add(&[h]);
        }
        core::mem::swap(&mut self.now, &mut self.tried);
        (self.known, self.is_new) = (None, true);
    }
}

/// The distance by which a motion misses a point, relative to its displacement in a time `h`.
fn missed(control: &Control, (dq, dv): (&[f64], &[f64]), (v, a): (&[f64], &[f64]), h: f64) -> f64 {
    let size = control.size(v).max(control.size(a) * h.abs());
    let by = control.size(dv).max(control.size(dq) / h.abs());
    if by == 0.0 { 0.0 } else { by / size }
}
