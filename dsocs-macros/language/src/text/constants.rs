//! `const n = 3;`: a number that replaces its name everywhere, also as the length of an array.

use std::collections::HashMap;

use proc_macro2::{Group, Ident, Literal, Punct, Spacing, TokenStream, TokenTree};
use quote::ToTokens as _;
use syn::{Expr, Lit, UnOp};

use super::split::Parts;
use crate::check::names::RESERVED;
use crate::mistakes::errors::Errors;
use crate::mistakes::nearest::did_you_mean;
use crate::syntax::bare;

/// Replaces the names of constants by their numbers. The values in `given` override those of the text.
pub(super) fn insert(parts: Parts, given: &[(String, f64)], errors: &Errors) -> Parts {
    let mut values: HashMap<String, f64> = HashMap::new();
    for (name, tokens) in &parts.constants {
        let text = name.to_string();
        let meaning = RESERVED.iter().find(|(word, _)| *word == text);
        if let Some((_, meaning)) = meaning {
            errors.at(name, format!("`{text}` is {meaning}; expected another name"));
        }
        let tokens = replaced(tokens.clone(), &values, &mut Vec::new());
        let own = number(&tokens);
        let value = given
            .iter()
            .find(|(known, _)| *known == text)
            .map(|(_, value)| *value)
            .or(own);
        if own.is_none() {
            match first_name(&tokens) {
                Some(unknown) => {
                    let hint = did_you_mean(&unknown.to_string(), values.keys().map(String::as_str));
                    let message = format!(
                        "no constant `{unknown}` is declared before this one{hint}; expected a number, `const {text} = 3;`"
                    );
                    errors.at(unknown, message);
                }
                None if tokens.is_empty() => {
                    errors.at(name, format!("expected a number, `const {text} = 3;`"));
                }
                None => {
                    errors.at(&tokens, format!("expected a number, `const {text} = 3;`"));
                }
            }
        }
        // the mistake is reported; a whole number in its place brings no others
        if values.insert(text.clone(), value.unwrap_or(1.0)).is_some() {
            errors.at(
                name,
                format!("the constant `{text}` is declared a second time here"),
            );
        }
    }
    for (name, _) in given {
        if !values.contains_key(name) {
            // a value from outside has no place of its own: it is shown where the constants of the text are
            let hint = did_you_mean(name, values.keys().map(String::as_str));
            let place = match parts.constants.first() {
                Some((first, _)) => first.to_token_stream(),
                None => parts.declaration.clone().into_iter().take(1).collect(),
            };
            let known = match parts.constants.len() {
                0 => "; it has none, `const n = 3;`".to_owned(),
                _ if hint.is_empty() => {
                    let names: Vec<String> = parts
                        .constants
                        .iter()
                        .map(|(name, _)| format!("`{name}`"))
                        .collect();
                    format!("; these are {}", names.join(", "))
                }
                _ => hint,
            };
            errors.at(
                place,
                format!("no constant of the text is called `{name}`{known}"),
            );
        }
    }
    if values.is_empty() {
        return parts;
    }
    let mut bound = Vec::new();
    let mut replace = |tokens| replaced(tokens, &values, &mut bound);
    let parts = Parts {
        parameters: parts
            .parameters
            .map(|group| with_tokens_replaced(&group, &mut replace)),
        runs: (parts.runs.into_iter())
            .map(|(word, name, group)| (word, name, with_tokens_replaced(&group, &mut replace)))
            .collect(),
        declaration: replace(parts.declaration),
        ..parts
    };
    for name in bound {
        errors.at(
            &name,
            format!("`{name}` is a constant of this text; expected another name"),
        );
    }
    parts
}

/// The first name in tokens.
fn first_name(tokens: &TokenStream) -> Option<Ident> {
    tokens.clone().into_iter().find_map(|tree| match tree {
        TokenTree::Ident(name) => Some(name),
        TokenTree::Group(group) => first_name(&group.stream()),
        _ => None,
    })
}

