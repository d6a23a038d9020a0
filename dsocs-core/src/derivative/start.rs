//! Derivatives of the first leg, and of the acceleration at the start, by the start and the parameters.

use super::bound::{self, ValueWithChange};
use super::error::DerivativeError;
use super::turning;
use crate::solve::dense::Matrix;
use crate::solve::rotation::{self, SLOTS};
use crate::start::StartOrder;
use crate::tape::declaration::Declaration;
use crate::tape::{Eight, Input, Leaf, Part, Segment, Workspace};

/// The derivatives of an acceleration, or of an increment, by position, velocity and parameters.
#[derive(Clone, Debug)]
pub(super) struct Slopes {
    /// The number of coordinates.
    coordinates: usize,
    /// The derivatives by the coordinates of the position, a row for each component.
    by_q: Vec<f64>,
    /// The derivatives by the components of the velocity, a row for each component.
    by_v: Vec<f64>,
    /// The derivatives by the parameters, a vector for each.
    by_parameters: Vec<Vec<f64>>,
}

/// The acceleration and the multipliers of the continuous system.
pub(super) struct ContinuousSolution {
    pub a: Vec<f64>,
    pub multipliers: Vec<f64>,
}

/// The beginning of a run, after its start's rule was applied.
#[derive(Clone, Debug)]
pub(super) struct AppliedStart {
    /// The rule that gives the second node.
    pub order: StartOrder,
    pub t0: f64,
    pub q0: Vec<f64>,
    pub v0: Vec<f64>,
    /// The acceleration, if the rule uses it.
    pub a0: Option<Vec<f64>>,
    /// The increment to the second node.
    pub d: Vec<f64>,
    /// Position and velocity before their projection onto the constraints, if they were projected.
    pub given: Option<[Vec<f64>; 2]>,
}

/// The derivatives at the start.
#[derive(Clone, Debug)]
pub(super) struct StartDerivatives {
    /// Derivatives of position and velocity by the given ones, if these were projected onto the constraints.
    pub projection: Option<[Slopes; 2]>,
    /// Derivatives of the first increment by the given start; zero if two nodes are given.
    pub increment: Slopes,
    /// The acceleration at the start, with its derivatives by the position and the velocity there; `None` if it cannot be computed.
    pub acceleration: Option<(Vec<f64>, Slopes)>,
}

impl Slopes {
    fn none(coordinates: usize, parameters: usize) -> Self {
        Self {
            coordinates,
            by_q: vec![0.0; coordinates * coordinates],
            by_v: vec![0.0; coordinates * coordinates],
            by_parameters: vec![vec![0.0; coordinates]; parameters],
        }
    }

    /// The derivatives along one direction after another: the coordinates of the position, the components of
    /// the velocity, the parameters.
    fn from_directions(coordinates: usize, changes: &[Vec<f64>]) -> Self {
        let (n, mut slopes) = (coordinates, Self::none(coordinates, 0));
        for (place, change) in changes.iter().enumerate() {
            match (place / n.max(1), place % n.max(1)) {
                (0, j) => (0..n).for_each(|i| slopes.by_q[i * n + j] = change[i]),
                (1, j) => (0..n).for_each(|i| slopes.by_v[i * n + j] = change[i]),
                _ => slopes.by_parameters.push(change.clone()),
            }
        }
        slopes
    }

    /// For each component, the derivatives by position and by velocity.
    fn rows(&self) -> impl Iterator<Item = (&[f64], &[f64])> {
        let n = self.coordinates.max(1);
        self.by_q.chunks_exact(n).zip(self.by_v.chunks_exact(n))
    }

    /// The change for changes of position, velocity and parameters.
    pub fn change(&self, q: &[f64], v: &[f64], parameters: &[f64]) -> Vec<f64> {
        let change = |(i, (by_q, by_v)): (usize, (&[f64], &[f64]))| {
            let by_q: f64 = by_q.iter().zip(q).map(|(slope, q)| slope * q).sum();
            let by_v: f64 = by_v.iter().zip(v).map(|(slope, v)| slope * v).sum();
            let own = self.by_parameters.iter().zip(parameters);
            by_q + by_v + own.map(|(slope, p)| slope[i] * p).sum::<f64>()
        };
        self.rows().enumerate().map(change).collect()
    }

    /// Adds the derivatives of a weighted sum of the components.
    pub fn add(&self, weights: &[f64], q: &mut [f64], v: &mut [f64], parameters: &mut [f64]) {
        for ((i, weight), (by_q, by_v)) in weights.iter().enumerate().zip(self.rows()) {
            if *weight == 0.0 {
                continue;
            }
            for (sums, slopes) in [(&mut *q, by_q), (&mut *v, by_v)] {
                for (sum, slope) in sums.iter_mut().zip(slopes) {
                    *sum += weight * slope;
                }
            }
            for (sum, slope) in parameters.iter_mut().zip(&self.by_parameters) {
                *sum += weight * slope[i];
            }
        }
    }
}

