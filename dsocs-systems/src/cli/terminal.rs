//! Output on a terminal: messages on standard error, and tables with colours where they are wanted.

use std::ffi::OsStr;
use std::fmt::Display;
use std::io::{IsTerminal, Write as _};

use comfy_table::{Table, TableStyle};

/// Writes a message to standard error. An error of writing is ignored.
pub fn tell(what: impl Display) {
    let _ = writeln!(std::io::stderr(), "{what}");
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
