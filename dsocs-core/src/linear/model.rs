//! A linear model: its matrices, and the meaning of their rows and columns.

use super::chart::{Basis, Chart};
use super::inputs_outputs::InputsOutputs;
use crate::number::inner_product;
use crate::number::point::OwnedPoint;
use crate::solve::eigenvalues::eigenvalues;
use crate::solve::rotation::{self, SLOTS};
use crate::tape::quantity::Quantity;
use crate::tape::{Shape, declaration::Declaration};

/// The motion that a linear model describes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LinearTime {
    /// The continuous motion: `z' = drift + A z + B u`.
    Continuous,
    /// The paper's step: `z` at the next node is `A z + B u`.
    Step {
        /// The step.
        h: f64,
    },
}

/// A linear model of a system near a state: of its continuous motion, or of its step.
///
/// See [`OperatingPoint`](super::OperatingPoint) for its definition and how to make one.
#[derive(Clone, Debug)]
pub struct LinearModel {
    /// The motion that it describes.
    pub time: LinearTime,
    /// The point that it belongs to: time, position, velocity and acceleration. For a step, the middle node
    /// as a run reports it.
    pub point: OwnedPoint<f64>,
    /// The minimal coordinates `z`, first those of the position, then those of the velocity. One that is a
    /// single coordinate of the declaration has its name (`theta`, `v_theta`) and unit. One that moves
    /// several has the name of the one that moves most, as `along_x`, `v_along_x`. For a rotation `r`, three
    /// are the turns about the axes of its body, `turn_r_x`, `turn_r_y`, `turn_r_z`.
    pub states: Vec<Quantity>,
    /// The inputs `u`: changes of parameters from their current values.
    pub inputs: Vec<Quantity>,
    /// The outputs `y`: changes of the measured quantities from their values at the point.
    pub outputs: Vec<Quantity>,
    /// The matrix `A`, by rows, with a row and a column for each state.
    pub a: Vec<Vec<f64>>,
    /// The matrix `B`, by rows, with a row for each state and a column for each input.
    pub b: Vec<Vec<f64>>,
    /// The matrix `C` of `y = C z + D u`, by rows, with a row for each output and a column for each state.
    pub c: Vec<Vec<f64>>,
    /// The matrix `D`, by rows, with a row for each output and a column for each input.
    pub d: Vec<Vec<f64>>,
    /// The motion of the point itself: the rate of [`LinearModel::state`] along the motion through it; for a
    /// step, its change in the step. Zero at an equilibrium.
    pub drift: Vec<f64>,
    /// The outputs at the point.
    pub measured: Vec<f64>,
    /// For each state, the weights of the changes of position and velocity in it, one after the other:
    /// `z = P δ(q, v)`. The change of a rotation's position, here and below, is a zero and a turn in the
    /// frame of its body.
    pub projection: Vec<Vec<f64>>,
    /// For each state, the change of position and velocity, one after the other, for a change of the state by
    /// 1.
    pub basis: Vec<Vec<f64>>,
    /// For a step, [`LinearModel::basis`] at the next node, where the free directions may differ. For the
    /// continuous motion, that of the point.
    pub basis_after: Vec<Vec<f64>>,
    /// The first places of rotations.
    rotations: Vec<usize>,
}

impl LinearModel {
    /// The minimal coordinates `z` of a state, as a controller needs them. For a rotation it is the turn from
    /// the point, in the frame of its body, as the axis times the angle in rad, of at most half a turn; `q`
    /// and `−q` are the same attitude. Missing components are taken from the point.
    #[must_use]
    pub fn state(&self, q: &[f64], v: &[f64]) -> Vec<f64> {
        let point = self.point.any();
        self.state_about([point.q, point.v], [q, v])
    }

    /// The minimal coordinates `z` of the state `to` relative to the state `about`, each a position and a
    /// velocity. If `about` moves through the point and `to` is a motion beside it, both at one time, it is
    /// the `z` of `z' = A z + B u`. So a controller that follows a motion takes its state about that motion.
    #[must_use]
    pub fn state_about(&self, about: [&[f64]; 2], to: [&[f64]; 2]) -> Vec<f64> {
        let change = state_change(&self.rotations, about, to);
        self.projection
            .iter()
            .map(|weights| inner_product(weights, &change))
            .collect()
    }

    /// The eigenvalues of `A`, real and imaginary part of each, from the largest real part to the least. `None` if the iteration for
    /// them does not converge.
    #[must_use]
    pub fn eigenvalues(&self) -> Option<Vec<[f64; 2]>> {
        eigenvalues(&self.a)
    }
}

