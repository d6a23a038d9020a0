//! `plot`: the figure of a sweep: a map over two quantities that vary, or curves over one.

use std::ops::Range;
use std::path::PathBuf;

use clap::Args;

use crate::cli::CliError;
use crate::cli::arguments::start::assignment;
use crate::cli::figures::label::label;
use crate::cli::output::OutputFile;
use crate::entry::{Column, UnknownName};
use crate::figure::{Axis, BLUE, Curve, Figure, Format, HeatMap, Panel, Scale, Style};
use crate::sweep::{Axis as Varied, Content};

/// Width and height of a map's panel, in pixels.
const MAP_SIZE: [f64; 2] = [760.0, 600.0];
/// Width and height of a panel of curves, in pixels.
const CURVES_SIZE: [f64; 2] = [900.0, 280.0];
/// The largest number of cells of a map across or up: more could not be seen. A cell then shows the mean of
/// its points.
const MOST_CELLS: usize = 500;
/// The number of cells for a quantity whose values are not evenly spaced.
const UNEVEN_CELLS: usize = 400;
/// The largest number of panels, unless columns are asked for.
const MOST_PANELS: usize = 4;

/// The arguments of `plot`.
#[derive(Args, Debug)]
pub struct MapArguments {
    /// The folder of a sweep
    folder: PathBuf,
    /// The columns that are shown, each in a panel [default: the columns kept at the end]
    #[arg(long, value_name = "NAME,NAME", value_delimiter = ',')]
    of: Option<Vec<String>>,
    /// The quantity on the horizontal axis [default: the first that has several values]
    #[arg(long, value_name = "NAME")]
    x: Option<String>,
    /// The quantity on the vertical axis of a map; `none` draws curves [default: the second that has several values, if there is one]
    #[arg(long, value_name = "NAME|none")]
    y: Option<String>,
    /// The value of another quantity that varies; may be given several times [default: in the middle]
    #[arg(long, value_name = "NAME=VALUE", allow_hyphen_values = true, value_parser = assignment)]
    at: Vec<(String, f64)>,
    /// A logarithmic scale for the columns that are shown
    #[arg(long)]
    log: bool,
    /// The figure: an .svg file, or with the feature `png` a .png file
    #[arg(long, value_name = "FILE", default_value = "sweep.svg")]
    out: PathBuf,
}

/// Draws a sweep.
///
/// # Errors
///
/// [`CliError`] if there is no sweep, it has no such columns, or the figure cannot be written.
pub fn plot(arguments: &MapArguments) -> Result<(), CliError> {
    let content = Content::open(&arguments.folder)?;
    let format = Format::of(&arguments.out)?;
    let file = OutputFile::create(&arguments.out)?;
    let (parts, there) = content.parts();
    if there < parts {
        crate::cli::output::terminal::tell(format_args!(
            "note: {} of {parts} parts are missing, and so are their points",
            parts - there
        ));
    }
    let (across, up) = axes(arguments, &content)?;
    let of = shown_columns(arguments, &content);
    let data = Data::read(arguments, &content, &of, (across, up))?;
    let panels: Vec<Panel> = (0..of.len())
        .map(|place| match up {
            Some(up) => data.map(
                place,
                [&content.axes()[across], &content.axes()[up]],
                arguments.log,
            ),
            None => data.curve(place, &content.axes()[across], arguments.log),
        })
        .collect();
    let columns = if up.is_some() && panels.len() > 1 { 2 } else { 1 };
    let [width, height] = if up.is_some() { MAP_SIZE } else { CURVES_SIZE };
    let rows = panels.len().div_ceil(columns);
    let picture = Figure {
        size: [
            width * columns as f64,
            (height * rows as f64).max(MAP_SIZE[1] - CURVES_SIZE[1]),
        ],
        columns,
        panels,
    }
    .encode(format)?;
    file.complete(&picture)
}

