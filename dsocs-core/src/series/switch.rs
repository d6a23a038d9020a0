//! Switches: expressions whose sign selects the piece of a function that a series continues.
//!
//! The series of `|u|` is that of `u` or of `-u`, and is valid only as long as `u` keeps the sign that the
//! series began with. The same holds for the argument of `signum`, and for the difference of the two sides of
//! a comparison. The recurrences give the series of these arguments. So the first change of sign is located,
//! and the step ends there.
//!
//! A root is never negative, but the series of `√(u²)` is that of `u` or of `-u`, which continues below zero.
//! The place where it vanishes is a corner. The same holds for inverse trigonometric functions, since the
//! series of `atan(tan u)` is that of `u` plus a constant.

use super::orders::{MAX_ORDER, ROWS};
use super::power::Power;
use crate::series::roots::{self, Crossing};

/// A coefficient is rounding if its term is below this part of the largest term.
const ROUNDING: f64 = 1e-12;

/// An argument is zero to rounding if it is below this part of the sum of its terms over a step.
const TOUCHES: f64 = 1e-14;

/// Bounds of the last terms of an argument, relative to its largest: above the first the argument cannot be
/// searched for a change of sign; the second is always enough.
const TAIL: [f64; 2] = [1e-3, 1e-9];

/// Largest number of times that a time is shortened.
const SHORTENINGS: u32 = 60;

/// Least factor by which a step is shortened if the series of an argument does not converge.
const SHORTEST: f64 = 0.05;

/// Factor by which the next part of a step is longer in which a root is searched.
const FARTHER: f64 = 8.0;

/// Least number of terms that are kept before later ones may count as rounding.
const LEAST_SIGNIFICANT: usize = 6;

/// A series that begins farther than this outside the range where a smooth step is visible shows nothing of
/// it.
const FLAT: f64 = 3.0;

/// Limits for switches that follow from the tolerance.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits {
    /// The largest part of the largest term that the last terms of an argument may have.
    tail: f64,
    /// The distance from its middle at which a hyperbolic tangent differs from ±1 by about the tolerance.
    visible: f64,
}

impl Limits {
    pub(crate) fn new(tolerance: f64) -> Self {
        Self {
            tail: tolerance.clamp(TAIL[1], TAIL[0]),
            visible: 0.5 * (4.0 / tolerance.max(f64::EPSILON)).ln(),
        }
    }
}

/// An expression whose sign selects the piece that a series continues.
#[derive(Clone, Debug)]
pub struct Switch {
    /// Its Taylor coefficients, of all orders below that of the series.
    coefficients: [f64; ROWS],
    /// The sign of the piece to which the series belongs; 0 if there are no pieces.
    side: f64,
    /// The sign that the next series has to have; 0 if the value decides.
    set: f64,
    /// Coefficients below this order are zero: the series begins at the zero of the argument.
    leading: usize,
    /// The sum of the terms over the last step.
    scale: f64,
    /// The time after which a series that begins at the zero has left it by more than rounding.
    leaves: f64,
    /// The function that depends on the argument.
    kind: Kind,
}

/// The function that depends on an argument.
#[derive(Clone, Copy, Debug, Default)]
enum Kind {
    /// A piecewise function.
    #[default]
    Piece,
    /// A smooth function that is flat except near zero.
    Steep,
    /// A power of a high degree of the argument.
    Power(Power),
    /// The argument is itself the value of a bounded function, with its largest absolute value; a bound of
    /// zero says that it is not negative.
    Bounded(f64),
}

impl Default for Switch {
    fn default() -> Self {
        Self {
            coefficients: [0.0; ROWS],
            side: 0.0,
            set: 0.0,
            leading: 0,
            scale: 0.0,
            leaves: 0.0,
            kind: Kind::Piece,
        }
    }
}

/// The part of a step that may be taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Reach {
    /// The whole step.
    Whole,
    /// A part: beyond it the series of an argument is inaccurate, or a steep function begins.
    Shorter(f64),
    /// A part, up to a change of sign.
    Crossing(f64),
    /// A part, up to the place where a function reaches its bound.
    Corner(f64),
}

