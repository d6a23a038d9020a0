//! The linear model of the continuous motion.

use super::chart::{Chart, ConstraintRows};
use super::corner;
use super::error::LinearizationError;
use super::inputs_outputs::{InputsOutputs, Measured};
use super::model::{Columns, Frame, LinearModel, LinearTime};
use super::slopes::{At, Direction, Slopes};
use crate::number::bounded::{Bounded, UNIT};
use crate::number::point::{AnyPoint, map};
use crate::number::scalar::Scalar as _;
use crate::regularity::undefined;
use crate::solve::{Square, rotation};
use crate::tape::declaration::Declaration;
use crate::tape::{Leaf, Part, Segment};

/// A component of the acceleration below this many times its rounding error is zero.
pub(super) const ROUNDINGS: f64 = 4.0;

/// The variational equation at a point of a motion: the changes of acceleration and multipliers with the
/// state and the parameters, by the implicit function theorem on the rows of the continuous system.
pub(super) struct Variational {
    rows: Slopes,
    jacobian: Square,
    coordinates: usize,
}

impl Variational {
    /// The equation at a point.
    pub(super) fn of(declaration: &Declaration<'_>, at: &At<'_>) -> Self {
        let rows = at.slopes(declaration, &[(Segment::Continuous, Part::Head)]);
        let coordinates = at.q.len();
        let jacobian = rows.square(|j| match j.checked_sub(coordinates) {
            None => Leaf::A(j),
            Some(k) => Leaf::Lambda(k),
        });
        Self {
            rows,
            jacobian,
            coordinates,
        }
    }

    /// The change of the acceleration for a change of the state or of a parameter.
    pub(super) fn acceleration(&self, direction: &Direction) -> Option<Vec<f64>> {
        let right = self.rows.along(&|leaf| direction.rate(leaf, &[]));
        let right: Vec<f64> = right.iter().map(|row| -row).collect();
        let mut change = self.jacobian.solve(&right)?.to_vec();
        change.truncate(self.coordinates);
        Some(change)
    }

    /// The rounding of each component of the acceleration: that of the rows, and of their leaves, which are
    /// given in double precision, through the inverse of their Jacobian.
    pub(super) fn rounding(&self, declaration: &Declaration<'_>, at: &At<'_>) -> Vec<f64> {
        let bounded = |x: &[f64]| map(x, Bounded::splat);
        let (q, v, a) = (bounded(at.q), bounded(at.v), bounded(at.a));
        let point = AnyPoint {
            t: Bounded::splat(at.t),
            q: &q,
            v: &v,
            a: &a,
        };
        let rows = declaration.continuous(point, &bounded(at.multipliers));
        let of_row = |i: usize| {
            let leaves = self.rows.moving(i);
            let leaves = leaves.map(|(leaf, slope)| (slope * at.value(declaration, leaf)).abs());
            let evaluated = rows.get(i).map_or(f64::NAN, |row| row.error());
            evaluated + UNIT * leaves.filter(|term| term.is_finite()).sum::<f64>()
        };
        let rows: Vec<f64> = (0..self.rows.values.len()).map(of_row).collect();
        let mut rounding = vec![0.0; self.coordinates];
        for (i, of_row) in rows.iter().enumerate() {
            let unit: Vec<f64> = (0..rows.len())
                .map(|k| if i == k { *of_row } else { 0.0 })
                .collect();
            let Some(part) = self.jacobian.solve(&unit) else {
                return vec![0.0; self.coordinates];
            };
            for (rounding, part) in rounding.iter_mut().zip(part.iter()) {
                *rounding += ROUNDINGS * part.abs();
            }
        }
        rounding
    }
}

/// Numbers, with a zero in place of those that are no larger than their rounding.
pub(super) fn without_rounding(x: &[f64], rounding: &[f64]) -> Vec<f64> {
    let both = x.iter().zip(rounding);
    both.map(|(x, rounding)| if x.abs() <= *rounding { 0.0 } else { *x })
        .collect()
}

