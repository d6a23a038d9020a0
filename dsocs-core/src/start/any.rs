//! A start with any number of coordinates.

use std::borrow::Cow;

use super::begin::{Rule, StartData};
use super::sized::Start;
use super::third::ThirdOrderDatum;
use crate::error::SetupError;
use crate::solve::Vector;
use crate::solve::sum::Sum;
use crate::tape::Shape;

/// A [`Start`](crate::Start) with any number of coordinates: each vector is a slice with one component for
/// each. For a rotation, a position has the four numbers of a unit quaternion, the scalar first; a velocity,
/// an acceleration or a force has three numbers in the frame of the body, with or without a zero before them.
#[derive(Clone, Debug)]
#[must_use]
pub struct AnyStart(pub(crate) StartData);

impl<const N: usize> From<Start<N>> for AnyStart {
    fn from(start: Start<N>) -> Self {
        Self(start.given())
    }
}

impl AnyStart {
    /// A start at time 0 by a rule.
    fn by(q0: &[f64], rule: Rule) -> Self {
        Self(StartData {
            q0: Vector::of(q0),
            rule,
            t0: 0.0,
            projected: false,
            near: None,
        })
    }

    /// A start with the second node `q1 = q0 + h v0`; see [`Start::paper`](crate::Start::paper).
    pub fn paper(q0: &[f64], v0: &[f64]) -> Self {
        let v0 = Vector::of(v0);
        Self::by(q0, Rule::Paper { v0 })
    }

    /// A start with the second node `q1 = q0 + h v0 + h²/2 a0`; see [`Start::second_order`](crate::Start::second_order).
    pub fn second_order(q0: &[f64], v0: &[f64]) -> Self {
        let v0 = Vector::of(v0);
        Self::by(q0, Rule::SecondOrder { v0 })
    }

    /// A start with a given acceleration, which constraints of third order leave free; see [`Start::third_order`](crate::Start::third_order).
    pub fn third_order(q0: &[f64], v0: &[f64], a0: &[f64]) -> Self {
        let (v0, datum) = (Vector::of(v0), ThirdOrderDatum::Acceleration(Vector::of(a0)));
        Self::by(q0, Rule::ThirdOrder { v0, datum })
    }

    /// A start with a given constraint force, for constraints of third order; see
    /// [`Start::third_order_by_force`](crate::Start::third_order_by_force).
    pub fn third_order_by_force(q0: &[f64], v0: &[f64], force: &[f64]) -> Self {
        let (v0, datum) = (Vector::of(v0), ThirdOrderDatum::Force(Vector::of(force)));
        Self::by(q0, Rule::ThirdOrder { v0, datum })
    }

    /// A start with two given nodes; see [`Start::nodes`](crate::Start::nodes).
    pub fn nodes(q0: &[f64], q1: &[f64]) -> Self {
        let q1 = Vector::of(q1);
        Self::by(q0, Rule::Nodes { q1 })
    }

    /// A start with three given nodes, for constraints of third order; see [`Start::three_nodes`](crate::Start::three_nodes).
    pub fn three_nodes(q0: &[f64], q1: &[f64], q2: &[f64]) -> Self {
        let [q1, q2] = [q1, q2].map(Vector::of);
        Self::by(q0, Rule::ThreeNodes { q1, q2 })
    }

    /// A start whose second node lies on the continuous motion, as [`Start::exact`](crate::Start::exact) finds it: the position, the initial
    /// velocity and acceleration, and the increment `d = q(t0 + h) − q0` of the motion over a step `h` from the time `t0`. The step of the
    /// run has to be `h`.
    pub fn exact(q0: &[f64], [v0, a0]: [&[f64]; 2], d: &[f64], [t0, h]: [f64; 2]) -> Self {
        let [v0, a0] = [v0, a0].map(Vector::of);
        let d = Sum::exact(Vector::of(d));
        let rule = Rule::Exact { v0, a0, d, h, t0 };
        Self::by(q0, rule).at(t0)
    }

