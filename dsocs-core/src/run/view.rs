//! A system as a run shows it.

use super::Node;
use crate::declaration::Declaration;
use crate::flow::multipliers;
use crate::system::{Point, Quantity, System};
use crate::taylor::Jet;

/// What a run shows of its system, independently of the system's type. Every [`System`] implements it.
pub trait View<const N: usize> {
    /// The coordinates; see [`System::COORDINATES`].
    fn coordinates(&self) -> [Quantity; N];

    /// The observed expressions; see [`System::OBSERVABLES`].
    fn observables(&self) -> &[Quantity];

    /// The observed expressions at a point, as many as there is room for.
    fn observed(&self, point: &Point<f64, N>, out: &mut [f64]);

    /// The same for Taylor series; `out` has room for all.
    fn observed_series(&self, point: &Point<Jet, N>, out: &mut [Jet]);

    /// The multipliers of a node's constraint force; see [`crate::multipliers`].
    fn multipliers_of(&self, node: &Node<N>) -> Vec<f64>;
}

impl<S: System<N>, const N: usize> View<N> for S {
    fn coordinates(&self) -> [Quantity; N] {
        S::COORDINATES
    }

    fn observables(&self) -> &[Quantity] {
        S::OBSERVABLES
    }

    fn observed(&self, point: &Point<f64, N>, out: &mut [f64]) {
        let count = S::OBSERVABLES.len();
        if out.len() >= count {
            self.observe(point, &mut out[..count]);
        } else {
            let mut all = vec![0.0; count];
            self.observe(point, &mut all);
            out.copy_from_slice(&all[..out.len()]);
        }
    }

    fn observed_series(&self, point: &Point<Jet, N>, out: &mut [Jet]) {
        Declaration::of(self).observe(point.any(), out);
    }

    fn multipliers_of(&self, node: &Node<N>) -> Vec<f64> {
        multipliers(self, node)
    }
}
