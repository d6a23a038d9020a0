//! `list`: the systems.

use clap::{Args, ValueEnum};
use comfy_table::presets;
use dsocs_core::{Quantity, geometry};
use serde::Serialize;

use crate::cli::output::number::{comma_separated, shortest};
use crate::cli::output::terminal;
use crate::cli::{CliError, Program};
use crate::entry::{Entry, Kind};

/// The arguments of `list`.
#[derive(Args, Debug)]
pub struct ListArguments {
    /// A system, or a text file, `swing.dsocs`, whose coordinates, parameters, runs and defaults are shown; without it, one line for each system
    system: Option<String>,

    /// The format of the list
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
}

/// The format of the list.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Format {
    /// A table for people
    Text,
    /// An array of objects
    Json,
}

/// A system in the list.
#[derive(Serialize)]
struct ListedSystem<'a> {
    /// The name that `run` takes.
    name: &'a str,
    /// The kind of its constraints.
    kind: Kind,
    /// Its summary.
    summary: &'a str,
    /// Its literature source.
    source: Option<&'a str>,
    /// The coordinates.
    coordinates: Vec<&'a str>,
    /// The coordinates' units.
    units: Vec<Option<&'a str>>,
    /// The meanings of the coordinates.
    meanings: Vec<&'a str>,
    /// The cyclic coordinates: their positions are in no equation.
    reduced: Vec<String>,
    /// The parameters.
    parameters: Vec<ListedParameter>,
    /// The tables of samples, if it was read from a text.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    samples: Vec<ListedTable<'a>>,
    /// The observed expressions.
    observables: Vec<&'a str>,
    /// The units of the observed expressions.
    observable_units: Vec<Option<&'a str>>,
    /// The meanings of the observed expressions.
    observable_meanings: Vec<&'a str>,
    /// The defaults of a run.
    defaults: Defaults<'a>,
}

/// A parameter in the list.
#[derive(Serialize)]
struct ListedParameter {
    /// The name that `--set` takes.
    name: String,
    /// The value unless it is set.
    default: f64,
    /// The unit, if the declaration gives it.
    unit: Option<String>,
    /// Its meaning.
    description: String,
}

/// A table of samples in the list.
#[derive(Serialize)]
struct ListedTable<'a> {
    /// The name of the parameter.
    name: &'a str,
    /// The file, as the text names it.
    file: &'a str,
    /// The kind of interpolation.
    interpolation: &'static str,
    /// Its meaning and unit.
    description: &'a str,
}

/// The defaults of a run.
#[derive(Serialize)]
struct Defaults<'a> {
    /// The step.
    step: f64,
    /// The end.
    until: f64,
    /// The first node, if there is one.
    q0: Option<&'a [f64]>,
    /// The initial velocity, if there is one.
    v0: Option<&'a [f64]>,
    /// The initial acceleration, where a constraint is of third order.
    #[serde(skip_serializing_if = "Option::is_none")]
    a0: Option<&'a [f64]>,
}

/// The names of quantities.
fn names(quantities: &[Quantity]) -> Vec<&str> {
    quantities.iter().map(|quantity| &*quantity.name).collect()
}

/// The units of quantities.
fn units(quantities: &[Quantity]) -> Vec<Option<&str>> {
    quantities.iter().map(Quantity::unit).collect()
}

/// The meanings of quantities.
fn meanings(quantities: &[Quantity]) -> Vec<&str> {
    quantities.iter().map(Quantity::meaning).collect()
}

