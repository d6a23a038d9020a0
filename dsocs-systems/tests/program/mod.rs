//! The program that the tests run.

use std::path::Path;
use std::process::Command;

/// The program with these arguments, in this folder.
pub fn dsocs(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_dsocs"));
    command.args(arguments).current_dir(folder);
    command
}
