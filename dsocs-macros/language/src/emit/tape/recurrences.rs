//! The recurrences as data, for an engine that runs them without a compiler; `dsocs_core` documents the
//! bytes.

use super::segment::{Segment, number};
use super::{Calls, of_constants};
use crate::emit::data::Call;
use crate::graph::{Comparison, Graph, Leaf};
use crate::hash::HashMap;
use crate::model::Model;
use crate::passes;
use crate::program::stages::single;
use crate::recurrences::plan::{Factor, Plan};
use crate::recurrences::sequence::{Argument, Constant, Inverse, Lane, Op, Operand, Sequence};

/// The version of the format, as `dsocs_core` reads it.
const VERSION: u8 = 4;

/// The recurrences of Taylor series as data, from [`Model::series`].
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// The recurrences.
    pub recurrences: Vec<u8>,
    /// A tape of the factors that depend on the parameters.
    pub constants: Vec<u8>,
    /// The functions and numbers that both call, in the order of their numbers.
    pub calls: Vec<Call>,
}

/// The recurrences of a declaration; `None` with a constraint of third order, whose motion has no series.
pub(crate) fn series(model: &Model) -> Option<Series> {
    let replaced = passes::with_continuous_quotients(model);
    let model = replaced.as_ref().unwrap_or(model);
    if model.order() > 2 {
        return None;
    }
    let mut graph = model.graph.clone();
    let plan = Plan::of(model, &mut graph);
    let mut calls = Calls::default();
    let (program, values) = single(&graph, &plan.constants);
    let constants = program.segment(Segment::default(), &values, 0, &HashMap::default(), &mut calls);
    let mut bytes = Bytes {
        graph: &graph,
        plan: &plan,
        calls,
        numbers: Vec::new(),
        out: Vec::new(),
    };
    bytes.all(model);
    Some(Series {
        recurrences: bytes.recurrences(),
        constants: of_constants(&constants),
        calls: bytes.calls.data(&graph),
    })
}

/// The bytes of a plan, in the making.
struct Bytes<'g> {
    graph: &'g Graph,
    plan: &'g Plan,
    calls: Calls,
    /// The different numbers among the factors.
    numbers: Vec<f64>,
    out: Vec<u8>,
}

