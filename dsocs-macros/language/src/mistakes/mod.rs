//! Mistakes and warnings of a declaration, each with its place.

pub(crate) mod errors;
pub(crate) mod limits;
pub(crate) mod nearest;

use std::fmt;

use proc_macro2::Span;

/// A place in a text; lines and columns count from 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Place {
    /// The line of its first character.
    pub line: usize,
    /// The column of its first character, counted in characters.
    pub column: usize,
    /// The line of its last character.
    pub end_line: usize,
    /// The column after its last character.
    pub end_column: usize,
}

impl Place {
    /// The place of some tokens.
    pub(crate) fn of(span: Span) -> Self {
        let (start, end) = (span.start(), span.end());
        Self {
            line: start.line,
            column: start.column + 1,
            end_line: end.line,
            end_column: end.column + 1,
        }
    }

    /// A mistake at this place.
    #[must_use]
    pub fn mistake(self, message: impl Into<String>) -> Mistake {
        Mistake {
            line: self.line,
            column: self.column,
            end_line: self.end_line,
            end_column: self.end_column,
            message: message.into(),
        }
    }
}

/// A mistake in a declaration, and where it is.
///
/// For a text, lines and columns are those of the text; for tokens from a compiler, those of its files.
#[derive(Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct Mistake {
    /// The line of the first character, from 1.
    pub line: usize,
    /// The column of the first character, from 1, in characters.
    pub column: usize,
    /// The line of the last character.
    pub end_line: usize,
    /// The column after its last character.
    pub end_column: usize,
    /// The message: what is wrong, and what was expected.
    pub message: String,
}

impl Mistake {
    /// A mistake at some tokens; tokens without a source are reported at the attribute.
    pub(crate) fn at(span: Span, attribute: Span, message: String) -> Self {
        let span = if is_nowhere(span) { attribute } else { span };
        Place::of(span).mistake(message)
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

    /// The mistakes that `syn` reports in one error of a text; those without a place are put at the end of
    /// the text.
    pub(crate) fn in_text(error: &syn::Error, end: (usize, usize)) -> impl Iterator<Item = Self> {
        let errors = error.clone().into_iter();
        errors.map(move |error| {
            if is_nowhere(error.span()) {
                Self::of_character(end.0, end.1, error.to_string())
            } else {
                Self::of(error.span(), error.to_string())
            }
        })
    }

    /// The mistakes that `syn` reports in one error.
    pub(crate) fn all(error: &syn::Error, attribute: Span) -> impl Iterator<Item = Self> {
        let errors = error.clone().into_iter();
        errors.map(move |error| Self::at(error.span(), attribute, error.to_string()))
    }
}

/// Whether a span belongs to no source.
fn is_nowhere(span: Span) -> bool {
    span.byte_range().is_empty() && span.start() == Span::call_site().start()
}

impl fmt::Display for Mistake {
    /// `line:column: message`.
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}:{}: {}", self.line, self.column, self.message)
    }
}

impl fmt::Debug for Mistake {
    /// The text of `Display`, because `main` and `unwrap` print `Debug` for people.
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, formatter)
    }
}

impl std::error::Error for Mistake {}
