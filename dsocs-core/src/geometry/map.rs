//! The discrete flow as a map of pairs, and its tangent map.

use super::array::{along, minus, moving_leg, plus, slopes};
use super::error::GeometryError;
use super::form::Displacement;
use super::legendre::product;
use super::solvable::{Solution, Solvable, Sought};
use super::units;
use crate::any::sized;
use crate::declaration::Declaration;
use crate::error::NewtonFailure;
use crate::regularity;
use crate::scalar::Scalar as _;
use crate::system::Leg;
use crate::tangent::Tangent;

/// How far a step's solution may be from the triple that it should belong to, relative to the legs.
const SAME: f64 = 1e-6;

/// Three consecutive nodes `(q0, q1, q2)`: a leg, and the second difference that leads to the third node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triple<const N: usize> {
    /// The first two nodes.
    pub leg: Leg<f64, N>,
    /// The second difference `e = q2 − 2 q1 + q0`.
    pub e: [f64; N],
}

impl<const N: usize> Triple<N> {
    /// The first two nodes, `(q0, q1)`.
    #[must_use]
    pub fn first(&self) -> Leg<f64, N> {
        self.leg
    }

    /// The last two nodes, `(q1, q2)`, where the step is `h`.
    #[must_use]
    pub fn last(&self, h: f64) -> Leg<f64, N> {
        let d = plus(&self.leg.d, &self.e);
        Leg {
            t: self.leg.t + h,
            q: plus(&self.leg.q, &d),
            d,
        }
    }

    /// The nodes, rounded.
    #[must_use]
    pub fn nodes(&self) -> [[f64; N]; 3] {
        let q0 = minus(&self.leg.q, &self.leg.d);
        [q0, self.leg.q, self.last(0.0).q]
    }
}

/// The discrete flow `F_{L_d}: (q0, q1) ↦ (q1, q2)` of a system and a step, as a map (paper, section 6).
///
/// A [`Flow`](crate::Flow) follows one motion, with compensated sums and with the past steps as guesses. This map uses only the given pair.
#[derive(Clone, Copy)]
pub struct DiscreteFlow<'s, const N: usize> {
    /// The system.
    pub(super) system: &'s dyn Solvable<N>,
    /// The step.
    pub(super) h: f64,
}

impl<const N: usize> core::fmt::Debug for DiscreteFlow<'_, N> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("DiscreteFlow")
            .field("h", &self.h)
            .finish_non_exhaustive()
    }
}

impl<'s, const N: usize> DiscreteFlow<'s, N> {
    /// The flow of a step, which may be negative.
    ///
    /// # Errors
    ///
    /// [`GeometryError::Setup`] if the step or a parameter is not usable.
    pub fn new(system: &'s dyn Solvable<N>, h: f64) -> Result<Self, GeometryError> {
        system.check_step(h)?;
        Ok(Self { system, h })
    }

    /// The declaration.
    pub(super) fn declaration(&self) -> Declaration<'s> {
        self.system.declaration()
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
    /// [`GeometryError::Step`] if no solution of the step is found.
    pub fn forward(&self, leg: &Leg<f64, N>) -> Result<Triple<N>, GeometryError> {
        let solution = self.solved(leg, Sought::Watched)?;
        Ok(Triple {
            leg: *leg,
            e: solution.e,
        })
    }

    /// The trajectory that begins with a pair, with the solution that is nearest to the second difference `e`. If there are two solutions, this
    /// chooses the one of a known motion.
    ///
    /// # Errors
    ///
    /// [`GeometryError::Step`] if no solution of the step is found from there.
    pub fn forward_near(&self, leg: &Leg<f64, N>, e: &[f64; N]) -> Result<Triple<N>, GeometryError> {
        let solution = self.solved(leg, Sought::Near(e))?;
        Ok(Triple {
            leg: *leg,
            e: solution.e,
        })
    }

    /// The solution of the step from `leg`.
    pub(super) fn solved(
        &self,
        leg: &Leg<f64, N>,
        sought: Sought<'_, N>,
    ) -> Result<Solution<N>, GeometryError> {
        match self.system.step(self.h, leg, sought) {
            Ok(solution) => Ok(solution),
            Err(cause) => Err(failed(leg, cause)),
        }
    }

