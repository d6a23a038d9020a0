//! `run`: one trajectory.

use std::io::Write;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::atomic::Ordering;

use clap::Args;
use dsocs_core::{NearlySingular, RunError, Shape, Stop, Unresolved};
use serde_json::{Map, Value, json};

use super::accuracy::{AccuracyArguments, Errors};
use super::destination::Destination;
use super::expression;
use super::input::InputArguments;
use super::motion::{MotionPage, titles};
use super::output::OutputFile;
use super::picture::Picture;
use super::plot::Plot;
use super::start::{BeginArguments, Component, StartArguments, StartOption, component, vector};
use super::table::{TableFormat, TableWriter};
use super::terminal::tell;
use super::{CliError, Program, interrupt, page, progress};
use crate::entry::{Beginning, Column, Entry, Method, Plan, Row, RunFailure, UnknownName, columns};
use crate::stability::number;
use crate::warnings::{Warnings, moved_start, passed_inputs};

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
/// failure are written all the same.
pub fn run(arguments: &RunArguments, program: &mut Program) -> Result<(), CliError> {
    let entry = program.single_entry(arguments.system.as_deref())?;
    arguments.from.set(entry)?;
    let plan = plan(arguments, entry)?;
    let beginning = beginning(arguments, entry)?;
    // a reader of standard output may leave when it has enough
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

    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // saturates; it is but a bar
    let bar = progress::bar(
        ((plan.until - arguments.from.t0()) / plan.h).abs() as u64,
        entry.name(),
    );
    let (mut rows, mut broken) = (0, None);
    let (mut every_value, mut values) = (Vec::new(), Vec::new());
    let mut observers = RunObservers::of(plan.method, entry.kernel().shape());
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
    // the cause of the end is told before the notes on the part that was computed
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

/// The result of a run that has written so many rows to a place.
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

/// The observers of every node, which give notes at the end.
struct RunObservers {
    irregular_nodes: IrregularNodes,
    errors: Errors,
    warnings: Warnings,
}

impl RunObservers {
    /// The observers for a run of a system by a method.
    fn of(method: Method, shape: &Shape) -> Self {
        Self {
            irregular_nodes: IrregularNodes::default(),
            errors: Errors::default(),
            warnings: Warnings::of(method, shape),
        }
    }

    /// Looks at a node.
    fn look(&mut self, row: &Row<'_>) {
        self.irregular_nodes.look(row);
        self.errors.look(row);
        self.warnings.look(row);
    }
}

/// The figure, the picture and the page of a run.
struct Pictures {
    /// The figure.
    plot: Option<Plot>,
    /// The picture of the mechanism.
    picture: Option<Picture>,
    /// The page and its file.
    report: Option<(OutputFile, MotionPage)>,
}

impl Pictures {
    /// Creates those that were asked for.
    fn create(
        arguments: &RunArguments,
        entry: &mut Entry,
        all: &[Column],
        chosen: &[usize],
    ) -> Result<Self, CliError> {
        let plot = match &arguments.plot {
            Some(path) => {
                let coordinates = 1..=entry.description().coordinates.len();
                let shown = match arguments.columns {
                    Some(_) => chosen.to_vec(),
                    None => coordinates.collect(),
                };
                let path_of = path_of(arguments.path.as_deref(), all)?;
                Some(Plot::create(path, all, &shown, path_of)?)
            }
            None => None,
        };
        let picture = match &arguments.picture {
            Some(path) => Some(Picture::create(path, entry, all)?),
            None => None,
        };
        let report = match &arguments.report {
            // a path that cannot be written is found before the run
            Some(path) => {
                page::check_name(path)?;
                let file = OutputFile::create(path)?;
                let draw = entry.drawing();
                Some((file, MotionPage::new(all, entry.description(), draw)))
            }
            None => None,
        };
        Ok(Self {
            plot,
            picture,
            report,
        })
    }

    /// Whether any was asked for.
    fn any(&self) -> bool {
        self.plot.is_some() || self.picture.is_some() || self.report.is_some()
    }

    /// Takes the number of a node and, if anything is asked for, the values of all columns there.
    #[inline]
    fn push(&mut self, index: u64, values: &[f64]) {
        // most runs have none
        if self.plot.is_some() || self.picture.is_some() || self.report.is_some() {
            self.draw(index, values);
        }
    }

    /// Takes a node; out of line, because most runs have no pictures.
    #[inline(never)]
    fn draw(&mut self, index: u64, values: &[f64]) {
        if let Some(plot) = &mut self.plot {
            plot.push(index, values);
        }
        if let Some(picture) = &mut self.picture {
            picture.push(index, values);
        }
        if let Some((_, report)) = &mut self.report {
            report.push(index, values);
        }
    }

    /// Completes them.
    fn finish(self, titles: [&str; 3], about: &Map<String, Value>, notes: &[String]) -> Result<(), CliError> {
        self.plot.map_or(Ok(()), Plot::finish)?;
        self.picture.map_or(Ok(()), Picture::finish)?;
        let Some((mut file, report)) = self.report else {
            return Ok(());
        };
        let page = report.finish(titles, about, notes);
        if let Err(cause) = file.write_all(page.as_bytes()) {
            return Err(file.failed(cause));
        }
        file.finish()
    }
}

/// The page of a finished run, as `run --report` writes it. `rows` has the values of all [`columns`] at each
/// node, in their order, and after them those of the parameters that changed on the way, whose names are
/// `changed`; `notes` are the messages of the run.
///
/// ```
/// use dsocs_core::text::Text;
/// use dsocs_systems::entry::{Beginning, Method, Plan};
/// use dsocs_systems::{Entry, cli};
/// use std::ops::ControlFlow;
///
/// let text = Text::parse("spring", "coordinates(x); lagrangian = dot(x).powi(2) / 2 - 2 * x.powi(2);")?;
/// let mut entry = Entry::of_text("spring", &text, None);
/// let plan = Plan { h: 0.01, until: 1.0, method: Method::Step, certify: false, estimate: false, inputs: Vec::new() };
/// let beginning = Beginning::SecondOrder { q0: vec![1.0], v0: vec![0.0] };
/// let mut rows = Vec::new();
/// entry.run(&plan, &beginning, &mut |row| {
///     let mut values = Vec::new();
///     row.write(&mut values);
///     rows.push(values);
///     ControlFlow::Continue(())
/// })?;
/// assert!(cli::run_page(&mut entry, &plan, &beginning, &[], rows, &[]).starts_with("<!DOCTYPE html>"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[must_use]
pub fn run_page(
    entry: &mut Entry,
    plan: &Plan,
    beginning: &Beginning,
    changed: &[String],
    rows: impl IntoIterator<Item = Vec<f64>>,
    notes: &[String],
) -> String {
    let draw = entry.drawing();
    let mut all = columns(entry.description(), plan);
    let parameters = entry.parameters();
    all.extend(changed.iter().map(|name| {
        let known = parameters.iter().find(|(parameter, _)| parameter.name == **name);
        Column {
            name: name.clone(),
            unit: known.and_then(|(parameter, _)| parameter.unit().map(str::to_owned)),
        }
    }));
    let mut page = MotionPage::new(&all, entry.description(), draw);
    for (index, values) in (0..).zip(rows) {
        page.push(index, &values);
    }
    let mut about = run_description(entry, plan, beginning);
    if let Some(Value::Object(values)) = about.get_mut("parameters") {
        for name in changed {
            if let Some(value) = values.get_mut(name) {
                *value = format!("{value} at the start, then as shown").into();
            }
        }
    }
    page.finish(titles(entry).each_ref().map(String::as_str), &about, notes)
}

/// The plan of the run that was asked for.
fn plan(arguments: &RunArguments, entry: &Entry) -> Result<Plan, CliError> {
    let accuracy = &arguments.accuracy;
    let (nodes, start) = (arguments.q1.is_some(), arguments.begin.start.is_some());
    accuracy.check(nodes, start, arguments.certify)?;
    let h = arguments.step.unwrap_or(entry.default_step());
    let until = arguments
        .until
        .unwrap_or(arguments.from.t0() + entry.until_with(h));
    if until.is_infinite() {
        return Err(RunFailure::from(RunError::Until { until }).into());
    }
    Ok(Plan {
        h,
        until,
        method: accuracy.method(),
        certify: arguments.certify,
        estimate: accuracy.estimates(),
        inputs: arguments.inputs.read(entry)?,
    })
}

/// A run of more steps is announced before it begins.
const MANY_STEPS: f64 = 1e8;

/// A note on a run of many steps.
fn many_steps_note(plan: &Plan, t0: f64) -> Option<String> {
    let steps = ((plan.until - t0) / plan.h).abs();
    (steps > MANY_STEPS && !matches!(plan.method, Method::Tolerance(_))).then(|| {
        format!(
            "note: this run has {steps:.1e} steps; Ctrl-C ends it, and what is computed by then is written (`--until` and `--step` give fewer, `--every` \
             writes fewer rows)"
        )
    })
}

/// The nodes at which a certified run is not regular.
#[derive(Default)]
struct IrregularNodes {
    /// The first of them: its number, its time, and which of the flows (forward, backward) is not granted.
    first: Option<(u64, f64, &'static str)>,
    /// The number of such nodes.
    count: u64,
}

impl IrregularNodes {
    /// Looks at a node. The start has no step that could be regular; of third order, neither has the node
    /// after it, which the given acceleration determines.
    fn look(&mut self, row: &Row<'_>) {
        let third = row.declaration.shape().is_of_third_order();
        let Some(regularity) = row.regularity.filter(|_| row.node.stop != Stop::Start) else {
            return;
        };
        let which = match (regularity.grants_forward(), regularity.grants_backward(), third) {
            (true, true, _) => return,
            (false, true, false) => "D₃ is singular, no forward flow is granted",
            (false, true, true) => "D₄ is singular, no forward flow is granted",
            (true, false, _) => "D₁ is singular, no backward flow is granted",
            (false, false, false) => "D₃ and D₁ are singular, no flow is granted",
            (false, false, true) => "D₄ and D₁ are singular, no flow is granted",
        };
        self.first.get_or_insert((row.node.index, row.node.t, which));
        self.count += 1;
    }

    /// The note at the end of the run.
    fn note(&self) -> Option<String> {
        let (index, t, which) = self.first?;
        Some(format!(
            "note: regularity is lost at {} node{}, first at node {index}, t = {t}: {which}",
            self.count,
            if self.count == 1 { "" } else { "s" }
        ))
    }
}

/// A warning about steps within which a function jumps.
fn jump_warning(
    Unresolved {
        steps,
        first,
        largest,
    }: Unresolved,
    third: bool,
    method: Method,
) -> String {
    // no method follows the continuous motion of a third-order system
    let [ends, goes_on] = if third {
        ["end the run before", "a smaller `--step`"]
    } else {
        [
            "`--tolerance` goes on where the force is finite, and ends where the motion does",
            "`--tolerance` goes on from the place of the jump itself; or a smaller `--step`; `--estimate-error` measures what it costs",
        ]
    };
    let (plural, first) = (if steps == 1 { "" } else { "s" }, number(first));
    if largest.is_infinite() {
        return format!(
            "warning: a force is infinite, or very large for a short time, or the velocity has to jump, within {steps} step{plural} that the run has passed, first about t = {first}: what \
             comes after depends on where the nodes lie ({ends})"
        );
    }
    // a jump in a derivative of the Lagrangian does not lower the order of the step of order 2
    let at_best = if matches!(method, Method::Composed(_)) {
        ", or of the second at best,"
    } else {
        ""
    };
    format!(
        "warning: a force or a constraint jumps, or nearly so, within {steps} step{plural}, first about t = {first}: there the motion has an error of the first \
         order in the step{at_best} ({goes_on})"
    )
}

/// A warning about steps in which the equations were nearly singular.
fn singularity_warning(
    NearlySingular {
        steps,
        first,
        of_step,
    }: NearlySingular,
    may_divide: bool,
    third: bool,
) -> String {
    let (plural, first) = (if steps == 1 { "" } else { "s" }, number(first));
    if of_step == steps {
        return format!(
            "warning: the equations of the step pass through a singularity in {steps} step{plural}, first about t = {first}, where those of the continuous motion have none: \
             a force changes too fast with the velocity for this step, or the velocity grows beyond all bounds, and what comes after may not be the motion (a smaller \
             `--step`{})",
            if third {
                ""
            } else {
                "; `--tolerance 1e-9` ends where the motion does"
            }
        );
    }
    let factor = if may_divide {
        "; a factor of a constraint that vanishes with positions or velocities may be divided out, `branch = divide(factor)`"
    } else {
        ""
    };
    format!(
        "warning: the equations are nearly singular in {steps} step{plural}, first about t = {first}: they hardly determine the {} there, and the error of \
         the motion may be much larger than elsewhere, with that of multipliers (a smaller `--step` shows it{factor})",
        if third { "jerk" } else { "acceleration" }
    )
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

/// The start that was asked for.
fn beginning(arguments: &RunArguments, entry: &Entry) -> Result<Beginning, CliError> {
    let q0 = arguments.from.q0(entry)?;
    let v0 = || arguments.from.v0(entry);
    let q1 = vector("--q1", arguments.q1.as_deref(), None, entry)?;
    let given = match (q1, arguments.begin.start) {
        (Some(q1), _) => Beginning::Nodes { q0, q1 },
        (None, Some(StartOption::Paper)) => Beginning::Paper { q0, v0: v0()? },
        (None, Some(StartOption::SecondOrder)) => Beginning::SecondOrder { q0, v0: v0()? },
        (None, None) => match arguments.from.third_order(entry, &q0)? {
            Some(third) => third,
            None => Beginning::SecondOrder { q0, v0: v0()? },
        },
    };
    let given = match arguments.from.near(entry)? {
        Some(near) => Beginning::Near(near, Box::new(given)),
        None => given,
    };
    let t0 = arguments.from.t0();
    let given = if t0 == 0.0 {
        given
    } else {
        Beginning::At(t0, Box::new(given))
    };
    Ok(if arguments.begin.project || entry.projects() {
        Beginning::Projected(Box::new(given))
    } else {
        given
    })
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

/// The numbers of the two columns of a path.
fn path_of(names: Option<&[String]>, all: &[Column]) -> Result<Option<[usize; 2]>, CliError> {
    let Some(names) = names else { return Ok(None) };
    let columns = chosen_columns(Some(names), all)?;
    let pair = columns
        .try_into()
        .map_err(|columns: Vec<usize>| CliError::Path { found: columns.len() })?;
    Ok(Some(pair))
}

/// The start as JSON.
fn start_as_json(beginning: &Beginning) -> Value {
    match beginning {
        Beginning::Paper { q0, v0 } => json!({"rule": "paper", "q0": q0, "v0": v0}),
        Beginning::SecondOrder { q0, v0 } => json!({"rule": "second_order", "q0": q0, "v0": v0}),
        Beginning::ThirdOrder { q0, v0, a0 } => {
            json!({"rule": "third_order", "q0": q0, "v0": v0, "a0": a0})
        }
        Beginning::ThirdOrderByForce { q0, v0, force } => {
            json!({"rule": "third_order_by_force", "q0": q0, "v0": v0, "f0": force})
        }
        Beginning::Nodes { q0, q1 } => json!({"rule": "nodes", "q0": q0, "q1": q1}),
        Beginning::ThreeNodes { q0, q1, q2 } => {
            json!({"rule": "three_nodes", "q0": q0, "q1": q1, "q2": q2})
        }
        Beginning::Near(a0, beginning) => {
            let mut start = start_as_json(beginning);
            start["near_a0"] = a0.clone().into();
            start
        }
        Beginning::At(t0, beginning) => {
            let mut start = start_as_json(beginning);
            start["t0"] = (*t0).into();
            start
        }
        Beginning::Projected(beginning) => {
            let mut start = start_as_json(beginning);
            start["projected"] = true.into();
            start
        }
    }
}

/// The description of a run that precedes its rows in JSON.
fn run_description(entry: &mut Entry, plan: &Plan, beginning: &Beginning) -> Map<String, Value> {
    let start = start_as_json(beginning);
    let accuracy = match plan.method {
        Method::Step => json!({"order": 2}),
        Method::Composed(method) => json!({"order": method.order()}),
        Method::Tolerance(tolerance) => json!({"tolerance": tolerance}),
    };
    let parameters: Map<String, Value> = entry
        .parameters()
        .into_iter()
        .map(|(parameter, value)| (parameter.name.into_owned(), value.into()))
        .collect();
    [
        ("system", entry.name().into()),
        ("step", plan.h.into()),
        ("until", plan.until.into()),
        ("accuracy", accuracy),
        ("start", start),
        ("parameters", parameters.into()),
    ]
    .into_iter()
    .map(|(key, value)| (key.to_owned(), value))
    .collect()
}
