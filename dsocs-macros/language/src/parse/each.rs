//! `each(0..16, |i| e)` in a list: one entry for every index.

use proc_macro2::Ident;
use syn::{BinOp, Expr, ExprCall, ExprClosure, ExprRange, Lit, Pat, RangeLimits, ReturnType, UnOp};

use crate::ast::{Entry, Index};
use crate::errors::{Errors, Reported};
use crate::syntax::{bare, plain_name};

/// The most entries into which a list may expand.
const MOST: usize = 10_000;

/// The entries of a list's elements.
pub(crate) fn entries(
    elements: impl IntoIterator<Item = Expr>,
    errors: &Errors,
) -> Result<Vec<Entry>, Reported> {
    let mut entries = Vec::new();
    let mut wrong = Ok(());
    for (group, element) in elements.into_iter().enumerate() {
        let written = write_out(&element, group, &[], &mut entries, errors);
        wrong = wrong.and(written);
    }
    wrong.map(|()| entries)
}

/// Adds the entries of an element: itself, or one for every index.
fn write_out(
    element: &Expr,
    group: usize,
    outer: &[Index],
    entries: &mut Vec<Entry>,
    errors: &Errors,
) -> Result<(), Reported> {
    let Some(call) = each_call(element) else {
        if entries.len() == MOST {
            return Err(errors.at(
                element,
                format!("written out, the list has more than {MOST} entries"),
            ));
        }
        entries.push(Entry {
            value: element.clone(),
            indices: outer.to_vec(),
            group,
        });
        return Ok(());
    };
    let arguments: Vec<_> = call.args.iter().map(bare).collect();
    let (range, closure, name) = match arguments.as_slice() {
        [range, Expr::Closure(closure)] => match parameter(closure) {
            Some(name) => (*range, closure, name),
            None => return Err(errors.at(call, expected_form(errors))),
        },
        _ => return Err(errors.at(call, expected_form(errors))),
    };
    if let ReturnType::Type(_, ty) = &closure.output {
        return Err(errors.at(ty, "no type is written here: every expression is a number"));
    }
    let before = entries.len();
    for value in integers(range, outer, errors)? {
        let mut indices = outer.to_vec();
        indices.push(Index {
            name: name.clone(),
            value,
        });
        write_out(&closure.body, group, &indices, entries, errors)?;
    }
    if entries.len() == before && outer.is_empty() {
        return Err(errors.at(range, "expected at least one index in the range"));
    }
    Ok(())
}

/// The error for a call of `each` in another form.
fn expected_form(errors: &Errors) -> &'static str {
    errors.words(
        "expected a range and a closure of its index, `each(0..8, |i| …)`",
        "expected a range and what stands for each index, `each(0..8, |i| …)`",
    )
}

/// The call of `each`, if an expression is one.
fn each_call(expr: &Expr) -> Option<&ExprCall> {
    match bare(expr) {
        Expr::Call(call) if plain_name(&call.func).is_some_and(|name| name == "each") => Some(call),
        _ => None,
    }
}

/// Whether an expression is a call of `each`.
pub(super) fn is_each(expr: &Expr) -> bool {
    each_call(expr).is_some()
}

/// The parameter of a closure with one plain parameter.
fn parameter(closure: &ExprClosure) -> Option<&Ident> {
    match closure.inputs.first() {
        Some(Pat::Ident(name))
            if closure.inputs.len() == 1
                && name.by_ref.is_none()
                && name.mutability.is_none()
                && name.subpat.is_none() =>
        {
            Some(&name.ident)
        }
        _ => None,
    }
}

/// The integers of `0..8` or `0..=i`.
fn integers(expr: &Expr, indices: &[Index], errors: &Errors) -> Result<core::ops::Range<i64>, Reported> {
    let Expr::Range(ExprRange {
        start: Some(start),
        end: Some(end),
        limits,
        ..
    }) = expr
    else {
        return Err(errors.at(expr, "expected a range with both ends, such as `0..8` or `0..=i`"));
    };
    let known = |expr: &Expr| {
        integer(expr, indices).ok_or_else(|| {
            let message = errors.words(
                "expected an integer of literals and outer indices: how many rows there are is known before anything else",
                "expected a whole number of constants, `const n = 3;`, and outer indices: how many rows there are is known before anything else",
            );
            errors.at(expr, message)
        })
    };
    let (first, last) = (known(start), known(end));
    let (first, last) = (first?, last?);
    Ok(match limits {
        RangeLimits::HalfOpen(_) => first..last,
        RangeLimits::Closed(_) => first..last.saturating_add(1),
    })
}

/// The value of an integer expression of literals and indices.
fn integer(expr: &Expr, indices: &[Index]) -> Option<i64> {
    match bare(expr) {
        Expr::Lit(literal) => match &literal.lit {
            Lit::Int(digits) => digits.base10_parse().ok(),
            _ => None,
        },
        Expr::Path(_) => {
            let name = plain_name(bare(expr))?;
            let index = indices.iter().rev().find(|index| index.name == *name)?;
            Some(index.value)
        }
        Expr::Unary(unary) if matches!(unary.op, UnOp::Neg(_)) => {
            integer(&unary.expr, indices)?.checked_neg()
        }
        Expr::Binary(binary) => {
            let (left, right) = (integer(&binary.left, indices)?, integer(&binary.right, indices)?);
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
