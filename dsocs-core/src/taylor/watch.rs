//! Steps that end at switches.
//!
//! All steps are tried with the pieces that their series began with. If an argument changes its sign within a
//! step, the step ends at the first place where it is beyond zero, located to rounding by evaluating the
//! declaration there. The next series belongs to the pieces beyond, if its motion goes there. If it leads
//! back, and the motion from the other side leads here, then no piece continues the motion.

use std::borrow::Cow;

use super::control::Assessment;
use super::integrator::Integrator;
use super::recurrences::{Along, SeriesKernel};
use super::sticking::Sticking;
use crate::regularity::sticking;
use crate::series::orders::ROWS;
use crate::series::roots::Crossing;
use crate::series::rows::Series;
use crate::series::switch::{Reach, Switch};

/// Largest number of switches at one place that are tried in all combinations.
const TOGETHER: usize = 4;

/// Largest number of consecutive changes without time between them.
pub(super) const AT_ONCE: u32 = 64;

/// Number of times that a motion is moved on from several switches at one place, twice as far each time.
const CLEARINGS: u32 = 12;

/// An argument that takes more than this part of the step to come to the sign of its piece is not kept from it by rounding: it stays at zero, as along
/// the curve on which a control switches.
const CLEARS: f64 = 1e-8;

/// Largest number of evaluations to locate a switch.
const EVALUATIONS: u32 = 200;

/// A step below this part of the time since the last switch is short; then a zero that an argument's first terms predict within [`AHEAD`]
/// such steps is tried.
const SHORT: f64 = 0.01;
const AHEAD: f64 = 8.0;

/// The part of the way to the corner of a root in which switches are searched.
const BESIDE_CORNER: f64 = 0.99;

/// Distance beyond the predicted place of a switch within which the true one is searched, as a part of the
/// step.
const BEYOND: f64 = 1e-3;

/// The state of a motion whose system has switches.
#[expect(
    clippy::struct_excessive_bools,
    reason = "facts that do not depend on each other"
)]
#[derive(Debug, Default)]
pub(super) struct Watch {
    /// Whether a sign may select a piece; else there are steep functions alone.
    pub has_pieces: bool,
    /// Whether the declaration depends on time. Then an argument is known at times that are representable
    /// alone, and steps end at these: between them its zero would be found where the rounded time has it,
    /// and lost there again.
    depends_on_time: bool,
    /// Whether a value is bounded, as a root is.
    pub(super) has_bounds: bool,
    crossings: Vec<Crossing>,
    touched: Vec<Touched>,
    /// The time of the last switch, or of the start.
    since: f64,
    /// The number of consecutive steps that were shorter than the rounding of the time.
    pub(super) short: u32,
    /// The switch where no piece continues the motion.
    pub stuck: Option<Cow<'static, str>>,
    /// Whether the motion is not unique beyond the current point.
    pub(super) forks: bool,
    /// The resting state at the current point.
    pub(super) sticking: Option<Box<Sticking>>,
    /// The resting state of the last step.
    pub(super) rested: Option<Box<Sticking>>,
    /// Whether the motion begins where a body was released: its argument is zero, but not to the last digit.
    pub(super) leaves: bool,
}

impl Watch {
    /// The workspace for crossings.
    pub(super) fn crossings(&mut self) -> &mut Vec<Crossing> {
        &mut self.crossings
    }

    /// Whether an argument was zero where the motion began, or at its last event.
    pub(super) fn touches(&self) -> bool {
        !self.touched.is_empty()
    }

    /// The state for a system; `None` if it has no switches.
    pub(super) fn new(equations: &dyn SeriesKernel, t: f64) -> Option<Box<Self>> {
        (equations.groups() > 0).then(|| {
            Box::new(Self {
                since: t,
                has_pieces: equations.has_pieces(),
                depends_on_time: equations.declaration().shape().depends_on_time,
                // steps allocate nothing
                crossings: Vec::with_capacity(ROWS),
                ..Self::default()
            })
        })
    }
}

/// A switch at the current point.
#[derive(Clone, Copy, Debug)]
struct Touched {
    group: usize,
    place: usize,
    /// The sign of the piece before the point, and the sign of its argument after it.
    side: f64,
    leads: f64,
}

impl Touched {
    /// A switch at the current point, with the sign that its series to an order has after a time `tau`.
    fn new((group, place): (usize, usize), switch: &Switch, order: usize, tau: f64) -> Self {
        let (_, leads) = switch.leads(order, tau);
        Self {
            group,
            place,
            side: switch.side(),
            leads,
        }
    }
}

