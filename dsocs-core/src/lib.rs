//! Integrators for mechanical systems with constraints on positions, velocities and accelerations, generated from a declaration.
//!
//! A system is declared with the attribute [`macro@dsocs`] on a struct, whose fields are the parameters:
//!
//! ```
//! use dsocs_core::prelude::*;
//!
//! /// A particle in the plane whose path has a prescribed signed curvature.
//! #[dsocs {
//!     coordinates(x, y);
//!     lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
//!     let speed = (dot(x).powi(2) + dot(y).powi(2)).sqrt();
//!     kinematic = (dot(x) * ddot(y) - ddot(x) * dot(y)) / speed.powi(3) - curvature;
//!     variational = [(dot(x), dot(y))];
//! }]
//! struct Particle {
//!     mass: f64,
//!     curvature: f64,
//! }
//!
//! let particle = Particle { mass: 1.0, curvature: 0.5 };
//! let mut flow = Flow::new(&particle, 0.01, Start::second_order([0.0, 0.0], [1.0, 0.0]))?;
//! let trajectory = flow.until(10.0)?;
//! assert_eq!(trajectory.len(), 1001);
//! assert!((trajectory.nodes[1000].q[1] - (2.0 - 2.0 * 5.0_f64.cos())).abs() < 1e-3);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # How a declaration becomes a trajectory
//!
//! 1. The attribute implements [`System`]: the rows (scalar equations) of one step and their exact Jacobian as straight-line
//!    code, the maps `φ`, the constraint force and the energy. This crate contains no particular system.
//! 2. A [`Start`] and the step `h` give the first two nodes `q0`, `q1`.
//! 3. A step solves these rows by Newton's iteration. Its unknown is the *second difference* `e = (q2 − q1) − (q1 − q0)`, so that
//!    the acceleration `e/h²` has all its digits, and sums of increments are compensated. A smooth motion needs one evaluation of rows
//!    and Jacobian per step. The book's chapter *How it works* has the details.
//! 4. If a step has no solution, or several between which the past does not decide, [`StepError`] says where, why, and what to try.
//!    [`Regularity`] says whether the equations determine the solution.
//! 5. The functions of [`Stepper`] drive a run of any method. A run is an iterator of [`Node`]s. [`Stepper::until`] collects the nodes,
//!    [`Stepper::stream`] hands them to an [`Observer`], [`Stepper::watch`] finds [`Events`], [`Stepper::advance`] makes one step, and
//!    [`Stepper::reverse`] goes back in time. Parameters may change during a run ([`Inputs`]).
//!
//! # Shapes and units
//!
//! `N` is the number of coordinates. Positions, velocities, accelerations and generalized forces are arrays `[f64; N]`, with one component
//! for each coordinate, in the order of the declaration. The library does not convert units: all numbers are in the units that the
//! declaration uses. If its parameters are in SI units, times and steps are in seconds, a velocity is in units of its coordinate per second,
//! and a generalized force in joules per unit of its coordinate (newtons for a length, newton metres for an angle).
//!
//! # Which method when
//!
//! 1. *The discrete system itself*, with its invariants and forces: [`Flow`], the paper's step. It is suited for long times, switches and
//!    friction, and for constraints of any order. Its error is of order `h²`.
//! 2. *The same with higher accuracy*, symmetric in time and without a drift of the energy: [`ComposedFlow`]. Order 4 suits errors around
//!    1e-4, order 6 errors around 1e-7, and order 8 smaller errors. The only constraints that it allows are those of second order
//!    ([`Symmetry`] says why a system cannot be composed). It is slow where the mass matrix varies. Some of its stages go back in time, so
//!    with a damping `k` it needs `h < 3/k`.
//! 3. *The continuous motion* to a tolerance: [`TaylorFlow`]. It is usually the fastest method for small errors, also across jumps and
//!    corners. The constraints hold to rounding, everything else to the tolerance.
//! 4. *Not sure?* [`taylor::GlobalError`] measures the error of any of these methods against the continuous motion.
//! 5. *Many runs* of one system: an [`Ensemble`] computes eight of them at once in SIMD lanes, on all cores.
//! 6. *Fits and plans* need derivatives of a run: [`Path`] computes them for a [`Flow`].
//!
//! # The names of this crate
//!
//! A name that begins with `Any` is the same for a number of coordinates that is known only at run time, as for a system from a text
//! (`dsocs_core::text`): [`AnyFlow`] is the [`Flow`] of a [`Kernel`].
//!
//! - *Declarations.* The attribute [`macro@dsocs`], which describes what a declaration may contain; [`macro@statements`] that several
//!   declarations share; [`Samples`], functions given by samples; [`Real`], the number type of a function that a declaration calls.
//! - *Declared systems.* [`System`] evaluates one at single points: energy, forces, rows, whose arguments are an [`At`];
//!   [`Kernel`] is the same without its type; [`Declaration`], its tape with the values of its parameters; [`Shape`], its counts of coordinates,
//!   unknowns and rows; [`Quantity`], a name with its unit; [`Symmetry`], whether its steps can be composed.
//! - *Starts.* [`Start`]; a [`Violation`] is a constraint that it does not satisfy.
//! - *Methods.* [`Flow`], the paper's step; [`ComposedFlow`], the orders 4 to 8 by a [`Composition`]; [`TaylorFlow`], the continuous
//!   motion to a [`Tolerance`]; [`Ensemble`], many runs by SIMD [`Instructions`], of which an [`ObservedRun`] is one; [`Path`], a run
//!   with derivatives.
//! - *Runs.* [`Stepper`], the functions that drive one; [`Run`], the same without its number of coordinates; [`Inputs`], parameters
//!   that change at nodes; [`Clock`] and [`End`], its time.
//! - *Nodes.* [`Node`]; [`OwnedNode`], which is filled again at every node; [`Trajectory`], all nodes of a run; [`NodeMut`] and
//!   [`NodeScalars`], where a run writes a node; [`Leg`] and [`OwnedLeg`], two nodes; [`Point`] and [`OwnedPoint`], position, velocity
//!   and acceleration at any time.
//! - *Between nodes.* [`Polynomial`], the motion during a step, which a [`Visitor`] receives, with its workspace [`Workspace`] and its
//!   [`StepEnd`].
//! - *Observers.* [`Observer`] and its [`ObserverResult`]; [`Event`], [`Events`], [`Occurrence`], [`LastLeg`]; [`on_event`], which
//!   makes an [`OnEvent`]; [`CsvWriter`]; [`Estimates`] of the error.
//! - *Derivatives of runs.* [`Variable`]; [`NodeTangent`], [`OwnedTangents`], [`Gradient`]; [`Dual`], the number in which a
//!   cost is written.
//! - *A solved step.* [`StepReport`], with its [`Guess`], where Newton's iteration began, and its [`Stop`], the rule that ended it;
//!   [`Roots`], both solutions; [`Regularity`]; [`multipliers`]; the steps whose errors may be large, [`Unresolved`] and
//!   [`NearlySingular`].
//! - *Errors.* [`SetupError`] before a run, [`RunError`] during it, and [`Failure`] with all that was computed. Their causes:
//!   [`StepError`] ([`FailedStep`], [`StepFailure`], [`NewtonFailure`], [`Deficiency`], [`DependentRow`], [`Undefined`]);
//!   [`StageError`] of a composition ([`FailedStage`], [`StageFailure`]); [`SeriesError`] ([`FailedSeries`], [`SeriesFailure`],
//!   [`Jump`]); [`FailedEvent`], [`InputError`], [`NotReversible`], [`TimeBehind`]; [`SamplesError`]; [`DerivativeError`].
//! - *Analysis.* [`mod@geometry`]: Legendre transforms, two-forms, the flow as a map, momentum maps, the theorem on the flow;
//!   [`mod@linear`]: linear models and equilibria; [`mod@taylor`]: lanes, tangents and errors of series;
//!   [`least_independent`], the constraint that is nearest to depending on the others.
//!
//! The book, with a chapter on each subject, is the module `guide` of `dsocs-systems`.

