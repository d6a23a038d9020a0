//! Derivatives of the projection of a start onto constraints of positions and velocities.
//!
//! The iterations are those of `start::consistency`, in numbers that carry their change along a direction. After they have converged, one
//! more iteration makes the change exact to rounding: the change converges one iteration later than the value.

use crate::number::point::{AnyLeg, AnyPoint};
use crate::number::scalar::Scalar as _;
use crate::number::tangent::Tangent2;
use crate::solve::dense::Matrix;
use crate::solve::rotation;
use crate::tape::declaration::Declaration;

/// Largest number of iterations of a projection.
const MAX_ITERATIONS: usize = 50;

/// Updates below this, relative to the vector, are rounding once they no longer decrease.
const SMALL: f64 = 1e-12;

/// Updates below this, relative to the vector, are rounding in any case.
const SETTLED: f64 = 8.0 * f64::EPSILON;

/// A vector and its change along a direction.
#[derive(Clone, Debug)]
pub(super) struct ValueWithChange {
    pub value: Vec<f64>,
    pub change: Vec<f64>,
}

/// A matrix and its change along a direction.
struct MatrixWithChange {
    value: Matrix,
    change: Matrix,
}

/// The rows that are to vanish at a vector.
type Rows<'r> = dyn Fn(&[Tangent2]) -> Vec<Tangent2> + 'r;

impl ValueWithChange {
    /// Numbers that carry the change in the first direction, and in the second one a unit at place `j`.
    fn lifted(&self, j: Option<usize>) -> Vec<Tangent2> {
        let both = self.value.iter().zip(&self.change).enumerate();
        both.map(|(i, (&value, &change))| {
            let unit = f64::from(u8::from(j == Some(i)));
            Tangent2::second(value, [change, unit])
        })
        .collect()
    }

    /// Values and changes of numbers that carry the change in the first direction.
    fn of(numbers: &[Tangent2]) -> Self {
        Self {
            value: numbers.iter().map(|number| number.value()).collect(),
            change: numbers.iter().map(|number| number.derivatives()[0]).collect(),
        }
    }

    /// Zeros.
    fn zeros(count: usize) -> Self {
        Self {
            value: vec![0.0; count],
            change: vec![0.0; count],
        }
    }

    /// A sum.
    pub fn plus(&self, other: &Self) -> Self {
        let sum = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| x + y).collect();
        Self {
            value: sum(&self.value, &other.value),
            change: sum(&self.change, &other.change),
        }
    }
}

/// The projection of a position and a velocity onto the constraints. For rotations, the position and its
/// change have quaternions. The parameters change at the rates of the declaration.
pub(super) fn projected(
    declaration: &Declaration<'_>,
    t0: f64,
    q: &ValueWithChange,
    v: &ValueWithChange,
) -> Option<(ValueWithChange, ValueWithChange)> {
    let holonomic = declaration.holonomic();
    let t = Tangent2::splat(t0);
    let q = if holonomic > 0 {
        let velocity = v.lifted(None);
        let rows = |q: &[Tangent2]| {
            let mut rows = declaration.phase(t, q, &velocity);
            rows.truncate(holonomic);
            rows
        };
        let (inverse, rotations) = (
            inverse_mass(declaration, t0, q, v),
            &declaration.shape().rotations,
        );
        if rotations.is_empty() {
            settled(q.clone(), &[], &inverse, &q.value, &rows)?
        } else {
            // the unknown is the increment to the position on the constraints
            let given = q.lifted(None);
            let turned = |by: &[Tangent2]| rows(&rotation::moved(rotations, &given, by));
            let by = settled(
                ValueWithChange::zeros(given.len()),
                rotations,
                &inverse,
                &q.value,
                &turned,
            )?;
            ValueWithChange::of(&rotation::moved(rotations, &given, &by.lifted(None)))
        }
    } else {
        q.clone()
    };
    let position = q.lifted(None);
    let rows = |v: &[Tangent2]| {
        let mut rows = declaration.phase(t, &position, v);
        rows.split_off(holonomic.min(rows.len()))
    };
    let v = settled(
        v.clone(),
        &[],
        &inverse_mass(declaration, t0, &q, v),
        &v.value,
        &rows,
    )?;
    Some((q, v))
}

