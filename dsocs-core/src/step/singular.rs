//! Steps past a singularity, where the equations do not determine the acceleration (in third order the jerk).
//!
//! There the determinant of the equations for the acceleration passes through zero. If a factor of a
//! constraint vanishes, the motion goes on undisturbed. Else the acceleration grows without bound, and no
//! motion leads past. The discrete equations have roots on both sides, so a step would jump over the place.

use core::cell::Cell;

use crate::number::largest;
use crate::regularity::deficiency::{DependentRow, Singularity};
use crate::regularity::dependence::dependent_row;
use crate::solve::Vector;
use crate::start::place::{MotionPath, Place};
use crate::start::{self, Determined};
use crate::tape::declaration::Declaration;

/// Number of equal parts into which the path between two places is divided.
const PLACES: u32 = 12;

/// Number of bisections towards a singularity.
const HALVINGS: u32 = 20;

/// The part at which an interval is divided: the half, or the second one if the singularity itself lies
/// there.
const DIVISIONS: [f64; 2] = [0.5, 0.4];

/// Least factor by which the accelerations on the two sides of a singularity differ more after the bisections
/// than before. At a simple pole it is a million, unless one end was near it.
const GROWS: f64 = 16.0;

/// A determinant that falls by more than this part of itself in one step may pass through zero within the
/// next four. It is examined once it has halved, and so not less than two steps before zero.
const FALLS: f64 = 0.25;

/// At the beginning of a run, a determinant that grows by more than this part of itself in the first step
/// comes from a zero less than two such steps before: there the acceleration differs between the ends of the
/// step.
const RISES: f64 = 0.5;

/// Number of steps ahead within which a falling determinant may pass through zero.
const AHEAD: f64 = 4.0;

/// Number of steps back within which a rising determinant may come from zero.
const BACK: f64 = 2.0;

/// A place without an acceleration is replaced by one at this part of the way to the other place: there a quotient 0/0 with a limit has values. No
/// whole number of the places ahead, so that one of them is near the zero of a determinant, but not at it.
const BESIDE: f64 = 0.2;

/// A determinant below this part of itself on the path ahead may pass through zero there, or touch it: a
/// square has a zero without a change of sign, and the path is not quite straight.
const VANISHES: f64 = 0.05;

/// A constraint is dependent if its part that is independent of those before it is below this part of its
/// former value.
pub(crate) const DEPENDENT: f64 = 1e-6;

/// A determinant that falls to this part of itself between two places touches zero there.
const TOUCHES: f64 = 1e-6;

/// A change of the acceleration by less than this part of itself is no jump.
const JUMPS: f64 = 0.1;

/// An acceleration that changes in a step by less than this part of its size is resolved.
const RESOLVED: f64 = 0.25;

/// Whether an acceleration, in any unit, changes little from one step to the next. If the determinant changes its sign there, only the equations of the
/// step are singular, and the motion is right: so it is where a constraint force turns with the velocity, in the step in which the velocity reverses.
/// Where a step is too long for a force, the acceleration changes its sign.
pub(crate) fn is_resolved(before: &[f64], now: &[f64]) -> bool {
    let size = largest(before).max(largest(now));
    before
        .iter()
        .zip(now)
        .all(|(before, now)| (now - before).abs() <= RESOLVED * size)
}

/// Distance of a component at one place from that at another.
fn apart(one: &Determined, other: &Determined, component: usize) -> f64 {
    (one.motion[component] - other.motion[component]).abs()
}

/// Whether the determinants have opposite signs.
pub(crate) fn are_opposite(one: &Determined, other: &Determined) -> bool {
    one.determinant.value * other.determinant.value < 0.0
}

/// Change of the determinant of the equations for the acceleration from one place to another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum DeterminantChange {
    /// The determinant changes little, or does not come near to zero.
    Little,
    /// The determinant may pass zero within the next four steps, or has passed it.
    Falls,
    /// The determinant grows so much that the motion comes from a place near zero.
    Rises,
}

