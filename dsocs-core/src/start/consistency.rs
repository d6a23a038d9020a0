//! Starts of systems with constraints on positions and velocities: check and projection.

use crate::error::{SetupError, Violation};
use crate::number::point::{AnyLeg, AnyPoint, OwnedLeg, map, moved};
use crate::number::scalar::Scalar as _;
use crate::number::tangent::Tangent;
use crate::regularity::rounding;
use crate::solve::Vector;
use crate::solve::dense::Matrix;
use crate::solve::rotation;
use crate::solve::sum::Sum;
use crate::tape::declaration::Declaration;

/// A constraint is obeyed if its value is below this part of its terms: a start is given with that many
/// digits.
pub(super) const OBEYED: f64 = 1e-12;

/// Largest number of iterations of a projection.
const MAX_ITERATIONS: usize = 50;

/// A row up to this part of its terms is zero to within its own rounding.
const ROUNDED: f64 = f64::EPSILON;

/// A projection has converged once its updates are below this part of the unknowns.
pub(super) const SETTLED: f64 = 8.0 * f64::EPSILON;

/// Whether there are constraints on positions or velocities.
fn is_bound(declaration: &Declaration<'_>) -> bool {
    declaration.lower() > 0
}

/// Checks that a position and a velocity obey the constraints.
pub(super) fn check(declaration: &Declaration<'_>, t: f64, q: &[f64], v: &[f64]) -> Result<(), SetupError> {
    if !is_bound(declaration) {
        return Ok(());
    }
    let rows = declaration.phase(t, q, v);
    let sizes = rounding::phase_sizes(declaration, t, q, v);
    let roundings = roundings(declaration, t, [q, q], [v, v]);
    obeyed(violations(declaration, Node::Start, &rows, &sizes, &roundings))
}

/// Checks that the second node obeys the constraints with the first.
pub(super) fn check_pair(
    declaration: &Declaration<'_>,
    (t0, h): (f64, f64),
    q0: &[f64],
    d: &Sum,
) -> Result<(), SetupError> {
    if !is_bound(declaration) {
        return Ok(());
    }
    // the holonomic rows at the first node
    let first = holonomic_rows(declaration, t0, q0);
    let sizes = rounding::phase_sizes(declaration, t0, q0, &vec![0.0; q0.len()]);
    let mut all = violations(declaration, Node::First, &first, &sizes, &[]);
    let second = second(declaration, q0, d);
    let leg = leg(t0 + h, &second, d);
    let mut rows = declaration.pair(h, leg);
    for (row, change) in rows.iter_mut().zip(of_rounded_nodes(declaration, h, q0, leg)) {
        if row.abs() <= change && change.is_finite() {
            *row = 0.0;
        }
    }
    let sizes = rounding::pair_sizes(declaration, h, leg);
    all.extend(violations(declaration, Node::Second, &rows, &sizes, &[]));
    obeyed(all)
}

/// The possible change of a pair's rows by rounding of the two nodes. The velocity is their difference and
/// keeps few digits in a short step, so no nodes in double precision obey a velocity constraint better.
fn of_rounded_nodes(declaration: &Declaration<'_>, h: f64, q0: &[f64], leg: AnyLeg<'_, f64>) -> Vec<f64> {
    let mut changes = vec![0.0; declaration.lower()];
    for (j, (first, second)) in q0.iter().zip(leg.q).enumerate() {
        let ends = moved_leg(leg, j);
        let rounding = f64::EPSILON * (first.abs() + second.abs());
        let rows = declaration.pair(Tangent::splat(h), ends.any());
        for (change, row) in changes.iter_mut().zip(rows) {
            *change += row.derivative().abs() * rounding;
        }
    }
    changes
}

/// The node or pair at which rows are evaluated.
#[derive(Clone, Copy)]
enum Node {
    /// The position and the velocity of the start.
    Start,
    /// The first of two nodes.
    First,
    /// The second, and the pair.
    Second,
}

