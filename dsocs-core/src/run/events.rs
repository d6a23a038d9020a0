//! Changes of sign of functions of the motion.

use core::cell::RefCell;
use core::ops::ControlFlow;

use super::error::{FailedEvent, RunError};
use super::{AnyObserver, AnyPolynomial, LastLeg};
use crate::number::point::Point;
use crate::number::point::{AnyPoint, OwnedPoint, sized};
use crate::series::jet::{Call, Jet};
use crate::series::orders::MAX_ORDER;
use crate::series::roots::{self, Crossing};
use crate::tape::declaration::Declaration;

/// A change of sign closer than this to the start of a part, relative to the part's length, may be the last one of the part before.
const JOINT: f64 = 1e-9;

/// Half the length of the first part about a corner or a jump, relative to the polynomial: on it the function itself is evaluated.
const GAP: f64 = 1e-12;

/// Factor of the length of a part that has not passed a corner.
const WIDER: f64 = 16.0;

/// A series and its function that differ by more than this part of the largest term have a corner or a jump between them.
const APART: f64 = 1e-6;

/// The longest part about a corner, relative to the polynomial, on which a function may have no series.
const HOLE: f64 = 1e-6;

/// The largest number of corners and jumps of a function on a polynomial; beyond it the function is rounding.
const CORNERS: usize = 64;

/// A function of position, velocity and acceleration.
type Function<'e> = Box<dyn Fn(AnyPoint<'_, Jet>) -> Jet + 'e>;

/// The function of an event.
enum Source<'e> {
    Observable(usize),
    Function(Function<'e>),
}

/// The direction in which a change of sign counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Direction {
    Rising,
    Falling,
    Both,
}

/// An [`Event`] for any number of coordinates.
pub struct AnyEvent<'e> {
    source: Source<'e>,
    direction: Direction,
    terminal: bool,
}

impl core::fmt::Debug for AnyEvent<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Event")
            .field("direction", &self.direction)
            .field("terminal", &self.terminal)
            .finish_non_exhaustive()
    }
}

impl<'e> AnyEvent<'e> {
    fn of(source: Source<'e>) -> Self {
        Self {
            source,
            direction: Direction::Both,
            terminal: false,
        }
    }

    /// An observed expression of the declaration, by its place; see [`Event::observable`].
    #[must_use]
    pub fn observable(index: usize) -> Self {
        Self::of(Source::Observable(index))
    }

    /// A function of position, velocity and acceleration.
    #[must_use]
    pub fn function(function: impl Fn(AnyPoint<'_, Jet>) -> Jet + 'e) -> Self {
        Self::of(Source::Function(Box::new(function)))
    }

    /// Counts only changes from negative to positive, in the direction of the run.
    #[must_use]
    pub fn rising(mut self) -> Self {
        self.direction = Direction::Rising;
        self
    }

    /// Counts only changes from positive to negative, in the direction of the run.
    #[must_use]
    pub fn falling(mut self) -> Self {
        self.direction = Direction::Falling;
        self
    }

    /// Ends the run at the event.
    #[must_use]
    pub fn terminal(mut self) -> Self {
        self.terminal = true;
        self
    }

    /// The function at a point of jets.
    pub(super) fn at(&self, declaration: &Declaration<'_>, point: AnyPoint<'_, Jet>) -> Jet {
        match &self.source {
            Source::Function(function) => function(point),
            Source::Observable(index) => {
                let mut observed = vec![Jet::from(f64::NAN); declaration.shape().observables.len()];
                declaration.observe(point, &mut observed);
                observed.get(*index).copied().unwrap_or(Jet::from(f64::NAN))
            }
        }
    }

    /// The function at the time `s` after the point of expansion.
    fn value(
        &self,
        declaration: &Declaration<'_>,
        polynomial: &AnyPolynomial<'_>,
        s: f64,
        work: &mut EventWorkspace,
    ) -> f64 {
        let mut point = core::mem::replace(&mut work.point, OwnedPoint::zero(0));
        polynomial.point(s, &mut point);
        let value = self.value_at(declaration, &point, work);
        work.point = point;
        value
    }

    /// The function at a point.
    pub(super) fn value_at(
        &self,
        declaration: &Declaration<'_>,
        point: &OwnedPoint<f64>,
        work: &mut EventWorkspace,
    ) -> f64 {
        let jets = point.map(Jet::from);
        // a user's function with unknown higher orders has a value, too
        work.call.begin(|| self.at(declaration, jets.any()))
    }

    /// Whether a change of sign counts.
    fn counts(&self, rising: bool) -> bool {
        match self.direction {
            Direction::Both => true,
            Direction::Rising => rising,
            Direction::Falling => !rising,
        }
    }
}

/// A change of sign of a function `g(q, v, a)` along the motion, for every method ([`crate::Stepper::watch`]).
///
/// The function is evaluated on Taylor series ([`Jet`]). From its series all changes of sign within a step are found. A function with corners or
/// jumps is searched piece by piece, and a jump through zero is a change of sign.
pub struct Event<'e, const N: usize>(AnyEvent<'e>);