/// The change of the determinant between two places that are `steps` steps apart.
///
/// A falling determinant need not reach zero: that of a rocket falls as it burns its mass, and that of a fast
/// particle as it slows down. So it is evaluated on the straight continuation of the path, ahead or back.
#[cold]
pub(crate) fn change(
    declaration: &Declaration<'_>,
    places: [&Place; 2],
    steps: f64,
    near: &[f64],
) -> DeterminantChange {
    let rotations = &declaration.shape().rotations;
    let solved = |place: &Place, other: &Place| {
        if let Some(solved) = place.solve(declaration, near) {
            return Some((0.0, place.clone(), solved));
        }
        let beside = place.towards(rotations, other, BESIDE);
        let solved = beside.solve(declaration, near)?;
        Some((BESIDE, beside, solved))
    };
    let [one, other] = places;
    let [Some((left_out, one, first)), Some((more, other, second))] =
        [solved(one, other), solved(other, one)]
    else {
        return DeterminantChange::Falls;
    };
    let steps = steps * (1.0 - left_out - more);
    let unit = second.determinant.exponent;
    let [before, now] = [first, second].map(|solved| solved.determinant.in_units_of(unit));
    if before * now < 0.0 {
        return DeterminantChange::Falls;
    }
    // a nearly dependent constraint is reported from farther away: the path is not straight there
    let least = if declaration.lower() > 0 { FALLS } else { VANISHES };
    // in units of the distance of the two places, from the first
    let vanishes = |from: f64, to: f64, size: f64| {
        let count = f64::from(PLACES) * ((to - from) * steps).abs();
        let mut parts = (1..=PLACES * 4).map(f64::from).take_while(|part| *part <= count);
        parts.any(|part| {
            let place = one.towards(rotations, &other, from + (to - from) * part / count);
            let solved = place.solve(declaration, near);
            // a straight path may leave the domain of the declaration, and then tells nothing
            solved.is_some_and(|solved| {
                solved.determinant.in_units_of(unit) * size.signum() < least * size.abs()
            })
        })
    };
    if before.abs() > (1.0 + FALLS * steps) * now.abs() && vanishes(1.0, 1.0 + AHEAD / steps, now) {
        DeterminantChange::Falls
    } else if now.abs() > (1.0 + RISES * steps) * before.abs() && vanishes(0.0, -BACK / steps, before) {
        DeterminantChange::Rises
    } else {
        DeterminantChange::Little
    }
}

/// The time on a path at which the constraints on positions and velocities are most nearly dependent, and the
/// first of them that is dependent on those before it, up to the part `dependent`. The determinant of the
/// equations for the acceleration is the square of a measure of their independence, and has a minimum there.
#[cold]
pub(crate) fn dependence(
    declaration: &Declaration<'_>,
    path: &MotionPath<'_>,
    dependent: f64,
) -> Option<(f64, DependentRow)> {
    let near = Vector::zero(declaration.dimension());
    let unit = path(0.0).solve(declaration, &near)?.determinant.exponent;
    // without an acceleration the determinant counts as zero
    let size = |part: f64| {
        let solved = path(part).solve(declaration, &near);
        solved.map_or(0.0, |solved| solved.determinant.in_units_of(unit).abs())
    };
    let places = (0..=2 * PLACES).map(|place| f64::from(place) / f64::from(2 * PLACES));
    let least = places.min_by(|one, other| size(*one).total_cmp(&size(*other)))?;
    let apart = 1.0 / f64::from(2 * PLACES);
    let place = path(minimum(
        &size,
        [least - apart, least + apart].map(|end| end.clamp(0.0, 1.0)),
    ));
    dependent_row(declaration, &place, &path(0.0), dependent).map(|row| (place.t, row))
}

/// The minimum of a unimodal function on an interval.
fn minimum(function: &dyn Fn(f64) -> f64, [mut from, mut to]: [f64; 2]) -> f64 {
    for _ in 0..3 * HALVINGS {
        let thirds = [from + (to - from) / 3.0, to - (to - from) / 3.0];
        if function(thirds[0]) < function(thirds[1]) {
            to = thirds[1];
        } else {
            from = thirds[0];
        }
    }
    0.5 * (from + to)
}

/// The first singularity on a path through some places, of those that no motion leads past. Accelerations are searched near `near`.
#[cold]
pub(crate) fn on_path(declaration: &Declaration<'_>, path: &[Place], near: &[f64]) -> Option<Singularity> {
    let rotations = &declaration.shape().rotations;
    let places = path.windows(2).flat_map(|ends| {
        (0..PLACES).map(|place| ends[0].towards(rotations, &ends[1], f64::from(place) / f64::from(PLACES)))
    });
    // a place without an acceleration is left out: it may be the singularity itself
    let solved: Vec<(Place, Determined)> = places
        .chain(path.last().cloned())
        .filter_map(|place| place.solve(declaration, near).map(|solved| (place, solved)))
        .collect();
    let range = |i: usize| {
        let all = solved.iter().map(|(_, solved)| solved.motion[i]);
        all.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], a| {
            [least.min(a), most.max(a)]
        })
    };
    let jumps = |before: &Determined, after: &Determined, i: usize| {
        let [least, most] = range(i);
        let jump = apart(before, after, i);
        jump >= 0.5 * (most - least) && jump > JUMPS * most.abs().max(least.abs())
    };
    let passed = solved.windows(2).find_map(|pair| {
        let [from, to] = pair else { return None };
        let jumping = (0..near.len()).find(|&i| jumps(&from.1, &to.1, i))?;
        if !are_opposite(&from.1, &to.1) {
            return None;
        }
        pole(declaration, [from, to], jumping)
    });
    passed.or_else(|| {
        // from a little before the beginning: the first place may lie just behind the last one that was
        // examined
        let [first, second, ..] = path else { return None };
        let back = first.towards(rotations, second, -1.0 / f64::from(PLACES));
        let back = back.solve(declaration, near).map(|solved| (back, solved));
        let solved: Vec<(Place, Determined)> = back.into_iter().chain(solved).collect();
        solved.windows(3).find_map(|places| {
            let [from, least, to] = places else { return None };
            touched(declaration, [from, least, to])
        })
    })
}

