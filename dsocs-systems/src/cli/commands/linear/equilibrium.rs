//! `equilibrium`: states of rest.

use clap::Args;
use comfy_table::{Cell, CellAlignment, presets};
use dsocs_core::linear::{Equilibria, Equilibrium, EquilibriumSearch};
use serde_json::{Value, json};

use crate::cli::arguments::expression;
use crate::cli::arguments::start::{Component, assignment, component, vector};
use crate::cli::commands::linear::linearize::{ModelFormat, block, complex};
use crate::cli::output::number::six_digits;
use crate::cli::output::terminal;
use crate::cli::{CliError, Program};
use crate::entry::Entry;

/// The arguments of `equilibrium`.
#[derive(Args, Debug)]
#[command(allow_negative_numbers = true)]
pub struct EquilibriumArguments {
    /// A system of `list`, or a text file, `swing.dsocs`, or one of its runs, `swing.dsocs:fast`; a program with one system needs none
    system: Option<String>,
    /// A position near which an equilibrium is looked for, a number for each coordinate, or those by name that differ from the system's own
    /// start (`theta=30deg`); may be given several times [default: the system's own start]
    #[arg(long, value_name = "A,B", allow_hyphen_values = true, value_parser = guess)]
    guess: Vec<Guess>,
    /// Parameters that are unknown as well, such as the torques that hold a position
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    free: Vec<String>,
    /// Coordinates that are held at their guesses
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    hold: Vec<String>,
    /// The time, in s, where the system depends on it
    #[arg(long, value_name = "T", allow_hyphen_values = true, default_value = "0", value_parser = expression::number)]
    t0: f64,
    /// A parameter's value; may be given several times
    #[arg(long, value_name = "NAME=VALUE", allow_hyphen_values = true, value_parser = assignment)]
    set: Vec<(String, f64)>,
    /// The format of the equilibria
    #[arg(long, value_enum, default_value_t = ModelFormat::Text)]
    format: ModelFormat,
}

/// A position.
#[derive(Clone, Debug)]
struct Guess(Vec<Component>);

/// Reads a position.
fn guess(text: &str) -> Result<Guess, String> {
    text.split(',')
        .map(component)
        .collect::<Result<_, _>>()
        .map(Guess)
}

/// Writes the equilibria to standard output.
///
/// # Errors
///
/// [`CliError`] if there is no such system or name, or no equilibrium is found.
pub fn equilibrium(arguments: &EquilibriumArguments, program: &mut Program) -> Result<(), CliError> {
    let entry = program.single_entry(arguments.system.as_deref())?;
    for (name, value) in &arguments.set {
        entry.set(name, *value)?;
    }
    let own = entry.default_start().map(|[q0, _]| q0.as_slice());
    let mut guesses = Vec::new();
    for Guess(components) in &arguments.guess {
        guesses.extend(vector("--guess", Some(components), own, entry)?);
    }
    if arguments.guess.is_empty() {
        let mut origin = vec![0.0; entry.description().coordinates.len()];
        for &first in entry.kernel().shape().rotations.iter() {
            origin[first] = 1.0;
        }
        guesses.push(own.map_or(origin, <[f64]>::to_vec));
    }
    let search = EquilibriumSearch::new(entry.kernel())
        .at(arguments.t0)
        .free(&arguments.free)
        .held(&arguments.hold);
    let found = search.near_all(&guesses)?;
    let failed = found.of_guess.iter().filter_map(|place| place.as_ref().err());
    if found.equilibria.is_empty()
        && let Some(error) = failed.clone().next()
    {
        return Err(error.clone().into());
    }
    for error in failed {
        terminal::tell(format_args!("warning: {error}"));
    }
    let output = match arguments.format {
        ModelFormat::Text => text(entry, &arguments.free, &found),
        ModelFormat::Json => format!("{:#}\n", encoded(entry, &found)),
    };
    terminal::print(output.as_bytes())
}

