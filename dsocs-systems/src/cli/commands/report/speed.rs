//! Speed against error: measured here for this program's methods, or read from a file of the bench
//! `work_precision`.

use std::ops::ControlFlow;
use std::path::Path;
use std::time::Instant;

use dsocs_core::Composition;
use serde::Deserialize;
use serde_json::{Value, json};

use crate::cli::output::progress;
use crate::cli::page::{self, Cell, Page};
use crate::cli::{CliError, Program};
use crate::entry::{Beginning, Entry, Method, Plan};
use crate::figure::{Axis, BLUE, Curve, Figure, GREEN, Legend, PURPLE, Panel, Style, VERMILION, escaped};

/// The problems, their ends in s.
const PROBLEMS: [(&str, f64); 2] = [("particle", 100.0), ("pendulum", 100.0)];

/// The number of timings of each run, of which the shortest counts.
const REPEATS: usize = 3;

/// Width and height of a figure, in pixels.
const FIGURE_SIZE: [f64; 2] = [560.0, 440.0];

/// A solution: its computing time and its error.
#[derive(Clone, Debug, Deserialize)]
pub struct Point {
    /// The problem.
    problem: String,
    /// The method.
    solver: String,
    /// Its step or tolerance.
    setting: String,
    /// The largest error.
    max_error: f64,
    /// The time, in s.
    seconds: f64,
}

/// Reads a file of the bench.
///
/// # Errors
///
/// [`CliError::Read`] if it cannot be read.
pub fn read(path: &Path) -> Result<Vec<Point>, CliError> {
    let failed = |cause: csv::Error| CliError::Read {
        path: path.to_owned(),
        cause: cause.to_string(),
    };
    let mut reader = csv::Reader::from_path(path).map_err(failed)?;
    reader.deserialize().collect::<Result<_, _>>().map_err(failed)
}

/// Measures this program's methods.
///
/// # Errors
///
/// [`CliError`] if a run does not reach its end.
pub fn measure(program: &mut Program) -> Result<Vec<Point>, CliError> {
    let mut runs = Vec::new();
    for h in [0.1, 0.05, 0.025, 0.0125, 0.00625] {
        runs.push(("order 2", Method::Step, h));
    }
    for (name, method) in [
        ("order 4", Composition::of_order(4)),
        ("order 6", Composition::of_order(6)),
        ("order 8", Composition::of_order(8)),
    ] {
        let Some(method) = method else { continue };
        for h in [0.2, 0.1, 0.05, 0.025] {
            runs.push((name, Method::Composed(method), h));
        }
    }
    for tolerance in [1e-3, 1e-5, 1e-7, 1e-9, 1e-11, 1e-13] {
        runs.push(("Taylor series", Method::Tolerance(tolerance), 0.1));
    }
    let bar = progress::bar((runs.len() * PROBLEMS.len()) as u64, "speed");
    let mut points = Vec::new();
    for (problem, until) in PROBLEMS {
        let entry = program.find(problem)?;
        for &(solver, method, h) in &runs {
            points.push(point(entry, solver, method, h, until)?);
            bar.inc(1);
        }
    }
    bar.finish_and_clear();
    Ok(points)
}

/// Measures one run.
fn point(entry: &Entry, solver: &str, method: Method, h: f64, until: f64) -> Result<Point, CliError> {
    let [q0, v0] = entry.default_start().cloned().unwrap_or_default();
    let beginning = Beginning::SecondOrder { q0, v0 };
    let mut plan = Plan {
        h,
        until,
        method,
        certify: false,
        estimate: false,
        inputs: Vec::new(),
    };
    let mut seconds = f64::INFINITY;
    for _ in 0..REPEATS {
        let begun = Instant::now();
        entry.run(&plan, &beginning, &mut |_| ControlFlow::Continue(()))?;
        seconds = seconds.min(begun.elapsed().as_secs_f64());
    }
    plan.estimate = true;
    let mut max_error = 0.0_f64;
    entry.run(&plan, &beginning, &mut |row| {
        max_error = max_error.max(row.errors.first().copied().unwrap_or(f64::NAN));
        ControlFlow::Continue(())
    })?;
    Ok(Point {
        problem: entry.name().to_owned(),
        solver: solver.to_owned(),
        setting: match method {
            Method::Tolerance(tolerance) => format!("tolerance {tolerance:e}"),
            _ => format!("h = {h}"),
        },
        max_error,
        seconds,
    })
}

