//! The command `dsocs`: the commands that every program over a list of systems has, and those of the paper.

use std::ffi::OsString;
use std::process::ExitCode;

use clap::{CommandFactory, Parser, Subcommand};

use crate::cli::commands::{new, paper, report};
use crate::cli::{Program, exit_status};
use crate::entry::Entry;
use crate::systems::texts::TEXTS;

/// Discrete second order constrained Lagrangian systems: the paper's figures, single runs, the list of systems.
///
/// Without a command, `dsocs` reproduces the paper's figures (`dsocs paper`).
#[derive(Debug, Parser)]
#[command(name = "dsocs", version, args_conflicts_with_subcommands = true)]
#[cfg_attr(not(feature = "sweep"), command(after_help = super::NO_SWEEP))]
struct Arguments {
    /// The command; `paper` if there is none.
    #[command(subcommand)]
    command: Option<Command>,
    /// The options for text files.
    #[command(flatten)]
    file: super::arguments::file::FileArguments,
    /// The options of `dsocs paper`, for a call without a command.
    #[command(flatten)]
    paper: paper::PaperArguments,
}

/// The commands of `dsocs`.
#[derive(Debug, Subcommand)]
enum Command {
    /// Reproduce the paper's figures and tables (the default)
    Paper(paper::PaperArguments),
    /// Write a page of all that can be measured: figures, tables, speed against error, theorems, hard cases
    Report(report::ReportArguments),
    /// Create a crate with an example system, as the beginning of your own
    New(new::NewArguments),
    /// The commands that every program over a list of systems has.
    #[command(flatten)]
    Common(super::Command),
}

/// The command line of `dsocs`: as [`super::main`], with `paper` as the command where none is given, and with
/// the hard cases of `stability`.
#[must_use]
pub fn main(entries: impl IntoIterator<Item = Entry>) -> ExitCode {
    let called: Vec<OsString> = std::env::args_os().collect();
    ExitCode::from(main_with_arguments(&called, entries))
}

/// The command line for given words, the name of the program first; returns the exit status. Called by the
/// package of another language. Words that cannot be read end the process.
#[must_use]
pub fn main_with_arguments(called: &[OsString], entries: impl IntoIterator<Item = Entry>) -> u8 {
    let arguments: Arguments = super::arguments(called);
    let program = Program {
        is_dsocs: true,
        shipped: &TEXTS,
        syntax: Arguments::command,
        constants: arguments.file.constants.clone(),
        ..Program::new(entries, called)
    };
    exit_status(
        program
            .verified()
            .and_then(|mut program| match arguments.command {
                None => paper::paper(&arguments.paper),
                Some(Command::Paper(arguments)) => paper::paper(&arguments),
                Some(Command::Report(arguments)) => report::report(&arguments, &mut program),
                Some(Command::New(arguments)) => new::new(&arguments, &mut program),
                Some(Command::Common(command)) => command.execute(&mut program),
            }),
    )
}
