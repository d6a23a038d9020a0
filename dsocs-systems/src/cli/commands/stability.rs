//! `stability`: hard cases, the figure measured in each, and its limit.

use std::path::PathBuf;

use clap::Args;
use comfy_table::{Cell, CellAlignment, Color, Table, presets};
use serde_json::{Value, json};

use crate::check::{Begin, Settings};
use crate::cli::arguments::expression;
use crate::cli::arguments::start::StartArguments;
use crate::cli::output;
use crate::cli::output::{progress, terminal};
use crate::cli::{CliError, Program};
#[cfg(all(feature = "dsocs", not(test)))]
use crate::stability::CASES;
use crate::stability::{Bar, Row, any, number};

/// The case that compares with another code, which is built only with the feature `peers`.
#[cfg(all(feature = "dsocs", not(test)))]
const PEER_CASE: u8 = 11;

/// The arguments of `stability`.
#[derive(Args, Debug)]
#[command(allow_negative_numbers = true)]
pub struct StabilityArguments {
    /// Systems of `list`, or text files, `swing.dsocs`, to be measured on their own motions [default: all systems]
    systems: Vec<String>,
    /// The step h, in s [default: the system's own]
    #[arg(long, value_name = "H", allow_hyphen_values = true, value_parser = expression::number)]
    step: Option<f64>,
    /// The end of the long run, in s [default: the system's own]
    #[arg(long, value_name = "T", allow_hyphen_values = true, value_parser = expression::number)]
    until: Option<f64>,
    /// Initial position, velocity and time, and the parameters
    #[command(flatten)]
    from: StartArguments,
    /// The folder for stability.json
    #[arg(long, value_name = "DIR", default_value = "results")]
    out: PathBuf,
    /// Leave out everything that takes more than seconds
    #[arg(long)]
    quick: bool,
    /// Run only the cases with these numbers
    #[arg(long, value_name = "N,N", value_delimiter = ',')]
    cases: Option<Vec<u8>>,
}

/// Measures the hard cases of the systems that are named, or of all. In `dsocs`, where none is named,
/// measures the library's own hard cases.
///
/// # Errors
///
/// [`CliError`] if a system or a case does not exist, the folder cannot be written (which is tried before anything is computed),
/// or if a limit is missed.
pub fn stability(arguments: &StabilityArguments, program: &mut Program) -> Result<(), CliError> {
    #[cfg(all(feature = "dsocs", not(test)))]
    if program.is_dsocs && arguments.systems.is_empty() {
        return library(arguments);
    }
    let entries = program.entries_named(&arguments.systems)?;
    arguments.from.for_systems(entries.len())?;
    let chosen = arguments.chosen_cases(any::CASES, |case| case.number)?;
    output::check_folder(&arguments.out)?;
    let bar = progress::bar((chosen.len() * entries.len()) as u64, "hard cases");
    let (mut text, mut systems, mut all) = (String::new(), Vec::new(), Vec::new());
    for entry in entries {
        arguments.from.set(entry)?;
        let h = arguments.step.unwrap_or(entry.default_step());
        let a0 = arguments.from.acceleration(entry, h)?;
        let mut settings = Settings {
            h,
            until: arguments.until,
            t0: arguments.from.t0(),
            q0: &arguments.from.q0(entry)?,
            v0: &arguments.from.v0(entry)?,
            a0: a0.as_deref(),
            begin: Begin::default(),
        };
        let moved = entry
            .projects()
            .then(|| entry.projected_state(&settings))
            .transpose()?;
        if let Some([q0, v0]) = &moved {
            (settings.q0, settings.v0) = (q0, v0);
        }
        let mut rows = Vec::new();
        for case in &chosen {
            rows.extend(case.run(entry, &settings, arguments.quick, &mut |_| bar.tick()));
            bar.inc(1);
        }
        let title = format!("{} ({}), h = {}", entry.name(), entry.kind(), settings.h);
        text.extend([title, "\n".into(), table(&rows).to_string(), "\n".into()]);
        systems.push(json!({
            "system": entry.name(),
            "kind": entry.kind(),
            "step": settings.h,
            "cases": encoded(&rows),
        }));
        all.extend(rows);
    }
    bar.finish_and_clear();
    arguments.finish(&text, &json!({ "systems": systems }), &all)
}

