//! Starts of systems whose constraints bind positions and velocities: whether they obey them, and how they are brought to.

use crate::compensated::Compensated;
use crate::declaration::Declaration;
use crate::dense::Matrix;
use crate::error::{SetupError, Violation};
use crate::rounding;
use crate::scalar::Scalar as _;
use crate::step::elimination;
use crate::system::{Leg, Point};
use crate::tangent::Tangent;

/// A constraint is obeyed if its value is below this part of its terms: a start is given in as many digits.
pub(super) const OBEYED: f64 = 1e-12;

/// How often a projection is repeated.
const MAX_ITERATIONS: usize = 50;

/// A row of this part of its terms is zero but for its own rounding.
const ROUNDED: f64 = f64::EPSILON;

/// What the updates of a projection are small against, in units of rounding.
const SETTLED: f64 = 8.0 * f64::EPSILON;

/// Whether there is anything to obey.
fn is_bound<const N: usize>(declaration: &Declaration<'_, N>) -> bool {
    declaration.lower() > 0
}

/// Checks that a position and a velocity obey the constraints.
pub(super) fn check<const N: usize>(
    declaration: &Declaration<'_, N>,
    t: f64,
    q: &[f64; N],
    v: &[f64; N],
) -> Result<(), SetupError> {
    if !is_bound(declaration) {
        return Ok(());
    }
    let rows = declaration.phase(t, q, v);
    let sizes = rounding::phase_sizes(declaration, t, q, v);
    let roundings = roundings(declaration, t, q, v);
    obeyed(violations(declaration, Node::Start, &rows, &sizes, &roundings))
}

/// Checks that the second node obeys the constraints with the first.
pub(super) fn check_pair<const N: usize>(
    declaration: &Declaration<'_, N>,
    (t0, h): (f64, f64),
    q0: &[f64; N],
    d: &Compensated<N>,
) -> Result<(), SetupError> {
    if !is_bound(declaration) {
        return Ok(());
    }
    // the first node, of whose pair nothing else is known
    let first = holonomic_rows(declaration, t0, q0);
    let sizes = rounding::phase_sizes(declaration, t0, q0, &[0.0; N]);
    let mut all = violations(declaration, Node::First, &first, &sizes, &[]);
    let leg = leg(t0 + h, q0, d);
    let mut rows = declaration.pair(h, &leg);
    for (row, change) in rows.iter_mut().zip(of_rounded_nodes(declaration, h, q0, &leg)) {
        if row.abs() <= change && change.is_finite() {
            *row = 0.0;
        }
    }
    let sizes = rounding::pair_sizes(declaration, h, &leg);
    all.extend(violations(declaration, Node::Second, &rows, &sizes, &[]));
    obeyed(all)
}

/// How much the rows of a pair of nodes may change where both nodes are rounded: a velocity is their difference, to which a
/// short step leaves few digits, so that no nodes of double precision obey a constraint of velocities better.
fn of_rounded_nodes<const N: usize>(
    declaration: &Declaration<'_, N>,
    h: f64,
    q0: &[f64; N],
    leg: &Leg<f64, N>,
) -> Vec<f64> {
    let mut changes = vec![0.0; declaration.lower()];
    for (j, (first, second)) in q0.iter().zip(&leg.q).enumerate() {
        let moved =
            |x: &[f64; N]| core::array::from_fn(|i| Tangent::new(x[i], if i == j { 1.0 } else { 0.0 }));
        let ends = Leg {
            t: Tangent::splat(leg.t),
            q: moved(&leg.q),
            d: moved(&leg.d),
        };
        let rounding = f64::EPSILON * (first.abs() + second.abs());
        let rows = declaration.pair(Tangent::splat(h), &ends);
        for (change, row) in changes.iter_mut().zip(rows) {
            *change += row.derivative().abs() * rounding;
        }
    }
    changes
}

/// Where rows are asked for.
#[derive(Clone, Copy)]
enum Node {
    /// At the position and the velocity of the start.
    Start,
    /// At the first of two nodes.
    First,
    /// At the second, and between the two.
    Second,
}

