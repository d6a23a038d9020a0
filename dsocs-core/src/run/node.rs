//! Nodes, the result of a run.

use crate::kernel::report::{NodeMut, NodeScalars};
use crate::number::point::Point;
use crate::number::point::{AnyPoint, sized};
use crate::regularity::multipliers;
use crate::solve::newton::Stop;
use crate::tape::declaration::Declaration;

/// A node of a motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node<const N: usize> {
    /// The number of the node; 0 is the start, or the node at which [`crate::Stepper::reverse`] reversed the
    /// run.
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
    /// Number of evaluations of the step's rows and their Jacobian, in all stages together; 0 at the start.
    /// In a [`crate::TaylorFlow`], number of expansions of the motion.
    pub iterations: u32,
    /// The stop rule that ended Newton's iteration of the step; [`Stop::Start`] at the start and in Taylor
    /// series, where no iteration is needed.
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

    /// The node that `write` writes; NaN where it writes nothing.
    #[inline]
    pub(crate) fn written_by(write: impl FnOnce(NodeMut<'_>)) -> Self {
        let (mut vectors, mut scalars) = ([[f64::NAN; N]; 4], NodeScalars::UNKNOWN);
        write(NodeMut {
            vectors: vectors.as_flattened_mut(),
            scalars: &mut scalars,
        });
        let [q, v, a, force] = vectors;
        let NodeScalars {
            index,
            t,
            energy,
            iterations,
            stop,
        } = scalars;
        Self {
            index,
            t,
            q,
            v,
            a,
            force,
            energy,
            iterations,
            stop,
        }
    }

    /// The node for any number of coordinates.
    #[must_use]
    pub fn any(&self) -> AnyNode<'_> {
        AnyNode {
            index: self.index,
            t: self.t,
            q: &self.q,
            v: &self.v,
            a: &self.a,
            force: &self.force,
            energy: self.energy,
            iterations: self.iterations,
            stop: self.stop,
        }
    }
}

/// A [`Node`] with any number of coordinates, by reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AnyNode<'a> {
    /// The number of the node.
    pub index: u64,
    /// Time.
    pub t: f64,
    /// Position.
    pub q: &'a [f64],
    /// Velocity.
    pub v: &'a [f64],
    /// Acceleration.
    pub a: &'a [f64],
    /// The generalized constraint force, in units of `L` per unit of the coordinate.
    pub force: &'a [f64],
    /// The energy.
    pub energy: f64,
    /// Number of evaluations of the step's rows and their Jacobian; 0 at the start.
    pub iterations: u32,
    /// The stop rule that ended Newton's iteration of the step.
    pub stop: Stop,
}

impl<'a> AnyNode<'a> {
    /// Position, velocity and acceleration.
    #[must_use]
    pub fn point(&self) -> AnyPoint<'a, f64> {
        AnyPoint {
            t: self.t,
            q: self.q,
            v: self.v,
            a: self.a,
        }
    }

    /// The node with its number of coordinates; missing numbers are NaN.
    #[must_use]
    pub fn sized<const N: usize>(&self) -> Node<N> {
        Node {
            index: self.index,
            t: self.t,
            q: sized(self.q),
            v: sized(self.v),
            a: sized(self.a),
            force: sized(self.force),
            energy: self.energy,
            iterations: self.iterations,
            stop: self.stop,
        }
    }
}

impl Declaration<'_> {
    /// The multipliers of a node's constraint force, one for each constraint, by the forms of its constraints. Where a body rests at a jump
    /// of a form, as with friction in proportion to the constraint force, the form is that with the friction that holds it.
    #[must_use]
    pub fn multipliers(&self, node: &AnyNode<'_>) -> Vec<f64> {
        if self.shape().forms == 0 {
            return Vec::new();
        }
        multipliers::of_node(self, node.point(), node.force)
    }
}

impl NodeMut<'_> {
    /// Writes a node, as much of it as there is room for.
    #[inline]
    pub fn write(self, node: &AnyNode<'_>) {
        let NodeMut { vectors, scalars } = self;
        let numbers = [node.q, node.v, node.a, node.force].into_iter().flatten();
        for (room, x) in vectors.iter_mut().zip(numbers) {
            *room = *x;
        }
        *scalars = NodeScalars {
            index: node.index,
            t: node.t,
            energy: node.energy,
            iterations: node.iterations,
            stop: node.stop,
        };
    }
}

/// A [`Node`] with any number of coordinates that owns its numbers. It is made once and filled again at every node.
#[derive(Clone, Debug, PartialEq)]
pub struct OwnedNode {
    /// The number of coordinates.
    pub(super) coordinates: usize,
    /// Position, velocity, acceleration and force.
    vectors: Vec<f64>,
    /// The other data.
    scalars: NodeScalars,
}

impl OwnedNode {
    /// A node of `coordinates` coordinates with all numbers NaN.
    #[must_use]
    pub fn new(coordinates: usize) -> Self {
        Self {
            coordinates,
            vectors: vec![f64::NAN; 4 * coordinates],
            scalars: NodeScalars::UNKNOWN,
        }
    }

    /// A copy of a node.
    #[must_use]
    pub fn of(node: &AnyNode<'_>) -> Self {
        let mut owned = Self::new(node.q.len());
        owned.as_node_mut().write(node);
        owned
    }

    /// The place into which a run writes its current node.
    #[inline]
    pub fn as_node_mut(&mut self) -> NodeMut<'_> {
        NodeMut {
            vectors: &mut self.vectors,
            scalars: &mut self.scalars,
        }
    }

    /// Position, velocity and acceleration, one after the other.
    pub(crate) fn point(&self) -> &[f64] {
        &self.vectors[..3 * self.coordinates]
    }

    /// A reference to the node.
    #[inline]
    #[must_use]
    pub fn any(&self) -> AnyNode<'_> {
        let (q, rest) = self.vectors.split_at(self.coordinates);
        let (v, rest) = rest.split_at(self.coordinates);
        let (a, force) = rest.split_at(self.coordinates);
        let NodeScalars {
            index,
            t,
            energy,
            iterations,
            stop,
        } = self.scalars;
        AnyNode {
            index,
            t,
            q,
            v,
            a,
            force,
            energy,
            iterations,
            stop,
        }
    }
}
