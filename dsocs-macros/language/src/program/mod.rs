//! From the expression graph to operations.
//!
//! A [`Program`] holds the operations of several functions, each operation once, with the *stage* at which it
//! can be computed. The early factors of a sum or product are gathered into a partial result of its own, so
//! that later stages have as little to do as possible. The caller defines the stages; see [`stages`].

pub(crate) mod cells;
pub(crate) mod schedule;
pub(crate) mod stages;

mod running;
mod sums;

use std::rc::Rc;

use crate::graph::{Bits, Comparison, Graph, Leaf, Node, NodeId, Unary};
use crate::hash::HashMap;
use crate::passes::running::EarlyFactor;
use crate::passes::share::Shared;

/// An operation of a [`Program`].
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub(crate) struct Value(u32);

impl Value {
    pub(crate) fn index(self) -> usize {
        self.0 as usize
    }
}

#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(crate) enum Op {
    Constant(Bits),
    Leaf(Leaf),
    Param(usize),
    Neg(Value),
    Add(Value, Value),
    Sub(Value, Value),
    Mul(Value, Value),
    Recip(Value),
    Powi(Value, i32),
    Unary(Unary, Value),
    Powf(Value, Value),
    Atan2(Value, Value),
    Select(Comparison, [Value; 4]),
    Call {
        callee: usize,
        args: Vec<Value>,
        wrt: Vec<usize>,
    },
}

impl Op {
    pub(crate) fn parts(&self) -> Vec<Value> {
        let mut parts = Vec::new();
        self.for_parts(|part| parts.push(part));
        parts
    }

    /// Calls a function with each operand.
    pub(crate) fn for_parts(&self, mut with: impl FnMut(Value)) {
        match self {
            Self::Constant(_) | Self::Leaf(_) | Self::Param(_) => {}
            Self::Neg(a) | Self::Recip(a) | Self::Powi(a, _) | Self::Unary(_, a) => with(*a),
            Self::Add(a, b) | Self::Sub(a, b) | Self::Mul(a, b) | Self::Powf(a, b) | Self::Atan2(a, b) => {
                with(*a);
                with(*b);
            }
            Self::Select(_, parts) => parts.iter().copied().for_each(with),
            Self::Call { args, .. } => args.iter().copied().for_each(with),
        }
    }
}

/// The array and the index of a value that another method has computed.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Stored {
    /// In `constants`, computed once a run.
    Constants(usize),
    /// In `known`, computed once a step.
    Known(usize),
}

/// Values that other methods have computed, and where they are stored.
pub(crate) type Given = HashMap<Value, Stored>;

/// Operations, each with the stage at which it can be computed.
pub(crate) struct Program<'g> {
    pub(crate) graph: &'g Graph,
    stage_of: fn(Leaf) -> usize,
    ops: Vec<Op>,
    stages: Vec<usize>,
    known: HashMap<Op, Value>,
    lowered: HashMap<NodeId, Value>,
    /// The stage at which nodes with a set of leaves are known.
    set_stages: HashMap<usize, usize>,
    shared: Shared,
    /// The shared parts that have been lowered.
    parts: HashMap<usize, Value>,
    /// The early parts of terms that have been lowered.
    early: HashMap<EarlyFactor, Value>,
    /// The parts of a sum that are computed as running sums; see [`running`].
    running: HashMap<NodeId, Vec<Rc<running::Running>>>,
    running_parts: Shared,
    /// The shared partial sums that have been lowered.
    running_values: HashMap<usize, Value>,
    /// For every operation its cell, if the program is so long that similar operations become loops; see
    /// [`cells`].
    cells: Vec<cells::Cell>,
}

impl<'g> Program<'g> {
    /// The number of operations.
    pub(crate) fn operations(&self) -> usize {
        self.ops.len()
    }

    /// An empty program; `stage_of` is the stage at which a leaf is known. Numbers and parameters are known
    /// at stage 0.
    pub(crate) fn new(graph: &'g Graph, stage_of: fn(Leaf) -> usize) -> Self {
        Self {
            graph,
            stage_of,
            ops: Vec::new(),
            stages: Vec::new(),
            known: HashMap::default(),
            lowered: HashMap::default(),
            set_stages: HashMap::default(),
            shared: Shared::default(),
            parts: HashMap::default(),
            early: HashMap::default(),
            running: HashMap::default(),
            running_parts: Shared::default(),
            running_values: HashMap::default(),
            cells: Vec::new(),
        }
    }

    /// The operation that computes a node.
    pub(crate) fn lower(&mut self, id: NodeId) -> Value {
        if let Some(&value) = self.lowered.get(&id) {
            return value;
        }
        let graph = self.graph;
        let value = match *graph.node(id) {
            Node::Constant(bits) => self.push(Op::Constant(bits)),
            Node::Leaf(leaf) => self.push(Op::Leaf(leaf)),
            Node::Param(param) => self.push(Op::Param(param)),
            Node::Sum(constant, ref terms) => self.lower_sum(id, constant, terms),
            Node::Product(_) => self.lower_product(id),
            Node::Unary(op, a) => {
                let a = self.lower(a);
                self.push(Op::Unary(op, a))
            }
            Node::Powf(a, b) => {
                let (a, b) = (self.lower(a), self.lower(b));
                self.push(Op::Powf(a, b))
            }
            Node::Atan2(y, x) => {
                let (y, x) = (self.lower(y), self.lower(x));
                self.push(Op::Atan2(y, x))
            }
            Node::Select(op, parts) => {
                let parts = parts.map(|part| self.lower(part));
                self.push(Op::Select(op, parts))
            }
            Node::Call {
                callee,
                ref args,
                ref wrt,
            } => {
                let args = args.iter().map(|&arg| self.lower(arg)).collect();
                let wrt = wrt.clone();
                self.push(Op::Call { callee, args, wrt })
            }
        };
        self.lowered.insert(id, value);
        value
    }

    /// The stage at which a value is known.
    pub(crate) fn stage(&self, value: Value) -> usize {
        self.stages[value.0 as usize]
    }

    /// Whether a value is the number 1.
    pub(crate) fn is_one(&self, value: Value) -> bool {
        matches!(self.op(value), Op::Constant(bits) if *bits == Bits::new(1.0))
    }

    pub(crate) fn op(&self, value: Value) -> &Op {
        &self.ops[value.0 as usize]
    }

    /// All values, in order.
    fn values(&self) -> impl Iterator<Item = Value> + use<> {
        let count = u32::try_from(self.ops.len()).unwrap_or(u32::MAX);
        (0..count).map(Value)
    }

    fn push(&mut self, op: Op) -> Value {
        if let Some(&value) = self.known.get(&op) {
            return value;
        }
        let mut stage = match &op {
            Op::Leaf(leaf) => (self.stage_of)(*leaf),
            _ => 0,
        };
        op.for_parts(|part| stage = stage.max(self.stage(part)));
        let value = Value(u32::try_from(self.ops.len()).unwrap_or(u32::MAX));
        self.ops.push(op.clone());
        self.stages.push(stage);
        self.known.insert(op, value);
        value
    }

    fn node_stage(&mut self, id: NodeId) -> usize {
        let (graph, stage_of) = (self.graph, self.stage_of);
        let stage = || graph.leaves(id).map(stage_of).max().unwrap_or(0);
        *self.set_stages.entry(graph.leaf_set(id)).or_insert_with(stage)
    }
}