/// Calls `ask` with every switch.
#[inline]
pub(super) fn each(equations: &mut dyn SeriesKernel, mut ask: impl FnMut(usize, usize, &mut Switch)) {
    for group in 0..equations.groups() {
        for (place, switch) in equations.group(group).iter_mut().enumerate() {
            ask(group, place, switch);
        }
    }
}

/// The distance of the nearest switch at the time `s` of a step, in units of its argument's size; negative
/// beyond.
fn margin(equations: &mut dyn SeriesKernel, s: f64) -> f64 {
    let mut least = f64::INFINITY;
    each(equations, |_, _, switch| least = least.min(switch.margin(s)));
    least
}

/// The end of a step, and whether it is at a switch.
#[derive(Clone, Copy, Debug)]
pub(super) struct End {
    pub size: f64,
    /// The last place before the switch.
    pub before: f64,
    pub at_switch: bool,
    /// Whether it is at the corner of a root.
    pub at_corner: bool,
}

impl End {
    /// An end at a given length, without a switch.
    #[inline]
    pub fn of(size: f64) -> Self {
        Self {
            size,
            before: size,
            at_switch: false,
            at_corner: false,
        }
    }
}

impl Integrator {
    /// Evaluates the series a time `h` later, and begins the next series there.
    #[inline]
    pub(super) fn arrive(&mut self, equations: &mut dyn SeriesKernel, h: f64, t: f64) -> Assessment {
        let end = self.side(t, false);
        let (weights, p) = (self.control.weights(), self.order.current());
        let Some(projection) = &mut self.projection else {
            let step = Along {
                series: &self.series,
                h,
                from: &self.now,
                to: &mut self.tried,
                t: end,
                weights,
                p,
            };
            return equations.arrive(step, &mut self.next);
        };
        equations.along(&self.series, h, &self.now, &mut self.tried);
        projection.apply(equations, t, &mut self.tried);
        equations.begin(&mut self.next, end, &self.tried);
        equations.assess(&self.next, self.tried.a(), weights, p)
    }

    /// Whether an argument is beyond zero at the end of the trial step.
    pub(super) fn is_beyond(equations: &mut dyn SeriesKernel, size: f64) -> bool {
        margin(equations, size) < 0.0
    }

    /// The part of a step of the length `|h|` that may be taken; not less for corners, unless they are wanted. From
    /// here on the pieces are held.
    pub(super) fn foresee(&mut self, equations: &mut dyn SeriesKernel, h: f64, wants_corners: bool) -> End {
        let (order, limits) = (self.series.order(), self.control.limits);
        let mut watch = self.watch.take().unwrap_or_default();
        let (mut part, mut at_switch, mut at_corner) = (1.0, false, false);
        each(equations, |_, _, switch| {
            if switch.is_bounded() && !wants_corners {
                return;
            }
            // a corner and a switch may be at the same place
            let at_most = if at_corner { BESIDE_CORNER * part } else { part };
            match switch.reach(order, h * at_most, &limits, &mut watch.crossings) {
                Reach::Whole => {}
                Reach::Shorter(place) => (part, at_switch, at_corner) = (at_most * place, false, false),
                Reach::Crossing(place) => (part, at_switch, at_corner) = (at_most * place, true, false),
                Reach::Corner(place) => (part, at_switch, at_corner) = (at_most * place, false, true),
            }
            watch.has_bounds |= switch.is_bounded();
            switch.hold();
        });
        self.watch = Some(watch);
        let (whole, size) = (h.abs(), part * h.abs());
        if at_switch {
            self.near(equations, h.signum(), [size, whole])
        } else {
            End {
                at_corner,
                ..End::of(size)
            }
        }
    }

    /// The end of a step at an argument's zero, if that is just beyond a short step of the length `|h|`: the
    /// series of a power is not valid beyond the zero of its argument, and the steps towards it become
    /// shorter and shorter.
    pub(super) fn ends_at_zero(&mut self, equations: &mut dyn SeriesKernel, h: f64) -> Option<f64> {
        let since = self.watch.as_ref().map_or(f64::NAN, |watch| watch.since);
        let is_short = h.abs() < SHORT * (self.time() - since).abs();
        if !is_short {
            return None;
        }
        let mut nearest = f64::INFINITY;
        each(equations, |_, _, switch| {
            nearest = nearest.min(switch.ends(h.signum()));
        });
        (nearest > h.abs() && nearest < AHEAD * h.abs()).then_some(nearest)
    }