/// The singularity between two places of opposite determinants, if a component of the acceleration is
/// unbounded there. It is bounded if a factor vanishes, and if the two roots of a pair change sides: then it
/// only seems to jump, from one root to the other.
fn pole(
    declaration: &Declaration<'_>,
    ends: [&(Place, Determined); 2],
    component: usize,
) -> Option<Singularity> {
    let [mut from, mut to] = ends.map(Clone::clone);
    let first = apart(&from.1, &to.1, component);
    let mut grown = first;
    for _ in 0..HALVINGS {
        // near the acceleration of either side, which it continues
        let near = from.1.motion.get(..from.0.q.len()).unwrap_or(&[]);
        let between = DIVISIONS.iter().find_map(|part| {
            let place = from.0.towards(&declaration.shape().rotations, &to.0, *part);
            let solved = place.solve(declaration, near)?;
            Some((place, solved))
        });
        let Some((middle, solved)) = between else {
            break;
        };
        if are_opposite(&solved, &from.1) {
            to = (middle, solved);
        } else {
            from = (middle, solved);
        }
        grown = f64::max(grown, apart(&from.1, &to.1, component));
    }
    if grown < GROWS * first {
        return None;
    }
    let (place, solved) = &to;
    Some(Singularity {
        time: place.t,
        deficiency: place.deficiency(declaration, solved),
    })
}

/// The singularity between three places where the determinant touches zero without a change of sign, as a
/// square does, if the acceleration is unbounded there. Dependent constraints on positions or velocities have
/// such a determinant, too; they are left to [`dependence`].
fn touched(declaration: &Declaration<'_>, places: [&(Place, Determined); 3]) -> Option<Singularity> {
    let unit = places[1].1.determinant.exponent;
    let [from, least, to] = places.map(|(_, solved)| solved.determinant.in_units_of(unit).abs());
    let dips = least <= from.min(to)
        && least < from.max(to)
        && !places.iter().any(|place| are_opposite(&place.1, &places[1].1));
    if declaration.lower() > 0 || !dips {
        return None;
    }
    let n = places[1].0.q.len();
    // in the norm of the mass matrix
    let mass = start::mass_matrix(declaration, places[1].0.t, &places[1].0.q, &places[1].0.v);
    let size = |solved: &Determined| {
        let terms = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
        let square: f64 = terms
            .map(|(i, j)| solved.motion[i] * mass[(i, j)] * solved.motion[j])
            .sum();
        square.sqrt()
    };
    let [before, here, after] = places.map(|(_, solved)| size(solved));
    if here < before.max(after) || here.is_nan() {
        return None;
    }
    // the path has a corner in the middle
    let at = |part: f64| {
        let end = if part < 0.0 { places[0] } else { places[2] };
        places[1]
            .0
            .towards(&declaration.shape().rotations, &end.0, part.abs())
    };
    let near = places[1].1.motion.get(..n).unwrap_or(&[]);
    let solve = |part: f64| at(part).solve(declaration, near);
    // the first determinant that is small enough: nearer to zero only rounding is left
    let small = Cell::new(None);
    let determinant = |part: f64| {
        let found = solve(part).map_or(least, |solved| solved.determinant.in_units_of(unit).abs());
        if found < TOUCHES * least && small.get().is_none() {
            small.set(Some(part));
        }
        found
    };
    let _ = minimum(&determinant, [-1.0, 1.0]);
    let part = small.get()?;
    let solved = solve(part)?;
    if size(&solved) <= GROWS * here {
        return None;
    }
    let place = at(part);
    Some(Singularity {
        time: place.t,
        deficiency: place.deficiency(declaration, &solved),
    })
}
