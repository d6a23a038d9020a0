//! Linear models of a system near a state, and its equilibria.
//!
//! An [`OperatingPoint`] is a state with the names of inputs and outputs. Its [`LinearModel`]s are the matrices `A`, `B`, `C`, `D` of
//!
//! ```text
//! z' = A z + B u,   y = C z + D u     of the continuous motion
//! z  → A z + B u,   y = C z + D u     of the paper's step
//! ```
//!
//! for small changes `z` of the state, `u` of parameters and `y` of outputs. Linear control theory begins
//! with them: stability, controllability, a regulator (LQR), an observer. [`EquilibriumSearch`] finds states
//! of rest and their eigenvalues.
//!
//! # The formula
//!
//! The rows `F(t, q, v, a, λ, p) = 0` of the continuous system determine acceleration and multipliers, so by the implicit function theorem
//! `∂F/∂(a, λ) · δ(a, λ) = −∂F/∂(q, v, p) · δ(q, v, p)`. All derivatives are exact to rounding, on the tape of the declaration; no difference
//! quotient is taken. Of the step, the rows of two consecutive steps are treated in the same way.
//!
//! Constraints on positions, `g(t, q) = 0`, and on velocities, `c(t, q, v) = 0`, bind the state. The model is that of the motion on the manifold of
//! the states that obey them and `dg/dt = 0`, in as many coordinates as the manifold has dimensions: `z = (Nᵀ δq, Mᵀ δv)`, where the columns of `N`
//! are an orthonormal basis of the kernel of `∂g/∂q`, those of `M` of the kernel of `∂(dg/dt, c)/∂v`. They are chosen near the axes of the
//! coordinates, so that a coordinate that nothing binds is a state of its own. A change of `z` moves the state along
//! [`LinearModel::basis`], and `A = P ∂(v, a) T` with `P = diag(Nᵀ, Mᵀ)` and the basis `T` for columns, since `P T = 1` (the reduction of
//! C. C. de Wit, B. Siciliano, G. Bastin, *Theory of Robot Control*, Springer 1996, chapter 7, and of W. C. Rheinboldt, *Differential-algebraic
//! systems as differential equations on manifolds*, Math. Comp. 43, 1984). So eigenvalues, and everything else that does not depend on the
//! choice of coordinates, are those of any other minimal coordinates.
//!
//! # Operating points in motion
//!
//! `z` compares two motions at the same time: the one through the point, and one beside it.
//! [`LinearModel::drift`] is the motion of the first. [`LinearModel::state`] is the state of a node relative
//! to the fixed point itself; for numbers its rate is `drift + A z + B u`, the sum of both. The turn of a
//! rotation is seen from the body of the first motion, which turns itself: `ξ' = δω - ω × ξ`. So the matrix
//! of a spinning top is that of the whole motion, and its eigenvalues tell whether the spin is stable. The
//! turn `θ` from the fixed attitude has `θ' = ω + δω - ½ ω × θ` to first order: to predict it by
//! `drift + A z + B u`, add `½ ω̂` to the block of `A` that maps the turn to its own rate.
//!
//! # Units
//!
//! The units of the declaration: an entry of `A` is in units of its row's state per unit of its column's
//! state and, for the continuous motion, per second. A basis is orthonormal as a matrix of numbers, whatever
//! the units of the coordinates are.
//!
//! ```
//! use dsocs_core::prelude::*;
//! use dsocs_core::linear::OperatingPoint;
//!
//! /// A pendulum with a motor.
//! #[dsocs {
//!     coordinates(theta);
//!     lagrangian = dot(theta).powi(2) / 2 + gravity * theta.cos();
//!     external_forces = (torque);
//! }]
//! struct Pendulum { gravity: f64, torque: f64 }
//!
//! let upright = Start::second_order([std::f64::consts::PI], [0.0]);
//! let model = OperatingPoint::new(&Pendulum { gravity: 9.0, torque: 0.0 }, upright)
//!     .inputs(["torque"])
//!     .outputs(["theta"])
//!     .continuous()?;
//! assert_eq!(model.a, [[0.0, 1.0], [9.0, 0.0]]);
//! assert_eq!((model.b, model.c), (vec![vec![0.0], vec![1.0]], vec![vec![1.0, 0.0]]));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod chart;
mod continuous;
mod corner;
mod equilibrium;
mod error;
mod inputs_outputs;
mod model;
mod point;
mod slopes;
mod step;

pub use equilibrium::{Equilibria, Equilibrium, EquilibriumError, EquilibriumSearch, Stability};
pub use error::LinearizationError;
pub use model::{LinearModel, LinearTime, state_change};
pub use point::OperatingPoint;
