//! Where a declaration is given by pieces, or divides by what may be zero.
//!
//! Whatever a motion may meet a jump, a corner or a pole at is an expression whose sign changes there: the argument of a `signum` or of an absolute
//! value, the difference of the two sides of a comparison, and what is divided by. Runs of steps watch these *arguments*.

use super::sides::{Sides, sides};
use crate::graph::{Graph, Leaf, Node, NodeId, Unary};
use crate::hash::{HashMap, HashSet};
use crate::model::{Displacements, Model};

/// The arguments of whatever is given by pieces, and of poles.
pub(crate) struct Switches {
    /// The graph that they stand in.
    pub(crate) graph: Graph,
    /// The arguments, in `Q`, `V` and `T`, of third order in `A` as well, multiples once: those of functions that jump with the velocity first, in the order of their sides.
    pub(crate) arguments: Vec<NodeId>,
    /// The tables of samples, each with its argument, in the same leaves.
    pub(crate) tables: Vec<Table>,
}

/// The value of a table of samples.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) struct Table {
    /// The function, by its place in the graph's callees.
    pub(crate) callee: usize,
    /// Its argument.
    pub(crate) argument: NodeId,
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
    let (mut seen, mut ranges, mut tables) = (HashSet::default(), Ranges::default(), Vec::new());
    while let Some(id) = open.pop() {
        if !seen.insert(id) {
            continue;
        }
        open.extend(graph.parts(id));
        if let Node::Call { callee, args, .. } = graph.node(id)
            && let &[argument] = &args[..]
            && model.table(*callee).is_some()
            && is_of_motion(&graph, argument, model.order())
        {
            let table = Table {
                callee: *callee,
                argument,
            };
            if !tables.contains(&table) {
                tables.push(table);
            }
        }
        let found = match graph.node(id).clone() {
            Node::Unary(Unary::Signum | Unary::Abs, argument) => vec![argument],
            Node::Select(_, [left, right, ..]) => vec![graph.sub(right, left)],
            // where a power is not smooth, or infinite, as the logarithm is
            Node::Unary(Unary::Sqrt | Unary::Cbrt | Unary::Ln, base) | Node::Powf(base, _) => {
                let mut found = zero_with(&graph, base);
                found.extend(turns(&mut graph, base));
                found
            }
            // which have a corner where their argument turns back at one
            Node::Unary(Unary::Asin | Unary::Acos, argument) => vec![graph.total_derivative(argument)],
            // where an angle jumps by a whole turn
            Node::Atan2(ordinate, _) => vec![ordinate],
            Node::Unary(Unary::Tan, angle) => vec![graph.unary(Unary::Cos, angle)],
            Node::Product(factors) => {
                let below = factors.into_iter().filter(|&(_, exponent)| exponent < 0);
                below.flat_map(|(factor, _)| zero_with(&graph, factor)).collect()
            }
            _ => Vec::new(),
        };
        for argument in found {
            add(&mut graph, &mut ranges, argument, model.order(), &mut arguments);
        }
    }
    Switches {
        graph,
        arguments,
        tables,
    }
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

/// The rate of what a root is taken of, which changes its sign where that touches zero, if it may do so without changing its own.
fn turns(graph: &mut Graph, base: NodeId) -> Option<NodeId> {
    let may_touch = matches!(graph.node(base), Node::Sum(..)) && !graph.is_several_squares(base);
    may_touch.then(|| graph.total_derivative(base))
}

/// Adds an argument, if its sign may change with the motion and it is not a multiple of a known one.
fn add(graph: &mut Graph, ranges: &mut Ranges, argument: NodeId, order: usize, arguments: &mut Vec<NodeId>) {
    if !is_of_motion(graph, argument, order) || ranges.have_one_sign(graph, argument) {
        return;
    }
    let (_, argument) = graph.split(argument);
    if !arguments.contains(&argument) {
        arguments.push(argument);
    }
}

/// Whether an expression changes with position, velocity and time, of third order also with the acceleration, and with nothing else.
fn is_of_motion(graph: &Graph, argument: NodeId, order: usize) -> bool {
    let is_state = |leaf| match leaf {
        Leaf::Q(_) | Leaf::V(_) | Leaf::T => true,
        // which does not jump where constraints are of third order
        Leaf::A(_) => order > 2,
        _ => false,
    };
    graph.leaves(argument).next().is_some() && graph.leaves(argument).all(is_state)
}

/// Numbers between which the values of expressions lie, as their form tells.
#[derive(Default)]
struct Ranges {
    known: HashMap<NodeId, [f64; 2]>,
}

impl Ranges {
    const ANY: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

    /// Whether the values of an expression cannot be below zero, or cannot be above.
    fn have_one_sign(&mut self, graph: &Graph, id: NodeId) -> bool {
        let [least, most] = self.of(graph, id);
        least >= 0.0 || most <= 0.0
    }

    /// The range of an expression.
    fn of(&mut self, graph: &Graph, id: NodeId) -> [f64; 2] {
        if let Some(&known) = self.known.get(&id) {
            return known;
        }
        let range = match graph.node(id) {
            Node::Constant(value) => [value.get(); 2],
            Node::Unary(Unary::Sin | Unary::Cos | Unary::Tanh | Unary::Signum, _) => [-1.0, 1.0],
            Node::Unary(Unary::Sqrt | Unary::Exp | Unary::Abs, _) => [0.0, f64::INFINITY],
            Node::Unary(Unary::Cosh, _) => [1.0, f64::INFINITY],
            Node::Product(factors) => factors.iter().fold([1.0, 1.0], |product, &(factor, exponent)| {
                times(product, self.of_power(graph, factor, exponent))
            }),
            Node::Sum(constant, terms) => {
                terms
                    .iter()
                    .fold([constant.get(); 2], |[least, most], (term, c)| {
                        let [low, high] = times([c.get(); 2], self.of(graph, *term));
                        [least + low, most + high]
                    })
            }
            _ => Self::ANY,
        };
        self.known.insert(id, range);
        range
    }

    /// The range of a power.
    fn of_power(&mut self, graph: &Graph, factor: NodeId, exponent: i32) -> [f64; 2] {
        let [least, most] = self.of(graph, factor);
        if exponent % 2 == 0 {
            // an even power of what is bounded by one is, too
            let is_bounded = exponent > 0 && least >= -1.0 && most <= 1.0;
            [0.0, if is_bounded { 1.0 } else { f64::INFINITY }]
        } else if exponent == 1 {
            [least, most]
        } else if exponent > 0 && least >= -1.0 && most <= 1.0 {
            [least.min(0.0), most.max(0.0)]
        } else if least >= 0.0 {
            [0.0, f64::INFINITY]
        } else if most <= 0.0 {
            [f64::NEG_INFINITY, 0.0]
        } else {
            Self::ANY
        }
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
