//! The command `dsocs`.

mod accuracy;
mod check;
mod destination;
mod error;
mod interrupt;
mod list;
mod output;
mod paper;
mod plot;
mod progress;
mod run;
mod stability;
mod table;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

pub use error::CliError;

/// Discrete second order constrained Lagrangian systems: the paper's figures, single runs, the list of systems.
///
/// Without a command, `dsocs` reproduces the paper's figures (`dsocs paper`).
#[derive(Debug, Parser)]
#[command(name = "dsocs", version, args_conflicts_with_subcommands = true)]
struct Arguments {
    /// What to do.
    #[command(subcommand)]
    command: Option<Command>,
    /// What `dsocs paper` takes.
    #[command(flatten)]
    paper: paper::PaperArguments,
}

/// What to do.
#[derive(Debug, Subcommand)]
enum Command {
    /// Reproduce the paper's figures and tables (the default)
    Paper(paper::PaperArguments),
    /// Run one system and write its trajectory
    Run(Box<run::RunArguments>),
    /// Measure numerical stability on hard cases and hold it against the bars
    Stability(stability::StabilityArguments),
    /// Check the paper's theorems on a system: regularity, symplectic and momentum laws, reversibility, order
    Check(check::CheckArguments),
    /// List the systems with their parameters
    List(list::ListArguments),
}

/// Reads the command line, does what it says and reports what went wrong on standard error.
#[must_use]
pub fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let result = match arguments.command {
        None => paper::paper(&arguments.paper),
        Some(Command::Paper(arguments)) => paper::paper(&arguments),
        Some(Command::Run(arguments)) => run::run(&arguments),
        Some(Command::Stability(arguments)) => stability::stability(&arguments),
        Some(Command::Check(arguments)) => check::check(&arguments),
        Some(Command::List(arguments)) => list::list(&arguments),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(CliError::Closed) => CliError::Closed.exit_code(),
        Err(error) => {
            eprintln!("error: {error}");
            error.exit_code()
        }
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        super::Arguments::command().debug_assert();
    }
}
