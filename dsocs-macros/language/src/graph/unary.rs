//! The functions of one argument, each a line of one table.
//!
//! A new function also needs a recurrence in [`crate::recurrences`] (the compiler requires it) and a code in `dsocs_core::tape`. If its
//! change can be formed without cancellation, [`difference`](Graph::difference) has a rule for it.

use super::{Graph, NodeId};

/// The derivative at `x`, where the function has the value `f`: from the nodes of both.
type Derivative = fn(&mut Graph, NodeId, NodeId) -> NodeId;

macro_rules! functions {
    ($($function:ident: $name:literal, $value:expr, $derivative:expr;)*) => {
        /// A function of one argument, by its number in the tape's format.
        #[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
        pub(crate) enum Unary {
            $($function),*
        }

        impl Unary {
            /// All functions.
            pub(crate) const ALL: &[Self] = &[$(Self::$function),*];

            /// The function's line of the table.
            fn line(self) -> (&'static str, fn(f64) -> f64, Derivative) {
                match self {
                    $(Self::$function => ($name, $value, $derivative)),*
                }
            }
        }
    };
}

// The name of the method of `f64` and of the core's `Scalar`, the value, and the derivative. `dsocs_core::tape`
// reads the functions in this order.
functions! {
    Sqrt: "sqrt", f64::sqrt, |g, _, f| over(g, 0.5, f);
    Cbrt: "cbrt", f64::cbrt, |g, _, f| { let inverse = g.powi(f, -2); g.scale(1.0 / 3.0, inverse) };
    Exp: "exp", f64::exp, |_, _, f| f;
    ExpM1: "exp_m1", f64::exp_m1, |g, _, f| one_plus(g, f);
    Ln: "ln", f64::ln, |g, x, _| g.recip(x);
    Ln1p: "ln_1p", f64::ln_1p, |g, x, _| { let sum = one_plus(g, x); g.recip(sum) };
    Sin: "sin", f64::sin, |g, x, _| g.unary(Unary::Cos, x);
    Cos: "cos", f64::cos, |g, x, _| { let sine = g.unary(Unary::Sin, x); g.neg(sine) };
    Tan: "tan", f64::tan, |g, _, f| one_plus_square(g, f);
    Asin: "asin", f64::asin, |g, x, _| { let square = one_minus_square(g, x); over_root(g, 1.0, square) };
    Acos: "acos", f64::acos, |g, x, _| { let square = one_minus_square(g, x); over_root(g, -1.0, square) };
    Atan: "atan", f64::atan, |g, x, _| { let sum = one_plus_square(g, x); g.recip(sum) };
    Sinh: "sinh", f64::sinh, |g, x, _| g.unary(Unary::Cosh, x);
    Cosh: "cosh", f64::cosh, |g, x, _| g.unary(Unary::Sinh, x);
    Tanh: "tanh", f64::tanh, |g, _, f| one_minus_square(g, f);
    Asinh: "asinh", f64::asinh, |g, x, _| { let sum = one_plus_square(g, x); over_root(g, 1.0, sum) };
    Acosh: "acosh", f64::acosh, |g, x, _| { let square = one_minus_square(g, x); let square = g.neg(square); over_root(g, 1.0, square) };
    Atanh: "atanh", f64::atanh, |g, x, _| { let square = one_minus_square(g, x); g.recip(square) };
    Abs: "abs", f64::abs, |g, x, _| g.unary(Unary::Signum, x);
    Signum: "signum", f64::signum, |g, _, _| g.constant(0.0);
}

impl Unary {
    /// The name of the method of `f64` and of the core's `Scalar`.
    pub(crate) fn name(self) -> &'static str {
        self.line().0
    }

    /// The function of a name.
    pub(crate) fn named(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|function| function.name() == name)
    }

    /// The function's value.
    pub(crate) fn apply(self, x: f64) -> f64 {
        self.line().1(x)
    }

    /// The derivative at `x`, where the function has the value `f`.
    pub(super) fn derivative(self, graph: &mut Graph, x: NodeId, f: NodeId) -> NodeId {
        self.line().2(graph, x, f)
    }
}

fn one_plus(graph: &mut Graph, x: NodeId) -> NodeId {
    graph.linear(1.0, &[(x, 1.0)])
}

fn one_plus_square(graph: &mut Graph, x: NodeId) -> NodeId {
    let square = graph.powi(x, 2);
    one_plus(graph, square)
}

/// `(1 - x)(1 + x)`, which keeps the digits that `1 - x²` loses near `|x| = 1`.
fn one_minus_square(graph: &mut Graph, x: NodeId) -> NodeId {
    let (minus, plus) = (graph.linear(1.0, &[(x, -1.0)]), one_plus(graph, x));
    graph.mul(minus, plus)
}

/// `c/x`.
fn over(graph: &mut Graph, c: f64, x: NodeId) -> NodeId {
    let inverse = graph.recip(x);
    graph.scale(c, inverse)
}

/// `c/√square`.
fn over_root(graph: &mut Graph, c: f64, square: NodeId) -> NodeId {
    let root = graph.unary(Unary::Sqrt, square);
    over(graph, c, root)
}
