//! Expressions whose sign changes where a declaration jumps, has a corner or has a pole.
//!
//! Such an expression is the argument of a `signum` or of an absolute value, the difference of the two sides
//! of a comparison, or a denominator. Runs of steps watch the signs of these *arguments*.

use crate::graph::{Bits, Graph, Leaf, Node, NodeId, Unary};
use crate::hash::HashMap;
use crate::mechanics::properties::sides::{Sides, sides};
use crate::model::{Displacements, Model};

/// The least exponent of a power that may be flat except where its base is large.
const HIGH: f64 = 4.0;

/// A sum of squares whose constant is less than this part of one of its factors is nearly zero where the square is, also if that has a bound.
const SOFT: f64 = 0.1;

/// The largest ratio of gears.
const GEAR: f64 = 8.0;

/// The arguments of a declaration's switches and poles.
pub(crate) struct Switches {
    /// The graph of the arguments.
    pub(crate) graph: Graph,
    /// The arguments, in `Q`, `V` and `T`, with constraints of third order in `A` as well, without multiples
    /// of each other. Those of functions that jump with the velocity come first, in the order of their sides.
    pub(crate) arguments: Vec<NodeId>,
    /// The tables of samples with their arguments, in the same leaves.
    pub(crate) tables: Vec<Table>,
    /// The functions that may be flat but for a narrow feature.
    pub(crate) steep: Vec<Steep>,
}

/// A function that may be flat but for a narrow feature, an exponential one or a power, or a periodic one.
#[derive(Clone, Copy, PartialEq)]
pub(crate) struct Steep {
    /// The exponent of a power; 0 for an exponential function, infinite for a periodic one.
    pub(crate) exponent: f64,
    /// The argument of the exponential or periodic function, or the base of the power, in the same leaves.
    pub(crate) argument: NodeId,
}

impl Steep {
    /// A power, if it is of a high degree, or a quotient whose divisor grows with the motion and does not vanish: one that may is a switch.
    fn power(graph: &Graph, ranges: &mut Ranges, (argument, exponent): (NodeId, f64)) -> Option<Self> {
        let is_root = exponent.fract() != 0.0 && graph.is_softened_sum(argument);
        let is_steep = if exponent < 0.0 || is_root {
            let vanishes = !graph.is_softened_sum(argument) && !ranges.exclude_zero(graph, argument);
            let is_soft = match graph.node(argument) {
                Node::Sum(constant, terms) => {
                    let is_small =
                        |(_, factor): &(NodeId, Bits)| constant.get().abs() < SOFT * factor.get().abs();
                    terms.iter().any(is_small)
                }
                _ => false,
            };
            !vanishes && (grows(graph, argument) || is_soft)
        } else {
            exponent >= HIGH
        };
        is_steep.then_some(Self { exponent, argument })
    }
}

/// A value of a table of samples.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) struct Table {
    /// The callee, by its index in the graph.
    pub(crate) callee: usize,
    /// Its argument.
    pub(crate) argument: NodeId,
}

/// The switches of a declaration.
pub(crate) fn switches(model: &Model) -> Switches {
    // the graph with sides contains all nodes of the model's graph
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
    let declared = rows
        .chain([model.lagrangian])
        .chain(model.external_forces.iter().copied())
        .chain(forms.copied())
        .chain(fields.iter().flatten().copied());
    let (mut ranges, mut tables) = (Ranges::default(), Vec::new());
    let mut steep = Vec::new();
    let all = graph.subexpressions(declared, |_| true);
    let divisors: Vec<NodeId> = all
        .iter()
        .flat_map(|&id| vanishing_divisors(&graph, id))
        .collect();
    for id in all {
        for found in self::steep(&graph, &mut ranges, id) {
            if is_of_motion(&graph, found.argument, model.order()) && !steep.contains(&found) {
                steep.push(found);
            }
        }
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
            // at a zero of the base a power is not smooth, and a logarithm is infinite
            Node::Unary(Unary::Sqrt | Unary::Cbrt | Unary::Ln, base) | Node::Powf(base, _) => {
                let mut found = vanishing_factors(&graph, base);
                if matches!(graph.node(id), Node::Unary(Unary::Cbrt, _)) {
                    // it goes on beyond its zero, where its rate has no bound
                    found.push(base);
                }
                if graph.is_several_squares(base) {
                    // it keeps its sign where it touches zero, as where a motion goes through the centre
                    if !graph.is_softened_sum(base) && !divisors.contains(&base) {
                        push(&mut graph, base, model.order(), &mut arguments);
                    }
                } else if matches!(graph.node(base), Node::Sum(..)) {
                    found.push(graph.total_derivative(base));
                }
                found
            }
            // these have a corner where their argument turns back at ±1
            Node::Unary(Unary::Asin | Unary::Acos, argument) => vec![graph.total_derivative(argument)],
            // the angle jumps by a whole turn
            Node::Atan2(ordinate, _) => vec![ordinate],
            Node::Unary(Unary::Tan, angle) => vec![graph.unary(Unary::Cos, angle)],
            _ => vanishing_divisors(&graph, id),
        };
        for argument in found {
            add(&mut graph, &mut ranges, argument, model.order(), &mut arguments);
        }
    }
    Switches {
        graph,
        arguments,
        tables,
        steep,
    }
}