/// The error of a point without a derivative.
pub(super) fn singular(declaration: &Declaration<'_>, at: &At<'_>) -> LinearizationError {
    LinearizationError::Singular {
        q: at.q.to_vec(),
        v: at.v.to_vec(),
        undefined: undefined::without_derivative(declaration, any(at)).map(Box::new),
    }
}

/// The linear model at a point of a motion.
pub(super) fn linearized(
    declaration: &Declaration<'_>,
    at: &At<'_>,
    inputs_outputs: &InputsOutputs,
) -> Result<LinearModel, LinearizationError> {
    corner::check(declaration, at)?;
    let constraint_rows = ConstraintRows::of(declaration, at);
    let chart = constraint_rows.chart();
    let variational = Variational::of(declaration, at);
    let force = at.slopes(declaration, &[(Segment::ContinuousForce, Part::All)]);
    let measured = Measured::of(declaration, inputs_outputs, at, at.q);
    // the columns of the state and of the outputs, for a change of the state or of a parameter
    let column = |direction: &Direction| -> Option<[Vec<f64>; 2]> {
        let a = variational.acceleration(direction)?;
        let forces = || force.along(&|leaf| direction.rate(leaf, &a));
        let outputs = measured.change(&direction.q, direction, &a, &forces);
        let rotations = &declaration.shape().rotations;
        let turns = rotation::turn_rates(rotations, at.v, &direction.q, &direction.v);
        Some([chart.coordinates(&turns, &a), outputs])
    };
    let (mut columns, mut basis) = (Columns::default(), Vec::new());
    for free in chart.directions() {
        let direction = constraint_rows.obeyed(&free);
        let [a, c] = column(&direction).ok_or_else(|| singular(declaration, at))?;
        columns.a.push(a);
        columns.c.push(c);
        basis.push([direction.q, direction.v].concat());
    }
    for &parameter in inputs_outputs.inputs() {
        let direction = constraint_rows.obeyed(&still(at.q.len(), parameter));
        let [b, d] = column(&direction).ok_or_else(|| singular(declaration, at))?;
        columns.b.push(b);
        columns.d.push(d);
    }
    if !columns.is_finite() {
        return Err(singular(declaration, at));
    }
    let told = (
        chart.coordinates(
            at.v,
            &without_rounding(at.a, &variational.rounding(declaration, at)),
        ),
        measured.values(&|| force.values.clone()),
    );
    let frame = Frame {
        declaration,
        inputs_outputs,
        chart: &chart,
        time: LinearTime::Continuous,
        point: point(at),
    };
    Ok(frame.model(&columns, told, [basis.clone(), basis]))
}

/// A change of one parameter alone.
pub(super) fn still(coordinates: usize, parameter: usize) -> Direction {
    Direction {
        q: vec![0.0; coordinates],
        v: vec![0.0; coordinates],
        parameter: Some(parameter),
    }
}

/// The point, without its multipliers.
fn point(at: &At<'_>) -> crate::number::point::OwnedPoint<f64> {
    any(at).to_owned()
}

fn any<'a>(at: &At<'a>) -> AnyPoint<'a, f64> {
    AnyPoint {
        t: at.t,
        q: at.q,
        v: at.v,
        a: at.a,
    }
}

/// The derivatives of the acceleration by every coordinate and every velocity, column by column; `None` if
/// there are none.
pub(super) fn acceleration_slopes(declaration: &Declaration<'_>, at: &At<'_>) -> Option<Vec<Vec<f64>>> {
    let variational = Variational::of(declaration, at);
    let n = at.q.len();
    let whole = Chart {
        positions: super::chart::Basis::of(n, &[]),
        velocities: super::chart::Basis::of(n, &[]),
    };
    whole
        .directions()
        .map(|direction| variational.acceleration(&direction))
        .collect()
}
