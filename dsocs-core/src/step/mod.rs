//! One step: from a leg to the second difference that leads to the next node.
//!
//! [`smooth`] makes the steps of a smooth motion, one after the other, in code of the declared type. If a
//! step halts with a [`HaltReason`](crate::kernel::halt::HaltReason), its equations are taken on slices ([`Step`])
//! and solved with the module [`solve`](crate::solve): [`guesses`] are tried if the prediction does not lead
//! to a root, and [`pair`] tells two roots apart.

mod arrays;
pub(crate) mod crossing;
mod declared;
mod guesses;
pub(crate) mod interpreted;
pub(crate) mod jumps;
mod knots;
pub(crate) mod limit;
pub(crate) mod pair;
pub(crate) mod singular;
pub(crate) mod slices;
pub(crate) mod smooth;
mod steep;
pub(crate) mod switches;

use smallvec::smallvec;

use crate::kernel::report::report;
pub use crate::kernel::report::{Guess, StepReport};
use crate::kernel::{At, Kernel};
use crate::number::point::AnyLeg;
use crate::regularity::multipliers;
use crate::solve::failure::NewtonFailure;
use crate::solve::newton::{self, Equations, Evaluation, Iterate, Linearized, Stop};
pub(crate) use crate::solve::predictor::PAST;
use crate::solve::predictor::Predictor;
use crate::solve::sparse::{Product, Update};
use crate::solve::{Numbers, Square, Vector};
use crate::start::InitialAcceleration;
use crate::tape::Shape;
use crate::tape::declaration::Declaration;
pub(crate) use guesses::FailurePlace;
pub use interpreted::{TapeError, TapeKernel};
use pair::ComparedRoot;

/// The expected size of an unknown second difference, at least, relative to the increment.
pub(crate) const SECOND_DIFFERENCE: f64 = 1e-5;

/// Largest relative change of a row's factor from a root to a point nearby, if the factor is not zero there.
pub(crate) const NEARLY_THE_SAME: f64 = 1e-2;

/// The equations of one step.
#[derive(Clone)]
pub(crate) struct Step<'a> {
    /// The system.
    pub kernel: &'a dyn Kernel,
    /// The values of its parameters.
    pub values: &'a [f64],
    /// The known values of the run.
    pub constants: &'a [f64],
    /// The known values of the step.
    known: Numbers,
    /// The step's first two nodes.
    pub leg: AnyLeg<'a, f64>,
    /// The last second difference, which a step of third order continues; in second order, zero.
    pub before: Vector,
    /// The length of the step.
    pub h: f64,
    /// Whether the past is too short to tell which of two roots continues the motion: then other roots are
    /// searched wherever the rows bend.
    pub past_is_short: bool,
    /// The acceleration that is given for the beginning of the motion, if the step is the first.
    pub initial_acceleration: Option<InitialAcceleration>,
    /// The legs of the last solutions, the last first, if they do not lie one step apart.
    pub past: Option<[AnyLeg<'a, f64>; PAST]>,
}

impl Equations for Step<'_> {
    fn are_affine(&self) -> bool {
        self.shape().linear
    }

    fn may_jump(&self) -> bool {
        self.shape().jumps
    }

    fn are_watched(&self) -> bool {
        self.shape().is_watched()
    }

    fn past_is_short(&self) -> bool {
        self.past_is_short
    }

    fn linearize(&self, z: &[f64]) -> Linearized {
        let count = self.shape().unknowns;
        let (mut rows, mut jacobian) = (Vector::nan(count), Square::zero(count));
        self.kernel
            .linearize(self.at(z), &mut rows, jacobian.entries_mut());
        Linearized { rows, jacobian }
    }

    fn sparse_update(&self, z: &Vector) -> Option<Evaluation<Vector>> {
        let sparse = self.kernel.sparse()?;
        let mut product = Product::new(sparse.is_odd());
        let evaluate = |entries: &mut [f64]| {
            let mut rows = Vector::nan(self.shape().unknowns);
            self.kernel.entries(self.at(z), &mut rows, entries);
            rows
        };
        let Update { rows, update } = sparse.update(evaluate, |pivot| product.take(pivot));
        update.is_finite().then(|| Evaluation {
            at: Iterate {
                z: z.clone(),
                rows,
                update,
            },
            safe: true,
            determinant: product.value(),
        })
    }

    fn is_declared(&self, z: &[f64], nearby: &[f64]) -> bool {
        let (Some(here), Some(there)) = (self.scales(z), self.scales(nearby)) else {
            return true;
        };
        // false also for a NaN
        let mut scales = here.iter().zip(there.iter());
        scales.all(|(here, there)| (here - there).abs() < NEARLY_THE_SAME * here.abs())
    }

    fn rounding(&self, z: &[f64]) -> Vector {
        let mut bounds = Vector::zero(self.shape().unknowns);
        self.declaration().bounds(self.h, self.leg, z, &mut bounds);
        bounds
    }
}

