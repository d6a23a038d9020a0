//! The command `dsocs`; everything it does is in [`dsocs_systems::cli`].

use std::process::ExitCode;

fn main() -> ExitCode {
    dsocs_systems::cli::main()
}
