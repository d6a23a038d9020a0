//! Polynomials in the components of quaternions, with few products.
//!
//! A vector turned into the frame of a body, and gravity there, are quadratic forms in the components of a
//! quaternion. As written, each component has products of its own. Multiplied out, all components share a few
//! products, and `q² = 1` spares one square more. No digits are lost, because the components, and so the
//! products, are at most 1.

use std::rc::Rc;

use crate::graph::algebra::Expansion;
use crate::graph::algebra::polynomial::{self, Polynomial};
use crate::graph::{Graph, Leaf, Memory, Node, NodeId, Pass};

/// The pass that rewrites expressions of attitudes alone.
#[derive(Default)]
pub(super) struct Attitudes {
    expansion: Expansion,
    memory: Memory,
}

impl Pass for Attitudes {
    fn memory(&mut self) -> &mut Memory {
        &mut self.memory
    }

    fn before(&mut self, graph: &mut Graph, id: NodeId) -> Option<NodeId> {
        if !matches!(graph.node(id), Node::Sum(..) | Node::Product(_)) {
            return None;
        }
        if is_of_attitudes(graph, id) {
            return self.multiplied_out(graph, id);
        }
        let Node::Sum(constant, terms) = graph.node(id).clone() else {
            return None;
        };
        let terms = terms.into_iter().map(|(term, c)| (term, c.get()));
        let (forms, rest): (Vec<_>, Vec<_>) = terms.partition(|&(term, _)| is_of_attitudes(graph, term));
        if forms.len() < 2 {
            return None;
        }
        let form = graph.linear(0.0, &forms);
        let form = self.multiplied_out(graph, form)?;
        let mut terms = vec![(form, 1.0)];
        for (term, c) in rest {
            terms.push((graph.rewrite(term, self), c));
        }
        Some(graph.linear(constant.get(), &terms))
    }
}

impl Attitudes {
    /// The expression as a sum of products; `None` if they are too many.
    fn multiplied_out(&mut self, graph: &mut Graph, id: NodeId) -> Option<NodeId> {
        let mut known = self.expansion.polynomial(graph, id)?;
        for first in graph.rotations().to_vec() {
            known = of_norm_one(graph, known, first)?;
        }
        let terms = known.iter().map(|(monomial, &coefficient)| {
            let product = graph.product(monomial);
            (graph.mul(coefficient, product), 1.0)
        });
        let terms: Vec<_> = terms.collect();
        Some(graph.linear(0.0, &terms))
    }
}

/// Whether an expression depends on attitudes and on no other leaf.
fn is_of_attitudes(graph: &Graph, id: NodeId) -> bool {
    let mut leaves = graph.leaves(id).peekable();
    leaves.peek().is_some()
        && leaves.all(|leaf| matches!(leaf, Leaf::Q(place) if graph.rotation_at(place).is_some()))
}

/// A polynomial with the squares of a quaternion's scalar replaced, `w² = 1 - x² - y² - z²`; `None` if it has
/// too many terms.
fn of_norm_one(graph: &mut Graph, known: Rc<Polynomial>, first: usize) -> Option<Rc<Polynomial>> {
    let scalar = graph.leaf(Leaf::Q(first));
    let has_square = |polynomial: &Polynomial| {
        let mut factors = polynomial.keys().flatten();
        factors.any(|&(factor, exponent)| factor == scalar && exponent > 1)
    };
    let mut known = known;
    if !has_square(&known) {
        return Some(known);
    }
    let one = graph.constant(1.0);
    let minus_one = graph.constant(-1.0);
    let mut square = Polynomial::from([(Vec::new(), one)]);
    for k in 1..4 {
        let component = graph.leaf(Leaf::Q(first + k));
        square.insert(vec![(component, 2)], minus_one);
    }
    while has_square(&known) {
        let mut sum = Polynomial::new();
        for (monomial, &coefficient) in &*known {
            let place = monomial
                .iter()
                .position(|&(factor, exponent)| factor == scalar && exponent > 1);
            let Some(place) = place else {
                polynomial::add(graph, &mut sum, monomial, coefficient);
                continue;
            };
            let mut rest = monomial.clone();
            rest[place].1 -= 2;
            rest.retain(|&(_, exponent)| exponent != 0);
            let rest = polynomial::single(rest, coefficient);
            for (monomial, coefficient) in polynomial::multiply(graph, &rest, &square)? {
                polynomial::add(graph, &mut sum, &monomial, coefficient);
            }
        }
        known = Rc::new(sum);
    }
    Some(known)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The vertical unit vector in the frame of the body, with terms that use no `q² = 1`.
    fn upright(graph: &mut Graph) -> [NodeId; 3] {
        let q = [0, 1, 2, 3].map(|k| graph.leaf(Leaf::Q(k)));
        let (zero, one) = (graph.constant(0.0), graph.constant(1.0));
        let back = graph.inverse(q);
        graph.rotated(back, [zero, zero, one])
    }

    #[test]
    fn components_of_a_turned_vector_share_their_products() {
        let mut graph = Graph::new();
        graph.set_rotations(vec![0]);
        let [x, y, z] = upright(&mut graph);
        // terms with w² may occur: the square is replaced by those of the other components
        let w = graph.leaf(Leaf::Q(0));
        let with_square = graph.powi(w, 2);
        let mut all = [x, y, z, with_square];
        graph.rewrite_all(&mut all, &mut Attitudes::default());
        let mut products: Vec<NodeId> = Vec::new();
        for &form in &all {
            for (term, _) in graph.terms(form).0 {
                if !products.contains(&term) {
                    products.push(term);
                }
            }
        }
        // the products bd, ac, ab, cd, b², c², d²
        assert_eq!(products.len(), 7);
        assert!(!products.contains(&with_square));
    }

    #[test]
    fn what_is_made_of_more_than_attitudes_stays() {
        let mut graph = Graph::new();
        graph.set_rotations(vec![0]);
        let [a, b] = [0, 1].map(|k| graph.leaf(Leaf::Q(k)));
        let x = graph.leaf(Leaf::Q(4));
        let sum = graph.add(a, x);
        let square = graph.powi(sum, 2);
        let whole = graph.mul(b, square);
        assert_eq!(graph.rewrite(whole, &mut Attitudes::default()), whole);
    }
}