/// Equilibria, for people.
fn text(entry: &Entry, free: &[String], found: &Equilibria) -> String {
    let mut text = format!("{} ({}), at rest\n", entry.name(), entry.kind());
    for equilibrium in &found.equilibria {
        text.push_str(&equilibrium_text(entry, free, equilibrium));
    }
    text
}

/// An equilibrium, for people.
fn equilibrium_text(entry: &Entry, free: &[String], found: &Equilibrium) -> String {
    let description = entry.description();
    let right = |text: String| Cell::new(text).set_alignment(CellAlignment::Right);
    let mut table = terminal::table(presets::NOTHING);
    let coordinates = description.coordinates.iter().zip(&found.q);
    let all = description.parameters.iter().zip(&found.parameters);
    let parameters = all.filter(|(parameter, _)| free.iter().any(|name| *name == parameter.name));
    for (quantity, value) in coordinates.chain(parameters) {
        table.add_row([
            Cell::new(&quantity.name),
            right(six_digits(*value)),
            Cell::new(quantity.unit().unwrap_or("")),
        ]);
    }
    let mut text = block(&table);
    match (found.eigenvalues(), found.stability()) {
        (Ok(eigenvalues), Ok(stability)) => {
            let shown: Vec<String> = eigenvalues.into_iter().map(complex).collect();
            text.extend([
                "  ",
                &stability.to_string(),
                "; eigenvalues ",
                &shown.join(", "),
                "\n",
            ]);
        }
        (Err(error), _) | (_, Err(error)) => {
            text.extend(["  no eigenvalues: ", &error.to_string(), "\n"]);
        }
    }
    if found.is_held_by_friction() {
        text.push_str("  friction holds a range of positions around it; this one needs no friction\n");
    }
    if let Some(t) = found.frozen_at {
        let note = format!(
            "  the declaration depends on t: this is the equilibrium of its equations frozen at t = {} (--t0)\n",
            six_digits(t)
        );
        text.push_str(&note);
    }
    for direction in &found.directions {
        text.extend(["  one of a continuum, along ", &rounded(direction), "\n"]);
    }
    text
}

/// Numbers as options take them, in six digits.
fn rounded(numbers: &[f64]) -> String {
    numbers
        .iter()
        .map(|&x| six_digits(x))
        .collect::<Vec<_>>()
        .join(",")
}

/// Equilibria as JSON.
fn encoded(entry: &Entry, found: &Equilibria) -> Value {
    let description = entry.description();
    let each = found.equilibria.iter().map(|equilibrium| {
        let parameters = description.parameters.iter().zip(&equilibrium.parameters);
        let parameters: serde_json::Map<String, Value> = parameters
            .map(|(parameter, value)| (parameter.name.to_string(), json!(value)))
            .collect();
        let eigenvalues = equilibrium.eigenvalues();
        json!({
            "q": equilibrium.q,
            "parameters": parameters,
            "force": equilibrium.force,
            "isolated": equilibrium.is_isolated(),
            "directions": equilibrium.directions,
            "held_by_friction": equilibrium.is_held_by_friction(),
            "frozen_at": equilibrium.frozen_at,
            "stability": equilibrium.stability().ok().map(|stability| stability.to_string()),
            "eigenvalues": eigenvalues.as_ref().ok(),
            "failure": eigenvalues.as_ref().err().map(ToString::to_string),
        })
    });
    json!({
        "system": entry.name(),
        "kind": entry.kind(),
        "coordinates": description.names().collect::<Vec<_>>(),
        "equilibria": each.collect::<Vec<_>>(),
        "of_guess": found.of_guess.iter().map(|place| place.as_ref().ok()).collect::<Vec<_>>(),
        "failures": found
            .of_guess
            .iter()
            .filter_map(|place| place.as_ref().err().map(ToString::to_string))
            .collect::<Vec<_>>(),
    })
}