/// Expressions one of which is zero wherever an expression is: the bases of roots and powers, and the factors
/// of products.
fn vanishing_factors(graph: &Graph, id: NodeId) -> Vec<NodeId> {
    match graph.node(id) {
        Node::Unary(Unary::Sqrt | Unary::Cbrt | Unary::Abs, base) | Node::Powf(base, _) => {
            vanishing_factors(graph, *base)
        }
        Node::Product(factors) => {
            let above = factors.iter().filter(|&&(_, exponent)| exponent > 0);
            above
                .flat_map(|&(factor, _)| vanishing_factors(graph, factor))
                .collect()
        }
        _ => vec![id],
    }
}

/// The exponential functions, quotients and powers of a high degree that may be flat but for a narrow feature.
fn steep(graph: &Graph, ranges: &mut Ranges, id: NodeId) -> Vec<Steep> {
    match graph.node(id) {
        // a limit of friction: the force is different on both sides, which the nodes see
        Node::Unary(Unary::Tanh | Unary::Atan, argument) if graph.order(*argument) > Some(0) => Vec::new(),
        Node::Unary(
            Unary::Exp | Unary::ExpM1 | Unary::Sinh | Unary::Cosh | Unary::Tanh | Unary::Atan,
            argument,
        ) => {
            vec![Steep {
                exponent: 0.0,
                argument: unclamped(graph, *argument),
            }]
        }
        Node::Unary(Unary::Sin | Unary::Cos | Unary::Tan, argument) if !is_angle(graph, *argument) => {
            vec![Steep {
                exponent: f64::INFINITY,
                argument: *argument,
            }]
        }
        Node::Unary(Unary::Sqrt, base) => Steep::power(graph, ranges, (*base, 0.5)).into_iter().collect(),
        Node::Powf(base, exponent) => {
            let power = graph.as_constant(*exponent).map(|exponent| (*base, exponent));
            power
                .and_then(|power| Steep::power(graph, ranges, power))
                .into_iter()
                .collect()
        }
        Node::Product(factors) => {
            let powers = factors
                .iter()
                .map(|&(factor, exponent)| (factor, f64::from(exponent)));
            powers
                .filter_map(|power| Steep::power(graph, ranges, power))
                .collect()
        }
        _ => Vec::new(),
    }
}

/// Whether an expression is an angle, which turns little in a step: a coordinate, a ratio of gears times one, or a sum of these with small
/// factors. A phase of the time is not, nor is a coordinate divided by a wavelength.
fn is_angle(graph: &Graph, id: NodeId) -> bool {
    match graph.node(id) {
        Node::Leaf(leaf) => *leaf != Leaf::T,
        Node::Product(factors) => factors
            .iter()
            .all(|&(factor, exponent)| match graph.node(factor) {
                Node::Param(_) => exponent > 0,
                _ => exponent == 1 && is_angle(graph, factor),
            }),
        Node::Sum(_, terms) => terms
            .iter()
            .all(|(term, factor)| factor.get().abs() <= GEAR && is_angle(graph, *term)),
        _ => false,
    }
}

