//! The plan of the recurrences: the series to compute, their order, and their operands. Code and data are written from it.

use std::collections::BTreeSet;

use super::describe;
use super::lower::Lower;
use super::sequence::{Argument, Constant, Op, Sequence, Sequences};
use crate::graph::{Graph, Node, NodeId, Unary};
use crate::mechanics;
use crate::model::Model;
use crate::passes::{self, Motion};

/// The number of sums in a block of lanes, as `LANES` in `dsocs-core/src/series/orders.rs`.
pub(crate) const LANES: usize = 4;

/// With up to this many products, the time of an order is that of its longest chain of operations; with more,
/// it is that of all operations.
const MOST_EAGER: usize = 16;

/// The plan of the recurrences of a motion.
pub(crate) struct Plan {
    /// All operations, with the inner sums of their recurrences.
    pub(crate) sequences: Sequences,
    /// The sequences that are needed beyond order 0.
    pub(crate) beyond_order_0: BTreeSet<Sequence>,
    /// The sequences that depend on accelerations that are solved for numerically.
    pub(crate) accelerated: BTreeSet<Sequence>,
    /// The sequences among the latter that higher orders need once the accelerations are known.
    pub(crate) after_solve: BTreeSet<Sequence>,
    pub(crate) accelerations: Vec<Sequence>,
    pub(crate) rows: Vec<Sequence>,
    /// The Jacobian of the rows, row by row.
    pub(crate) jacobian: Vec<Sequence>,
    /// The factors that depend on the parameters, each once.
    pub(crate) constants: Vec<NodeId>,
    /// The calls of the user's functions, in order.
    pub(crate) calls: Vec<Sequence>,
    /// Whether inner sums take the newest coefficients from variables instead of arrays.
    pub(crate) eager: bool,
    /// The number of leading blocks of products, and of squares, all of whose operands are known before an order is computed.
    pub(crate) whole: [usize; 2],
    /// The motion whose series is computed.
    pub(crate) motion: Motion,
}

/// A factor that is constant in time.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) enum Factor {
    /// A number.
    Number(f64),
    /// An expression of the parameters, by its index in [`Plan::constants`].
    Computed(usize),
}

impl Plan {
    /// The plan of a declaration's motion.
    pub(crate) fn of(model: &Model, graph: &mut Graph) -> Self {
        let motion = motion(model, graph);
        Self::new(graph, motion, &hidden_jumps(model))
    }

    /// The plan of a motion. `hidden_jumps` are functions in which the declaration jumps although the motion does
    /// not show it.
    pub(crate) fn new(graph: &mut Graph, motion: Motion, hidden_jumps: &[NodeId]) -> Self {
        let beyond_order_0 = [motion.accelerations.as_slice(), &motion.rows].concat();
        let mut lower = Lower::new(graph, &beyond_order_0);
        let mut all =
            |nodes: &[NodeId]| -> Vec<Sequence> { nodes.iter().map(|&node| lower.lower(node)).collect() };
        let (accelerations, rows) = (all(&motion.accelerations), all(&motion.rows));
        let jacobian = all(&motion.jacobian.concat());
        all(hidden_jumps);
        let sequences = lower.sequences;
        let switched = sequences.switched();
        let mut plan = Self {
            beyond_order_0: sequences.needed(&[accelerations.as_slice(), &rows, &switched].concat()),
            accelerated: sequences.accelerated(),
            after_solve: BTreeSet::new(),
            accelerations,
            rows,
            jacobian,
            constants: Vec::new(),
            calls: Vec::new(),
            eager: false,
            whole: [0; 2],
            sequences,
            motion,
        };
        plan.find(graph);
        plan
    }