impl<'a> ListedSystem<'a> {
    /// The record of a system in the list.
    fn new(entry: &'a mut Entry) -> Self {
        let parameters = entry.parameters().into_iter();
        let parameters = parameters.map(|(parameter, default)| ListedParameter {
            name: parameter.name.to_string(),
            default,
            unit: parameter.unit().map(str::to_owned),
            description: parameter.meaning().to_owned(),
        });
        let parameters = parameters.collect();
        let description = entry.description();
        let start = entry.default_start();
        Self {
            name: entry.name(),
            kind: entry.kind(),
            summary: entry.summary(),
            source: entry.origin(),
            coordinates: names(&description.coordinates),
            units: units(&description.coordinates),
            meanings: meanings(&description.coordinates),
            reduced: reduced(entry),
            parameters,
            samples: (entry.tables())
                .map(|table| ListedTable {
                    name: &table.name,
                    file: &table.file,
                    interpolation: table.curve.name(),
                    description: &table.doc,
                })
                .collect(),
            observables: names(&description.observables),
            observable_units: units(&description.observables),
            observable_meanings: meanings(&description.observables),
            defaults: Defaults {
                step: entry.default_step(),
                until: entry.default_until(),
                q0: start.map(|[q0, _]| q0.as_slice()),
                v0: start.map(|[_, v0]| v0.as_slice()),
                a0: entry.default_acceleration(),
            },
        }
    }
}

/// The coordinates whose positions are in no equation; a rotation by its name.
fn reduced(entry: &Entry) -> Vec<String> {
    let shape = entry.kernel().shape();
    let name = |place: usize| {
        let name = shape.coordinates.get(place).map_or("", |own| &*own.name);
        match shape.rotation_of(place) {
            Some(_) => name.strip_suffix("_w").unwrap_or(name).to_owned(),
            None => name.to_owned(),
        }
    };
    geometry::reduced(entry.kernel()).into_iter().map(name).collect()
}

/// Lists the systems, or one, on standard output.
///
/// # Errors
///
/// [`CliError`] if there is no system of the name, or if the list cannot be written.
pub fn list(arguments: &ListArguments, program: &mut Program) -> Result<(), CliError> {
    let text = match (&arguments.system, arguments.format) {
        (Some(name), Format::Text) => text(program.find(name)?, Some(name)),
        (Some(name), Format::Json) => {
            let system = ListedSystem::new(program.find(name)?);
            format!("{:#}\n", serde_json::json!(system))
        }
        (None, Format::Text) if program.entries.len() == 1 => text(program.single_entry(None)?, None),
        (None, Format::Text) => by_kind(program),
        (None, Format::Json) => {
            program.read_shipped()?;
            let systems: Vec<ListedSystem> = program.entries.iter_mut().map(ListedSystem::new).collect();
            format!("{:#}\n", serde_json::json!(systems))
        }
    };
    terminal::print(text.as_bytes())
}

/// The systems kind by kind, a line for each. Systems that the program holds as texts are not parsed for it.
fn by_kind(program: &Program) -> String {
    let own = program.entries.iter();
    let own = own.map(|entry| (entry.kind(), entry.name(), entry.summary()));
    let shipped = program.shipped.iter();
    let shipped = shipped.map(|shipped| (shipped.kind, shipped.name, shipped.summary));
    let systems: Vec<(Kind, &str, &str)> = own.chain(shipped).collect();
    let width = systems.iter().map(|(_, name, _)| name.len()).max().unwrap_or(0);
    let mut list = String::new();
    for kind in Kind::ALL {
        let of_kind = systems.iter().filter(|(of, ..)| *of == kind);
        let of_kind: Vec<String> = of_kind
            .map(|(_, name, summary)| format!("  {name:width$}  {summary}\n"))
            .collect();
        if !of_kind.is_empty() {
            list.extend([format!("{kind}\n"), of_kind.concat(), "\n".to_owned()]);
        }
    }
    let mut mistakes: Vec<String> = Vec::new();
    for mistake in program.mistakes.iter().flatten() {
        let message = format!("error: {mistake}\n\n");
        if !mistakes.contains(&message) {
            mistakes.push(message);
        }
    }
    list.extend(mistakes);
    list + &format!(
        "Coordinates, parameters and defaults of one: `{} list SYSTEM`.\n",
        program.name
    )
}

