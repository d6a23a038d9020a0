//! Dividing a declared factor out of a row.
//!
//! A Lyapunov constraint `dV/dt + F` has, where the variational equations hold, a factor `w` that the unknowns enter
//! linearly (see `branch = divide(w)`). Evaluated as a quotient of numbers it is noise near `w = 0`; as a quotient of
//! polynomials it has no singularity there, costs less, and rounds like a formula derived by hand.

use std::collections::HashMap;

use crate::graph::{Graph, Leaf, Node, NodeId};

/// Rows of a higher degree in the unknown are divided as numbers.
const HIGHEST_DEGREE: usize = 4;

/// `value / factor`: without the factor if it divides the value exactly as a polynomial in one of the `unknowns`,
/// otherwise the plain quotient.
pub(super) fn quotient(graph: &mut Graph, value: NodeId, factor: NodeId, unknowns: &[Leaf]) -> NodeId {
    for &unknown in unknowns {
        if let Some(quotient) = divide_exactly(graph, value, factor, unknown) {
            return quotient;
        }
    }
    graph.div(value, factor)
}

fn divide_exactly(graph: &mut Graph, value: NodeId, factor: NodeId, unknown: Leaf) -> Option<NodeId> {
    let slope = graph.derivative(factor, unknown);
    if graph.depends_on(slope, unknown) || graph.vanishes(slope) {
        return None;
    }
    let zero = graph.constant(0.0);
    let at_zero = HashMap::from([(unknown, zero)]);
    let offset = graph.substitute(factor, &at_zero);

    // terms that carry the factor openly, such as w tanh(w), need no division
    let (scale, base) = graph.split(factor);
    let (constant, terms) = match graph.node(value).clone() {
        Node::Sum(constant, terms) => (constant.get(), terms.iter().map(|&(t, c)| (t, c.get())).collect()),
        _ => (0.0, vec![(value, 1.0)]),
    };
    let mut open = Vec::new();
    let mut rest = Vec::new();
    for (term, c) in terms {
        let carries = match graph.node(term) {
            Node::Product(factors) => factors.iter().any(|&(node, n)| node == base && n > 0),
            _ => term == base,
        };
        if carries {
            open.push((graph.product(&[(term, 1), (base, -1)]), c / scale));
        } else {
            rest.push((term, c));
        }
    }
    let mut polynomial = graph.linear(constant, &rest);

    // Taylor coefficients at 0, until there are no more
    let mut coefficients = Vec::new();
    while !graph.vanishes(polynomial) {
        if coefficients.len() > HIGHEST_DEGREE {
            return None;
        }
        coefficients.push(graph.substitute(polynomial, &at_zero));
        let degree = f64::from(u32::try_from(coefficients.len()).ok()?);
        let derivative = graph.derivative(polynomial, unknown);
        polynomial = graph.scale(1.0 / degree, derivative);
    }

    // synthetic division by offset + slope · unknown, from the highest degree down
    let mut quotient = Vec::new();
    let mut carried = zero;
    for &coefficient in coefficients.iter().skip(1).rev() {
        let taken = graph.mul(carried, offset);
        let left = graph.sub(coefficient, taken);
        carried = graph.div(left, slope);
        quotient.push(carried);
    }
    let taken = graph.mul(carried, offset);
    let remainder = match coefficients.first() {
        Some(&first) => graph.sub(first, taken),
        None => zero,
    };
    if !graph.vanishes(remainder) {
        return None;
    }
    let variable = graph.leaf(unknown);
    let degree = i32::try_from(quotient.len()).ok()?;
    for (coefficient, power) in quotient.into_iter().zip((0..degree).rev()) {
        open.push((graph.product(&[(coefficient, 1), (variable, power)]), 1.0));
    }
    Some(graph.linear(0.0, &open))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::Unary;

    #[test]
    fn an_exact_factor_leaves_no_denominator() {
        let mut graph = Graph::new();
        let (z, a, b, c) = (
            graph.leaf(Leaf::Z(0)),
            graph.leaf(Leaf::N(0)),
            graph.leaf(Leaf::N(1)),
            graph.leaf(Leaf::D(0)),
        );
        // w = a + b z; row = w (c - 3 z + tanh w), the polynomial part multiplied out
        let slope = graph.mul(b, z);
        let w = graph.add(a, slope);
        let tanh = graph.unary(Unary::Tanh, w);
        let open = graph.mul(w, tanh);
        let products = [
            (a, c, 1.0, 0),
            (b, c, 1.0, 1),
            (a, a, 0.0, 0),
            (a, z, -3.0, 0),
            (b, z, -3.0, 1),
        ];
        let mut terms = vec![(open, 1.0)];
        for (first, second, scale, power) in products {
            terms.push((graph.product(&[(first, 1), (second, 1), (z, power)]), scale));
        }
        let row = graph.linear(0.0, &terms);
        let quotient = quotient(&mut graph, row, w, &[Leaf::Z(0)]);
        let expected = graph.linear(0.0, &[(c, 1.0), (z, -3.0), (tanh, 1.0)]);
        let difference = graph.sub(quotient, expected);
        assert!(graph.vanishes(difference));
        // at w = 0 there is nothing to divide by
        let reciprocal = graph.recip(w);
        let inside = |graph: &Graph| {
            let mut open = vec![quotient];
            while let Some(id) = open.pop() {
                if let Node::Product(factors) = graph.node(id)
                    && factors
                        .iter()
                        .any(|&(node, n)| n < 0 && graph.depends_on(node, Leaf::Z(0)))
                {
                    return true;
                }
                open.extend(graph.parts(id));
            }
            false
        };
        assert!(!inside(&graph), "{:?}", graph.node(reciprocal));
    }

    #[test]
    fn a_factor_that_does_not_divide_stays_a_denominator() {
        let mut graph = Graph::new();
        let (z, a) = (graph.leaf(Leaf::Z(0)), graph.leaf(Leaf::N(0)));
        let w = graph.add(a, z);
        let square = graph.powi(z, 2);
        let row = graph.add(square, a);
        let (quotient, plain) = (quotient(&mut graph, row, w, &[Leaf::Z(0)]), graph.div(row, w));
        assert_eq!(quotient, plain);
    }
}