impl Switch {
    /// Begins a series with the argument's value; `own` is its sign. Returns the sign of the piece that is continued.
    #[inline(always)]
    pub fn start(&mut self, value: f64, own: f64) -> f64 {
        self.coefficients[0] = value;
        self.side = if self.set == 0.0 { own } else { self.set };
        self.side
    }

    /// Begins the series of the argument of a smooth function that is flat except near zero.
    #[inline(always)]
    pub fn steep(&mut self, value: f64) {
        self.coefficients[0] = value;
        self.kind = Kind::Steep;
    }

    /// Begins the series of a bounded value.
    #[inline(always)]
    pub fn bounded(&mut self, value: f64, bound: f64) {
        self.coefficients[0] = value;
        self.kind = Kind::Bounded(bound);
    }

    /// Begins the series of the base of a power of a high degree; the exponent is negative in a divisor. The
    /// power may be flat except where it is large.
    #[inline(always)]
    pub fn power(&mut self, value: f64, exponent: i32) {
        self.coefficients[0] = value;
        if !matches!(self.kind, Kind::Power(power) if power.is_of(exponent)) {
            self.kind = Kind::Power(Power::new(exponent));
        }
    }

    /// Stores the coefficient of order `k`.
    #[inline(always)]
    pub fn push(&mut self, k: usize, coefficient: f64) {
        self.coefficients[k.min(MAX_ORDER)] = coefficient;
    }

    /// The sign of the piece.
    pub(crate) fn side(&self) -> f64 {
        self.side
    }

    /// Sets the sign of the next series; 0 lets its value decide.
    pub(crate) fn set(&mut self, side: f64) {
        self.set = side;
    }

    /// Counts the value as zero if that is within the given time, in which the argument has its present rate.
    pub(crate) fn blur(&mut self, time: f64) {
        self.known_to(self.coefficients[1].abs() * time);
    }

    /// Counts the value as zero if it is below an error.
    pub(crate) fn known_to(&mut self, error: f64) {
        self.scale = self.scale.max(error / TOUCHES);
    }

    /// Makes the next series continue the piece of this one.
    pub(crate) fn hold(&mut self) {
        self.set = self.side;
    }

    /// Lets the value decide the sign of the next series, if it is beyond the piece by more than rounding;
    /// returns whether it is.
    pub(crate) fn lets_go(&mut self) -> bool {
        let is_beyond = self.side * self.coefficients[0] < -TOUCHES * self.scale;
        if is_beyond {
            self.set = 0.0;
        }
        is_beyond
    }

    /// Whether the sign of the next series is set.
    pub(crate) fn is_held(&self) -> bool {
        self.set != 0.0
    }

    /// Takes over from another switch, which is left, the number of leading zero coefficients.
    pub(crate) fn begins_as(&mut self, other: &mut Self) {
        self.leading = core::mem::take(&mut other.leading);
    }

    /// Sets the order below which coefficients are rounding.
    pub(crate) fn begins_with(&mut self, leading: usize) {
        self.leading = leading;
    }

    /// Whether its sign selects a piece; that of a steep function's argument does not.
    pub(crate) fn may_turn(&self) -> bool {
        self.side != 0.0
    }

    /// Whether it is the value of a bounded function.
    pub(crate) fn is_bounded(&self) -> bool {
        matches!(self.kind, Kind::Bounded(_))
    }

    /// The distance of the value of a bounded function from its bound; `None` for other arguments.
    pub(crate) fn distance_from_bound(&self) -> Option<f64> {
        match self.kind {
            Kind::Bounded(bound) if bound > 0.0 => Some(bound - self.size()),
            Kind::Bounded(_) => Some(self.size()),
            _ => None,
        }
    }

    /// Whether the value is exactly zero.
    pub(crate) fn is_zero(&self) -> bool {
        self.may_turn() && self.coefficients[0] == 0.0
    }

    /// The value at the time `s` of a step, in units of its size over the step; negative if it is beyond the
    /// piece.
    pub(crate) fn margin(&self, s: f64) -> f64 {
        if self.side == 0.0 || self.side.is_nan() || (self.leading > 0 && s <= self.leaves) {
            return f64::INFINITY;
        }
        self.side * self.coefficients[0] / self.scale.max(f64::MIN_POSITIVE)
    }

