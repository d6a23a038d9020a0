//! A text → documentation, constants, parameters, runs, and the declaration.

use proc_macro2::{Delimiter, Group, Ident, TokenStream, TokenTree};
use syn::{Lit, LitStr};

use crate::mistakes::errors::Errors;

/// The parts of a text.
#[derive(Default)]
pub(super) struct Parts {
    /// The lines of `//!`.
    pub(super) docs: Vec<String>,
    /// `const n = 3;`: the name, and the tokens behind `=`.
    pub(super) constants: Vec<(Ident, TokenStream)>,
    /// `parameters { … }`.
    pub(super) parameters: Option<Group>,
    /// `run name { … }`: the word `run`, the name, which is optional, and the block.
    pub(super) runs: Vec<(Ident, Option<Ident>, Group)>,
    /// The other statements, which are the declaration.
    pub(super) declaration: TokenStream,
}

/// Splits a text.
pub(super) fn split(tokens: TokenStream, errors: &Errors) -> Parts {
    let mut parts = Parts::default();
    let mut trees: Vec<TokenTree> = tokens.into_iter().collect();
    trees.reverse();
    let mut rest: Vec<TokenTree> = Vec::new();
    let mut begins = true;
    while let Some(tree) = trees.pop() {
        let ahead = |place: usize| trees.len().checked_sub(place).and_then(|at| trees.get(at));
        let word = match &tree {
            TokenTree::Ident(word) if begins => Some(word.clone()),
            _ => None,
        };
        match word.map(|word| (word.to_string(), word)) {
            Some((text, word)) if text == "parameters" => {
                begins = true;
                if is_equals(trees.last())
                    && let Some(equals) = trees.pop()
                {
                    errors.at(equals, "expected `parameters { … }`, without `=`");
                }
                match trees.pop() {
                    Some(TokenTree::Group(group)) => {
                        if group.delimiter() != Delimiter::Brace {
                            errors.at(&word, "expected `parameters { … }`, in braces");
                        }
                        if parts.parameters.is_some() {
                            errors.at(&word, "`parameters` stands a second time here; expected it once");
                        }
                        parts.parameters = Some(group);
                        skip_semicolon(&mut trees);
                    }
                    other => {
                        trees.extend(other);
                        errors.at(&word, "expected `parameters { mass = 1.0, length = 2.0 }`");
                        skip_statement(&mut trees);
                    }
                }
            }
            Some((text, word)) if text == "run" => {
                let name = match ahead(1) {
                    Some(TokenTree::Ident(name)) => Some(name.clone()),
                    _ => None,
                };
                if name.is_some() {
                    trees.pop();
                }
                if is_equals(trees.last())
                    && let Some(equals) = trees.pop()
                {
                    errors.at(equals, "expected `run { … }`, without `=`");
                }
                match trees.pop() {
                    Some(TokenTree::Group(group)) if group.delimiter() == Delimiter::Brace => {
                        parts.runs.push((word, name, group));
                        skip_semicolon(&mut trees);
                    }
                    other => {
                        trees.extend(other);
                        errors.at(
                            &word,
                            "expected `run { start = ([1.0], [0.0]); step = 0.01; until = 20.0; }`",
                        );
                        skip_statement(&mut trees);
                    }
                }
            }
            Some((text, word)) if text == "const" => constant(&word, &mut trees, &mut parts, errors),
            _ => {
                if let Some(line) = inner_doc(&tree, &mut trees, begins) {
                    parts.docs.push(line);
                    continue;
                }
                // documentation belongs to the statement that follows
                let is_doc = begins && matches!(&tree, TokenTree::Punct(punct) if punct.as_char() == '#');
                let ends = matches!(&tree, TokenTree::Punct(punct) if punct.as_char() == ';');
                rest.push(tree);
                if is_doc {
                    rest.extend(trees.pop());
                } else {
                    begins = ends;
                }
            }
        }
    }
    parts.declaration = rest.into_iter().collect();
    parts
}

/// Whether a token is `=`.
fn is_equals(tree: Option<&TokenTree>) -> bool {
    matches!(tree, Some(TokenTree::Punct(sign)) if sign.as_char() == '=')
}

/// Reads `n = 3;` behind `const`.
fn constant(word: &Ident, trees: &mut Vec<TokenTree>, parts: &mut Parts, errors: &Errors) {
    let name = match trees.pop() {
        Some(TokenTree::Ident(name)) => Some(name),
        other => {
            trees.extend(other);
            None
        }
    };
    let equals = match trees.pop() {
        Some(TokenTree::Punct(punct)) if punct.as_char() == '=' => true,
        other => {
            trees.extend(other);
            false
        }
    };
    let value = skip_statement(trees);
    match name {
        Some(name) if equals => parts.constants.push((name, value)),
        _ => {
            errors.at(word, "expected `const n = 3;`, with a number");
        }
    }
}

/// The text of `//!`, which the lexer hands over as `#![doc = "…"]`.
fn inner_doc(tree: &TokenTree, trees: &mut Vec<TokenTree>, begins: bool) -> Option<String> {
    let is =
        |tree: Option<&TokenTree>, c| matches!(tree, Some(TokenTree::Punct(punct)) if punct.as_char() == c);
    if !begins || !is(Some(tree), '#') || !is(trees.last(), '!') {
        return None;
    }
    let group = trees.len().checked_sub(2).and_then(|at| trees.get(at));
    let Some(TokenTree::Group(group)) = group else {
        return None;
    };
    let mut inner = group.stream().into_iter();
    let (Some(TokenTree::Ident(doc)), Some(_), Some(TokenTree::Literal(text))) =
        (inner.next(), inner.next(), inner.next())
    else {
        return None;
    };
    if doc != "doc" {
        return None;
    }
    let text = match Lit::new(text) {
        Lit::Str(text) => LitStr::value(&text),
        _ => return None,
    };
    trees.truncate(trees.len() - 2);
    Some(text)
}

/// Takes a `;` away, if it comes next.
fn skip_semicolon(trees: &mut Vec<TokenTree>) {
    if matches!(trees.last(), Some(TokenTree::Punct(punct)) if punct.as_char() == ';') {
        trees.pop();
    }
}

/// Takes everything up to the next `;`, and gives back what stood before it.
fn skip_statement(trees: &mut Vec<TokenTree>) -> TokenStream {
    let mut taken = Vec::new();
    while let Some(tree) = trees.pop() {
        if matches!(&tree, TokenTree::Punct(punct) if punct.as_char() == ';') {
            break;
        }
        taken.push(tree);
    }
    taken.into_iter().collect()
}
