//! `let name = …;`

use proc_macro2::Ident;
use syn::{Attribute, Expr, Local, Pat};

use crate::mistakes::errors::{Errors, Reported};
use crate::syntax::ast::{Declaration, Let};
use crate::syntax::doc;

/// Reads a `let` of the declaration.
pub(super) fn read_let(
    declaration: &mut Declaration,
    local: Local,
    attributes: &[Attribute],
    errors: &Errors,
) {
    let name = match &local.pat {
        Pat::Ident(pattern) => Some(pattern.ident.clone()),
        Pat::Type(typed) => match &*typed.pat {
            Pat::Ident(pattern) => Some(pattern.ident.clone()),
            _ => None,
        },
        _ => None,
    };
    let value = plain_let(local, errors).map(|(_, value)| value);
    if let Some(name) = name {
        let doc = doc(attributes);
        declaration.lets.push(Let {
            name,
            value,
            doc,
            shared: false,
        });
    }
}

/// The parts of a `let` with a plain name.
pub(crate) fn plain_let(local: Local, errors: &Errors) -> Result<(Ident, Expr), Reported> {
    let name = match &local.pat {
        Pat::Ident(pattern)
            if pattern.by_ref.is_none() && pattern.mutability.is_none() && pattern.subpat.is_none() =>
        {
            Ok(pattern.ident.clone())
        }
        Pat::Type(typed) => {
            Err(errors.at(&typed.ty, "no type is written here: every expression is a number"))
        }
        Pat::TupleStruct(function) => {
            let name = &function.path;
            let name = quote::ToTokens::to_token_stream(name);
            Err(errors.at(function, format!("a function is written `let {name} = |x| …;`")))
        }
        other => Err(errors.at(other, "expected a plain name, as in `let name = …;`")),
    };
    match local.init {
        Some(init) => match init.diverge {
            Some((otherwise, _)) => Err(errors.at(
                otherwise,
                "`let … else` has no meaning here: there is nothing to match",
            )),
            None => Ok((name?, *init.expr)),
        },
        None => Err(errors.at(&local.pat, "expected a value, as in `let name = …;`")),
    }
}
