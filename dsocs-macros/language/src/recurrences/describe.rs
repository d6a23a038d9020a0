//! An expression as text, for error messages.

use std::fmt::Write as _;

use proc_macro2::Ident;

use crate::graph::{Callee, Graph, Leaf, Node, NodeId};

/// The longest text, in characters; longer ones are cut.
const LONGEST: usize = 100;

/// An expression, approximately as the declaration has it.
pub(crate) fn describe(graph: &Graph, coordinates: &[Ident], id: NodeId) -> String {
    let text = text(graph, coordinates, id, false);
    match text.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text,
    }
}

/// The name of a function.
pub(crate) fn function(graph: &Graph, callee: usize) -> String {
    match graph.callee(callee) {
        Callee::Function(tokens) => short(&tokens.to_string()),
        Callee::Method(name) => name.to_string(),
    }
}

/// Tokens as one would write them, without `self.`.
fn short(tokens: &str) -> String {
    tokens.replace(' ', "").replace("self.", "")
}

/// The text of an expression; a sum that is a factor is in parentheses.
#[allow(clippy::float_cmp)] // a coefficient of one is not written
fn text(graph: &Graph, coordinates: &[Ident], id: NodeId, is_factor: bool) -> String {
    let part = |id: NodeId, is_factor: bool| text(graph, coordinates, id, is_factor);
    let coordinate = |i: usize| coordinates.get(i).map_or_else(String::new, ToString::to_string);
    match graph.node(id) {
        Node::Constant(value) => value.get().to_string(),
        Node::Leaf(leaf) => match leaf {
            Leaf::Q(i) => coordinate(*i),
            Leaf::V(i) => format!("dot({})", coordinate(*i)),
            Leaf::A(i) => format!("ddot({})", coordinate(*i)),
            Leaf::T => "t".to_owned(),
            _ => "a multiplier".to_owned(),
        },
        Node::Param(param) => short(&graph.param_tokens(*param).to_string()),
        Node::Sum(constant, terms) => {
            let mut sum = String::new();
            for (term, c) in terms {
                let c = c.get();
                let sign = match (sum.is_empty(), c < 0.0) {
                    (true, false) => "",
                    (true, true) => "-",
                    (false, false) => " + ",
                    (false, true) => " - ",
                };
                sum.push_str(sign);
                if c.abs() != 1.0 {
                    let _ = write!(sum, "{} * ", c.abs());
                }
                sum.push_str(&part(*term, true));
            }
            let constant = constant.get();
            if constant != 0.0 {
                let sign = if constant < 0.0 { '-' } else { '+' };
                let _ = write!(sum, " {sign} {}", constant.abs());
            }
            if is_factor && (terms.len() > 1 || constant != 0.0) {
                format!("({sum})")
            } else {
                sum
            }
        }
        Node::Product(factors) => {
            let side = |above: bool| {
                let factors = factors.iter().filter(|(_, n)| (*n > 0) == above);
                let factors = factors.map(|&(factor, n)| match n.unsigned_abs() {
                    1 => part(factor, true),
                    n => format!("{}.powi({n})", part(factor, true)),
                });
                factors.collect::<Vec<_>>()
            };
            let (above, below) = (side(true), side(false));
            let above = if above.is_empty() {
                "1".to_owned()
            } else {
                above.join(" * ")
            };
            match below.as_slice() {
                [] => above,
                [one] => format!("{above} / {one}"),
                more => format!("{above} / ({})", more.join(" * ")),
            }
        }
        Node::Unary(op, a) => format!("{}.{}()", part(*a, true), op.name()),
        Node::Powf(a, b) => format!("{}.powf({})", part(*a, true), part(*b, false)),
        Node::Atan2(y, x) => format!("{}.atan2({})", part(*y, true), part(*x, false)),
        Node::Select(..) => "(if …)".to_owned(),
        Node::Call { callee, .. } => format!("{}(…)", function(graph, *callee)),
    }
}