/// The quantities across and, in a map, up, by their indices.
fn axes(arguments: &MapArguments, content: &Content) -> Result<(usize, Option<usize>), CliError> {
    let all = content.axes();
    let find = |name: &str| {
        let known = all.iter().map(|axis| axis.name.clone());
        all.iter()
            .position(|axis| axis.name == name)
            .ok_or_else(|| UnknownName::new("quantity that varies", name, known))
    };
    let several = |place: &usize| all[*place].count != Some(1);
    let given = match &arguments.y {
        Some(name) if name != "none" => Some(find(name)?),
        _ => None,
    };
    let x = match &arguments.x {
        Some(name) => find(name)?,
        None => (0..all.len())
            .find(|place| several(place) && Some(*place) != given)
            .unwrap_or(0),
    };
    let y = match (&arguments.y, given) {
        (Some(_), given) => given,
        (None, _) => (0..all.len()).find(|place| several(place) && *place != x),
    };
    Ok((x, y))
}

/// The columns that are shown.
fn shown_columns(arguments: &MapArguments, content: &Content) -> Vec<String> {
    if let Some(names) = &arguments.of {
        return names.clone();
    }
    let columns = || content.columns().iter();
    let ends = columns().filter(|name| name.starts_with("end_") && *name != "end_t");
    let ends: Vec<String> = ends.take(MOST_PANELS).cloned().collect();
    if !ends.is_empty() {
        return ends;
    }
    let begins = |name: &&String| {
        ["end_", "least_", "count_"]
            .iter()
            .any(|begin| name.starts_with(begin))
    };
    columns().filter(begins).take(MOST_PANELS).cloned().collect()
}

/// The points that a figure shows.
struct Data {
    /// The values of the quantities across, and up.
    places: [Vec<f64>; 2],
    /// The columns that are shown.
    values: Vec<Vec<f64>>,
    /// Their labels.
    labels: Vec<String>,
    /// Whether the points lie on a grid.
    grid: bool,
}

impl Data {
    /// Reads the points at which the quantities that are not shown have their chosen values.
    fn read(
        arguments: &MapArguments,
        content: &Content,
        of: &[String],
        (x, y): (usize, Option<usize>),
    ) -> Result<Self, CliError> {
        let axes = content.axes();
        for (name, _) in &arguments.at {
            if !axes.iter().any(|axis| axis.name == *name) {
                let known = axes.iter().map(|axis| axis.name.clone());
                return Err(UnknownName::new("quantity that varies", name, known).into());
            }
        }
        let names: Vec<&str> = axes
            .iter()
            .map(|axis| axis.name.as_str())
            .chain(of.iter().map(String::as_str))
            .collect();
        let mut all = content.numbers(&names)?;
        let values = all.split_off(axes.len());
        let mut kept = vec![true; all.first().map_or(0, Vec::len)];
        for (place, axis) in axes.iter().enumerate() {
            // at random points, no two have the same value
            if place == x || Some(place) == y || !content.is_grid() {
                continue;
            }
            let there = distinct(&all[place]);
            let given = arguments.at.iter().find(|(name, _)| *name == axis.name);
            let middle = there.get(there.len() / 2).copied().unwrap_or(f64::NAN);
            let wanted = given.map_or(middle, |&(_, value)| value);
            let nearest = there
                .iter()
                .copied()
                .min_by(|a, b| (a - wanted).abs().total_cmp(&(b - wanted).abs()));
            let Some(nearest) = nearest else { continue };
            if there.len() > 1 {
                crate::cli::output::terminal::tell(format_args!("note: {} = {nearest}", axis.name));
            }
            for (kept, value) in kept.iter_mut().zip(&all[place]) {
                *kept &= value.to_bits() == nearest.to_bits();
            }
        }
        let chosen = |column: &Vec<f64>| -> Vec<f64> {
            let values = column.iter().zip(&kept);
            values
                .filter(|(_, kept)| **kept)
                .map(|(value, _)| *value)
                .collect()
        };
        let labels = of.iter().map(|name| column_label(name, content.unit(name)));
        Ok(Self {
            places: [chosen(&all[x]), y.map_or_else(Vec::new, |y| chosen(&all[y]))],
            values: values.iter().map(chosen).collect(),
            labels: labels.collect(),
            grid: content.is_grid(),
        })
    }

