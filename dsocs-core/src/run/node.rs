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
    /// Velocity. In a [`crate::Flow`] it is that of `φ_D⁻¹`, by default the central difference; at the start it is the initial velocity.
    pub v: [f64; N],
    /// Acceleration. In a [`crate::Flow`] it is that of `φ_D⁻¹`, by default the second difference over `h²`. At the start it is that of
    /// the continuous system, or NaN if there is none.
    pub a: [f64; N],
    /// The generalized constraint force, in units of `L` per unit of the coordinate. In a [`crate::Flow`] it is
    /// `Q = −(D₁L_d(q1,q2) + D₂L_d(q0,q1))`. At the start, and with other methods, it is that of the continuous system.
    pub force: [f64; N],
    /// The energy `⟨∂L/∂v, v⟩ − L` at the position and velocity given here.
    pub energy: f64,
    /// How often the rows of the step and their Jacobian were evaluated, in all stages together; 0 at the start. In a
    /// [`crate::TaylorFlow`], how often the motion was expanded.
    pub iterations: u32,
    /// How Newton's iteration of the step ended; [`Stop::Start`] if nothing was solved, at the start and in Taylor series.
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
