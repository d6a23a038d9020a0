//! `check`: the paper's theorems, measured on a system.

mod orders;

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use clap::Args;
use comfy_table::{Cell, CellAlignment, Color, Table, presets};
use serde_json::{Value, json};

use crate::check::{Begin, Finding, Settings};
use crate::cli::arguments::expression;
use crate::cli::arguments::start::{BeginArguments, StartArguments};
use crate::cli::output;
use crate::cli::output::{OutputFile, terminal};
use crate::cli::{CliError, Program};
use crate::entry::Entry;
use crate::stability::{Bar, number};

/// The arguments of `check`.
#[derive(Args, Debug)]
#[command(allow_negative_numbers = true)]
pub struct CheckArguments {
    /// Systems of `list`, or text files, `swing.dsocs`, or their runs, `swing.dsocs:fast` [default: all systems]
    systems: Vec<String>,
    /// The step h, in s [default: the system's own]
    #[arg(long, value_name = "H", allow_hyphen_values = true, value_parser = expression::number)]
    step: Option<f64>,
    /// The end of the motion that is checked, in s [default: the system's own]
    #[arg(long, value_name = "T", allow_hyphen_values = true, value_parser = expression::number)]
    until: Option<f64>,
    /// Initial position, velocity and time, and the parameters
    #[command(flatten)]
    from: StartArguments,
    /// The rule for the second node, and the projection onto constraints
    #[command(flatten)]
    begin: BeginArguments,
    /// Measure the orders of the parts in place of the checks: the orders of contact of `L_d`, `D_K` and `D_V` with the exact ones, the order of
    /// the flow that follows from them, and the order that is measured
    #[arg(long)]
    orders: bool,
    /// Measure the orders with other discretization maps as well, for systems that can be written as a text
    #[arg(long, requires = "orders")]
    every_map: bool,
    /// A .json file for the measured values; with `--orders` a .md file for the table
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// The motion that is checked.
pub(super) struct Motion {
    h: f64,
    until: Option<f64>,
    t0: f64,
    q0: Vec<f64>,
    v0: Vec<f64>,
    a0: Option<Vec<f64>>,
    begin: Begin,
}

impl Motion {
    /// The motion in the form that a check takes.
    pub(super) fn settings(&self) -> Settings<'_> {
        Settings {
            h: self.h,
            until: self.until,
            t0: self.t0,
            q0: &self.q0,
            v0: &self.v0,
            a0: self.a0.as_deref(),
            begin: self.begin,
        }
    }
}

impl CheckArguments {
    /// Gives a system its parameters, and finds its motion.
    ///
    /// # Errors
    ///
    /// [`CliError`] if an option does not fit the system.
    pub(super) fn motion(&self, entry: &mut Entry) -> Result<Motion, CliError> {
        self.from.set(entry)?;
        let h = self.step.unwrap_or(entry.default_step());
        Ok(Motion {
            h,
            until: self.until,
            t0: self.from.t0(),
            q0: self.from.q0(entry)?,
            v0: self.from.v0(entry)?,
            a0: self.from.acceleration(entry, h)?,
            begin: self.begin.begin(entry),
        })
    }

    /// The file for the values.
    pub(super) fn out(&self) -> Option<&Path> {
        self.out.as_deref()
    }

    /// Whether other maps are to be measured, too.
    pub(super) fn with_every_map(&self) -> bool {
        self.every_map
    }
}

/// Checks systems.
///
/// # Errors
///
/// [`CliError`] if a system does not exist, its motion cannot be computed, the file cannot be written, or a check fails.
pub fn check(arguments: &CheckArguments, program: &mut Program) -> Result<(), CliError> {
    let entries = program.entries_named(&arguments.systems)?;
    arguments.from.for_systems(entries.len())?;
    let is_one = entries.len() == 1;
    if let Some(path) = &arguments.out {
        let ending = path.extension().and_then(OsStr::to_str);
        match ending {
            Some("json") => {}
            Some("md") if arguments.orders => {}
            _ => return Err(CliError::NotJson(path.display().to_string())),
        }
        drop(OutputFile::create(path)?);
    }
    if arguments.orders {
        return orders::orders(arguments, entries);
    }
    let mut missed = 0;
    let mut encoded = Vec::new();
    let mut text = String::new();
    for entry in entries {
        let motion = arguments.motion(entry)?;
        let settings = motion.settings();
        let findings = match entry.check(&settings) {
            Ok(findings) => findings,
            Err(failure) if is_one => return Err(failure.into()),
            // a failure does not end the checks of the other systems
            Err(failure) => {
                missed += 1;
                let failure = CliError::from(failure).to_string();
                text.extend([entry.name(), ": FAILED: ", &failure, "\n"]);
                encoded.push(json!({"system": entry.name(), "kind": entry.kind(), "failure": failure}));
                continue;
            }
        };
        missed += findings.iter().filter(|finding| !finding.ok()).count();
        let until = settings.until.unwrap_or(entry.checked_end());
        let title = format!(
            "{} ({}), h = {}, to t = {until}",
            entry.name(),
            entry.kind(),
            settings.h
        );
        text.extend([title, "\n".into(), self::text(&findings)]);
        encoded.push(json!({
            "system": entry.name(),
            "kind": entry.kind(),
            "step": settings.h,
            "until": until,
            "checks": findings.iter().map(value).collect::<Vec<_>>(),
        }));
    }
    if let Some(path) = &arguments.out {
        let all = json!({ "systems": encoded });
        output::write(path, format!("{all:#}\n").as_bytes())?;
    }
    terminal::print_figures(&text, missed)
}