    /// The coefficients below an order.
    pub(crate) fn series(&self, order: usize) -> &[f64] {
        &self.coefficients[..order.min(ROWS)]
    }

    /// The value.
    pub(crate) fn value(&self) -> f64 {
        self.coefficients[0]
    }

    /// The absolute value.
    pub(crate) fn size(&self) -> f64 {
        self.coefficients[0].abs()
    }

    /// The time between the point of expansion and the zero of the argument by its first two terms, on either side of it.
    pub(crate) fn takes(&self) -> f64 {
        let [value, rate, ..] = self.coefficients;
        if self.may_turn() && rate != 0.0 {
            (value / rate).abs()
        } else {
            f64::INFINITY
        }
    }

    /// Whether the value is zero, and stays zero in all known orders.
    pub(crate) fn stays(&self) -> bool {
        let finite = self.coefficients.iter().take_while(|c| c.is_finite());
        self.may_turn() && finite.fold(0.0_f64, |most, c| most.max(c.abs())) == 0.0
    }

    /// The time, by the first two terms, until the value is beyond the piece.
    pub(crate) fn missing(&self) -> f64 {
        let [value, rate, ..] = self.coefficients;
        if self.side * value > 0.0 && rate != 0.0 {
            (value / rate).abs()
        } else {
            0.0
        }
    }

    /// Whether the value is zero to rounding, or has the sign of another piece.
    pub(crate) fn touches(&self) -> bool {
        (self.side * self.coefficients[0]) <= TOUCHES * self.scale && self.may_turn()
    }

    /// The first order whose term at the time `tau` exceeds rounding, and its sign; an order beyond the last
    /// and sign 0 if there is none.
    pub(crate) fn leads(&self, order: usize, tau: f64) -> (usize, f64) {
        let known = &self.coefficients[..order.clamp(2, MAX_ORDER)];
        // the series of a root has only finitely many terms at its zero
        let finite = known.iter().take_while(|c| c.is_finite()).count();
        let known = &known[..finite];
        let (mut terms, mut largest) = ([0.0; ROWS], 0.0_f64);
        let mut tau = tau;
        // until the series converges at that time: an argument may change faster than the motion
        for _ in 0..SHORTENINGS {
            let mut power = 1.0;
            largest = 0.0;
            for (term, c) in terms.iter_mut().zip(known) {
                *term = c * power;
                power *= tau;
                largest = largest.max(term.abs());
            }
            // with two or three terms the missing ones cannot be estimated
            if known.len() < 4 || (largest.is_finite() && tail(&terms[..known.len()]) <= TAIL[0] * largest) {
                break;
            }
            tau *= 0.3;
        }
        let is_rounding = |term: f64, k: usize| {
            term.abs() <= ROUNDING * largest || (k == 0 && term.abs() <= TOUCHES * self.scale)
        };
        let leading = (0..terms.len()).find(|&k| !is_rounding(terms[k], k));
        match leading {
            Some(leading) if largest.is_finite() => (leading, terms[leading].signum()),
            _ => (ROWS, 0.0),
        }
    }

    /// Whether the argument is zero to rounding, and by its first terms returns to zero within a time of the length `reach`.
    pub(crate) fn turns_within(&self, reach: f64) -> bool {
        let [_, first, second, ..] = self.coefficients;
        self.touches() && first != 0.0 && second.abs() * reach > first.abs()
    }

    /// The time until the argument vanishes, in a direction, by its first three terms.
    pub(crate) fn ends(&self, direction: f64) -> f64 {
        let [c, b, a, ..] = self.coefficients;
        let [c, b, a] = [c, b * direction, a].map(|x| x * self.side);
        // the first root of `c + b t + a t²`, without cancellation
        let root = (b * b - 4.0 * a * c).sqrt();
        let time = 2.0 * c / (root - b);
        if self.may_turn() && c > 0.0 && time > 0.0 {
            time
        } else {
            f64::INFINITY
        }
    }