/// Whether an expression depends on the motion other than through functions whose values have bounds.
fn grows(graph: &Graph, id: NodeId) -> bool {
    match graph.node(id) {
        Node::Leaf(_) => true,
        // nothing is known of a function of the user's own
        Node::Unary(Unary::Sin | Unary::Cos | Unary::Tanh | Unary::Atan | Unary::Signum, _)
        | Node::Atan2(..)
        | Node::Call { .. } => false,
        _ => graph.parts(id).into_iter().any(|part| grows(graph, part)),
    }
}

/// An expression without the constant limits of its value, where it shows nothing.
fn unclamped(graph: &Graph, id: NodeId) -> NodeId {
    match *graph.node(id) {
        Node::Select(_, [.., then, otherwise]) if graph.as_constant(then).is_some() => {
            unclamped(graph, otherwise)
        }
        Node::Select(_, [.., then, otherwise]) if graph.as_constant(otherwise).is_some() => {
            unclamped(graph, then)
        }
        _ => id,
    }
}

/// Expressions that vanish where a product or a power divides by zero.
fn vanishing_divisors(graph: &Graph, id: NodeId) -> Vec<NodeId> {
    match graph.node(id) {
        Node::Product(factors) => {
            let below = factors.iter().filter(|&&(_, exponent)| exponent < 0);
            below
                .flat_map(|&(factor, _)| vanishing_factors(graph, factor))
                .collect()
        }
        Node::Powf(base, exponent)
            if graph
                .as_constant(*exponent)
                .is_some_and(|exponent| exponent < 0.0) =>
        {
            vanishing_factors(graph, *base)
        }
        _ => Vec::new(),
    }
}

/// Adds an argument whose sign may change with the motion.
fn add(graph: &mut Graph, ranges: &mut Ranges, argument: NodeId, order: usize, arguments: &mut Vec<NodeId>) {
    if !ranges.have_one_sign(graph, argument) {
        push(graph, argument, order, arguments);
    }
}

/// Adds an argument that depends on the motion alone, if it is not a multiple of a known one.
fn push(graph: &mut Graph, argument: NodeId, order: usize, arguments: &mut Vec<NodeId>) {
    if !is_of_motion(graph, argument, order) {
        return;
    }
    let (_, argument) = graph.split(argument);
    if !arguments.contains(&argument) {
        arguments.push(argument);
    }
}

/// Whether an expression depends on position, velocity and time alone, or with constraints of third order on
/// the acceleration as well.
fn is_of_motion(graph: &Graph, argument: NodeId, order: usize) -> bool {
    let is_state = |leaf| match leaf {
        Leaf::Q(_) | Leaf::V(_) | Leaf::T => true,
        // with constraints of third order the acceleration does not jump
        Leaf::A(_) => order > 2,
        _ => false,
    };
    graph.leaves(argument).next().is_some() && graph.leaves(argument).all(is_state)
}

/// Bounds of the values of expressions, by their form.
#[derive(Default)]
pub(crate) struct Ranges {
    known: HashMap<NodeId, [f64; 2]>,
}

impl Ranges {
    const ANY: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

    /// Whether the values of an expression are all nonnegative or all nonpositive.
    pub(crate) fn have_one_sign(&mut self, graph: &Graph, id: NodeId) -> bool {
        let [least, most] = self.of(graph, id);
        least >= 0.0 || most <= 0.0
    }

    /// Whether an expression is not zero anywhere.
    fn exclude_zero(&mut self, graph: &Graph, id: NodeId) -> bool {
        let [least, most] = self.of(graph, id);
        least > 0.0 || most < 0.0
    }

    /// The least and the largest value of an expression.
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

    /// The bounds of a power.
    fn of_power(&mut self, graph: &Graph, factor: NodeId, exponent: i32) -> [f64; 2] {
        let [least, most] = self.of(graph, factor);
        if exponent % 2 == 0 {
            // an even power of a number in [-1, 1] is at most 1
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

/// The bounds of a product.
fn times(x: [f64; 2], y: [f64; 2]) -> [f64; 2] {
    let products = x
        .iter()
        .flat_map(|x| y.map(|y| if *x == 0.0 || y == 0.0 { 0.0 } else { x * y }));
    products.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], x| {
        [least.min(x), most.max(x)]
    })
}