/// The rows that are not zero.
fn violations(
    declaration: &Declaration<'_>,
    node: Node,
    rows: &[f64],
    sizes: &[f64],
    roundings: &[f64],
) -> Vec<Violation> {
    let (holonomic, lower) = (declaration.holonomic(), declaration.lower());
    let mut violations = Vec::new();
    for (place, (&value, &size)) in rows.iter().zip(sizes).enumerate() {
        // false also for a NaN
        let is_obeyed = value.abs() <= OBEYED * size
            || roundings
                .get(place)
                .is_some_and(|rounding| value.abs() <= *rounding);
        if is_obeyed {
            continue;
        }
        let (constraint, index) = if place < holonomic {
            ("holonomic constraint", place)
        } else if place < lower {
            ("nonholonomic constraint", place - holonomic)
        } else {
            ("time derivative of holonomic constraint", place - lower)
        };
        let at = match node {
            Node::Start if place < holonomic => "q0",
            Node::Start => "(q0, v0)",
            Node::First => "the first node",
            Node::Second if place < holonomic => "the second node",
            Node::Second => "φ⁻¹(q0, q1) of the map of L",
        };
        violations.push(Violation {
            constraint,
            index,
            at,
            value,
            size,
        });
    }
    violations
}

/// Returns violations, if there are any, as an error.
fn obeyed(violations: Vec<Violation>) -> Result<(), SetupError> {
    if violations.is_empty() {
        Ok(())
    } else {
        Err(SetupError::Inconsistent { violations })
    }
}

/// Whether a projection has ended on the constraints, and not at a point where their derivatives vanish.
fn reached(
    declaration: &Declaration<'_>,
    rows: &[f64],
    sizes: &[f64],
    roundings: &[f64],
) -> Result<(), SetupError> {
    if violations(declaration, Node::Second, rows, sizes, roundings).is_empty() {
        Ok(())
    } else {
        Err(SetupError::Projection {
            residual: rows.to_vec(),
        })
    }
}

/// The possible change of each row at a position and a velocity by rounding of their largest components, or
/// of those of the given ones. Terms that vanish or cancel are no measure of a row.
fn roundings(
    declaration: &Declaration<'_>,
    t: f64,
    [q, given_q]: [&[f64]; 2],
    [v, given_v]: [&[f64]; 2],
) -> Vec<f64> {
    let (holonomic, lower) = (declaration.holonomic(), declaration.lower());
    let mut roundings = Vec::with_capacity(holonomic + lower);
    for (of_velocity, count, x, given) in [(false, holonomic, q, given_q), (true, lower, v, given_v)] {
        let mut rows = vec![0.0; count * (1 + x.len())];
        declaration.phase_slopes(of_velocity, t, q, v, &mut rows);
        let numbers = x.iter().chain(given);
        let largest = numbers.fold(0.0_f64, |largest, x| largest.max(x.abs()));
        let slopes = rows.split_at(count).1.chunks_exact(x.len());
        roundings.extend(slopes.map(|slopes| {
            let sum: f64 = slopes.iter().map(|slope| slope.abs()).sum();
            SETTLED * sum * largest
        }));
    }
    roundings
}

/// [`roundings`] for a leg: rows of positions are measured by the largest component of the position, rows of
/// velocities by that of the increment.
fn pair_roundings(declaration: &Declaration<'_>, h: f64, leg: AnyLeg<'_, f64>) -> Vec<f64> {
    let largest = |x: &[f64]| x.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
    let mut roundings = vec![0.0; declaration.lower()];
    for j in 0..leg.q.len() {
        let rows = declaration.pair(Tangent::splat(h), moved_leg(leg, j).any());
        for (place, (rounding, row)) in roundings.iter_mut().zip(rows).enumerate() {
            let size = if place < declaration.holonomic() {
                largest(leg.q)
            } else {
                largest(leg.d)
            };
            *rounding += SETTLED * row.derivative().abs() * size;
        }
    }
    roundings
}

