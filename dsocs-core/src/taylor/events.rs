//! Where a function of the motion changes its sign.

use core::cell::RefCell;

use super::Jets;
use super::error::TaylorError;
use super::flow::{State, TaylorFlow};
use super::jet::{Jet, Tape};
use super::kernel::{MAX_ORDER, ROWS};
use super::polynomial::Polynomial;
use super::roots::{self, Crossing};
use crate::system::{Point, System};

/// The last term of an event's series may be this part of the largest: beyond, the interval is halved.
const TAIL: f64 = 1e-9;
/// How often.
const DEPTH: u32 = 12;

/// A change of sign this near to the start of a part, as a part of it, may be the last one, seen again.
const JOINT: f64 = 1e-9;

/// A function of position, velocity and acceleration.
type Function<'e, const N: usize> = Box<dyn Fn(&Point<Jet, N>) -> Jet + 'e>;

/// What an event's function is.
enum Source<'e, const N: usize> {
    Observable(usize),
    Function(Function<'e, N>),
}

/// In which direction a change of sign counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Direction {
    Rising,
    Falling,
    Both,
}

/// A change of sign of a function `g(q, v, a)` along the motion.
pub struct Event<'e, const N: usize> {
    source: Source<'e, N>,
    direction: Direction,
    terminal: bool,
}

impl<const N: usize> core::fmt::Debug for Event<'_, N> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Event")
            .field("direction", &self.direction)
            .field("terminal", &self.terminal)
            .finish_non_exhaustive()
    }
}

impl<'e, const N: usize> Event<'e, N> {
    fn of(source: Source<'e, N>) -> Self {
        Self {
            source,
            direction: Direction::Both,
            terminal: false,
        }
    }

    /// An observed expression of the declaration, by its place in [`System::OBSERVABLES`]. It may not call functions of the
    /// user's own, of which an observed expression knows plain numbers only.
    #[must_use]
    pub fn observable(index: usize) -> Self {
        Self::of(Source::Observable(index))
    }

    /// A function of position, velocity and acceleration; the functions of jets are those of [`crate::Real`].
    #[must_use]
    pub fn function(function: impl Fn(&Point<Jet, N>) -> Jet + 'e) -> Self {
        Self::of(Source::Function(Box::new(function)))
    }

    /// Only changes from negative to positive, in the direction of the run, count.
    #[must_use]
    pub fn rising(mut self) -> Self {
        self.direction = Direction::Rising;
        self
    }

    /// Only changes from positive to negative, in the direction of the run, count.
    #[must_use]
    pub fn falling(mut self) -> Self {
        self.direction = Direction::Falling;
        self
    }

    /// The motion ends where the event happens.
    #[must_use]
    pub fn terminal(mut self) -> Self {
        self.terminal = true;
        self
    }

    /// The function at a point of jets.
    fn at<S: System<N>>(&self, system: &S, point: &Point<Jet, N>) -> Jet {
        match &self.source {
            Source::Function(function) => function(point),
            Source::Observable(index) => {
                let mut observed = vec![Jet::from(f64::NAN); S::OBSERVABLES.len()];
                system.observe(point, &mut observed);
                observed.get(*index).copied().unwrap_or(Jet::from(f64::NAN))
            }
        }
    }

    /// The function at the time `s` after the start of a step.
    fn value<S: Jets<N>>(&self, polynomial: &Polynomial<'_, S, N>, s: f64, tape: &mut Tape) -> f64 {
        let [q, v, a] = polynomial.series.point(s).map(|x| x.map(Jet::from));
        // functions that are not seen are written down all the same
        tape.written(|| self.at(polynomial.system, &Point { q, v, a }))
    }
}

/// An event that happened.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Occurrence<const N: usize> {
    /// The event's place among those watched.
    pub event: usize,
    /// Whether the function became positive, in the direction of the run.
    pub rising: bool,
    /// The state there.
    pub state: State<N>,
}