impl<const N: usize> core::fmt::Debug for Event<'_, N> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        self.0.fmt(f)
    }
}

impl<'e, const N: usize> Event<'e, N> {
    /// An observed expression of the declaration, by its index in [`crate::System::OBSERVABLES`]. The expression may not call Rust functions of
    /// your own: in observed expressions these are called with plain numbers only.
    #[must_use]
    pub fn observable(index: usize) -> Self {
        Self(AnyEvent::observable(index))
    }

    /// A function of position, velocity and acceleration. A [`Jet`] has the functions of [`crate::Real`], and a plain number may stand on either
    /// side of an operator: `Event::function(|p| 2.9 + p.q[2])`.
    #[must_use]
    pub fn function(function: impl Fn(&Point<Jet, N>) -> Jet + 'e) -> Self {
        Self(AnyEvent::function(move |point| function(&Point::of(point))))
    }

    /// Counts only changes from negative to positive, in the direction of the run.
    #[must_use]
    pub fn rising(self) -> Self {
        Self(self.0.rising())
    }

    /// Counts only changes from positive to negative, in the direction of the run.
    #[must_use]
    pub fn falling(self) -> Self {
        Self(self.0.falling())
    }

    /// Ends the run where the event happens.
    #[must_use]
    pub fn terminal(self) -> Self {
        Self(self.0.terminal())
    }
}

/// An event that happened.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Occurrence<const N: usize> {
    /// The index of the event among those watched.
    pub event: usize,
    /// Whether the function became positive, in the direction of the run.
    pub rising: bool,
    /// The time.
    pub t: f64,
    /// Position.
    pub q: [f64; N],
    /// Velocity.
    pub v: [f64; N],
    /// Acceleration.
    pub a: [f64; N],
}

impl<const N: usize> Occurrence<N> {
    /// An event with its number of coordinates.
    pub(crate) fn of(any: &AnyOccurrence) -> Self {
        let AnyPoint { t, q, v, a } = any.point();
        Self {
            event: any.event,
            rising: any.rising,
            t,
            q: sized(q),
            v: sized(v),
            a: sized(a),
        }
    }

    /// Position, velocity and acceleration, as [`crate::System::observe`] and [`crate::System::constraint_force`] take them.
    #[must_use]
    pub fn point(&self) -> Point<f64, N> {
        Point {
            t: self.t,
            q: self.q,
            v: self.v,
            a: self.a,
        }
    }
}

/// An [`Occurrence`] with any number of coordinates.
#[derive(Clone, Debug)]
pub struct AnyOccurrence {
    /// The index of the event among those watched.
    pub event: usize,
    /// Whether the function became positive, in the direction of the run.
    pub rising: bool,
    /// Time, position, velocity and acceleration.
    point: OwnedPoint<f64>,
}

impl AnyOccurrence {
    /// Time, position, velocity and acceleration.
    #[must_use]
    pub fn point(&self) -> AnyPoint<'_, f64> {
        self.point.any()
    }
}

/// Events that are watched, with the last sign of each function.
#[derive(Debug)]
pub struct Events<'e, const N: usize> {
    /// The events for any number of coordinates.
    pub(super) any: AnyEvents<'e>,
}

impl<'e, const N: usize> Events<'e, N> {
    /// The events; occurrences refer to them by index.
    #[must_use]
    pub fn new(events: Vec<Event<'e, N>>) -> Self {
        Self {
            any: AnyEvents::new(events.into_iter().map(|event| event.0).collect()),
        }
    }

