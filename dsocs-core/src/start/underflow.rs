//! Whether the equations for the acceleration keep their digits at a start, or are so small that numbers have none left for them.

use super::acceleration;
use crate::error::SetupError;
use crate::number::bounded::QUANTUM;
use crate::number::point::AnyPoint;
use crate::regularity::rounding::continuous_underflow;
use crate::solve::convergence::NaturalSizes;
use crate::solve::{Square, Vector};
use crate::tape::declaration::Declaration;

/// An acceleration that has lost this part of itself is refused: the motion is off by as much in one unit of its time.
const LOST: f64 = 1e-10;

/// A position or a velocity below this is none, as that of a motion that has died away.
const NOTHING: f64 = 1e-280;

/// Refuses equations whose terms lie below the smallest normal number, 2.2e-308, so that too little is left of their digits: a step `h` is made of
/// terms that are smaller by `h`, and one of a series of terms as they are, where none is given.
#[cold]
pub(crate) fn check(
    declaration: &Declaration<'_>,
    (t, q, v): (f64, &[f64], &[f64]),
    h: Option<f64>,
) -> Result<(), SetupError> {
    // other errors tell more of what has no acceleration
    let Ok((a, multipliers)) = acceleration(declaration, (t, q, v), None) else {
        return Ok(());
    };
    let point = AnyPoint { t, q, v, a: &a };
    let size = a.len() + multipliers.len();
    let (mut rows, mut jacobian) = (Vector::nan(size), Square::zero(size));
    declaration.linearize_continuous(point, &multipliers, &mut rows, jacobian.entries_mut());
    let part = h.map_or(1.0, |h| h.abs().min(1.0));
    // a row that vanishes at the start will not do so later
    let lost = continuous_underflow(declaration, point, &multipliers)
        .into_iter()
        .map(|lost| lost.max(QUANTUM) / part)
        .collect::<Vec<_>>();
    let Some(lost) = NaturalSizes::new(&jacobian, &lost, &[]) else {
        return Ok(());
    };
    let coordinates = declaration.coordinates().iter().enumerate();
    let mut wrong = coordinates.filter_map(|(i, coordinate)| {
        let (lost, moves) = (*lost.sizes().get(i)?, q[i].abs().max(v[i].abs()) > NOTHING);
        // what moves with this velocity is off by 1e-6 of it after ten thousand steps that lose as much
        let size = a[i].abs().max(h.map_or(0.0, |h| v[i].abs() / h.abs()));
        (moves && size > 0.0 && lost > LOST * size).then(|| SetupError::Underflow {
            coordinate: coordinate.name.clone(),
            acceleration: a[i],
            lost,
        })
    });
    wrong.next().map_or(Ok(()), Err)
}