impl<'a> Step<'a> {
    /// The equations of the step `h` after a leg, of a system with the given parameters and known values of
    /// the run.
    pub fn new(
        (kernel, values): (&'a dyn Kernel, &'a [f64]),
        constants: &'a [f64],
        leg: AnyLeg<'a, f64>,
        h: f64,
    ) -> Self {
        let shape = kernel.shape();
        let mut before = Vector::zero(shape.increments);
        kernel.past(constants, &mut before);
        Self {
            kernel,
            values,
            constants,
            known: known(kernel, constants, leg),
            leg,
            before,
            h,
            past_is_short: false,
            initial_acceleration: None,
            past: None,
        }
    }

    /// The shape of the system.
    pub fn shape(&self) -> &'a Shape {
        self.kernel.shape()
    }

    /// The declaration, with the last second difference of third order.
    pub fn declaration(&self) -> Declaration<'_> {
        Declaration::of(self.kernel).with(self.values).after(&self.before)
    }

    fn at<'b>(&'b self, z: &'b [f64]) -> At<'b> {
        At {
            constants: self.constants,
            known: &self.known,
            z,
        }
    }

    /// The unknowns that belong to a second difference and to multipliers.
    pub fn unknown(&self, e: &[f64], multipliers: &[f64]) -> Vector {
        let mut z = Vector::nan(self.shape().unknowns);
        self.kernel.unknown(e, multipliers, &mut z);
        z
    }

    /// The second difference that belongs to the unknowns.
    pub fn second_difference(&self, z: &[f64]) -> Vector {
        let mut e = Vector::nan(self.shape().increments);
        self.kernel.second_difference(self.at(z), &mut e);
        e
    }

    /// The factor of each row, the row over the declared one; `None` if no row was multiplied.
    fn scales(&self, z: &[f64]) -> Option<Vector> {
        self.shape().scaled.then(|| {
            let mut scales = Vector::zero(self.shape().unknowns);
            self.kernel.scales(self.at(z), &mut scales);
            scales
        })
    }

    /// The second difference and the rows of the step after another leg.
    fn on_leg(&self, leg: AnyLeg<'_, f64>, z: &[f64]) -> (Vector, Linearized) {
        let moved = Step {
            known: known(self.kernel, self.constants, leg),
            leg,
            initial_acceleration: None,
            past: None,
            before: self.before.clone(),
            ..*self
        };
        (moved.second_difference(z), moved.linearize(z))
    }

    /// The unknowns of a second difference, with the multipliers that fit its constraint force best.
    pub fn unknowns(&self, e: &[f64]) -> Vector {
        let multipliers = multipliers::of_step(&self.declaration(), self.h, self.leg, e);
        self.unknown(e, &multipliers)
    }

    /// The sign of the determinant of the declared rows' Jacobian.
    pub fn orientation(&self, z: &[f64]) -> f64 {
        let sign = self.linearize(z).jacobian.determinant().value.signum();
        let scales = self.scales(z);
        let scales = scales.iter().flat_map(|scales| scales.iter());
        scales.fold(sign, |sign, scale| sign * scale.signum())
    }

    /// The expected size of each unknown without a past.
    pub fn least(&self) -> Vector {
        self.unknown(self.leg.d, &[]).map(|d| SECOND_DIFFERENCE * d.abs())
    }

    /// The expected size of each unknown: its recent one, and at least [`SECOND_DIFFERENCE`] of the
    /// increment.
    pub fn size(&self, predictor: &Predictor) -> Vector {
        predictor.expected(&self.least())
    }

    /// Solves the step, from the prediction or, if that does not lead to a root, from other guesses.
    pub fn solve(
        &self,
        predictor: &mut Predictor,
        max_iterations: u32,
    ) -> Result<(Vector, StepReport), NewtonFailure> {
        let size = self.size(predictor);
        let mut evaluations = 0;
        if let Some(start) = predictor.predict() {
            match newton::solve(self, &start, &size, max_iterations, predictor) {
                Ok(root) if self.shape().jumps && root.stop == Stop::Jump => {
                    return Ok(report(root, Guess::Predicted));
                }
                Ok(root) => {
                    let continuation = self.continuation(&root, predictor);
                    let found = ComparedRoot { root, continuation };
                    return self.checked(found, &start, Guess::Predicted, predictor, &size);
                }
                Err(failed) => evaluations = failed.evaluations,
            }
        }
        self.solve_without_prediction(predictor, &size, max_iterations, evaluations)
    }
}

/// The known values of a step, from its leg.
fn known(kernel: &dyn Kernel, constants: &[f64], leg: AnyLeg<'_, f64>) -> Numbers {
    let mut known = smallvec![f64::NAN; kernel.shape().known];
    kernel.known(constants, leg, &mut known);
    known
}
