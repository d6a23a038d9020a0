//! Compositions of the step: orders 4, 6 and 8 at a fixed step.
//!
//! At a node with legs of unequal lengths the parabola through the three nodes has, at the middle one, a value `q`, a slope `v`
//! and a curvature `a`; where the equations depend on these alone ([`Symmetry::AnyLegs`]) they determine `a` from `(q, v)`, and the map
//! from node to node
//!
//! ```text
//! v_r = v + h/2 a(q, v),   q' = q + h v_r,   v' = v_r + h/2 a(q', v')
//! ```
//!
//! is symmetric in time for every `h` and of order 2. With equal legs it is the paper's step. A [`Composition`] makes a step of
//! several such with different, partly negative lengths. The generated code is that of the paper's step: seen from the leg that
//! arrives, the equations are those of equal legs of its length.
//!
//! # Where the parabola does not join the legs
//!
//! A mass matrix that varies, or an external force that is no linear function of the velocity, binds a node to more than its parabola. There the
//! legs are joined by the momenta ([`Symmetry::Momenta`]): half a kick by the constraint force of the continuous system at the node,
//!
//! ```text
//! p + h/2 Q = -D₁L_d(q, q') - f⁻_d,   p' = D₂L_d(q, q') + f⁺_d + h/2 Q'
//! ```
//!
//! and half a one at the next, where the constraints hold for position, velocity and acceleration. `L_d` and the external forces are those of the declared map, which
//! has to be symmetric in time, as `midpoint` and `trapezoid` are (for `paper` the trapezoid's are taken). Without constraints this is the discrete
//! flow of `L_d`, which is symplectic. It is evaluated on the tape: a leg of a double pendulum takes 5 to 10 µs, and 25 µs with a constraint, where the generated
//! step takes 0.1 to 0.2 µs. Who wants digits alone takes Taylor series.
//!
//! # What is kept
//!
//! Symmetry in time: a step back undoes a step to rounding. Constraints and forces hold at every node. `L_d` of the paper's
//! particle, which equal legs keep exactly, is not kept from leg to leg: `|v_r|² = |v|² + h² |a|²/4` depends on the leg's length. Where
//! the curvature is constant the energy at the nodes is kept exactly; where it varies it stays within an error of the
//! method's order, without a drift (`tests/tests/claims/composition.rs`).
//!
//! # Legs that go back in time
//!
//! No composition of order above 2 does without them. They must not be so long that the motion cannot be followed back: with a
//! damping `a = -k v` a leg of the length `γ h` has to have `|γ| h k < 2` (`γ` is 0.66, 0.71 and 0.61 for the orders 4, 6 and 8). Lyapunov
//! constraints are dampings: the paper's pendulum, whose switch has `k = 10` at its steepest, is composed with
//! `h ≤ 0.2` over its 2000 s, with clean orders, and refused with `h = 0.4`, which the step of order 2 takes. A leg without a solution, with
//! two close ones, beyond a singularity or with a solution that the motion does not lead to ends in a [`StageError`]. A switch that
//! is so steep that no node falls into it is not noticed; [`crate::taylor::GlobalError`] tells what it costs.

mod backward;
mod error;
mod flow;
mod inputs;
mod method;
mod momenta;
mod symmetry;

pub use error::{FailedStage, StageError, StageFailure};
pub use flow::ComposedFlow;
pub use method::Composition;
pub use symmetry::Symmetry;