    /// A column over one quantity.
    fn curve(&self, column: usize, across: &Varied, log: bool) -> Panel {
        let mut points: Vec<[f64; 2]> = self.places[0]
            .iter()
            .zip(&self.values[column])
            .map(|(&x, &y)| [x, y])
            .collect();
        points.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let few = points.len() <= 60;
        let mut curves = Vec::new();
        let curve = |style| Curve {
            points: points.clone(),
            style,
            colour: BLUE,
            label: None,
        };
        if self.grid {
            curves.push(curve(Style::Line(1.3)));
        }
        if few || !self.grid {
            curves.push(curve(Style::Discs(if few { 3.0 } else { 1.5 })));
        }
        Panel {
            x: axis(across),
            y: axis_with_scale(self.labels[column].clone(), log),
            curves,
            ..Panel::default()
        }
    }

    /// A column over two quantities.
    fn map(&self, column: usize, [across, up]: [&Varied; 2], log: bool) -> Panel {
        let cuts = [(across, 0), (up, 1)].map(|(axis, place)| {
            if self.grid {
                AxisCells::of_grid(&self.places[place], axis.logarithmic)
            } else {
                AxisCells::of_random_points(&self.places[place], axis.logarithmic)
            }
        });
        let cells = [cuts[0].cells.len(), cuts[1].cells.len()];
        let colours = axis_with_scale(self.labels[column].clone(), log);
        // the sum and the number of values, by cell
        let size = [cuts[0].count, cuts[1].count];
        let mut sums = vec![(0.0, 0_u32); size[0] * size[1]];
        for ((&x, &y), &value) in self.places[0]
            .iter()
            .zip(&self.places[1])
            .zip(&self.values[column])
        {
            let value = if log && value > 0.0 {
                value.ln()
            } else if log {
                f64::NAN
            } else {
                value
            };
            if let (Some(i), Some(j), true) = (cuts[0].place(x), cuts[1].place(y), value.is_finite()) {
                let (sum, count) = &mut sums[j * size[0] + i];
                (*sum, *count) = (*sum + value, *count + 1);
            }
        }
        let mut values = Vec::with_capacity(cells[0] * cells[1]);
        for rows in &cuts[1].cells {
            for columns in &cuts[0].cells {
                let places = rows
                    .clone()
                    .flat_map(|j| columns.clone().map(move |i| j * size[0] + i));
                let (sum, count) = places.fold((0.0, 0), |(sum, count), place| {
                    (sum + sums[place].0, count + sums[place].1)
                });
                let mean = sum / f64::from(count);
                values.push(if log { mean.exp() } else { mean });
            }
        }
        Panel {
            x: axis(across),
            y: axis(up),
            map: Some(HeatMap {
                cells,
                values,
                edges: [cuts[0].edges, cuts[1].edges],
                colours,
            }),
            ..Panel::default()
        }
    }
}

/// The division of a map's axis into cells.
struct AxisCells {
    /// The distinct values, in order; empty where points are random.
    distinct: Vec<f64>,
    /// The number of distinct values, or of cells where points are random.
    count: usize,
    /// The range of distinct values that each cell shows.
    cells: Vec<Range<usize>>,
    /// The lower edge of the first cell and the upper edge of the last.
    edges: [f64; 2],
    /// Whether the scale is logarithmic.
    logarithmic: bool,
}

