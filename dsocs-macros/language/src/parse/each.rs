//! `each(0..16, |i| e)` in a list: one entry for every index.

use syn::{Expr, ExprCall, ReturnType};

use crate::mistakes::errors::{Errors, Reported};
use crate::syntax::ast::{Entry, Index};
use crate::syntax::{bare, integer, plain_name, plain_parameter, range_of};

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
        [range, Expr::Closure(closure)] => match (
            closure.inputs.first().and_then(plain_parameter),
            closure.inputs.len(),
        ) {
            (Some(name), 1) => (*range, closure, name),
            _ => return Err(errors.at(call, expected_form(errors))),
        },
        _ => return Err(errors.at(call, expected_form(errors))),
    };
    if let ReturnType::Type(_, ty) = &closure.output {
        return Err(errors.at(ty, "no type is written here: every expression is a number"));
    }
    let before = entries.len();
    for value in range_of(range, |end| whole_number(end, outer, errors), errors)? {
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

/// The value of an integer expression of literals and indices.
fn whole_number(expr: &Expr, indices: &[Index], errors: &Errors) -> Result<i64, Reported> {
    let index = |path: &Expr| {
        let name = plain_name(path)?;
        let mut indices = indices.iter().rev();
        indices.find(|index| index.name == *name).map(|index| index.value)
    };
    integer(expr, &index).ok_or_else(|| {
        let message = errors.words(
            "expected an integer of literals and outer indices: how many rows there are is known before anything else",
            "expected a whole number of constants, `const n = 3;`, and outer indices: how many rows there are is known before anything else",
        );
        errors.at(expr, message)
    })
}
