//! `linearize`: the linear model of a system at a state.

use clap::{Args, ValueEnum};
use comfy_table::{Cell, CellAlignment, presets};
use dsocs_core::Quantity;
use dsocs_core::linear::{LinearModel, LinearTime, OperatingPoint};
use serde_json::{Value, json};

use crate::cli::arguments::expression;
use crate::cli::arguments::start::StartArguments;
use crate::cli::output::number::{comma_separated, six_digits};
use crate::cli::output::terminal;
use crate::cli::{CliError, Program};
use crate::entry::{Beginning, Entry};

/// The arguments of `linearize`.
#[derive(Args, Debug)]
#[command(allow_negative_numbers = true)]
pub struct LinearizeArguments {
    /// A system of `list`, or a text file, `swing.dsocs`, or one of its runs, `swing.dsocs:fast`; a program with one system needs none
    system: Option<String>,
    /// The state, and the parameters; with `--q0` alone, the state at rest
    #[command(flatten)]
    from: StartArguments,
    /// Move the state onto the constraints on positions and velocities, by the smallest change to first order
    #[arg(long)]
    project: bool,
    /// The model of the step h, in s, in place of that of the continuous motion
    #[arg(long, value_name = "H", allow_hyphen_values = true, value_parser = expression::number)]
    step: Option<f64>,
    /// The parameters that are inputs [default: all]
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    inputs: Option<Vec<String>>,
    /// The outputs: coordinates (`theta`), velocities (`v_theta`), accelerations (`a_theta`), constraint forces (`force_theta`),
    /// `energy`, observed expressions [default: coordinates and velocities]
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    outputs: Option<Vec<String>>,
    /// The format of the model
    #[arg(long, value_enum, default_value_t = ModelFormat::Text)]
    format: ModelFormat,
}

/// The format in which a model, or equilibria, are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ModelFormat {
    /// Tables for people
    Text,
    /// An object
    Json,
}

/// Writes the linear model of a system to standard output.
///
/// # Errors
///
/// [`CliError`] if there is no such system or name, the state cannot be used, or the system has no linear model there.
pub fn linearize(arguments: &LinearizeArguments, program: &mut Program) -> Result<(), CliError> {
    let entry = program.single_entry(arguments.system.as_deref())?;
    arguments.from.set(entry)?;
    let beginning = beginning(arguments, entry)?;
    beginning.fits(entry.kernel().shape()).map_err(CliError::from)?;
    let mut point = OperatingPoint::new(entry.kernel(), beginning.start());
    if let Some(names) = &arguments.inputs {
        point = point.inputs(names);
    }
    if let Some(names) = &arguments.outputs {
        point = point.outputs(names);
    }
    let model = match arguments.step {
        None => point.continuous(),
        Some(h) => point.step(h),
    }?;
    let output = match arguments.format {
        ModelFormat::Text => text(entry, &model),
        ModelFormat::Json => format!("{:#}\n", encoded(entry, &model)),
    };
    terminal::print(output.as_bytes())
}

/// The state at which the system is linearized.
fn beginning(arguments: &LinearizeArguments, entry: &Entry) -> Result<Beginning, CliError> {
    let from = &arguments.from;
    let q0 = from.q0(entry)?;
    let mut beginning = match from.third_order(entry, &q0)? {
        Some(beginning) => beginning,
        None => Beginning::SecondOrder {
            // a position alone means a state at rest
            v0: if from.gives_only_position() {
                vec![0.0; q0.len()]
            } else {
                from.v0(entry)?
            },
            q0,
        },
    };
    if let Some(near) = from.near(entry)? {
        beginning = Beginning::Near(near, Box::new(beginning));
    }
    if arguments.project || entry.projects() {
        beginning = Beginning::Projected(Box::new(beginning));
    }
    Ok(Beginning::At(from.t0(), Box::new(beginning)))
}