/// The change of position and velocity, one after the other, from a state to another one;
/// `LinearModel::projection` is applied to it. For a rotation, whose first place `rotations` contains, it is
/// a zero and the turn as the axis times the angle in rad, in the frame of the body. Missing components of
/// the second state count as unchanged.
#[must_use]
pub fn state_change(rotations: &[usize], from: [&[f64]; 2], to: [&[f64]; 2]) -> Vec<f64> {
    let [own, other] = [from, to];
    let change = |own: &[f64], x: &[f64]| -> Vec<f64> {
        let parts = own.iter().enumerate();
        parts.map(|(i, own)| x.get(i).map_or(0.0, |x| x - own)).collect()
    };
    let mut both = [change(own[0], other[0]), change(own[1], other[1])].concat();
    for first in rotations {
        if other[0].len() >= first + SLOTS {
            rotation::turns(&[*first], [own[0], other[0]], &mut both);
        } else {
            both.iter_mut()
                .skip(*first)
                .take(SLOTS)
                .for_each(|change| *change = 0.0);
        }
    }
    both
}

/// The matrices of a model by columns.
#[derive(Debug, Default)]
pub(super) struct Columns {
    pub(super) a: Vec<Vec<f64>>,
    pub(super) b: Vec<Vec<f64>>,
    pub(super) c: Vec<Vec<f64>>,
    pub(super) d: Vec<Vec<f64>>,
}

impl Columns {
    /// Whether all entries are finite.
    pub(super) fn is_finite(&self) -> bool {
        let all = [&self.a, &self.b, &self.c, &self.d];
        all.into_iter().flatten().flatten().all(|entry| entry.is_finite())
    }
}

/// The rows of a matrix with `count` rows, given by its columns.
pub(super) fn rows(columns: &[Vec<f64>], count: usize) -> Vec<Vec<f64>> {
    let row = |i: usize| columns.iter().map(|column| column[i]).collect();
    (0..count).map(row).collect()
}

/// The states of a chart.
fn states(shape: &Shape, chart: &Chart) -> Vec<Quantity> {
    let named = |basis: &Basis, of_velocity: bool| -> Vec<Quantity> {
        let each = basis.vectors.iter().zip(&basis.along);
        each.map(|(vector, &along)| {
            let Some(own) = shape.coordinates.get(along) else {
                return Quantity::new("?", "");
            };
            let alone = vector.iter().filter(|part| **part != 0.0).count() == 1;
            if let (true, Some((body, axis))) = (alone, shape.axis_of(along)) {
                return if of_velocity {
                    Quantity {
                        doc: format!(
                            "The angular velocity of `{body}` about the {axis} axis of its body [rad/s]."
                        )
                        .into(),
                        name: format!("v_{}", own.name).into(),
                    }
                } else {
                    Quantity {
                        doc: format!("The turn of `{body}` about the {axis} axis of its body [rad].").into(),
                        name: format!("turn_{}", own.name).into(),
                    }
                };
            }
            let unit = own.unit().filter(|_| alone);
            let name = match (of_velocity, alone) {
                (false, true) => return own.clone(),
                (true, true) => format!("v_{}", own.name),
                (false, false) => format!("along_{}", own.name),
                (true, false) => format!("v_along_{}", own.name),
            };
            let doc = match (of_velocity, unit) {
                (true, Some(unit)) => format!("The velocity of `{}` [{unit}/s].", own.name),
                (true, None) => format!("The velocity along a free direction, mostly of `{}`.", own.name),
                (false, _) => format!("The way along a free direction, mostly of `{}`.", own.name),
            };
            Quantity {
                name: name.into(),
                doc: doc.into(),
            }
        })
        .collect()
    };
    let mut states = named(&chart.positions, false);
    states.extend(named(&chart.velocities, true));
    states
}

/// The data of a model besides its matrices.
pub(super) struct Frame<'f> {
    pub(super) declaration: &'f Declaration<'f>,
    pub(super) inputs_outputs: &'f InputsOutputs,
    pub(super) chart: &'f Chart,
    pub(super) time: LinearTime,
    pub(super) point: OwnedPoint<f64>,
}

impl Frame<'_> {
    /// The model with its matrices.
    pub(super) fn model(
        self,
        columns: &Columns,
        (drift, measured): (Vec<f64>, Vec<f64>),
        [basis, basis_after]: [Vec<Vec<f64>>; 2],
    ) -> LinearModel {
        let shape = self.declaration.shape();
        let outputs = self.inputs_outputs.output_quantities(shape);
        LinearModel {
            time: self.time,
            states: states(shape, self.chart),
            inputs: self.inputs_outputs.input_quantities(shape),
            a: rows(&columns.a, self.chart.len()),
            b: rows(&columns.b, self.chart.len()),
            c: rows(&columns.c, outputs.len()),
            d: rows(&columns.d, outputs.len()),
            outputs,
            point: self.point,
            projection: self.chart.projection(),
            drift,
            measured,
            rotations: shape.rotations.to_vec(),
            basis,
            basis_after,
        }
    }
}
