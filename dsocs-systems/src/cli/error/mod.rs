//! Errors of the command line, and the exit status of each.

mod advice;

use std::io;
use std::path::PathBuf;

use thiserror::Error;

use crate::entry::{CheckFailure, EntryError, NoText, RunFailure, UnknownName};
#[cfg(all(feature = "dsocs", not(test)))]
use crate::experiment::ExperimentError;
use crate::figure::FigureError;
use dsocs_core::RunError;
use dsocs_core::linear::{EquilibriumError, LinearizationError};
use dsocs_core::text::TextError;

use advice::{options, options_of_check, options_of_model};

/// Options with a place for each number, `--q0 …,… --v0 …,…`.
fn numbered(options: &[&str], count: usize, rotations: usize) -> String {
    let options: Vec<_> = options
        .iter()
        .map(|option| {
            // a rotation has four numbers of position, and three of velocity
            let count = if *option == "--q0" {
                count
            } else {
                count - rotations
            };
            format!("{option} {}", vec!["…"; count].join(","))
        })
        .collect();
    format!("`{}`", options.join(" "))
}

/// A command failed.
#[derive(Error)]
#[non_exhaustive]
pub enum CliError {
    /// A name does not exist.
    #[error(transparent)]
    Unknown(#[from] UnknownName),
    /// A text file does not declare a system.
    #[error(transparent)]
    Text(#[from] TextError),
    /// The name to be watched is not that of a text file.
    #[error(
        "expected a text file, such as `swing.dsocs`, found `{0}`: what is compiled does not change while it runs"
    )]
    NoFile(String),
    /// No page can be shown at a port of this machine.
    #[error("cannot show a page at a port of this machine: {0}")]
    Port(io::Error),
    /// A system contains something that a text file cannot express.
    #[error(transparent)]
    NoText(#[from] NoText),
    /// A system has no linear model at a state.
    #[error("{0}{options}", options = options_of_model(.0))]
    Linearization(#[from] LinearizationError),
    /// There is no equilibrium.
    #[error(transparent)]
    Equilibrium(#[from] EquilibriumError),
    /// A parameter's value is infinite or not a number.
    #[error("parameter `{name}` is {value}; it must be finite")]
    Parameter {
        /// The parameter.
        name: String,
        /// The value.
        value: f64,
    },
    /// A file is not a plan of an input.
    #[error("{file} is no plan of an input: {reason}")]
    Plan {
        /// The file.
        file: String,
        /// The reason.
        reason: String,
    },
    /// The program has no systems.
    #[error("this program has no systems: `cli::main` was given none")]
    NoSystems,
    /// A system's entry contradicts its declaration: a mistake of the program, not of its call.
    #[error(transparent)]
    Entry(#[from] EntryError),
    /// There are several systems, and none was named.
    #[error("which system? known: {}", .known.join(", "))]
    Which {
        /// The systems.
        known: Vec<String>,
    },
    /// There is no start to run from.
    #[error(
        "`{system}` has no start of its own: give one with {}, a number for each coordinate: {}{}{}",
        numbered(.options, .coordinates.len(), *.rotations), .coordinates.join(", "),
        if *.rotations == 0 { "" } else { "; of a rotation the four numbers of a unit quaternion, (w, x, y, z), and three of velocity, in the frame of its body" },
        .in_text
    )]
    NoStart {
        /// The system.
        system: String,
        /// The options that are missing.
        options: Vec<&'static str>,
        /// The coordinates.
        coordinates: Vec<String>,
        /// The number of rotations among them.
        rotations: usize,
        /// The advice for a text file, if the system was read from one.
        in_text: &'static str,
    },
    /// A crate cannot have this name.
    #[error(
        "`{0}` is no name for a new crate: a letter, then letters, digits, `-` and `_`, and none of dsocs' own \
         (`--name` gives another than the folder's)"
    )]
    CrateName(String),
    /// A folder for a new crate has something in it.
    #[error("{} is there already, and not empty", .0.display())]
    Occupied(PathBuf),
    /// A folder is no checkout of dsocs.
    #[error("{} is no checkout of dsocs: it has no dsocs-core and dsocs-systems", .0.display())]
    NoCheckout(PathBuf),
    /// There is no such case.
    #[error("there is no case {number}; the cases are {}", .known.join(", "))]
    NoCase {
        /// The number.
        number: u8,
        /// The numbers of the known cases.
        known: Vec<String>,
    },
    /// An option of one system was given for several.
    #[error("`{option}` is for one system: say which")]
    OneSystem {
        /// The option.
        option: &'static str,
    },
    /// The components of a vector are incomplete, or given in two ways at once.
    #[error(
        "`{option}`: {reason}; expected a number for each coordinate, or `name=number` for those that differ from the system's own start"
    )]
    Components {
        /// The option.
        option: &'static str,
        /// The problem.
        reason: String,
    },
    /// Options that do not go together.
    #[error("`{option}` does not go with `{other}`: {reason}")]
    Conflict {
        /// One of them.
        option: &'static str,
        /// The other.
        other: String,
        /// The reason.
        reason: &'static str,
    },
    /// The name of an output file does not say its format.
    #[error(
        "the name `{0}` does not say the format of the table: a name ends in .csv or .json, or `--format csv` and `--format json` say it"
    )]
    TableFormat(String),
    /// The measured values are written as JSON, and the table of orders also as Markdown.
    #[error(
        "`{0}` is no name for the measured values, which are written as JSON: it has to end in .json (the table of `check --orders` may end in .md)"
    )]
    NotJson(String),
    /// A path does not have two columns.
    #[error("`--path` takes two columns, as in `--path x,y`; {found} given")]
    Path {
        /// The number of columns given.
        found: usize,
    },
    /// The name of a page's file does not end in `.html`.
    #[error("`{0}` is no page: a report's file name ends in .html")]
    PageFormat(String),
    /// A picture is asked of a system without a drawing.
    #[error(
        "nothing says how `{0}` is drawn: `--plot` draws its columns; in Rust, `Entry::drawn` says it, and what turns in space (`r: rotation`) is drawn by itself"
    )]
    NoPicture(String),
    /// A file cannot be read.
    #[error("cannot read {}: {cause}", .path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The reason.
        cause: String,
    },
    /// A file cannot be written.
    #[error("cannot write {}: {cause}", .path.display())]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// The reason.
        cause: io::Error,
    },
    /// Standard output cannot be written.
    #[error("cannot write standard output: {0}")]
    Stdout(io::Error),
    /// The reader of standard output has gone, which is no error.
    #[error("standard output was closed")]
    Closed,
    /// A run ended early or did not begin.
    #[error("{failure}{}", options(.failure))]
    Run {
        /// The cause.
        failure: RunFailure,
    },
    /// A run ended early after some of it had been written.
    #[error(
        "{failure}{}\nwhat was computed before ({rows} row{}) is written to {place}{}",
        options(.failure), if *.rows == 1 { "" } else { "s" },
        .notes.iter().flat_map(|note| ["\n", note]).collect::<String>()
    )]
    Partial {
        /// The cause.
        failure: Box<RunFailure>,
        /// The number of rows written.
        rows: u64,
        /// The destination.
        place: String,
        /// Notes on the rows written.
        notes: Vec<String>,
    },
    /// A run was interrupted; some of it had been written.
    #[error("interrupted; what was computed before ({rows} row{}) is written to {place}", if *.rows == 1 { "" } else { "s" })]
    Interrupted {
        /// The number of rows written.
        rows: u64,
        /// The destination.
        place: String,
    },
    /// A sweep cannot begin or go on.
    #[cfg(feature = "sweep")]
    #[error(transparent)]
    Sweep(#[from] crate::sweep::SweepError),
    /// A sweep was interrupted.
    #[cfg(feature = "sweep")]
    #[error("interrupted; {missing} of {parts} parts are missing, and the same command goes on from there")]
    Stopped {
        /// The parts that are not there.
        missing: u64,
        /// All parts.
        parts: u64,
    },
    /// Parts of a sweep are missing.
    #[cfg(feature = "sweep")]
    #[error("{missing} of {parts} parts are missing; `sweep` with the plan computes them")]
    Missing {
        /// The parts that are not there.
        missing: u64,
        /// All parts.
        parts: u64,
    },
    /// A system could not be checked.
    #[error("{0}{options}", options = options_of_check(.0))]
    Check(#[from] CheckFailure),
    /// Figures of `stability` or `check` do not meet their limits.
    #[error(
        "{missed} measured value{} not meet the limit (FAILED or MISSED in the table): the property in that line does not hold to the accuracy that \
         is required",
        if *.missed == 1 { " does" } else { "s do" }
    )]
    Bars {
        /// The number of values.
        missed: usize,
    },
    /// An experiment of the paper failed.
    #[cfg(all(feature = "dsocs", not(test)))]
    #[error(transparent)]
    Experiment(#[from] ExperimentError),
    /// A figure could not be drawn.
    #[error(transparent)]
    Figure(#[from] FigureError),
}

dsocs_core::debug_is_message!(CliError);

impl CliError {
    /// An error of standard output; one that is closed by its reader becomes `Closed`.
    #[must_use]
    pub fn stdout(error: io::Error) -> Self {
        if error.kind() == io::ErrorKind::BrokenPipe {
            Self::Closed
        } else {
            Self::Stdout(error)
        }
    }

    /// The exit status: 2 for wrong arguments, 1 for a failure on the way, 0 if only the reader of standard
    /// output has gone.
    #[must_use]
    pub fn status(&self) -> u8 {
        match self {
            Self::Closed => 0,
            Self::Unknown(_)
            | Self::Text(_)
            | Self::NoText(_)
            | Self::NoFile(_)
            | Self::Port(_)
            | Self::Parameter { .. }
            | Self::Plan { .. }
            | Self::Read { .. }
            | Self::TableFormat(_)
            | Self::NotJson(_)
            | Self::PageFormat(_)
            | Self::NoPicture(_)
            | Self::Path { .. }
            | Self::Components { .. }
            | Self::Conflict { .. }
            | Self::Which { .. }
            | Self::NoStart { .. }
            | Self::OneSystem { .. }
            | Self::NoCase { .. }
            | Self::CrateName(_)
            | Self::Occupied(_)
            | Self::NoCheckout(_)
            | Self::Linearization(
                LinearizationError::Setup(_)
                | LinearizationError::Input { .. }
                | LinearizationError::Output { .. }
                | LinearizationError::Twice { .. },
            )
            | Self::Equilibrium(
                EquilibriumError::Setup(_)
                | EquilibriumError::Name { .. }
                | EquilibriumError::Length { .. }
                | EquilibriumError::Guess { .. },
            )
            | Self::Check(CheckFailure::Start(RunFailure::Length { .. }) | CheckFailure::Setup(_))
            | Self::Figure(FigureError::Format(_) | FigureError::NoPng)
            | Self::Run {
                failure:
                    RunFailure::Setup(_)
                    | RunFailure::Length { .. }
                    | RunFailure::Run(RunError::TimeBehind { .. } | RunError::Until { .. }),
            } => 2,
            #[cfg(feature = "sweep")]
            Self::Sweep(error) if error.is_wrong_request() => 2,
            #[cfg(feature = "sweep")]
            Self::Stopped { .. } => 130,
            Self::Interrupted { .. } => 130, // the exit status of shells for SIGINT
            _ => 1,
        }
    }
}

impl CliError {
    /// Its message for people who need not know Rust.
    #[must_use]
    pub fn plain(&self) -> String {
        plain(&self.to_string())
    }
}

/// Advice in terms of Rust, and its replacement on the command line.
const IN_RUST: [(&str, &str); 11] = [
    (" (linear::OperatingPoint)", ""),
    (" (`Start::projected`)", ""),
    (" (`Start::second_order`)", ""),
    (" (`Start::third_order(q0, v0, a0)`)", ""),
    (" (`Start::third_order_by_force(q0, v0, force)`)", ""),
    (" (`Start::third_order`)", ""),
    (" (`Start::near_acceleration`)", ""),
    (" (`Start::nodes`)", ""),
    (" (`Start::paper`)", ""),
    (" (Flow)", ""),
    (
        "`Samples::monotone` or `Samples::cubic` for `Samples::linear`",
        "`monotone` or `cubic` for `linear`",
    ),
];

/// A message without names of Rust, and without the operating system's error numbers, ` (os error 2)`.
fn plain(message: &str) -> String {
    let mut parts = message.split(" (os error ");
    let mut plain = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        match part.split_once(')') {
            Some((number, rest)) if number.bytes().all(|byte| byte.is_ascii_digit()) => plain.push_str(rest),
            _ => plain.extend([" (os error ", part]),
        }
    }
    IN_RUST
        .iter()
        .fold(plain, |plain, (rust, words)| plain.replace(rust, words))
}

impl From<RunFailure> for CliError {
    fn from(failure: RunFailure) -> Self {
        Self::Run { failure }
    }
}

#[cfg(test)]
mod tests {
    use super::plain;

    #[test]
    fn messages_are_for_people_who_know_no_rust() {
        for (message, expected) in [
            (
                "cannot read a: No such file or directory (os error 2)",
                "cannot read a: No such file or directory",
            ),
            ("a (os error 2); b (os error 13): c", "a; b: c"),
            ("a (os error x)", "a (os error x)"),
            ("a (os error ", "a (os error "),
            (
                "expected a start that obeys what is declared, or project it (`Start::projected`)\n(on the command line: `--project`)",
                "expected a start that obeys what is declared, or project it\n(on the command line: `--project`)",
            ),
        ] {
            assert_eq!(plain(message), expected);
        }
    }
}
