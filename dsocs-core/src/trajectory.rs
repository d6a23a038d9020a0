//! Nodes, and what becomes of them: collected in a trajectory or handed to an observer.

use core::ops::ControlFlow;

use thiserror::Error;

use crate::error::RunError;
use crate::step::newton::Stop;
use crate::system::Point;

/// A node of the discrete motion, with what is known there once the next node is solved for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node<const N: usize> {
    /// The number of the node; 0 is the start, or the node where [`crate::Flow::reverse`] turned round.
    pub index: u64,
    /// Time.
    pub t: f64,
    /// Position.
    pub q: [f64; N],
    /// Velocity at `φ_D⁻¹`, by default the central difference. At the start, the initial velocity.
    pub v: [f64; N],
    /// Acceleration at `φ_D⁻¹`, by default the second difference over `h²`. At the start, the continuous
    /// system's, or NaN where it has none.
    pub a: [f64; N],
    /// The generalized constraint force `Q = −(D₁L_d(q1,q2) + D₂L_d(q0,q1))`, in units of `L` per unit of the
    /// coordinate. At the start, the continuous system's.
    pub force: [f64; N],
    /// The energy `⟨∂L/∂v, v⟩ − L` at the position and velocity given here.
    pub energy: f64,
    /// How often the rows of the step and their Jacobian were evaluated; 0 at the start.
    pub iterations: u32,
    /// How the solution of the step ended.
    pub stop: Stop,
}

impl<const N: usize> Node<N> {
    /// Position, velocity and acceleration, as [`crate::System::observe`] takes them.
    #[must_use]
    pub fn point(&self) -> Point<f64, N> {
        Point {
            q: self.q,
            v: self.v,
            a: self.a,
        }
    }
}

/// A discrete motion, node by node.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trajectory<const N: usize> {
    /// The nodes, in the order of the run.
    pub nodes: Vec<Node<N>>,
}

impl<const N: usize> Trajectory<N> {
    /// The number of nodes.
    #[must_use]
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Whether there are no nodes.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// The last node.
    #[must_use]
    pub fn last(&self) -> Option<&Node<N>> {
        self.nodes.last()
    }

    /// The nodes, by reference.
    pub fn iter(&self) -> core::slice::Iter<'_, Node<N>> {
        self.nodes.iter()
    }
}

impl<const N: usize> IntoIterator for Trajectory<N> {
    type Item = Node<N>;
    type IntoIter = std::vec::IntoIter<Node<N>>;

    fn into_iter(self) -> Self::IntoIter {
        self.nodes.into_iter()
    }
}

impl<'a, const N: usize> IntoIterator for &'a Trajectory<N> {
    type Item = &'a Node<N>;
    type IntoIter = core::slice::Iter<'a, Node<N>>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

/// A run that ended early, with all that it had computed.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{error}")]
pub struct Failure<const N: usize> {
    /// Why it ended.
    #[source]
    pub error: RunError,
    /// The nodes before the failure.
    pub trajectory: Trajectory<N>,
}

/// Receives the nodes of a run one by one, in bounded memory.
///
/// Every `FnMut(&Node<N>)` is an observer. To end a run early, use [`until_break`], or implement the trait.
pub trait Observer<const N: usize> {
    /// Takes a node; [`ControlFlow::Break`] ends the run after it.
    fn node(&mut self, node: &Node<N>) -> ControlFlow<()>;
}

impl<F: FnMut(&Node<N>), const N: usize> Observer<N> for F {
    fn node(&mut self, node: &Node<N>) -> ControlFlow<()> {
        self(node);
        ControlFlow::Continue(())
    }
}

impl<const N: usize> Observer<N> for Trajectory<N> {
    fn node(&mut self, node: &Node<N>) -> ControlFlow<()> {
        self.nodes.push(*node);
        ControlFlow::Continue(())
    }
}

/// An observer made of a closure that says whether to go on.
///
/// ```
/// use std::ops::ControlFlow;
/// use dsocs_core::{Node, until_break};
///
/// let mut falling = until_break(|node: &Node<1>| {
///     if node.q[0] < 0.0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
/// });
/// # let _: &mut dyn dsocs_core::Observer<1> = &mut falling;
/// ```
pub fn until_break<const N: usize, F>(closure: F) -> UntilBreak<F>
where
    F: FnMut(&Node<N>) -> ControlFlow<()>,
{
    UntilBreak(closure)
}

/// The observer that [`until_break`] makes.
#[derive(Clone, Copy, Debug)]
pub struct UntilBreak<F>(F);

impl<F: FnMut(&Node<N>) -> ControlFlow<()>, const N: usize> Observer<N> for UntilBreak<F> {
    fn node(&mut self, node: &Node<N>) -> ControlFlow<()> {
        (self.0)(node)
    }
}
