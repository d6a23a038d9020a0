//! Steps that end at switches.
//!
//! All steps are tried with the pieces that their series began with. If an argument changes its sign within a step, the step ends at the
//! first place where it is beyond zero, found to rounding by evaluating the declaration there. The next series belongs to the pieces
//! beyond, if its motion goes there. If it leads back, and the motion from the other side leads here, then no piece continues the motion.

use std::borrow::Cow;

use super::control::Judged;
use super::integrator::Integrator;
use super::recurrences::{Along, SeriesKernel};
use super::sticking::Sticking;
use crate::series::orders::ROWS;
use crate::series::roots::Crossing;
use crate::series::rows::Series;
use crate::series::switch::{Reach, Switch};

/// So many switches at one place are tried in all combinations.
const TOGETHER: usize = 4;

/// So many changes in a row may come without any time between them.
pub(super) const AT_ONCE: u32 = 64;

/// How often a motion goes on from several switches at one place, twice as far each time.
const CLEARINGS: u32 = 12;

/// Evaluations on the way to the place of a switch.
const EVALUATIONS: u32 = 200;

/// A step of less than this part of the time since the last switch is short, and what an argument's first terms tell of its zero so many steps ahead is
/// tried.
const SHORT: f64 = 0.01;
const AHEAD: f64 = 8.0;

/// A switch is looked for up to this part of the way to the corner of a root.
const BESIDE_CORNER: f64 = 0.99;

/// How far beyond the place that the series of an argument tells the true one is looked for, as a part of the step.
const BEYOND: f64 = 1e-3;

/// What a motion needs whose system has switches.
#[expect(
    clippy::struct_excessive_bools,
    reason = "facts that do not depend on each other"
)]
#[derive(Debug, Default)]
pub(super) struct Watch {
    /// Whether a sign may decide between pieces; else there are steep functions alone.
    pub has_pieces: bool,
    /// Whether a value has a bound, as a root has.
    pub(super) has_bounds: bool,
    crossings: Vec<Crossing>,
    touched: Vec<Touched>,
    /// The time of the last switch, or of the start.
    since: f64,
    /// How many steps in a row were too short for a clock.
    pub(super) short: u32,
    /// The switch where no piece continues the motion.
    pub stuck: Option<Cow<'static, str>>,
    /// Whether the motion is not unique beyond the current point: it is at rest, and a force leads away from it on both sides.
    pub(super) forks: bool,
    /// What rests at the current point.
    pub(super) sticking: Option<Box<Sticking>>,
    /// What rested on the last step.
    pub(super) rested: Option<Box<Sticking>>,
    /// Whether the motion begins where something rested: its argument is zero, and not to the last digit.
    pub(super) leaves: bool,
}

impl Watch {
    /// Room for crossings.
    pub(super) fn crossings(&mut self) -> &mut Vec<Crossing> {
        &mut self.crossings
    }

    /// For a system; `None` if it has no switches.
    pub(super) fn new(equations: &dyn SeriesKernel, t: f64) -> Option<Box<Self>> {
        (equations.groups() > 0).then(|| {
            Box::new(Self {
                since: t,
                has_pieces: equations.has_pieces(),
                // steps allocate nothing
                crossings: Vec::with_capacity(ROWS),
                ..Self::default()
            })
        })
    }
}

/// A switch where the motion is.
#[derive(Clone, Copy, Debug)]
struct Touched {
    group: usize,
    place: usize,
    /// The sign of the piece that led here, and the sign that its argument has from here on.
    side: f64,
    leads: f64,
}

impl Touched {
    /// A switch at its place, with the sign that its series to an order leads to in a time `tau`.
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

/// Asks something of every switch.
#[inline]
pub(super) fn each(equations: &mut dyn SeriesKernel, mut ask: impl FnMut(usize, usize, &mut Switch)) {
    for group in 0..equations.groups() {
        for (place, switch) in equations.group(group).iter_mut().enumerate() {
            ask(group, place, switch);
        }
    }
}

/// How far the nearest switch is a time `s` after the beginning of a step, in units of the size of its argument; negative beyond.
fn margin(equations: &mut dyn SeriesKernel, s: f64) -> f64 {
    let mut least = f64::INFINITY;
    each(equations, |_, _, switch| least = least.min(switch.margin(s)));
    least
}

/// How far a step may go, and whether it ends at a switch.
#[derive(Clone, Copy, Debug)]
pub(super) struct End {
    pub size: f64,
    /// The last place that is not beyond the switch.
    pub before: f64,
    pub at_switch: bool,
    /// Whether it is at the corner of a root.
    pub at_corner: bool,
}

impl End {
    /// A length, without a switch there.
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
    /// Tries the position, the velocity and the acceleration of the series a time `h` later, where the next series begins.
    #[inline]
    pub(super) fn arrive(&mut self, equations: &mut dyn SeriesKernel, h: f64, t: f64) -> Judged {
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
        equations.judge(&self.next, self.tried.a(), weights, p)
    }

    /// Whether an argument is beyond zero at the end of the step that has been tried.
    pub(super) fn is_beyond(equations: &mut dyn SeriesKernel, size: f64) -> bool {
        margin(equations, size) < 0.0
    }

