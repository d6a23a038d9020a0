//! The state at which a system is linearized.

use super::continuous;
use super::error::LinearizationError;
use super::inputs_outputs::InputsOutputs;
use super::model::LinearModel;
use super::slopes::At;
use super::step;
use crate::error::SetupError;
use crate::geometry::solvable;
use crate::kernel::Kernel;
use crate::start::{self, AnyStart, Phase};
use crate::tape::declaration::Declaration;

/// A state at which a system is linearized, with the names of inputs and outputs.
///
/// The state is a [`Start`](crate::Start) with position and velocity, including its options: a time, a
/// projection onto the constraints, the acceleration to choose if there are several. Constraints are of
/// second order at most. It need not be an equilibrium: [`LinearModel::drift`] is its motion.
///
/// *Inputs* are parameters, by name; without [`OperatingPoint::inputs`], all of them. If a constraint on
/// positions depends on one, its column is that of motions with another constant value. *Outputs* are
/// coordinates (`theta`), velocities (`v_theta`), accelerations (`a_theta`), generalized constraint forces
/// (`force_theta`), the `energy`, and observed expressions; without [`OperatingPoint::outputs`], all
/// coordinates and velocities.
///
/// For a rotation `r`, the states are the turns about the axes of its body, `turn_r_x` and so on, and the
/// angular velocity in the frame of the body; the outputs `r_w`, `r_x`, … are the components of its
/// quaternion, as in a run.
///
/// See [`mod@crate::linear`] for the formula and an example.
#[derive(Clone)]
#[must_use]
pub struct OperatingPoint<'s> {
    system: &'s dyn Kernel,
    start: AnyStart,
    inputs: Option<Vec<String>>,
    outputs: Option<Vec<String>>,
}

impl core::fmt::Debug for OperatingPoint<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("OperatingPoint")
            .field("start", &self.start)
            .field("inputs", &self.inputs)
            .field("outputs", &self.outputs)
            .finish_non_exhaustive()
    }
}

/// A point of a motion.
struct Place {
    phase: Phase,
    a: Vec<f64>,
    multipliers: Vec<f64>,
}

impl Place {
    fn at(&self) -> At<'_> {
        At {
            t: self.phase.t0,
            q: &self.phase.q0,
            v: &self.phase.v0,
            a: &self.a,
            multipliers: &self.multipliers,
        }
    }
}

impl<'s> OperatingPoint<'s> {
    /// The state of a system.
    pub fn new(system: &'s dyn Kernel, start: impl Into<AnyStart>) -> Self {
        Self {
            system,
            start: start.into(),
            inputs: None,
            outputs: None,
        }
    }

    /// Names the inputs.
    pub fn inputs<I: IntoIterator>(mut self, names: I) -> Self
    where
        I::Item: Into<String>,
    {
        self.inputs = Some(names.into_iter().map(Into::into).collect());
        self
    }

    /// Names the outputs.
    pub fn outputs<I: IntoIterator>(mut self, names: I) -> Self
    where
        I::Item: Into<String>,
    {
        self.outputs = Some(names.into_iter().map(Into::into).collect());
        self
    }

    fn inputs_outputs(&self) -> Result<InputsOutputs, LinearizationError> {
        InputsOutputs::of(
            self.system.shape(),
            self.inputs.as_deref(),
            self.outputs.as_deref(),
        )
    }

    /// The point of the motion through the state.
    fn place(&self) -> Result<Place, LinearizationError> {
        let (shape, declaration) = (self.system.shape(), Declaration::of(self.system));
        if shape.is_of_third_order() {
            return Err(LinearizationError::Setup(SetupError::ThirdOrder {
                method: "a linear model (linear::OperatingPoint)",
            }));
        }
        let start = self.start.fitted(shape)?;
        start::check_parameters(&declaration)?;
        let phase = start.phase(&declaration)?;
        let state = (phase.t0, &phase.q0[..], &phase.v0[..]);
        let (a, multipliers) = start::state(&declaration, state, phase.near.as_deref())?;
        start::check_determined(&declaration, state, &a)?;
        Ok(Place {
            a: a.to_vec(),
            multipliers: multipliers.to_vec(),
            phase,
        })
    }

    /// The linear model of the continuous motion.
    ///
    /// # Errors
    ///
    /// [`LinearizationError`] if a name is unknown, the state cannot be used, or the equations have no derivative there: at a jump such as that
    /// of `signum`, at a corner, or where they are singular.
    pub fn continuous(&self) -> Result<LinearModel, LinearizationError> {
        let (inputs_outputs, place) = (self.inputs_outputs()?, self.place()?);
        continuous::linearized(&Declaration::of(self.system), &place.at(), &inputs_outputs)
    }

    /// The linear model of the paper's step `h`, from one node to the next. The state of a node is the one
    /// that a run reports: the position `q1` and the velocity of `φ_{D_K}⁻¹(q0, q1, q2)`. `B` is for inputs
    /// that keep their value: to second order in `h`, for an input that is held from the node to the next.
    ///
    /// At an equilibrium, `A` is `exp(A h)` of the continuous motion to third order in `h`. In motion with
    /// constraints on positions or velocities, the states of the next node are those along its own free
    /// directions, [`LinearModel::basis_after`].
    ///
    /// # Errors
    ///
    /// The errors of [`OperatingPoint::continuous`], and [`LinearizationError`] if the step cannot be used or has no solution.
    pub fn step(&self, h: f64) -> Result<LinearModel, LinearizationError> {
        let (inputs_outputs, place) = (self.inputs_outputs()?, self.place()?);
        solvable::check_step(self.system, h)?;
        step::linearized(self.system, h, &place.at(), &inputs_outputs)
    }
}