    /// The tangent map `TF` at the pair `(q0, q1)` of a trajectory, by the implicit function theorem on the generated rows.
    ///
    /// # Errors
    ///
    /// [`GeometryError::NoTrajectory`] if the triple does not solve the step, [`GeometryError::Singular`] if the rows do not
    /// determine a derivative.
    pub fn tangent(&self, triple: &Triple<N>) -> Result<TangentMap<N>, GeometryError> {
        let Triple { leg, e } = triple;
        let Solution { z, e: found } = self.solved(leg, Sought::Near(e))?;
        let lengths = regularity::lengths(&self.declaration(), self.h, leg.any(), e);
        if (0..N).any(|i| (found[i] - e[i]).abs() > SAME * lengths[i]) {
            let [q0, q1, q2] = triple.nodes().map(Vec::from);
            let found = Triple { leg: *leg, e: found };
            return Err(GeometryError::NoTrajectory {
                q0,
                q1,
                q2,
                found: found.last(self.h).q.to_vec(),
            });
        }
        let (declaration, units) = (self.declaration(), units(leg));
        let jacobian = declaration.jacobian(self.h, leg.any(), &z);
        // q0 = q1 − d, so moving q0 moves d back, and moving q1 moves both
        let column = |j: usize, [by_q, by_d]: [f64; 2]| -> Option<[f64; N]> {
            let leg = moving_leg(leg, &along(j, by_q * units[j]), &along(j, by_d * units[j]));
            let h = Tangent::splat(self.h);
            let rows = declaration.rows(h, leg.any(), &moved(&z, |_| 0.0));
            let right: Vec<f64> = rows.iter().map(|row| -row.derivative()).collect();
            let change = self.system.solve_unknowns(&jacobian, &right)?;
            let moving = moved(&z, |k| change[k]);
            let e = declaration.second_difference(h, leg.any(), &moving);
            let slopes = slopes(&sized(&e), units[j]);
            slopes.iter().all(|slope| slope.is_finite()).then_some(slopes)
        };
        let columns =
            |parts: [f64; 2]| -> Option<Vec<[f64; N]>> { (0..N).map(|j| column(j, parts)).collect() };
        let (Some(back), Some(on)) = (columns([0.0, -1.0]), columns([1.0, 1.0])) else {
            let [q0, q1, _] = triple.nodes().map(Vec::from);
            return Err(GeometryError::Singular { q0, q1 });
        };
        let (mut by_first, mut by_second) = ([[0.0; N]; N], [[0.0; N]; N]);
        for (i, (by_first, by_second)) in by_first.iter_mut().zip(&mut by_second).enumerate() {
            (*by_first, *by_second) = (along(i, -1.0), along(i, 2.0));
            for j in 0..N {
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

/// The error of a step that is not solved.
fn failed<const N: usize>(leg: &Leg<f64, N>, cause: NewtonFailure) -> GeometryError {
    GeometryError::Step {
        q0: minus(&leg.q, &leg.d).to_vec(),
        q1: leg.q.to_vec(),
        cause: Box::new(cause),
    }
}

/// The tangent map of the discrete flow, `(δq0, δq1) ↦ (δq1, δq2)`, by the derivatives of `q2`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TangentMap<const N: usize> {
    /// `∂q2/∂q0`, row `i` for the coordinate `i` of `q2`.
    pub by_first: [[f64; N]; N],
    /// `∂q2/∂q1`.
    pub by_second: [[f64; N]; N],
}

impl<const N: usize> TangentMap<N> {
    /// Applies the map to a displacement.
    #[must_use]
    pub fn apply(&self, displacement: &Displacement<N>) -> Displacement<N> {
        let Displacement { first, second } = displacement;
        let mut moved = [0.0; N];
        for (moved, (by_first, by_second)) in moved.iter_mut().zip(self.by_first.iter().zip(&self.by_second))
        {
            *moved = product(by_first, first) + product(by_second, second);
        }
        Displacement {
            first: *second,
            second: moved,
        }
    }
}
