//! The functions of `f64` that the expression graph knows.

use std::f64::consts::{LN_2, LN_10, PI};

use proc_macro2::Ident;
use syn::Expr;

use crate::graph::{Comparison, Graph, NodeId, Unary};
use crate::lower::lowering::{Lowered, Lowering};
use crate::lower::values::Value;
use crate::mistakes::errors::Reported;

/// A function of `f64`, called as a method.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Builtin {
    /// A function of the graph.
    Unary(Unary),
    /// A function of the receiver alone.
    One(fn(&mut Graph, NodeId) -> NodeId),
    /// A function of the receiver and one argument.
    Two(fn(&mut Graph, NodeId, NodeId) -> NodeId),
    /// A function of the receiver and two arguments.
    Three(fn(&mut Graph, NodeId, NodeId, NodeId) -> NodeId),
    /// `powi`, whose argument is an integer literal.
    Powi,
}

/// The functions that are composed of other functions, by name.
const COMPOSED: [(&str, Builtin); 14] = [
    ("exp2", Builtin::One(exp2)),
    ("log10", Builtin::One(|g, x| ln_over(g, x, LN_10))),
    ("log2", Builtin::One(|g, x| ln_over(g, x, LN_2))),
    ("recip", Builtin::One(recip)),
    ("to_radians", Builtin::One(|g, x| scale(g, x, PI / 180.0))),
    ("to_degrees", Builtin::One(|g, x| scale(g, x, 180.0 / PI))),
    ("log", Builtin::Two(log)),
    ("powf", Builtin::Two(Graph::powf)),
    ("atan2", Builtin::Two(Graph::atan2)),
    ("hypot", Builtin::Two(hypot)),
    (
        "min",
        Builtin::Two(|g, x, y| g.select(Comparison::Lt, x, y, x, y)),
    ),
    (
        "max",
        Builtin::Two(|g, x, y| g.select(Comparison::Lt, x, y, y, x)),
    ),
    ("mul_add", Builtin::Three(mul_add)),
    ("powi", Builtin::Powi),
];

/// Methods of `f64` that have no useful derivative, or no number as a result.
const NOT_SUPPORTED: [&str; 21] = [
    "floor",
    "ceil",
    "round",
    "round_ties_even",
    "trunc",
    "fract",
    "rem_euclid",
    "div_euclid",
    "copysign",
    "clamp",
    "sin_cos",
    "is_nan",
    "is_finite",
    "is_infinite",
    "is_sign_negative",
    "is_sign_positive",
    "total_cmp",
    "partial_cmp",
    "to_bits",
    "next_up",
    "next_down",
];

impl Builtin {
    /// The function of a name.
    pub(crate) fn find(name: &str) -> Option<Self> {
        let composed = || {
            let known = COMPOSED.iter().find(|(known, _)| *known == name);
            known.map(|(_, builtin)| *builtin)
        };
        Unary::named(name).map(Self::Unary).or_else(composed)
    }

    /// The names of all functions.
    pub(crate) fn names() -> impl Iterator<Item = &'static str> {
        let composed = COMPOSED.iter().map(|(name, _)| *name);
        Unary::ALL.iter().map(|function| function.name()).chain(composed)
    }

    /// Whether it is a function of the receiver alone.
    pub(crate) fn is_of_one(self) -> bool {
        self.arguments() == 0
    }

    /// The number of arguments beside the receiver.
    fn arguments(self) -> usize {
        match self {
            Self::Unary(_) | Self::One(_) => 0,
            Self::Two(_) | Self::Powi => 1,
            Self::Three(_) => 2,
        }
    }
}

/// Whether this is a method of `f64` that expressions may not contain.
pub(crate) fn is_not_supported(name: &str) -> bool {
    NOT_SUPPORTED.contains(&name)
}

impl Lowering<'_> {
    /// The value of a call of a builtin function.
    pub(crate) fn builtin(
        &mut self,
        builtin: Builtin,
        name: &Ident,
        receiver: &Expr,
        arguments: &[&Expr],
    ) -> Lowered {
        let value = match self.value(receiver) {
            Ok(Value::Number(value)) => Ok(value),
            Ok(other) => Err(self.no_method_of_vectors(name, &other)),
            Err(reported) => Err(reported),
        };
        if arguments.len() != builtin.arguments() {
            let expected = match builtin.arguments() {
                0 => "no argument".to_owned(),
                1 => "1 argument".to_owned(),
                more => format!("{more} arguments"),
            };
            return Err(self.errors.at(
                name,
                format!(
                    "expected {expected} in the parentheses of `{name}`, found {}",
                    arguments.len()
                ),
            ));
        }
        if let Builtin::Powi = builtin {
            let exponent = self.exponent(arguments[0]);
            return Ok(self.graph.powi(value?, exponent?));
        }
        let arguments: Vec<_> = arguments.iter().map(|argument| self.expr(argument)).collect();
        let value = value?;
        let arguments: Vec<_> = arguments.into_iter().collect::<Result<_, _>>()?;
        match (builtin, arguments.as_slice()) {
            (Builtin::Unary(function), []) => Ok(self.graph.unary(function, value)),
            (Builtin::One(function), []) => Ok(function(&mut self.graph, value)),
            (Builtin::Two(function), &[a]) => Ok(function(&mut self.graph, value, a)),
            (Builtin::Three(function), &[a, b]) => Ok(function(&mut self.graph, value, a, b)),
            _ => Err(self.errors.at(name, "wrong number of arguments")),
        }
    }

    fn exponent(&self, argument: &Expr) -> Result<i32, Reported> {
        let known: Option<i32> = self.integer(argument).and_then(|value| value.try_into().ok());
        known
            .filter(|exponent| exponent.unsigned_abs() <= LARGEST_EXPONENT)
            .ok_or_else(|| {
                let message = self.errors.words(
                    "expected an integer literal of at most 10000 as the exponent of `powi`; any other exponent is for `powf`",
                    "expected a whole number of at most 10000 as the exponent of `powi`; any other exponent is for `powf`, as in `x.powf(0.5)`",
                );
                self.errors.at(argument, message)
            })
    }
}

/// The largest exponent of an integer power, whose derivatives are written out as products.
const LARGEST_EXPONENT: u32 = 10_000;

fn exp2(g: &mut Graph, x: NodeId) -> NodeId {
    let two = g.constant(2.0);
    g.powf(two, x)
}

fn ln_over(g: &mut Graph, x: NodeId, denominator: f64) -> NodeId {
    let ln = g.unary(Unary::Ln, x);
    let denominator = g.constant(denominator);
    g.div(ln, denominator)
}

fn log(g: &mut Graph, x: NodeId, base: NodeId) -> NodeId {
    let ln = g.unary(Unary::Ln, x);
    let base = g.unary(Unary::Ln, base);
    g.div(ln, base)
}

fn recip(g: &mut Graph, x: NodeId) -> NodeId {
    let one = g.constant(1.0);
    g.div(one, x)
}

fn scale(g: &mut Graph, x: NodeId, factor: f64) -> NodeId {
    let factor = g.constant(factor);
    g.mul(factor, x)
}

fn hypot(g: &mut Graph, x: NodeId, y: NodeId) -> NodeId {
    let squares = [g.powi(x, 2), g.powi(y, 2)];
    let sum = g.add(squares[0], squares[1]);
    g.unary(Unary::Sqrt, sum)
}

fn mul_add(g: &mut Graph, x: NodeId, a: NodeId, b: NodeId) -> NodeId {
    let product = g.mul(x, a);
    g.add(product, b)
}
