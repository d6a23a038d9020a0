//! The graph against numeric values: normal form, derivatives and differences.

use super::{Change, Comparison, Graph, Leaf, Node, NodeId, Unary};

use crate::hash::HashMap;

/// The value of a node without calls and parameters.
fn value(graph: &Graph, id: NodeId, at: &dyn Fn(Leaf) -> f64) -> f64 {
    let of = |id: NodeId| value(graph, id, at);
    match graph.node(id) {
        Node::Constant(bits) => bits.get(),
        Node::Leaf(leaf) => at(*leaf),
        Node::Sum(constant, terms) => {
            constant.get() + terms.iter().map(|&(term, c)| c.get() * of(term)).sum::<f64>()
        }
        Node::Product(factors) => factors.iter().map(|&(factor, n)| of(factor).powi(n)).product(),
        Node::Unary(op, a) => op.apply(of(*a)),
        Node::Powf(a, b) => of(*a).powf(of(*b)),
        Node::Atan2(y, x) => of(*y).atan2(of(*x)),
        Node::Select(Comparison::Lt, [l, r, a, b]) => of(if of(*l) < of(*r) { *a } else { *b }),
        Node::Select(Comparison::Le, [l, r, a, b]) => of(if of(*l) <= of(*r) { *a } else { *b }),
        Node::Param(_) | Node::Call { .. } => unreachable!("the tests use neither"),
    }
}

/// Expressions in `Q(0)`, `Q(1)` that together contain every kind of node.
fn expressions(graph: &mut Graph) -> Vec<NodeId> {
    let (x, y) = (graph.leaf(Leaf::Q(0)), graph.leaf(Leaf::Q(1)));
    let product = graph.mul(x, y);
    let mut all = Vec::new();
    for &op in Unary::ALL {
        let argument = if op == Unary::Acosh {
            graph.linear(1.5, &[(product, 1.0)])
        } else {
            graph.linear(0.1, &[(product, 1.0)])
        };
        all.push(graph.unary(op, argument));
    }
    all.push(graph.powf(x, y));
    all.push(graph.atan2(x, y));
    all.push(graph.select(Comparison::Lt, x, y, product, x));
    all.push(graph.select(Comparison::Le, x, y, x, product));
    all.push(graph.powi(product, -3));
    all.push(graph.powi(x, 5));
    let quotient = graph.div(x, y);
    let sum = graph.sum(&[quotient, x, y]);
    all.push(graph.mul(sum, product));
    all
}

#[test]
fn equal_expressions_are_one_node() {
    let mut graph = Graph::new();
    let (x, y) = (graph.leaf(Leaf::Q(0)), graph.leaf(Leaf::Q(1)));
    let (a, b) = (graph.add(x, y), graph.add(y, x));
    assert_eq!(a, b);
    let (a, b) = (graph.mul(x, y), graph.mul(y, x));
    assert_eq!(a, b);
    let (a, b) = (graph.sub(x, y), graph.sub(y, x));
    let zero = graph.add(a, b);
    assert!(graph.is_zero(zero));
    let ratio = graph.div(a, b);
    assert_eq!(graph.as_constant(ratio), Some(-1.0));
    let root = graph.unary(Unary::Sqrt, a);
    let square = graph.powi(root, 2);
    let back = graph.div(square, root);
    assert_eq!(back, root);
}

#[test]
fn the_normal_form_of_differences_finds_the_second_difference() {
    let mut graph = Graph::new();
    let (n, d, e) = (
        graph.leaf(Leaf::N(0)),
        graph.leaf(Leaf::D(0)),
        graph.leaf(Leaf::E(0)),
    );
    let q0 = graph.sub(n, d);
    let q2 = graph.sum(&[n, d, e]);
    let second = graph.linear(0.0, &[(q2, 1.0), (n, -2.0), (q0, 1.0)]);
    assert_eq!(second, e);
}

#[test]
fn derivatives_agree_with_central_differences() {
    let mut graph = Graph::new();
    for id in expressions(&mut graph) {
        for (k, leaf) in [Leaf::Q(0), Leaf::Q(1)].into_iter().enumerate() {
            let derivative = graph.derivative(id, leaf);
            let at = |shift: f64| {
                let point = [
                    0.53 + if k == 0 { shift } else { 0.0 },
                    0.81 + if k == 1 { shift } else { 0.0 },
                ];
                move |leaf: Leaf| if leaf == Leaf::Q(0) { point[0] } else { point[1] }
            };
            let exact = value(&graph, derivative, &at(0.0));
            let h = 1e-3;
            let slope = |h: f64| (value(&graph, id, &at(h)) - value(&graph, id, &at(-h))) / (2.0 * h);
            let numeric = (4.0 * slope(h / 2.0) - slope(h)) / 3.0;
            assert!(
                (exact - numeric).abs() < 1e-9 * (1.0 + exact.abs()),
                "{:?} by {leaf:?}: {exact} against {numeric}",
                graph.node(id),
            );
        }
    }
}

#[test]
fn differences_agree_with_subtraction_and_keep_digits_that_it_loses() {
    let mut graph = Graph::new();
    let all = expressions(&mut graph);
    let mut leaves = HashMap::default();
    for i in 0..2 {
        let (before, delta) = (graph.leaf(Leaf::N(i)), graph.leaf(Leaf::E(i)));
        let after = graph.add(before, delta);
        leaves.insert(Leaf::Q(i), Change { before, after, delta });
    }
    let at = |delta: f64| {
        move |leaf: Leaf| match leaf {
            Leaf::N(0) => 0.53,
            Leaf::N(_) => 0.81,
            Leaf::E(0) => delta,
            _ => -0.7 * delta,
        }
    };
    for id in all {
        let mut done = HashMap::default();
        let change = graph.difference(id, &leaves, &|leaf| matches!(leaf, Leaf::E(_)), false, &mut done);
        let coarse = value(&graph, change.delta, &at(0.01));
        let plain = value(&graph, change.after, &at(0.01)) - value(&graph, change.before, &at(0.01));
        assert!(
            (coarse - plain).abs() <= 1e-14,
            "{:?}: {coarse} against {plain}",
            graph.node(id)
        );
        // at 1e-9 a subtraction keeps 7 digits; nodes with a rule for differences keep all
        if matches!(graph.node(id), Node::Product(_) | Node::Sum(..))
            || matches!(
                graph.node(id),
                Node::Unary(Unary::Sin | Unary::Cos | Unary::Tanh | Unary::Exp, _)
            )
        {
            let fine = value(&graph, change.delta, &at(1e-9));
            let finer = value(&graph, change.delta, &at(0.5e-9));
            let curvature = (fine / 2.0 - finer) / fine;
            assert!(curvature.abs() < 5e-9, "{:?}: {curvature}", graph.node(id));
        }
    }
}

#[test]
fn total_derivative_is_the_chain_rule() {
    let mut graph = Graph::new();
    let (x, v) = (graph.leaf(Leaf::Q(0)), graph.leaf(Leaf::V(0)));
    let expression = graph.product(&[(x, 2), (v, 3)]);
    let rate = graph.total_derivative(expression);
    let at = |leaf: Leaf| match leaf {
        Leaf::Q(_) => 2.0,
        Leaf::V(_) => 3.0,
        _ => 5.0,
    };
    let expected = 2.0 * 2.0 * 27.0 * 3.0 + 4.0 * 3.0 * 9.0 * 5.0;
    assert!((value(&graph, rate, &at) - expected).abs() < 1e-9);
    assert_eq!(graph.order(rate), Some(2));
}