/// Projects a position onto the holonomic constraints, then a velocity onto all constraints of lower order.
pub(super) fn project(
    declaration: &Declaration<'_>,
    t: f64,
    q: &[f64],
    v: &[f64],
) -> Result<(Vec<f64>, Vec<f64>), SetupError> {
    if !is_bound(declaration) {
        return Ok((q.to_vec(), v.to_vec()));
    }
    let (given_q, given_v) = (q, v);
    let inverse = inverse_mass(declaration, t, q, v);
    let q = if declaration.holonomic() > 0 {
        let rows = |q: &[Tangent]| {
            let mut rows = declaration.phase(Tangent::splat(t), q, &map(v, Tangent::splat));
            rows.truncate(declaration.holonomic());
            rows
        };
        let rotations = &declaration.shape().rotations;
        if rotations.is_empty() {
            solve(q.to_vec(), &[], &inverse, q, &rows, &|q| {
                rounding::phase_sizes(declaration, t, q, v)
            })?
        } else {
            // the unknown is the increment to the position on the constraints
            let given = map(q, Tangent::splat);
            let turned = |by: &[Tangent]| rows(&rotation::moved(rotations, &given, by));
            let by = solve(vec![0.0; q.len()], rotations, &inverse, q, &turned, &|by| {
                rounding::phase_sizes(declaration, t, &rotation::moved(rotations, q, by), v)
            })?;
            let mut q = rotation::moved(rotations, q, &by);
            rotation::unit(rotations, &mut q);
            q
        }
    } else {
        q.to_vec()
    };
    let inverse = inverse_mass(declaration, t, &q, v);
    let rows = |v: &[Tangent]| {
        let mut rows = declaration.phase(Tangent::splat(t), &map(&q, Tangent::splat), v);
        rows.split_off(declaration.holonomic().min(rows.len()))
    };
    let v = solve(v.to_vec(), &[], &inverse, v, &rows, &|v| {
        let mut sizes = rounding::phase_sizes(declaration, t, &q, v);
        sizes.split_off(declaration.holonomic().min(sizes.len()))
    })?;
    let rows = declaration.phase(t, &q, &v);
    reached(
        declaration,
        &rows,
        &rounding::phase_sizes(declaration, t, &q, &v),
        &roundings(declaration, t, [&q, given_q], [&v, given_v]),
    )?;
    Ok((q, v))
}

/// Projects the second node onto the constraints of nodes and of pairs.
pub(super) fn onto_pair(
    declaration: &Declaration<'_>,
    (t0, h): (f64, f64),
    q0: &[f64],
    v0: &[f64],
    d: Sum,
) -> Result<Sum, SetupError> {
    if !is_bound(declaration) {
        return Ok(d);
    }
    let inverse = inverse_mass(declaration, t0, q0, v0);
    let rows = |correction: &[Tangent]| {
        let moved = |x: &[f64]| -> Vec<Tangent> {
            let numbers = x.iter().zip(correction);
            numbers
                .map(|(&x, &correction)| Tangent::splat(x) + correction)
                .collect()
        };
        let rotations = &declaration.shape().rotations;
        let leg = OwnedLeg {
            t: Tangent::splat(t0 + h),
            q: if rotations.is_empty() {
                moved(&second(declaration, q0, &d))
            } else {
                rotation::moved(rotations, &map(q0, Tangent::splat), &moved(&d.hi))
            },
            d: moved(&d.hi),
        };
        declaration.pair(Tangent::splat(h), leg.any())
    };
    // the unknown is accurate to the digits of the leg
    let around: Vec<f64> = q0.iter().zip(&d.hi).map(|(q, d)| q.abs().max(d.abs())).collect();
    let correction = solve(
        vec![0.0; q0.len()],
        &[],
        &inverse,
        &around,
        &rows,
        &|correction| {
            let mut d = d.clone();
            d.add(correction);
            rounding::pair_sizes(declaration, h, leg(t0 + h, &second(declaration, q0, &d), &d))
        },
    )?;
    let mut d = d;
    d.add(&correction);
    let second = second(declaration, q0, &d);
    let leg = leg(t0 + h, &second, &d);
    reached(
        declaration,
        &declaration.pair(h, leg),
        &rounding::pair_sizes(declaration, h, leg),
        &pair_roundings(declaration, h, leg),
    )?;
    Ok(d)
}

/// The second node.
fn second(declaration: &Declaration<'_>, q0: &[f64], d: &Sum) -> Vector {
    let q0 = Sum::exact(Vector::of(q0));
    rotation::moved_sum(&declaration.shape().rotations, &q0, d).hi
}

/// The leg to the second node at the time `t`.
fn leg<'a>(t: f64, second: &'a [f64], d: &'a Sum) -> AnyLeg<'a, f64> {
    AnyLeg {
        t,
        q: second,
        d: &d.hi,
    }
}