/// The increment to the second node, from that of the start's rule, after its projection onto the holonomic and nonholonomic constraints.
pub(super) fn onto_pair(
    declaration: &Declaration<'_>,
    (t0, h): (f64, f64),
    (q0, v0): (&ValueWithChange, &ValueWithChange),
    foreseen: &ValueWithChange,
) -> Option<ValueWithChange> {
    let (node, increment) = (q0.plus(foreseen).lifted(None), foreseen.lifted(None));
    let (first, rotations) = (q0.lifted(None), &declaration.shape().rotations);
    let rows = |correction: &[Tangent2]| {
        let moved = |x: &[Tangent2]| -> Vec<Tangent2> {
            x.iter()
                .zip(correction)
                .map(|(&x, &correction)| x + correction)
                .collect()
        };
        let d = moved(&increment);
        let q = if rotations.is_empty() {
            moved(&node)
        } else {
            rotation::moved(rotations, &first, &d)
        };
        let leg = AnyLeg {
            t: Tangent2::splat(t0 + h),
            q: &q,
            d: &d,
        };
        declaration.pair(Tangent2::splat(h), leg)
    };
    let none = ValueWithChange::zeros(q0.value.len());
    let ends = q0.value.iter().zip(&foreseen.value);
    let around: Vec<f64> = ends.map(|(q, d)| q.abs().max(d.abs())).collect();
    let correction = settled(none, &[], &inverse_mass(declaration, t0, q0, v0), &around, &rows)?;
    Some(foreseen.plus(&correction))
}

/// The inverse of the mass matrix, the metric of displacements; the identity if it is singular.
fn inverse_mass(
    declaration: &Declaration<'_>,
    t: f64,
    q: &ValueWithChange,
    v: &ValueWithChange,
) -> MatrixWithChange {
    let n = q.value.len();
    let rest = ValueWithChange::zeros(n);
    let (position, velocity) = (q.lifted(None), v.lifted(None));
    let columns: Vec<Vec<Tangent2>> = (0..n)
        .map(|j| {
            declaration.continuous_force(AnyPoint {
                t: Tangent2::splat(t),
                q: &position,
                v: &velocity,
                a: &rest.lifted(Some(j)),
            })
        })
        .collect();
    let value = Matrix::from_fn(n, n, |i, j| columns[j][i].derivatives()[1]).inverse();
    if !value.is_finite() {
        return MatrixWithChange {
            value: Matrix::from_fn(n, n, |i, j| f64::from(u8::from(i == j))),
            change: Matrix::zeros(n, n),
        };
    }
    let mass_change = Matrix::from_fn(n, n, |i, j| -columns[j][i].mixed());
    MatrixWithChange {
        change: value.times(&mass_change).times(&value),
        value,
    }
}

/// The iteration of `start::consistency::solve`, with changes.
fn settled(
    mut x: ValueWithChange,
    rotations: &[usize],
    inverse: &MatrixWithChange,
    around: &[f64],
    rows: &Rows<'_>,
) -> Option<ValueWithChange> {
    let largest = |x: &[f64]| x.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
    let n = x.value.len();
    let (mut last, mut is_settled) = (f64::INFINITY, false);
    for _ in 0..MAX_ITERATIONS {
        let columns: Vec<Vec<Tangent2>> = (0..n).map(|j| rows(&x.lifted(Some(j)))).collect();
        let count = columns.first().map_or(0, Vec::len);
        let value: Vec<f64> = (0..count).map(|i| columns[0][i].value()).collect();
        let slope = Matrix::from_fn(count, n, |i, j| columns[j][i].derivatives()[1]);
        let slope_change = Matrix::from_fn(count, n, |i, j| columns[j][i].mixed());
        let forces = inverse.value.times(&slope.transposed());
        let forces_change = (inverse.change.times(&slope.transposed()))
            .plus(&inverse.value.times(&slope_change.transposed()));
        let metric = slope.times(&forces);
        let metric_change = (slope_change.times(&forces)).plus(&slope.times(&forces_change));
        if value.iter().any(|value| !value.is_finite()) || !metric.is_finite() || !metric_change.is_finite() {
            return None;
        }
        let parts = metric.solve_metric(&value);
        let moved = metric_change.times_vector(&parts);
        let right = moved.iter().enumerate();
        let right: Vec<f64> = right
            .map(|(i, moved)| columns[0][i].derivatives()[0] - moved)
            .collect();
        if right.iter().any(|right| !right.is_finite()) {
            return None;
        }
        let parts_change = metric.solve_metric(&right);
        let update = forces.times_vector(&parts);
        let of_forces = forces_change.times_vector(&parts);
        let of_parts = forces.times_vector(&parts_change);
        let part = rotation::part_of_update(rotations, &update);
        for i in 0..n {
            x.value[i] -= part * update[i];
            x.change[i] -= part * (of_forces[i] + of_parts[i]);
        }
        if is_settled {
            return Some(x);
        }
        let (step, size) = (largest(&update), largest(&x.value).max(largest(around)));
        is_settled = step <= SETTLED * size || step >= last && step <= SMALL * size;
        last = step;
    }
    None
}

#[cfg(all(test, feature = "text"))]
mod tests {
    use crate::text::Text;
    use crate::{AnyPath, AnyStart, Kernel, Variable};

    /// A bead on an ellipse that turns, with variable mass: the mass matrix, the rows and the parameters in
    /// them change.
    const BEAD: &str = "
        parameters { mass = 1.3, size = 1.2, gravity = 9.81, friction = 0.3 }
        coordinates(x, y);
        lagrangian = mass * (1 + x.powi(2) / 4) * (dot(x).powi(2) + dot(y).powi(2) + dot(x) * dot(y) / 3) / 2 - gravity * y;
        holonomic = x.powi(2) + 2 * y.powi(2) + x * y * t / 5 - size.powi(2);
        external_forces = (-friction * dot(x), 0);
    ";