impl StartDerivatives {
    /// The derivatives of a start of a run with the step `h`.
    pub fn new(
        declaration: &Declaration<'_>,
        h: f64,
        first: &AppliedStart,
        accelerated: Option<&ContinuousSolution>,
    ) -> Result<Self, DerivativeError> {
        let order = first.order;
        if order == StartOrder::Exact {
            return Err(DerivativeError::Start {
                reason: "an exact start has no derivatives",
            });
        }
        let (n, parameters) = (declaration.dimension(), declaration.parameters().len());
        let acceleration = accelerated.and_then(|found| acceleration(declaration, first, found));
        if declaration.lower() > 0 && order != StartOrder::Nodes {
            return Self::bound(declaration, h, first, acceleration).ok_or(DerivativeError::Start {
                reason: "the start on the constraints has no derivative: its equations are singular, or not finite",
            });
        }
        let mut increment = Slopes::none(n, parameters);
        if order != StartOrder::Nodes {
            for i in 0..n {
                increment.by_v[i * n + i] = h;
            }
        }
        if let (StartOrder::Second, Some((_, slopes))) = (order, &acceleration) {
            let factor = h * h / 2.0;
            let own = [
                (&mut increment.by_q, &slopes.by_q),
                (&mut increment.by_v, &slopes.by_v),
            ];
            for (sums, slopes) in own {
                for (sum, slope) in sums.iter_mut().zip(slopes) {
                    *sum += factor * slope;
                }
            }
            for (sums, slopes) in increment.by_parameters.iter_mut().zip(&slopes.by_parameters) {
                for (sum, slope) in sums.iter_mut().zip(slopes) {
                    *sum = factor * slope;
                }
            }
        }
        Ok(Self {
            projection: None,
            increment,
            acceleration,
        })
    }

    /// The change of the increment between two given nodes, for changes of the nodes.
    pub fn increment_of_nodes(rotations: &[usize], d: &[f64], [q0, q1]: [&[f64]; 2]) -> Vec<f64> {
        let mut change: Vec<f64> = q1.iter().zip(q0).map(|(q1, q0)| q1 - q0).collect();
        for &first in rotations {
            let by_nodes = rotation::of_nodes([1, 2, 3].map(|k| d[first + k]));
            for i in 0..3 {
                let parts = by_nodes.iter().zip([q0, q1]);
                let products = parts.map(|(by, q)| (0..3).map(|j| by[i][j] * q[first + 1 + j]).sum::<f64>());
                change[first + 1 + i] = products.sum();
            }
        }
        change
    }

    /// Adds to the derivatives by the nodes the part from those by that increment.
    pub fn back_from_increment_of_nodes(
        rotations: &[usize],
        d: &[f64],
        by_d: &[f64],
        [q0, q1]: [&mut [f64]; 2],
    ) {
        for i in 0..d.len() {
            if !rotations.iter().any(|first| (*first..first + SLOTS).contains(&i)) {
                q0[i] -= by_d[i];
                q1[i] += by_d[i];
            }
        }
        for &first in rotations {
            let by_nodes = rotation::of_nodes([1, 2, 3].map(|k| d[first + k]));
            for (by, q) in by_nodes.iter().zip([&mut *q0, &mut *q1]) {
                for j in 0..3 {
                    q[first + 1 + j] += (0..3).map(|i| by[i][j] * by_d[first + 1 + i]).sum::<f64>();
                }
            }
        }
    }

    /// [`StartDerivatives::new`] for a start with constraints between its first two nodes, or whose position and velocity were projected.
    fn bound(
        declaration: &Declaration<'_>,
        h: f64,
        first: &AppliedStart,
        acceleration: Option<(Vec<f64>, Slopes)>,
    ) -> Option<Self> {
        let (n, parameters) = (declaration.dimension(), declaration.parameters().len());
        let has_acceleration = first.order == StartOrder::Second;
        let [mut positions, mut velocities, mut increments]: [Vec<Vec<f64>>; 3] = Default::default();
        for direction in 0..2 * n + parameters {
            let along = |begin: usize, count: usize| -> Vec<f64> {
                let places = begin..begin + count;
                places
                    .map(|place| f64::from(u8::from(place == direction)))
                    .collect()
            };
            let rates = along(2 * n, parameters);
            let moving = declaration.moving(&rates);
            let [own_q, own_v] = match &first.given {
                Some([q, v]) => [q, v],
                None => [&first.q0, &first.v0],
            };
            let changing = |value: &Vec<f64>, begin| ValueWithChange {
                value: value.clone(),
                change: along(begin, n),
            };
            let (mut q, mut v) = (changing(own_q, 0), changing(own_v, n));
            // the directions of a rotation are turns
            let rotations = &declaration.shape().rotations;
            if rotations.iter().any(|first| direction % n == *first) && direction < 2 * n {
                (q.change, v.change) = (vec![0.0; n], vec![0.0; n]);
            } else if direction < n {
                q.change = turning::along(rotations, own_q, direction);
            }
            if first.given.is_some() {
                (q, v) = bound::projected(&moving, first.t0, &q, &v)?;
            }
            let mut foreseen = ValueWithChange {
                value: v.value.iter().map(|v| h * v).collect(),
                change: v.change.iter().map(|v| h * v).collect(),
            };
            if has_acceleration {
                let (a, slopes) = acceleration.as_ref()?;
                let half = |a: &[f64]| a.iter().map(|a| h * h / 2.0 * a).collect();
                foreseen = foreseen.plus(&ValueWithChange {
                    value: half(a),
                    change: half(&slopes.change(
                        &rotation::body(rotations, &q.value, &q.change),
                        &v.change,
                        &rates,
                    )),
                });
            }
            let d = bound::onto_pair(&moving, (first.t0, h), (&q, &v), &foreseen)?;
            positions.push(rotation::body(rotations, &q.value, &q.change));
            velocities.push(v.change);
            increments.push(d.change);
        }
        let is_finite = increments.iter().flatten().all(|change| change.is_finite());
        let slopes = |changes: &[Vec<f64>]| Slopes::from_directions(n, changes);
        is_finite.then(|| Self {
            projection: first
                .given
                .as_ref()
                .map(|_| [slopes(&positions), slopes(&velocities)]),
            increment: slopes(&increments),
            acceleration,
        })
    }
}

