//! Switches: expressions whose sign decides which piece of a function a series continues.
//!
//! The series of `|u|` is that of `u` or of `-u`, and it is right only as long as `u` keeps the sign that the series began with. The same
//! holds for the argument of `signum`, and for the difference of the two sides of a comparison. Recurrences know the series of these
//! arguments. So the first place is found where one of them changes its sign, and the step ends there.
//!
//! A root is never negative, but the series of `√(u²)` is that of `u` or of `-u`, which goes on below zero. The place where it would is a corner. The same holds for
//! angles, as the series of `atan(tan u)` is that of `u` and a constant.

use super::orders::{MAX_ORDER, ROWS};
use super::power::Power;
use crate::series::roots::{self, Crossing};

/// A coefficient is rounding if its term is below this part of the largest.
const ROUNDING: f64 = 1e-12;

/// An argument is zero to rounding if it is below this part of the sum of its terms over a step.
const TOUCHES: f64 = 1e-14;

/// The last terms of an argument have to be below this part of its largest where it may change its sign, and need not be below the second.
const TAIL: [f64; 2] = [1e-3, 1e-9];

/// How often a time is made shorter.
const SHORTENINGS: u32 = 60;

/// How much of a step a shorter one takes at least, where the series of an argument does not converge.
const SHORTEST: f64 = 0.05;

/// How much longer the next part of a step is in which a root is looked for.
const FARTHER: f64 = 8.0;

/// So many terms a series has at least whose later ones are taken as rounding.
const LEAST_TOLD: usize = 6;

/// A series that begins so far outside of the place where a smooth step is visible knows nothing of it.
const FLAT: f64 = 3.0;

/// What a tolerance says of switches.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits {
    /// The part of the largest term that the last terms of an argument may have.
    tail: f64,
    /// How far from its middle a hyperbolic tangent differs from ±1 by more than the tolerance, about.
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

/// An expression whose sign decides how a series goes on.
#[derive(Clone, Debug)]
pub struct Switch {
    /// Its Taylor coefficients; those of lower orders than a series' are known.
    coefficients: [f64; ROWS],
    /// The sign of the piece that the series belongs to; 0 of what has no pieces.
    side: f64,
    /// The sign that the next series is to have; 0 if the value decides.
    set: f64,
    /// The coefficients below this order are zero: the series begins where the switch is.
    leading: usize,
    /// The sum of the terms over the last step.
    scale: f64,
    /// The time after which a series that begins where the switch is has left it by more than rounding.
    leaves: f64,
    /// What depends on it.
    kind: Kind,
}

/// What depends on an argument.
#[derive(Clone, Copy, Debug, Default)]
enum Kind {
    /// A piece of a function.
    #[default]
    Piece,
    /// A smooth function that is flat but for a neighbourhood of zero.
    Steep,
    /// A power of a high degree that it is raised to.
    Power(Power),
    /// It is itself the value of a function that has a bound: the largest absolute value. With zero it is not negative.
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

/// How far a step may go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Reach {
    /// To its end.
    Whole,
    /// Not as far: the series of an argument is not good beyond, or something steep begins.
    Shorter(f64),
    /// Up to a change of sign.
    Crossing(f64),
    /// Up to where the value of a function comes to its bound.
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

    /// Begins the series of the argument of a smooth function that is flat but for a neighbourhood of zero.
    #[inline(always)]
    pub fn steep(&mut self, value: f64) {
        self.coefficients[0] = value;
        self.kind = Kind::Steep;
    }

    /// Begins the series of a value that has a bound.
    #[inline(always)]
    pub fn bounded(&mut self, value: f64, bound: f64) {
        self.coefficients[0] = value;
        self.kind = Kind::Bounded(bound);
    }

    /// Begins the series of the base of a power of a high degree, negative in a divisor: it may be flat but where the power is large.
    #[inline(always)]
    pub fn power(&mut self, value: f64, exponent: i32) {
        self.coefficients[0] = value;
        if !matches!(self.kind, Kind::Power(power) if power.is_of(exponent)) {
            self.kind = Kind::Power(Power::new(exponent));
        }
    }

    /// Takes the coefficient of order `k`.
    #[inline(always)]
    pub fn push(&mut self, k: usize, coefficient: f64) {
        self.coefficients[k.min(MAX_ORDER)] = coefficient;
    }

    /// The sign of the piece.
    pub(crate) fn side(&self) -> f64 {
        self.side
    }

    /// Lets the next series have a sign, or with 0 its own.
    pub(crate) fn set(&mut self, side: f64) {
        self.set = side;
    }

    /// Lets the next series continue the piece of this one.
    pub(crate) fn hold(&mut self) {
        self.set = self.side;
    }

    /// Lets the next series have the sign of the value, if that is on the other side of the piece by more than rounding. Returns whether it is.
    pub(crate) fn lets_go(&mut self) -> bool {
        let is_beyond = self.side * self.coefficients[0] < -TOUCHES * self.scale;
        if is_beyond {
            self.set = 0.0;
        }
        is_beyond
    }

    /// Whether the next series has a sign given.
    pub(crate) fn is_held(&self) -> bool {
        self.set != 0.0
    }

    /// Takes from another switch, which is left, that the series begins where it is.
    pub(crate) fn begins_as(&mut self, other: &mut Self) {
        self.leading = core::mem::take(&mut other.leading);
    }

    /// Sets below which order coefficients are rounding.
    pub(crate) fn begins_with(&mut self, leading: usize) {
        self.leading = leading;
    }

    /// Whether its sign decides between pieces; that of a steep function's argument does not.
    pub(crate) fn may_turn(&self) -> bool {
        self.side != 0.0
    }