    /// A sledge with an offset, which is in its constraint on velocities.
    const SLEDGE: &str = "
        parameters { mass = 1.0, inertia = 0.4, offset = 0.3 }
        coordinates(x, y, theta);
        lagrangian = mass * (dot(x).powi(2) + dot(y).powi(2)) / 2 + inertia * dot(theta).powi(2) / 2;
        nonholonomic = dot(y) * theta.cos() - dot(x) * theta.sin() - offset * dot(theta);
    ";

    /// Forward and backward derivatives of the end by position, velocity and parameters, against differences of fourth order.
    fn check(text: &str, x: &[f64], start: &dyn Fn(&[f64]) -> AnyStart, apart: &[usize]) {
        let text = Text::parse("bound", text).unwrap();
        let kernel: &dyn Kernel = &text.system;
        let (n, parameters) = (kernel.shape().dimension(), &kernel.shape().parameters);
        let end = |by: usize, change: f64| -> Vec<f64> {
            let (mut x, mut system) = (x.to_vec(), text.system.clone());
            match by.checked_sub(2 * n) {
                None => x[by] += change,
                Some(place) => *system.parameter_mut(place).unwrap() += change,
            }
            let path = AnyPath::new(&system, 0.05, &start(&x), 1.0).unwrap();
            [path.end().q, path.end().v].concat()
        };
        let path = AnyPath::new(&text.system, 0.05, &start(x), 1.0).unwrap();
        let gradient = path
            .gradient_at_end(&mut |end| end.q[0] * 0.7 + end.v[1])
            .unwrap();
        // and one that depends on the start
        let all = path
            .gradient(&mut |index, node| {
                if index == 0 {
                    node.q[1] + node.v[0]
                } else {
                    node.q[0] * 0.0
                }
            })
            .unwrap();
        let backward = [&gradient.q0[..], &gradient.v0, &gradient.parameters].concat();
        let at_start = [&all.q0[..], &all.v0, &all.parameters].concat();
        for by in (0..2 * n + parameters.len()).filter(|by| !apart.contains(by)) {
            let variable = match by {
                by if by < n => Variable::Position(by),
                by if by < 2 * n => Variable::Velocity(by - n),
                by => Variable::Parameter(&parameters[by - 2 * n].name),
            };
            let tangents = path.tangents(&[variable]).unwrap();
            let tangent = tangents.get(0).unwrap();
            let found = [tangent.q, tangent.v].concat();
            let shift = 1e-3;
            let [far, near, back, behind] = [2.0, 1.0, -1.0, -2.0].map(|k| end(by, k * shift));
            for (place, found) in found.iter().enumerate() {
                let difference = 8.0 * (near[place] - back[place]) - (far[place] - behind[place]);
                let expected = difference / (12.0 * shift);
                assert!(
                    (found - expected).abs() < 1e-8 * (1.0 + expected.abs()),
                    "{by}, {place}: {found} {expected}"
                );
            }
            let sum = 0.7 * found[0] + found[n + 1];
            assert!((backward[by] - sum).abs() < 1e-11 * (1.0 + sum.abs()), "{by}");
            let mut first = None;
            path.tangents_along(&[variable], &mut |index, _, tangents| {
                if index == 0 {
                    first = tangents.next().map(|tangent| tangent.q[1] + tangent.v[0]);
                }
            })
            .unwrap();
            assert!((at_start[by] - first.unwrap()).abs() < 1e-11, "{by}");
        }
    }

    #[test]
    fn what_moves_a_start_onto_constraints_has_derivatives() {
        let split = |x: &[f64]| -> (Vec<f64>, Vec<f64>) {
            let (q, v) = x.split_at(x.len() / 2);
            (q.to_vec(), v.to_vec())
        };
        let of = |rule: fn(&[f64], &[f64]) -> AnyStart| move |x: &[f64]| rule(&split(x).0, &split(x).1);
        let projected = |rule: fn(&[f64], &[f64]) -> AnyStart| move |x: &[f64]| of(rule)(x).projected();
        // a change of one component of the start, or of `size`, alone leaves the constraints
        let y = (1.08_f64 / 2.0).sqrt();
        let on = [0.6, y, 0.5, -(0.6 + 0.6 * y / 5.0) / (4.0 * y)];
        let beside = [0.65, 0.8, 0.5, 0.2];
        for rule in [AnyStart::paper, AnyStart::second_order] {
            check(BEAD, &on, &of(rule), &[0, 1, 2, 3, 5]);
            check(BEAD, &beside, &projected(rule), &[]);
            check(SLEDGE, &[0.1, 0.2, 0.3, 1.0, 0.2, 0.4], &projected(rule), &[]);
        }
    }
}
