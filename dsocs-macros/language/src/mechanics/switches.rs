//! Where a declaration is given by pieces, or divides by what may be zero.
//!
//! Whatever a motion may meet a jump, a corner or a pole at is an expression whose sign changes there: the argument of a `signum` or of an absolute
//! value, the difference of the two sides of a comparison, and what is divided by. Runs of steps watch these *arguments*.

use super::sides::{Sides, sides};
use crate::graph::{Graph, Leaf, Node, NodeId, Unary};
use crate::hash::HashSet;
use crate::model::{Displacements, Model};

/// The arguments of whatever is given by pieces, and of poles.
pub(crate) struct Switches {
    /// The graph that they stand in.
    pub(crate) graph: Graph,
    /// The arguments, in `Q`, `V` and `T`, multiples once: those of functions that jump with the velocity first, in the order of their sides.
    pub(crate) arguments: Vec<NodeId>,
}

/// The switches of a declaration.
pub(crate) fn switches(model: &Model) -> Switches {
    // the graph with sides has all nodes of the model's
    let (mut graph, mut arguments) = match sides(model) {
        Some(Sides { model, arguments }) => (model.graph, arguments),
        None => (model.graph.clone(), Vec::new()),
    };
    let rows = model.constraints.iter().map(|row| row.value);
    let forms = model.forms.iter().flat_map(|form| &form.components);
    let fields = match &model.displacements {
        Displacements::Fields(fields) => fields.as_slice(),
        Displacements::Annihilated => &[],
    };
    let mut open: Vec<NodeId> = rows
        .chain([model.lagrangian])
        .chain(model.external_forces.iter().copied())
        .chain(forms.copied())
        .chain(fields.iter().flatten().copied())
        .collect();
    let mut seen = HashSet::default();
    while let Some(id) = open.pop() {
        if !seen.insert(id) {
            continue;
        }
        open.extend(graph.parts(id));
        let found = match graph.node(id).clone() {
            Node::Unary(Unary::Signum | Unary::Abs, argument) => vec![argument],
            Node::Select(_, [left, right, ..]) => vec![graph.sub(right, left)],
            Node::Product(factors) => {
                let below = factors.into_iter().filter(|&(_, exponent)| exponent < 0);
                below.flat_map(|(factor, _)| zero_with(&graph, factor)).collect()
            }
            _ => Vec::new(),
        };
        for argument in found {
            add(&mut graph, argument, &mut arguments);
        }
    }
    Switches { graph, arguments }
}

/// Expressions one of which is zero where an expression is: what roots and powers are taken of.
fn zero_with(graph: &Graph, id: NodeId) -> Vec<NodeId> {
    match graph.node(id) {
        Node::Unary(Unary::Sqrt | Unary::Cbrt | Unary::Abs, base) | Node::Powf(base, _) => {
            zero_with(graph, *base)
        }
        Node::Product(factors) => {
            let above = factors.iter().filter(|&&(_, exponent)| exponent > 0);
            above.flat_map(|&(factor, _)| zero_with(graph, factor)).collect()
        }
        _ => vec![id],
    }
}

/// Adds an argument, if its sign may change with the motion and it is not a multiple of a known one.
fn add(graph: &mut Graph, argument: NodeId, arguments: &mut Vec<NodeId>) {
    let is_motion = graph
        .leaves(argument)
        .all(|leaf| matches!(leaf, Leaf::Q(_) | Leaf::V(_) | Leaf::T));
    if !is_motion || graph.leaves(argument).next().is_none() || has_one_sign(graph, argument) {
        return;
    }
    let (_, argument) = graph.split(argument);
    if !arguments.contains(&argument) {
        arguments.push(argument);
    }
}

/// Whether the values of an expression cannot be below zero, or cannot be above.
fn has_one_sign(graph: &Graph, id: NodeId) -> bool {
    let [least, most] = range(graph, id);
    least >= 0.0 || most <= 0.0
}

/// Numbers between which the values of an expression lie, as its form tells.
fn range(graph: &Graph, id: NodeId) -> [f64; 2] {
    const ANY: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];
    match graph.node(id) {
        Node::Constant(value) => [value.get(); 2],
        Node::Unary(Unary::Sin | Unary::Cos | Unary::Tanh | Unary::Signum, _) => [-1.0, 1.0],
        Node::Unary(Unary::Sqrt | Unary::Exp | Unary::Abs, _) => [0.0, f64::INFINITY],
        Node::Unary(Unary::Cosh, _) => [1.0, f64::INFINITY],
        Node::Product(factors) => factors.iter().fold([1.0, 1.0], |product, &(factor, exponent)| {
            let factor = if exponent % 2 == 0 {
                let [least, most] = range(graph, factor);
                // an even power of what is bounded by one is, too
                let most = if exponent > 0 && least >= -1.0 && most <= 1.0 {
                    1.0
                } else {
                    f64::INFINITY
                };
                [0.0, most]
            } else if exponent > 0 {
                range(graph, factor)
            } else if has_one_sign(graph, factor) {
                if range(graph, factor)[0] >= 0.0 {
                    [0.0, f64::INFINITY]
                } else {
                    [f64::NEG_INFINITY, 0.0]
                }
            } else {
                ANY
            };
            times(product, factor)
        }),
        Node::Sum(constant, terms) => terms
            .iter()
            .fold([constant.get(); 2], |[least, most], (term, c)| {
                let [low, high] = times([c.get(); 2], range(graph, *term));
                [least + low, most + high]
            }),
        _ => ANY,
    }
}

/// The range of a product.
fn times(x: [f64; 2], y: [f64; 2]) -> [f64; 2] {
    let products = x
        .iter()
        .flat_map(|x| y.map(|y| if *x == 0.0 || y == 0.0 { 0.0 } else { x * y }));
    products.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], x| {
        [least.min(x), most.max(x)]
    })
}
