//! Powers of a high degree. Such a function may be flat except where its base is large, or small in a
//! divisor. Its own series does not show that from afar; the series of the base does.

use super::orders::ROWS;
use super::roots::{self, Crossing, value};
use super::switch::{Reach, shorter, tail};

/// A step ends where a power has grown by this factor (binary logarithm) since its beginning. The value at
/// the end of a step does not count: a rejected step is tried again, and then ends elsewhere.
const RISES: f64 = 4.0;

/// Such a step ends on the flank, where the power is smaller than at its largest by this factor (binary logarithm). At the top itself the
/// derivative of the power vanishes, and a step that ends there would not show a force that is this derivative.
const FLANK: f64 = 2.0;

/// Part of the way to the zero of a divisor that a step goes, and how many steps in a row do so.
const BEFORE_ZERO: f64 = 0.98;
const MOST_NEARS: u8 = 8;

/// The series of the base is accurate enough if its last terms are below this part of the rise that is
/// searched.
const ACCURATE: f64 = 0.1;

/// A power, watched by its base.
#[derive(Clone, Copy, Debug)]
pub(super) struct Power {
    /// Its exponent; negative in a divisor.
    exponent: i32,
    /// The ratio of two values of the base between which the power changes by the factor `2^RISES`.
    part: f64,
    /// The ratio of the base on the flank to that at the top.
    flank: f64,
    /// Number of steps in a row that came nearer to a zero of a divisor.
    nears: u8,
}

impl Power {
    /// The power with an exponent.
    pub(super) fn new(exponent: i32) -> Self {
        let ratio = |factor: f64| (factor / f64::from(exponent.unsigned_abs().max(1))).exp2();
        Self {
            exponent,
            part: ratio(-RISES),
            flank: ratio(if exponent < 0 { FLANK } else { -FLANK }),
            nears: 0,
        }
    }

    /// Whether it has this exponent.
    pub(super) fn is_of(&self, exponent: i32) -> bool {
        self.exponent == exponent
    }

    /// The part of a step of the length `h` that may be taken, from the series of the base.
    #[inline]
    pub(super) fn reach(&mut self, known: &[f64], h: f64, found: &mut Vec<Crossing>) -> Reach {
        let (first, size) = (known[0].abs(), h.abs());
        let rest = known[1..].iter().rev();
        let rest = rest.fold(0.0, |rest, c| (rest + c.abs()) * size);
        // false also if a term is not finite
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

    /// The part of a step on which a divisor may come near zero: up to the flank of its minimum, if it is
    /// much smaller there than at the beginning. Where it vanishes, a step ends before: the quotient has no
    /// value there. If the motion shows nothing of it, it passes after some such steps.
    #[cold]
    fn search_pit(&mut self, known: &[f64], h: f64, found: &mut Vec<Crossing>) -> Reach {
        let least = self.part * known[0].abs();
        let (part, terms) = self.accurate(known, h, |_| known[0].abs());
        let terms = &terms[..known.len()];
        roots::crossings(terms, found);
        let zero = found.first().map(|crossing| BEFORE_ZERO * crossing.at);
        extrema(terms, found);
        let mut extrema = found.iter().map(|crossing| crossing.at);
        let pit = extrema.find(|&at| value(terms, at).abs() < least);
        let pit = pit.map(|at| self.flank_before(terms, at, found));
        let nears = self.nears;
        self.nears = if zero.is_some() {
            nears.saturating_add(1)
        } else {
            0
        };
        let zero = zero.filter(|_| nears < MOST_NEARS);
        let nearest = zero.into_iter().chain(pit).reduce(f64::min);
        match nearest {
            Some(nearest) => Reach::Shorter(part * nearest),
            None if part < 1.0 => Reach::Shorter(part),
            None => Reach::Whole,
        }
    }

    /// The part of a step on which a base may grow: up to the flank of its maximum, within the range in which
    /// its series converges.
    #[cold]
    fn search_hill(&self, known: &[f64], h: f64, found: &mut Vec<Crossing>) -> Reach {
        let first = known[0].abs();
        let (part, terms) = self.accurate(known, h, |terms| {
            extrema(terms, found);
            let ends = [0.0, 1.0].map(|at| value(terms, at).abs());
            let within = found.iter().map(|crossing| value(terms, crossing.at).abs());
            within.fold(ends[0].max(ends[1]), f64::max)
        });
        let terms = &terms[..known.len()];
        let mut extrema = found.iter().map(|crossing| crossing.at);
        match extrema.find(|&at| self.part * value(terms, at).abs() > first) {
            Some(at) => Reach::Shorter(part * self.flank_before(terms, at, found)),
            None if part < 1.0 => Reach::Shorter(part),
            None => Reach::Whole,
        }
    }

    /// The part of a step on which the series of the base is accurate enough to distinguish a base that
    /// changes by much of its size from one that does not, and its terms at the end of that part.
    fn accurate(&self, known: &[f64], h: f64, mut size: impl FnMut(&[f64]) -> f64) -> (f64, [f64; ROWS]) {
        let mut part = 1.0;
        loop {
            let all = terms(known, h * part);
            let terms = &all[..known.len()];
            let (tail, allowed) = (tail(terms), ACCURATE * (1.0 - self.part) * size(terms));
            // with two or three terms the missing ones cannot be estimated
            let is_known = known.len() < 4 || tail <= allowed || tail.is_nan();
            if is_known || part <= f64::EPSILON {
                return (part, all);
            }
            part *= shorter(tail, allowed, known.len() - 1);
        }
    }

    /// The place on the flank before an extremum of the base.
    fn flank_before(&self, terms: &[f64], at: f64, found: &mut Vec<Crossing>) -> f64 {
        let mut above = [0.0; ROWS];
        let above = &mut above[..terms.len()];
        above.copy_from_slice(terms);
        above[0] -= self.flank * value(terms, at);
        roots::crossings(above, found);
        let mut places = found.iter().map(|crossing| crossing.at);
        places.rfind(|place| *place < at).unwrap_or(at)
    }
}

/// The terms of a series at the time `h`.
fn terms(known: &[f64], h: f64) -> [f64; ROWS] {
    let mut power = 1.0;
    let mut terms = [0.0; ROWS];
    for (term, c) in terms.iter_mut().zip(known) {
        *term = c * power;
        power *= h;
    }
    terms
}

/// Finds the extrema of a series on a step.
fn extrema(terms: &[f64], found: &mut Vec<Crossing>) {
    let mut slopes = [0.0; ROWS];
    for (k, (slope, term)) in slopes.iter_mut().zip(&terms[1..]).enumerate() {
        *slope = (k + 1) as f64 * term;
    }
    roots::crossings(&slopes[..terms.len() - 1], found);
}
