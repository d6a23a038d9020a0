//! The command line over any list of systems.
//!
//! A crate with its own systems needs the declarations and this `main` function:
//!
//! ```no_run
//! use std::process::ExitCode;
//!
//! use dsocs_core::dsocs;
//! use dsocs_systems::{Entry, cli};
//!
//! /// A mass on a spring.
//! #[dsocs {
//!     coordinates(
//!         /// The elongation [m].
//!         x,
//!     );
//!     lagrangian = mass / 2 * dot(x).powi(2) - stiffness / 2 * x.powi(2);
//! }]
//! #[derive(Clone)]
//! struct MassOnSpring {
//!     /// The mass \[kg\].
//!     mass: f64,
//!     /// The stiffness of the spring [N/m].
//!     stiffness: f64,
//! }
//!
//! fn main() -> ExitCode {
//!     cli::main([Entry::new(MassOnSpring { mass: 1.0, stiffness: 4.0 }).start([1.0], [0.0])])
//! }
//! ```
//!
//! Then `cargo run -- list` lists the system, `run --plot x.svg` runs it, `check` checks the paper's theorems on it, and `stability` tests
//! its numerics; `--help` says more. If there is only one system, its name can be left out.

pub(crate) mod arguments;
mod commands;
#[cfg(all(feature = "dsocs", not(test)))]
pub mod dsocs;
mod error;
mod figures;
mod output;
mod page;
#[cfg(test)]
mod tests;

use std::ffi::OsString;
use std::path::Path;
use std::process::ExitCode;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{CommandFactory, Parser, Subcommand};

use crate::entry::{Entry, EntryError, Mistake, Shipped, UnknownName};

use arguments::file;
#[cfg(feature = "sweep")]
use commands::sweep::{self, map};
use commands::{check, linear, list, manual, run, stability, text, watch};
use output::terminal;

pub use commands::run::run_page;
pub use error::CliError;

/// Discrete second order constrained Lagrangian systems: single runs, checks, the list of systems.
#[derive(Debug, Parser)]
#[command(subcommand_required = true, arg_required_else_help = true)]
#[cfg_attr(not(feature = "sweep"), command(after_help = NO_SWEEP))]
struct Arguments {
    /// The command.
    #[command(subcommand)]
    command: Command,
    /// The options for text files.
    #[command(flatten)]
    file: file::FileArguments,
}

/// The help text on commands that are missing without the feature `sweep`.
#[cfg(not(feature = "sweep"))]
const NO_SWEEP: &str = "Many runs by a plan, here or on a cluster (`sweep`, `plot`): they need the feature `sweep` of dsocs-systems. \
    In a crate of your own, write it into `Cargo.toml`: `dsocs-systems = { …, features = [\"cli\", \"sweep\"] }`. In a checkout of dsocs: \
    `cargo run --release --features sweep -- sweep --help`";

/// The commands that every program has.
#[derive(Debug, Subcommand)]
enum Command {
    /// Run one system and write its trajectory
    Run(Box<run::RunArguments>),
    /// Run a text file at every save, and show the page in a browser that reloads it
    Watch(Box<watch::WatchArguments>),
    /// Measure numerical stability on hard cases, and compare each value with its limit
    Stability(stability::StabilityArguments),
    /// Check the paper's theorems on a system: regularity, symplectic and momentum laws, reversibility, order
    Check(check::CheckArguments),
    /// The linear model of a system at a state: A, B, C and D of its continuous motion, or of its step
    Linearize(Box<linear::linearize::LinearizeArguments>),
    /// States of rest, with their eigenvalues
    Equilibrium(linear::equilibrium::EquilibriumArguments),
    /// Run a plan of many runs, on this machine or as a task of a scheduler
    #[cfg(feature = "sweep")]
    Sweep(sweep::SweepArguments),
    /// Draw a sweep: a map over two quantities that vary, or curves over one
    #[cfg(feature = "sweep")]
    Plot(map::MapArguments),
    /// List the systems with their parameters
    List(list::ListArguments),
    /// Write a system as a text file to standard output: what every command takes in place of a name
    Text(text::TextArguments),
    /// Write completions for a shell to standard output
    Completions(manual::CompletionsArguments),
    /// Write a page of the manual to standard output
    Man(manual::ManArguments),
}

impl Command {
    /// Carries out the command.
    fn execute(&self, program: &mut Program) -> Result<(), CliError> {
        match self {
            Self::Run(arguments) => run::run(arguments, program),
            Self::Watch(arguments) => watch::watch(arguments, program),
            Self::Stability(arguments) => stability::stability(arguments, program),
            Self::Check(arguments) => check::check(arguments, program),
            Self::Linearize(arguments) => linear::linearize::linearize(arguments, program),
            Self::Equilibrium(arguments) => linear::equilibrium::equilibrium(arguments, program),
            #[cfg(feature = "sweep")]
            Self::Sweep(arguments) => sweep::sweep(arguments, program),
            #[cfg(feature = "sweep")]
            Self::Plot(arguments) => map::plot(arguments),
            Self::List(arguments) => list::list(arguments, program),
            Self::Text(arguments) => text::text(arguments, program),
            Self::Completions(arguments) => manual::completions(arguments, program),
            Self::Man(arguments) => manual::man(arguments, program),
        }
    }
}