    /// Whether it is the value of a function that has a bound.
    pub(crate) fn is_bounded(&self) -> bool {
        matches!(self.kind, Kind::Bounded(_))
    }

    /// Whether the value is exactly zero.
    pub(crate) fn is_zero(&self) -> bool {
        self.may_turn() && self.coefficients[0] == 0.0
    }

    /// Whether the value is on the side of the piece a time `s` after the beginning of a step, in units of its size over the step; negative
    /// where it is not.
    pub(crate) fn margin(&self, s: f64) -> f64 {
        if self.side == 0.0 || self.side.is_nan() || (self.leading > 0 && s <= self.leaves) {
            return f64::INFINITY;
        }
        self.side * self.coefficients[0] / self.scale.max(f64::MIN_POSITIVE)
    }

    /// The time, by the first two terms, between the value and zero, before or after.
    pub(crate) fn takes(&self) -> f64 {
        let [value, rate, ..] = self.coefficients;
        if self.may_turn() && rate != 0.0 {
            (value / rate).abs()
        } else {
            f64::INFINITY
        }
    }

    /// Whether the value is zero, and stays so as far as the series is known.
    pub(crate) fn stays(&self) -> bool {
        let finite = self.coefficients.iter().take_while(|c| c.is_finite());
        self.may_turn() && finite.fold(0.0_f64, |most, c| most.max(c.abs())) == 0.0
    }

    /// The time that is missing, by the first two terms, until the value is beyond the piece.
    pub(crate) fn missing(&self) -> f64 {
        let [value, rate, ..] = self.coefficients;
        if self.side * value > 0.0 && rate != 0.0 {
            (value / rate).abs()
        } else {
            0.0
        }
    }

    /// Whether the value is zero to rounding or beyond.
    pub(crate) fn touches(&self) -> bool {
        (self.side * self.coefficients[0]) <= TOUCHES * self.scale && self.may_turn()
    }

    /// The first order whose term at a time `tau` is more than rounding, and the sign there; beyond the last order with sign 0, if there is
    /// none.
    pub(crate) fn leads(&self, order: usize, tau: f64) -> (usize, f64) {
        let known = &self.coefficients[..order.clamp(2, MAX_ORDER)];
        // the series of a root has no terms beyond some order at its zero
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
            // two or three terms say nothing of those that are missing
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

    /// The time until the argument of a sign is zero, in a direction, by its first three terms.
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

    /// How far a step of the length `h` may go, by the series of the argument to an order; `h` is negative back in time.
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

    /// The same of a value that has two bounds.
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

    /// How many terms tell something. Near a corner the digits of a value that has a bound are lost, the more the higher the order: beyond its smallest term its series is
    /// rounding.
    fn told(&self, terms: &[f64], limits: &Limits) -> usize {
        if !matches!(self.kind, Kind::Bounded(_)) || terms.len() < LEAST_TOLD {
            return terms.len();
        }
        // of an even function every other term is zero
        let pairs = terms.windows(2).map(|pair| pair[0].abs().max(pair[1].abs()));
        let sizes = pairs.enumerate().skip(LEAST_TOLD - 2);
        let first = terms.iter().take(LEAST_TOLD);
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

    /// The same where the terms alone do not tell that there is no change of sign.
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
            let told = self.told(&terms[..=last - from], limits);
            let terms = &mut terms[..told];
            self.leaves = if from == 0 {
                0.0
            } else {
                let far = (4.0 * TOUCHES * sum / terms[0].abs()).powf(1.0 / from as f64);
                (far * part).min(part) * h.abs()
            };
            if !sum.is_finite() {
                part *= 1e-3;
                whole = part;
                // what is not finite at all is the step's to tell
                if part < 1e-300 {
                    return Reach::Whole;
                }
                continue;
            }
            let first = terms[0].abs();
            let rest = sum - first;
            let free = if matches!(self.kind, Kind::Steep) {
                // flat at the beginning: as far as it is flat
                let sign = terms[0].signum();
                for term in terms.iter_mut() {
                    *term *= sign;
                }
                // at a multiple zero rounding is all that is left of the sum
                let visible = limits.visible.max(TOUCHES * sum);
                terms[0] -= visible;
                first - rest > visible
            } else {
                rest < 0.9 * first
            };
            if !free {
                let tail = if told == last - from + 1 && last + 2 >= known.len() && last >= from + 2 {
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

/// The largest of the last third of terms, of two at least: where a motion begins at the zero of a power, only every so many of them are not zero.
pub(super) fn tail(terms: &[f64]) -> f64 {
    let from = terms.len() - (terms.len() / 3).max(2).min(terms.len());
    terms[from..].iter().fold(0.0, |tail, term| tail.max(term.abs()))
}

/// By which part a step is made shorter so that its last terms, of an order, are as small as is allowed.
pub(super) fn shorter(tail: f64, allowed: f64, order: usize) -> f64 {
    (0.9 * (allowed / tail).powf(1.0 / order as f64)).max(SHORTEST)
}

/// The part of a step where its search for the first root begins: terms beyond the first are not much larger than it there. Roots are
/// found to rounding in units of the part that is searched.
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
        // a sum that overflows says nothing of how much
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
    /// How many groups there are; none in a system without any.
    const GROUPS: usize;

    /// A group of one motion: the declaration's, then that of each call.
    fn group(&mut self, track: usize, group: usize) -> &mut [Switch];

    /// Lets functions that are given by pieces begin the piece at whose end they are. Returns whether there are any.
    fn enter(&mut self, track: usize) -> bool;

    /// Whether a value of the user's functions moves.
    fn moves(&self) -> bool;
}