    /// The place of a switch, searched near the place that the series of an argument predicts.
    pub(super) fn near(
        &mut self,
        equations: &mut dyn SeriesKernel,
        direction: f64,
        [place, whole]: [f64; 2],
    ) -> End {
        let farthest = (place + BEYOND * whole).min(whole);
        // for a step of unlimited length, as with a constant force, the length is no scale for the place
        let length = whole.min(place / f64::EPSILON.sqrt());
        let mut width = 64.0 * f64::EPSILON * place + f64::EPSILON * BEYOND * length;
        width = width.max(f64::MIN_POSITIVE);
        let (mut before, mut beyond) = ((place - width).max(0.0), (place + width).min(farthest));
        let mut left = EVALUATIONS;
        loop {
            if self.margin_at(equations, direction * beyond) < 0.0 {
                break;
            }
            if beyond >= farthest {
                // no change of sign up to here
                return End::of(beyond);
            }
            width *= 8.0;
            (before, beyond) = (beyond, (beyond + width).min(farthest));
        }
        while before > 0.0 && left > 0 && self.margin_at(equations, direction * before) < 0.0 {
            width *= 8.0;
            left -= 1;
            (before, beyond) = ((before - width).max(0.0), before);
        }
        self.locate(equations, direction, [before, beyond])
    }

    /// The first time at which an argument is beyond zero, between one at which none is and one at which one
    /// is.
    pub(super) fn locate(
        &mut self,
        equations: &mut dyn SeriesKernel,
        direction: f64,
        [mut before, mut beyond]: [f64; 2],
    ) -> End {
        let order = self.next.order();
        let mut values = [before, beyond].map(|s| self.margin_at(equations, direction * s));
        let mut left = EVALUATIONS;
        let rounding = self.rounding_of_time();
        while left > 0 && beyond - before > rounding.max(f64::EPSILON * beyond) {
            left -= 1;
            let [a, b] = values;
            // the Illinois method, and bisection where it is slow or the values are useless
            let secant = before + (beyond - before) * (a / (a - b));
            let inside = secant > before && secant < beyond && a > 0.0 && !left.is_multiple_of(4);
            let middle = if inside { secant } else { 0.5 * (before + beyond) };
            if middle <= before || middle >= beyond {
                break;
            }
            let value = self.margin_at(equations, direction * middle);
            if value < 0.0 {
                (beyond, values) = (middle, [0.5 * a, value]);
            } else {
                (before, values) = (middle, [value, 0.5 * b]);
            }
        }
        self.next.set_order(order);
        End {
            size: beyond,
            before,
            at_switch: true,
            at_corner: false,
        }
    }

    /// The distance of the nearest switch a time `h` later.
    fn margin_at(&mut self, equations: &mut dyn SeriesKernel, h: f64) -> f64 {
        let order = self.next.order();
        self.next.set_order(2);
        let h = self.representable(h);
        self.arrive(equations, h, self.time() + h);
        self.next.set_order(order);
        margin(equations, h.abs())
    }

    /// The length nearest to `h` of a step to a representable time, where the declaration depends on time;
    /// else, and for steps shorter than the rounding of the time, `h` itself.
    #[inline]
    pub(super) fn representable(&self, h: f64) -> f64 {
        if self.rounding_of_time() == 0.0 {
            return h;
        }
        let t = &self.t;
        let length = (t.hi[0] + h - t.hi[0]) - t.lo[0];
        if length * h > 0.0 { length } else { h }
    }

    /// The distance of two representable times, at most, where the declaration depends on time; else zero.
    pub(super) fn rounding_of_time(&self) -> f64 {
        match &self.watch {
            Some(watch) if watch.depends_on_time => f64::EPSILON * self.time().abs(),
            _ => 0.0,
        }
    }

    /// Continues after a step whose end belongs to the same pieces.
    pub(super) fn go_on(&mut self, equations: &mut dyn SeriesKernel) {
        each(equations, |_, _, switch| switch.begins_with(0));
        self.is_new = false;
        if let Some(watch) = &mut self.watch {
            watch.short = 0;
        }
    }