/// Events that are watched, and on which side of zero each function was last.
#[derive(Debug)]
pub struct Events<'e, const N: usize> {
    watched: Vec<Event<'e, N>>,
    sides: Vec<f64>,
    tape: Tape,
    crossings: Vec<Crossing>,
    found: Vec<(f64, usize, bool)>,
}

impl<'e, const N: usize> Events<'e, N> {
    /// The events, in the order by which occurrences name them.
    #[must_use]
    pub fn new(events: Vec<Event<'e, N>>) -> Self {
        let sides = vec![0.0; events.len()];
        Self {
            watched: events,
            sides,
            tape: Tape::default(),
            crossings: Vec::new(),
            found: Vec::new(),
        }
    }

    /// The changes of sign within a step, by their time since its start, in order.
    fn search<S: Jets<N>>(&mut self, polynomial: &Polynomial<'_, S, N>) -> Result<(), TaylorError> {
        self.found.clear();
        for place in 0..self.watched.len() {
            let first = self.found.len();
            let mut side = self.sides[place];
            let mut open = vec![(0.0, polynomial.h, DEPTH)];
            while let Some((from, length, depth)) = open.pop() {
                let Some(part) = self.part(polynomial, place, from, length) else {
                    return Err(TaylorError::Event {
                        event: place,
                        t: polynomial.start() + from,
                    });
                };
                let part = part.as_slice();
                let largest = part.iter().fold(0.0_f64, |size, c| size.max(c.abs()));
                let tail = part
                    .iter()
                    .rev()
                    .take(2)
                    .fold(0.0_f64, |size, c| size.max(c.abs()));
                if tail > TAIL * largest && depth > 0 {
                    // the left half is taken from the stack first
                    open.push((from + length / 2.0, length / 2.0, depth - 1));
                    open.push((from, length / 2.0, depth - 1));
                    continue;
                }
                self.crossings(polynomial, place, part, [from, length], &mut side);
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

    /// The series of an event's function on a part of a step, of which that part is the unit of time; `None` if it is not
    /// finite.
    fn part<S: Jets<N>>(
        &mut self,
        polynomial: &Polynomial<'_, S, N>,
        place: usize,
        from: f64,
        length: f64,
    ) -> Option<Vec<f64>> {
        let series = shifted(polynomial, from);
        let mut coefficients = expand(&self.watched[place], polynomial.system, &series, &mut self.tape);
        let mut power = 1.0;
        for c in &mut coefficients {
            *c *= power;
            power *= length;
        }
        coefficients.iter().all(|c| c.is_finite()).then_some(coefficients)
    }

    /// The changes of sign on a part of a step; `side` is the sign before and after.
    fn crossings<S: Jets<N>>(
        &mut self,
        polynomial: &Polynomial<'_, S, N>,
        place: usize,
        part: &[f64],
        [from, length]: [f64; 2],
        side: &mut f64,
    ) {
        let Self {
            watched,
            tape,
            crossings,
            found,
            ..
        } = self;
        roots::crossings(part, crossings);
        let begins = part.iter().find(|c| **c != 0.0).map_or(0.0, |c| c.signum());
        if *side == 0.0 {
            *side = begins;
        }
        // a change where two parts meet shows in neither, or through rounding once more at the start of the second
        let again = crossings.first().is_some_and(|first| first.at < JOINT);
        if begins * *side < 0.0 {
            if again {
                crossings.remove(0);
            } else {
                found.push((from, place, begins > 0.0));
                *side = begins;
            }
        }
        for crossing in crossings.iter() {
            // the series of the function has lost what its truncation has: the function itself decides
            let ends = crossing.bracket.map(|s| from + s * length);
            let tape = RefCell::new(&mut *tape);
            let value = |s: f64| watched[place].value(polynomial, s, &mut tape.borrow_mut());
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

/// The series of position and velocity about another point of a step.
struct Shifted<const N: usize> {
    order: usize,
    v: [[f64; N]; ROWS],
    q: [[f64; N]; ROWS],
}

fn shifted<S: Jets<N>, const N: usize>(polynomial: &Polynomial<'_, S, N>, s: f64) -> Shifted<N> {
    let series = polynomial.series;
    let mut shifted = Shifted {
        order: series.order(),
        v: [[0.0; N]; ROWS],
        q: [[0.0; N]; ROWS],
    };
    let (q, v) = (series.position(), series.velocity());
    shifted.q[..q.len()].copy_from_slice(q);
    shifted.v[..v.len()].copy_from_slice(v);
    if s != 0.0 {
        shift(&mut shifted.q[..q.len()], s);
        shift(&mut shifted.v[..v.len()], s);
    }
    shifted
}

/// A polynomial about another point, by repeated synthetic division.
fn shift<const N: usize>(coefficients: &mut [[f64; N]], s: f64) {
    let n = coefficients.len();
    for first in 0..n {
        for k in (first..n - 1).rev() {
            for i in 0..N {
                coefficients[k][i] += s * coefficients[k + 1][i];
            }
        }
    }
}

/// The series of an event's function, as far as it is known.
fn expand<S: Jets<N>, const N: usize>(
    event: &Event<'_, N>,
    system: &S,
    series: &Shifted<N>,
    tape: &mut Tape,
) -> Vec<f64> {
    // the acceleration is known to one order less than the velocity
    let order = series.order.min(MAX_ORDER);
    let input = |k: usize, place: usize| {
        let (kind, i) = (place / N, place % N);
        match kind {
            0 => series.q[k][i],
            1 => series.v[k][i],
            _ => (k + 1) as f64 * series.v[k + 1][i],
        }
    };
    let value = tape.written(|| {
        let vector = |kind: usize| {
            core::array::from_fn(|i| {
                let place = kind * N + i;
                Jet::input(place, input(0, place))
            })
        };
        let point = Point {
            q: vector(0),
            v: vector(1),
            a: vector(2),
        };
        event.at(system, &point)
    });
    let mut coefficients = vec![value];
    coefficients.extend((1..order).map(|k| tape.next(k, &|place| input(k, place))));
    coefficients
}

impl<S: Jets<N>, const N: usize> TaylorFlow<'_, S, N> {
    /// Runs to the time `until`, or to the first terminal event, and hands every event on, in order. A function that is zero
    /// without changing its sign is no event, and neither is one at the very start.
    ///
    /// Within each step every change of sign is found, also of functions that change it several times: the roots of the
    /// function's own Taylor polynomial are isolated. Then the function itself is brought to zero, to rounding.
    ///
    /// Returns the terminal event, at which the flow then stands.
    ///
    /// # Errors
    ///
    /// [`TaylorError`] if the motion does not get there, or [`TaylorError::Event`] if a function has no Taylor series.
    pub fn watch(
        &mut self,
        until: f64,
        events: &mut Events<'_, N>,
        mut observer: impl FnMut(&Occurrence<N>),
    ) -> Result<Option<Occurrence<N>>, TaylorError> {
        if !until.is_finite() {
            return Err(TaylorError::Until { until });
        }
        while self.state().t != until {
            let polynomial = self.step(until)?;
            events.search(&polynomial)?;
            let mut ended = None;
            for &(s, place, rising) in &events.found {
                let side = if rising { 1.0 } else { -1.0 };
                events.sides[place] = side;
                let event = &events.watched[place];
                let counts = match event.direction {
                    Direction::Both => true,
                    Direction::Rising => rising,
                    Direction::Falling => !rising,
                };
                if !counts {
                    continue;
                }
                let mut t = polynomial.t;
                t.add(&[s]);
                let [q, v, _] = polynomial.series.point(s);
                let occurrence = Occurrence {
                    event: place,
                    rising,
                    state: State { t: t.hi[0], q, v },
                };
                observer(&occurrence);
                if event.terminal {
                    ended = Some((s, occurrence));
                    break;
                }
            }
            if let Some((s, occurrence)) = ended {
                self.stop_at(s);
                return Ok(Some(occurrence));
            }
        }
        Ok(None)
    }
}
