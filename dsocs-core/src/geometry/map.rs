//! The discrete flow as a map of pairs, and its tangent map.

use super::array::{along, minus, moving_leg, plus, slopes, square};
use super::error::GeometryError;
use super::form::Displacement;
use super::solvable::{self, Solution, WantedSolution};
use super::units;
use crate::error::SetupError;
use crate::kernel::Kernel;
use crate::number::inner_product;
use crate::number::point::{AnyLeg, OwnedLeg};
use crate::number::scalar::Scalar as _;
use crate::number::tangent::Tangent;
use crate::regularity::lengths::lengths;
use crate::solve::failure::NewtonFailure;
use crate::solve::rotation;
use crate::tape::declaration::Declaration;

/// Largest distance of a step's solution from the triple that is claimed to be a trajectory, relative to the
/// legs.
const SAME: f64 = 1e-6;

/// Three consecutive nodes `(q0, q1, q2)`: a leg, and the second difference that leads to the third node.
#[derive(Clone, Debug, PartialEq)]
pub struct Triple {
    /// The first two nodes.
    pub leg: OwnedLeg<f64>,
    /// The second difference `e = q2 − 2 q1 + q0`, with one component for each coordinate.
    pub e: Vec<f64>,
}

impl Triple {
    /// The triple of a leg and the second difference `e = q2 − 2 q1 + q0`.
    #[must_use]
    pub fn new(leg: AnyLeg<'_, f64>, e: &[f64]) -> Self {
        Self {
            leg: leg.to_owned(),
            e: e.to_vec(),
        }
    }

    /// The first two nodes, `(q0, q1)`.
    #[must_use]
    pub fn first(&self) -> AnyLeg<'_, f64> {
        self.leg.any()
    }

    /// The last two nodes, `(q1, q2)`, for the step `h`, in a system without rotations.
    #[must_use]
    pub fn last(&self, h: f64) -> OwnedLeg<f64> {
        let d = plus(&self.leg.d, &self.e);
        OwnedLeg {
            t: self.leg.t + h,
            q: plus(&self.leg.q, &d),
            d,
        }
    }

    /// The last two nodes, for systems that may have rotations, whose increments are turns.
    pub(super) fn last_of(&self, rotations: &[usize], h: f64) -> OwnedLeg<f64> {
        let d = plus(&self.leg.d, &self.e);
        OwnedLeg {
            t: self.leg.t + h,
            q: rotation::moved(rotations, &self.leg.q, &d),
            d,
        }
    }

    /// The nodes, rounded.
    #[must_use]
    pub fn nodes(&self) -> [Vec<f64>; 3] {
        let q0 = minus(&self.leg.q, &self.leg.d);
        [q0, self.leg.q.clone(), self.last(0.0).q]
    }
}

/// The discrete flow `F_{L_d}: (q0, q1) ↦ (q1, q2)` of a system and a step, as a map (paper, section 6).
///
/// A [`Flow`](crate::Flow) follows one motion, with compensated sums and with the past steps as guesses. This map uses only the given pair.
#[derive(Clone)]
pub struct DiscreteFlow<'s> {
    /// The system.
    pub(super) system: &'s dyn Kernel,
    /// The step.
    pub(super) h: f64,
}

impl core::fmt::Debug for DiscreteFlow<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("DiscreteFlow")
            .field("h", &self.h)
            .finish_non_exhaustive()
    }
}

impl<'s> DiscreteFlow<'s> {
    /// The flow of a step, which may be negative. For a system with rotations it goes forward, and has no
    /// tangent map and no inverse yet.
    ///
    /// # Errors
    ///
    /// [`GeometryError::Setup`] if the step or a parameter is not usable.
    pub fn new(system: &'s dyn Kernel, h: f64) -> Result<Self, GeometryError> {
        solvable::check_step(system, h)?;
        Ok(Self { system, h })
    }

    /// The flow of the same system with another step.
    ///
    /// # Errors
    ///
    /// The errors of [`DiscreteFlow::new`].
    pub fn with_step(&self, h: f64) -> Result<Self, GeometryError> {
        Self::new(self.system, h)
    }

