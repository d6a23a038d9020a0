//! Tests of whole commands.

mod advice;
mod rotations;
mod systems;

use clap::CommandFactory;

#[test]
fn the_command_line_is_consistent() {
    super::Arguments::command().debug_assert();
}