/// Measures the hard cases of the library's systems.
#[cfg(all(feature = "dsocs", not(test)))]
fn library(arguments: &StabilityArguments) -> Result<(), CliError> {
    arguments.refuse_motion_options()?;
    let chosen = arguments.chosen_cases(CASES, |case| case.number)?;
    output::check_folder(&arguments.out)?;
    let bar = progress::bar(chosen.len() as u64, "hard cases");
    let mut rows = Vec::new();
    for case in chosen {
        rows.extend(case.run(arguments.quick, &mut |_| bar.tick()));
        bar.inc(1);
    }
    bar.finish_and_clear();
    if cfg!(not(feature = "peers")) && rows.iter().any(|row| row.number == PEER_CASE) {
        terminal::tell(format_args!(
            "note: case {PEER_CASE} is without the general method's own figures: they need `--features peers`"
        ));
    }
    let text = format!("{}\n", table(&rows));
    arguments.finish(&text, &json!({ "cases": encoded(&rows) }), &rows)
}

impl StabilityArguments {
    /// The cases that were asked for.
    fn chosen_cases<'a, C>(&self, cases: &'a [C], number: fn(&C) -> u8) -> Result<Vec<&'a C>, CliError> {
        // an unknown number would measure nothing, and nothing would miss its limit
        let asked = self.cases.iter().flatten();
        for asked in asked {
            if cases.iter().all(|case| number(case) != *asked) {
                return Err(CliError::NoCase {
                    number: *asked,
                    known: cases.iter().map(|case| number(case).to_string()).collect(),
                });
            }
        }
        let chosen = |case: &&C| {
            let numbers = self.cases.as_ref();
            numbers.is_none_or(|numbers| numbers.contains(&number(case)))
        };
        Ok(cases.iter().filter(chosen).collect())
    }

    /// Refuses options for the motion of a system where none is named.
    #[cfg(all(feature = "dsocs", not(test)))]
    fn refuse_motion_options(&self) -> Result<(), CliError> {
        self.from.for_systems(usize::MAX)?;
        for (option, given) in [("--step", self.step), ("--until", self.until)] {
            if given.is_some() {
                return Err(CliError::OneSystem { option });
            }
        }
        Ok(())
    }

    /// Writes what was measured.
    fn finish(&self, text: &str, json: &Value, rows: &[Row]) -> Result<(), CliError> {
        let path = self.out.join("stability.json");
        output::write(&path, format!("{json:#}\n").as_bytes())?;
        let missed = rows.iter().filter(|row| !row.ok()).count();
        let text = format!(
            "{text}{} measured values, {missed} of which do not meet their limit. All values: {}.\n",
            rows.len(),
            path.display()
        );
        terminal::print_figures(&text, missed)
    }
}

/// The prefix of a row whose measurement is that of the row above; in JSON it is written out.
const SAME_AS_ABOVE: &str = "the same";

/// The rows as JSON.
fn encoded(rows: &[Row]) -> Vec<Value> {
    let mut before = "";
    rows.iter()
        .map(|row| {
            let what = if let Some(rest) = row.what.strip_prefix(SAME_AS_ABOVE) {
                format!("{before}{rest}")
            } else {
                let parts = row.what.rsplit_once(": ");
                before = parts.map_or(row.what.as_str(), |(what, _)| what);
                row.what.clone()
            };
            let (bar, relation) = match row.bar {
                Bar::AtMost(bar) => (Value::from(bar), Value::from("<=")),
                Bar::AtLeast(bar) => (Value::from(bar), Value::from(">=")),
                Bar::Reported => (Value::Null, Value::Null),
            };
            json!({
                "case": format!("{} {}: {what}", row.number, row.case),
                "figure": row.figure,
                "bar": bar,
                "relation": relation,
                "ok": row.ok(),
                "seconds": row.seconds,
                "failure": row.failure,
            })
        })
        .collect()
}

/// The rows as a table.
pub(crate) fn table(rows: &[Row]) -> Table {
    let mut table = terminal::table(presets::UTF8_FULL_CONDENSED);
    table.set_header(["case", "figure", "bar", "", "s"]);
    let mut last = 0;
    for row in rows {
        if row.number != last {
            last = row.number;
            table.add_row([format!("{} {}", row.number, row.case)]);
        }
        let bar = match row.bar {
            Bar::AtMost(bar) => format!("≤ {}", number(bar)),
            Bar::AtLeast(bar) => format!("≥ {}", number(bar)),
            Bar::Reported => String::new(),
        };
        let (word, colour) = match (row.ok(), row.bar) {
            (false, _) => ("MISSED", Color::Red),
            (true, Bar::Reported) => ("", Color::Reset),
            (true, _) => ("ok", Color::Green),
        };
        let what = match &row.failure {
            Some(failure) => format!("  {}: {failure}", row.what),
            None => format!("  {}", row.what),
        };
        let right = |text: String| Cell::new(text).set_alignment(CellAlignment::Right);
        table.add_row([
            Cell::new(what),
            right(number(row.figure)),
            right(bar),
            Cell::new(word).fg(colour),
            right(format!("{:.2}", row.seconds)),
        ]);
    }
    table
}
