//! The nodes of a run, collected.

use super::error::RunError;
use super::{AnyPolynomial, Node, Polynomial};
use crate::number::point::Point;
use crate::series::rows::Series;

use thiserror::Error;

/// A motion, node by node. Two are equal if their nodes are.
#[derive(Clone, Debug, Default)]
pub struct Trajectory<const N: usize> {
    /// The nodes, in the order of the run.
    pub nodes: Vec<Node<N>>,
    /// The first of the four places of each coordinate that is a rotation.
    pub(crate) rotations: Vec<usize>,
    /// See [`super::Run::has_differences`].
    pub(crate) differences: bool,
}

impl<const N: usize> PartialEq for Trajectory<N> {
    fn eq(&self, other: &Self) -> bool {
        self.nodes == other.nodes
    }
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

    /// Position, velocity and acceleration at a time between the first and the last node, by the polynomial between the two neighbouring
    /// nodes. `None` outside. [`Polynomial::between`] gives the error. The trajectory should come from
    /// [`Stepper::until`](crate::Stepper::until): one that was collected otherwise does not know which components are a quaternion, and whether
    /// velocities are differences.
    #[must_use]
    pub fn at(&self, t: f64) -> Option<Point<f64, N>> {
        let (first, last) = (self.nodes.first()?, self.nodes.last()?);
        let forward = last.t >= first.t;
        let before = |node: &Node<N>| if forward { node.t <= t } else { node.t >= t };
        // the first node beyond the time, or the last one if the time is its own
        let beyond = self.nodes.partition_point(before);
        let (left, right) = match (beyond.checked_sub(1), self.nodes.get(beyond)) {
            (Some(left), Some(right)) => (&self.nodes[left], right),
            (Some(_), None) if before(last) && last.t.to_bits() == t.to_bits() => return Some(last.point()),
            _ => return None,
        };
        let mut series = Series::new(N, AnyPolynomial::ORDER);
        let nodes = [left, right];
        Some(Polynomial::through(&self.rotations, self.differences, nodes, &mut series).at(t))
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

/// A run that failed, with everything that it had computed.
#[derive(Clone, PartialEq, Error)]
#[error("{error}")]
pub struct Failure<const N: usize> {
    /// The cause.
    #[source]
    pub error: RunError,
    /// The nodes before the failure.
    pub trajectory: Trajectory<N>,
}

crate::debug_is_message!(Failure<N>);
