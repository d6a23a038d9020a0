//! Powers of a high degree: a function may be flat but where what is raised to one is large, or small in a divisor. Its series tells nothing of that from afar, that of
//! the base does.

use super::orders::ROWS;
use super::roots::{self, Crossing, value};
use super::switch::{Reach, shorter, tail};

/// A power is narrow where it is so many times what it is at the beginning of a step (binary logarithm). What it is at the end says nothing: a step that is not
/// good is tried again, and then ends elsewhere.
const RISES: f64 = 4.0;

/// Which part of the way to its zero a step goes, and how many steps in a row do so.
const BEFORE_ZERO: f64 = 0.98;
const MOST_NEARS: u8 = 8;

/// The last terms of the base are below this part of what it has to rise by.
const TOLD: f64 = 0.1;

/// A power.
#[derive(Clone, Copy, Debug)]
pub(super) struct Power {
    /// Its exponent; that of a divisor is negative.
    exponent: i32,
    /// Which part of its value on the way the base has at the beginning of a step where the power rises by so much, or the other way round.
    part: f64,
    /// In how many steps in a row a divisor has come nearer to zero.
    nears: u8,
}

impl Power {
    /// Of an exponent.
    pub(super) fn new(exponent: i32) -> Self {
        Self {
            exponent,
            part: (-RISES / f64::from(exponent.unsigned_abs().max(1))).exp2(),
            nears: 0,
        }
    }

    /// Whether it has this exponent.
    pub(super) fn is_of(&self, exponent: i32) -> bool {
        self.exponent == exponent
    }

    /// How far a step of the length `h` may go, by the series of the base.
    #[inline]
    pub(super) fn reach(&mut self, known: &[f64], h: f64, found: &mut Vec<Crossing>) -> Reach {
        let (first, size) = (known[0].abs(), h.abs());
        let rest = known[1..].iter().rev();
        let rest = rest.fold(0.0, |rest, c| (rest + c.abs()) * size);
        // false where a term is not finite, too
        if rest < (1.0 - self.part) * first || !rest.is_finite() {
            self.nears = 0;
            return Reach::Whole;
        }
        if self.exponent < 0 {
            self.search_pit(known, h, found)
        } else {
            self.search_hill(known, h, found)
        }
    }

    /// How far a step may go on whose way a divisor may come near zero: to where it is nearest, if it is much nearer there than at the beginning. Where it
    /// is zero, a step ends before: what is divided by it has no value there, and if the motion shows nothing of it, it goes on after some such steps.
    #[cold]
    fn search_pit(&mut self, known: &[f64], h: f64, found: &mut Vec<Crossing>) -> Reach {
        let terms = &terms(known, h)[..known.len()];
        roots::crossings(terms, found);
        let zero = found.first().map(|crossing| BEFORE_ZERO * crossing.at);
        let least = self.part * value(terms, 0.0).abs();
        extrema(terms, found);
        let mut extrema = found.iter().map(|crossing| crossing.at);
        let pit = extrema.find(|&at| value(terms, at).abs() < least);
        let nears = self.nears;
        self.nears = if zero.is_some() {
            nears.saturating_add(1)
        } else {
            0
        };
        let zero = zero.filter(|_| nears < MOST_NEARS);
        let nearest = zero.into_iter().chain(pit).reduce(f64::min);
        nearest.map_or(Reach::Whole, Reach::Shorter)
    }

    /// How far a step may go on whose way a base may become larger than at the beginning: to where it is largest, and no farther than its series converges.
    #[cold]
    fn search_hill(&self, known: &[f64], h: f64, found: &mut Vec<Crossing>) -> Reach {
        let mut part = 1.0;
        loop {
            let terms = &terms(known, h * part)[..known.len()];
            let [first, last] = [0.0, 1.0].map(|at| value(terms, at).abs());
            extrema(terms, found);
            let mut extrema = found.iter().map(|crossing| crossing.at);
            let largest = extrema
                .clone()
                .fold(first.max(last), |largest, at| largest.max(value(terms, at).abs()));
            // so that a base is told from one that does not rise
            let (tail, allowed) = (tail(terms), TOLD * (1.0 - self.part) * largest);
            // two or three terms say nothing of those that are missing
            if known.len() >= 4 && tail > allowed && part > f64::EPSILON {
                part *= shorter(tail, allowed, known.len() - 1);
                continue;
            }
            return match extrema.find(|&at| self.part * value(terms, at).abs() > first) {
                Some(at) => Reach::Shorter(part * at),
                None if part < 1.0 => Reach::Shorter(part),
                None => Reach::Whole,
            };
        }
    }
}

/// The terms of a series a time `h` later.
fn terms(known: &[f64], h: f64) -> [f64; ROWS] {
    let mut power = 1.0;
    let mut terms = [0.0; ROWS];
    for (term, c) in terms.iter_mut().zip(known) {
        *term = c * power;
        power *= h;
    }
    terms
}

/// Finds where it is largest or smallest on the way.
fn extrema(terms: &[f64], found: &mut Vec<Crossing>) {
    let mut slopes = [0.0; ROWS];
    for (k, (slope, term)) in slopes.iter_mut().zip(&terms[1..]).enumerate() {
        *slope = (k + 1) as f64 * term;
    }
    roots::crossings(&slopes[..terms.len() - 1], found);
}
