//! `run`: one trajectory.

mod description;
mod notes;
mod pictures;
mod plan;

use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::atomic::Ordering;

use clap::Args;

use crate::cli::arguments::accuracy::AccuracyArguments;
use crate::cli::arguments::expression;
use crate::cli::arguments::input::InputArguments;
use crate::cli::arguments::start::{BeginArguments, Component, StartArguments, component};
use crate::cli::output::destination::Destination;
use crate::cli::output::table::{TableFormat, TableWriter};
use crate::cli::output::terminal::tell;
use crate::cli::output::{interrupt, progress};
use crate::cli::page::motion::titles;
use crate::cli::{CliError, Program};
use crate::entry::{Column, RunFailure, UnknownName, columns};
use crate::warnings::{moved_start, passed_inputs};

use description::run_description;
use notes::{RunObservers, jump_warning, many_steps_note, singularity_warning};
use pictures::Pictures;
use plan::{beginning, plan};

pub use description::run_page;

/// The number of nodes between two updates of the progress bar.
const PROGRESS: u64 = 1024;

/// The arguments of `run`.
#[derive(Args, Clone, Debug)]
#[command(allow_negative_numbers = true)]
pub struct RunArguments {
    /// The system: one of `list`, or a text file, `swing.dsocs`, or the run of a name in it, `swing.dsocs:fast`; may be left out if there is only one
    system: Option<String>,
    /// The step h, in s; negative to run back in time
    #[arg(long, value_name = "H", allow_hyphen_values = true, value_parser = expression::number)]
    step: Option<f64>,
    /// The end of the run, in s: a time, also with `--t0`; `until` in a file is how long it takes from `--t0` on
    #[arg(long, value_name = "T", allow_hyphen_values = true, value_parser = expression::number)]
    until: Option<f64>,
    /// Initial position, velocity and time, and the parameters
    #[command(flatten)]
    from: StartArguments,
    /// Parameters that change during the run
    #[command(flatten)]
    inputs: InputArguments,
    /// The second node, a number for each coordinate, instead of a velocity
    #[arg(
        long, value_name = "A,B", allow_hyphen_values = true, value_delimiter = ',', value_parser = component,
        conflicts_with_all = ["v0", "start"]
    )]
    q1: Option<Vec<Component>>,
    /// The rule for the second node, and the projection onto constraints
    #[command(flatten)]
    begin: BeginArguments,
    /// Write every N-th node
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..))]
    every: u64,
    /// Write (and plot) only these columns, in this order
    #[arg(long, value_name = "NAME,NAME", value_delimiter = ',')]
    columns: Option<Vec<String>>,
    /// The table: a .csv or .json file, `-` for CSV on standard output (the default, unless there is a --plot, a --picture or a --report)
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// The format of the table; by default it follows from the name of its file, and on standard output it is CSV
    #[arg(long, value_enum)]
    format: Option<TableFormat>,
    /// Record how regular the equations are at every node: the smallest singular values of D₃ and D₁. The paper's theorem on the
    /// discrete flow requires that neither is zero; report where one is
    #[arg(long)]
    certify: bool,
    /// The order of the step, or a tolerance
    #[command(flatten)]
    accuracy: AccuracyArguments,
    /// A figure of the coordinates (or of --columns) against time: an .svg file, or with the feature `png` a .png file
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// Draw the path of these two columns, the second against the first, instead of columns against time
    #[arg(long, value_name = "NAME,NAME", value_delimiter = ',', requires = "plot")]
    path: Option<Vec<String>>,
    /// A picture of the mechanism at some moments of the run, for systems that are drawn (whatever turns in space is): an .svg file, or with the feature `png` a .png
    /// file
    #[arg(long, value_name = "FILE")]
    picture: Option<PathBuf>,
    /// A page with the moving mechanism and the plots of all columns under one slider: a single .html file
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
}

impl RunArguments {
    /// The system.
    pub fn system(&self) -> Option<&str> {
        self.system.as_deref()
    }

    /// The files that were asked for.
    fn files(&self) -> impl Iterator<Item = &PathBuf> {
        [&self.out, &self.plot, &self.picture, &self.report]
            .into_iter()
            .flatten()
    }

    /// The arguments with a page: at the path that was asked for, else at `otherwise`; and that path.
    pub fn with_page(self, otherwise: PathBuf) -> (Self, PathBuf) {
        let page = self.report.clone().unwrap_or(otherwise);
        let report = Some(page.clone());
        (Self { report, ..self }, page)
    }
}

