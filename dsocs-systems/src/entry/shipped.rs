//! Systems that a program has as texts.

use dsocs_core::text::{Text, TextError};

use super::{Entry, Kind};

/// A system that a program has as a text. It is read when it is asked for, so it costs neither a compiler's time nor that of a program which is asked for another one.
/// What a list says of it is known before.
#[derive(Clone, Copy, Debug)]
pub struct Shipped {
    /// The name on the command line.
    pub name: &'static str,
    /// What it is, in a line.
    pub summary: &'static str,
    /// The kind of its constraints, as it is found when the text is read.
    pub kind: Kind,
    /// Where it comes from.
    pub source: &'static str,
    /// The text.
    pub text: &'static str,
    /// What an entry adds to it: how it is drawn, its symmetries.
    pub with: fn(Entry) -> Entry,
}

impl Shipped {
    /// The entry of the system, with the first of its runs, and with numbers in place of those that the text gives its constants.
    ///
    /// # Errors
    ///
    /// [`TextError`] with all mistakes of the text; also for a constant that it does not have.
    pub fn entry(&self, constants: &[(String, f64)]) -> Result<Entry, TextError> {
        let text = Text::parse_with(self.name, self.text, constants, &[])?;
        let entry = Entry::of_text(self.name, &text, text.runs.first());
        Ok((self.with)(entry.described(self.summary).source(self.source)))
    }
}
