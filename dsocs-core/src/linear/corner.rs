//! Whether the equations are smooth at a point.
//!
//! Every piecewise function, and every divisor that may vanish, has an argument in the declaration that is
//! zero there. This alone is no corner: the drag `-c |v| v` is smooth at rest. So the motion and its
//! derivatives are compared on both sides of the zero, at two distances: a difference that does not shrink
//! with the distance is a jump.

use std::borrow::Cow;

use super::continuous::acceleration_slopes;
use super::error::LinearizationError;
use super::slopes::{At, Slopes};
use crate::geometry::Triple;
use crate::solve::rotation;
use crate::start;
use crate::tape::declaration::Declaration;
use crate::tape::{Leaf, Part, Segment};

/// An argument below this part of its terms is zero.
const ZERO: f64 = 64.0 * f64::EPSILON;

/// The larger distance to either side, relative to the state, or absolute where that is below 1.
const FAR: f64 = 1e-4;

/// The ratio of the smaller distance to the larger.
const NEARER: f64 = 1.0 / 64.0;

/// A difference at the smaller distance above this part of that at the larger does not shrink.
const SHRINKS: f64 = 0.25;

/// A difference below this part of the values themselves is rounding.
const ROUNDING: f64 = 1e-9;

/// Checks that the equations are smooth.
pub(super) fn check(declaration: &Declaration<'_>, at: &At<'_>) -> Result<(), LinearizationError> {
    if declaration.switches() == 0 {
        return Ok(());
    }
    let arguments = at.slopes(declaration, &[(Segment::Switches, Part::All)]);
    for argument in 0..arguments.values.len() {
        if is_zero(&arguments, argument, at, declaration) && is_corner(&arguments, argument, at, declaration)
        {
            return Err(LinearizationError::Corner {
                q: at.q.to_vec(),
                v: at.v.to_vec(),
                depends_on: names(&arguments, argument, declaration),
            });
        }
    }
    Ok(())
}

/// Checks that no argument changes its sign within a step, whose derivative would be that of one side alone.
pub(super) fn check_triple(
    declaration: &Declaration<'_>,
    h: f64,
    triple: &Triple,
    at: &At<'_>,
) -> Result<(), LinearizationError> {
    if declaration.switches() == 0 {
        return Ok(());
    }
    let (first, last) = (triple.first(), triple.last(h));
    let rotations = &declaration.shape().rotations;
    let back: Vec<f64> = first.d.iter().map(|d| -d).collect();
    let q0 = rotation::moved(rotations, first.q, &back);
    let q2 = rotation::moved(rotations, first.q, &last.d);
    let rate = |d: &[f64]| -> Vec<f64> { d.iter().map(|d| d / h).collect() };
    // arguments may depend on the acceleration only in third order, which has no linear model
    let a = vec![0.0; q0.len()];
    let before = declaration.switch_arguments(first.t - h, &q0, &rate(first.d), &a);
    let after = declaration.switch_arguments(last.t, &q2, &rate(&last.d), &a);
    let mut both = before.iter().zip(&after).enumerate();
    match both.find(|(_, (before, after))| **before * **after < 0.0) {
        None => Ok(()),
        Some((argument, _)) => {
            let arguments = at.slopes(declaration, &[(Segment::Switches, Part::All)]);
            Err(LinearizationError::Corner {
                q: at.q.to_vec(),
                v: at.v.to_vec(),
                depends_on: names(&arguments, argument, declaration),
            })
        }
    }
}

/// Whether an argument is zero to rounding.
fn is_zero(arguments: &Slopes, argument: usize, at: &At<'_>, declaration: &Declaration<'_>) -> bool {
    let terms = arguments.moving(argument).map(|(leaf, slope)| {
        let value = at.value(declaration, leaf);
        (slope * value).abs()
    });
    arguments.values[argument].abs() <= ZERO * terms.sum::<f64>()
}

/// The names of the quantities that an argument depends on.
fn names(arguments: &Slopes, argument: usize, declaration: &Declaration<'_>) -> Vec<Cow<'static, str>> {
    let coordinate = |i: usize| declaration.coordinates().get(i).map(|own| own.name.clone());
    let named = arguments.moving(argument).filter_map(|(leaf, _)| match leaf {
        Leaf::Q(i) => coordinate(i),
        Leaf::V(i) => Some(format!("dot({})", coordinate(i)?).into()),
        Leaf::T => Some("t".into()),
        _ => None,
    });
    named.collect()
}

/// The acceleration and its derivatives at a point nearby.
fn beside(declaration: &Declaration<'_>, at: &At<'_>, [t, q, v]: [&[f64]; 3]) -> Option<[Vec<f64>; 2]> {
    let (a, multipliers) = start::acceleration(declaration, (t[0], q, v), Some(at.a)).ok()?;
    let there = At {
        t: t[0],
        q,
        v,
        a: &a,
        multipliers: &multipliers,
    };
    let slopes = acceleration_slopes(declaration, &there)?;
    Some([a.to_vec(), slopes.concat()])
}

/// Whether the motion or its derivatives differ between the two sides of an argument that is zero.
fn is_corner(arguments: &Slopes, argument: usize, at: &At<'_>, declaration: &Declaration<'_>) -> bool {
    let n = at.q.len();
    let (mut t, mut q, mut v) = ([0.0], vec![0.0; n], vec![0.0; n]);
    for (leaf, slope) in arguments.moving(argument) {
        match leaf {
            Leaf::T => t[0] = slope,
            Leaf::Q(i) => q[i] = slope,
            Leaf::V(i) => v[i] = slope,
            _ => {}
        }
    }
    let all = || t.iter().chain(&q).chain(&v);
    let steepest = all().fold(0.0_f64, |most, slope| most.max(slope.abs()));
    if steepest == 0.0 || !steepest.is_finite() {
        // the argument does not change its sign here, or has no derivative
        return !steepest.is_finite();
    }
    let moved = |rotations: &[usize], x: &[f64], by: &[f64], far: f64| -> Vec<f64> {
        let parts = x.iter().zip(by);
        let increment: Vec<f64> = parts
            .map(|(x, by)| far * x.abs().max(1.0) * by / steepest)
            .collect();
        rotation::moved(rotations, x, &increment)
    };
    // the distance between the two sides, and their size
    let apart = |far: f64| -> Option<[[f64; 2]; 2]> {
        let side = |far: f64| {
            let place = [
                moved(&[], &[at.t], &t, far),
                moved(&declaration.shape().rotations, at.q, &q, far),
                moved(&[], at.v, &v, far),
            ];
            beside(declaration, at, [&place[0], &place[1], &place[2]])
        };
        let (before, after) = (side(-far)?, side(far)?);
        Some([0, 1].map(|k| {
            let pairs = || before[k].iter().zip(&after[k]);
            let apart = pairs().fold(0.0_f64, |most, (x, y)| most.max((x - y).abs()));
            let size = pairs().fold(0.0_f64, |most, (x, y)| most.max(x.abs()).max(y.abs()));
            [apart, size]
        }))
    };
    let (Some(first), Some(nearer)) = (apart(FAR), apart(FAR * NEARER)) else {
        return true;
    };
    let mut both = first.into_iter().zip(nearer);
    both.any(|([first, _], [nearer, size])| nearer > SHRINKS * first && nearer > ROUNDING * size)
}
