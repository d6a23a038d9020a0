//! Whether a force or an acceleration jumps on the way of a step.
//!
//! It is evaluated at some places of the way. What a step resolves changes there as a polynomial of low degree does.

use crate::solve::Vector;
use crate::start;
use crate::tape::declaration::Declaration;

/// In so many equal parts a way is divided.
const PLACES: u8 = 16;

/// The degree of the polynomials that a step resolves. Lower ones do not hold a force that grows from nothing as the cube of a position does, after a start
/// at rest, nor one with a multiple zero; higher ones follow a switch.
const DEGREE: usize = 4;

/// What a step resolves departs from a polynomial of this degree by less than this part of its range: the sixth power of the time by 0.042, wherever its
/// zero lies; a jump by a third, at least; tanh(t/w) by 0.04 to 0.15 if w is a tenth of the step, and by 0.014 to 0.044 if it is a fifth.
const LEFT: f64 = 0.05;

/// What departs by more than this part of itself is unresolved.
pub(crate) const UNRESOLVED: f64 = 0.1;

/// The places of a way, from 0 to 1.
pub(crate) fn places() -> impl Iterator<Item = f64> {
    (0..=PLACES).map(|place| f64::from(place) / f64::from(PLACES))
}

/// Whether values at the places of a way are nearly those of a polynomial of low degree, as its distance by least squares tells.
pub(crate) fn is_smooth(values: &[f64]) -> bool {
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

/// The accelerations at equally spaced places of a way, from 0 to 1: time, position and velocity; `None` where the equations do not determine one.
pub(crate) fn accelerations(
    declaration: &Declaration<'_>,
    way: impl Fn(f64) -> (f64, Vector, Vector),
) -> Option<Vec<Vector>> {
    let accelerations = places().map(|part| {
        let (t, q, v) = way(part);
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

/// How much the acceleration jumps on a way, relative to itself: the largest of all components. The way
/// takes the time `h` and leads about as far as the increment `d`.
pub(crate) fn of_acceleration(accelerations: &[Vector], h: f64, d: &[f64]) -> f64 {
    let jump = |i: usize| {
        let [least, most] = range(accelerations.iter().map(|a| a[i]));
        let jumps = accelerations
            .windows(2)
            .map(|pair| (pair[1][i] - pair[0][i]).abs());
        let widest = jumps.fold(0.0, f64::max);
        // what moves a node by less than the rounding of the increment is no jump
        let is_rounding = widest * h * h <= f64::EPSILON * d[i].abs();
        // what is smooth changes little from place to place
        let is_jump = !is_rounding && widest >= 0.5 * (most - least);
        if is_jump {
            widest / most.abs().max(least.abs())
        } else {
            0.0
        }
    };
    (0..d.len()).map(jump).fold(0.0, f64::max)
}
