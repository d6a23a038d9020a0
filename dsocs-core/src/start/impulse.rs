//! The velocity after a sudden change of parameters.

use super::begin::{momentum, velocity_of};
use super::consistency;
use crate::error::SetupError;
use crate::number::point::AnyPoint;
use crate::solve::dense::Matrix;
use crate::tape::declaration::Declaration;

/// Largest number of iterations for an impulse.
const MAX_ITERATIONS: usize = 50;

/// A change of the velocity below this part of it is rounding.
const SETTLED: f64 = 8.0 * f64::EPSILON;

/// The velocity after a sudden change of parameters, from those of the first declaration to those of the
/// second. The momentum is conserved except for impulses of the constraint forces. If a velocity constraint
/// changes, the impulse of its force brings the velocity onto it, the shortest way in the mass metric. A
/// kinematic constraint `c(q, v, a) = 0` keeps its value: `∂c/∂a Δv = 0`, by an impulse of its own force, as
/// in a fast continuous change.
pub(crate) fn velocity_after(
    sides: &[Declaration<'_>; 2],
    (t, q, v): (f64, &[f64], &[f64]),
) -> Result<Vec<f64>, SetupError> {
    let [before, after] = sides;
    let kept = momentum(before, (t, q, v));
    let free = velocity_of(after, (t, q), &kept, v);
    let (_, velocity) = consistency::project(after, t, q, &free)?;
    let shape = after.shape();
    if shape.kinematic == 0 || shape.is_of_third_order() || velocity == v {
        return Ok(velocity);
    }
    Ok(with_kinematic(sides, (t, q, v), &free).unwrap_or(velocity))
}

/// [`velocity_after`] with kinematic constraints; `free` is the velocity from the momentum alone. `None` if
/// the constraints do not determine it.
fn with_kinematic(
    [before, after]: &[Declaration<'_>; 2],
    (t, q, v): (f64, &[f64], &[f64]),
    free: &[f64],
) -> Option<Vec<f64>> {
    let shape = after.shape();
    let (n, lower) = (v.len(), shape.holonomic + shape.nonholonomic);
    let unknowns = n + shape.multipliers();
    // constraints need not be linear in the accelerations
    let a = super::acceleration(before, (t, q, v), None).map_or_else(|_| vec![0.0; n], |(a, _)| a.to_vec());
    let linear = |side: &Declaration<'_>, v: &[f64]| {
        let point = AnyPoint { t, q, v, a: &a };
        let all = side.continuous_with_jacobian(point, &vec![0.0; unknowns - n]);
        (all.len() == unknowns * (unknowns + 1))
            .then(|| Matrix::from_fn(unknowns, unknowns, |i, j| all[(i + 1) * unknowns + j]))
    };
    let old = linear(before, v)?;
    let mut velocity = free.to_vec();
    for _ in 0..MAX_ITERATIONS {
        let mut matrix = linear(after, &velocity)?;
        for i in lower..lower + shape.kinematic {
            for j in 0..n {
                matrix[(i, j)] = 0.5 * (matrix[(i, j)] + old[(i, j)]);
            }
        }
        // the rows of the lower-order constraints on a velocity: nonholonomic ones, then the rates of
        // holonomic ones
        let asked = after.phase(t, q, &velocity).split_off(shape.holonomic);
        let asked = |row: usize| {
            let place = if row < shape.holonomic {
                shape.nonholonomic + row
            } else {
                row - shape.holonomic
            };
            asked.get(place).copied().unwrap_or(f64::NAN)
        };
        let mut wanted: Vec<f64> = (0..unknowns)
            .map(|i| {
                let along = |to: &[f64]| -> f64 { (0..n).map(|j| matrix[(i, j)] * (to[j] - v[j])).sum() };
                if i < lower {
                    along(&velocity) - asked(i)
                } else if i < lower + shape.kinematic {
                    0.0
                } else {
                    along(free)
                }
            })
            .collect();
        let (singular, lengths) = matrix.equilibrated(&mut wanted)?;
        let mut change = singular.solve(&wanted, f64::EPSILON);
        for (change, length) in change.iter_mut().zip(&lengths) {
            *change /= length;
        }
        let (mut step, mut size) = (0.0_f64, 0.0_f64);
        for j in 0..n {
            let next = v[j] + change[j];
            step = step.max((next - velocity[j]).abs());
            size = size.max(next.abs()).max(v[j].abs());
            velocity[j] = next;
        }
        if !size.is_finite() || velocity.iter().any(|v| !v.is_finite()) {
            return None;
        }
        if step <= SETTLED * size {
            return Some(velocity);
        }
    }
    None
}
