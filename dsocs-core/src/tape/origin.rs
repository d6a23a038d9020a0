//! The origin of a number that is not finite: the first expression without a value, in the words of the
//! declaration.

use super::evaluate::function;
use super::link::gathered;
use super::read::{Binary, Comparison, Function, Op};
use super::{Leaf, Segment, Source};
use crate::number::scalar::Scalar;

/// An expression longer than this is shortened.
const LONG: usize = 90;

/// Largest depth of nested operations in a shortened expression.
const DEEP: usize = 9;

/// An expression of a declaration; of a number that is not finite, the one without a finite value whose operands are finite, or a divisor that is
/// zero.
pub(crate) struct Origin {
    /// The expression as in a declaration, shortened if it is long.
    pub(crate) text: String,
    /// Its value; of a number that is not finite, infinite, not a number, or zero for a divisor.
    pub(crate) value: f64,
    /// Its leaves with their values, each once.
    pub(crate) leaves: Vec<(Leaf, f64)>,
}

/// A segment with the values of its operations.
struct Evaluated<'n> {
    /// The operations of this segment and of those that it reads.
    ops: Vec<Op>,
    /// Their values.
    values: Vec<f64>,
    /// The places of the segment's results.
    results: Vec<usize>,
    /// The names of leaves.
    name: &'n dyn Fn(Leaf) -> String,
}

impl<'n> Evaluated<'n> {
    /// `None` if the tape has no such segment.
    fn new(
        source: &dyn Source,
        segment: Segment,
        leaf: &dyn Fn(Leaf) -> f64,
        name: &'n dyn Fn(Leaf) -> String,
    ) -> Option<Self> {
        let bodies = source.tape().bodies();
        let results = &bodies.get(segment as usize)?.results;
        let (ops, places) = gathered(bodies, segment, &[]);
        Some(Self {
            values: values(&ops, source, leaf),
            results: results.iter().map(|&result| places[result]).collect(),
            ops,
            name,
        })
    }

    /// The places that the results need, in order.
    fn needed(&self) -> impl Iterator<Item = usize> {
        let mut is_needed = vec![false; self.ops.len()];
        for &result in &self.results {
            is_needed[result] = true;
        }
        for place in (0..self.ops.len()).rev() {
            if is_needed[place] {
                for part in read(&self.ops[place], &self.values) {
                    is_needed[part] = true;
                }
            }
        }
        (0..self.ops.len()).filter(move |&place| is_needed[place])
    }

    /// The leaves that an operation reads, with their values, in textual order.
    fn leaves(&self, place: usize) -> Vec<(Leaf, f64)> {
        let mut leaves = Vec::new();
        collect(&self.ops, place, &self.values, &mut leaves);
        leaves
    }

    /// An operation as an expression.
    fn expression(&self, place: usize) -> Origin {
        Origin {
            text: shortened(&self.ops, place, self.name),
            value: self.values[place],
            leaves: self.leaves(place),
        }
    }
}

/// The origin of the first result of a segment that is not finite. If all results are finite, that of the
/// first intermediate number that is not, since it may make a derivative infinite. `None` if all numbers are
/// finite, or if a leaf is not.
pub(crate) fn origin(
    source: &dyn Source,
    segment: Segment,
    leaf: &dyn Fn(Leaf) -> f64,
    name: &dyn Fn(Leaf) -> String,
) -> Option<Origin> {
    let all = Evaluated::new(source, segment, leaf, name)?;
    let (ops, values) = (&all.ops, &all.values);
    let wrong = |place: &usize| !values[*place].is_finite();
    let mut place = match all.results.iter().copied().find(wrong) {
        Some(result) => result,
        None => all.needed().find(wrong)?,
    };
    // back to the first operation that is not finite
    while let Some(before) = read(&ops[place], values).find(|&part| !values[part].is_finite()) {
        place = before;
    }
    if matches!(ops[place], Op::Leaf(_) | Op::Number(_) | Op::Stored(..)) {
        return None;
    }
    // for a division by zero, report the divisor
    if let Op::Recip(divisor) | Op::Powi(divisor, _) | Op::Binary(Binary::Div, [_, divisor]) = ops[place]
        && values[divisor] == 0.0
    {
        place = divisor;
    }
    Some(all.expression(place))
}

/// The first expression in a segment that has a value and no derivative, such as the root of zero, and whose
/// argument depends on a position, a velocity or time. `None` if there is none.
pub(crate) fn without_derivative(
    source: &dyn Source,
    segment: Segment,
    leaf: &dyn Fn(Leaf) -> f64,
    name: &dyn Fn(Leaf) -> String,
) -> Option<Origin> {
    let all = Evaluated::new(source, segment, leaf, name)?;
    let values = &all.values;
    let has_none = |place: usize| match all.ops[place] {
        Op::Function(Function::Sqrt | Function::Cbrt, a) => values[a] == 0.0,
        Op::Function(Function::Asin | Function::Acos, a) => values[a].abs() >= 1.0,
        Op::Binary(Binary::Powf, [a, b]) => {
            values[a] == 0.0 && (0.0..1.0).contains(&values[b]) && values[b] > 0.0
        }
        _ => false,
    };
    let moves = |&(leaf, _): &(Leaf, f64)| matches!(leaf, Leaf::Q(_) | Leaf::V(_) | Leaf::T);
    let place = (all.needed()).find(|&place| has_none(place) && all.leaves(place).iter().any(moves))?;
    Some(all.expression(place))
}

