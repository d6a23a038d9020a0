//! The order in the step with which an expression vanishes.

use crate::graph::{Graph, Leaf, Node, NodeId};

use crate::hash::HashMap;

/// The power of an expression that is zero.
const OF_ZERO: i32 = i32::MAX;

/// The power of an increment; a second difference has twice as much.
const OF_INCREMENT: i32 = 1;

impl Graph {
    /// The least power of `h` in an expression of a step, on a smooth motion: 1 for an increment, 2 for a
    /// second difference. Terms that cancel are not seen, and functions are taken to be of power 0. `None`
    /// where the expression is zero.
    pub(crate) fn power_of_step(&mut self, id: NodeId) -> Option<i32> {
        let mut known = std::mem::take(&mut self.powers);
        let power = self.power(id, &mut known);
        self.powers = known;
        (power != OF_ZERO).then_some(power)
    }

    /// The power of [`Graph::power_of_step`], by the powers found so far; [`OF_ZERO`] for zero.
    fn power(&self, id: NodeId, known: &mut HashMap<NodeId, i32>) -> i32 {
        if let Some(&power) = known.get(&id) {
            return power;
        }
        let of_constant = |value: f64| if value == 0.0 { OF_ZERO } else { 0 };
        let power = match self.node(id) {
            Node::Constant(value) => of_constant(value.get()),
            Node::Leaf(Leaf::H | Leaf::D(_)) => OF_INCREMENT,
            Node::Leaf(Leaf::P(_) | Leaf::E(_)) => 2 * OF_INCREMENT,
            Node::Sum(constant, terms) => {
                let terms = terms.iter().map(|&(term, _)| self.power(term, known));
                terms.fold(of_constant(constant.get()), i32::min)
            }
            Node::Product(factors) => factors.iter().fold(0_i32, |sum, &(factor, exponent)| {
                let power = self.power(factor, known);
                sum.saturating_add(power.saturating_mul(exponent))
            }),
            _ => 0,
        };
        known.insert(id, power);
        power
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_are_powers_of_the_step() {
        let mut graph = Graph::new();
        let [h, d, e, q] = [Leaf::H, Leaf::D(0), Leaf::E(0), Leaf::N(0)].map(|leaf| graph.leaf(leaf));
        let zero = graph.constant(0.0);
        let velocity = graph.div(d, h);
        let acceleration = graph.mul(e, velocity);
        let sine = graph.unary(crate::graph::Unary::Sin, q);
        let force = graph.mul(h, sine);
        let sum = graph.add(force, velocity);
        let powers = [h, d, e, q, zero, velocity, acceleration, force, sum].map(|id| graph.power_of_step(id));
        let expected = [
            Some(1),
            Some(1),
            Some(2),
            Some(0),
            None,
            Some(0),
            Some(2),
            Some(1),
            Some(0),
        ];
        assert_eq!(powers, expected);
    }
}
