//! The entries `name = value` of the blocks `parameters { … }` and `run { … }`.

use proc_macro2::{Delimiter, Group, Ident, TokenStream, TokenTree};
use syn::{Attribute, Expr};

use crate::mistakes::errors::{Errors, Reported};
use crate::parse::{DEEPEST, expression, too_deep};

/// An entry of a block.
pub(super) struct Item {
    /// Its documentation.
    pub(super) attributes: Vec<Attribute>,
    /// Its name.
    pub(super) name: Ident,
    /// The length of an array, in brackets behind a colon.
    pub(super) length: Option<Result<Expr, Reported>>,
    /// The expression behind `=`.
    pub(super) value: Result<Expr, Reported>,
}

/// The entries of a block, each read by itself, so that a mistake in one does not hide the others. They are
/// separated by `separator`; `other` is taken for it, and reported.
pub(super) fn read(group: &Group, [separator, other]: [char; 2], errors: &Errors) -> Vec<Item> {
    if let Some(deep) = too_deep(&group.stream(), DEEPEST) {
        errors.at(deep, "expected values that are nested less deep");
        return Vec::new();
    }
    let mut items = Vec::new();
    let mut trees: Vec<TokenTree> = Vec::new();
    let mut is_told = false;
    let mut end = |trees: &mut Vec<TokenTree>| items.extend(item(std::mem::take(trees), errors));
    let all: Vec<TokenTree> = group.stream().into_iter().collect();
    for (place, tree) in all.iter().enumerate() {
        let sign = match tree {
            TokenTree::Punct(punct) => punct.as_char(),
            _ => '\0',
        };
        let next = all.get(place + 1..).unwrap_or_default();
        if sign == other && (next.is_empty() || begins(next)) {
            if !is_told {
                errors.at(
                    tree,
                    format!("expected `{separator}` here, which stands between the parts of this block"),
                );
            }
            is_told = true;
            end(&mut trees);
        } else if sign == separator {
            end(&mut trees);
        } else if begins(&all[place..]) && trees.iter().any(is_equals) && line_ends(trees.last(), tree) {
            if let Some(last) = trees.last() {
                errors.at(last, format!("expected `{separator}` behind this"));
            }
            end(&mut trees);
            trees.push(tree.clone());
        } else {
            trees.push(tree.clone());
        }
    }
    end(&mut trees);
    items
}

/// Whether tokens begin an entry or its documentation.
fn begins(trees: &[TokenTree]) -> bool {
    match trees {
        [TokenTree::Ident(_), TokenTree::Punct(sign), ..] => matches!(sign.as_char(), '=' | ':'),
        [TokenTree::Punct(sharp), TokenTree::Group(_), ..] => sharp.as_char() == '#',
        _ => false,
    }
}

fn is_equals(tree: &TokenTree) -> bool {
    matches!(tree, TokenTree::Punct(punct) if punct.as_char() == '=')
}

/// Whether a token is the last one of its line.
fn line_ends(last: Option<&TokenTree>, next: &TokenTree) -> bool {
    last.is_some_and(|last| last.span().end().line < next.span().start().line)
}

/// Reads one entry. `None` if there is none, or if it has no name, which is reported.
fn item(trees: Vec<TokenTree>, errors: &Errors) -> Option<Item> {
    let mut rest = trees.into_iter().peekable();
    let mut attributes = Vec::new();
    while matches!(rest.peek(), Some(TokenTree::Punct(sharp)) if sharp.as_char() == '#') {
        let attribute: TokenStream = [rest.next(), rest.next()].into_iter().flatten().collect();
        match syn::parse::Parser::parse2(Attribute::parse_outer, attribute.clone()) {
            Ok(parsed) => attributes.extend(parsed),
            Err(_) => {
                errors.at(
                    attribute,
                    "documentation is written `/// …`, in a line above what it is of",
                );
            }
        }
    }
    let name = match rest.next() {
        Some(TokenTree::Ident(name)) => name,
        Some(other) => {
            errors.at(other, "expected a name, as in `name = value`");
            return None;
        }
        None => {
            if let Some(last) = attributes.last() {
                errors.at(last, "expected `name = value` below its documentation");
            }
            return None;
        }
    };
    let (mut length, mut reported) = (None, None);
    match rest.next() {
        Some(TokenTree::Punct(sign)) if sign.as_char() == '=' => {}
        Some(TokenTree::Punct(sign)) if sign.as_char() == ':' => match rest.peek() {
            Some(TokenTree::Group(group)) if group.delimiter() == Delimiter::Bracket => {
                length = Some(expression(&group.stream(), group, errors));
                rest.next();
                match rest.next() {
                    Some(TokenTree::Punct(sign)) if sign.as_char() == '=' => {}
                    other => {
                        let at = other.unwrap_or_else(|| name.clone().into());
                        reported = Some(
                            errors.at(at, format!("expected `{name}: […] = […]`, with a value for each")),
                        );
                    }
                }
            }
            Some(TokenTree::Punct(equals)) if equals.as_char() == '=' => {
                reported = Some(errors.at(sign, format!("expected `{name} = …`, without `:`")));
            }
            _ => reported = Some(errors.at(sign, format!("expected `{name} = …`, with `=`"))),
        },
        Some(other) => reported = Some(errors.at(other, format!("expected `{name} = …`, with `=`"))),
        None => reported = Some(errors.at(&name, format!("expected a value, `{name} = …`"))),
    }
    let value = match reported {
        Some(reported) => Err(reported),
        None => expression(&rest.collect(), &name, errors),
    };
    Some(Item {
        attributes,
        name,
        length,
        value,
    })
}
