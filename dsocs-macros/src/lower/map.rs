//! The discretization maps: closures of the nodes, whose values are vectors.

use proc_macro2::Ident;
use syn::{Expr, Pat, ReturnType};

use super::Lowering;
use crate::ast::Map;
use crate::errors::Reported;
use crate::graph::NodeId;
use crate::names::Binding;
use crate::parse::bare;

impl Lowering<'_> {
    /// The `K` vectors of a map: `q, v` of the first order map (of two nodes), `q, v, a` of the others (of three).
    pub(super) fn map<const K: usize>(&mut self, map: &Map) -> Result<[Vec<NodeId>; K], Reported> {
        let expected = if K == 2 {
            "|q0, q1| (q, v)"
        } else {
            "|q0, q1, q2| (q, v, a)"
        };
        let keyword = &map.keyword;
        let closure = &map.closure;
        let outer = self.scope.len();
        let mut wrong = None;
        if closure.inputs.len() != K {
            let message = format!(
                "expected {K} nodes, `{keyword} = {expected};`, found {}",
                closure.inputs.len()
            );
            wrong = Some(if closure.inputs.is_empty() {
                self.errors.at(keyword, message)
            } else {
                self.errors.at(&closure.inputs, message)
            });
        }
        if let ReturnType::Type(_, ty) = &closure.output {
            wrong = Some(self.errors.at(
                ty,
                "no type is written here: a map's values are vectors of numbers",
            ));
        }
        for (index, input) in closure.inputs.iter().enumerate() {
            match node_name(input) {
                Some(name) => {
                    let defined = self.scope.define(name, Binding::Node(index), self.errors);
                    wrong = defined.err().or(wrong);
                }
                None => wrong = Some(self.errors.at(input, "expected a plain name of a node")),
            }
        }
        // with another number of nodes the body would bring a second error for the same mistake
        let value = if let Some(reported) = wrong {
            Err(reported)
        } else {
            self.component = Some(0);
            self.vectors(&closure.body, keyword, expected)
        };
        self.component = None;
        self.scope.truncate(outer);
        value
    }

    /// `(q, v)` or `(q, v, a)`, perhaps at the end of a block.
    fn vectors<const K: usize>(
        &mut self,
        body: &Expr,
        keyword: &Ident,
        expected: &str,
    ) -> Result<[Vec<NodeId>; K], Reported> {
        match bare(body) {
            Expr::Block(block) if block.label.is_none() => self.block(&block.block, |lowering, last| {
                lowering.vectors(last, keyword, expected)
            }),
            Expr::Tuple(tuple) if tuple.elems.len() == K => {
                let vectors: Vec<_> = tuple.elems.iter().map(|element| self.vector(element)).collect();
                let vectors: Vec<_> = vectors.into_iter().collect::<Result<_, _>>()?;
                vectors.try_into().map_err(|_| {
                    self.errors
                        .at(tuple, format!("expected `{keyword} = {expected};`"))
                })
            }
            Expr::Tuple(tuple) => Err(self.errors.at(
                tuple,
                format!(
                    "expected {K} vectors, `{keyword} = {expected};`, found {}",
                    tuple.elems.len()
                ),
            )),
            other => Err(self.errors.at(
                other,
                format!("expected a tuple of {K} vectors, `{keyword} = {expected};`"),
            )),
        }
    }

    /// The components of a vector: an expression that holds for each of them, or a tuple of them.
    pub(super) fn vector(&mut self, expr: &Expr) -> Result<Vec<NodeId>, Reported> {
        let outer = self.component;
        let value = self.components(expr);
        self.component = outer;
        value
    }

    fn components(&mut self, expr: &Expr) -> Result<Vec<NodeId>, Reported> {
        match bare(expr) {
            Expr::Tuple(_) => self.entries(expr),
            // the list of a single array
            Expr::Array(_) | Expr::Repeat(_) | Expr::Closure(_) if self.groups.len() == 1 => {
                self.entries(expr)
            }
            Expr::Block(block) if block.label.is_none() => self.block(&block.block, Self::components),
            // a mistake in one component is a mistake in all of them: the first one ends it
            other => (0..self.coordinates.len())
                .map(|i| {
                    self.component = Some(i);
                    self.expr(other)
                })
                .collect(),
        }
    }
}

fn node_name(pattern: &Pat) -> Option<&Ident> {
    match pattern {
        Pat::Ident(name) if name.by_ref.is_none() && name.mutability.is_none() && name.subpat.is_none() => {
            Some(&name.ident)
        }
        _ => None,
    }
}
