//! Multipliers: the contribution of each constraint to the constraint force.

use crate::number::inner_product;
use crate::number::point::{AnyLeg, AnyPoint, map, moved};
use crate::number::scalar::Scalar as _;
use crate::number::tangent::Tangent;
use crate::regularity::lengths;
use crate::regularity::sides::Piece;
use crate::regularity::sticking;
use crate::solve::dense::Matrix;
use crate::tape::declaration::Declaration;

/// Components of forms below this part of the largest are not scaled up.
const FAINT: f64 = 1e-3;

/// Forms explain a force up to this part of it. An update of sides below this is the last: the remaining error is its square.
const EXPLAINED: f64 = 1e-9;

/// Largest number of iterations for multipliers and sides; they converge quadratically.
const MAX_ITERATIONS: usize = 30;

/// The multipliers `λ` for which `Σ λ_j α_j` is closest to a force `Q`; equal to it if the equations of the
/// step hold. NaN if the force or a form is not finite.
pub(crate) fn multipliers(force: &[f64], forms: &[Vec<f64>]) -> Vec<f64> {
    let (n, count) = (force.len(), forms.len());
    if count == 0 {
        return Vec::new();
    }
    // coordinates may have different units: each component of forms and force is scaled by its largest form
    let scale = |i: usize| {
        forms
            .iter()
            .fold(0.0_f64, |largest, form| largest.max(form[i].abs()))
    };
    // a component that passes through zero is not scaled up to the size of the others: its force is rounding
    let least = FAINT * (0..n).fold(0.0_f64, |largest, i| largest.max(scale(i)));
    let scaled = |i: usize, x: f64| {
        let scale = scale(i);
        if scale > 0.0 { x / scale.max(least) } else { 0.0 }
    };
    let mut matrix = Matrix::from_fn(n, count, |i, j| scaled(i, forms[j][i]));
    let right: Vec<f64> = (0..n).map(|i| scaled(i, force[i])).collect();
    if !matrix.is_finite() || right.iter().any(|entry| !entry.is_finite()) {
        return vec![f64::NAN; count];
    }
    // forms may be short, or zero
    let lengths: Vec<f64> = matrix
        .normalize_columns()
        .into_iter()
        .enumerate()
        .map(|(j, length)| {
            if length > 0.0 {
                return length;
            }
            for i in 0..n {
                matrix[(i, j)] = 0.0;
            }
            1.0
        })
        .collect();
    let mut multipliers = matrix.decomposed().solve(&right, f64::EPSILON);
    for (multiplier, length) in multipliers.iter_mut().zip(lengths) {
        *multiplier /= length;
    }
    multipliers
}

/// The multipliers among the unknowns of the continuous system.
pub(crate) fn of_motion(coordinates: usize, motion: &[f64]) -> &[f64] {
    motion.get(coordinates..).unwrap_or_default()
}

/// The multipliers among the unknowns of a step, for a leg and a second difference: those that fit the
/// constraint force best. Empty if there are fields instead.
pub(crate) fn of_step(declaration: &Declaration<'_>, h: f64, leg: AnyLeg<'_, f64>, e: &[f64]) -> Vec<f64> {
    if !declaration.has_multipliers() {
        return Vec::new();
    }
    // components in units of the coordinates' lengths, not of their units: then whether a form is faint does
    // not depend on units
    let forms = declaration.forms(h, leg, e);
    let lengths = lengths::measured(declaration, h, leg, e);
    let largest = |i: usize| {
        forms
            .iter()
            .fold(0.0_f64, |largest, form| largest.max(form[i].abs()))
    };
    let n = declaration.dimension();
    let all = (0..n).fold(0.0_f64, |most, i| {
        most.max(lengths[i].map_or(0.0, |length| length * largest(i)))
    });
    let unit = |i: usize| {
        // the forms of a coordinate without a length are scaled to the common size
        let unit = lengths[i].unwrap_or_else(|| if all > 0.0 { all } else { 1.0 } / largest(i));
        if unit.is_normal() { unit } else { 1.0 }
    };
    let units: Vec<f64> = (0..n).map(unit).collect();
    let works = |x: &[f64]| -> Vec<f64> { x.iter().zip(&units).map(|(x, unit)| x * unit).collect() };
    let forms: Vec<Vec<f64>> = forms.iter().map(|form| works(form)).collect();
    multipliers(&works(&declaration.force(h, leg, e)), &forms)
}

/// The multipliers of the continuous system at a point.
pub(crate) fn of_point(declaration: &Declaration<'_>, point: AnyPoint<'_, f64>) -> Vec<f64> {
    multipliers(
        &declaration.continuous_force(point),
        &declaration.continuous_forms(point),
    )
}

/// The multipliers of a node's constraint force.
pub(crate) fn of_node(declaration: &Declaration<'_>, point: AnyPoint<'_, f64>, force: &[f64]) -> Vec<f64> {
    if declaration.sides() > 0
        && let Some(found) = at_jump(declaration, point, force)
    {
        return found;
    }
    multipliers(force, &declaration.continuous_forms(point))
}

/// Multipliers whose forms have sides in place of signs.
struct Fit {
    multipliers: Vec<f64>,
    /// What the forms leave of the force, as a part of it.
    left: f64,
}