/// The acceleration of the continuous system at the start, with its derivatives by the implicit function theorem.
fn acceleration(
    declaration: &Declaration<'_>,
    first: &AppliedStart,
    ContinuousSolution { a, multipliers }: &ContinuousSolution,
) -> Option<(Vec<f64>, Slopes)> {
    let AppliedStart { t0, q0, v0, a0, .. } = first;
    let (n, parameters) = (declaration.dimension(), declaration.parameters().len());
    let source = declaration.source();
    let is_moving = |input| !matches!(input, Input::Leaf(Leaf::T | Leaf::H | Leaf::Clock));
    let differential = source
        .tape()
        .differential(&[(Segment::Continuous, Part::Head)], &is_moving);
    let mut room = Workspace::default();
    differential.evaluate(source, &mut room, 1, &mut |input| {
        Eight::splat(match input {
            Input::Leaf(Leaf::Q(i)) => q0[i],
            Input::Leaf(Leaf::V(i)) => v0[i],
            Input::Leaf(Leaf::A(i)) => a[i],
            Input::Leaf(Leaf::Lambda(i)) => multipliers.get(i).copied().unwrap_or(0.0),
            Input::Leaf(Leaf::Parameter(i)) => declaration.value(i),
            Input::Leaf(Leaf::T) => *t0,
            _ => f64::NAN,
        })
    });
    let inputs: Vec<Input> = differential.inputs().collect();
    let rows = differential.len();
    let mut jacobian = Matrix::zeros(rows, rows);
    let mut right = Matrix::zeros(rows, 2 * n + parameters);
    for row in 0..rows {
        differential.back_from(&mut room, row, &mut |input, slope| {
            let entry = match inputs[input] {
                Input::Leaf(Leaf::A(i)) => &mut jacobian[(row, i)],
                Input::Leaf(Leaf::Lambda(i)) if n + i < rows => &mut jacobian[(row, n + i)],
                Input::Leaf(Leaf::Q(i)) => &mut right[(row, i)],
                Input::Leaf(Leaf::V(i)) => &mut right[(row, n + i)],
                Input::Leaf(Leaf::Parameter(i)) => &mut right[(row, 2 * n + i)],
                _ => return,
            };
            *entry = slope.0[0];
        });
    }
    // by the turns of rotations
    for &first in declaration.shape().rotations.iter() {
        let q: [f64; SLOTS] = core::array::from_fn(|k| q0[first + k]);
        for row in 0..rows {
            let slopes = core::array::from_fn(|k| right[(row, first + k)]);
            for (k, slope) in rotation::body_covector(q, slopes).into_iter().enumerate() {
                right[(row, first + k)] = slope;
            }
        }
    }
    // the scale of a row does not matter
    for row in 0..rows {
        let largest = jacobian.row(row).fold(0.0_f64, |largest, x| largest.max(x.abs()));
        jacobian.divide_row(row, largest);
        right.divide_row(row, largest);
    }
    if !jacobian.is_finite() || !right.is_finite() {
        return None;
    }
    let decomposed = jacobian.decomposed();
    let solved = |column: usize| -> Vec<f64> {
        let right: Vec<f64> = (0..rows).map(|row| -right[(row, column)]).collect();
        let mut solution = decomposed.solve(&right, 0.0);
        solution.resize(n, f64::NAN);
        solution
    };
    let mut slopes = Slopes::none(n, parameters);
    for j in 0..n {
        let (by_q, by_v) = (solved(j), solved(n + j));
        for i in 0..n {
            slopes.by_q[i * n + j] = by_q[i];
            slopes.by_v[i * n + j] = by_v[i];
        }
    }
    for (place, slope) in slopes.by_parameters.iter_mut().enumerate() {
        *slope = solved(2 * n + place);
    }
    Some((a0.as_ref().unwrap_or(a).clone(), slopes))
}
