//! The figure of `dsocs run --plot`: columns against time, a panel each.

use std::io::Write;
use std::path::Path;

use super::CliError;
use super::output::OutputFile;
use crate::entry::{Column, Row};
use crate::figure::{Axis, BLUE, Curve, Envelope, Figure, Format, Panel, Style};

/// Width of the figure, in pixels.
const WIDTH: f64 = 900.0;
/// Height of a panel, in pixels, and the least height of the figure.
const HEIGHTS: [f64; 2] = [240.0, 420.0];

/// A figure in the making. What it keeps of a run does not grow with the run.
pub struct Plot {
    /// The file.
    file: OutputFile,
    /// Its format.
    format: Format,
    /// The panels.
    curves: Vec<PlottedColumn>,
}

/// A panel in the making.
struct PlottedColumn {
    /// The number of the column.
    column: usize,
    /// The label of the axis.
    label: String,
    /// The points.
    points: Envelope,
}

impl Plot {
    /// Begins the file, so that a place that cannot be written is found before the run. `shown` are the numbers of the
    /// columns among `all`.
    ///
    /// # Errors
    ///
    /// [`CliError`] if the name asks for no known format or the file cannot be written.
    pub fn create(path: &Path, all: &[Column], shown: &[usize]) -> Result<Self, CliError> {
        let format = Format::of(path)?;
        let curves = shown
            .iter()
            .filter(|&&column| column != 0)
            .map(|&column| PlottedColumn {
                column,
                label: label(&all[column]),
                points: Envelope::new(),
            });
        Ok(Self {
            format,
            curves: curves.collect(),
            file: OutputFile::create(path)?,
        })
    }

    /// Takes a node.
    pub fn push(&mut self, row: &Row<'_>) {
        for curve in &mut self.curves {
            if let Some(value) = row.values().nth(curve.column) {
                curve.points.push([row.t, value]);
            }
        }
    }

    /// Draws the figure and completes the file.
    ///
    /// # Errors
    ///
    /// [`CliError`] if the figure cannot be drawn or written.
    pub fn finish(self) -> Result<(), CliError> {
        let Self {
            mut file,
            format,
            curves,
        } = self;
        let last = curves.len().saturating_sub(1);
        let panels: Vec<Panel> = curves
            .into_iter()
            .enumerate()
            .map(|(index, curve)| {
                let points = curve.points.points();
                let time = match (points.first(), points.last()) {
                    (Some(first), Some(end)) => Axis::linear("").over(first[0], end[0]),
                    _ => Axis::linear(""),
                };
                let width = if points.len() > 600 { 0.7 } else { 1.3 };
                Panel {
                    x: if index == last {
                        Axis {
                            label: "t [s]".to_owned(),
                            ..time
                        }
                    } else {
                        time
                    },
                    y: Axis::linear(curve.label),
                    curves: vec![Curve {
                        points,
                        style: Style::Line(width),
                        colour: BLUE,
                        label: None,
                    }],
                    ..Panel::default()
                }
            })
            .collect();
        let height = (HEIGHTS[0] * panels.len() as f64).max(HEIGHTS[1]);
        let picture = Figure {
            size: [WIDTH, height],
            columns: 1,
            panels,
        }
        .encode(format)?;
        if let Err(cause) = file.write_all(&picture) {
            return Err(file.failed(cause));
        }
        file.finish()
    }
}

/// The label of a column, with its unit where it is known.
fn label(column: &Column) -> String {
    let name = column.name.split('_').map(greek).collect::<Vec<_>>().join(" ");
    match &column.unit {
        Some(unit) => format!("{name} [{unit}]"),
        None => name,
    }
}

/// The Greek letter of a name.
fn greek(name: &str) -> &str {
    match name {
        "theta" => "θ",
        "psi" => "ψ",
        "phi" => "φ",
        "alpha" => "α",
        "beta" => "β",
        other => other,
    }
}