    /// Finds inner sums, constants and calls: first those of the orders beyond 0, then those of order 0.
    fn find(&mut self, graph: &Graph) {
        for is_start in [false, true] {
            for accelerated in [false, true] {
                let places: Vec<Sequence> = if is_start {
                    self.at_start(accelerated).map(|(to, _)| to).collect()
                } else {
                    self.beyond(accelerated).map(|(to, _)| to).collect()
                };
                for to in places {
                    let op = self.sequences.op(to).clone();
                    for constant in op.constants(is_start) {
                        if number(graph, constant).is_none() && !self.constants.contains(&constant) {
                            self.constants.push(constant);
                        }
                    }
                    if matches!(op, Op::Call { .. }) && !self.calls.contains(&to) {
                        self.calls.push(to);
                    }
                    if !is_start {
                        for sum in op.inner(to) {
                            self.sequences.add_lane(sum);
                        }
                    }
                }
            }
        }
        self.eager = self.sequences.products.len() <= MOST_EAGER;
        self.whole = self.sequences.fill(LANES);
        let operands = self.sequences.products.iter().flatten();
        let operands = operands.chain(&self.sequences.squares);
        let mut outputs: Vec<Sequence> = operands.map(|operand| operand.sequence()).collect();
        outputs.extend(&self.accelerations);
        outputs.extend(self.sequences.switched());
        let needed = self.sequences.needed(&outputs);
        self.after_solve = self.accelerated.intersection(&needed).copied().collect();
    }

    /// The operations of order 0, of the sequences that depend on accelerations or of the others.
    pub(crate) fn at_start(&self, accelerated: bool) -> impl Iterator<Item = (Sequence, &Op)> {
        let ops = self.sequences.ops();
        ops.filter(move |(to, _)| self.accelerated.contains(to) == accelerated)
    }

    /// The operations of the orders beyond 0.
    pub(crate) fn beyond(&self, accelerated: bool) -> impl Iterator<Item = (Sequence, &Op)> {
        self.at_start(accelerated)
            .filter(|(to, _)| self.beyond_order_0.contains(to))
    }

    /// The operations that higher orders need once the accelerations of an order are known.
    pub(crate) fn after_solve(&self) -> impl Iterator<Item = (Sequence, &Op)> {
        self.sequences
            .ops()
            .filter(|(to, _)| self.after_solve.contains(to))
    }

    /// A constant factor, as a number or by its index.
    pub(crate) fn factor(&self, graph: &Graph, constant: Constant) -> Factor {
        let computed = || {
            let mut constants = self.constants.iter();
            constants.position(|&known| known == constant).unwrap_or_default()
        };
        number(graph, constant).map_or_else(|| Factor::Computed(computed()), Factor::Number)
    }

    /// The names of the switches for error messages: those of the declaration, then one for each call of a
    /// user's function.
    pub(crate) fn names(&self, model: &Model, graph: &Graph) -> Vec<String> {
        let text = |&node: &NodeId| describe::describe(graph, &model.coordinates, node);
        let declared = self.sequences.switches().iter();
        let declared = declared.map(|(argument, nodes)| match argument {
            // these end no motion
            Argument::Steep(_) | Argument::Power(..) | Argument::Bounded(..) => String::new(),
            _ => nodes.iter().map(text).collect::<Vec<_>>().join(" - "),
        });
        let calls = self.calls.iter();
        let calls = calls.map(|&call| match self.sequences.op(call) {
            Op::Call { callee, .. } => format!("a comparison in {}", describe::function(graph, *callee)),
            _ => String::new(),
        });
        declared.chain(calls).collect()
    }
}

/// The value of a constant, if it is a finite number.
fn number(graph: &Graph, constant: Constant) -> Option<f64> {
    graph.as_constant(constant).filter(|value| value.is_finite())
}

/// The motion of a declaration, in the form with the fewest products of sequences.
fn motion(model: &Model, graph: &mut Graph) -> Motion {
    let equations = mechanics::continuous(model, graph);
    let n = model.coordinates.len();
    let rows = (equations.rows.as_slice(), equations.velocities.as_slice());
    passes::motion(graph, rows, n, model.multipliers(), Lower::cost)
}

/// The jumps in the Lagrangian and in constraints on positions or velocities. The equations may not show
/// them, since a derivative is that of one side: `lagrangian = dot(x).powi(2) / 2 - x.signum()` has a step in
/// the potential, and the acceleration is zero on both sides of it.
fn hidden_jumps(model: &Model) -> Vec<NodeId> {
    let graph = &model.graph;
    let constraints = model.constraints.iter();
    let lower = constraints.filter(|row| row.order < 2).map(|row| row.value);
    let declared = lower.chain([model.lagrangian]);
    let mut jumps = graph.subexpressions(declared, |id| graph.jump_leaves(id).next().is_some());
    jumps.retain(|&id| matches!(graph.node(id), Node::Unary(Unary::Signum, _) | Node::Select(..)));
    jumps
}
