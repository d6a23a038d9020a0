//! Similar operations of a long program.
//!
//! The links of a chain, or the nodes of a lattice, have the same operations with other numbers. Operations are
//! of one *kind* if they do the same with operands of the same kinds ([`Kinds`]). Rust code of thousands of
//! operations is written as loops over those of one kind ([`crate::emit::rust::loops`]); values that are passed
//! from one method to another stand in the order that such loops read ([`Cell`]).

use std::cmp::Ordering;
use std::collections::BTreeSet;

use super::schedule::{Product, Schedule};
use super::{Op, Program, Value};
use crate::graph::{Bits, Comparison, Leaf, Unary};
use crate::hash::HashMap;

/// The most operations of a program that is written without loops over similar operations.
const MOST_WITHOUT_CELLS: usize = 8000;

/// The kind of an operation: the property by which operations are similar.
#[derive(Clone, PartialEq, Eq, Hash)]
pub(crate) enum Kind {
    Constant(Bits),
    Leaf(std::mem::Discriminant<Leaf>),
    Parameter,
    /// A value that another method has computed, by its kind there.
    Given(usize),
    /// Sums and differences of any number of terms of some kinds, where the number does not matter.
    Sum(BTreeSet<usize>),
    /// The operation, the kinds of its operands, and the order of each operand's coordinates and the next
    /// one's.
    Operation(Operation, Vec<usize>, Vec<Ordering>),
    /// Similar to no other operation.
    Alone(Value),
}

/// An operation without its operands.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Operation {
    Neg,
    Add,
    Sub,
    Mul,
    Div,
    Recip,
    Powi(i32),
    Unary(Unary),
    Powf,
    Atan2,
    Select(Comparison),
}

impl Operation {
    /// Whether it calls a function, so that a loop with it is not vectorized.
    pub(crate) fn is_call(self) -> bool {
        let in_registers = matches!(self, Self::Unary(Unary::Sqrt | Unary::Abs | Unary::Signum));
        matches!(self, Self::Powi(_) | Self::Unary(_) | Self::Powf | Self::Atan2) && !in_registers
    }
}

/// The kinds of some operations, and their numbers.
pub(crate) struct Kinds {
    numbers: HashMap<Kind, usize>,
    pub(crate) of: HashMap<Value, usize>,
    sums: HashMap<usize, BTreeSet<usize>>,
}

impl Kinds {
    pub(crate) fn new() -> Self {
        Self {
            numbers: HashMap::default(),
            of: HashMap::default(),
            sums: HashMap::default(),
        }
    }

    fn number(&mut self, kind: Kind) -> usize {
        let next = self.numbers.len();
        *self.numbers.entry(kind).or_insert(next)
    }

    /// Adds an operation of a kind, whose operands have been added; returns the kind's number.
    pub(crate) fn add(&mut self, value: Value, kind: Kind) -> usize {
        let number = self.number(kind);
        self.of.insert(value, number);
        number
    }

    /// The operands in the order of their kinds, where the operation is commutative.
    pub(crate) fn ordered(&self, operation: Operation, mut parts: Vec<Value>) -> Vec<Value> {
        if matches!(operation, Operation::Add | Operation::Mul) {
            parts.sort_by_key(|part| (self.of.get(part).copied(), *part));
        }
        parts
    }
}