    /// The events for a run that was watched with other events before; see [`AnyEvents::after`].
    ///
    /// ```
    /// use dsocs_core::prelude::*;
    ///
    /// /// A particle.
    /// #[dsocs { coordinates(x); lagrangian = dot(x).powi(2) / 2; }]
    /// struct Particle {}
    ///
    /// let mut flow = Flow::new(&Particle {}, 0.25, Start::second_order([0.0], [1.0]))?;
    /// let at_one = || Event::function(|point| point.q[0] - 1.0);
    /// let mut times = Vec::new();
    /// let mut watched = Events::new(vec![at_one()]);
    /// flow.watch(1.0, &mut watched, &mut on_event(|found: &Occurrence<1>| times.push(found.t)))?;
    /// let mut watched = Events::new(vec![at_one()]).after(watched.last_leg());
    /// flow.watch(2.0, &mut watched, &mut on_event(|found: &Occurrence<1>| times.push(found.t)))?;
    /// assert_eq!(times, [1.0]);
    /// # Ok::<(), dsocs_core::RunError>(())
    /// ```
    #[must_use]
    pub fn after(self, leg: LastLeg) -> Self {
        Self {
            any: self.any.after(leg),
        }
    }

    /// The motion to the node up to which a run was watched last; see [`AnyEvents::last_leg`].
    #[must_use]
    pub fn last_leg(self) -> LastLeg {
        self.any.last_leg()
    }
}

/// The workspace of event functions.
#[derive(Debug)]
pub(super) struct EventWorkspace {
    pub(super) call: Call,
    point: OwnedPoint<f64>,
}

/// [`Events`] of any number of coordinates.
#[derive(Debug)]
pub struct AnyEvents<'e> {
    pub(super) watched: Vec<AnyEvent<'e>>,
    pub(super) sides: Vec<f64>,
    pub(super) work: EventWorkspace,
    crossings: Vec<Crossing>,
    pub(super) found: Vec<(f64, usize, bool)>,
    /// The motion to the current node of the run.
    pub(super) leg: LastLeg,
}

impl<'e> AnyEvents<'e> {
    /// The events; occurrences refer to them by index.
    #[must_use]
    pub fn new(events: Vec<AnyEvent<'e>>) -> Self {
        let sides = vec![0.0; events.len()];
        Self {
            watched: events,
            sides,
            work: EventWorkspace {
                call: Call::default(),
                point: OwnedPoint::zero(0),
            },
            crossings: Vec::new(),
            found: Vec::new(),
            leg: LastLeg::default(),
        }
    }

    /// The events for a run that was watched with other events before and has not moved since, with their
    /// [`AnyEvents::last_leg`]: so events at the current node, and those after an event that ended the run
    /// before it, are found.
    #[must_use]
    pub fn after(mut self, leg: LastLeg) -> Self {
        self.leg = leg;
        self
    }

    /// The motion to the node up to which a run was watched last.
    #[must_use]
    pub fn last_leg(self) -> LastLeg {
        self.leg
    }

    /// Reports the events on a polynomial, in order, up to one that ends the run, whose time since the point
    /// of expansion is returned. Simultaneous events are reported before it.
    pub(super) fn happen(
        &mut self,
        declaration: &Declaration<'_>,
        polynomial: &AnyPolynomial<'_>,
        observer: &mut dyn AnyObserver,
    ) -> Result<Option<(f64, AnyOccurrence)>, RunError> {
        self.search(declaration, polynomial)?;
        self.order_by_end(polynomial);
        let together = JOINT * polynomial.length().abs();
        let mut ended: Option<(f64, AnyOccurrence)> = None;
        for &(s, event, rising) in &self.found {
            if ended.as_ref().is_some_and(|(end, _)| (s - end).abs() > together) {
                break;
            }
            self.sides[event] = if rising { 1.0 } else { -1.0 };
            if !self.watched[event].counts(rising) {
                continue;
            }
            let mut occurrence = AnyOccurrence {
                event,
                rising,
                point: OwnedPoint::zero(declaration.dimension()),
            };
            polynomial.point(s, &mut occurrence.point);
            if report_event(&self.watched, &occurrence, observer).is_break() {
                ended = Some((s, occurrence));
            }
        }
        self.leg
            .take(polynomial, ended.as_ref().map(|(s, _)| *s), together);
        Ok(ended)
    }

    /// Moves events that are simultaneous with the first terminal one before it.
    fn order_by_end(&mut self, polynomial: &AnyPolynomial<'_>) {
        let ends = |&(_, event, rising): &(f64, usize, bool)| {
            self.watched[event].terminal && self.watched[event].counts(rising)
        };
        let Some(first) = self.found.iter().position(ends) else {
            return;
        };
        let (end, together) = (self.found[first].0, JOINT * polynomial.length().abs());
        let others = self.found[first..].iter();
        let count = others.take_while(|(s, ..)| (s - end).abs() <= together).count();
        self.found[first..first + count].sort_by_key(ends);
    }

