//! Two values side by side: `length theta.sin()`, for a product.

use proc_macro2::{Ident, Span, TokenStream, TokenTree};

use super::STATEMENTS;

/// The error of a statement that cannot be read, with what to write if an operator is missing where it ends.
pub(super) fn missing(statement: &TokenStream, error: syn::Error) -> syn::Error {
    match side_by_side(statement, error.span(), "expected `;` or an operator") {
        Some(expected) => syn::Error::new(error.span(), format!("{expected}: a product is written with `*`")),
        None => error,
    }
}

/// What is expected at a place where a value follows another one.
fn side_by_side(tokens: &TokenStream, place: Span, expected: &'static str) -> Option<&'static str> {
    let mut before = None;
    for tree in tokens.clone() {
        if tree.span().start() == place.start() && tree.span().start() != Span::call_site().start() {
            let follows = before.as_ref().is_some_and(is_value) && begins_value(&tree);
            return follows.then_some(expected);
        }
        if let TokenTree::Group(group) = &tree
            && let Some(found) = side_by_side(&group.stream(), place, "expected an operator")
        {
            return Some(found);
        }
        before = Some(tree);
    }
    None
}

/// Whether a value may end with a token.
fn is_value(tree: &TokenTree) -> bool {
    match tree {
        TokenTree::Ident(name) => is_name(name),
        TokenTree::Literal(_) | TokenTree::Group(_) => true,
        TokenTree::Punct(_) => false,
    }
}

/// Whether a value, and no other statement, may begin with a token.
fn begins_value(tree: &TokenTree) -> bool {
    match tree {
        TokenTree::Ident(name) => is_name(name) && STATEMENTS.iter().all(|statement| name != statement),
        TokenTree::Literal(_) => true,
        TokenTree::Group(_) | TokenTree::Punct(_) => false,
    }
}

/// Whether an identifier is no word of Rust.
fn is_name(name: &Ident) -> bool {
    syn::parse_str::<Ident>(&name.to_string()).is_ok()
}