/// A result of a segment, by its number.
pub(crate) fn result(
    source: &dyn Source,
    (segment, number): (Segment, usize),
    leaf: &dyn Fn(Leaf) -> f64,
    name: &dyn Fn(Leaf) -> String,
) -> Option<Origin> {
    let all = Evaluated::new(source, segment, leaf, name)?;
    Some(all.expression(*all.results.get(number)?))
}

/// The first exponential in a segment above a size, finite itself. `None` if there is none.
pub(crate) fn large(
    source: &dyn Source,
    segment: Segment,
    size: f64,
    leaf: &dyn Fn(Leaf) -> f64,
    name: &dyn Fn(Leaf) -> String,
) -> Option<Origin> {
    let all = Evaluated::new(source, segment, leaf, name)?;
    let is_large = |&place: &usize| {
        let value = all.values[place];
        let grows = matches!(
            all.ops[place],
            Op::Function(
                Function::Exp | Function::ExpM1 | Function::Sinh | Function::Cosh,
                _
            )
        );
        grows && value.is_finite() && value.abs() > size
    };
    let place = all.needed().find(is_large)?;
    Some(all.expression(place))
}

/// The arguments of sines, cosines and tangents in a segment that differ by more than `least` between two sets of leaves, with the difference as
/// value; none that depends on time.
pub(crate) fn turning(
    source: &dyn Source,
    segment: Segment,
    least: f64,
    [from, to]: [&dyn Fn(Leaf) -> f64; 2],
    name: &dyn Fn(Leaf) -> String,
) -> Vec<Origin> {
    let Some(after) = Evaluated::new(source, segment, to, name) else {
        return Vec::new();
    };
    let before = values(&after.ops, source, from);
    let arguments = after.needed().filter_map(|place| match after.ops[place] {
        Op::Function(Function::Sin | Function::Cos | Function::Tan, a) => Some(a),
        _ => None,
    });
    let depends_on_time = |&(leaf, _): &(Leaf, f64)| matches!(leaf, Leaf::T | Leaf::Clock);
    let turned = arguments.filter_map(|place| {
        let turn = (after.values[place] - before[place]).abs();
        let all = (turn > least).then(|| after.expression(place));
        all.map(|argument| Origin {
            value: turn,
            ..argument
        })
    });
    turned
        .filter(|argument| !argument.leaves.iter().any(depends_on_time))
        .collect()
}

/// An operation as text, shortened if it is long.
fn shortened(ops: &[Op], place: usize, name: &dyn Fn(Leaf) -> String) -> String {
    let text = (1..=DEEP).rev().map(|deep| written(ops, place, deep, name).0);
    let short = text.clone().find(|text| text.chars().count() <= LONG);
    short.or_else(|| text.last()).unwrap_or_default()
}

/// The operands that determine a value: of a comparison, the compared ones and the selected one.
fn read<'o>(op: &'o Op, values: &'o [f64]) -> impl Iterator<Item = usize> + 'o {
    let skipped = match op {
        Op::Select(comparison, [a, b, ..]) => {
            let holds = match comparison {
                Comparison::Less => values[*a] < values[*b],
                Comparison::LessOrEqual => values[*a] <= values[*b],
            };
            Some(if holds { 3 } else { 2 })
        }
        _ => None,
    };
    let parts = op.parts().iter().copied().enumerate();
    parts
        .filter(move |&(k, _)| Some(k) != skipped)
        .map(|(_, part)| part)
}

/// The values of all operations.
fn values(ops: &[Op], source: &dyn Source, leaf: &dyn Fn(Leaf) -> f64) -> Vec<f64> {
    let mut values: Vec<f64> = Vec::with_capacity(ops.len());
    for op in ops {
        let at = |place: usize| values[place];
        let value = match op {
            Op::Number(value) => *value,
            Op::Leaf(which) => leaf(*which),
            // replaced when segments are linked
            Op::Stored(..) => f64::NAN,
            Op::Neg(a) => -at(*a),
            Op::Recip(a) => at(*a).recip(),
            Op::Powi(a, power) => Scalar::powi(at(*a), *power),
            Op::Function(name, a) => function(*name, at(*a)),
            Op::Binary(binary, [a, b]) => {
                let (a, b) = (at(*a), at(*b));
                match binary {
                    Binary::Add => a + b,
                    Binary::Sub => a - b,
                    Binary::Mul => a * b,
                    Binary::Div => a / b,
                    Binary::Powf => a.powf(b),
                    Binary::Atan2 => a.atan2(b),
                }
            }
            Op::Select(comparison, [a, b, c, d]) => match comparison {
                Comparison::Less => f64::select_lt(at(*a), at(*b), at(*c), at(*d)),
                Comparison::LessOrEqual => f64::select_le(at(*a), at(*b), at(*c), at(*d)),
            },
            Op::Call(which, arguments) => {
                let arguments: Vec<f64> = arguments.iter().map(|&argument| at(argument)).collect();
                source.call(*which, &arguments)
            }
        };
        values.push(value);
    }
    values
}

