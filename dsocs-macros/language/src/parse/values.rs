//! The values of statements, behind the `=`: rows, maps, fields, factors, names, a path.

use proc_macro2::Ident;
use syn::{Expr, Path};

use super::each;
use crate::mistakes::errors::{Errors, Reported};
use crate::mistakes::nearest::did_you_mean;
use crate::syntax::ast::{Entry, MapRule};
use crate::syntax::{bare, plain_name};

/// The rows of a constraint statement.
pub(super) fn read_rows(keyword: &Ident, value: Expr, errors: &Errors) -> Result<Vec<Entry>, Reported> {
    match value {
        Expr::Array(array) if array.elems.is_empty() => Err(errors.at(
            array,
            "expected at least one constraint; without any, leave the statement out",
        )),
        Expr::Array(array) => each::entries(array.elems, errors),
        Expr::Tuple(tuple) => Err(errors.at(
            tuple,
            format!("expected several constraints in brackets, `{keyword} = [c1, c2];`"),
        )),
        row => each::entries([row], errors),
    }
}

/// A map by its name or by a formula.
pub(super) fn read_map(keyword: &Ident, value: Expr, errors: &Errors) -> Result<MapRule, Reported> {
    let of_pairs = keyword == "phi_lagrangian";
    let (example, names): (_, &[&str]) = if of_pairs {
        ("|q0, q1| (q, v)", &["paper", "midpoint", "trapezoid"])
    } else {
        ("|q0, q1, q2| (q, v, a)", &["paper", "midpoint"])
    };
    // also in parentheses, or in the group that a macro by example makes
    let name = match bare(&value) {
        Expr::Closure(closure) => return Ok(MapRule::Closure(Box::new(closure.clone()))),
        other => plain_name(other).map(ToString::to_string),
    };
    match name.as_deref() {
        Some("paper") => return Ok(MapRule::Paper),
        Some("midpoint") => return Ok(MapRule::Midpoint),
        Some("trapezoid") if of_pairs => return Ok(MapRule::Trapezoid),
        Some("trapezoid") => {
            return Err(errors.at(
                value,
                format!(
                    "the trapezoid is a mean of two points, which `phi_lagrangian` alone can be; expected `paper`, `midpoint` or a {}",
                    errors.words("closure", "formula")
                ),
            ));
        }
        _ => {}
    }
    let hint = did_you_mean(name.as_deref().unwrap_or(""), names.iter().copied());
    let names: Vec<_> = names.iter().map(|name| format!("`{name}`")).collect();
    let names = names.join(", ");
    Err(errors.at(
        value,
        format!(
            "expected {names} or a {}, `{keyword} = {example};`{hint}",
            errors.words("closure", "formula")
        ),
    ))
}

/// The path of `dsocs-core`.
pub(super) fn read_path(value: Expr, errors: &Errors) -> Result<Path, Reported> {
    match value {
        Expr::Path(value) if value.qself.is_none() => Ok(value.path),
        other => Err(errors.at(
            other,
            "expected the path of dsocs-core, such as `crate = prelude::dsocs_core;`",
        )),
    }
}

pub(super) fn read_fields(keyword: &Ident, value: Expr, errors: &Errors) -> Result<Vec<Entry>, Reported> {
    if each::is_each(&value) {
        return each::entries([value], errors);
    }
    let Expr::Array(array) = value else {
        let rule = if keyword == "variational" {
            ", or `chetaev`"
        } else {
            ""
        };
        let what = errors.words("tuples", "components in parentheses");
        return Err(errors.at(
            value,
            format!("expected a list of {what} in brackets, `{keyword} = [(…, …)];`{rule}"),
        ));
    };
    each::entries(array.elems, errors)
}

pub(super) fn read_factor(entry: Entry, errors: &Errors) -> Result<Option<Entry>, Reported> {
    const EXPECTED: &str = "expected `divide(factor)`, or `_` for a row of a list that is left as it is";
    match entry.value {
        Expr::Infer(_) => Ok(None),
        Expr::Call(call) => match plain_name(&call.func) {
            Some(name) if name == "divide" => match call.args.first() {
                Some(factor) if call.args.len() == 1 => Ok(Some(Entry {
                    value: factor.clone(),
                    indices: entry.indices,
                    group: entry.group,
                })),
                _ => Err(errors.at(
                    &call,
                    format!("expected one factor, `divide(factor)`, found {}", call.args.len()),
                )),
            },
            Some(name) => {
                let hint = did_you_mean(&name.to_string(), ["divide"]);
                let message = if hint.is_empty() {
                    EXPECTED.to_owned()
                } else {
                    format!("nothing is called `{name}` here{hint}")
                };
                Err(errors.at(name, message))
            }
            None => Err(errors.at(call, EXPECTED)),
        },
        other => Err(errors.at(other, EXPECTED)),
    }
}

pub(super) fn read_names(value: Expr, errors: &Errors) -> Result<Vec<Result<Ident, Reported>>, Reported> {
    let Expr::Array(array) = value else {
        return Err(errors.at(
            value,
            "expected a list of names in brackets, `observe = [height, momentum];`",
        ));
    };
    let names = array.elems.iter().map(|element| {
        plain_name(element).cloned().ok_or_else(|| {
            errors.at(
                element,
                "expected the name of a `let`: give the expression a name first",
            )
        })
    });
    Ok(names.collect())
}
