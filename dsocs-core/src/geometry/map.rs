//! The discrete flow as a map of pairs, and its tangent map.

use super::error::GeometryError;
use super::form::Displacement;
use super::units;
use crate::declaration::Declaration;
use crate::error::NewtonFailure;
use crate::flow::{Flow, MAX_ITERATIONS};
use crate::regularity;
use crate::scalar::Scalar as _;
use crate::start;
use crate::step::Step;
use crate::step::predictor::Predictor;
use crate::step::unknown::Unknown;
use crate::system::{Leg, System};
use crate::tangent::Tangent;

/// How far a step's solution may be from the triple that it should belong to, relative to the legs.
const SAME: f64 = 1e-6;

/// Three consecutive nodes `(q0, q1, q2)`: a leg, and the second difference that leads on.
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

    /// The last two nodes, `(q1, q2)`.
    #[must_use]
    pub fn last(&self) -> Leg<f64, N> {
        let d = core::array::from_fn(|i| self.leg.d[i] + self.e[i]);
        Leg {
            q: core::array::from_fn(|i| self.leg.q[i] + d[i]),
            d,
        }
    }

    /// The nodes, rounded.
    #[must_use]
    pub fn nodes(&self) -> [[f64; N]; 3] {
        let q0 = core::array::from_fn(|i| self.leg.q[i] - self.leg.d[i]);
        [q0, self.leg.q, self.last().q]
    }
}

/// The discrete flow `F_{L_d}: (q0, q1) ↦ (q1, q2)` of a system and a step, as a map (paper, section 6).
///
/// A [`Flow`] walks along one motion, with compensated sums and a past; this map begins anew at every pair.
pub struct DiscreteFlow<'s, S: System<N>, const N: usize> {
    /// The system.
    pub(super) system: &'s S,
    /// The step.
    pub(super) h: f64,
    /// What the parameters and the step decide.
    pub(super) constants: S::Constants<f64>,
}

// by hand, because a derivation would ask the system for as much
impl<S: System<N>, const N: usize> core::fmt::Debug for DiscreteFlow<'_, S, N> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("DiscreteFlow")
            .field("h", &self.h)
            .finish_non_exhaustive()
    }
}

impl<'s, S: System<N>, const N: usize> DiscreteFlow<'s, S, N> {
    /// The flow of a step, which may be negative.
    ///
    /// # Errors
    ///
    /// [`GeometryError::Setup`] if the step or a parameter is not usable.
    pub fn new(system: &'s S, h: f64) -> Result<Self, GeometryError> {
        Flow::check(system, h)?;
        Ok(Self {
            system,
            h,
            constants: system.constants(&system.parameters(), h),
        })
    }

    /// The system.
    #[must_use]
    pub fn system(&self) -> &'s S {
        self.system
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
    /// [`GeometryError::Step`] if the step has no solution that is found.
    pub fn forward(&self, leg: &Leg<f64, N>) -> Result<Triple<N>, GeometryError> {
        let mut step = Step::new(self.system, &self.constants, *leg, self.h);
        step.past_is_short = true;
        match step.solve(&mut Predictor::new(), MAX_ITERATIONS) {
            Ok((z, _)) => Ok(Triple {
                leg: *leg,
                e: step.second_difference(&z),
            }),
            Err(cause) => Err(failed(leg, cause)),
        }
    }

    /// The trajectory that begins with a pair, with the last node nearest to that of a second difference: of two solutions,
    /// the one of a motion that is known.
    ///
    /// # Errors
    ///
    /// [`GeometryError::Step`] if the step has no solution that is found from there.
    pub fn forward_near(&self, leg: &Leg<f64, N>, e: &[f64; N]) -> Result<Triple<N>, GeometryError> {
        let (z, step) = self.solved(leg, e)?;
        Ok(Triple {
            leg: *leg,
            e: step.second_difference(&z),
        })
    }

    /// The unknowns of the step from `leg` whose second difference is nearest to `e`.
    pub(super) fn solved(
        &self,
        leg: &Leg<f64, N>,
        e: &[f64; N],
    ) -> Result<(S::Unknown<f64>, Step<'_, S, N>), GeometryError> {
        let step = Step::new(self.system, &self.constants, *leg, self.h);
        match step.any().solve_from(step.any().unknowns(e), MAX_ITERATIONS) {
            Ok((z, _)) => Ok((z, step)),
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
        let (z, step) = self.solved(leg, e)?;
        let found = step.second_difference(&z);
        let lengths = regularity::lengths(leg, e);
        if (0..N).any(|i| (found[i] - e[i]).abs() > SAME * lengths[i]) {
            let [q0, q1, q2] = triple.nodes().map(Vec::from);
            let found = Triple { leg: *leg, e: found };
            return Err(GeometryError::NoTrajectory {
                q0,
                q1,
                q2,
                found: found.last().q.to_vec(),
            });
        }
        let jacobian = step.system.linearize(step.constants, &step.known, &z).jacobian;
        let (declaration, units) = (Declaration::of(self.system), units(leg));
        // q0 = q1 − d, so moving q0 moves d back, and moving q1 moves both
        let column = |j: usize, [by_q, by_d]: [f64; 2]| -> Option<[f64; N]> {
            let along = |x: &[f64; N], part: f64| -> [Tangent; N] {
                core::array::from_fn(|i| Tangent::new(x[i], if i == j { part * units[j] } else { 0.0 }))
            };
            let leg = Leg {
                q: along(&leg.q, by_q),
                d: along(&leg.d, by_d),
            };
            let h = Tangent::splat(self.h);
            let rows = declaration.rows(h, &leg, &moved(z.as_ref(), |_| 0.0));
            let right: Vec<f64> = rows.iter().map(|row| -row.derivative()).collect();
            let change = S::Unknown::<f64>::solve(&jacobian, &start::vector(&right))?;
            let moving = moved(z.as_ref(), |k| change.as_ref()[k]);
            let e = declaration.second_difference(h, &leg, &moving);
            let slopes: [f64; N] = core::array::from_fn(|i| e[i].derivative() / units[j]);
            slopes.iter().all(|slope| slope.is_finite()).then_some(slopes)
        };
        let columns =
            |parts: [f64; 2]| -> Option<Vec<[f64; N]>> { (0..N).map(|j| column(j, parts)).collect() };
        let (Some(back), Some(on)) = (columns([0.0, -1.0]), columns([1.0, 1.0])) else {
            let [q0, q1, _] = triple.nodes().map(Vec::from);
            return Err(GeometryError::Singular { q0, q1 });
        };
        let identity = |i: usize, j: usize, times: f64| if i == j { times } else { 0.0 };
        Ok(TangentMap {
            by_first: core::array::from_fn(|i| core::array::from_fn(|j| back[j][i] + identity(i, j, -1.0))),
            by_second: core::array::from_fn(|i| core::array::from_fn(|j| on[j][i] + identity(i, j, 2.0))),
        })
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
        q0: (0..N).map(|i| leg.q[i] - leg.d[i]).collect(),
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
    /// What becomes of a displacement.
    #[must_use]
    pub fn apply(&self, displacement: &Displacement<N>) -> Displacement<N> {
        let Displacement { first, second } = displacement;
        Displacement {
            first: *second,
            second: core::array::from_fn(|i| {
                super::legendre::product(&self.by_first[i], first)
                    + super::legendre::product(&self.by_second[i], second)
            }),
        }
    }
}
