//! From a declared discrete second order constrained system to trajectories.
#![forbid(unsafe_code)]

mod compensated;
mod error;
mod flow;
mod newton;
mod predictor;
mod rounding;
mod scalar;
mod start;
mod step;
mod system;
#[cfg(test)]
mod testing;
mod trajectory;
mod unknown;

pub use dsocs_macros::dsocs;
pub use error::{FailedStep, NewtonFailure, RunError, SetupError, StepError, StepFailure};
pub use flow::Flow;
pub use newton::Stop;
pub use num_dual::DualNum;
pub use scalar::Scalar;
pub use start::Start;
pub use step::{Guess, StepReport};
pub use system::{Leg, Parameter, Point, System};
pub use trajectory::{Failure, Node, Observer, Trajectory, UntilBreak, until_break};
pub use unknown::{Linearization, Unknown};

/// The number type of functions and methods that a declaration calls: real numbers and dual numbers over them.
///
/// ```
/// use dsocs_core::Real;
///
/// fn curvature<R: Real>(x: R, y: R) -> R {
///     (x.sin() * y.cos()) * 0.5 + 1.0
/// }
/// ```
pub trait Real: DualNum<Primitive = f64> + Copy {}

impl<R: DualNum<Primitive = f64> + Copy> Real for R {}