impl Program<'_> {
    /// An operation and its operands; `None` for constants, leaves, parameters and calls of the user's
    /// functions.
    pub(crate) fn operation_of(
        &self,
        value: Value,
        schedule: Option<&Schedule>,
    ) -> Option<(Operation, Vec<Value>)> {
        let operation = match self.op(value) {
            Op::Constant(_) | Op::Leaf(_) | Op::Param(_) | Op::Call { .. } => return None,
            Op::Neg(_) => Operation::Neg,
            Op::Add(..) => Operation::Add,
            Op::Sub(..) => Operation::Sub,
            Op::Mul(a, b) => match schedule.map(|schedule| schedule.product(self, *a, *b)) {
                Some(Product::Quotient(top, bottom)) => return Some((Operation::Div, vec![top, bottom])),
                _ => Operation::Mul,
            },
            Op::Recip(_) => Operation::Recip,
            Op::Powi(_, n) => Operation::Powi(*n),
            Op::Unary(op, _) => Operation::Unary(*op),
            Op::Powf(..) => Operation::Powf,
            Op::Atan2(..) => Operation::Atan2,
            Op::Select(op, _) => Operation::Select(*op),
        };
        Some((operation, self.op(value).parts()))
    }

    /// The number of the kind of every operation, where sums of similar terms are similar whatever their
    /// number.
    fn kinds_of_values(&self) -> Vec<usize> {
        let mut kinds = Kinds::new();
        self.values()
            .map(|value| {
                let kind = match (self.op(value), self.operation_of(value, None)) {
                    (Op::Constant(bits), _) => Kind::Constant(*bits),
                    (Op::Leaf(leaf), _) => Kind::Leaf(std::mem::discriminant(leaf)),
                    (Op::Param(_), _) => Kind::Parameter,
                    (_, None) => Kind::Alone(value),
                    (_, Some((Operation::Add | Operation::Sub, parts))) => {
                        let terms = parts.iter().flat_map(|part| {
                            let kind = kinds.of[part];
                            kinds
                                .sums
                                .get(&kind)
                                .cloned()
                                .unwrap_or_else(|| BTreeSet::from([kind]))
                        });
                        let terms: BTreeSet<usize> = terms.collect();
                        if let (1, Some(&only)) = (terms.len(), terms.first()) {
                            kinds.of.insert(value, only);
                            return only;
                        }
                        Kind::Sum(terms)
                    }
                    (_, Some((operation, parts))) => {
                        let parts = kinds.ordered(operation, parts);
                        Kind::Operation(
                            operation,
                            parts.iter().map(|part| kinds.of[part]).collect(),
                            Vec::new(),
                        )
                    }
                };
                let terms = match &kind {
                    Kind::Sum(terms) => Some(terms.clone()),
                    _ => None,
                };
                let number = kinds.add(value, kind);
                if let Some(terms) = terms {
                    kinds.sums.insert(number, terms);
                }
                number
            })
            .collect()
    }
}

/// The number of coordinates of a value that are used to order it among similar ones.
const IN_KEY: usize = 4;

/// The position of a value among similar ones, for sorting.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(crate) struct Cell {
    /// The number of its kind.
    pub(crate) kind: usize,
    /// The first coordinates that it depends on; without any, those of its first use.
    pub(crate) key: Vec<usize>,
    /// Whether it depends on coordinates.
    pub(crate) varies: bool,
}

impl Program<'_> {
    /// Finds similar operations, if there are many operations; to be called once everything is lowered.
    pub(crate) fn look_for_cells(&mut self) {
        if self.ops.len() > MOST_WITHOUT_CELLS {
            self.cells = self.cells_of_values();
        }
    }

    /// Whether similar operations are written as loops.
    pub(crate) fn has_cells(&self) -> bool {
        !self.cells.is_empty()
    }

    /// Values in the order in which they are passed to another method: similar ones together.
    pub(crate) fn in_order(&self, values: impl IntoIterator<Item = Value>) -> Vec<Value> {
        let mut values: Vec<Value> = values.into_iter().collect();
        if self.has_cells() {
            values.sort_by_key(|value| (self.cell(*value), *value));
        }
        values
    }

    /// The cells of all operations.
    fn cells_of_values(&self) -> Vec<Cell> {
        let mut cells: Vec<Cell> = Vec::with_capacity(self.ops.len());
        for (op, kind) in self.ops.iter().zip(self.kinds_of_values()) {
            let mut key = match op {
                Op::Leaf(leaf) => Vec::from_iter(leaf.place()),
                _ => op
                    .parts()
                    .iter()
                    .flat_map(|part| cells[part.0 as usize].key.clone())
                    .collect(),
            };
            key.sort_unstable();
            key.dedup();
            key.truncate(IN_KEY);
            let varies = !key.is_empty();
            cells.push(Cell { kind, key, varies });
        }
        for place in (0..cells.len()).rev() {
            let key = cells[place].key.clone();
            for part in self.ops[place].parts() {
                let part = &mut cells[part.0 as usize];
                if !key.is_empty() && !part.varies && (part.key.is_empty() || key < part.key) {
                    part.key.clone_from(&key);
                }
            }
        }
        cells
    }

    pub(crate) fn cell(&self, value: Value) -> &Cell {
        &self.cells[value.0 as usize]
    }
}