/// Shows a figure for each problem, and a switch between them.
pub fn show(page: &mut Page, points: &[Point], read: bool) {
    page.heading("Speed against error");
    page.paragraph(if read {
        "Time of the whole solution, and its largest error, as the bench `work_precision` measured them."
    } else {
        "Time of the whole solution with all its nodes (the shortest of three), and the largest error of the first coordinate against \
         the continuous motion, to t = 100 s. Order 2 is the paper's step; Taylor series write a node every 0.1 s."
    });
    let mut problems: Vec<&str> = Vec::new();
    for point in points {
        if !problems.contains(&point.problem.as_str()) {
            problems.push(&point.problem);
        }
    }
    let choices = problems.iter().enumerate().map(|(place, problem)| {
        format!(
            "<label><input type=\"radio\" name=\"problem\" value=\"{0}\"{1}> {0}</label>",
            escaped(problem),
            if place == 0 { " checked" } else { "" }
        )
    });
    let choices: String = choices.collect();
    page.add(format!(
        "<fieldset class=\"switch\" id=\"problem\" hidden><legend>Problem</legend>{choices}</fieldset>\n<div class=\"figures wide\">"
    ));
    let mut points_by_name = serde_json::Map::new();
    for problem in problems {
        let of_problem: Vec<&Point> = points.iter().filter(|point| point.problem == problem).collect();
        let (figure, values) = figure(&of_problem);
        let name = format!("speed-{problem}");
        let title = format!("{problem}: largest error against the time of the whole solution");
        page.add(format!(
            "<figure data-switch=\"problem\" data-choice=\"{0}\" data-points=\"{1}\">{2}<figcaption>{3}</figcaption></figure>",
            escaped(problem),
            escaped(&name),
            figure.on_page(&name, &title),
            escaped(&title),
        ));
        points_by_name.insert(name, values);
    }
    page.add("</div>");
    page.data("points", points_by_name.into());
    let rows = points.iter().map(|point| {
        let words = [&point.problem, &point.solver, &point.setting].map(|text| Cell::Text(text.clone()));
        let numbers = [
            format!("{:.3}", 1e3 * point.seconds),
            format!("{:.2e}", point.max_error),
        ]
        .map(Cell::Number);
        words.into_iter().chain(numbers).collect()
    });
    let head = ["problem", "method", "setting", "#time [ms]", "#largest error"];
    page.add("<details><summary>The numbers of these figures</summary>");
    page.add(page::table("", &head, rows));
    page.add("</details>");
}

/// The figure of a problem, and the labels of its points.
fn figure(points: &[&Point]) -> (Figure, Value) {
    const COLOURS: [&str; 12] = [
        BLUE, GREEN, VERMILION, PURPLE, "#E69F00", "#56B4E9", "#999999", "#000000", "#A6761D", "#66A61E",
        "#E7298A", "#7570B3",
    ];
    let shown = |point: &&&Point| point.max_error > 0.0 && point.max_error.is_finite();
    let mut solvers: Vec<&str> = Vec::new();
    for point in points {
        if !solvers.contains(&point.solver.as_str()) {
            solvers.push(&point.solver);
        }
    }
    let mut curves = Vec::new();
    for (place, solver) in solvers.iter().enumerate() {
        let of = points
            .iter()
            .filter(shown)
            .filter(|point| point.solver == *solver);
        let places: Vec<[f64; 2]> = of.map(|point| [1e3 * point.seconds, point.max_error]).collect();
        let colour = COLOURS[place % COLOURS.len()];
        for (style, label) in [
            (Style::Line(1.4), Some((*solver).to_owned())),
            (Style::Discs(3.2), None),
        ] {
            curves.push(Curve {
                points: places.clone(),
                style,
                colour,
                label,
            });
        }
    }
    let values = points.iter().filter(shown).map(|point| {
        let words = format!(
            "{}, {}\n{:.3} ms, error {:.1e}",
            point.solver,
            point.setting,
            1e3 * point.seconds,
            point.max_error
        );
        json!([1e3 * point.seconds, point.max_error, words])
    });
    let values = values.collect();
    let panel = Panel {
        x: Axis::logarithmic("time of the whole solution [ms]"),
        y: Axis::logarithmic("largest error"),
        curves,
        legend: Legend::Ends,
        ..Panel::default()
    };
    let figure = Figure {
        size: FIGURE_SIZE,
        columns: 1,
        panels: vec![panel],
    };
    (figure, values)
}