/// The leaves that an operation reads, in textual order.
fn collect(ops: &[Op], place: usize, values: &[f64], leaves: &mut Vec<(Leaf, f64)>) {
    if let Op::Leaf(leaf) = ops[place]
        && !leaves.iter().any(|(known, _)| *known == leaf)
    {
        leaves.push((leaf, values[place]));
    }
    for &part in ops[place].parts() {
        collect(ops, part, values, leaves);
    }
}

/// The binding strength of an expression, for parentheses.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Precedence {
    Sum,
    Product,
    Sign,
    Atom,
}

/// An operation as text, with at most `deep` nested operations.
fn written(ops: &[Op], place: usize, deep: usize, name: &dyn Fn(Leaf) -> String) -> (String, Precedence) {
    let Some(deeper) = deep.checked_sub(1) else {
        return match &ops[place] {
            Op::Leaf(leaf) => (name(*leaf), Precedence::Atom),
            Op::Number(value) => (value.to_string(), Precedence::Atom),
            _ => ("…".to_owned(), Precedence::Atom),
        };
    };
    let part = |place: usize, least: Precedence| {
        let (text, tie) = written(ops, place, deeper, name);
        if tie < least { format!("({text})") } else { text }
    };
    let method = |a: usize, call: String| (format!("{}.{call}", part(a, Precedence::Atom)), Precedence::Atom);
    match &ops[place] {
        Op::Number(value) if *value < 0.0 => (value.to_string(), Precedence::Sign),
        Op::Number(value) => (value.to_string(), Precedence::Atom),
        Op::Leaf(leaf) => (name(*leaf), Precedence::Atom),
        Op::Stored(..) => ("…".to_owned(), Precedence::Atom),
        Op::Neg(a) => (format!("-{}", part(*a, Precedence::Sign)), Precedence::Sign),
        Op::Recip(a) => (format!("1 / {}", part(*a, Precedence::Sign)), Precedence::Product),
        Op::Powi(a, power) => method(*a, format!("powi({power})")),
        Op::Function(function, a) => method(*a, format!("{}()", method_of(*function))),
        Op::Binary(binary, [a, b]) => match binary {
            Binary::Add => (
                format!(
                    "{} + {}",
                    part(*a, Precedence::Sum),
                    part(*b, Precedence::Product)
                ),
                Precedence::Sum,
            ),
            Binary::Sub => (
                format!(
                    "{} - {}",
                    part(*a, Precedence::Sum),
                    part(*b, Precedence::Product)
                ),
                Precedence::Sum,
            ),
            Binary::Mul if a == b => method(*a, "powi(2)".to_owned()),
            Binary::Mul => (
                format!(
                    "{} * {}",
                    part(*a, Precedence::Product),
                    part(*b, Precedence::Sign)
                ),
                Precedence::Product,
            ),
            Binary::Div => (
                format!(
                    "{} / {}",
                    part(*a, Precedence::Product),
                    part(*b, Precedence::Sign)
                ),
                Precedence::Product,
            ),
            Binary::Powf => method(*a, format!("powf({})", part(*b, Precedence::Sum))),
            Binary::Atan2 => method(*a, format!("atan2({})", part(*b, Precedence::Sum))),
        },
        Op::Select(comparison, parts) => {
            let [a, b, c, d] = parts.map(|place| part(place, Precedence::Sum));
            let than = match comparison {
                Comparison::Less => "<",
                Comparison::LessOrEqual => "<=",
            };
            (
                format!("(if {a} {than} {b} {{ {c} }} else {{ {d} }})"),
                Precedence::Atom,
            )
        }
        Op::Call(_, arguments) => {
            let arguments: Vec<_> = arguments
                .iter()
                .map(|&place| part(place, Precedence::Sum))
                .collect();
            (
                format!("a function of your own at ({})", arguments.join(", ")),
                Precedence::Atom,
            )
        }
    }
}

/// The name of the method of `f64`.
fn method_of(function: Function) -> &'static str {
    match function {
        Function::Sqrt => "sqrt",
        Function::Cbrt => "cbrt",
        Function::Exp => "exp",
        Function::ExpM1 => "exp_m1",
        Function::Ln => "ln",
        Function::Ln1p => "ln_1p",
        Function::Sin => "sin",
        Function::Cos => "cos",
        Function::Tan => "tan",
        Function::Asin => "asin",
        Function::Acos => "acos",
        Function::Atan => "atan",
        Function::Sinh => "sinh",
        Function::Cosh => "cosh",
        Function::Tanh => "tanh",
        Function::Asinh => "asinh",
        Function::Acosh => "acosh",
        Function::Atanh => "atanh",
        Function::Abs => "abs",
        Function::Signum => "signum",
    }
}