/// A system, for people; `asked` is the name by which a text file was asked for.
fn text(entry: &mut Entry, asked: Option<&str>) -> String {
    let mut table = terminal::table(presets::NOTHING);
    let parameters = entry.parameters();
    let description = entry.description();
    let parts = [
        (
            "coordinate",
            "",
            quantities_without_values(&description.coordinates),
        ),
        ("parameter", "default", parameters_with_values(&parameters)),
        ("samples", "from", tables(entry)),
        (
            "observed",
            "",
            quantities_without_values(&description.observables),
        ),
    ];
    for (what, value, rows) in parts {
        if !rows.is_empty() {
            table.add_row(["", "", "", ""]);
            table.add_row([&format!("  {what}"), value, "unit", "meaning"]);
            for (quantity, value) in rows {
                table.add_row([
                    &format!("  {}", quantity.name),
                    value.as_str(),
                    quantity.unit().unwrap_or(""),
                    quantity.meaning(),
                ]);
            }
        }
    }
    let project = if entry.projects() { " --project" } else { "" };
    let source = entry
        .origin()
        .map_or_else(String::new, |source| format!("  source: {source}\n"));
    // three numbers for a rotation, as the options expect
    let shape = entry.kernel().shape();
    let moving = |vector: &[f64]| comma_separated(&shape.moving(vector).copied().collect::<Vec<f64>>());
    let start = entry.default_start().map_or_else(
        || " (and a start, `--q0` and `--v0`)".to_owned(),
        |[q0, v0]| format!(" --q0 {} --v0 {}", comma_separated(q0), moving(v0)),
    );
    let acceleration = entry
        .default_acceleration()
        .map(|a0| format!(" --a0 {}", moving(a0)))
        .or_else(|| Some(format!(" --near-a0 {}", moving(entry.default_near()?))))
        .unwrap_or_default();
    let runs = asked.map_or_else(String::new, |asked| other_runs(entry, asked));
    let reduced = match &reduced(entry)[..] {
        [] => String::new(),
        names => format!(
            "  reduced: no equation has the position of {}, which follows from the increments of the steps\n",
            names.join(", ")
        ),
    };
    let lines: Vec<_> = table.lines().map(|line| line.trim_end().to_owned()).collect();
    let description = entry.description();
    let quantities = [
        &description.coordinates,
        &description.parameters,
        &description.observables,
    ];
    let broken: String = quantities.into_iter().flatten().filter_map(broken_unit).collect();
    format!(
        "{} ({}): {}\n{source}  a run: --step {} --until {}{start}{acceleration}{project}\n{runs}{reduced}{}\n{broken}",
        entry.name(),
        entry.kind(),
        entry.summary(),
        shortest(entry.default_step()),
        shortest(entry.default_until()),
        lines.join("\n"),
    )
}

/// The tables of samples of a system that was read from a text, with their files and interpolations.
fn tables(entry: &Entry) -> Vec<(Quantity, String)> {
    let tables = entry.tables();
    tables
        .map(|table| {
            let of = Quantity {
                name: table.name.clone().into(),
                doc: table.doc.clone().into(),
            };
            (of, format!("{} ({})", table.file, table.curve.name()))
        })
        .collect()
}

/// The other runs of a text file, by the names that commands take.
fn other_runs(entry: &Entry, asked: &str) -> String {
    let Some((file, own)) = crate::cli::arguments::file::file_and_run(asked) else {
        return String::new();
    };
    let first = entry
        .runs()
        .find(Option::is_none)
        .or_else(|| entry.runs().next())
        .flatten();
    let own = own.or(first);
    let others = entry.runs().filter(|run| *run != own);
    let others: Vec<_> = others
        .map(|run| run.map_or_else(|| file.clone(), |run| format!("{file}:{run}")))
        .collect();
    if others.is_empty() {
        String::new()
    } else {
        format!("  other runs of this file: {}\n", others.join(", "))
    }
}