    /// The part of a step of the length `h` that may be taken, from the series of the argument to an order;
    /// `h` is negative back in time.
    #[inline]
    pub(crate) fn reach(
        &mut self,
        order: usize,
        h: f64,
        limits: &Limits,
        found: &mut Vec<Crossing>,
    ) -> Reach {
        let known = &self.coefficients[..order.clamp(1, MAX_ORDER)];
        let (mut first, size) = (known[0].abs(), h.abs());
        let is_steep = match &mut self.kind {
            Kind::Power(power) => return power.reach(known, h, found),
            Kind::Steep => true,
            Kind::Piece => false,
            Kind::Bounded(bound) => {
                if *bound > 0.0 {
                    first = *bound - first;
                }
                false
            }
        };
        if is_steep && first <= limits.visible + FLAT {
            return Reach::Whole;
        }
        let rest = known[1..]
            .iter()
            .rev()
            .fold(0.0, |rest, c| (rest + c.abs()) * size);
        let least = if is_steep { limits.visible } else { 0.1 * first };
        if self.leading == 0 && first - rest > least {
            (self.scale, self.leaves) = (first + rest, 0.0);
            return Reach::Whole;
        }
        match self.kind {
            Kind::Bounded(bound) if bound > 0.0 => self.search_bounds(bound, order, h, limits, found),
            _ => self.search(order, h, limits, found),
        }
    }

    /// [`Switch::search`] for a value with two bounds.
    #[cold]
    fn search_bounds(
        &self,
        bound: f64,
        order: usize,
        h: f64,
        limits: &Limits,
        found: &mut Vec<Crossing>,
    ) -> Reach {
        let mut nearest = (1.0, Reach::Whole);
        for side in [1.0, -1.0] {
            let mut way = Self {
                coefficients: self.coefficients.map(|c| -side * c),
                kind: Kind::Bounded(0.0),
                ..Self::default()
            };
            way.coefficients[0] += bound;
            let reach = way.search(order, h, limits, found);
            match reach {
                Reach::Shorter(part) | Reach::Crossing(part) | Reach::Corner(part) if part < nearest.0 => {
                    nearest = (part, reach);
                }
                _ => {}
            }
        }
        nearest.1
    }

    /// The number of significant terms. Near a corner the value of a bounded function loses digits, the more
    /// the higher the order: beyond its smallest term its series is rounding.
    fn significant(&self, terms: &[f64], limits: &Limits) -> usize {
        if !matches!(self.kind, Kind::Bounded(_)) || terms.len() < LEAST_SIGNIFICANT {
            return terms.len();
        }
        // in an even function every other term is zero
        let pairs = terms.windows(2).map(|pair| pair[0].abs().max(pair[1].abs()));
        let sizes = pairs.enumerate().skip(LEAST_SIGNIFICANT - 2);
        let first = terms.iter().take(LEAST_SIGNIFICANT);
        let largest = first.fold(0.0_f64, |largest, term| largest.max(term.abs()));
        let (place, least) = sizes.fold(
            (0, f64::INFINITY),
            |least, (k, size)| {
                if size < least.1 { (k, size) } else { least }
            },
        );
        if least <= limits.tail * largest {
            place + 2
        } else {
            terms.len()
        }
    }

