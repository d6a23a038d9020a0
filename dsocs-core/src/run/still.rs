//! Functions of events that stay zero, as a velocity does while a body rests.
//!
//! There a function has no sign: rounding decides on it, and on that of a polynomial that ends or begins there.
//! So the sign before the rest is kept until the function leaves zero; if it does so to the other side, that is
//! the event.

use super::AnyPolynomial;
use super::events::{AnyEvents, expand, shifted};
use crate::number::larger;
use crate::number::point::{AnyPoint, OwnedPoint};
use crate::regularity::resting::{AtPoint, Held};
use crate::regularity::sides::Piece;
use crate::tape::declaration::Declaration;

/// A function below this many times the change by one rounding of the motion is zero.
const ROUNDINGS: f64 = 16.0;

impl AnyEvents<'_> {
    /// Corrects the changes of sign that were found for a function, from `first` on, on a polynomial at one end
    /// of which the function stays zero. `side` is the sign after the polynomial.
    pub(super) fn settle(
        &mut self,
        declaration: &Declaration<'_>,
        polynomial: &AnyPolynomial<'_>,
        (place, first): (usize, usize),
        side: &mut f64,
    ) {
        let ends = [
            (polynomial.from, polynomial.resting[0]),
            (polynomial.to, polynomial.resting[1]),
        ];
        let [begins, arrives] = ends.map(|end| self.near_zero(declaration, polynomial, place, end));
        // at the start of a run the sign is not known before the first polynomial
        let before = match self.sides[place] {
            side if side == 0.0 && !begins.is_zero => begins.value.signum(),
            side => side,
        };
        if !begins.stays && !arrives.stays {
            let joins = polynomial.search.joins && declaration.sides() > 0 && arrives.is_zero;
            // the next polynomial shows whether the function stays zero or passes
            if joins
                && let Some((s, rising)) = self
                    .found
                    .get(first..)
                    .and_then(<[_]>::last)
                    .map(|&(s, _, rising)| (s, rising))
            {
                let way = (polynomial.to - s).abs() / polynomial.length().abs();
                if way * arrives.slope <= arrives.noise {
                    self.found.pop();
                    *side = if rising { -1.0 } else { 1.0 };
                }
            }
            return;
        }
        let last = self.found.get(first..).and_then(<[_]>::last).copied();
        self.found.truncate(first);
        *side = before;
        if arrives.stays || arrives.is_zero {
            return;
        }
        let rising = arrives.value > 0.0;
        *side = arrives.value.signum();
        if before * *side < 0.0 {
            let at = last.filter(|(_, _, up)| *up == rising);
            let at = at.map_or(polynomial.from, |(s, ..)| s);
            self.found.push((at, place, rising));
        }
    }

    /// The function of an event at a time `s` after the point of expansion, where some arguments rest.
    fn near_zero(
        &mut self,
        declaration: &Declaration<'_>,
        polynomial: &AnyPolynomial<'_>,
        place: usize,
        (s, resting): (f64, &[bool]),
    ) -> Near {
        let length = polynomial.length().abs();
        let series = shifted(polynomial, s);
        let coefficients = expand(&self.watched[place], declaration, &series, &mut self.work.call);
        let [value, rate] = [0, 1].map(|k| coefficients.get(k).copied().unwrap_or(f64::NAN));
        let mut point = OwnedPoint::zero(declaration.dimension());
        polynomial.point(s, &mut point);
        let rests = resting.contains(&true) && hold(declaration, resting, &mut point);
        let value = if rests {
            self.watched[place].value_at(declaration, &point, &mut self.work)
        } else {
            value
        };
        let noise = self.rounding(declaration, polynomial, place, (&point, value));
        let is_zero = value.abs() <= noise;
        let slope = (rate * length).abs();
        Near {
            value,
            slope,
            noise,
            is_zero,
            stays: is_zero && (rests || slope <= noise),
        }
    }

    /// The change of the function of an event, from its value at a point of a polynomial, by some roundings of the motion.
    pub(super) fn rounding(
        &mut self,
        declaration: &Declaration<'_>,
        polynomial: &AnyPolynomial<'_>,
        place: usize,
        (point, value): (&OwnedPoint<f64>, f64),
    ) -> f64 {
        let length = polynomial.length().abs();
        // positions round; velocities and accelerations as differences of them, and of the largest velocity
        let mut fastest = 0.0;
        let mut end_point = OwnedPoint::zero(declaration.dimension());
        for end in [polynomial.from, polynomial.to] {
            polynomial.point(end, &mut end_point);
            let AnyPoint { v, a, .. } = end_point.any();
            let speeds = v.iter().copied().chain(a.iter().map(|a| length * a));
            fastest = speeds.fold(fastest, |most: f64, speed| larger(most, speed.abs()));
        }
        let mut noise = 0.0;
        for i in 0..declaration.dimension() {
            let q = f64::EPSILON * larger(point.any().q[i].abs(), length * fastest);
            for (kind, rounding) in [q, q / length, q / (length * length)].into_iter().enumerate() {
                let mut moved = point.clone();
                moved.parts().0[kind][i] += rounding;
                noise += (self.watched[place].value_at(declaration, &moved, &mut self.work) - value).abs();
            }
        }
        ROUNDINGS * noise
    }
}

/// Corrects the velocity of a point at which some arguments rest, so that they are zero: the velocity of a node is a difference of positions
/// before and after it, and that of a surface is not. `false` if the resting motion is not determined.
fn hold(declaration: &Declaration<'_>, resting: &[bool], point: &mut OwnedPoint<f64>) -> bool {
    let AnyPoint { t, q, v, a } = point.any();
    let at = AtPoint::new(*declaration, (t, q, v));
    let arguments = at.arguments().into_iter().zip(resting);
    let pieces: Vec<Piece> = arguments
        .map(|(argument, rests)| {
            if *rests {
                Piece::Between
            } else {
                Piece::of(argument)
            }
        })
        .collect();
    let guess = Held::guess(a, declaration.shape().multipliers(), pieces.len());
    let Some(held) = at.held(&pieces, &guess) else {
        return false;
    };
    let v = &mut point.parts().0[1];
    v.iter_mut().zip(held.correction).for_each(|(v, by)| *v += by);
    true
}

/// A function near an end of a polynomial.
struct Near {
    value: f64,
    /// Its rate times the length of the polynomial.
    slope: f64,
    /// Its rounding.
    noise: f64,
    /// Whether it is zero to rounding.
    is_zero: bool,
    /// Whether its rate is zero, too.
    stays: bool,
}