/// A warning about a quantity whose unit cannot be read: brackets that do not match, or that do not end the
/// comment.
fn broken_unit(quantity: &Quantity) -> Option<String> {
    let doc = quantity.doc.trim_end().trim_end_matches('.');
    let warn = |why: String| {
        Some(format!(
            "warning: `{}` has no unit: in its comment {why}\n",
            quantity.name
        ))
    };
    match (doc.rfind('['), doc.rfind(']')) {
        (Some(open), close) if close.is_none_or(|close| close < open) => {
            warn(format!("`{}` has no `]`", &doc[open..]))
        }
        (None, Some(close)) => {
            let begin = doc[..close].rfind(' ').map_or(0, |blank| blank + 1);
            warn(format!("`{}` has no `[`", &doc[begin..=close]))
        }
        (Some(open), Some(close)) if close + 1 < doc.len() && is_unit(&doc[open + 1..close]) => {
            warn(format!("`{}` does not stand at the end", &doc[open..=close]))
        }
        _ => None,
    }
}

/// Whether a text in brackets is a unit, and not a link or an interval.
fn is_unit(text: &str) -> bool {
    const UNITS: [&str; 28] = [
        "m", "mm", "cm", "km", "s", "ms", "min", "h", "kg", "g", "rad", "deg", "°", "N", "kN", "J", "kJ",
        "W", "kW", "Hz", "Pa", "V", "A", "T", "C", "K", "Nm", "1",
    ];
    let text = text.trim_matches('\\');
    let is_part = |c: char| " /·*()^⁻¹²³⁴-0123456789".contains(c);
    let mut words = text.split(is_part).filter(|word| !word.is_empty()).peekable();
    (words.peek().is_some() || text == "1") && words.all(|word| UNITS.contains(&word))
}

/// Quantities without values.
fn quantities_without_values(quantities: &[Quantity]) -> Vec<(Quantity, String)> {
    quantities
        .iter()
        .map(|quantity| (quantity.clone(), String::new()))
        .collect()
}

/// Parameters with their values.
fn parameters_with_values(parameters: &[(Quantity, f64)]) -> Vec<(Quantity, String)> {
    parameters
        .iter()
        .map(|(parameter, value)| (parameter.clone(), shortest(*value)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rotation_has_three_numbers_of_velocity() {
        let system = "coordinates(r: rotation, x);
            lagrangian = r.angular_velocity().norm_squared() + dot(x).powi(2);
            run { start = ([1, 0, 0, 0, 0.5], [0.6, -0.3, 3, 2]); }";
        let parsed = dsocs_core::text::Text::parse("body", system).unwrap();
        let mut entry = Entry::of_text("body", &parsed, parsed.runs.first());
        let listed = text(&mut entry, None);
        assert!(listed.contains("--q0 1,0,0,0,0.5 --v0 0.6,-0.3,3,2"), "{listed}");
    }

    #[test]
    fn units_that_cannot_be_read_are_told() {
        let warning = |doc| broken_unit(&Quantity::new("x", doc));
        for (doc, words) in [
            ("The stiffness [N/m.", "`[N/m` has no `]`"),
            ("The gravity m/s²].", "`m/s²]` has no `[`"),
            (
                "The speed [m/s] of the belt.",
                "`[m/s]` does not stand at the end",
            ),
            (r"The mass \[kg\] of the rod", "does not stand at the end"),
        ] {
            let warning = warning(doc).unwrap();
            assert!(warning.contains(words), "{doc}: {warning}");
        }
        for doc in [
            "",
            "The angle",
            "The length [m].",
            r"The mass \[kg\]",
            "The [`Pendulum`] it hangs from",
            "As [Marsden] has it",
            "In [0, 2] without a unit",
            "The damping ratio [1]",
        ] {
            assert_eq!(warning(doc), None, "{doc}");
        }
    }
}
