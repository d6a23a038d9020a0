//! The mistakes of a declaration, collected so that all of them are reported at once.

use std::cell::RefCell;
use std::fmt::Display;

use proc_macro2::TokenStream;
use quote::ToTokens;

/// The proof that a mistake was reported, so that its consequences need not be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Reported(());

/// Collects mistakes; [`Errors::finish`] has to be called before it is dropped.
#[derive(Debug)]
pub(crate) struct Errors {
    /// Whether the declaration is a text; its author may not know Rust.
    of_text: bool,
    found: RefCell<Option<Vec<syn::Error>>>,
}

impl Errors {
    /// No mistakes yet, for a declaration in Rust.
    pub(crate) fn new() -> Self {
        Self {
            of_text: false,
            found: RefCell::new(Some(Vec::new())),
        }
    }

    /// No mistakes yet, for a declaration in a text.
    pub(crate) fn of_text() -> Self {
        let mut errors = Self::new();
        errors.of_text = true;
        errors
    }

    /// Whether there are so many mistakes that reading on is useless.
    pub(crate) fn are_many(&self) -> bool {
        const MANY: usize = 1000;
        let found = self.found.borrow();
        found.as_ref().is_some_and(|found| found.len() > MANY)
    }

    /// Whether messages are for authors of a text, who may not know Rust.
    pub(crate) fn are_of_text(&self) -> bool {
        self.of_text
    }

    /// The wording for this declaration: `rust` in Rust, `text` in a text.
    pub(crate) fn words<'w>(&self, rust: &'w str, text: &'w str) -> &'w str {
        if self.of_text { text } else { rust }
    }

    /// Reports a mistake at the given tokens.
    pub(crate) fn at(&self, tokens: impl ToTokens, message: impl Display) -> Reported {
        self.push(syn::Error::new_spanned(tokens.into_token_stream(), message))
    }

    /// Reports a missing statement, at the attribute.
    pub(crate) fn missing(&self, statement: &str) -> Reported {
        self.at(
            TokenStream::new(),
            format!("expected the statement `{statement}` in the declaration"),
        )
    }

    /// Reports a mistake that `syn` found.
    pub(crate) fn push(&self, error: syn::Error) -> Reported {
        if let Some(found) = self.found.borrow_mut().as_mut() {
            found.push(error);
        }
        Reported(())
    }

    /// The mistakes in the order of the source, without repetitions; `Ok` if there are none.
    pub(crate) fn finish(self) -> Result<(), Vec<syn::Error>> {
        let mut found = self.found.borrow_mut().take().unwrap_or_default();
        let place = |error: &syn::Error| {
            let (start, end) = (error.span().start(), error.span().end());
            [start.line, start.column, end.line, end.column]
        };
        found.sort_by_key(place);
        // the body of a sum or of a function is read several times
        found.dedup_by(|a, b| place(a) == place(b) && a.to_string() == b.to_string());
        if found.is_empty() { Ok(()) } else { Err(found) }
    }
}

impl Drop for Errors {
    fn drop(&mut self) {
        debug_assert!(
            self.found.get_mut().is_none() || std::thread::panicking(),
            "the collected errors were dropped unread"
        );
    }
}

/// The mistakes as `compile_error!` invocations.
pub(crate) fn compile_errors(errors: &[syn::Error]) -> TokenStream {
    errors.iter().map(syn::Error::to_compile_error).collect()
}
