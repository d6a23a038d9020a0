//! The first half of the first leg, where a function jumps with the velocity.
//!
//! A step is a motion from the middle of one leg to that of the next (see [`crate::regularity::sticking`]). The start has to lead to the middle of
//! the first leg as accurately: if an argument changes its sign before, the acceleration of the start does not act until there.

use crate::number::{larger, largest};
use crate::regularity::resting::AtPoint;
use crate::regularity::sticking;
use crate::solve::Vector;
use crate::solve::rotation;
use crate::step::switches::Crossing;
use crate::tape::declaration::Declaration;

/// Largest number of arrivals at zero, for each argument.
const ARRIVALS: usize = 4;

/// A function jumps if the accelerations on both sides differ by more than this part of that at the start: that of a root vanishes with its argument.
const JUMPS: f64 = 1e-3;

/// The acceleration whose part over the half leg changes the velocity as the motion does, if a function jumps with the velocity there, and `a0`
/// is the acceleration at the start; `None` if none does. Arguments and velocities change linearly, to second order.
#[cold]
pub(crate) fn mean_acceleration(
    declaration: &Declaration<'_>,
    h: f64,
    (t0, q0, v0): (f64, &[f64], &[f64]),
    a0: &[f64],
) -> Option<Vector> {
    let (rotations, multipliers) = (&declaration.shape().rotations, declaration.shape().multipliers());
    let (mut t, mut q, mut v, mut a) = (t0, q0.to_vec(), v0.to_vec(), a0.to_vec());
    let begin = declaration.side_arguments(t, &q, &v);
    let mut zero = sticking::zero(declaration, t, &q, &v);
    // an argument that begins at zero has its side from the acceleration, and is not looked at
    let mut sides: Vec<f64> = zero
        .iter()
        .zip(begin)
        .map(|(zero, argument)| if *zero { 0.0 } else { argument.signum() })
        .collect();
    let (middle, mut arrived) = (t0 + 0.5 * h, false);
    for _ in 0..=ARRIVALS * zero.len() {
        let left = middle - t;
        let ahead = |part: f64| {
            let by = part * left;
            let way: Vec<f64> = v.iter().zip(&a).map(|(v, a)| by * (v + 0.5 * by * a)).collect();
            let then: Vec<f64> = v.iter().zip(&a).map(|(v, a)| v + by * a).collect();
            (t + by, rotation::moved(rotations, &q, &way), then)
        };
        let arguments = |part: f64| {
            let (t, q, v) = ahead(part);
            declaration.side_arguments(t, &q, &v)
        };
        let end = arguments(1.0);
        let arrives = (0..zero.len()).filter(|&g| sides[g] * end[g] < 0.0);
        let place = |g: usize| Crossing::found(g, [0.0, 1.0], |part| sides[g] * arguments(part)[g]).parts[1];
        let arrivals: Vec<(usize, f64)> = arrives.map(|g| (g, place(g))).collect();
        let Some(first) = arrivals.iter().map(|(_, part)| *part).reduce(f64::min) else {
            let change = v.iter().zip(&a).zip(v0).map(|((v, a), v0)| (v - v0) + left * a);
            return arrived.then(|| Vector::of(&change.collect::<Vec<f64>>()).map(|dv| dv / (0.5 * h)));
        };
        (t, q, v) = ahead(first);
        arrived = true;
        for (g, part) in arrivals {
            zero[g] |= part <= first;
        }
        let point = AtPoint::new(*declaration, (t, &q, &v));
        let on_side = |side: f64| {
            let own = sides
                .iter()
                .zip(&zero)
                .map(|(own, zero)| if *zero { side } else { *own });
            point.unknowns(&own.collect::<Vec<f64>>(), &zero, multipliers)
        };
        let apart = on_side(1.0)?.into_iter().zip(on_side(-1.0)?).take(a.len());
        let apart = apart.fold(0.0_f64, |most, (one, other)| larger(most, (one - other).abs()));
        if apart <= JUMPS * largest(a0) || apart.is_nan() {
            return None;
        }
        let found = point.solve(&zero, multipliers, Some(&a))?;
        a = found.x.get(..a.len())?.to_vec();
        for (side, piece) in sides
            .iter_mut()
            .zip(&found.pieces)
            .filter(|(side, _)| **side != 0.0)
        {
            *side = piece.side();
        }
        zero = found.still;
    }
    None
}
