//! Derivatives of the first leg, and of the acceleration at the start, by the start and the parameters.

use super::error::DerivativeError;
use crate::any::AnySystem;
use crate::declaration::Declaration;
use crate::dense::Matrix;
use crate::start::{Beginning, StartOrder};
use crate::tape::{Eight, Input, Leaf, Part, Room, Segment};

/// The derivatives of an acceleration, or of an increment, by position, velocity and parameters.
#[derive(Clone, Debug)]
pub(super) struct Slopes<const N: usize> {
    pub by_q: [[f64; N]; N],
    pub by_v: [[f64; N]; N],
    /// By one parameter after another.
    pub by_parameters: Vec<[f64; N]>,
}

/// The derivatives at the start.
#[derive(Clone, Debug)]
pub(super) struct Begun<const N: usize> {
    /// The rule that gives the second node.
    pub order: StartOrder,
    /// Those of the first increment; zero if two nodes are given.
    pub increment: Slopes<N>,
    /// The acceleration at the start, with its derivatives; `None` if it cannot be computed.
    pub acceleration: Option<([f64; N], Slopes<N>)>,
}

impl<const N: usize> Slopes<N> {
    fn none(parameters: usize) -> Self {
        Self {
            by_q: [[0.0; N]; N],
            by_v: [[0.0; N]; N],
            by_parameters: vec![[0.0; N]; parameters],
        }
    }

    /// The change that follows from changes of position, velocity and parameters.
    pub fn change(&self, q: &[f64; N], v: &[f64; N], parameters: &[f64]) -> [f64; N] {
        core::array::from_fn(|i| {
            let by_q: f64 = self.by_q[i].iter().zip(q).map(|(slope, q)| slope * q).sum();
            let by_v: f64 = self.by_v[i].iter().zip(v).map(|(slope, v)| slope * v).sum();
            let own = self.by_parameters.iter().zip(parameters);
            by_q + by_v + own.map(|(slope, p)| slope[i] * p).sum::<f64>()
        })
    }

    /// Adds the derivatives of a weighted sum of the components.
    pub fn add(&self, weights: &[f64; N], q: &mut [f64; N], v: &mut [f64; N], parameters: &mut [f64]) {
        for (i, weight) in weights.iter().enumerate().filter(|(_, weight)| **weight != 0.0) {
            for j in 0..N {
                q[j] += weight * self.by_q[i][j];
                v[j] += weight * self.by_v[i][j];
            }
            for (sum, slope) in parameters.iter_mut().zip(&self.by_parameters) {
                *sum += weight * slope[i];
            }
        }
    }
}

impl<const N: usize> Begun<N> {
    /// The derivatives of a start of a run with the step `h`.
    pub fn new(
        system: &dyn AnySystem<N>,
        h: f64,
        order: StartOrder,
        beginning: &Beginning<N>,
    ) -> Result<Self, DerivativeError> {
        let declaration = system.declaration();
        if order == StartOrder::Exact {
            return Err(DerivativeError::Start {
                reason: "an exact start has no derivatives",
            });
        }
        if declaration.lower() > 0 && order != StartOrder::Nodes {
            return Err(DerivativeError::Start {
                reason: "constraints bind the second node to the first",
            });
        }
        let parameters = system.parameters().len();
        let acceleration = acceleration(system, &declaration, beginning, parameters);
        let mut increment = Slopes::none(parameters);
        if order != StartOrder::Nodes {
            for (i, row) in increment.by_v.iter_mut().enumerate() {
                row[i] = h;
            }
        }
        if let (StartOrder::Second, Some((_, slopes))) = (order, &acceleration) {
            let factor = h * h / 2.0;
            for i in 0..N {
                for j in 0..N {
                    increment.by_q[i][j] += factor * slopes.by_q[i][j];
                    increment.by_v[i][j] += factor * slopes.by_v[i][j];
                }
            }
            for (sum, slope) in increment.by_parameters.iter_mut().zip(&slopes.by_parameters) {
                *sum = slope.map(|slope| factor * slope);
            }
        }
        Ok(Self {
            order,
            increment,
            acceleration,
        })
    }
}

/// The acceleration of the continuous system at the start, with its derivatives by the implicit function theorem.
fn acceleration<const N: usize>(
    system: &dyn AnySystem<N>,
    declaration: &Declaration<'_>,
    beginning: &Beginning<N>,
    parameters: usize,
) -> Option<([f64; N], Slopes<N>)> {
    let Beginning { q0, v0, a0, t0, .. } = *beginning;
    let near = a0.or(beginning.near);
    let (a, multipliers) = system.acceleration((t0, &q0, &v0), near.as_ref()).ok()?;
    let source = declaration.source();
    let is_moving = |input| !matches!(input, Input::Leaf(Leaf::T | Leaf::H | Leaf::Clock));
    let differential = source
        .tape()
        .differential(&[(Segment::Continuous, Part::Head)], &is_moving);
    let mut room = Room::default();
    differential.evaluate(source, &mut room, 1, &mut |input| {
        Eight::splat(match input {
            Input::Leaf(Leaf::Q(i)) => q0[i],
            Input::Leaf(Leaf::V(i)) => v0[i],
            Input::Leaf(Leaf::A(i)) => a[i],
            Input::Leaf(Leaf::Lambda(i)) => multipliers.get(i).copied().unwrap_or(0.0),
            Input::Leaf(Leaf::Parameter(i)) => source.value(i),
            Input::Leaf(Leaf::T) => t0,
            _ => f64::NAN,
        })
    });
    let inputs: Vec<Input> = differential.inputs().collect();
    let rows = differential.len();
    let mut jacobian = Matrix::zeros(rows, rows);
    let mut right = Matrix::zeros(rows, 2 * N + parameters);
    for row in 0..rows {
        differential.back_from(&mut room, row, &mut |input, slope| {
            let entry = match inputs[input] {
                Input::Leaf(Leaf::A(i)) => &mut jacobian[(row, i)],
                Input::Leaf(Leaf::Lambda(i)) if N + i < rows => &mut jacobian[(row, N + i)],
                Input::Leaf(Leaf::Q(i)) => &mut right[(row, i)],
                Input::Leaf(Leaf::V(i)) => &mut right[(row, N + i)],
                Input::Leaf(Leaf::Parameter(i)) => &mut right[(row, 2 * N + i)],
                _ => return,
            };
            *entry = slope.0[0];
        });
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
    let solved = |column: usize| -> [f64; N] {
        let right: Vec<f64> = (0..rows).map(|row| -right[(row, column)]).collect();
        let solution = decomposed.solve(&right, 0.0);
        core::array::from_fn(|i| solution.get(i).copied().unwrap_or(f64::NAN))
    };
    let mut slopes = Slopes::none(parameters);
    for j in 0..N {
        let (by_q, by_v) = (solved(j), solved(N + j));
        for i in 0..N {
            slopes.by_q[i][j] = by_q[i];
            slopes.by_v[i][j] = by_v[i];
        }
    }
    for (place, slope) in slopes.by_parameters.iter_mut().enumerate() {
        *slope = solved(2 * N + place);
    }
    Some((a0.unwrap_or(a), slopes))
}