    /// Enters other pieces at a switch, at the end of a step or before one; `tau` is a time scale of the
    /// motion, in its direction.
    pub(super) fn go_over(
        &mut self,
        equations: &mut dyn SeriesKernel,
        tau: f64,
        (is_short, is_arrival): (bool, bool),
    ) {
        let (order, rounding) = (self.tells_to(tau), self.rounding_of_time());
        let Some(mut watch) = self.watch.take() else {
            return;
        };
        self.known = None;
        watch.touched.clear();
        watch.since = self.time();
        // the rounding of a velocity may be larger than all that an argument changes in a short step
        let (t, q, v) = (self.t.hi[0], self.now.q(), self.now.v());
        let roundings = sticking::roundings(&equations.declaration(), t, q, v);
        // the series has its arguments in another order
        let error_of = |argument: f64| {
            let same = |known: &&[f64; 2]| (known[0] - argument).abs() <= known[1];
            roundings.iter().find(same).map_or(0.0, |known| known[1])
        };
        each(equations, |group, place, switch| {
            switch.begins_with(0);
            switch.blur(2.0 * rounding);
            switch.known_to(error_of(switch.value()));
            if switch.touches() {
                watch
                    .touched
                    .push(Touched::new((group, place), switch, order, tau));
            }
        });
        if is_arrival && watch.touched.len() > 1 {
            self.clear(equations, &watch.touched);
        }
        self.is_new = true;
        watch.short = if is_short { watch.short + 1 } else { 0 };
        self.decide(equations, &mut watch, tau);
        self.watch = Some(watch);
        self.look_for_forks(equations, Some(tau));
    }

    /// Moves on until all arguments that are zero to rounding, and change their sign, have the signs of the
    /// pieces beyond: a root has no value if the argument of another function that vanishes at the same time
    /// is on the wrong side by rounding.
    #[cold]
    fn clear(&mut self, equations: &mut dyn SeriesKernel, touched: &[Touched]) {
        let Some((began, mut h)) = self.last else {
            return;
        };
        let mut least = 0.0_f64;
        for _ in 0..CLEARINGS {
            let mut missing = 0.0_f64;
            for touched in touched.iter().filter(|touched| touched.leads == -touched.side) {
                if let Some(switch) = equations.group(touched.group).get(touched.place) {
                    let takes = switch.missing();
                    if takes <= CLEARS * h.abs() {
                        missing = missing.max(takes);
                    }
                }
            }
            if missing == 0.0 || !missing.is_finite() {
                return;
            }
            least = (2.0 * least).max(2.0 * missing);
            h += least.copysign(h);
            (self.t, self.last) = (began, Some((began, h)));
            self.t.add(&[h]);
            // the next step is tried from the state at the beginning of this one
            equations.along(&self.series, h, &self.tried, &mut self.now);
            let t = self.side(self.t.hi[0], true);
            if let Some(projection) = &mut self.projection {
                projection.apply(equations, t, &mut self.now);
            }
            equations.begin(&mut self.next, t, &self.now);
        }
    }

    /// Enters other pieces if a step has ended exactly at a switch and the old piece has no series there, as
    /// a root at zero. Returns whether an argument is zero there.
    #[cold]
    pub(super) fn goes_over_here(&mut self, equations: &mut dyn SeriesKernel) -> bool {
        let (true, Some((_, last))) = (self.may_go_over(), self.last) else {
            return false;
        };
        equations.expand(&mut self.next);
        let mut touches = false;
        each(equations, |_, _, switch| touches |= switch.touches());
        if touches {
            self.go_over(equations, last, (true, false));
        }
        touches
    }

    /// Whether an argument is so close to zero that it takes less than the smallest step to get there.
    #[cold]
    pub(super) fn is_at_switch(equations: &mut dyn SeriesKernel, smallest: f64) -> bool {
        let mut is_at = false;
        each(equations, |_, _, switch| is_at |= switch.takes() < smallest);
        is_at
    }

    /// Whether there are pieces, and not too many changes have come at once.
    fn may_go_over(&self) -> bool {
        let watch = self.watch.as_ref();
        watch.is_some_and(|watch| watch.has_pieces && watch.short <= AT_ONCE)
    }

    /// Begins at a point without a step that led to it.
    pub(super) fn begin_at_switch(&mut self, equations: &mut dyn SeriesKernel) {
        let Some(mut watch) = self.watch.take() else {
            return;
        };
        watch.stuck = None;
        watch.touched.clear();
        let order = self.next.order();
        let step = self.scale_of_series().unwrap_or(1.0);
        let tau = if self.clock.is_forward() { step } else { -step };
        each(equations, |group, place, switch| {
            if switch.is_zero() || (watch.leaves && switch.may_turn() && switch.leads(order, tau).0 > 0) {
                watch
                    .touched
                    .push(Touched::new((group, place), switch, order, tau));
            }
        });
        if !watch.touched.is_empty() {
            each(equations, |_, _, switch| switch.hold());
            equations.expand(&mut self.next);
            for touched in &mut watch.touched {
                if let Some(switch) = equations.group(touched.group).get(touched.place) {
                    (_, touched.leads) = switch.leads(order, tau);
                }
            }
            self.decide(equations, &mut watch, tau);
        }
        self.watch = Some(watch);
    }

