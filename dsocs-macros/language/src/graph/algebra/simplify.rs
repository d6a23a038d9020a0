//! Fewer products: common factors of sums, and squares of roots.
//!
//! In a Taylor series a product of two sequences is a convolution; a sum is cheap beside it. So factors that
//! all terms of a sum share are taken out, and an even power of a root becomes a power of its radicand:
//! `|v|³/|v|²` is `|v|`.

use crate::graph::{Graph, Memory, Node, NodeId, Pass, Unary};
use crate::hash::HashMap;

/// Takes common factors out of sums, and simplifies even powers of square roots.
#[derive(Default)]
pub(crate) struct Simplify {
    memory: Memory,
}

impl Pass for Simplify {
    const FINAL: bool = true;

    fn memory(&mut self) -> &mut Memory {
        &mut self.memory
    }

    fn after(&mut self, graph: &mut Graph, id: NodeId) -> NodeId {
        match graph.node(id).clone() {
            Node::Sum(constant, terms) if terms.len() > 1 && constant.get() == 0.0 => {
                let terms: Vec<_> = terms.iter().map(|&(term, c)| (term, c.get())).collect();
                factored(graph, &terms).unwrap_or(id)
            }
            Node::Sum(constant, terms) => {
                let terms: Vec<_> = terms
                    .iter()
                    .map(|&(term, c)| (with_radicands(graph, term), c.get()))
                    .collect();
                graph.linear(constant.get(), &terms)
            }
            _ => with_radicands(graph, id),
        }
    }
}

/// The factors of a term, with exponents.
fn factors(graph: &Graph, term: NodeId) -> Vec<(NodeId, i32)> {
    match graph.node(term) {
        Node::Product(factors) => factors.clone(),
        _ => vec![(term, 1)],
    }
}

/// A sum as a product with the factors that its terms share; anything else as it is.
pub(crate) fn factored_sum(graph: &mut Graph, id: NodeId) -> NodeId {
    match graph.terms(id) {
        (terms, constant) if terms.len() > 1 && constant == 0.0 => factored(graph, &terms).unwrap_or(id),
        _ => id,
    }
}

/// The sum as a product with the factors that its terms share; `None` if they share none.
fn factored(graph: &mut Graph, terms: &[(NodeId, f64)]) -> Option<NodeId> {
    let mut common = factors(graph, terms[0].0);
    for &(term, _) in &terms[1..] {
        let present: HashMap<NodeId, i32> = factors(graph, term).into_iter().collect();
        common.retain_mut(|(factor, exponent)| match present.get(factor) {
            Some(&other) if other.signum() == exponent.signum() => {
                *exponent = exponent.signum() * exponent.abs().min(other.abs());
                true
            }
            _ => false,
        });
    }
    if common.is_empty() {
        return None;
    }
    let inverse: Vec<_> = common.iter().map(|&(factor, n)| (factor, -n)).collect();
    let rest: Vec<_> = terms
        .iter()
        .map(|&(term, c)| {
            let factors = [[(term, 1)].as_slice(), &inverse].concat();
            (graph.product(&factors), c)
        })
        .collect();
    let rest = graph.linear(0.0, &rest);
    let product = [common.as_slice(), &[(rest, 1)]].concat();
    let product = graph.product(&product);
    Some(with_radicands(graph, product))
}

/// A product in which even powers of square roots are powers of their radicands.
fn with_radicands(graph: &mut Graph, id: NodeId) -> NodeId {
    let (scale, inner) = match graph.node(id).clone() {
        Node::Sum(constant, terms) if constant.get() == 0.0 && terms.len() == 1 => {
            (terms[0].1.get(), terms[0].0)
        }
        _ => (1.0, id),
    };
    let Node::Product(all) = graph.node(inner).clone() else {
        return id;
    };
    let mut changed = false;
    let mut result = Vec::new();
    for (factor, n) in all {
        match *graph.node(factor) {
            Node::Unary(Unary::Sqrt, radicand) if n.abs() > 1 => {
                changed = true;
                result.push((radicand, n / 2));
                result.push((factor, n % 2));
            }
            _ => result.push((factor, n)),
        }
    }
    // x / sqrt(x) is the root itself
    let powers: HashMap<NodeId, i32> = result.iter().copied().collect();
    for entry in 0..result.len() {
        let (factor, n) = result[entry];
        if let Node::Unary(Unary::Sqrt, radicand) = *graph.node(factor)
            && n == -1
            && powers.get(&radicand).is_some_and(|&m| m > 0)
        {
            changed = true;
            result[entry].1 = 1;
            result.push((radicand, -1));
        }
    }
    if !changed {
        return id;
    }
    let product = graph.product(&result);
    let product = graph.scale(scale, product);
    with_radicands(graph, product)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::Leaf;

    #[test]
    fn powers_of_a_root_cancel() {
        let mut graph = Graph::new();
        let (x, y) = (graph.leaf(Leaf::V(0)), graph.leaf(Leaf::V(1)));
        let squares = [graph.powi(x, 2), graph.powi(y, 2)];
        let square = graph.sum(&squares);
        let root = graph.unary(Unary::Sqrt, square);
        // x / (x² / r³ + y² / r³)
        let parts = squares.map(|part| graph.product(&[(part, 1), (root, -3)]));
        let sum = graph.sum(&parts);
        let quotient = graph.div(x, sum);
        let expected = graph.mul(x, root);
        assert_eq!(graph.rewrite(quotient, &mut Simplify::default()), expected);
    }

    #[test]
    fn shared_factors_are_taken_out() {
        let mut graph = Graph::new();
        let (x, y, z) = (
            graph.leaf(Leaf::V(0)),
            graph.leaf(Leaf::V(1)),
            graph.leaf(Leaf::Q(0)),
        );
        let (left, right) = (graph.mul(x, y), graph.mul(x, z));
        let sum = graph.linear(0.0, &[(left, 2.0), (right, -3.0)]);
        let inner = graph.linear(0.0, &[(y, 2.0), (z, -3.0)]);
        let expected = graph.mul(x, inner);
        assert_eq!(graph.rewrite(sum, &mut Simplify::default()), expected);
    }
}
