//! Helpers for Rust's syntax: plain names, expressions without parentheses, documentation.

pub(crate) mod ast;
pub(crate) mod input;
pub(crate) mod layout;
pub(crate) mod shared;

use std::ops::Range;

use proc_macro2::Ident;
use syn::{Attribute, BinOp, Expr, ExprRange, Lit, Meta, Pat, RangeLimits, UnOp};

use crate::mistakes::errors::{Errors, Reported};

/// The name, if an expression is a plain one.
pub(crate) fn plain_name(expr: &Expr) -> Option<&Ident> {
    match expr {
        Expr::Path(path) if path.qself.is_none() => path.path.get_ident(),
        _ => None,
    }
}

/// An expression without the parentheses around it.
pub(crate) fn bare(expr: &Expr) -> &Expr {
    match expr {
        Expr::Paren(inner) => bare(&inner.expr),
        Expr::Group(inner) => bare(&inner.expr),
        other => other,
    }
}

/// The parameter of a closure, if it is a plain name.
pub(crate) fn plain_parameter(pattern: &Pat) -> Option<&Ident> {
    match pattern {
        Pat::Ident(name) if name.by_ref.is_none() && name.mutability.is_none() && name.subpat.is_none() => {
            Some(&name.ident)
        }
        _ => None,
    }
}

/// The value of an integer expression of literals and names, given the values of names; `None` for other
/// expressions.
pub(crate) fn integer(expr: &Expr, value_of: &dyn Fn(&Expr) -> Option<i64>) -> Option<i64> {
    match bare(expr) {
        Expr::Lit(literal) => match &literal.lit {
            Lit::Int(digits) if matches!(digits.suffix(), "" | "usize" | "i32") => digits.base10_parse().ok(),
            _ => None,
        },
        path @ Expr::Path(_) => value_of(path),
        Expr::Unary(unary) if matches!(unary.op, UnOp::Neg(_)) => {
            integer(&unary.expr, value_of)?.checked_neg()
        }
        Expr::Binary(binary) => {
            let (left, right) = (
                integer(&binary.left, value_of)?,
                integer(&binary.right, value_of)?,
            );
            match binary.op {
                BinOp::Add(_) => left.checked_add(right),
                BinOp::Sub(_) => left.checked_sub(right),
                BinOp::Mul(_) => left.checked_mul(right),
                BinOp::Div(_) => left.checked_div(right),
                BinOp::Rem(_) => left.checked_rem(right),
                _ => None,
            }
        }
        _ => None,
    }
}

/// The integers of a range, `0..8` or `0..=i`, given those of its ends.
pub(crate) fn range_of(
    expr: &Expr,
    known: impl Fn(&Expr) -> Result<i64, Reported>,
    errors: &Errors,
) -> Result<Range<i64>, Reported> {
    let Expr::Range(ExprRange {
        start: Some(start),
        end: Some(end),
        limits,
        ..
    }) = expr
    else {
        return Err(errors.at(expr, "expected a range with both ends, such as `0..8` or `0..=i`"));
    };
    let (first, last) = (known(start), known(end));
    let (first, last) = (first?, last?);
    Ok(match limits {
        RangeLimits::HalfOpen(_) => first..last,
        RangeLimits::Closed(_) => first..last.saturating_add(1),
    })
}

/// The documentation of an item in one line.
pub(crate) fn doc(attributes: &[Attribute]) -> String {
    let lines: Vec<_> = lines(attributes).filter(|line| !line.is_empty()).collect();
    lines.join(" ")
}

/// The first paragraph of an item's documentation in one line.
pub(crate) fn first_paragraph(attributes: &[Attribute]) -> String {
    let lines = lines(attributes).skip_while(String::is_empty);
    let lines: Vec<_> = lines.take_while(|line| !line.is_empty()).collect();
    lines.join(" ")
}

/// The lines of an item's documentation.
fn lines(attributes: &[Attribute]) -> impl Iterator<Item = String> {
    attributes
        .iter()
        .filter(|attribute| attribute.path().is_ident("doc"))
        .filter_map(|attribute| match &attribute.meta {
            Meta::NameValue(pair) => match &pair.value {
                Expr::Lit(literal) => match &literal.lit {
                    Lit::Str(text) => Some(text.value().trim().to_owned()),
                    _ => None,
                },
                _ => None,
            },
            _ => None,
        })
}