// tests compare floats exactly where the results are exact
#![cfg_attr(test, allow(clippy::float_cmp))]

// the systems declared in tests refer to this crate by name
#[cfg(test)]
extern crate self as dsocs_core;

// Layers: a folder uses only folders above it in this list.

// threads
mod threads;

// numbers, sampled functions, linear and nonlinear equations, Taylor series
mod number;

mod samples;

mod solve;

mod series;

// declarations: tapes (bytecode), and kernels (compiled or interpreted)
mod tape;

mod kernel;

// regularity of the equations, and errors
mod regularity;

mod error;

// the interface of a system
mod system;

// starts, steps, runs
mod start;

mod step;

mod run;

// methods
mod flow;

mod composition;

mod ensemble;

mod derivative;

pub mod taylor;

// analysis, and declarations as text
pub mod geometry;

pub mod linear;

pub mod prelude;

#[cfg(feature = "text")]
pub mod text;

#[cfg(test)]
mod testing;

pub use dsocs_macros::{dsocs, statements};

pub use crate::number::dual::Dual;
pub use crate::number::instructions::Instructions;
pub use crate::number::point::{AnyLeg, AnyPoint, Leg, OwnedLeg, OwnedPoint, Point};
pub use crate::number::real::Real;
pub use crate::regularity::deficiency::{Deficiency, DependentRow};
pub use crate::regularity::dependence::least_independent;
pub use crate::regularity::undefined::Undefined;
pub use crate::solve::failure::{NewtonFailure, StepFailure};
pub use crate::solve::newton::Stop;
pub use crate::tape::declaration::Declaration;
pub use crate::tape::quantity::Quantity;
pub use composition::{AnyComposedFlow, ComposedFlow, Composition, FailedStage, StageError, StageFailure};
pub use derivative::{
    AnyGradient, AnyPath, AnyTangent, DerivativeError, Gradient, NodeTangent, OwnedTangents, Path, Variable,
};
pub use ensemble::{AnyEnsemble, AnyObservedRun, Ensemble, ObservedRun};
pub use error::{FailedStep, SetupError, StepError, Violation};
pub use flow::{AnyFlow, Flow, Roots, multipliers};
pub use kernel::report::{NodeMut, NodeScalars};
pub use kernel::{At, Kernel};
pub use regularity::Regularity;
pub use run::{
    AnyEvent, AnyEvents, AnyNode, AnyObserver, AnyOccurrence, AnyPolynomial, AnyVisitor, Clock, CsvWriter,
    End, Event, Events, FailedEvent, Failure, InputError, Inputs, LastLeg, NearlySingular, Node,
    NotReversible, Observer, ObserverResult, Occurrence, OnEvent, OwnedNode, Polynomial, Run, RunError,
    SampleObserver, StepEnd, Stepper, TimeBehind, Trajectory, Unresolved, Visitor, Workspace, on_event,
};
pub use samples::{Samples, SamplesError};
pub use start::{AnyStart, Start};
pub use step::{Guess, StepReport};
pub use system::System;
pub use tape::{Shape, Symmetry};
pub use taylor::{Estimates, FailedSeries, Jump, SeriesError, SeriesFailure, TaylorFlow, Tolerance};

