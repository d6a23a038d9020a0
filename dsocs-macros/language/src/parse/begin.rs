//! Beginnings of statements that are written in the way of other languages: `lagrangian : …`, `import numpy`.

use proc_macro2::{Delimiter, TokenStream, TokenTree};

use super::foreign_statement_hint;
use super::{STATEMENTS, expected_statement};
use crate::mistakes::errors::{Errors, Reported};
use crate::mistakes::nearest::nearest;

/// The tokens of a statement after its documentation.
pub(super) fn words(statement: &TokenStream) -> impl Iterator<Item = TokenTree> + use<> {
    let mut trees = statement.clone().into_iter().peekable();
    while matches!(trees.peek(), Some(TokenTree::Punct(sharp)) if sharp.as_char() == '#') {
        trees.next();
        trees.next_if(|tree| matches!(tree, TokenTree::Group(_)));
    }
    trees
}

/// Refuses a statement with a beginning that no statement has.
pub(super) fn check(statement: &TokenStream, errors: &Errors) -> Option<Reported> {
    let mut words = words(statement);
    let TokenTree::Ident(word) = words.next()? else {
        return None;
    };
    let (second, third) = (words.next(), words.next());
    let is_equals =
        |tree: &Option<TokenTree>| matches!(tree, Some(TokenTree::Punct(sign)) if sign.as_char() == '=');
    let text = word.to_string();
    let second_is_name = matches!(second, Some(TokenTree::Ident(_) | TokenTree::Literal(_)));
    if text == "let" {
        let Some(TokenTree::Ident(name)) = &second else {
            return None;
        };
        return match (&third, words.next()) {
            (Some(TokenTree::Punct(sign)), fourth) if sign.as_char() == ':' && is_equals(&fourth) => {
                Some(errors.at(sign, format!("expected `let {name} = …;`, without `:`")))
            }
            _ => None,
        };
    }
    if !STATEMENTS.contains(&text.as_str()) {
        let is_name = syn::parse_str::<syn::Ident>(&text).is_ok();
        if !is_name || !second_is_name {
            return None;
        }
        let hint = match (
            foreign_statement_hint(&text),
            nearest(&text.to_lowercase(), STATEMENTS),
        ) {
            (Some(hint), _) if errors.are_of_text() => hint.to_owned(),
            (_, Some(near)) => format!("did you mean `{near}`?"),
            _ => expected_statement(),
        };
        return Some(errors.at(word, format!("no statement begins with `{text}`: {hint}")));
    }
    match (&second, text.as_str()) {
        (Some(TokenTree::Group(group)), "coordinates") if group.delimiter() == Delimiter::Parenthesis => None,
        (second, "coordinates") if !is_equals(second) => {
            Some(errors.at(&word, "expected `coordinates(x, y);`, in parentheses"))
        }
        (_, "coordinates") => None,
        (Some(TokenTree::Punct(sign)), _) if sign.as_char() != '=' || is_equals(&third) => {
            Some(errors.at(sign, format!("expected `{word} = …;`, with `=`")))
        }
        _ if second_is_name => Some(errors.at(&word, format!("expected `{word} = …;`, with `=`"))),
        _ => None,
    }
}
