//! Output on a terminal: messages on standard error, and tables with colours where they are wanted.

use std::ffi::OsStr;
use std::fmt::Display;
use std::io::{IsTerminal, Write as _};

use comfy_table::{Table, TableStyle};

use crate::cli::CliError;

/// Writes a message to standard error. An error of writing is ignored.
pub fn tell(what: impl Display) {
    let _ = writeln!(std::io::stderr(), "{what}");
}

/// Writes to standard output.
///
/// # Errors
///
/// [`CliError::Stdout`] or, if its reader has gone, [`CliError::Closed`].
pub fn print(content: &[u8]) -> Result<(), CliError> {
    let mut out = std::io::stdout();
    out.write_all(content).map_err(CliError::stdout)
}

/// Writes measured figures to standard output.
///
/// # Errors
///
/// As [`print`], and [`CliError::Bars`] if some figures missed their bars.
pub fn print_figures(text: &str, missed: usize) -> Result<(), CliError> {
    print(text.as_bytes())?;
    if missed > 0 {
        return Err(CliError::Bars { missed });
    }
    Ok(())
}

/// An empty table, coloured where colours are wanted: on a terminal, unless `NO_COLOR` is set to anything (<https://no-color.org>).
pub fn table(style: TableStyle) -> Table {
    let mut table = Table::new();
    table.load_style(style);
    let no_color = std::env::var_os("NO_COLOR");
    if !coloured(std::io::stdout().is_terminal(), no_color.as_deref()) {
        table.force_no_tty();
    }
    table
}

/// Whether colours are wanted.
fn coloured(terminal: bool, no_color: Option<&OsStr>) -> bool {
    terminal && no_color.is_none_or(OsStr::is_empty)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_for_terminals_and_can_be_switched_off() {
        assert!(coloured(true, None));
        assert!(coloured(true, Some("".as_ref())));
        assert!(!coloured(true, Some("1".as_ref())));
        assert!(!coloured(false, None));
    }
}
