//! `dsocs list`: the systems.

use std::io::Write;

use clap::{Args, ValueEnum};
use comfy_table::{Table, presets};
use serde::Serialize;

use super::CliError;
use crate::registry::{Entry, Kind, SYSTEMS};

/// What `dsocs list` takes.
#[derive(Args, Debug)]
pub struct ListArguments {
    /// A system, to be told all of it: coordinates, parameters, defaults; without one, a line for each
    system: Option<String>,

    /// How to write the list
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
}

/// How to write the list.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Format {
    /// A table for people
    Text,
    /// An array of objects
    Json,
}

/// A system, as it is listed.
#[derive(Serialize)]
struct Listed {
    /// The name that `dsocs run` takes.
    name: &'static str,
    /// The kind of its constraints.
    kind: Kind,
    /// What it is.
    summary: &'static str,
    /// Where it comes from.
    source: &'static str,
    /// The coordinates.
    coordinates: &'static [&'static str],
    /// The coordinates' units.
    units: &'static [&'static str],
    /// The parameters.
    parameters: Vec<ListedParameter>,
    /// The observed expressions.
    observables: &'static [&'static str],
    /// What a run takes unless told otherwise.
    defaults: Defaults,
}

/// A parameter, as it is listed.
#[derive(Serialize)]
struct ListedParameter {
    /// The name that `--set` takes.
    name: &'static str,
    /// The value unless set.
    default: f64,
    /// The unit.
    unit: &'static str,
    /// What it is.
    description: &'static str,
}

/// What a run takes unless told otherwise.
#[derive(Serialize)]
struct Defaults {
    /// The step.
    step: f64,
    /// The end.
    until: f64,
    /// The first node.
    q0: &'static [f64],
    /// The initial velocity.
    v0: &'static [f64],
}

impl Listed {
    /// What is listed of a system.
    fn new(entry: &Entry) -> Self {
        let mut system = (entry.build)();
        let parameters = system.parameters().into_iter().map(|parameter| ListedParameter {
            name: parameter.name,
            default: parameter.value,
            unit: parameter.unit,
            description: parameter.description,
        });
        Self {
            name: entry.name,
            kind: entry.kind,
            summary: entry.summary,
            source: entry.source,
            coordinates: system.coordinates(),
            units: entry.units,
            parameters: parameters.collect(),
            observables: system.observables(),
            defaults: Defaults {
                step: entry.step,
                until: entry.until,
                q0: entry.q0,
                v0: entry.v0,
            },
        }
    }
}

/// Lists the systems, or one, on standard output.
///
/// # Errors
///
/// [`CliError`] if there is no system of the name, or if the list cannot be written.
pub fn list(arguments: &ListArguments) -> Result<(), CliError> {
    let text = match (&arguments.system, arguments.format) {
        (Some(name), format) => {
            let system = Listed::new(Entry::find(name)?);
            match format {
                Format::Text => text(&system),
                Format::Json => format!("{:#}\n", serde_json::json!(system)),
            }
        }
        (None, Format::Text) => by_kind(),
        (None, Format::Json) => {
            let systems: Vec<Listed> = SYSTEMS.iter().map(Listed::new).collect();
            format!("{:#}\n", serde_json::json!(systems))
        }
    };
    std::io::stdout()
        .write_all(text.as_bytes())
        .map_err(CliError::stdout)
}

/// The systems kind by kind, a line for each.
fn by_kind() -> String {
    let width = SYSTEMS.iter().map(|entry| entry.name.len()).max().unwrap_or(0);
    let mut list = String::new();
    for kind in Kind::ALL {
        let of_kind: Vec<String> = SYSTEMS
            .iter()
            .filter(|entry| entry.kind == kind)
            .map(|entry| format!("  {:width$}  {}\n", entry.name, entry.summary))
            .collect();
        if !of_kind.is_empty() {
            list.extend([format!("{kind}\n"), of_kind.concat(), "\n".to_owned()]);
        }
    }
    list + "Coordinates, parameters and defaults of one: `dsocs list SYSTEM`.\n"
}

/// A system, for people.
fn text(system: &Listed) -> String {
    let coordinates: Vec<String> = system
        .coordinates
        .iter()
        .zip(system.units)
        .map(|(name, unit)| format!("{name} [{unit}]"))
        .collect();
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.set_header(["  parameter", "default", "unit", "meaning"]);
    for parameter in &system.parameters {
        let name = format!("  {}", parameter.name);
        table.add_row([
            name,
            parameter.default.to_string(),
            parameter.unit.into(),
            parameter.description.into(),
        ]);
    }
    let defaults = &system.defaults;
    format!(
        "{} ({}): {}\n  source: {}\n  coordinates: {}\n  observed: {}\n  a run: --step {} --until {} --q0 {} --v0 {}\n{}\n",
        system.name,
        system.kind,
        system.summary,
        system.source,
        coordinates.join(", "),
        if system.observables.is_empty() {
            "nothing".to_owned()
        } else {
            system.observables.join(", ")
        },
        defaults.step,
        defaults.until,
        joined(defaults.q0),
        joined(defaults.v0),
        table
            .lines()
            .map(|line| line.trim_end().to_owned())
            .collect::<Vec<_>>()
            .join("\n"),
    )
}

/// Numbers as `--q0` takes them.
fn joined(numbers: &[f64]) -> String {
    numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(",")
}