    /// Sets the unknown signs of functions to those at the end of a leg.
    pub(super) fn begin_after(
        &mut self,
        declaration: &Declaration<'_>,
        polynomial: &AnyPolynomial<'_>,
    ) -> Result<(), RunError> {
        if self.sides.iter().all(|side| *side != 0.0) {
            return Ok(());
        }
        let known = self.sides.clone();
        self.search(declaration, polynomial)?;
        for &(_, event, rising) in &self.found {
            self.sides[event] = if rising { 1.0 } else { -1.0 };
        }
        for (side, known) in self.sides.iter_mut().zip(known) {
            if known != 0.0 {
                *side = known;
            }
        }
        Ok(())
    }

    /// The changes of sign within a step, by their time since its start, in order.
    fn search(
        &mut self,
        declaration: &Declaration<'_>,
        polynomial: &AnyPolynomial<'_>,
    ) -> Result<(), RunError> {
        self.found.clear();
        self.work.point = OwnedPoint::zero(declaration.dimension());
        let search = polynomial.search;
        for place in 0..self.watched.len() {
            let first = self.found.len();
            let mut side = self.sides[place];
            let mut open = vec![(polynomial.from, polynomial.length(), search.depth)];
            let least = GAP * polynomial.length().abs();
            let (mut gap, mut corners, mut seen) = (least, 0, polynomial.from);
            while let Some((from, length, depth)) = open.pop() {
                let part = self.part(declaration, polynomial, place, from, length);
                if part
                    .as_ref()
                    .is_some_and(|part| part.tail > search.tail * part.largest)
                    && depth > 0
                {
                    // the left half is taken from the stack first
                    open.push((from + length / 2.0, length / 2.0, depth - 1));
                    open.push((from, length / 2.0, depth - 1));
                    continue;
                }
                let corner = match &part {
                    Some(part) if corners < CORNERS => self.corner(declaration, polynomial, place, part, gap),
                    Some(_) => None,
                    // on a corner a function may have no series
                    None if gap <= HOLE * polynomial.length().abs() => Some(0.0),
                    None => {
                        return Err(RunError::Event(Box::new(FailedEvent {
                            event: place,
                            time: polynomial.time(seen),
                        })));
                    }
                };
                let Some(corner) = corner else {
                    (gap, seen) = (least, from + length);
                    if let Some(part) = &part {
                        self.crossings(declaration, polynomial, place, part, &mut side);
                    }
                    continue;
                };
                // the series up to the corner, the function itself about it, another series beyond
                corners += 1;
                let before = (corner.abs() - gap).max(0.0);
                let after = (corner.abs() + gap).min(length.abs());
                let about = [before, after].map(|s| from + s.copysign(length));
                if let Some(part) = part.filter(|_| before > 0.0) {
                    (gap, seen) = (least, about[1]);
                    let shorter = part.shorter(before.copysign(length));
                    self.crossings(declaration, polynomial, place, &shorter, &mut side);
                } else {
                    gap *= WIDER;
                }
                self.jump(declaration, polynomial, place, about, &mut side);
                if after < length.abs() {
                    open.push((about[1], length - after.copysign(length), depth));
                }
            }
            if first < self.found.len() || self.sides[place] == 0.0 {
                self.settle(declaration, polynomial, (place, first), &mut side);
            }
            self.sides[place] = if first == self.found.len() {
                side
            } else {
                self.sides[place]
            };
        }
        self.found.sort_by(|x, y| x.0.abs().total_cmp(&y.0.abs()));
        Ok(())
    }

    /// An event's function on a part of a step; `None` if its series is not finite.
    fn part(
        &mut self,
        declaration: &Declaration<'_>,
        polynomial: &AnyPolynomial<'_>,
        place: usize,
        from: f64,
        length: f64,
    ) -> Option<Part> {
        let series = shifted(polynomial, from);
        let terms = expand(&self.watched[place], declaration, &series, &mut self.work.call);
        let part = Part::new(from, length, &terms);
        part.terms.iter().all(|c| c.is_finite()).then_some(part)
    }