/// Items that generated code uses beside the public ones; not part of the public interface.
#[doc(hidden)]
pub mod __private {
    pub use crate::kernel::generated::{Compiled, Report};
    pub use crate::kernel::halt::{Halt, HaltReason};
    pub use crate::kernel::jets::Jets;
    pub use crate::kernel::report::NodeMut;
    pub use crate::kernel::run_state::RunState;
    pub use crate::kernel::{At, Kernel};
    pub use crate::number::dual::{Dual, Part};
    pub use crate::number::lanes::Lanes;
    pub use crate::number::point::{AnyLeg, AnyPoint, OwnedPoint};
    pub use crate::number::real::generic::{call_1, call_2, call_3, call_4, call_5, call_6};
    pub use crate::number::scalar::Scalar;
    pub use crate::number::tangent::{Tangent, Tangent2};
    pub use crate::run::held_value;
    pub use crate::series::coefficient::Coefficient;
    pub use crate::series::orders::RECIPROCALS;
    pub use crate::series::rows::Rows;
    pub use crate::series::sums::{Table, add_product, weighted};
    pub use crate::solve::sparse::Sparse;
    pub use crate::solve::unknown::{Linearization, Unknown};
    pub use crate::step::{TapeError, TapeKernel};
    pub use crate::tape::Shape;
    pub use crate::tape::declaration::Declaration;
    pub use crate::tape::{CallData, Number, Source, Tape, table};
    pub use crate::taylor::solve::{Accelerations, back};

    /// Formulas of the recurrences of Taylor series.
    pub mod series {
        pub use crate::series::formulas::*;
    }

    /// Items that the code of the attribute uses for a kernel.
    pub mod kernel {
        pub use crate::kernel::compiled::*;
        pub use crate::step::smooth::smooth;
    }

    /// Constants that are known in every declaration.
    pub mod __circle {
        pub use core::f64::consts::{PI, TAU};
        #[allow(non_upper_case_globals, reason = "as formulas write it")]
        pub const pi: f64 = PI;
        #[allow(non_upper_case_globals, reason = "as formulas write it")]
        pub const tau: f64 = TAU;
    }

    /// Calls a part of a long function as a function that is not inlined.
    #[inline(never)]
    pub fn apart<R>(part: impl FnOnce() -> R) -> R {
        part()
    }
}