/// A matrix with the names of its rows and columns.
fn matrix(name: &str, entries: &[Vec<f64>], [rows, columns]: [&[Quantity]; 2]) -> String {
    if entries.is_empty() || columns.is_empty() {
        return String::new();
    }
    let right = |text: String| Cell::new(text).set_alignment(CellAlignment::Right);
    let mut table = terminal::table(presets::NOTHING);
    let head = columns.iter().map(|column| right(column.name.to_string()));
    table.add_row([Cell::new(name)].into_iter().chain(head).collect::<Vec<_>>());
    for (quantity, row) in rows.iter().zip(entries) {
        let entries = row.iter().map(|&entry| right(six_digits(entry)));
        let name = Cell::new(format!("  {}", quantity.name));
        table.add_row([name].into_iter().chain(entries).collect::<Vec<_>>());
    }
    block(&table)
}

/// A table, without blanks at the ends of its lines, after an empty line.
pub fn block(table: &comfy_table::Table) -> String {
    let lines = table.lines().map(|line| format!("{}\n", line.trim_end()));
    format!("\n{}", lines.collect::<String>())
}

/// A complex number.
pub fn complex([re, im]: [f64; 2]) -> String {
    if im == 0.0 {
        return six_digits(re);
    }
    let sign = if im < 0.0 { '-' } else { '+' };
    format!("{} {sign} {}i", six_digits(re), six_digits(im.abs()))
}

/// A model, for people.
fn text(entry: &Entry, model: &LinearModel) -> String {
    let point = model.point.any();
    let of = match model.time {
        LinearTime::Continuous => "the continuous motion, z' = A z + B u".to_owned(),
        LinearTime::Step { h } => format!("the step h = {h}, z → A z + B u"),
    };
    let mut text = format!(
        "{} ({}): {of}, y = C z + D u\nabout t = {}, q = {}, v = {}\n",
        entry.name(),
        entry.kind(),
        six_digits(point.t),
        comma_separated(point.q),
        comma_separated(point.v)
    );
    let moves = model.drift.iter().any(|x| *x != 0.0);
    if moves {
        let drift: Vec<String> = model.drift.iter().map(|&x| six_digits(x)).collect();
        let adds = match model.time {
            LinearTime::Continuous => "no equilibrium: at the state itself z' =",
            LinearTime::Step { .. } => "no equilibrium: in the step the state itself changes by",
        };
        text.extend([adds, " ", &drift.join(", "), "\n"]);
    }
    let (states, inputs, outputs) = (&model.states[..], &model.inputs[..], &model.outputs[..]);
    text.push_str(&matrix("A", &model.a, [states, states]));
    text.push_str(&matrix("B", &model.b, [states, inputs]));
    text.push_str(&matrix("C", &model.c, [outputs, states]));
    if model.d.iter().flatten().any(|entry| *entry != 0.0) {
        text.push_str(&matrix("D", &model.d, [outputs, inputs]));
    }
    if let Some(eigenvalues) = model.eigenvalues() {
        let mut table = terminal::table(presets::NOTHING);
        table.add_row(["eigenvalues of A"]);
        for eigenvalue in eigenvalues {
            table.add_row([format!("  {}", complex(eigenvalue))]);
        }
        text.push_str(&block(&table));
    }
    text
}

/// Names, units and meanings.
pub fn quantities(all: &[Quantity]) -> Vec<Value> {
    let each = all.iter();
    each.map(|of| json!({ "name": of.name, "unit": of.unit(), "meaning": of.meaning() }))
        .collect()
}

/// A model as JSON.
fn encoded(entry: &Entry, model: &LinearModel) -> Value {
    let point = model.point.any();
    let step = match model.time {
        LinearTime::Continuous => None,
        LinearTime::Step { h } => Some(h),
    };
    json!({
        "system": entry.name(),
        "kind": entry.kind(),
        "step": step,
        "t": point.t,
        "q": point.q,
        "v": point.v,
        "a": point.a,
        "states": quantities(&model.states),
        "inputs": quantities(&model.inputs),
        "outputs": quantities(&model.outputs),
        "A": model.a,
        "B": model.b,
        "C": model.c,
        "D": model.d,
        "drift": model.drift,
        "measured": model.measured,
        "projection": model.projection,
        "basis": model.basis,
        "basis_after": model.basis_after,
        "eigenvalues": model.eigenvalues(),
    })
}