/// Runs one system and writes its trajectory.
///
/// # Errors
///
/// [`CliError`] if a name does not exist, a file cannot be written or the run fails. The rows before a
/// failure are written, too.
pub fn run(arguments: &RunArguments, program: &mut Program) -> Result<(), CliError> {
    let entry = program.single_entry(arguments.system.as_deref())?;
    arguments.from.set(entry)?;
    let plan = plan(arguments, entry)?;
    let beginning = beginning(arguments, entry)?;
    // a program that reads the rows from standard output may stop the run early, so only a run to a file is
    // announced
    if arguments.files().next().is_some() {
        let note = many_steps_note(&plan, arguments.from.t0());
        note.into_iter().for_each(tell);
    }
    let all = columns(entry.description(), &plan);
    let chosen = chosen_columns(arguments.columns.as_deref(), &all)?;

    let mut pictures = Pictures::create(arguments, entry, &all, &chosen)?;
    let (format, destination) = Destination::new(
        arguments.out.as_deref(),
        arguments.format,
        !pictures.any() || arguments.format.is_some(),
    )?;
    let titles = titles(entry);
    let about = run_description(entry, &plan, &beginning);
    let names = chosen.iter().map(|&column| all[column].name.clone()).collect();
    let mut table = TableWriter::new(format, destination, about.clone(), names);

    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // saturates; only the bar uses it
    let bar = progress::bar(
        ((plan.until - arguments.from.t0()) / plan.h).abs() as u64,
        entry.name(),
    );
    let (mut rows, mut broken) = (0, None);
    let (mut every_value, mut values) = (Vec::new(), Vec::new());
    let mut observers = RunObservers::of(&plan, entry.kernel().shape());
    let (mut unresolved, mut nearly_singular) = (None, None);
    let [mut may_divide, mut third] = [false; 2];
    let interrupted = interrupt::stop_flag();
    let mut moved = None;
    let result = entry.run(&plan, &beginning, &mut |row| {
        observers.look(row);
        (unresolved, nearly_singular) = (row.unresolved, row.nearly_singular);
        let shape = row.declaration.shape();
        (may_divide, third) = (shape.may_divide(), shape.is_of_third_order());
        if interrupted.load(Ordering::Relaxed) {
            return ControlFlow::Break(());
        }
        let index = row.node.index;
        if index % PROGRESS == 0 {
            if index == 0 {
                moved = moved_start(&beginning, shape, row.node.q);
            }
            bar.set_position(index);
        }
        let is_written = index % arguments.every == 0;
        if is_written || pictures.any() {
            row.write(&mut every_value);
        }
        pictures.push(index, &every_value);
        if !is_written {
            return ControlFlow::Continue(());
        }
        values.clear();
        values.extend(chosen.iter().map(|&column| every_value[column]));
        rows += 1;
        match table.row(&values) {
            Ok(()) => ControlFlow::Continue(()),
            Err(error) => {
                broken = Some(error);
                ControlFlow::Break(())
            }
        }
    });
    bar.finish_and_clear();
    let names: Vec<&str> = entry.description().names().collect();
    let of_run = [
        moved,
        passed_inputs(&plan, arguments.from.t0()),
        observers.irregular_nodes.note(),
        observers.errors.note(names.iter().copied(), result.is_err()),
    ];
    let of_steps = [
        unresolved.map(|found| jump_warning(found, third, plan.method)),
        nearly_singular.map(|found| singularity_warning(found, may_divide, third)),
        arguments.accuracy.note(),
    ];
    let looked_at = observers.warnings.notes(&names, plan.method, plan.h);
    let notes = of_run.into_iter().chain(looked_at).chain(of_steps);
    let notes: Vec<String> = notes.flatten().collect();
    // the cause of the end is reported before the notes on the part that was computed
    let fails_on_the_way = result.is_err() && rows > 0;
    if !fails_on_the_way {
        for note in &notes {
            tell(note);
        }
    }
    if let Some(error) = broken {
        return Err(table.get_ref().failed(error));
    }
    if rows > 0 {
        finish(table)?;
        pictures.finish(titles.each_ref().map(String::as_str), &about, &notes)?;
    }
    let is_interrupted = interrupted.load(Ordering::Relaxed);
    ended(result, (rows, destinations(arguments)), notes, is_interrupted)
}

/// The outcome of a run that wrote `rows` rows to `place`: success, an interruption, or a failure with the
/// notes on the rows.
fn ended(
    result: Result<(), RunFailure>,
    (rows, place): (u64, String),
    notes: Vec<String>,
    is_interrupted: bool,
) -> Result<(), CliError> {
    match result {
        Ok(()) if is_interrupted => Err(CliError::Interrupted { rows, place }),
        Ok(()) => Ok(()),
        Err(failure) if rows > 0 => Err(CliError::Partial {
            failure: Box::new(failure),
            rows,
            place,
            notes,
        }),
        Err(failure) => Err(failure.into()),
    }
}

/// The destinations of a run's rows, for people.
fn destinations(arguments: &RunArguments) -> String {
    let places: Vec<String> = arguments.files().map(|path| path.display().to_string()).collect();
    if places.is_empty() {
        "standard output".to_owned()
    } else {
        places.join(" and ")
    }
}

/// Completes the table and its file.
fn finish(table: TableWriter<Destination>) -> Result<(), CliError> {
    let on_stdout = table.get_ref().path().is_none();
    let path = table.get_ref().path().map(PathBuf::from).unwrap_or_default();
    match table.finish() {
        Ok(destination) => destination.finish(),
        Err(error) if on_stdout => Err(CliError::stdout(error)),
        Err(cause) => Err(CliError::Write { path, cause }),
    }
}

/// The numbers of the columns that were asked for.
fn chosen_columns(names: Option<&[String]>, all: &[Column]) -> Result<Vec<usize>, UnknownName> {
    let Some(names) = names else {
        return Ok((0..all.len()).collect());
    };
    names
        .iter()
        .map(|name| {
            all.iter()
                .position(|column| column.name == *name)
                .ok_or_else(|| UnknownName::new("column", name, all.iter().map(|column| column.name.clone())))
        })
        .collect()
}
