//! `dsocs stability`: hard cases, the figure reached in each, and the bar.

use std::io::Write;
use std::path::PathBuf;

use clap::Args;
use comfy_table::{Cell, CellAlignment, Color, Table, presets};
use serde_json::{Value, json};

use super::{CliError, output, progress};
use crate::stability::{Bar, CASES, Row};

/// The case whose rival is not built unless the feature `peers` is on.
const BESIDE: u8 = 11;

/// What `dsocs stability` takes.
#[derive(Args, Debug)]
pub struct StabilityArguments {
    /// The folder for stability.json
    #[arg(long, value_name = "DIR", default_value = "results")]
    out: PathBuf,
    /// Leave out what takes more than seconds
    #[arg(long)]
    quick: bool,
    /// Run the cases of these numbers alone
    #[arg(long, value_name = "N,N", value_delimiter = ',', value_parser = case_number)]
    cases: Option<Vec<u8>>,
}

/// The number of a case: an unknown one would measure nothing, and nothing would be below its bar.
fn case_number(text: &str) -> Result<u8, String> {
    let known = |number: &u8| CASES.iter().any(|case| case.number == *number);
    text.parse().ok().filter(known).ok_or_else(|| {
        let numbers: Vec<String> = CASES.iter().map(|case| case.number.to_string()).collect();
        format!("the cases are {}", numbers.join(", "))
    })
}

/// Measures the hard cases.
///
/// # Errors
///
/// [`CliError`] if the folder cannot be written (which is tried before anything is computed), or if a bar is missed.
pub fn stability(arguments: &StabilityArguments) -> Result<(), CliError> {
    output::check_folder(&arguments.out)?;
    let chosen: Vec<_> = CASES
        .iter()
        .filter(|case| {
            let numbers = arguments.cases.as_ref();
            numbers.is_none_or(|numbers| numbers.contains(&case.number))
        })
        .collect();
    let bar = progress::bar(chosen.len() as u64, "hard cases");
    let mut rows = Vec::new();
    for case in chosen {
        rows.extend(case.run(arguments.quick, &mut |_| bar.tick()));
        bar.inc(1);
    }
    bar.finish_and_clear();
    if cfg!(not(feature = "peers")) && rows.iter().any(|row| row.number == BESIDE) {
        eprintln!(
            "note: case {BESIDE} is without the general method's own figures: they need `--features peers`"
        );
    }
    let path = arguments.out.join("stability.json");
    output::write(&path, &encoded(&rows))?;
    let missed = rows.iter().filter(|row| !row.ok()).count();
    let text = format!(
        "{}\n{} figures, {missed} below their bar. Every figure: {}.\n",
        table(&rows),
        rows.len(),
        path.display()
    );
    std::io::stdout()
        .write_all(text.as_bytes())
        .map_err(CliError::stdout)?;
    if missed > 0 {
        return Err(CliError::Bars { missed });
    }
    Ok(())
}

/// What stands for the measurement of the row above; in JSON every row speaks for itself.
const SAME: &str = "the same";

/// The rows as JSON.
fn encoded(rows: &[Row]) -> Vec<u8> {
    let mut before = "";
    let cases: Vec<Value> = rows
        .iter()
        .map(|row| {
            let what = if let Some(rest) = row.what.strip_prefix(SAME) {
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
        .collect();
    format!("{:#}\n", json!({ "cases": cases })).into_bytes()
}

/// The rows as a table.
fn table(rows: &[Row]) -> Table {
    let mut table = Table::new();
    table.load_style(presets::UTF8_FULL_CONDENSED);
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

/// A number in two or three digits.
pub fn number(x: f64) -> String {
    if x == 0.0 || ((0.01..1e5).contains(&x.abs()) && (x * 100.0).fract() == 0.0) {
        format!("{x}")
    } else if (0.01..1e5).contains(&x.abs()) {
        format!("{x:.3}")
    } else {
        format!("{x:.1e}")
    }
}