impl Bytes<'_> {
    fn number(&mut self, value: usize) {
        number(&mut self.out, value);
    }

    fn sequence(&mut self, sequence: Sequence) {
        self.number(sequence.index());
    }

    fn sequences(&mut self, sequences: &[Sequence]) {
        for &sequence in sequences {
            self.sequence(sequence);
        }
    }

    fn operand(&mut self, operand: Operand) {
        let is_rate = matches!(operand, Operand::Rate(_));
        self.number(2 * operand.sequence().index() + usize::from(is_rate));
    }

    /// A factor: `2 i` for the number `i`, `2 i + 1` for the computed factor `i`.
    fn factor(&mut self, constant: Constant) {
        let place = match self.plan.factor(self.graph, constant) {
            Factor::Number(value) => {
                let known = self
                    .numbers
                    .iter()
                    .position(|known| known.to_bits() == value.to_bits());
                2 * known.unwrap_or_else(|| {
                    self.numbers.push(value);
                    self.numbers.len() - 1
                })
            }
            Factor::Computed(place) => 2 * place + 1,
        };
        self.number(place);
    }

    /// The index of a switch plus one; 0 if there is none.
    fn switch(&mut self, argument: Argument) {
        let place = self.plan.sequences.place(argument);
        self.number(place.map_or(0, |place| place + 1));
    }

    /// Writes everything but the numbers.
    fn all(&mut self, model: &Model) {
        let Plan {
            sequences, motion, ..
        } = self.plan;
        let count = sequences.ops().count();
        for value in [
            model.coordinates.len(),
            motion.multipliers,
            usize::from(motion.affine),
            usize::from(self.plan.eager),
            self.plan.constants.len(),
        ] {
            self.number(value);
        }
        self.number(sequences.products.len());
        self.number(sequences.squares.len());
        self.number(sequences.switches().len());
        self.number(self.plan.calls.len());
        for name in self.plan.names(model, self.graph) {
            self.number(name.len());
            self.out.extend(name.bytes());
        }
        self.number(count);
        for (to, op) in sequences.ops() {
            self.operation(to, op);
        }
        for [left, right] in &sequences.products {
            self.operand(*left);
            self.operand(*right);
        }
        for &square in &sequences.squares {
            self.operand(square);
        }
        for &(argument, _) in sequences.switches() {
            let (kind, parts, degree) = match argument {
                Argument::Sign(u) => (0, vec![u], None),
                Argument::Steep(u) => (1, vec![u], None),
                Argument::Difference(u, v) => (2, vec![u, v], None),
                Argument::Bounded(u, bound) => (5 + bound as usize, vec![u], None),
                Argument::Power(u, exponent) => (
                    if exponent < 0 { 3 } else { 4 },
                    vec![u],
                    Some(exponent.unsigned_abs()),
                ),
            };
            self.number(kind);
            self.sequences(&parts);
            if let Some(degree) = degree {
                self.number(degree as usize);
            }
        }
        self.sequences(&self.plan.accelerations);
        self.number(motion.unknown.len());
        for &leaf in &motion.unknown {
            self.number(match leaf {
                Leaf::Lambda(i) => 2 * i + 1,
                Leaf::A(i) => 2 * i,
                // no other leaf is unknown
                _ => usize::from(u16::MAX),
            });
        }
        self.sequences(&self.plan.rows);
        self.number(motion.entries.len());
        for &[row, column] in &motion.entries {
            self.number(row);
            self.number(column);
            self.sequence(self.plan.jacobian[row * motion.unknown.len() + column]);
        }
        self.number(sequences.divisors().len());
        self.sequences(sequences.divisors());
    }

    /// All bytes: the numbers, then everything else.
    fn recurrences(&self) -> Vec<u8> {
        let mut bytes = vec![VERSION];
        number(&mut bytes, self.numbers.len());
        for value in &self.numbers {
            bytes.extend(value.to_le_bytes());
        }
        bytes.extend(&self.out);
        bytes
    }

    /// Writes an operation: its code, the lists that it is in, its operands, and its inner sums.
    fn operation(&mut self, to: Sequence, op: &Op) {
        let code = code(op);
        self.out.push(code);
        let lists = [
            &self.plan.beyond_order_0,
            &self.plan.accelerated,
            &self.plan.after_solve,
        ];
        let lists = lists.iter().enumerate();
        self.out
            .push(lists.map(|(bit, list)| u8::from(list.contains(&to)) << bit).sum());
        match op {
            Op::Leaf(Leaf::Q(i) | Leaf::V(i) | Leaf::A(i) | Leaf::Lambda(i)) => self.number(*i),
            Op::Leaf(_) => {}
            Op::Constant(constant) => self.factor(*constant),
            Op::Linear(constant, terms) => {
                self.number(usize::from(constant.is_some()));
                if let Some(constant) = constant {
                    self.factor(*constant);
                }
                self.number(terms.len());
                for &(coefficient, term) in terms {
                    self.factor(coefficient);
                    self.sequence(term);
                }
            }
            Op::Power(u, exponent) => {
                self.sequence(*u);
                self.factor(*exponent);
            }
            Op::Call { callee, args, wrt } => {
                let which = self.calls.function(*callee, args.len(), wrt);
                self.number(which);
                let place = self.plan.calls.iter().position(|&call| call == to);
                self.number(place.unwrap_or_default());
                self.number(args.len());
                self.sequences(args);
            }
            _ => self.sequences(&op.parts()),
        }
        match *op {
            Op::Abs(u) | Op::Signum(u) => self.switch(Argument::Sign(u)),
            Op::Select(_, [left, right, ..]) => self.switch(Argument::Difference(left, right)),
            _ => {}
        }
        if self.plan.beyond_order_0.contains(&to) {
            for sum in op.inner(to) {
                let lane = self.plan.sequences.lane(sum);
                self.number(match lane {
                    Some(Lane::Product(place)) => 2 * place,
                    Some(Lane::Square(place)) => 2 * place + 1,
                    // inner sums were added for sequences needed beyond order 0 only
                    None => 0,
                });
            }
        }
    }
}

/// The code of an operation.
fn code(op: &Op) -> u8 {
    match op {
        Op::Leaf(Leaf::T) => 0,
        Op::Leaf(Leaf::Q(_)) => 1,
        Op::Leaf(Leaf::V(_)) => 2,
        Op::Leaf(Leaf::A(_)) => 3,
        Op::Leaf(Leaf::Lambda(_)) => 4,
        // the continuous system has no other leaves
        Op::Leaf(_) => u8::MAX,
        Op::Constant(_) => 5,
        Op::Linear(..) => 6,
        Op::Product(..) => 7,
        Op::Square(_) => 8,
        Op::Quotient(..) => 9,
        Op::Reciprocal(_) => 10,
        Op::Root(_) => 11,
        Op::CubeRoot(_) => 12,
        Op::Power(..) => 13,
        Op::Exp(_) => 14,
        Op::ExpM1(_) => 15,
        Op::Ln(_) => 16,
        Op::Ln1p(_) => 17,
        Op::Sin(..) => 18,
        Op::Cos(..) => 19,
        Op::Sinh(..) => 20,
        Op::Cosh(..) => 21,
        Op::Tan(..) => 22,
        Op::Tanh(..) => 23,
        Op::Conjugate(..) => 24,
        Op::Inverse(Inverse::Asin, ..) => 25,
        Op::Inverse(Inverse::Acos, ..) => 26,
        Op::Inverse(Inverse::Atan, ..) => 27,
        Op::Inverse(Inverse::Asinh, ..) => 28,
        Op::Inverse(Inverse::Acosh, ..) => 29,
        Op::Inverse(Inverse::Atanh, ..) => 30,
        Op::Atan2(..) => 31,
        Op::Abs(_) => 32,
        Op::Signum(_) => 33,
        Op::Select(Comparison::Lt, _) => 34,
        Op::Select(Comparison::Le, _) => 35,
        Op::Call { .. } => 36,
    }
}
