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
//! 3. The unknown of a step is the *second difference* `e = (q2 − q1) − (q1 − q0)`. Dividing differences of rounded
//!    nodes by `h²` would lose digits, and more of them for a smaller `h`. With `e` as the unknown, the acceleration
//!    `e/h²` has all its digits. The increment `q1 − q0` and the node are sums of second differences. Both sums are
//!    compensated: each carries its rounding error with it. At `h = 1e-5` a particle is 1e-13
//!    away from the exact discrete motion after 5·10⁷ steps
//!    (`cargo test --release -p dsocs-tests --test core_units -- --ignored --nocapture`).
//! 4. The first guess of Newton's iteration is extrapolated by a polynomial, of degree 5 at most, through the last
//!    solutions. The iteration ends when its update is small: the error after an update is quadratic in the update, so
//!    it is then below rounding. A smooth motion needs one evaluation of rows and Jacobian per step. If an update
//!    grows, it is shortened. If it stops shrinking, it is compared with the rounding error of the rows. If the
//!    iteration diverges from every guess, a homotopy leads from the straight line to the root. If two roots are
//!    close, the step takes the one whose Jacobian determinant continues those of the last steps. If that does not decide,
//!    it fails ([`StepFailure::AmbiguousRoot`]). If a step has no solution, [`StepError`] says where, why, and what to
//!    try. [`Regularity`] says whether the equations determine the solution.
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
//! # Where to look
//!
//! The attribute [`macro@dsocs`] describes what a declaration may contain. [`Samples`] are sampled functions
//! of time or of a coordinate. The trait [`System`] evaluates a declared system at single points: energy,
//! forces, rows. [`mod@geometry`] has the paper's objects: Legendre transforms, two-forms, the flow as a map,
//! momentum maps, the theorem on the flow. [`mod@linear`] has linear models and equilibria. [`RunError`] and
//! [`SetupError`] give the cause of a failure and advice. The book, with a chapter on each of these, is the
//! module `guide` of `dsocs-systems`.

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
    NotReversible, Observer, ObserverResult, Occurrence, OnEvent, OwnedNode, Polynomial, Room, Run, RunError,
    StepEnd, Stepper, TimeBehind, Trajectory, Unresolved, Visitor, on_event,
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