    /// [`Switch::reach`] if the sizes of the terms do not exclude a change of sign.
    #[cold]
    fn search(&mut self, order: usize, h: f64, limits: &Limits, found: &mut Vec<Crossing>) -> Reach {
        let from = self.leading.min(ROWS);
        let known = &self.coefficients[..order.clamp(1, MAX_ORDER)];
        let Some(last) = known.iter().rposition(|c| *c != 0.0).filter(|&last| last >= from) else {
            self.scale = 0.0;
            return Reach::Whole;
        };
        let mut whole = 1.0;
        let mut part = near_start(&known[from..=last], h);
        loop {
            let mut terms = [0.0; ROWS];
            let mut power = 1.0;
            let mut sum = 0.0;
            for (k, c) in known.iter().enumerate().take(last + 1) {
                let term = c * power;
                power *= h * part;
                if k >= from {
                    terms[k - from] = term;
                    sum += term.abs();
                }
            }
            self.scale = sum;
            let significant = self.significant(&terms[..=last - from], limits);
            let terms = &mut terms[..significant];
            self.leaves = if from == 0 {
                0.0
            } else {
                let far = (4.0 * TOUCHES * sum / terms[0].abs()).powf(1.0 / from as f64);
                (far * part).min(part) * h.abs()
            };
            if !sum.is_finite() {
                part *= 1e-3;
                whole = part;
                // if no step is finite, the step itself reports it
                if part < 1e-300 {
                    return Reach::Whole;
                }
                continue;
            }
            let first = terms[0].abs();
            let rest = sum - first;
            let free = if matches!(self.kind, Kind::Steep) {
                // flat at the beginning: up to the end of the flat part
                let sign = terms[0].signum();
                for term in terms.iter_mut() {
                    *term *= sign;
                }
                // at a multiple zero only rounding is left of the sum
                let visible = limits.visible.max(TOUCHES * sum);
                terms[0] -= visible;
                first - rest > visible
            } else {
                rest < 0.9 * first
            };
            if !free {
                let tail = if significant == last - from + 1 && last + 2 >= known.len() && last >= from + 2 {
                    tail(terms)
                } else {
                    0.0
                };
                let largest = terms
                    .iter()
                    .fold(0.0_f64, |largest, term| largest.max(term.abs()));
                let allowed = limits.tail * largest;
                if tail > allowed {
                    part *= shorter(tail, allowed, last - from);
                    whole = part;
                    continue;
                }
                roots::crossings(terms, found);
                if let Some(crossing) = found.first() {
                    let place = part * crossing.at;
                    return match self.kind {
                        Kind::Piece => Reach::Crossing(place),
                        Kind::Bounded(_) => Reach::Corner(place),
                        Kind::Steep | Kind::Power(_) => Reach::Shorter(place),
                    };
                }
            }
            if part < whole {
                part = (FARTHER * part).min(whole);
            } else if whole < 1.0 {
                return Reach::Shorter(whole);
            } else {
                return Reach::Whole;
            }
        }
    }
}

/// The largest of the last third of the terms, of at least two: where a motion begins at the zero of a power,
/// only every few terms are nonzero.
pub(super) fn tail(terms: &[f64]) -> f64 {
    let from = terms.len() - (terms.len() / 3).max(2).min(terms.len());
    terms[from..].iter().fold(0.0, |tail, term| tail.max(term.abs()))
}

/// Factor by which a step is shortened so that its last terms, of the given order, are as small as allowed.
pub(super) fn shorter(tail: f64, allowed: f64, order: usize) -> f64 {
    (0.9 * (allowed / tail).powf(1.0 / order as f64)).max(SHORTEST)
}

/// The first part of a step in which a root is searched: there the terms beyond the first are not much larger
/// than it. Roots are accurate to rounding relative to the part that is searched.
fn near_start(known: &[f64], h: f64) -> f64 {
    let first = known[0].abs();
    let rest = |part: f64| {
        let mut power = (h * part).abs();
        let mut sum = 0.0;
        for c in &known[1..] {
            sum += c.abs() * power;
            power *= (h * part).abs();
        }
        sum
    };
    let mut part = 1.0;
    while part > 1e-300 {
        let rest = rest(part);
        if rest <= FARTHER * first {
            break;
        }
        // a sum that overflows gives no estimate
        part *= if rest.is_finite() {
            (first / rest).max(1e-3)
        } else {
            1e-3
        };
    }
    if part > 1e-300 { part } else { 1.0 }
}

/// The switches of a system: those of the declaration, and those of each of the user's functions.
pub trait Switches {
    /// The number of groups; 0 in a system without switches.
    const GROUPS: usize;

    /// A group of one motion: the declaration's, then that of each call.
    fn group(&mut self, track: usize, group: usize) -> &mut [Switch];

    /// Lets piecewise functions enter the piece at whose end they are; returns whether there are any.
    fn enter(&mut self, track: usize) -> bool;

    /// Whether a value of the user's functions depends on time.
    fn moves(&self) -> bool;
}
