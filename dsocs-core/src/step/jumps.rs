//! Jumps of a force or an acceleration on the path of a step.
//!
//! It is evaluated at equally spaced places of the path. A resolved quantity is close to a polynomial of low
//! degree there.

use crate::solve::Vector;
use crate::start;
use crate::start::place::{MotionPath, Place};
use crate::tape::declaration::Declaration;

/// Number of equal parts of a path.
const PLACES: u8 = 16;

/// Number of them in a quarter of the path, where a smooth quantity is nearly linear.
const QUARTER: usize = 4;

/// A smooth quantity deviates from a straight line over a quarter of the path by less than this part of its
/// deviation over the whole: a parabola by 0.06, and one that grows with the sixth power of the time, as the
/// cube of a position does from rest, by 0.18. A jump deviates by as much over a quarter as over the whole.
const STRAIGHT: f64 = 0.19;

/// A quantity with a multiple zero on the path deviates by more, but is close to a polynomial of this degree.
const DEGREE: usize = 5;

/// Its largest distance from that polynomial, relative to its range. A jump has at least a quarter; tanh(t/w)
/// has 0.02 to 0.1 if w is a tenth of the step, and 0.004 to 0.013 if it is a quarter.
const LEFT: f64 = 0.004;

/// An acceleration that deviates by more than this part of itself is unresolved.
pub(crate) const UNRESOLVED: f64 = 0.1;

/// A jump of the acceleration larger than this part of itself is reported.
pub(crate) const REPORTED: f64 = 1e-3;

/// The places of a path, from 0 to 1.
pub(crate) fn places() -> impl Iterator<Item = f64> {
    (0..=PLACES).map(|place| f64::from(place) / f64::from(PLACES))
}

/// Largest distance of equally spaced values from the straight line between the first and the last.
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

/// Whether values at the places of a path are those of a smooth quantity.
pub(crate) fn is_smooth(values: &[f64]) -> bool {
    let quarters = values.windows(QUARTER + 1).step_by(QUARTER).map(aside);
    quarters.fold(0.0, f64::max) <= STRAIGHT * aside(values) || is_polynomial(values)
}

/// Deviation of the accelerations at the places of a path from a straight line, relative to themselves: the
/// largest of all components that are not smooth, and deviate by more than their `noise`.
pub(crate) fn departure(accelerations: &[Vector], noise: impl Fn(usize) -> f64) -> f64 {
    let components = accelerations.first().map_or(0, |a| a.len());
    let departures = (0..components).map(|i| {
        let values: Vec<f64> = accelerations.iter().map(|a| a[i]).collect();
        let aside = aside(&values);
        if is_smooth(&values) || aside <= noise(i) {
            return 0.0;
        }
        let [least, most] = range(values.iter().copied());
        aside / most.abs().max(least.abs())
    });
    departures.fold(0.0, f64::max)
}

/// Whether values are close to a polynomial of degree [`DEGREE`], by least squares.
fn is_polynomial(values: &[f64]) -> bool {
    let [least, most] = range(values.iter().copied());
    let product = |x: &[f64], y: &[f64]| -> f64 { x.iter().zip(y).map(|(x, y)| x * y).sum() };
    let take = |from: &mut [f64], part: f64, of: &[f64]| {
        for (from, of) in from.iter_mut().zip(of) {
            *from -= part * of;
        }
    };
    // orthogonal polynomials, each from the one before times the place
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

/// The accelerations at the places of a path; `None` if the equations do not determine one.
pub(crate) fn accelerations(declaration: &Declaration<'_>, path: &MotionPath<'_>) -> Option<Vec<Vector>> {
    let accelerations = places().map(|part| {
        let Place { t, q, v, .. } = path(part);
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

/// The acceleration that moves a node by one rounding of the increment `d`: a smaller jump cannot be noticed.
pub(crate) fn rounding(h: f64, d: f64) -> f64 {
    f64::EPSILON * d.abs() / (h * h)
}
