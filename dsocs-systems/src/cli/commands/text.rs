//! `text`: a system as a text file. A system that was read from a file is written word for word, unless
//! `--const` changes it.

use clap::Args;

use crate::cli::output::terminal;
use crate::cli::{CliError, Program};

/// The arguments of `text`.
#[derive(Debug, Args)]
pub struct TextArguments {
    /// The system's name, a text file, or the folder or a Parquet file of a sweep; it may be left out if there is only one system
    pub system: Option<String>,
}

/// Writes a system as a text file.
pub fn text(arguments: &TextArguments, program: &mut Program) -> Result<(), CliError> {
    let text = if let Some(text) = swept(arguments.system.as_deref(), program)? {
        text
    } else {
        let is_as_written = program.constants.is_empty();
        let entry = program.single_entry(arguments.system.as_deref())?;
        match entry.source_text() {
            Some(text) if is_as_written => text.to_owned(),
            _ => entry.text()?,
        }
    };
    terminal::print(text.as_bytes())
}

/// The declaration that a sweep holds of its system, if a sweep is named. Control characters are left out:
/// the file may come from an untrusted source.
#[cfg(feature = "sweep")]
fn swept(name: Option<&str>, program: &Program) -> Result<Option<String>, CliError> {
    let is_known = |name: &str| program.entries.iter().any(|entry| entry.name() == name);
    let Some(name) = name.filter(|name| !is_known(name)) else {
        return Ok(None);
    };
    let path = std::path::Path::new(name);
    if !path.is_dir() && path.extension().is_none_or(|ending| ending != "parquet") {
        return Ok(None);
    }
    let seen = |c: &char| !c.is_control() || matches!(c, '\n' | '\t');
    Ok(Some(crate::sweep::text(path)?.chars().filter(seen).collect()))
}

/// Without the feature `sweep` nothing is read from sweeps.
#[cfg(not(feature = "sweep"))]
#[allow(clippy::unnecessary_wraps)] // as with the feature
fn swept(_: Option<&str>, _: &Program) -> Result<Option<String>, CliError> {
    Ok(None)
}
