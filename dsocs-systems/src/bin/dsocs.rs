//! The command `dsocs`: the command line over the systems of this crate; everything it does is in [`dsocs_systems::cli`].

use std::process::ExitCode;

fn main() -> ExitCode {
    dsocs_systems::cli::dsocs::main(dsocs_systems::systems::all())
}