/// A group with its tokens replaced.
fn with_tokens_replaced(group: &Group, replace: &mut impl FnMut(TokenStream) -> TokenStream) -> Group {
    let mut new = Group::new(group.delimiter(), replace(group.stream()));
    new.set_span(group.span());
    new
}

/// Tokens with constants replaced by numbers. `bound` collects the places where the name of a constant is
/// defined anew.
fn replaced(tokens: TokenStream, values: &HashMap<String, f64>, bound: &mut Vec<Ident>) -> TokenStream {
    let trees: Vec<TokenTree> = tokens.into_iter().collect();
    let is = |place: Option<usize>, c: char| {
        let tree = place.and_then(|place| trees.get(place));
        matches!(tree, Some(TokenTree::Punct(punct)) if punct.as_char() == c)
    };
    let mut new: Vec<TokenTree> = Vec::with_capacity(trees.len());
    for (place, tree) in trees.iter().enumerate() {
        match tree {
            TokenTree::Group(group) => {
                new.push(with_tokens_replaced(group, &mut |tokens| replaced(tokens, values, bound)).into());
            }
            TokenTree::Ident(name) => match values.get(&name.to_string()) {
                // `q.n` is a coordinate of a node
                Some(_) if is(place.checked_sub(1), '.') && !is(place.checked_sub(2), '.') => {
                    new.push(tree.clone());
                }
                Some(&value) => {
                    let before = place.checked_sub(1).and_then(|place| trees.get(place));
                    let is_let = matches!(before, Some(TokenTree::Ident(word)) if word == "let");
                    if is_let || is(place.checked_sub(1), '|') || is(Some(place + 1), '|') {
                        bound.push(name.clone());
                    }
                    if value < 0.0 {
                        let mut minus = Punct::new('-', Spacing::Alone);
                        minus.set_span(name.span());
                        new.push(minus.into());
                    }
                    let mut literal = literal(value.abs());
                    literal.set_span(name.span());
                    new.push(literal.into());
                }
                None => new.push(tree.clone()),
            },
            _ => new.push(tree.clone()),
        }
    }
    new.into_iter().collect()
}

/// The literal of a nonnegative number: an integer literal if it is whole, so that it can be the length of an
/// array.
fn literal(value: f64) -> Literal {
    /// Whole numbers up to this one are exact in double precision.
    const MOST: f64 = 9_007_199_254_740_992.0;
    if value.fract() == 0.0 && value < MOST {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a whole number that is exact"
        )]
        let whole = value as u64;
        Literal::u64_unsuffixed(whole)
    } else if value.is_finite() {
        Literal::f64_unsuffixed(value)
    } else {
        // the number is refused where the constant is read
        Literal::u64_unsuffixed(0)
    }
}

/// The value of tokens: a literal, or sums, differences, products and quotients of literals.
fn number(tokens: &TokenStream) -> Option<f64> {
    fn of(expr: &Expr) -> Option<f64> {
        match bare(expr) {
            Expr::Lit(literal) => match &literal.lit {
                Lit::Int(number) => number.base10_parse().ok(),
                Lit::Float(number) => number.base10_parse().ok(),
                _ => None,
            },
            Expr::Unary(unary) => match unary.op {
                UnOp::Neg(_) => of(&unary.expr).map(|value| -value),
                _ => None,
            },
            Expr::Binary(binary) => {
                let (left, right) = (of(&binary.left)?, of(&binary.right)?);
                match binary.op {
                    syn::BinOp::Add(_) => Some(left + right),
                    syn::BinOp::Sub(_) => Some(left - right),
                    syn::BinOp::Mul(_) => Some(left * right),
                    syn::BinOp::Div(_) => Some(left / right),
                    _ => None,
                }
            }
            _ => None,
        }
    }
    if parse_is_deep(tokens, 64) {
        return None;
    }
    let expr: Expr = syn::parse2(tokens.clone()).ok()?;
    of(&expr).filter(|value| value.is_finite())
}

/// Whether tokens are nested deeper than a depth.
fn parse_is_deep(tokens: &TokenStream, depth: usize) -> bool {
    crate::parse::too_deep(tokens, depth).is_some()
}
