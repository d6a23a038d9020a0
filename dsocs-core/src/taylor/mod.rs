//! The continuous motion to any tolerance, by Taylor series.
//!
//! `#[dsocs]` generates, beside the step, the recurrences for the Taylor coefficients of the motion of the *continuous*
//! system. A [`TaylorFlow`] makes steps with them: it expands the motion, goes as far as its [`Tolerance`] allows, and
//! expands again. Each step is a [`crate::Polynomial`], which gives the motion during the step.
//!
//! ```
//! use dsocs_core::prelude::*;
//!
//! /// A pendulum.
//! #[dsocs {
//!     coordinates(theta);
//!     lagrangian = dot(theta).powi(2) / 2 + gravity / length * theta.cos();
//! }]
//! struct Pendulum {
//!     length: f64,
//!     gravity: f64,
//! }
//!
//! let pendulum = Pendulum { length: 1.0, gravity: 9.81 };
//! let start = Start::second_order([1.0], [0.0]);
//! let mut flow = TaylorFlow::new(&pendulum, start, Tolerance::relative(1e-14))?;
//!
//! // a quarter of its period: where it hangs straight down
//! let mut events = Events::new(vec![Event::function(|point| point.q[0]).terminal()]);
//! let quarter = flow.watch(10.0, &mut events, &mut |_: &Node<1>| {})?.map(|event| event.t);
//! assert!((quarter.unwrap_or(0.0) - 0.534_784_400_139_672).abs() < 1e-12);
//!
//! // and its motion from the start, every tenth of a second
//! let trajectory = TaylorFlow::new(&pendulum, start, Tolerance::relative(1e-14))?.every(0.1)?.until(0.8)?;
//! assert_eq!(trajectory.len(), 9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # How it works
//!
//! 1. When the code is generated, the rows of the continuous system are solved for the accelerations, as far as that
//!    is worthwhile: rows that are linear in an acceleration with coefficients that depend on the parameters alone, and one or two rows by
//!    Cramer's rule. A declared factor (`branch = divide(w)`) is divided out of its row as a polynomial. The other rows remain equations:
//!    in each expansion one matrix is inverted, and each order needs one product with the inverse.
//! 2. Each product and function of the accelerations has a recurrence; products with parameters need none. The inner sums of
//!    all recurrences are computed together, four in a register, with fused multiply-add instructions if the machine has them. Products of
//!    positions and velocities, whose factors are known before anything of an order is computed, stay side by side to the end.
//! 3. The tolerance determines the order, and the last two coefficients determine the step (Jorba and Zou 2005). At the end of a step
//!    the acceleration of the series has to be that of the system; otherwise the step is halved.
//! 4. Position, velocity and time are compensated sums.
//!
//! Your own Rust functions are called with [`Jet`]s, once for each order. This is slower than generated code. The functions have to be
//! generic over their number type ([`crate::Real`]), even if the discrete step never differentiates them, and they have to do the same
//! in each call.
//!
//! # Limits
//!
//! *Jumps and corners.* A function with a jump or a corner (`if`, `abs`, `signum`, `min`) consists of pieces,
//! and a series is valid in one piece. The sign of an argument, such as that of `abs`, selects the piece. So
//! a step ends where such an argument changes its sign. This place is located to rounding. The next series
//! belongs to the next piece. If the motion is led back to this place from both sides, as by dry friction at
//! rest, no piece continues it. If functions jump with the velocity, the motion then rests there, and goes on
//! by polynomials that satisfy the equations at several places of a step, until it is released. Otherwise the
//! run ends with [`SeriesFailure::Sticks`]. If the velocity would have to jump, as that of a bead at the
//! corner of a wire, it ends with [`SeriesFailure::Jumps`]. Corners of roots, as of `√(u²)`, and jumps and
//! corners of inverse trigonometric functions, as of `asin(sin u)` and `atan2`, are found by the functions'
//! own series, which lead beyond their ranges; the first step beyond takes the series of its end. Branches on
//! the values of numbers ([`crate::Real::re`]) are not found. There the steps become short.
//!
//! *Constraints on positions and velocities* are differentiated until accelerations appear. After each step, position and velocity are
//! projected onto these constraints by the smallest change. So the nodes obey them to rounding, and the motion between the nodes obeys them to
//! within the tolerance.
//!
//! *Rounding.* High orders make long steps, in which large terms of opposite signs cancel. If the last two
//! digits matter, set a lower [`Tolerance::order`]. A body that comes to rest moves in the end by less than a
//! rounding of its position: there the velocity is as accurate as the forces at the rounded position are, and
//! not to the tolerance.

// code under `dispatch` has to be inlined there to be compiled for the machine's own instructions
#![allow(clippy::inline_always)]
// times are reached exactly, and zeros are exact
#![allow(clippy::float_cmp)]
// recurrences are indexed by order, several at a time, as in textbooks
#![allow(clippy::needless_range_loop)]

mod block;
mod control;
mod corner;
mod ensemble;
mod estimate;
mod failed;
mod flow;
mod grid;
mod held_path;
mod inputs;
mod integrator;
mod interpreted;
mod jumps;
mod knots;
mod lanes;
mod length;
mod motion;
mod moved;
mod node;
mod order;
mod pieces;
mod projection;
mod quotient;
mod recurrences;
mod rounding;
mod singular;
pub(crate) mod solve;
mod start;
mod state;
mod sticking;
mod tangents;
mod trial;
mod watch;
mod weights;

pub use crate::error::series::{FailedSeries, Jump, SeriesError, SeriesFailure};
pub use crate::series::jet::Jet;
pub use crate::series::orders::MAX_ORDER;
#[doc(hidden)]
pub use crate::series::rows::Rows;
pub use crate::series::rows::Series;
pub use control::Tolerance;
pub use ensemble::TaylorEnsemble;
pub use estimate::Estimates;
pub use flow::{AnyTaylorFlow, TaylorFlow};
#[doc(hidden)]
pub use motion::rounding;
pub use motion::{AnyGlobalError, GlobalError, Motion};
pub use tangents::TaylorTangents;
