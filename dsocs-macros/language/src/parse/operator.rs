//! Missing operators between two values: `length theta.sin()` for a product.

use proc_macro2::{Ident, Spacing, Span, TokenStream, TokenTree};

use super::STATEMENTS;
use crate::mistakes::errors::Errors;

/// The error for tokens that cannot be read, with a hint if an operator is missing at its place.
pub(super) fn missing(tokens: &TokenStream, error: syn::Error, errors: &Errors) -> syn::Error {
    if errors.are_of_text()
        && let Some(message) = foreign_sign_hint(tokens, error.span())
    {
        return syn::Error::new(error.span(), message);
    }
    match side_by_side(tokens, error.span(), "expected `;` or an operator") {
        Some(expected) => {
            let unit = match token_before(tokens, error.span()) {
                Some(TokenTree::Literal(_)) if errors.are_of_text() => ", and a number has no unit",
                _ => "",
            };
            let message = format!("{expected}: a product is written with `*`{unit}");
            syn::Error::new(error.span(), message)
        }
        None if errors.are_of_text() => in_plain_words(tokens, &error),
        None => error,
    }
}

/// An error of `syn`, in words for people who know no Rust.
fn in_plain_words(tokens: &TokenStream, error: &syn::Error) -> syn::Error {
    let said = error.to_string();
    if said.contains("end of input") {
        // the end of input has no place
        let last = last_span(tokens).filter(|_| error.span().start() == Span::call_site().start());
        let place = last.unwrap_or_else(|| error.span());
        return syn::Error::new(place, "this ends too early: expected a value behind it");
    }
    let message = match said.as_str() {
        "expected an expression" => "expected a value here: a number, a name, or something in brackets",
        "expected `;`" | "unexpected token" | "unexpected token, expected `;`" => {
            "this does not belong here; expected an operator, or the end of the statement"
        }
        said if said.starts_with("expected identifier") => "expected a name here",
        said if said.starts_with("expected one of") => "expected a name or a value here",
        said if said.contains("expected `,`") => "expected `,` here, or an operator",
        _ => return error.clone(),
    };
    syn::Error::new(error.span(), message)
}

/// The hint for a sign or a word of another language, at a place of some tokens.
fn foreign_sign_hint(tokens: &TokenStream, place: Span) -> Option<&'static str> {
    const CHOICE: &str = "a choice is written `if x > 0 { 1 } else { 2 }`";
    let mut before = None;
    for tree in tokens.clone() {
        if tree.span().start() == place.start() {
            return match &tree {
                TokenTree::Ident(word) if word == "if" || word == "then" => Some(CHOICE),
                TokenTree::Ident(word) if word == "and" => Some("between comparisons, `and` is written `&&`"),
                TokenTree::Ident(word) if word == "or" => Some("between comparisons, `or` is written `||`"),
                TokenTree::Punct(sign) => match sign.as_char() {
                    '#' => {
                        Some("documentation, `///`, stands above what it is of; a comment begins with `//`")
                    }
                    ',' => Some("several values stand in parentheses or brackets; a decimal has a point"),
                    '=' if sign.spacing() == Spacing::Joint => {
                        Some("expected the expression alone; what is done for an index is written `|i| …`")
                    }
                    '?' => Some(CHOICE),
                    _ if sign_of(before.as_ref()) == '|' => Some("an absolute value is written `x.abs()`"),
                    _ => None,
                },
                _ if sign_of(before.as_ref()) == '?' => Some(CHOICE),
                _ => None,
            };
        }
        if let TokenTree::Group(group) = &tree
            && let Some(found) = foreign_sign_hint(&group.stream(), place)
        {
            return Some(found);
        }
        before = Some(tree);
    }
    None
}

/// The sign of a token; `\0` for other tokens.
fn sign_of(tree: Option<&TokenTree>) -> char {
    match tree {
        Some(TokenTree::Punct(sign)) => sign.as_char(),
        _ => '\0',
    }
}

/// The last token that is no semicolon.
fn last_span(tokens: &TokenStream) -> Option<Span> {
    let is_end = |tree: &TokenTree| matches!(tree, TokenTree::Punct(sign) if sign.as_char() == ';');
    let last = tokens.clone().into_iter().filter(|tree| !is_end(tree)).last()?;
    Some(last.span())
}

/// The token before a place.
fn token_before(tokens: &TokenStream, place: Span) -> Option<TokenTree> {
    let mut last = None;
    for tree in tokens.clone() {
        if tree.span().start() == place.start() {
            return last;
        }
        if let TokenTree::Group(group) = &tree
            && let Some(found) = token_before(&group.stream(), place)
        {
            return Some(found);
        }
        last = Some(tree);
    }
    None
}

/// The expected token where a value directly follows another one.
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

/// Whether a token may begin a value, but not a statement.
fn begins_value(tree: &TokenTree) -> bool {
    match tree {
        TokenTree::Ident(name) => is_name(name) && STATEMENTS.iter().all(|statement| name != statement),
        TokenTree::Literal(_) => true,
        TokenTree::Group(_) | TokenTree::Punct(_) => false,
    }
}

/// Whether an identifier is no reserved word of Rust.
fn is_name(name: &Ident) -> bool {
    syn::parse_str::<Ident>(&name.to_string()).is_ok()
}
