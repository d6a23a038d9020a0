//! Loss of digits by underflow in the equations for the acceleration at a start.

use super::acceleration;
use crate::error::SetupError;
use crate::number::bounded::QUANTUM;
use crate::number::point::AnyPoint;
use crate::regularity::rounding::continuous_underflow;
use crate::solve::convergence::NaturalSizes;
use crate::solve::{Square, Vector};
use crate::tape::declaration::Declaration;

/// Largest relative loss of an acceleration: the motion has about the same relative error after one unit of
/// its time.
const LOST: f64 = 1e-10;

/// A position or a velocity below this counts as zero, such as that of a motion that has died away.
const NOTHING: f64 = 1e-280;

/// Part of a position or a velocity, per unit of time, below which an acceleration moves nothing: a force that is far from where it acts may
/// underflow, as that of a narrow well does.
const STILL: f64 = 1e-100;

/// Refuses equations with terms so far below the smallest normal number, 2.2e-308, that too few digits are
/// left. The terms of a step `h` are smaller by the factor `h`; without a step, those of a series are taken.
#[cold]
pub(crate) fn check(
    declaration: &Declaration<'_>,
    (t, q, v): (f64, &[f64], &[f64]),
    h: Option<f64>,
) -> Result<(), SetupError> {
    // other errors are more specific about an acceleration that does not exist
    let Ok((a, multipliers)) = acceleration(declaration, (t, q, v), None) else {
        return Ok(());
    };
    let point = AnyPoint { t, q, v, a: &a };
    let size = a.len() + multipliers.len();
    let (mut rows, mut jacobian) = (Vector::nan(size), Square::zero(size));
    declaration.linearize_continuous(point, &multipliers, &mut rows, jacobian.entries_mut());
    let part = h.map_or(1.0, |h| h.abs().min(1.0));
    // a row that vanishes at the start will not vanish later
    let lost = continuous_underflow(declaration, point, &multipliers)
        .into_iter()
        .map(|lost| lost.max(QUANTUM) / part)
        .collect::<Vec<_>>();
    let Some(lost) = NaturalSizes::new(&jacobian, &lost, &[]) else {
        return Ok(());
    };
    let coordinates = declaration.coordinates().iter().enumerate();
    let mut wrong = coordinates.filter_map(|(i, coordinate)| {
        let (lost, largest) = (*lost.sizes().get(i)?, q[i].abs().max(v[i].abs()));
        let moves = largest > NOTHING && lost > STILL * largest;
        // with this loss, the velocity has a relative error of 1e-6 after ten thousand steps
        let size = a[i].abs().max(h.map_or(0.0, |h| v[i].abs() / h.abs()));
        (moves && size > 0.0 && lost > LOST * size).then(|| SetupError::Underflow {
            coordinate: coordinate.name.clone(),
            acceleration: a[i],
            lost,
        })
    });
    wrong.next().map_or(Ok(()), Err)
}