    /// Finds the pieces that continue the motion, beginning with those to which the motion so far leads.
    fn decide(&mut self, equations: &mut dyn SeriesKernel, watch: &mut Watch, tau: f64) {
        let count = watch.touched.len().min(TOGETHER);
        let first = watch
            .touched
            .iter()
            .map(|touched| touched.leads == -touched.side)
            .collect::<Vec<_>>();
        if first.contains(&true) {
            let others = (0..1_usize << count).map(|mask| {
                let mut over = first.clone();
                for (place, over) in over.iter_mut().enumerate().take(count) {
                    *over = mask >> place & 1 == 1;
                }
                over
            });
            let goes_on = core::iter::once(first.clone())
                .chain(others)
                .any(|over| self.goes_over(equations, &watch.touched, &over, tau));
            if !goes_on || watch.short > AT_ONCE {
                // restores the pieces of the arrival
                self.goes_over(equations, &watch.touched, &vec![false; first.len()], tau);
                let over = watch.touched.iter().zip(&first).find(|(_, over)| **over);
                watch.stuck = over.map(|(touched, _)| equations.switch(touched.group, touched.place));
            }
        }
        self.take_known_pieces(equations, &watch.touched);
        let order = self.tells_to(tau);
        for touched in &watch.touched {
            if let Some(switch) = equations.group(touched.group).get_mut(touched.place) {
                let (leading, _) = switch.leads(order, tau);
                switch.begins_with(leading);
            }
        }
        each(equations, |_, _, switch| switch.hold());
        if equations.enter() {
            equations.expand(&mut self.next);
        }
    }

    /// If arguments stay at zero, as between bodies that touch each other at rest, takes the pieces for which
    /// the series is finite to its last order; that of a power is not.
    fn take_known_pieces(&mut self, equations: &mut dyn SeriesKernel, touched: &[Touched]) {
        let known = self.next.in_range_to();
        if known >= self.next.order() {
            return;
        }
        let mut turn = |next: &mut Series| {
            let mut any = false;
            for touched in touched {
                let group = equations.group(touched.group);
                if let Some(switch) = group.get_mut(touched.place).filter(|switch| switch.stays()) {
                    switch.set(-switch.side());
                    any = true;
                }
            }
            if any {
                equations.expand(next);
            }
            any
        };
        if turn(&mut self.next) && self.next.in_range_to() <= known {
            turn(&mut self.next);
        }
    }

    /// Sets the signs of arguments to those of their values, if these have jumped across zero with the change
    /// of others, as a saturated force does if its input jumps; repeated for those that depend on these.
    /// Arguments at their zeros keep the given signs.
    fn let_go(&mut self, equations: &mut dyn SeriesKernel, touched: &[Touched]) {
        for _ in 0..equations.switches() {
            let mut any = false;
            each(equations, |group, place, switch| {
                let is_given = touched.iter().any(|at| (at.group, at.place) == (group, place));
                any |= !is_given && switch.lets_go();
            });
            if !any {
                return;
            }
            equations.expand(&mut self.next);
        }
    }

    /// Expands the motion on the other side of some switches; returns whether it stays there.
    fn goes_over(
        &mut self,
        equations: &mut dyn SeriesKernel,
        touched: &[Touched],
        over: &[bool],
        tau: f64,
    ) -> bool {
        for (touched, &over) in touched.iter().zip(over) {
            let group = equations.group(touched.group);
            // the later comparisons of a function may be different ones on the other side
            if over && touched.group > 0 {
                for later in group.iter_mut().skip(touched.place + 1) {
                    later.set(0.0);
                }
            }
            if let Some(switch) = group.get_mut(touched.place) {
                switch.set(if over { -touched.side } else { touched.side });
            }
        }
        equations.expand(&mut self.next);
        self.let_go(equations, touched);
        let order = self.tells_to(tau);
        touched.iter().all(|touched| {
            let switch = equations.group(touched.group).get(touched.place);
            switch.is_none_or(|switch| {
                let (_, leads) = switch.leads(order, tau);
                leads == 0.0 || leads == switch.side()
            })
        })
    }
}