/// The program's systems, and its call.
struct Program {
    /// The program's name.
    name: String,
    /// The systems, at least one.
    entries: Vec<Entry>,
    /// The mistake of each entry, if it has one.
    mistakes: Vec<Option<EntryError>>,
    /// The systems that it holds as texts, which are parsed when they are asked for.
    shipped: &'static [Shipped],
    /// The systems that were read from text files: the name that was asked for, and the index among the
    /// entries.
    read: Vec<(String, usize)>,
    /// The syntax of its arguments.
    syntax: fn() -> clap::Command,
    /// Values that replace those of constants in text files.
    constants: Vec<(String, f64)>,
    /// Whether it is `dsocs`, whose systems have hard cases with known answers.
    #[cfg(all(feature = "dsocs", not(test)))]
    is_dsocs: bool,
}

/// The command line over some systems: reads the arguments, carries out the command, and reports errors on standard error.
#[must_use]
pub fn main(entries: impl IntoIterator<Item = Entry>) -> ExitCode {
    let called: Vec<OsString> = std::env::args_os().collect();
    let Arguments { command, file } = arguments(&called);
    let program = Program {
        constants: file.constants,
        ..Program::new(entries, &called)
    };
    let result = program
        .verified()
        .and_then(|mut program| command.execute(&mut program));
    ExitCode::from(exit_status(result))
}

/// Names of options in other programs, and the option that each is here.
const OPTION_ALIASES: [(&str, &str); 22] = [
    ("--dt", "--step"),
    ("--h", "--step"),
    ("--timestep", "--step"),
    ("--time-step", "--step"),
    ("--stepsize", "--step"),
    ("--step-size", "--step"),
    ("--delta-t", "--step"),
    ("--tend", "--until"),
    ("--t-end", "--until"),
    ("--t1", "--until"),
    ("--end", "--until"),
    ("--duration", "--until"),
    ("--time", "--until"),
    ("--tol", "--tolerance"),
    ("--rtol", "--tolerance"),
    ("--x0", "--q0"),
    ("--initial", "--q0"),
    ("--param", "--set"),
    ("--parameter", "--set"),
    ("--output", "--out"),
    ("--method", "--order"),
    ("--force", "--input"),
];

/// The arguments in the words of the call; ends the program where they cannot be read.
fn arguments<P: Parser>(called: &[OsString]) -> P {
    let words = called.iter().map(|word| word.to_string_lossy().into_owned());
    P::try_parse_from(called).unwrap_or_else(|error| with_option_hint(error, &P::command(), words).exit())
}

/// An error of the arguments, with a hint where an option was given by its name in another program.
fn with_option_hint(
    mut error: clap::Error,
    syntax: &clap::Command,
    given: impl Iterator<Item = String>,
) -> clap::Error {
    let Some(ContextValue::String(option)) = error.get(ContextKind::InvalidArg) else {
        return error;
    };
    let option = option.split('=').next().unwrap_or_default().to_owned();
    let command = given.skip(1).find_map(|word| syntax.find_subcommand(word));
    if error.kind() != ErrorKind::UnknownArgument {
        return error;
    }
    if command.is_some_and(|command| command.get_name() == "check") && option == "--input" {
        let advice = "the theorems are about a motion whose parameters stay: '--set NAME=VALUE' gives the value that is held; \
                      'run --input NAME=FILE --estimate-error' measures the error of a run whose inputs change";
        error.remove(ContextKind::SuggestedArg);
        error.insert(
            ContextKind::Suggested,
            ContextValue::StyledStrs(vec![advice.into()]),
        );
        return error;
    }
    let meant = OPTION_ALIASES
        .iter()
        .find(|(name, _)| *name == option)
        .map(|(_, meant)| *meant);
    let known = |meant: &&str| {
        let mut arguments = command.into_iter().flat_map(clap::Command::get_arguments);
        arguments.any(|argument| {
            argument
                .get_long()
                .is_some_and(|long| meant.strip_prefix("--") == Some(long))
        })
    };
    if let Some(meant) = meant.filter(known) {
        error.remove(ContextKind::Suggested);
        error.insert(ContextKind::SuggestedArg, ContextValue::String(meant.to_owned()));
    }
    error
}

/// Reports what went wrong, and gives the exit status.
fn exit_status(result: Result<(), CliError>) -> u8 {
    match result {
        Ok(()) => 0,
        Err(CliError::Closed) => CliError::Closed.status(),
        Err(error) => {
            terminal::tell(format_args!("error: {}", error.plain()));
            error.status()
        }
    }
}

impl Program {
    /// The program as it was called, its own name first.
    fn new(entries: impl IntoIterator<Item = Entry>, called: &[OsString]) -> Self {
        let stem = called.first().and_then(|path| Path::new(path).file_stem());
        Self {
            #[cfg(all(feature = "dsocs", not(test)))]
            is_dsocs: false,
            name: stem.map_or_else(|| "dsocs".to_owned(), |stem| stem.to_string_lossy().into_owned()),
            entries: entries.into_iter().collect(),
            mistakes: Vec::new(),
            shipped: &[],
            read: Vec::new(),
            syntax: Arguments::command,
            constants: Vec::new(),
        }
    }

