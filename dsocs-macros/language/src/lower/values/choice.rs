//! Choices between numbers or vectors: `if a < b { … } else { … }`.

use quote::quote;
use syn::{BinOp, Expr, ExprIf, UnOp};

use crate::graph::{Comparison, NodeId};
use crate::lower::lowering::{Lowered, Lowering};
use crate::lower::values::{Value, Valued};
use crate::syntax::bare;

impl Lowering<'_> {
    /// `if condition { then } else { otherwise }`
    pub(crate) fn choice(&mut self, choice: &ExprIf) -> Valued {
        // only the branch taken is read, if the condition is one of indices:
        // `if i > 0 { theta[i - 1] } else { 0 }`
        match (self.known_condition(&choice.cond), &choice.else_branch) {
            (Some(true), Some(_)) => return self.block(&choice.then_branch, Self::value),
            (Some(false), Some((_, otherwise))) => return self.value(otherwise),
            _ => {}
        }
        let then = self.block(&choice.then_branch, Self::value);
        let otherwise = match &choice.else_branch {
            Some((_, otherwise)) => self.value(otherwise),
            None => Err(self.errors.at(
                choice.if_token,
                "expected `else`: the expression needs a value in both cases",
            )),
        };
        match (then, otherwise) {
            (Ok(then), Ok(otherwise)) => self.select_values(choice, &then, &otherwise),
            (Err(reported), _) | (_, Err(reported)) => Err(reported),
        }
    }

    /// A choice between values of the same shape, component by component.
    fn select_values(&mut self, choice: &ExprIf, then: &Value, otherwise: &Value) -> Valued {
        let others = otherwise.numbers();
        if then.kind() != otherwise.kind() {
            let message = format!(
                "expected the same in both cases of this choice, found {} and {}",
                then.kind(),
                otherwise.kind()
            );
            return Err(self.errors.at(choice.if_token, message));
        }
        let mut others = others.into_iter();
        then.map(|then| {
            let otherwise = others.next().unwrap_or(then);
            self.select(&choice.cond, then, otherwise)
        })
    }

    /// `if condition { then } else { otherwise }`, for numbers
    fn select(&mut self, condition: &Expr, then: NodeId, otherwise: NodeId) -> Lowered {
        match bare(condition) {
            Expr::Binary(binary) => {
                let (op, swapped) = match binary.op {
                    BinOp::Lt(_) => (Comparison::Lt, false),
                    BinOp::Le(_) => (Comparison::Le, false),
                    BinOp::Gt(_) => (Comparison::Lt, true),
                    BinOp::Ge(_) => (Comparison::Le, true),
                    BinOp::And(_) => {
                        let inner = self.select(&binary.right, then, otherwise)?;
                        return self.select(&binary.left, inner, otherwise);
                    }
                    BinOp::Or(_) => {
                        let inner = self.select(&binary.right, then, otherwise)?;
                        return self.select(&binary.left, then, inner);
                    }
                    _ => return self.flag(condition, then, otherwise),
                };
                let (left, right) = (self.expr(&binary.left), self.expr(&binary.right));
                let (left, right) = if swapped { (right?, left?) } else { (left?, right?) };
                Ok(self.graph.select(op, left, right, then, otherwise))
            }
            Expr::Unary(unary) if matches!(unary.op, UnOp::Not(_)) => {
                self.select(&unary.expr, otherwise, then)
            }
            other => self.flag(other, then, otherwise),
        }
    }

    /// A choice by a condition that the graph does not know, such as a field of type `bool`.
    fn flag(&mut self, condition: &Expr, then: NodeId, otherwise: NodeId) -> Lowered {
        let is_opaque = !matches!(condition, Expr::Let(_) | Expr::Lit(_)) && self.is_closed(condition);
        if !is_opaque {
            return Err(self.errors.at(
                condition,
                "expected a comparison of numbers by `<`, `<=`, `>` or `>=`",
            ));
        }
        let condition = self.closed(condition)?;
        let flag = self.graph.param(quote!(::core::primitive::f64::from(#condition)));
        let zero = self.graph.constant(0.0);
        Ok(self.graph.select(Comparison::Lt, zero, flag, then, otherwise))
    }
}
