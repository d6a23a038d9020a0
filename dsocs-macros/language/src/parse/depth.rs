//! The depth of expressions, before they are parsed.

use proc_macro2::{TokenStream, TokenTree};

/// The deepest nesting of an expression. Parsing and lowering recurse as deep, and the compiler's stack has
/// to hold.
pub(crate) const DEEPEST: usize = 100;

/// The most tokens between two commas or semicolons, a bracket counting as one: a sum is nested as deep as it
/// has terms.
pub(crate) const LONGEST: usize = 8000;

/// The first token beyond a depth of brackets, prefixes like `-`, method calls, closures, assignments and
/// alternatives, or beyond [`LONGEST`].
pub(crate) fn too_deep(tokens: &TokenStream, left: usize) -> Option<TokenTree> {
    // the tokens since the last separator, and those of them that add to the depth
    let (mut count, mut prefixes, mut methods, mut inner) = (0, 0, 0, 0);
    let mut before = '\0';
    for tree in tokens.clone() {
        count += 1;
        let mut punctuation = '\0';
        match &tree {
            TokenTree::Group(group) => {
                prefixes = 0;
                match left.checked_sub(1) {
                    Some(left) => {
                        if let Some(deep) = too_deep(&group.stream(), left) {
                            return Some(deep);
                        }
                    }
                    None => return Some(tree),
                }
            }
            TokenTree::Punct(punct) => {
                punctuation = punct.as_char();
                prefixes += 1;
                match punctuation {
                    ',' | ';' => (count, methods, inner) = (0, 0, 0),
                    '.' if before != '.' => methods += 1,
                    // a closure has two of these
                    '|' => inner += 1,
                    '=' if !matches!(before, '=' | '<' | '>' | '!') => inner += 1,
                    _ => methods = 0,
                }
            }
            TokenTree::Ident(word) => {
                prefixes = 0;
                if ["else", "return", "break", "move"]
                    .iter()
                    .any(|keyword| word == keyword)
                {
                    inner += 1;
                }
            }
            TokenTree::Literal(_) => prefixes = 0,
        }
        before = punctuation;
        if count > LONGEST || prefixes.max(methods).max(inner / 2) > left {
            return Some(tree);
        }
    }
    None
}