    /// The first place, since the beginning of a part, at which the function leaves the piece of its series, that was expanded last.
    fn corner(
        &mut self,
        declaration: &Declaration<'_>,
        polynomial: &AnyPolynomial<'_>,
        place: usize,
        part: &Part,
        gap: f64,
    ) -> Option<f64> {
        let Self { work, crossings, .. } = self;
        let mut nearest = f64::INFINITY;
        for switch in work.call.switches().iter().filter(|switch| switch.may_turn()) {
            let argument = Part::new(part.from, part.length, switch.series(part.terms.len()));
            if argument.terms.iter().any(|c| !c.is_finite()) {
                continue;
            }
            // at the zero of an argument rounding chooses the piece
            let begun = (gap / part.length.abs()).min(1.0);
            if switch.side() * roots::value(&argument.terms, begun) < 0.0 {
                return Some(0.0);
            }
            roots::crossings(&argument.terms, crossings);
            nearest = crossings.first().map_or(nearest, |first| nearest.min(first.at));
        }
        if nearest > 1.0 {
            // corners without a sign that changes, as that of a root at zero, show in the function
            nearest = self.leaves(declaration, polynomial, place, part, gap)?;
        }
        (nearest <= 1.0).then_some(nearest * part.length)
    }

    /// The place, relative to a part, at which the function leaves its series; `None` if it does not before the end.
    fn leaves(
        &mut self,
        declaration: &Declaration<'_>,
        polynomial: &AnyPolynomial<'_>,
        place: usize,
        part: &Part,
        accuracy: f64,
    ) -> Option<f64> {
        let from_series = |events: &mut Self, s: f64| {
            let at = part.from + s * part.length;
            let value = events.watched[place].value(declaration, polynomial, at, &mut events.work);
            (value, (value - roots::value(&part.terms, s)).abs())
        };
        let (value, apart) = from_series(self, 1.0);
        // the terms of a series that does not converge say nothing of the function
        let size = if part.tail > polynomial.search.tail * part.largest {
            part.terms.first().map_or(0.0, |first| first.abs())
        } else {
            part.largest
        };
        let mut allowed = APART * size.max(value.abs());
        if apart > allowed {
            let point = self.work.point.clone();
            allowed += self.rounding(declaration, polynomial, place, (&point, value));
        }
        if apart.is_nan() || apart <= allowed {
            return None;
        }
        let mut ends = [0.0, 1.0];
        while (ends[1] - ends[0]) * part.length.abs() > accuracy {
            let middle = 0.5 * (ends[0] + ends[1]);
            let leaves = from_series(self, middle).1 > allowed;
            ends[usize::from(leaves)] = middle;
        }
        Some(ends[1])
    }

    /// The change of sign between two times that are close together, at a corner or a jump.
    fn jump(
        &mut self,
        declaration: &Declaration<'_>,
        polynomial: &AnyPolynomial<'_>,
        place: usize,
        ends: [f64; 2],
        side: &mut f64,
    ) {
        let Self {
            watched, work, found, ..
        } = self;
        let work = RefCell::new(work);
        let value = |s: f64| watched[place].value(declaration, polynomial, s, &mut work.borrow_mut());
        let values = ends.map(value);
        if *side == 0.0 {
            *side = values
                .into_iter()
                .find(|value| *value != 0.0)
                .map_or(0.0, f64::signum);
        }
        if values[1] * *side < 0.0 {
            let at = if values[0] * values[1] < 0.0 {
                roots::refine(&value, ends).at
            } else {
                ends[0]
            };
            *side = values[1].signum();
            found.push((at, place, *side > 0.0));
        }
    }

    /// The changes of sign on a part of a step; `side` is the sign before it and receives that after it.
    fn crossings(
        &mut self,
        declaration: &Declaration<'_>,
        polynomial: &AnyPolynomial<'_>,
        place: usize,
        part: &Part,
        side: &mut f64,
    ) {
        let &Part { from, length, .. } = part;
        let Self {
            watched,
            work,
            crossings,
            found,
            ..
        } = self;
        roots::crossings(&part.terms, crossings);
        // right at the joint of two parts rounding decides on the sign, and on a change that is in neither of them
        crossings.retain(|crossing| crossing.at >= JOINT);
        let beside = [roots::value(&part.terms, JOINT)];
        let begins = beside.iter().chain(&part.terms).find(|c| **c != 0.0);
        let begins = begins.map_or(0.0, |c| c.signum());
        if *side == 0.0 {
            *side = begins;
        }
        if begins * *side < 0.0 {
            found.push((from, place, begins > 0.0));
            *side = begins;
        }
        for crossing in crossings.iter() {
            // the series of the function is inaccurate by its truncation: the function itself decides
            let ends = crossing.bracket.map(|s| from + s * length);
            let work = RefCell::new(&mut *work);
            let value = |s: f64| watched[place].value(declaration, polynomial, s, &mut work.borrow_mut());
            let at = if value(ends[0]) * value(ends[1]) < 0.0 {
                roots::refine(&value, ends).at
            } else {
                from + crossing.at * length
            };
            found.push((at, place, crossing.rising));
            *side = if crossing.rising { 1.0 } else { -1.0 };
        }
    }
}

