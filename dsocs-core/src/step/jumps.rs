//! Whether a force or an acceleration jumps on the way of a step.
//!
//! It is evaluated at some places of the way. What a step resolves changes there as a polynomial of low degree does.

use crate::solve::Vector;
use crate::start;
use crate::start::place::{Place, Way};
use crate::tape::declaration::Declaration;

/// In so many equal parts a way is divided.
const PLACES: u8 = 16;

/// So many of them are a part of the way in which what is smooth is nearly linear.
const QUARTER: usize = 4;

/// What is smooth departs from a straight line over a quarter of the way by less than this part of its departure over the whole: a parabola by 0.06, and
/// what grows with the sixth power of the time from a start at rest, as the cube of a position does, by 0.18. What jumps departs by as much.
const STRAIGHT: f64 = 0.19;

/// What has a multiple zero on the way departs by more, but hardly from a polynomial of this degree.
const DEGREE: usize = 5;

/// It does so by less than this part of its range. A jump departs by a quarter, at least; tanh(t/w) by 0.02 to 0.1 if w is a tenth of the step, and by
/// 0.004 to 0.013 if it is a quarter.
const LEFT: f64 = 0.004;

/// What departs by more than this part of itself is unresolved.
pub(crate) const UNRESOLVED: f64 = 0.1;

/// A jump of an acceleration is told that is larger than this part of itself.
pub(crate) const TOLD: f64 = 1e-3;

/// The places of a way, from 0 to 1.
pub(crate) fn places() -> impl Iterator<Item = f64> {
    (0..=PLACES).map(|place| f64::from(place) / f64::from(PLACES))
}

/// How far equally spaced values are from the straight line between the first and the last.
pub(crate) fn aside(values: &[f64]) -> f64 {
    let (Some(first), Some(last)) = (values.first(), values.last()) else {
        return 0.0;
    };
    let count = values.len().saturating_sub(1).max(1) as f64;
    let asides = values.iter().enumerate().map(|(k, value)| {
        let line = first + k as f64 / count * (last - first);
        (value - line).abs()
    });
    asides.fold(0.0, f64::max)
}

/// Whether values at the places of a way are those of something smooth.
pub(crate) fn is_smooth(values: &[f64]) -> bool {
    let quarters = values.windows(QUARTER + 1).step_by(QUARTER).map(aside);
    quarters.fold(0.0, f64::max) <= STRAIGHT * aside(values) || is_polynomial(values)
}

/// How far accelerations at the places of a way depart from a straight line, relative to themselves: the largest of all components that are not smooth.
pub(crate) fn departure(accelerations: &[Vector]) -> f64 {
    let components = accelerations.first().map_or(0, |a| a.len());
    let departures = (0..components).map(|i| {
        let values: Vec<f64> = accelerations.iter().map(|a| a[i]).collect();
        if is_smooth(&values) {
            return 0.0;
        }
        let [least, most] = range(values.iter().copied());
        aside(&values) / most.abs().max(least.abs())
    });
    departures.fold(0.0, f64::max)
}

/// Whether they are nearly those of a polynomial of low degree, as its distance by least squares tells.
fn is_polynomial(values: &[f64]) -> bool {
    let [least, most] = range(values.iter().copied());
    let product = |x: &[f64], y: &[f64]| -> f64 { x.iter().zip(y).map(|(x, y)| x * y).sum() };
    let take = |from: &mut [f64], part: f64, of: &[f64]| {
        for (from, of) in from.iter_mut().zip(of) {
            *from -= part * of;
        }
    };
    // orthogonal polynomials, each the one before times the place
    let mut basis: Vec<Vec<f64>> = Vec::with_capacity(DEGREE + 1);
    let mut rest: Vec<f64> = values.to_vec();
    for _ in 0..=DEGREE {
        let mut next: Vec<f64> = match basis.last() {
            Some(last) => last.iter().zip(places()).map(|(p, x)| p * (x - 0.5)).collect(),
            None => vec![1.0; values.len()],
        };
        for p in &basis {
            let part = product(&next, p) / product(p, p);
            take(&mut next, part, p);
        }
        let part = product(&rest, &next) / product(&next, &next);
        take(&mut rest, part, &next);
        basis.push(next);
    }
    rest.iter().all(|rest| rest.abs() <= LEFT * (most - least))
}

/// The accelerations at equally spaced places of a way, from 0 to 1; `None` where the equations do not determine one.
pub(crate) fn accelerations(declaration: &Declaration<'_>, way: &Way<'_>) -> Option<Vec<Vector>> {
    let accelerations = places().map(|part| {
        let Place { t, q, v, .. } = way(part);
        let found = start::acceleration(declaration, (t, &q, &v), None);
        found.ok().map(|(a, _)| a)
    });
    accelerations.collect()
}

/// The least and the greatest of some numbers.
pub(crate) fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], x| {
        [least.min(x), most.max(x)]
    })
}

/// What moves a node by less than the rounding of an increment is no jump: the largest acceleration of which that can be said.
pub(crate) fn rounding(h: f64, d: f64) -> f64 {
    f64::EPSILON * d.abs() / (h * h)
}
