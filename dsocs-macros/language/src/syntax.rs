//! Helpers for Rust's syntax: plain names, expressions without parentheses, documentation.

use proc_macro2::Ident;
use syn::{Attribute, Expr, Lit, Meta};

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