impl AxisCells {
    /// Cells for a grid: one for each value, or for several values where there are too many. Where values are
    /// not evenly spaced, each cell shows the nearest value.
    fn of_grid(values: &[f64], logarithmic: bool) -> Self {
        let distinct = distinct(values);
        let count = distinct.len();
        let logarithmic = logarithmic && distinct.first().is_some_and(|&first| first > 0.0);
        let scale = |x: f64| if logarithmic { x.ln() } else { x };
        let back = |x: f64| if logarithmic { x.exp() } else { x };
        let places: Vec<f64> = distinct.iter().map(|&x| scale(x)).collect();
        let gaps: Vec<f64> = places.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let (first, last) = (
            places.first().copied().unwrap_or(0.0),
            places.last().copied().unwrap_or(1.0),
        );
        let mean = if count > 1 {
            (last - first) / (count - 1) as f64
        } else {
            1.0
        };
        let even = gaps.iter().all(|gap| (gap - mean).abs() < 1e-6 * mean.abs());
        let outer = |gap: Option<&f64>| gap.copied().unwrap_or(mean) / 2.0;
        let (from, to) = (first - outer(gaps.first()), last + outer(gaps.last()));
        let (cells, to): (Vec<Range<usize>>, f64) = if even {
            let each = count.div_ceil(MOST_CELLS).max(1);
            let cells: Vec<_> = (0..count.div_ceil(each))
                .map(|cell| cell * each..((cell + 1) * each).min(count))
                .collect();
            // the last cell is as wide as the others
            let to = from + (cells.len() * each) as f64 * mean;
            (cells, to)
        } else {
            let nearest = |cell: usize| {
                let x = from + (to - from) * (cell as f64 + 0.5) / UNEVEN_CELLS as f64;
                let after = places.partition_point(|&place| place < x).min(count - 1);
                let before = after.saturating_sub(1);
                if x - places[before] < places[after] - x {
                    before
                } else {
                    after
                }
            };
            (
                (0..UNEVEN_CELLS)
                    .map(nearest)
                    .map(|place| place..place + 1)
                    .collect(),
                to,
            )
        };
        Self {
            distinct,
            count,
            cells,
            edges: [back(from), back(to)],
            logarithmic,
        }
    }

    /// Cells for random points: of equal width, about four points to a cell.
    fn of_random_points(values: &[f64], logarithmic: bool) -> Self {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // at most a thousand
        let count = ((values.len() as f64 / 4.0).sqrt() as usize).clamp(4, 200);
        let ends = values
            .iter()
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[least, greatest], &x| {
                [least.min(x), greatest.max(x)]
            });
        let edges = if ends[0] < ends[1] { ends } else { [0.0, 1.0] };
        Self {
            distinct: Vec::new(),
            count,
            cells: (0..count).map(|place| place..place + 1).collect(),
            logarithmic: logarithmic && edges[0] > 0.0,
            edges,
        }
    }

    /// The index of a value among the distinct values, or of its cell where points are random.
    fn place(&self, x: f64) -> Option<usize> {
        if !self.distinct.is_empty() {
            return self.distinct.binary_search_by(|value| value.total_cmp(&x)).ok();
        }
        let scale = |x: f64| if self.logarithmic { x.ln() } else { x };
        let [from, to] = self.edges.map(scale);
        let part = (scale(x) - from) / (to - from);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a place among them
        let place = (part * self.count as f64) as usize;
        (0.0..=1.0).contains(&part).then(|| place.min(self.count - 1))
    }
}

/// The distinct values, in order.
fn distinct(values: &[f64]) -> Vec<f64> {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    values.dedup_by(|a, b| a.to_bits() == b.to_bits());
    values
}

/// The axis of a quantity that varies.
fn axis(varied: &Varied) -> Axis {
    let name = column_label(&varied.name, varied.unit.as_deref());
    axis_with_scale(name, varied.logarithmic)
}

/// An axis with a scale.
fn axis_with_scale(label: String, logarithmic: bool) -> Axis {
    Axis {
        label,
        scale: if logarithmic {
            Scale::Logarithmic
        } else {
            Scale::Linear
        },
        ..Axis::default()
    }
}

/// The label of a column: the quantity, and when it is taken.
fn column_label(column: &str, unit: Option<&str>) -> String {
    let (name, when) = match column.split_once('_') {
        Some(("end", name)) => (name, " at the end"),
        Some(("least", name)) => (name, ", least"),
        Some(("greatest", name)) => (name, ", greatest"),
        _ => (column, ""),
    };
    let column = Column {
        name: name.to_owned(),
        unit: None,
    };
    let unit = unit.map_or_else(String::new, |unit| format!(" [{unit}]"));
    format!("{}{when}{unit}", label(&column))
}
