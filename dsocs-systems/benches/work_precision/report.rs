//! The report: a table for each problem, all points as CSV, and a picture for each problem.

use std::error::Error;
use std::fs;
use std::path::Path;

use dsocs_systems::figure::{Axis, BLUE, Curve, Figure, GREEN, Legend, PURPLE, Panel, Style, VERMILION};

use crate::measure::Point;

/// Solutions with a larger error, which have nothing to do with the motion any more, are left out of the pictures.
const LARGEST: f64 = 1e2;

/// The errors that are asked for.
fn targets() -> impl Iterator<Item = f64> {
    (2..=11).map(|k| 10.0_f64.powi(-k))
}

/// The fastest point of some that is as good as a target.
fn fastest<'p>(points: impl Iterator<Item = &'p Point>, target: f64) -> Option<&'p Point> {
    points
        .filter(|point| point.max_error <= target)
        .min_by(|a, b| a.seconds.total_cmp(&b.seconds))
}

fn ours(point: &Point) -> bool {
    point.solver.starts_with("dsocs")
}

/// The solvers, in the order of the measurement.
fn solvers(points: &[Point]) -> Vec<&'static str> {
    let mut solvers = Vec::new();
    for point in points {
        if !solvers.contains(&point.solver) {
            solvers.push(point.solver);
        }
    }
    solvers
}

/// The problems, in the order of the measurement.
pub fn problems(points: &[Point]) -> Vec<&'static str> {
    let mut problems: Vec<_> = points.iter().map(|point| point.problem).collect();
    problems.dedup();
    problems
}

/// The table of one problem, in Markdown: for each target the fastest time of each solver in ms and, in brackets, how many
/// times our best it takes.
pub fn table(problem: &str, points: &[Point]) -> String {
    let points: Vec<Point> = points
        .iter()
        .filter(|point| point.problem == problem)
        .cloned()
        .collect();
    let solvers = solvers(&points);
    let mut text = format!("\n### {problem}\n\n| error | {} |\n|---", solvers.join(" | "));
    text.push_str(&"|---".repeat(solvers.len()));
    text.push_str("|\n");
    for target in targets() {
        let best = fastest(points.iter().filter(|point| ours(point)), target);
        let mut cells = vec![format!("| {target:.0e} |")];
        for solver in &solvers {
            let own = fastest(points.iter().filter(|point| point.solver == *solver), target);
            let cell = match (own, best) {
                (None, _) => " |".to_owned(),
                (Some(own), Some(best)) => {
                    let (time, ratio) = (own.seconds * 1e3, own.seconds / best.seconds);
                    format!(" {time:.3} ({ratio:.2}) |")
                }
                (Some(own), None) => format!(" {:.3} |", own.seconds * 1e3),
            };
            cells.push(cell);
        }
        text.push_str(&cells.concat());
        text.push('\n');
    }
    text
}

/// For each target, how many times our best the fastest of the others takes.
pub fn ratios(problem: &str, points: &[Point]) -> Vec<(f64, Option<f64>)> {
    let of = |own: bool, target: f64| {
        let points = points
            .iter()
            .filter(move |point| point.problem == problem && ours(point) == own);
        fastest(points, target).map(|point| point.seconds)
    };
    targets()
        .map(|target| {
            let ratio = of(true, target)
                .zip(of(false, target))
                .map(|(ours, theirs)| theirs / ours);
            (target, ratio)
        })
        .collect()
}

/// Writes all points, and a picture of each problem.
pub fn write(directory: &Path, points: &[Point]) -> Result<(), Box<dyn Error>> {
    fs::create_dir_all(directory)?;
    let mut writer = csv::Writer::from_path(directory.join("work_precision.csv"))?;
    writer.write_record(["problem", "solver", "setting", "max_error", "seconds"])?;
    for point in points {
        let (error, seconds) = (format!("{:e}", point.max_error), format!("{:e}", point.seconds));
        writer.write_record([point.problem, point.solver, &point.setting, &error, &seconds])?;
    }
    writer.flush()?;
    for problem in problems(points) {
        let points: Vec<Point> = points
            .iter()
            .filter(|point| point.problem == problem)
            .cloned()
            .collect();
        let svg = picture(problem, &points).svg();
        fs::write(directory.join(format!("work_precision_{problem}.svg")), svg)?;
    }
    Ok(())
}

/// Error against time, both logarithmic.
fn picture(problem: &str, points: &[Point]) -> Figure {
    const COLOURS: [&str; 12] = [
        BLUE, GREEN, VERMILION, PURPLE, "#E69F00", "#56B4E9", "#999999", "#000000", "#A6761D", "#66A61E",
        "#E7298A", "#7570B3",
    ];
    let curves = solvers(points)
        .into_iter()
        .enumerate()
        .map(|(place, solver)| Curve {
            points: points
                .iter()
                .filter(|point| {
                    point.solver == solver
                        && (0.0..LARGEST).contains(&point.max_error)
                        && point.max_error > 0.0
                })
                .map(|point| [point.seconds * 1e3, point.max_error])
                .collect(),
            style: if solver.starts_with("dsocs") {
                Style::Line(2.0)
            } else {
                Style::Dashed(1.2)
            },
            colour: COLOURS[place % COLOURS.len()],
            label: Some(solver.to_owned()),
        })
        .collect();
    Figure {
        size: [820.0, 440.0],
        columns: 1,
        panels: vec![Panel {
            x: Axis::logarithmic(format!("{problem}: time of the whole solution [ms]")),
            y: Axis::logarithmic("largest error"),
            curves,
            legend: Legend::Right,
            equal_aspect: false,
        }],
    }
}