    /// The syntax of its arguments, under its own name.
    fn syntax(&self) -> clap::Command {
        (self.syntax)().name(self.name.clone())
    }

    /// Looks for mistakes in the entries. An entry with a mistake is refused when it is asked for; the others
    /// can be used.
    fn verified(self) -> Result<Self, CliError> {
        if self.entries.is_empty() {
            return Err(CliError::NoSystems);
        }
        let twice = |entry: &Entry| {
            let same = self.entries.iter().filter(|other| other.name() == entry.name());
            (same.count() > 1).then(|| EntryError {
                name: entry.name().to_owned(),
                cause: Mistake::Twice,
            })
        };
        let mistakes = self
            .entries
            .iter()
            .map(|entry| entry.verify().err().or_else(|| twice(entry)));
        Ok(Self {
            mistakes: mistakes.collect(),
            ..self
        })
    }

    /// The system at an index, or its mistake.
    fn entry_at(&mut self, place: usize) -> Result<&mut Entry, CliError> {
        match self.mistakes.get(place) {
            Some(Some(mistake)) => Err(mistake.clone().into()),
            _ => Ok(&mut self.entries[place]),
        }
    }

    /// The system of this name, or in the text file of this name.
    fn find(&mut self, name: &str) -> Result<&mut Entry, CliError> {
        let place = self.index_of(name)?;
        self.entry_at(place)
    }

    /// The index of the system of this name. One in a text file is read, and comes last.
    fn index_of(&mut self, name: &str) -> Result<usize, CliError> {
        if let Some(place) = self.entries.iter().position(|entry| entry.name() == name) {
            return Ok(place);
        }
        if let Some((_, place)) = self.read.iter().find(|(read, _)| read == name) {
            return Ok(*place);
        }
        let shipped = self.shipped.iter().find(|shipped| shipped.name == name);
        let entry = match shipped {
            Some(shipped) => Some(shipped.entry(&self.constants)?),
            None => file::entry(name, &self.constants)?,
        };
        let Some(entry) = entry else {
            let unknown = UnknownName::new("system", name, self.names());
            return Err(match file::file_hint(name) {
                Some(hint) => unknown.of_other_kind(hint),
                None => unknown,
            }
            .into());
        };
        self.mistakes.push(entry.verify().err());
        self.read.push((name.to_owned(), self.entries.len()));
        self.entries.push(entry);
        Ok(self.entries.len() - 1)
    }

    /// The names of all systems but those of text files.
    fn names(&self) -> impl Iterator<Item = String> {
        let own = self.entries.iter().map(|entry| entry.name().to_owned());
        let shipped = self.shipped.iter().map(|shipped| shipped.name.to_owned());
        own.chain(shipped)
    }

    /// Parses all systems that the program holds as texts.
    fn read_shipped(&mut self) -> Result<(), CliError> {
        let shipped = self.shipped;
        shipped
            .iter()
            .try_for_each(|shipped| self.index_of(shipped.name).map(drop))
    }

    /// Drops the systems of text files, which are read again.
    fn drop_entries_from(&mut self, entries: usize) {
        self.read.clear();
        self.entries.truncate(entries);
        self.mistakes.truncate(entries);
    }

    /// The systems without mistakes, for commands that take all. Each system that is left out is reported.
    fn entries_without_mistakes(&mut self) -> Vec<&mut Entry> {
        for mistake in self.mistakes.iter().flatten() {
            terminal::tell(format_args!("warning: a system is left out: {mistake}"));
        }
        let entries = self.entries.iter_mut().zip(&self.mistakes);
        let sound = entries.filter(|(_, mistake)| mistake.is_none());
        sound.map(|(entry, _)| entry).collect()
    }

    /// The system of a name; without a name, the only system.
    fn single_entry(&mut self, name: Option<&str>) -> Result<&mut Entry, CliError> {
        match name {
            Some(name) => self.find(name),
            None if self.entries.len() == 1 => self.entry_at(0),
            None => Err(CliError::Which {
                known: self.names().collect(),
            }),
        }
    }

    /// The systems of these names; without names, all systems.
    fn entries_named(&mut self, names: &[String]) -> Result<Vec<&mut Entry>, CliError> {
        if names.is_empty() {
            self.read_shipped()?;
            return Ok(self.entries_without_mistakes());
        }
        let mut places = Vec::new();
        for name in names {
            let place = self.index_of(name)?;
            self.entry_at(place)?;
            places.push(place);
        }
        let mut chosen: Vec<(usize, &mut Entry)> = self
            .entries
            .iter_mut()
            .enumerate()
            .filter_map(|(place, entry)| Some((places.iter().position(|&chosen| chosen == place)?, entry)))
            .collect();
        chosen.sort_by_key(|(wanted, _)| *wanted);
        Ok(chosen.into_iter().map(|(_, entry)| entry).collect())
    }
}
