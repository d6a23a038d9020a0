//! The report: a table for each problem, all points as CSV, and a picture for each problem.

use std::error::Error;
use std::fs;
use std::path::Path;

use dsocs_systems::figure::{Axis, BLUE, Curve, Figure, GREEN, Legend, PURPLE, Panel, Style, VERMILION};

use crate::measure::Point;

/// Solutions with a larger error are left out of the pictures: they no longer follow the motion.
const LARGEST: f64 = 1.0;

/// The target errors of the tables.
fn targets() -> impl Iterator<Item = f64> {
    (2..=11).map(|k| 10.0_f64.powi(-k))
}

/// The fastest point whose error is at most the target.
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

/// The table of one problem, in Markdown: for each target the fastest time of each solver in ms and, in
/// brackets, its ratio to the best time of this library.
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

/// The conditions of the measurement, which a reader needs for comparisons: processor, cores, compiler flags.
pub fn conditions() -> String {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let cpuinfo = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let processor = cpuinfo
        .lines()
        .find_map(|line| line.strip_prefix("model name")?.split_once(": "))
        .map_or(std::env::consts::ARCH, |(_, model)| model);
    let flags = option_env!("RUSTFLAGS").map_or_else(
        || "no flags of its own".to_owned(),
        |flags| format!("RUSTFLAGS={flags}"),
    );
    format!(
        "{processor}, {cores} cores, of which one is used; cargo's release profile, {flags}.\n\
         Each time is the median of 11 samples, which are taken in turn; within a sample caches are warm."
    )
}

/// The ratio of the fastest other solver to this library's best, for each problem and target, in Markdown.
pub fn ratios(points: &[Point]) -> String {
    let of = |problem: &str, own: bool, target: f64| {
        let points = points
            .iter()
            .filter(move |point| point.problem == problem && ours(point) == own);
        fastest(points, target)
    };
    let heads: Vec<String> = targets().map(|target| format!("{target:.0e}")).collect();
    let mut lines = vec![
        "\n### The fastest of the others, over our best\n".to_owned(),
        format!("| problem | {} |", heads.join(" | ")),
        format!("|---{}|", "|---".repeat(heads.len())),
    ];
    for problem in problems(points) {
        let cells: Vec<String> = targets()
            .map(
                |target| match (of(problem, true, target), of(problem, false, target)) {
                    (Some(own), Some(other)) => {
                        format!("{:.2}, {}", other.seconds / own.seconds, other.solver)
                    }
                    (Some(_), None) => "ours alone".to_owned(),
                    (None, Some(other)) => format!("{} alone", other.solver),
                    (None, None) => "not reached".to_owned(),
                },
            )
            .collect();
        lines.push(format!("| {problem} | {} |", cells.join(" | ")));
    }
    lines.join("\n")
}

/// The ratio of the longest to the shortest time of a point: its median and its largest value.
pub fn spread(points: &[Point]) -> String {
    let mut spreads: Vec<f64> = points
        .iter()
        .map(|point| point.between[1] / point.between[0])
        .collect();
    spreads.sort_by(f64::total_cmp);
    let (Some(middle), Some(worst)) = (spreads.get(spreads.len() / 2), spreads.last()) else {
        return String::new();
    };
    format!("Longest over shortest time of a point: {middle:.2} in the middle, {worst:.2} at worst.")
}

/// Writes all points, and a picture of each problem.
pub fn write(directory: &Path, points: &[Point]) -> Result<(), Box<dyn Error>> {
    fs::create_dir_all(directory)?;
    let mut writer = csv::Writer::from_path(directory.join("work_precision.csv"))?;
    writer.write_record([
        "problem",
        "solver",
        "setting",
        "max_error",
        "seconds",
        "shortest",
        "longest",
    ])?;
    for point in points {
        let [shortest, longest] = point.between;
        let [error, seconds, shortest, longest] =
            [point.max_error, point.seconds, shortest, longest].map(|number| format!("{number:e}"));
        writer.write_record([
            point.problem,
            point.solver,
            &point.setting,
            &error,
            &seconds,
            &shortest,
            &longest,
        ])?;
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

/// The unit of the measured components of a problem.
fn unit(problem: &str) -> &'static str {
    match problem {
        "pendulum" | "chain8" => "rad",
        "top" => "1",
        _ => "m",
    }
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
        size: [820.0, 520.0],
        columns: 1,
        panels: vec![Panel {
            x: Axis::logarithmic(format!("{problem}: time of the whole solution [ms]")),
            y: Axis::logarithmic(format!("largest error [{}]", unit(problem))),
            curves,
            legend: Legend::Ends,
            ..Panel::default()
        }],
    }
}