    /// Sets the time of the first node, which is 0 unless set.
    pub fn at(mut self, t0: f64) -> Self {
        self.0.t0 = t0;
        self
    }

    /// Moves the start onto the constraints on positions and velocities; see [`Start::projected`](crate::Start::projected).
    pub fn projected(mut self) -> Self {
        self.0.projected = true;
        self
    }

    /// Chooses the acceleration near `a0` if there are several; see [`Start::near_acceleration`](crate::Start::near_acceleration).
    pub fn near_acceleration(mut self, a0: &[f64]) -> Self {
        self.0.near = Some(Vector::of(a0));
        self
    }

    /// The start, whose vectors have one component for each coordinate.
    ///
    /// # Errors
    ///
    /// [`SetupError::StartLength`] for the first vector of another length.
    pub(crate) fn fitted(&self, shape: &Shape) -> Result<Cow<'_, StartData>, SetupError> {
        let mut start = Cow::Borrowed(&self.0);
        if !shape.rotations.is_empty() {
            start.to_mut().widen(shape);
        }
        start.fits(shape)?;
        Ok(start)
    }

    /// The start, with the zeros that velocities have in place of a rotation's scalar.
    pub(crate) fn widened(mut self, shape: &Shape) -> StartData {
        self.0.widen(shape);
        self.0
    }
}

impl StartData {
    /// Inserts the zeros into velocities, accelerations and forces that have three numbers for each rotation.
    fn widen(&mut self, shape: &Shape) {
        let Self { rule, near, .. } = self;
        let [first, second] = match rule {
            Rule::Paper { v0 } | Rule::SecondOrder { v0 } => [Some(v0), None],
            Rule::ThirdOrder { v0, datum } => match datum {
                ThirdOrderDatum::Acceleration(a0) => [Some(v0), Some(a0)],
                ThirdOrderDatum::Force(force) => [Some(v0), Some(force)],
            },
            Rule::Nodes { .. } | Rule::ThreeNodes { .. } | Rule::Exact { .. } => [None, None],
        };
        for vector in [first, second, near.as_mut()].into_iter().flatten() {
            if vector.len() + shape.rotations.len() == shape.dimension() {
                let mut numbers = vector.iter();
                *vector = (0..shape.dimension())
                    .map(|place| {
                        if shape.moves(place) {
                            numbers.next().copied().unwrap_or(f64::NAN)
                        } else {
                            0.0
                        }
                    })
                    .collect();
            }
        }
    }

    /// Checks that each vector has one component for each coordinate.
    ///
    /// # Errors
    ///
    /// [`SetupError::StartLength`] for the first vector of another length.
    pub(crate) fn fits(&self, shape: &Shape) -> Result<(), SetupError> {
        let Self { q0, rule, near, .. } = self;
        let others: [Option<(_, &Vector)>; 2] = match rule {
            Rule::Paper { v0 } | Rule::SecondOrder { v0 } => [Some(("v0", v0)), None],
            Rule::Nodes { q1 } => [Some(("q1", q1)), None],
            Rule::ThreeNodes { q1, q2 } => [Some(("q1", q1)), Some(("q2", q2))],
            Rule::ThirdOrder { v0, datum } => match datum {
                ThirdOrderDatum::Acceleration(a0) => [Some(("v0", v0)), Some(("a0", a0))],
                ThirdOrderDatum::Force(force) => [Some(("v0", v0)), Some(("force", force))],
            },
            Rule::Exact { v0, a0, .. } => [Some(("v0", v0)), Some(("a0", a0))],
        };
        let near = near.iter().map(|near| ("a0", near));
        let all = [("q0", q0)].into_iter().chain(others.into_iter().flatten());
        let coordinates = shape.dimension();
        match all.chain(near).find(|(_, vector)| vector.len() != coordinates) {
            None => Ok(()),
            Some((vector, found)) => Err(SetupError::StartLength {
                vector,
                found: found.len(),
                coordinates,
                rotations: shape.rotations.len(),
            }),
        }
    }
}
