//! Compositions of the step: orders 4, 6 and 8 at a fixed step.
//!
//! Three consecutive nodes, with legs of unequal lengths, determine a parabola. At the middle node it has a value `q`, a slope `v` and a
//! second derivative `a`. If the equations of the step depend only on these ([`Symmetry::AnyLegs`](crate::Symmetry::AnyLegs)), they determine
//! `a` from `(q, v)`. Then the map from node to node
//!
//! ```text
//! v_r = v + h/2 a(q, v),   q' = q + h v_r,   v' = v_r + h/2 a(q', v')
//! ```
//!
//! is symmetric in time for every `h`, and of order 2. With equal legs it is the paper's step. A step of a [`Composition`] consists of several
//! such maps with different `h`, of which some are negative. The generated code of the paper's step is used for each of them: from the leg that
//! arrives at a node, the equations can be written as those of two equal legs.
//!
//! # Systems whose legs are joined by momenta
//!
//! If the mass matrix varies, or an external force is not a linear function of the velocity, the equations depend on more than the parabola.
//! Then the legs are joined by the momenta at the nodes ([`Symmetry::Momenta`](crate::Symmetry::Momenta)). There is half a kick by the
//! constraint force `Q` of the continuous system at the first node,
//!
//! ```text
//! p + h/2 Q = -D₁L_d(q, q') - f⁻_d,   p' = D₂L_d(q, q') + f⁺_d + h/2 Q'
//! ```
//!
//! and half a kick by `Q'` at the next node. There the constraints hold for position, velocity and acceleration. `L_d` and the external forces
//! are those of the declared map. It has to be symmetric in time, as `midpoint` and `trapezoid` are; for `paper` those of `trapezoid` are taken.
//! Without constraints this is the discrete flow of `L_d`, which is symplectic. It is evaluated on the tape, which is slow: a leg of a double
//! pendulum takes 2 µs, and 8 µs with a constraint. A generated step takes 0.15 to 0.2 µs (`cargo test --release -p dsocs-tests --test claims
//! composition_by_momenta::what_a_leg_costs -- --ignored --nocapture`). If you only want a small error, take Taylor
//! series.
//!
//! # Invariants
//!
//! Symmetry in time is kept: a step back undoes a step, to rounding. Constraints and the conditions on their forces hold at every node.
//!
//! The paper's particle shows what is not conserved. With equal legs its `L_d` is conserved exactly. With
//! unequal legs it is not: `|v_r|² = |v|² + h² |a|²/4` depends on the length of the leg. The energy at the
//! nodes is conserved exactly if the curvature is constant. If the curvature varies, the error of the energy
//! is of the method's order, without a drift (`tests/tests/claims/composition.rs`).
//!
//! # Legs that go back in time
//!
//! Every composition of order above 2 has legs of negative length. They must be short enough that the motion can be followed back: with a damping
//! `a = -k v`, a leg of the length `γ h` needs `|γ| h k < 2`. The `γ` of the longest such leg is 0.66, 0.71 and 0.61 for the orders 4, 6 and 8.
//! Lyapunov constraints act as dampings. An example is the paper's pendulum, whose switch has `k = 10` where it is steepest. With `h ≤ 0.2` its
//! 2000 s can be computed, and the orders are as expected. With `h = 0.4` the composition is refused, while the step of order 2 still works.
//!
//! A [`StageError`] ends the run if a leg has no solution, has two close solutions, lies beyond a singularity, or has only a solution that the
//! motion does not lead to. A step in which an acceleration jumps is counted ([`crate::Stepper::unresolved`]), since it leaves an error of order 1;
//! [`crate::taylor::GlobalError`] measures it.

mod any;
mod backward;
mod flow;
mod jumping;
mod momenta;
mod run;
mod stages;
mod unresolved;

pub use crate::error::stage::{FailedStage, StageError, StageFailure};
pub use crate::number::composition::Composition;
pub use any::AnyComposedFlow;
pub use flow::ComposedFlow;
