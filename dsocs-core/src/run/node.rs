//! A node: what a run hands out.

use crate::step::newton::Stop;
use crate::system::Point;

/// A node of a motion: what every method hands out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node<const N: usize> {
    /// The number of the node; 0 is the start, or the node where [`crate::Stepper::reverse`] turned round.
    pub index: u64,
    /// Time.
    pub t: f64,
    /// Position.
    pub q: [f64; N],
    /// Velocity. Of a [`crate::Flow`], that of `φ_D⁻¹`, by default the central difference; at the start, the initial velocity.
    pub v: [f64; N],
    /// Acceleration. Of a [`crate::Flow`], that of `φ_D⁻¹`, by default the second difference over `h²`; at the start, the
    /// continuous system's, or NaN where it has none.
    pub a: [f64; N],
    /// The generalized constraint force, in units of `L` per unit of the coordinate: of a [`crate::Flow`]
    /// `Q = −(D₁L_d(q1,q2) + D₂L_d(q0,q1))`; at the start and of other methods, the continuous system's.
    pub force: [f64; N],
    /// The energy `⟨∂L/∂v, v⟩ − L` at the position and velocity given here.
    pub energy: f64,
    /// How often the rows of the step and their Jacobian were evaluated, for all stages; 0 at the start. Of a
    /// [`crate::TaylorFlow`], how often the motion was expanded.
    pub iterations: u32,
    /// How the solution of the step ended; [`Stop::Start`] where nothing was solved, at the start and by Taylor series.
    pub stop: Stop,
}

impl<const N: usize> Node<N> {
    /// Position, velocity and acceleration, as [`crate::System::observe`] takes them.
    #[must_use]
    pub fn point(&self) -> Point<f64, N> {
        Point {
            t: self.t,
            q: self.q,
            v: self.v,
            a: self.a,
        }
    }
}