    /// The system.
    #[must_use]
    pub fn system(&self) -> &'s dyn Kernel {
        self.system
    }

    /// The declaration.
    pub(super) fn declaration(&self) -> Declaration<'_> {
        Declaration::of(self.system())
    }

    /// The step.
    #[must_use]
    pub fn h(&self) -> f64 {
        self.h
    }

    /// The trajectory `(q0, q1, q2)` that begins with a pair.
    ///
    /// # Errors
    ///
    /// [`GeometryError::Step`] if no solution of the step is found, [`GeometryError::Length`] if the pair has another number of coordinates.
    pub fn forward(&self, leg: AnyLeg<'_, f64>) -> Result<Triple, GeometryError> {
        let solution = self.solved(leg, WantedSolution::Watched)?;
        Ok(Triple::new(leg, &solution.e))
    }

    /// The trajectory that begins with a pair, with the solution that is nearest to the second difference `e`. If there are two solutions, this
    /// chooses the one of a known motion.
    ///
    /// # Errors
    ///
    /// [`GeometryError::Step`] if no solution of the step is found from there, [`GeometryError::Length`] if the pair has another number of
    /// coordinates.
    pub fn forward_near(&self, leg: AnyLeg<'_, f64>, e: &[f64]) -> Result<Triple, GeometryError> {
        let solution = self.solved(leg, WantedSolution::Near(e))?;
        Ok(Triple::new(leg, &solution.e))
    }

    /// Refuses systems with rotations.
    pub(super) fn without_rotations(&self, method: &'static str) -> Result<(), GeometryError> {
        SetupError::for_rotations(
            self.system.shape(),
            [method, "take the derivatives of the run itself (Path)"],
        )?;
        Ok(())
    }

    /// Checks that vectors have one component for each coordinate.
    pub(super) fn check(&self, vectors: &[&[f64]]) -> Result<(), GeometryError> {
        let coordinates = self.system.shape().dimension();
        match vectors.iter().find(|vector| vector.len() != coordinates) {
            None => Ok(()),
            Some(vector) => Err(GeometryError::Length {
                found: vector.len(),
                coordinates,
            }),
        }
    }

    /// The solution of the step from `leg`.
    pub(super) fn solved(
        &self,
        leg: AnyLeg<'_, f64>,
        wanted: WantedSolution<'_>,
    ) -> Result<Solution, GeometryError> {
        self.check(&[leg.q, leg.d])?;
        if let WantedSolution::Near(e) = wanted {
            self.check(&[e])?;
        }
        match solvable::step(self.system, self.h, leg, wanted) {
            Ok(solution) => Ok(solution),
            Err(cause) => Err(failed(leg, cause)),
        }
    }

    /// The tangent map `TF` at the pair `(q0, q1)` of a trajectory, by the implicit function theorem on the generated rows.
    ///
    /// # Errors
    ///
    /// [`GeometryError::NoTrajectory`] if the triple does not solve the step, [`GeometryError::Singular`] if the rows do not
    /// determine a derivative, [`GeometryError::Setup`] if a coordinate is a rotation.
    pub fn tangent(&self, triple: &Triple) -> Result<TangentMap, GeometryError> {
        self.without_rotations("the tangent map of a pair of nodes (geometry::DiscreteFlow::tangent)")?;
        let (leg, e) = (triple.leg.any(), &triple.e);
        let Solution { z, e: found } = self.solved(leg, WantedSolution::Near(e))?;
        let declaration = self.declaration();
        let lengths = lengths(&declaration, self.h, leg, e);
        let mut apart = found.iter().zip(e).zip(&lengths);
        if apart.any(|((found, e), length)| (found - e).abs() > SAME * length) {
            let [q0, q1, q2] = triple.nodes();
            let found = Triple::new(leg, &found).last(self.h).q;
            return Err(GeometryError::NoTrajectory { q0, q1, q2, found });
        }
        let units = units(leg);
        let n = units.len();
        let jacobian = declaration.jacobian(self.h, leg, &z);
        // q0 = q1 − d: a change of q0 changes d by its negative, a change of q1 changes both
        let column = |(j, &unit): (usize, &f64), [by_q, by_d]: [f64; 2]| -> Option<Vec<f64>> {
            let leg = moving_leg(leg, &along(n, j, by_q * unit), &along(n, j, by_d * unit));
            let h = Tangent::splat(self.h);
            let rows = declaration.rows(h, leg.any(), &moved(&z, |_| 0.0));
            let right: Vec<f64> = rows.iter().map(|row| -row.derivative()).collect();
            let change = solvable::solve(&jacobian, &right)?;
            let moving = moved(&z, |k| change[k]);
            let e = declaration.second_difference(h, leg.any(), &moving);
            let slopes = slopes(&e, unit);
            slopes.iter().all(|slope| slope.is_finite()).then_some(slopes)
        };
        let columns = |parts: [f64; 2]| -> Option<Vec<Vec<f64>>> {
            units.iter().enumerate().map(|unit| column(unit, parts)).collect()
        };
        let (Some(back), Some(on)) = (columns([0.0, -1.0]), columns([1.0, 1.0])) else {
            let [q0, q1, _] = triple.nodes();
            return Err(GeometryError::Singular { q0, q1 });
        };
        let (mut by_first, mut by_second) = (square(n), square(n));
        for (i, (by_first, by_second)) in by_first.iter_mut().zip(&mut by_second).enumerate() {
            (*by_first, *by_second) = (along(n, i, -1.0), along(n, i, 2.0));
            for j in 0..n {
                by_first[j] += back[j][i];
                by_second[j] += on[j][i];
            }
        }
        Ok(TangentMap { by_first, by_second })
    }
}

/// The unknowns with a derivative each.
pub(super) fn moved(z: &[f64], derivative: impl Fn(usize) -> f64) -> Vec<Tangent> {
    let unknowns = z.iter().enumerate();
    unknowns
        .map(|(k, &value)| Tangent::new(value, derivative(k)))
        .collect()
}

/// The error of a step without a solution.
fn failed(leg: AnyLeg<'_, f64>, cause: NewtonFailure) -> GeometryError {
    GeometryError::Step {
        q0: minus(leg.q, leg.d),
        q1: leg.q.to_vec(),
        cause: Box::new(cause),
    }
}

/// The tangent map of the discrete flow, `(δq0, δq1) ↦ (δq1, δq2)`, by the derivatives of `q2`.
#[derive(Clone, Debug, PartialEq)]
pub struct TangentMap {
    /// `∂q2/∂q0`, row `i` for the coordinate `i` of `q2`.
    pub by_first: Vec<Vec<f64>>,
    /// `∂q2/∂q1`.
    pub by_second: Vec<Vec<f64>>,
}

impl TangentMap {
    /// Applies the map to a displacement.
    #[must_use]
    pub fn apply(&self, displacement: &Displacement) -> Displacement {
        let Displacement { first, second } = displacement;
        let rows = self.by_first.iter().zip(&self.by_second);
        let moved = rows
            .map(|(by_first, by_second)| inner_product(by_first, first) + inner_product(by_second, second));
        Displacement {
            first: second.clone(),
            second: moved.collect(),
        }
    }
}
