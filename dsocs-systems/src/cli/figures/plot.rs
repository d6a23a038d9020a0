//! The figure of `dsocs run --plot`: columns against time, a panel each.

use std::path::Path;

use crate::cli::CliError;
use crate::cli::figures::label::label;
use crate::cli::figures::moments::Moments;
use crate::cli::output::OutputFile;
use crate::entry::Column;
use crate::figure::{Axis, BLUE, Curve, Envelope, Figure, Format, Panel, Style};

/// Width of the figure, in pixels.
const WIDTH: f64 = 900.0;
/// Height of a panel, in pixels, and the least height of the figure.
const HEIGHTS: [f64; 2] = [240.0, 420.0];

/// The largest number of panels in one column; more stand in two.
const ONE_COLUMN_PANELS: usize = 6;
/// The largest number of points of a path.
const PATH_POINTS: usize = 8000;
/// Width and height of the figure of a path, in pixels.
const PATH_SIZE: [f64; 2] = [760.0, 722.0];

/// A figure in the making. Its memory does not grow with the run.
pub struct Plot {
    /// The file.
    file: OutputFile,
    /// Its format.
    format: Format,
    /// The panels.
    curves: Vec<PlottedColumn>,
    /// The panel of a path, if one is asked for.
    path: Option<PlottedPath>,
}

/// The panel of a path in the making.
struct PlottedPath {
    /// The numbers of its columns.
    columns: [usize; 2],
    /// Their labels.
    labels: [String; 2],
    /// Whether both are lengths.
    lengths: bool,
    /// The points.
    points: Moments,
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
    /// columns among `all`; where the two of `path` are given, the figure is the path of these columns instead.
    ///
    /// # Errors
    ///
    /// [`CliError`] if the name asks for no known format or the file cannot be written.
    pub fn create(
        path: &Path,
        all: &[Column],
        shown: &[usize],
        path_of: Option<[usize; 2]>,
    ) -> Result<Self, CliError> {
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
            path: path_of.map(|columns| PlottedPath {
                columns,
                labels: columns.map(|column| label(&all[column])),
                lengths: columns.map(|column| all[column].unit.as_deref() == Some("m")) == [true; 2],
                points: Moments::new(PATH_POINTS),
            }),
            file: OutputFile::create(path)?,
        })
    }

    /// Takes the number of a node and the values of all columns there.
    pub fn push(&mut self, index: u64, values: &[f64]) {
        if let Some(path) = &mut self.path {
            let values = path.columns.map(|column| values[column]);
            path.points.push(index, values.to_vec());
        }
        for curve in &mut self.curves {
            curve.points.push([values[0], values[curve.column]]);
        }
    }

    /// Draws the figure and completes the file.
    ///
    /// # Errors
    ///
    /// [`CliError`] if the figure cannot be drawn or written.
    pub fn finish(self) -> Result<(), CliError> {
        let Self {
            file,
            format,
            curves,
            path,
        } = self;
        let columns = if curves.len() > ONE_COLUMN_PANELS { 2 } else { 1 };
        let count = curves.len();
        let mut panels = Vec::new();
        for (index, curve) in curves.into_iter().enumerate() {
            let points = curve.points.points();
            let time = match (points.first(), points.last()) {
                (Some(first), Some(end)) => Axis::linear("").with_range(first[0], end[0]),
                _ => Axis::linear(""),
            };
            let width = if points.len() > 600 { 0.7 } else { 1.3 };
            // the panels of a column share one axis of time, below the last of them
            let time = if index + columns >= count {
                Axis {
                    label: "t [s]".to_owned(),
                    ..time
                }
            } else {
                time.without_labels()
            };
            panels.push(Panel {
                x: time,
                y: Axis::linear(curve.label),
                curves: vec![line(points, width)],
                ..Panel::default()
            });
        }
        let mut size = [
            WIDTH * columns as f64,
            (HEIGHTS[0] * panels.len().div_ceil(columns) as f64).max(HEIGHTS[1]),
        ];
        if let Some(path) = path {
            let [x, y] = path.labels.map(Axis::linear);
            let points = path
                .points
                .into_rows()
                .iter()
                .map(|row| [row[0], row[1]])
                .collect();
            size = PATH_SIZE;
            panels = vec![Panel {
                x,
                y,
                curves: vec![line(points, 1.0)],
                equal_aspect: path.lengths,
                ..Panel::default()
            }];
        }
        let columns = if panels.len() > 1 { columns } else { 1 };
        let picture = Figure {
            size,
            columns,
            panels,
        }
        .encode(format)?;
        file.complete(&picture)
    }
}

/// A curve of these points.
fn line(points: Vec<[f64; 2]>, width: f64) -> Curve {
    Curve {
        points,
        style: Style::Line(width),
        colour: BLUE,
        label: None,
    }
}
