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
//! several such with different, partly negative lengths.

mod backward;
mod error;
mod flow;
mod method;
mod symmetry;

pub use error::{FailedStage, StageError, StageFailure};
pub use flow::ComposedFlow;
pub use method::Composition;
pub use symmetry::Symmetry;
