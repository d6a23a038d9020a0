//! What is wrong in a declaration, or of no effect there, with its place.

use std::fmt;

use proc_macro2::Span;

/// A mistake in a declaration, and where it is.
///
/// In text, places are those of the text. In tokens that a compiler has handed over, they are those of its files.
#[derive(Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct Mistake {
    /// The line in which the mistake begins, from 1.
    pub line: usize,
    /// The column in which it begins, from 1, in characters.
    pub column: usize,
    /// The line in which it ends.
    pub end_line: usize,
    /// The column after its last character.
    pub end_column: usize,
    /// What is wrong, and what was expected there.
    pub message: String,
}

impl Mistake {
    /// A mistake at some tokens; those that are in no source stand for the attribute as a whole.
    pub(crate) fn at(span: Span, attribute: Span, message: String) -> Self {
        let nowhere = span.byte_range().is_empty() && span.start() == Span::call_site().start();
        let span = if nowhere { attribute } else { span };
        let (start, end) = (span.start(), span.end());
        Self {
            line: start.line,
            column: start.column + 1,
            end_line: end.line,
            end_column: end.column + 1,
            message,
        }
    }

    /// A mistake at some tokens of a source.
    pub(crate) fn of(span: Span, message: String) -> Self {
        Self::at(span, span, message)
    }

    /// A mistake at a character of a source; line and column count from 1.
    pub(crate) fn of_character(line: usize, column: usize, message: String) -> Self {
        Self {
            line,
            column,
            end_line: line,
            end_column: column + 1,
            message,
        }
    }

    /// The mistakes that `syn` tells in one error.
    pub(crate) fn all(error: &syn::Error, attribute: Span) -> impl Iterator<Item = Self> {
        let errors = error.clone().into_iter();
        errors.map(move |error| Self::at(error.span(), attribute, error.to_string()))
    }
}

impl fmt::Display for Mistake {
    /// `line:column: message`.
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}:{}: {}", self.line, self.column, self.message)
    }
}

impl fmt::Debug for Mistake {
    /// Its message: `main` and `unwrap` print a text for people.
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, formatter)
    }
}

impl std::error::Error for Mistake {}