/// The multipliers at a node where bodies may rest at jumps of forms: there the force is that of a side in `[-1, 1]`, which it determines
/// together with the multipliers. `None` if no form depends on a side.
///
/// An argument that is zero has a side of its own. On a surface whose velocity changes, the velocity of a resting node is that of the surface
/// only to the order of the step, so other arguments get sides too, the smallest first, until the forms explain the force.
#[cold]
fn at_jump(declaration: &Declaration<'_>, point: AnyPoint<'_, f64>, force: &[f64]) -> Option<Vec<f64>> {
    let arguments = declaration.side_arguments(point.t, point.q, point.v);
    let signs: Vec<f64> = arguments.iter().map(|x| Piece::of(*x).side()).collect();
    let mut free = sticking::zero(declaration, point.t, point.q, point.v);
    let mut others: Vec<usize> = (0..free.len()).filter(|&g| !free[g]).collect();
    others.sort_by(|&g, &k| arguments[g].abs().total_cmp(&arguments[k].abs()));
    let has_side = |g: usize| {
        let forms = sided_forms(declaration, point, &signs, Some(g));
        forms.iter().flatten().any(|x| x.derivative() != 0.0)
    };
    let with_sides: Vec<bool> = (0..free.len()).map(has_side).collect();
    if !with_sides.contains(&true) {
        return None;
    }
    others.retain(|&g| with_sides[g]);
    let mut best = fit(declaration, point, force, (&signs, &free));
    for g in others {
        if best.left <= EXPLAINED {
            break;
        }
        free[g] = true;
        let other = fit(declaration, point, force, (&signs, &free));
        if other.left < best.left {
            best = other;
        }
    }
    Some(best.multipliers)
}

/// The forms with sides, as tangents in the direction of one side.
fn sided_forms(
    declaration: &Declaration<'_>,
    point: AnyPoint<'_, f64>,
    sides: &[f64],
    along: Option<usize>,
) -> Vec<Vec<Tangent>> {
    let [q, v, a] = [point.q, point.v, point.a].map(|x| map(x, Tangent::splat));
    let t = Tangent::splat(point.t);
    let sides = along.map_or_else(|| map(sides, Tangent::splat), |g| moved(sides, g));
    declaration.sided_continuous_forms(
        AnyPoint {
            t,
            q: &q,
            v: &v,
            a: &a,
        },
        &sides,
    )
}

/// The multipliers and free sides in `[-1, 1]` that fit a force best, by Gauss and Newton. Where the force does not determine them all, the
/// updates from sides of zero are the shortest.
fn fit(
    declaration: &Declaration<'_>,
    point: AnyPoint<'_, f64>,
    force: &[f64],
    (signs, free): (&[f64], &[bool]),
) -> Fit {
    let mut free: Vec<usize> = (0..free.len()).filter(|&g| free[g]).collect();
    let mut sides = signs.to_vec();
    for &g in &free {
        sides[g] = 0.0;
    }
    let forms = |sides: &[f64]| -> Vec<Vec<f64>> {
        let forms = sided_forms(declaration, point, sides, None);
        forms.iter().map(|form| map(form, Tangent::value)).collect()
    };
    let of_forms = |forms: &[Vec<f64>], multipliers: &[f64], i: usize| -> f64 {
        forms.iter().zip(multipliers).map(|(form, x)| form[i] * x).sum()
    };
    let mut now = forms(&sides);
    let mut found = multipliers(force, &now);
    for _ in 0..MAX_ITERATIONS {
        if free.is_empty() {
            break;
        }
        let left: Vec<f64> = (0..force.len())
            .map(|i| force[i] - of_forms(&now, &found, i))
            .collect();
        let mut columns = now;
        for &g in &free {
            let forms = sided_forms(declaration, point, &sides, Some(g));
            let slope = |i: usize| {
                let slopes: Vec<f64> = forms.iter().map(|form| form[i].derivative()).collect();
                inner_product(&slopes, &found)
            };
            columns.push((0..force.len()).map(slope).collect());
        }
        let mut update = multipliers(&left, &columns).into_iter();
        for (x, by) in found.iter_mut().zip(&mut update) {
            *x += by;
        }
        // the first multipliers may be far off, and with them the first update of a side: only what is at its bound and goes on stays there
        let mut moved = 0.0_f64;
        let mut goes_on = vec![false; sides.len()];
        for (&g, by) in free.iter().zip(update) {
            let side = &mut sides[g];
            goes_on[g] = side.abs() >= 1.0 && *side * by > 0.0;
            let next = (*side + by).clamp(-1.0, 1.0);
            moved = moved.max((next - *side).abs());
            *side = next;
        }
        let count = free.len();
        free.retain(|&g| !goes_on[g]);
        now = forms(&sides);
        if moved <= EXPLAINED && free.len() == count {
            break;
        }
    }
    let found = multipliers(force, &now);
    let largest = |of: &dyn Fn(usize) -> f64| (0..force.len()).fold(0.0_f64, |most, i| most.max(of(i).abs()));
    let left = largest(&|i| force[i] - of_forms(&now, &found, i)) / largest(&|i| force[i]);
    Fit {
        multipliers: found,
        left: if left.is_nan() { 0.0 } else { left },
    }
}

/// The number of multipliers among the unknowns of a step.
pub(crate) fn count_unknown(declaration: &Declaration<'_>) -> usize {
    let ones = vec![1.0; declaration.forms_count()];
    let unknown = declaration.unknown(&vec![0.0; declaration.dimension()], &ones);
    unknown.iter().filter(|&&x| x != 0.0).count()
}
