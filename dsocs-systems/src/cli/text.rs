//! `text`: a system as a text file.

use std::io::Write as _;

use clap::Args;

use super::{CliError, Program};

/// What is written.
#[derive(Debug, Args)]
pub struct TextArguments {
    /// The system's name; it may be left out if there is only one
    pub system: Option<String>,
}

/// Writes a system as a text file.
pub fn text(arguments: &TextArguments, program: &mut Program) -> Result<(), CliError> {
    let entry = program.one(arguments.system.as_deref())?;
    let text = entry.text()?;
    std::io::stdout()
        .write_all(text.as_bytes())
        .map_err(CliError::stdout)
}
