//! `dsocs report`: one page with the paper's figures and tables, speed against error, the theorems, the hard
//! cases, and the origin of the numbers.

mod moving_picture;
mod speed;

use std::path::PathBuf;

use clap::Args;

use crate::check::Settings;
use crate::cli::commands::paper;
use crate::cli::output::terminal;
use crate::cli::output::{OutputFile, progress};
use crate::cli::page::{self, Cell, Page};
use crate::cli::{CliError, Program};
use crate::experiment::{ErrorRow, StartRule, slope};
use crate::stability::number;
use crate::stability::{Bar, CASES};

/// The systems whose theorems are shown unless others are named.
const SYSTEMS: [&str; 2] = ["particle", "pendulum"];

/// The arguments of `report`.
#[derive(Args, Debug)]
pub struct ReportArguments {
    /// Systems of `list` on which the theorems are checked [default: the paper's two]
    systems: Vec<String>,
    /// The page: a single .html file
    #[arg(long, value_name = "FILE", default_value = "results/report.html")]
    out: PathBuf,
    /// Run only the hard cases with these numbers
    #[arg(long, value_name = "N,N", value_delimiter = ',')]
    cases: Option<Vec<u8>>,
    /// A file with speed against error as the bench `work_precision` measured it, other codes included
    /// (`target/report/work_precision.csv`). By default this program measures its own methods
    #[arg(long, value_name = "FILE")]
    speed: Option<PathBuf>,
}

/// Writes the page.
///
/// # Errors
///
/// [`CliError`] if a system or a case does not exist, the page cannot be written (which is tried before anything is computed), the
/// file of speeds cannot be read, or something cannot be computed.
pub fn report(arguments: &ReportArguments, program: &mut Program) -> Result<(), CliError> {
    page::check_name(&arguments.out)?;
    let file = OutputFile::create(&arguments.out)?;
    let measured = arguments.speed.as_deref().map(speed::read).transpose()?;
    let names: Vec<String> = if arguments.systems.is_empty() {
        SYSTEMS.map(str::to_owned).to_vec()
    } else {
        arguments.systems.clone()
    };
    program.entries_named(&names)?;
    for asked in arguments.cases.iter().flatten() {
        if CASES.iter().all(|case| case.number != *asked) {
            let known = CASES.iter().map(|case| case.number.to_string()).collect();
            return Err(CliError::NoCase {
                number: *asked,
                known,
            });
        }
    }

    let mut page = Page::new(
        "dsocs: what it computes, and how well",
        "Discrete second order constrained Lagrangian systems. Every number on this page was computed by the command at its end.",
    );
    figures(&mut page)?;
    let points = match measured {
        Some(points) => points,
        None => speed::measure(program)?,
    };
    speed::show(&mut page, &points, arguments.speed.is_some());
    let missed = theorems(&mut page, &names, program)? + hard_cases(&mut page, arguments.cases.as_deref());
    page.heading("Where this comes from");
    page.add(page::provenance::provenance([]));
    file.complete(page.finish().as_bytes())?;
    let text = format!("The page is in {}.\n", arguments.out.display());
    terminal::print_figures(&text, missed)
}

/// The paper's figures: the name of each, its caption, and its width and height on a page, in pixels.
const FIGURES: [(&str, &str, [f64; 2]); 5] = [
    (
        "particle-path",
        "The particle's path: all turns lie on one circle",
        [560.0, 532.0],
    ),
    (
        "particle-xy",
        "The particle's coordinates in an early and a late window",
        [640.0, 532.0],
    ),
    (
        "particle-error",
        "The particle's error against the step",
        [560.0, 440.0],
    ),
    (
        "pendulum-motion",
        "The pendulum's angles, its Lyapunov function, and the control torque",
        [560.0, 800.0],
    ),
    (
        "pendulum-error",
        "The pendulum's error against the step",
        [560.0, 440.0],
    ),
];

/// The paper's figures and tables.
fn figures(page: &mut Page) -> Result<(), CliError> {
    let results = paper::compute()?;
    page.heading("The paper's figures");
    page.paragraph(
        "The scheme is of second order. The paper's slopes of 1.6 and 1.3 come from its start, q1 = q0 + h v0, whose error is of \
         first order.",
    );
    page.add("<div class=\"figures wide\">");
    for (name, mut figure) in paper::figures(&results) {
        let Some(&(_, title, size)) = FIGURES.iter().find(|known| known.0 == name) else {
            continue;
        };
        figure.size = size;
        page.add(format!(
            "<figure>{}<figcaption>{title}</figcaption></figure>",
            figure.on_page(name, title)
        ));
    }
    page.add("</div>");
    page.add(errors(
        "Particle, curvature 1, over [0, 500 s]: max |x error| [m]",
        &results.particle_errors,
    ));
    page.add(errors(
        "Inertia wheel pendulum over [0, 2000 s]: max |θ error| [rad]",
        &results.pendulum_errors,
    ));
    Ok(())
}

