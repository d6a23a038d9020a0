//! Characters that no text has: those that a terminal would obey, and those that hide what stands in a line.

use proc_macro2::{TokenStream, TokenTree};
use syn::{Lit, LitStr};

use crate::mistake::Mistake;

/// Refuses such a character where it stands.
pub(super) fn check(text: &str) -> Result<(), Vec<Mistake>> {
    let Some((at, message)) = found(text) else {
        return Ok(());
    };
    let before = &text[..at];
    let line = before.matches('\n').count() + 1;
    let column = before.rsplit('\n').next().map_or(0, |line| line.chars().count()) + 1;
    Err(vec![Mistake::of_character(line, column, message)])
}

/// Refuses such a character in a string: what is named or said may be shown anywhere.
pub(super) fn check_literals(tokens: &TokenStream) -> Result<(), Vec<Mistake>> {
    for tree in tokens.clone() {
        match tree {
            TokenTree::Group(group) => check_literals(&group.stream())?,
            TokenTree::Literal(literal) => {
                let span = literal.span();
                let text = match Lit::new(literal) {
                    Lit::Str(text) => LitStr::value(&text),
                    _ => continue,
                };
                if let Some((_, message)) = found(&text) {
                    return Err(vec![Mistake::of(span, message)]);
                }
            }
            _ => {}
        }
    }
    Ok(())
}

/// The place of the first such character, and what is said of it.
fn found(text: &str) -> Option<(usize, String)> {
    let mut characters = text.char_indices().peekable();
    while let Some((at, character)) = characters.next() {
        let is_end_of_line = character == '\r' && characters.peek().is_some_and(|(_, next)| *next == '\n');
        let is_space = matches!(character, '\n' | '\t') || is_end_of_line;
        let hides = matches!(character, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
        if (character.is_control() && !is_space) || hides {
            let code = u32::from(character);
            let message = format!("the character U+{code:04X}, which is not seen, is out of place here");
            return Some((at, message));
        }
    }
    None
}