/// The figures as a table, with remarks below it.
pub(crate) fn text(findings: &[Finding]) -> String {
    let mut text = table(findings).to_string();
    text.push('\n');
    for (remark, of) in remarks(findings) {
        text.extend([&of.join("; "), ": ", remark, "\n"]);
    }
    text
}

/// The remarks on the figures, each once, with the checks that it belongs to.
fn remarks(findings: &[Finding]) -> Vec<(&str, Vec<String>)> {
    let mut remarks: Vec<(&str, Vec<String>)> = Vec::new();
    let mut say = |remark, of: String| match remarks.iter_mut().find(|(text, _)| *text == remark) {
        Some((_, others)) if others.contains(&of) => {}
        Some((_, others)) => others.push(of),
        None => remarks.push((remark, vec![of])),
    };
    for finding in findings {
        if let Some(failure) = &finding.failure {
            say(failure.as_str(), format!("{}: {}", finding.check, finding.what));
        }
        if let Some(excuse) = &finding.excuse {
            say(excuse.as_str(), format!("{}: {}", finding.check, finding.what));
        }
        if let Some(note) = &finding.note {
            say(note.as_str(), finding.check.to_owned());
        }
    }
    remarks
}

/// A figure as JSON.
fn value(finding: &Finding) -> Value {
    let (bar, relation) = match finding.bar {
        Bar::AtMost(bar) => (Value::from(bar), Value::from("<=")),
        Bar::AtLeast(bar) => (Value::from(bar), Value::from(">=")),
        Bar::Reported => (Value::Null, Value::Null),
    };
    json!({
        "check": finding.check,
        "what": finding.what,
        "figure": finding.figure,
        "bar": bar,
        "relation": relation,
        "ok": finding.ok(),
        "failure": finding.failure,
        "note": finding.note,
        "excuse": finding.excuse,
    })
}

/// The figures as a table.
fn table(findings: &[Finding]) -> Table {
    let mut table = terminal::table(presets::UTF8_FULL_CONDENSED);
    table.set_header(["check", "figure", "bar", ""]);
    let mut last = "";
    for finding in findings {
        if finding.check != last {
            last = finding.check;
            table.add_row([last]);
        }
        let bar = match finding.bar {
            Bar::AtMost(bar) => format!("≤ {}", number(bar)),
            Bar::AtLeast(bar) => format!("≥ {}", number(bar)),
            Bar::Reported => String::new(),
        };
        let (word, colour) = match (finding.holds(), &finding.excuse, finding.bar) {
            (false, Some(_), _) => ("open", Color::Yellow),
            (false, None, _) => ("FAILED", Color::Red),
            (true, _, Bar::Reported) => ("", Color::Reset),
            (true, ..) => ("ok", Color::Green),
        };
        let right = |text: String| Cell::new(text).set_alignment(CellAlignment::Right);
        table.add_row([
            Cell::new(format!("  {}", finding.what)),
            right(number(finding.figure)),
            right(bar),
            Cell::new(word).fg(colour),
        ]);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_remark_is_made_once() {
        let finding = |check, what: &str, failure: Option<&str>, note: Option<&str>| Finding {
            check,
            what: what.to_owned(),
            figure: f64::NAN,
            bar: Bar::Reported,
            failure: failure.map(str::to_owned),
            note: note.map(str::to_owned),
            excuse: None,
        };
        let findings = [
            finding("order", "slope", Some("the motion sticks"), None),
            finding("contact", "of L_d", Some("the motion sticks"), Some("look here")),
            finding("contact", "of D_K", None, Some("look here")),
            finding("order", "distance", Some("it is chaotic"), None),
        ];
        let text = text(&findings);
        let lines: Vec<&str> = text
            .lines()
            .skip_while(|line| !line.starts_with("order: "))
            .collect();
        assert_eq!(
            lines,
            [
                "order: slope; contact: of L_d: the motion sticks",
                "contact: look here",
                "order: distance: it is chaotic",
            ]
        );
    }
}