/// The rows that are not zero.
fn violations<const N: usize>(
    declaration: &Declaration<'_, N>,
    node: Node,
    rows: &[f64],
    sizes: &[f64],
    roundings: &[f64],
) -> Vec<Violation> {
    let (holonomic, lower) = (declaration.holonomic(), declaration.lower());
    let mut violations = Vec::new();
    for (place, (&value, &size)) in rows.iter().zip(sizes).enumerate() {
        // false also where it is not a number
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

/// Refuses violations.
fn obeyed(violations: Vec<Violation>) -> Result<(), SetupError> {
    if violations.is_empty() {
        Ok(())
    } else {
        Err(SetupError::Inconsistent { violations })
    }
}

/// Whether a projection has ended on the constraints, and not where their derivatives vanish.
fn reached<const N: usize>(
    declaration: &Declaration<'_, N>,
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

/// How much each row of a position and a velocity may be where these are rounded in their largest components: terms may vanish, or
/// cancel, that are no measure of a row then.
fn roundings<const N: usize>(
    declaration: &Declaration<'_, N>,
    t: f64,
    q: &[f64; N],
    v: &[f64; N],
) -> Vec<f64> {
    let (holonomic, lower) = (declaration.holonomic(), declaration.lower());
    let mut roundings = Vec::with_capacity(holonomic + lower);
    for (of_velocity, count, x) in [(false, holonomic, q), (true, lower, v)] {
        let mut rows = vec![0.0; count * (1 + N)];
        declaration.phase_slopes(of_velocity, t, q, v, &mut rows);
        let largest = x.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
        let slopes = rows.split_at(count).1.chunks_exact(N);
        roundings.extend(slopes.map(|slopes| {
            let sum: f64 = slopes.iter().map(|slope| slope.abs()).sum();
            SETTLED * sum * largest
        }));
    }
    roundings
}

/// The same of a leg: for rows of a position its largest component counts, for rows of a velocity that of the leg.
fn pair_roundings<const N: usize>(declaration: &Declaration<'_, N>, h: f64, leg: &Leg<f64, N>) -> Vec<f64> {
    let largest = |x: &[f64; N]| x.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
    let mut roundings = vec![0.0; declaration.lower()];
    for j in 0..N {
        let moved =
            |x: &[f64; N]| core::array::from_fn(|i| Tangent::new(x[i], if i == j { 1.0 } else { 0.0 }));
        let moved = Leg {
            t: Tangent::splat(leg.t),
            q: moved(&leg.q),
            d: moved(&leg.d),
        };
        let rows = declaration.pair(Tangent::splat(h), &moved);
        for (place, (rounding, row)) in roundings.iter_mut().zip(rows).enumerate() {
            let size = if place < declaration.holonomic() {
                largest(&leg.q)
            } else {
                largest(&leg.d)
            };
            *rounding += SETTLED * row.derivative().abs() * size;
        }
    }
    roundings
}

/// Moves a position onto the holonomic constraints, then a velocity onto all of lower order.
pub(super) fn project<const N: usize>(
    declaration: &Declaration<'_, N>,
    t: f64,
    q: [f64; N],
    v: [f64; N],
) -> Result<([f64; N], [f64; N]), SetupError> {
    if !is_bound(declaration) {
        return Ok((q, v));
    }
    let inverse = inverse_mass(declaration, t, &q, &v);
    let q = if declaration.holonomic() > 0 {
        let rows = |q: &[Tangent; N]| {
            let mut rows = declaration.phase(Tangent::splat(t), q, &v.map(|v| Tangent::new(v, 0.0)));
            rows.truncate(declaration.holonomic());
            rows
        };
        solve(q, &inverse, &q, rows, |q| {
            rounding::phase_sizes(declaration, t, q, &v)
        })?
    } else {
        q
    };
    let inverse = inverse_mass(declaration, t, &q, &v);
    let rows = |v: &[Tangent; N]| {
        let mut rows = declaration.phase(Tangent::splat(t), &q.map(|q| Tangent::new(q, 0.0)), v);
        rows.split_off(declaration.holonomic().min(rows.len()))
    };
    let v = solve(v, &inverse, &v, rows, |v| {
        let mut sizes = rounding::phase_sizes(declaration, t, &q, v);
        sizes.split_off(declaration.holonomic().min(sizes.len()))
    })?;
    let rows = declaration.phase(t, &q, &v);
    reached(
        declaration,
        &rows,
        &rounding::phase_sizes(declaration, t, &q, &v),
        &roundings(declaration, t, &q, &v),
    )?;
    Ok((q, v))
}

/// Moves the second node onto the constraints of nodes and of pairs.
pub(super) fn onto_pair<const N: usize>(
    declaration: &Declaration<'_, N>,
    (t0, h): (f64, f64),
    q0: &[f64; N],
    v0: &[f64; N],
    d: Compensated<N>,
) -> Result<Compensated<N>, SetupError> {
    if !is_bound(declaration) {
        return Ok(d);
    }
    let inverse = inverse_mass(declaration, t0, q0, v0);
    let rows = |correction: &[Tangent; N]| {
        let leg = leg(t0 + h, q0, &d);
        let moved = |x: [f64; N]| core::array::from_fn(|i| Tangent::new(x[i], 0.0) + correction[i]);
        let leg = Leg {
            t: Tangent::splat(leg.t),
            q: moved(leg.q),
            d: moved(leg.d),
        };
        declaration.pair(Tangent::splat(h), &leg)
    };
    // what is sought is known to the digits of the leg
    let around = core::array::from_fn(|i| q0[i].abs().max(d.hi[i].abs()));
    let correction = solve([0.0; N], &inverse, &around, rows, |correction| {
        let mut d = d;
        d.add(correction);
        rounding::pair_sizes(declaration, h, &leg(t0 + h, q0, &d))
    })?;
    let mut d = d;
    d.add(&correction);
    let leg = leg(t0 + h, q0, &d);
    reached(
        declaration,
        &declaration.pair(h, &leg),
        &rounding::pair_sizes(declaration, h, &leg),
        &pair_roundings(declaration, h, &leg),
    )?;
    Ok(d)
}

/// The leg from the first node, to the second at the time `t`.
fn leg<const N: usize>(t: f64, q0: &[f64; N], d: &Compensated<N>) -> Leg<f64, N> {
    Leg {
        t,
        q: Compensated::exact(*q0).plus(d).hi,
        d: d.hi,
    }
}

/// The holonomic constraints at a node.
fn holonomic_rows<const N: usize>(declaration: &Declaration<'_, N>, t: f64, q: &[f64; N]) -> Vec<f64> {
    let mut rows = declaration.phase(t, q, &[0.0; N]);
    rows.truncate(declaration.holonomic());
    rows
}

/// The inverse of the mass matrix `∂²L/∂v²`, by which displacements are measured; the identity where there is none.
pub(super) fn inverse_mass<const N: usize>(
    declaration: &Declaration<'_, N>,
    t: f64,
    q: &[f64; N],
    v: &[f64; N],
) -> Matrix {
    let inverse = elimination::inverse::<false, N>(&mass_matrix(declaration, t, q, v));
    let inverse = Matrix::from_fn(N, N, |i, j| inverse[j][i]);
    if inverse.is_finite() {
        inverse
    } else {
        Matrix::from_fn(N, N, |i, j| if i == j { 1.0 } else { 0.0 })
    }
}

/// The mass matrix `∂²L/∂v²`.
pub(super) fn mass_matrix<const N: usize>(
    declaration: &Declaration<'_, N>,
    t: f64,
    q: &[f64; N],
    v: &[f64; N],
) -> [[f64; N]; N] {
    let columns: [[f64; N]; N] = core::array::from_fn(|j| {
        let point = Point {
            t: Tangent::splat(t),
            q: q.map(|q| Tangent::new(q, 0.0)),
            v: v.map(|v| Tangent::new(v, 0.0)),
            a: core::array::from_fn(|i| Tangent::new(0.0, if i == j { 1.0 } else { 0.0 })),
        };
        declaration.continuous_force(&point).map(Tangent::derivative)
    });
    core::array::from_fn(|i| core::array::from_fn(|j| columns[j][i]))
}

/// Newton's iteration for fewer rows than unknowns, along the forces of the rows: each update is the shortest by the mass
/// matrix. What is sought is rounded like `around`, or like itself; `sizes` are those of the rows' terms. Where the rows are zero to
/// rounding nothing is moved.
fn solve<const N: usize>(
    mut x: [f64; N],
    inverse: &Matrix,
    around: &[f64; N],
    rows: impl Fn(&[Tangent; N]) -> Vec<Tangent>,
    sizes: impl Fn(&[f64; N]) -> Vec<f64>,
) -> Result<[f64; N], SetupError> {
    let largest = |x: &[f64; N]| x.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
    let mut last = f64::INFINITY;
    for _ in 0..MAX_ITERATIONS {
        let columns: Vec<Vec<Tangent>> = (0..N)
            .map(|j| {
                rows(&core::array::from_fn(|i| {
                    Tangent::new(x[i], if i == j { 1.0 } else { 0.0 })
                }))
            })
            .collect();
        let count = columns.first().map_or(0, Vec::len);
        let value: Vec<f64> = (0..count).map(|i| columns[0][i].value()).collect();
        let within = |(value, size): (&f64, f64)| size.is_finite() && value.abs() <= ROUNDED * size;
        if value.iter().zip(sizes(&x)).all(within) {
            return Ok(x);
        }
        let slope = Matrix::from_fn(count, N, |i, j| columns[j][i].derivative());
        let forces = inverse.times(&slope.transposed());
        let metric = slope.times(&forces);
        if value.iter().any(|entry| !entry.is_finite()) || !metric.is_finite() {
            break;
        }
        // rows may be dependent: the shortest update then
        let parts = metric.decomposed().solve(&value, f64::EPSILON);
        let update = forces.times_vector(&parts);
        for (x, update) in x.iter_mut().zip(&update) {
            *x -= update;
        }
        let size = largest(&x).max(largest(around));
        let step = update.iter().fold(0.0_f64, |step, update| step.max(update.abs()));
        // as small as rounding, or no smaller than before at the level of rounding
        if step <= SETTLED * size || step >= last && step <= OBEYED * size || step == 0.0 {
            return Ok(x);
        }
        last = step;
    }
    let residual = rows(&x.map(|x| Tangent::new(x, 0.0)))
        .iter()
        .map(|row| row.value())
        .collect();
    Err(SetupError::Projection { residual })
}