/// The series of a function on a part of a polynomial.
struct Part {
    /// The beginning, after the time of expansion of the polynomial, and the length.
    from: f64,
    length: f64,
    /// The terms at the end.
    terms: Vec<f64>,
    /// The largest term, and the largest of the last two.
    largest: f64,
    tail: f64,
}

impl Part {
    /// A series on a part.
    fn new(from: f64, length: f64, coefficients: &[f64]) -> Self {
        let mut power = 1.0;
        let mut terms = coefficients.to_vec();
        for term in &mut terms {
            *term *= power;
            power *= length;
        }
        let most = |terms: &[f64]| terms.iter().fold(0.0_f64, |most, term| most.max(term.abs()));
        Self {
            from,
            length,
            largest: most(&terms),
            tail: most(&terms[terms.len().saturating_sub(2)..]),
            terms,
        }
    }

    /// The beginning of the part.
    fn shorter(&self, length: f64) -> Self {
        let mut part = Self::new(self.from, length / self.length, &self.terms);
        part.length = length;
        part
    }
}

/// Reports an event; breaks if it ends the run.
fn report_event(
    watched: &[AnyEvent<'_>],
    occurrence: &AnyOccurrence,
    observer: &mut dyn AnyObserver,
) -> ControlFlow<()> {
    observer.event(occurrence)?;
    if watched[occurrence.event].terminal {
        return ControlFlow::Break(());
    }
    ControlFlow::Continue(())
}

/// The series of position and velocity about another point of a step.
pub(super) struct ShiftedSeries {
    t: f64,
    order: usize,
    dimension: usize,
    /// The coefficients of the velocity, a vector for each order; then those of the position.
    v: Vec<f64>,
    q: Vec<f64>,
}

pub(super) fn shifted(polynomial: &AnyPolynomial<'_>, s: f64) -> ShiftedSeries {
    let series = polynomial.series;
    let mut shifted = ShiftedSeries {
        t: polynomial.time(s),
        order: series.order(),
        dimension: series.dimension(),
        v: series.velocities().to_vec(),
        q: series.positions().to_vec(),
    };
    if s != 0.0 {
        shift(&mut shifted.q, shifted.dimension, s);
        shift(&mut shifted.v, shifted.dimension, s);
    }
    shifted
}

/// A polynomial about another point, by repeated synthetic division.
fn shift(coefficients: &mut [f64], dimension: usize, s: f64) {
    let n = coefficients.len() / dimension.max(1);
    for first in 0..n {
        for k in (first..n - 1).rev() {
            for i in 0..dimension {
                coefficients[k * dimension + i] += s * coefficients[(k + 1) * dimension + i];
            }
        }
    }
}

/// The series of an event's function, to the highest known order.
pub(super) fn expand(
    event: &AnyEvent<'_>,
    declaration: &Declaration<'_>,
    series: &ShiftedSeries,
    call: &mut Call,
) -> Vec<f64> {
    let n = series.dimension;
    // the acceleration is known to one order less than the velocity
    let order = series.order.min(MAX_ORDER);
    let input = |k: usize, place: usize| {
        if place == 3 * n {
            return [series.t, 1.0].get(k).copied().unwrap_or(0.0);
        }
        let (kind, i) = (place / n, place % n);
        match kind {
            0 => series.q[k * n + i],
            1 => series.v[k * n + i],
            _ => (k + 1) as f64 * series.v[(k + 1) * n + i],
        }
    };
    let at = |k: usize| {
        let jet = |place: usize| {
            let now = if k == 0 { 0.0 } else { input(k, place) };
            Jet::moving(input(0, place), now)
        };
        event.at(
            declaration,
            OwnedPoint::new(n, (0..=3 * n).map(jet).collect()).any(),
        )
    };
    let mut coefficients = vec![call.begin(|| at(0))];
    for k in 1..order {
        coefficients.push(call.next::<false>(k, || at(k)));
    }
    coefficients
}
