//! Systems that a program holds as texts.

use dsocs_core::text::{Text, TextError};

use super::{Entry, Kind};

/// A system that a program holds as a text. It is parsed when it is asked for, so it costs no compile time,
/// and no time when another system is run. The items of a list are known without parsing.
#[derive(Clone, Copy, Debug)]
pub struct Shipped {
    /// The name on the command line.
    pub name: &'static str,
    /// The summary, in a line.
    pub summary: &'static str,
    /// The kind of its constraints, as it is found when the text is read.
    pub kind: Kind,
    /// The literature source.
    pub source: &'static str,
    /// The text.
    pub text: &'static str,
    /// Adds to the entry what a text does not contain: its drawing and its symmetries.
    pub with: fn(Entry) -> Entry,
}

impl Shipped {
    /// The entry of the system, with the first run of its text, and with other values for the text's
    /// constants.
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