    /// How far a step of the length `|h|` may go. From here on the pieces are held.
    pub(super) fn foresee(&mut self, equations: &mut dyn SeriesKernel, h: f64) -> End {
        let (order, limits) = (self.series.order(), self.control.limits);
        let mut watch = self.watch.take().unwrap_or_default();
        let (mut part, mut at_switch, mut at_corner) = (1.0, false, false);
        each(equations, |_, _, switch| {
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

    /// The end of a step at whose end an argument comes to zero, if it is just beyond a step of the length `|h|`, short as that is: the series of a power
    /// ends before the zero of its argument, and the steps that lead there become shorter and shorter.
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

    /// The place of a switch, looked for near a place that the series of an argument tells.
    pub(super) fn near(
        &mut self,
        equations: &mut dyn SeriesKernel,
        direction: f64,
        [place, whole]: [f64; 2],
    ) -> End {
        let farthest = (place + BEYOND * whole).min(whole);
        // of a step without an end, as that of a constant force, the length says nothing of the place
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
                // the argument turns back
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

    /// The first time at which an argument is beyond zero, between one at which none is and one at which one is.
    pub(super) fn locate(
        &mut self,
        equations: &mut dyn SeriesKernel,
        direction: f64,
        [mut before, mut beyond]: [f64; 2],
    ) -> End {
        let order = self.next.order();
        let mut values = [before, beyond].map(|s| self.margin_at(equations, direction * s));
        let mut left = EVALUATIONS;
        while left > 0 && beyond - before > f64::EPSILON * beyond {
            left -= 1;
            let [a, b] = values;
            // the method of Illinois, and halving where it is slow or the values are of no use
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

    /// How far the nearest switch is a time `h` later.
    fn margin_at(&mut self, equations: &mut dyn SeriesKernel, h: f64) -> f64 {
        let order = self.next.order();
        self.next.set_order(2);
        self.arrive(equations, h, self.time() + h);
        self.next.set_order(order);
        margin(equations, h.abs())
    }

    /// Goes on after a step: its end belongs to the same pieces.
    pub(super) fn go_on(&mut self, equations: &mut dyn SeriesKernel) {
        each(equations, |_, _, switch| switch.begins_with(0));
        self.is_new = false;
        if let Some(watch) = &mut self.watch {
            watch.short = 0;
        }
    }

    /// Goes over to other pieces at a switch, where a step has just ended or before one; `tau` is a time in which the motion changes, in its direction.
    pub(super) fn go_over(
        &mut self,
        equations: &mut dyn SeriesKernel,
        tau: f64,
        (is_short, is_arrival): (bool, bool),
    ) {
        let order = self.tells_to(tau);
        let Some(mut watch) = self.watch.take() else {
            return;
        };
        self.known = None;
        watch.touched.clear();
        watch.since = self.time();
        each(equations, |group, place, switch| {
            switch.begins_with(0);
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
    }

    /// Goes on until all arguments that are zero to rounding, and go over, have the signs of the pieces beyond: a root has no value on the side where the rounding of an
    /// argument may be that comes to zero at the same time as another one.
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
                    missing = missing.max(switch.missing());
                }
            }
            if missing == 0.0 || !missing.is_finite() {
                return;
            }
            least = (2.0 * least).max(2.0 * missing);
            h += least.copysign(h);
            (self.t, self.last) = (began, Some((began, h)));
            self.t.add(&[h]);
            // the state at the beginning of the step is where the next one is tried
            equations.along(&self.series, h, &self.tried, &mut self.now);
            let t = self.side(self.t.hi[0], true);
            if let Some(projection) = &mut self.projection {
                projection.apply(equations, t, &mut self.now);
            }
            equations.begin(&mut self.next, t, &self.now);
        }
    }

    /// Goes over to other pieces where a step has ended at a switch to the last digit, not beyond it, and the piece that led there has no series: a root has none at
    /// zero. Returns whether an argument is zero there.
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

    /// Whether an argument is so near to zero that it takes less than the smallest step from there.
    #[cold]
    pub(super) fn is_at_switch(equations: &mut dyn SeriesKernel, smallest: f64) -> bool {
        let mut is_at = false;
        each(equations, |_, _, switch| is_at |= switch.takes() < smallest);
        is_at
    }

    /// Whether there are pieces, and so many changes have not come at once.
    fn may_go_over(&self) -> bool {
        let watch = self.watch.as_ref();
        watch.is_some_and(|watch| watch.has_pieces && watch.short <= AT_ONCE)
    }

    /// Begins at a point where nothing is known of what led there.
    pub(super) fn begin_at_switch(&mut self, equations: &mut dyn SeriesKernel) {
        let Some(mut watch) = self.watch.take() else {
            return;
        };
        watch.stuck = None;
        watch.touched.clear();
        let order = self.next.order();
        let step = self.control.first_step(&self.next, self.order().min(order));
        let step = if step > 0.0 && step < 1e100 { step } else { 1.0 };
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

    /// Finds the pieces whose motion goes on in them, first those where the motion so far leads to.
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
                // as it came here
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

    /// Where arguments stay at zero, as between bodies that touch each other at rest, takes the pieces on whose side the series is known to its last order: that of a
    /// power is not.
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

    /// Lets arguments have the signs of their values that have jumped across zero with those that changed, as a force that is limited does where what it follows
    /// jumps; and others with these. Those that are at their places have the signs that they were given.
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

    /// Expands the motion on the other side of some switches; tells whether it stays there.
    fn goes_over(
        &mut self,
        equations: &mut dyn SeriesKernel,
        touched: &[Touched],
        over: &[bool],
        tau: f64,
    ) -> bool {
        for (touched, &over) in touched.iter().zip(over) {
            let group = equations.group(touched.group);
            // what a function compares later may be something else on the other side
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