/// A leg as tangents in the direction of one coordinate of both nodes.
fn moved_leg(leg: AnyLeg<'_, f64>, j: usize) -> OwnedLeg<Tangent> {
    OwnedLeg {
        t: Tangent::splat(leg.t),
        q: moved(leg.q, j),
        d: moved(leg.d, j),
    }
}

/// The holonomic constraints at a node.
fn holonomic_rows(declaration: &Declaration<'_>, t: f64, q: &[f64]) -> Vec<f64> {
    let mut rows = declaration.phase(t, q, &vec![0.0; q.len()]);
    rows.truncate(declaration.holonomic());
    rows
}

/// The inverse of the mass matrix `∂²L/∂v²`, the metric of displacements; the identity if it is singular.
pub(crate) fn inverse_mass(declaration: &Declaration<'_>, t: f64, q: &[f64], v: &[f64]) -> Matrix {
    let inverse = mass_matrix(declaration, t, q, v).inverse();
    if inverse.is_finite() {
        inverse
    } else {
        Matrix::from_fn(q.len(), q.len(), |i, j| if i == j { 1.0 } else { 0.0 })
    }
}

/// The mass matrix `∂²L/∂v²`.
pub(crate) fn mass_matrix(declaration: &Declaration<'_>, t: f64, q: &[f64], v: &[f64]) -> Matrix {
    let zero = vec![0.0; q.len()];
    let point = AnyPoint {
        t: Tangent::splat(t),
        q: &map(q, Tangent::splat),
        v: &map(v, Tangent::splat),
        a: &[],
    };
    let column = |j| {
        let a = moved(&zero, j);
        declaration.continuous_force(AnyPoint { a: &a, ..point })
    };
    let columns: Vec<Vec<Tangent>> = (0..q.len()).map(column).collect();
    Matrix::from_fn(q.len(), q.len(), |i, j| columns[j][i].derivative())
}

/// Newton's iteration for fewer rows than unknowns, along the forces of the rows: each update is the shortest
/// in the mass metric, and turns no body of `rotations` far, so that a start comes to a nearby assembly. The
/// unknown is rounded like `around`, or like itself; `sizes` are those of the rows' terms. If the rows are
/// zero to rounding nothing is moved.
fn solve(
    mut x: Vec<f64>,
    rotations: &[usize],
    inverse: &Matrix,
    around: &[f64],
    rows: &dyn Fn(&[Tangent]) -> Vec<Tangent>,
    sizes: &dyn Fn(&[f64]) -> Vec<f64>,
) -> Result<Vec<f64>, SetupError> {
    let largest = |x: &[f64]| x.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
    let mut last = f64::INFINITY;
    for _ in 0..MAX_ITERATIONS {
        let columns: Vec<Vec<Tangent>> = (0..x.len()).map(|j| rows(&moved(&x, j))).collect();
        let count = columns.first().map_or(0, Vec::len);
        let value: Vec<f64> = (0..count).map(|i| columns[0][i].value()).collect();
        let within = |(value, size): (&f64, f64)| size.is_finite() && value.abs() <= ROUNDED * size;
        if value.iter().zip(sizes(&x)).all(within) {
            return Ok(x);
        }
        let slope = Matrix::from_fn(count, x.len(), |i, j| columns[j][i].derivative());
        let forces = inverse.times(&slope.transposed());
        let metric = slope.times(&forces);
        if value.iter().any(|entry| !entry.is_finite()) || !metric.is_finite() {
            break;
        }
        // rows may be dependent: then the shortest update
        let parts = metric.solve_metric(&value);
        let mut update = forces.times_vector(&parts);
        let part = rotation::part_of_update(rotations, &update);
        if part < 1.0 {
            for update in &mut update {
                *update *= part;
            }
        }
        for (x, update) in x.iter_mut().zip(&update) {
            *x -= update;
        }
        let size = largest(&x).max(largest(around));
        let step = update.iter().fold(0.0_f64, |step, update| step.max(update.abs()));
        // as small as rounding, or no longer decreasing at the level of rounding
        if step <= SETTLED * size || step >= last && step <= OBEYED * size || step == 0.0 {
            return Ok(x);
        }
        last = step;
    }
    let residual = rows(&map(&x, Tangent::splat))
        .iter()
        .map(|row| row.value())
        .collect();
    Err(SetupError::Projection { residual })
}