/// A table of errors, the slopes in its last row.
fn errors(caption: &str, rows: &[ErrorRow]) -> String {
    let of = |start| rows.iter().filter(move |row| row.start == start);
    let pairs = of(StartRule::Paper).zip(of(StartRule::SecondOrder));
    let number = |x: f64| Cell::Number(format!("{x:.3e}"));
    let lines = pairs.map(|(paper, second)| {
        vec![
            Cell::Number(paper.h.to_string()),
            number(paper.max_error),
            number(second.max_error),
        ]
    });
    let slopes = StartRule::ALL.map(|start| Cell::Number(format!("{:.3}", slope(rows, start))));
    let last = [Cell::Number("slope".to_owned())]
        .into_iter()
        .chain(slopes)
        .collect();
    page::table(
        caption,
        &["#h [s]", "#paper start", "#second-order start"],
        lines.chain([last]),
    )
}

/// The theorems on some systems. Returns the number of limits missed.
fn theorems(page: &mut Page, names: &[String], program: &mut Program) -> Result<usize, CliError> {
    page.heading("The theorems");
    page.paragraph(
        "Each theorem of the paper as a figure, on a motion of the system, and the bar that it has to meet.",
    );
    let mut missed = 0;
    for entry in program.entries_named(names)? {
        let Some([q0, v0]) = entry.default_start() else {
            return Err(CliError::NoStart {
                system: entry.name().to_owned(),
                options: Vec::new(),
                coordinates: entry.description().names().map(str::to_owned).collect(),
                rotations: entry.description().rotations.len(),
                in_text: "",
            });
        };
        let settings = Settings {
            h: entry.default_step(),
            until: None,
            t0: 0.0,
            q0,
            v0,
            a0: entry.default_acceleration().or(entry.default_near()),
            begin: moving_picture::checked_start(entry),
        };
        let findings = entry.check(&settings)?;
        missed += findings.iter().filter(|finding| !finding.ok()).count();
        let rows = findings.iter().map(|finding| {
            let what = explained(&finding.what, finding.failure.as_deref());
            let verdict = [finding.check.to_owned(), what].map(Cell::Text);
            let figures = figures_of(finding.figure, finding.bar, finding.ok());
            verdict.into_iter().chain(figures).collect()
        });
        let caption = format!("{} ({}), h = {} s", entry.name(), entry.kind(), settings.h);
        page.add(page::table(
            &caption,
            &["check", "what", "#figure", "#bar", ""],
            rows,
        ));
        moving_picture::picture(page, entry)?;
    }
    Ok(missed)
}

/// The hard cases. Returns the number of limits missed.
fn hard_cases(page: &mut Page, numbers: Option<&[u8]>) -> usize {
    page.heading("Hard cases");
    page.paragraph("The quick form of each; `dsocs stability` runs the long one.");
    let wanted = |number: u8| numbers.is_none_or(|numbers| numbers.contains(&number));
    let chosen: Vec<_> = CASES.iter().filter(|case| wanted(case.number)).collect();
    let bar = progress::bar(chosen.len() as u64, "hard cases");
    let mut rows = Vec::new();
    for case in chosen {
        rows.extend(case.run(true, &mut |_| bar.tick()));
        bar.inc(1);
    }
    bar.finish_and_clear();
    let missed = rows.iter().filter(|row| !row.ok()).count();
    let lines = rows.iter().map(|row| {
        let what = explained(&row.what, row.failure.as_deref());
        let words = [format!("{} {}", row.number, row.case), what].map(Cell::Text);
        words
            .into_iter()
            .chain(figures_of(row.figure, row.bar, row.ok()))
            .collect()
    });
    page.add(page::table("", &["case", "what", "#figure", "#bar", ""], lines));
    missed
}

/// A measurement, with the reason where it failed.
fn explained(what: &str, failure: Option<&str>) -> String {
    failure.map_or_else(|| what.to_owned(), |failure| format!("{what}: {failure}"))
}

/// A figure, its limit, and whether it is met.
fn figures_of(figure: f64, bar: Bar, ok: bool) -> [Cell; 3] {
    let (bar, verdict) = match bar {
        Bar::AtMost(bar) => (format!("≤ {}", number(bar)), Cell::Verdict(ok)),
        Bar::AtLeast(bar) => (format!("≥ {}", number(bar)), Cell::Verdict(ok)),
        Bar::Reported if ok => (String::new(), Cell::Text(String::new())),
        Bar::Reported => (String::new(), Cell::Verdict(false)),
    };
    [Cell::Number(number(figure)), Cell::Number(bar), verdict]
}
