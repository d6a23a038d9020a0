//! The one place that knows the plotting crate.

use std::sync::Arc;

use kuva::backend::svg::SvgBackend;
use kuva::plot::legend::LegendPosition;
use kuva::plot::scatter::MarkerShape;
use kuva::plot::{LinePlot, ScatterPlot};
use kuva::render::figure::Figure as Grid;
use kuva::render::layout::{Layout, TickFormat};
use kuva::render::plots::Plot;
use kuva::render::theme::Theme;

use super::axis::{linear_label, logarithmic_label};
use super::render::FONT;
use super::{Axis, Curve, Figure, Legend, Panel, Scale, Style};

/// Space around a figure, in pixels.
const PADDING: f64 = 4.0;
/// Space between panels, in pixels.
const SPACING: f64 = 6.0;
/// Width of the margin left of the axes, in pixels, the same in every panel so that their axes align.
const LEFT: f64 = 88.0;
/// Width of the margin right of the axes, in pixels.
const RIGHT: f64 = 22.0;
/// Width of a legend that stands beside the axes, in pixels.
const LEGEND: f64 = 236.0;
/// Height of the margin above the axes, in pixels.
const TOP: f64 = 14.0;
/// Height of the margin below axes with tick labels, in pixels.
const BOTTOM: f64 = 32.0;
/// Height that the label of the horizontal axis takes, in pixels.
const LABEL: f64 = 26.0;

/// The figure as the plotting crate writes it, with its text as text.
pub(super) fn svg(figure: &Figure) -> String {
    let columns = figure.columns.max(1);
    let rows = figure.panels.len().div_ceil(columns).max(1);
    let (plots, layouts): (Vec<_>, Vec<_>) = figure
        .panels
        .iter()
        .map(|panel| {
            let plots = curves(panel);
            let layout = layout(panel, &plots);
            (plots, layout)
        })
        .unzip();
    // the last row has the label of the axis, and the same height without
    let labelled = figure
        .panels
        .last()
        .is_some_and(|panel| !panel.x.label.is_empty());
    let label = if labelled && rows > 1 { LABEL } else { 0.0 };
    let gaps = 2.0 * PADDING + SPACING * (rows - 1) as f64;
    let height = (figure.size[1] - gaps - label) / rows as f64;
    let width = (figure.size[0] - 2.0 * PADDING - SPACING * (columns - 1) as f64) / columns as f64;
    let grid = Grid::new(rows, columns)
        .with_plots(plots)
        .with_layouts(layouts)
        .with_padding(PADDING)
        .with_spacing(SPACING)
        .with_cell_size(width, height)
        .with_row_height(rows - 1, height + label);
    SvgBackend.render_scene(&grid.render())
}

/// The curves of a panel.
fn curves(panel: &Panel) -> Vec<Plot> {
    let raise = ranges(panel).map(|(_, raise)| raise);
    panel
        .curves
        .iter()
        .map(|curve| plot(panel, curve, raise))
        .collect()
}

/// The smallest number that the crate shows on a logarithmic axis; smaller ones it takes for this one.
const LEAST: f64 = 1e-10;

/// The ranges of the axes, and the powers of ten that data is multiplied by so that the crate shows it.
fn ranges(panel: &Panel) -> [((f64, f64), f64); 2] {
    [(&panel.x, 0), (&panel.y, 1)].map(|(axis, component)| {
        let points = panel.curves.iter().flat_map(|curve| &curve.points);
        let range = axis.range_of(points.map(|point| point[component]));
        let raise = match axis.scale {
            Scale::Logarithmic if range.0 < LEAST => 10_f64.powf((LEAST / range.0).log10().ceil()),
            _ => 1.0,
        };
        (range, raise)
    })
}

/// One curve.
fn plot(panel: &Panel, curve: &Curve, raise: [f64; 2]) -> Plot {
    let points: Vec<(f64, f64)> = curve
        .points
        .iter()
        .filter(|[x, y]| panel.x.shows(*x) && panel.y.shows(*y))
        .map(|&[x, y]| (x * raise[0], y * raise[1]))
        .collect();
    let line = |width| {
        let line = LinePlot::new()
            .with_data(points.iter().copied())
            .with_color(curve.colour);
        let line = line.with_stroke_width(width);
        curve.label.iter().fold(line, LinePlot::with_legend)
    };
    let markers = |shape, size| {
        let markers = ScatterPlot::new()
            .with_data(points.iter().copied())
            .with_color(curve.colour);
        let markers = markers.with_marker(shape).with_size(size);
        curve.label.iter().fold(markers, ScatterPlot::with_legend)
    };
    match curve.style {
        Style::Line(width) => line(width).into(),
        Style::Dashed(width) => line(width).with_dashed().into(),
        Style::Discs(size) => markers(MarkerShape::Circle, size).into(),
        Style::Squares(size) => markers(MarkerShape::Square, size).into(),
    }
}

/// The axes of a panel.
fn layout(panel: &Panel, plots: &[Plot]) -> Layout {
    let [(x, raise_x), (y, raise_y)] = ranges(panel);
    let position = match panel.legend {
        Legend::TopLeft => LegendPosition::InsideTopLeft,
        Legend::At([x, y]) => LegendPosition::DataCoords(x * raise_x, y * raise_y),
        Legend::Right => LegendPosition::OutsideRightTop,
    };
    let right = if panel.legend == Legend::Right {
        RIGHT + LEGEND
    } else {
        RIGHT
    };
    let label = if panel.x.label.is_empty() { 0.0 } else { LABEL };
    let mut layout = Layout::auto_from_plots(plots)
        .with_x_axis_min(x.0 * raise_x)
        .with_x_axis_max(x.1 * raise_x)
        .with_y_axis_min(y.0 * raise_y)
        .with_y_axis_max(y.1 * raise_y)
        .with_x_tick_format(ticks(&panel.x, x, raise_x))
        .with_y_tick_format(ticks(&panel.y, y, raise_y))
        .with_y_label(panel.y.label.as_str())
        .with_y_label_offset(-4.0, 0.0)
        .with_legend_position(position)
        .with_force_margins(LEFT, right)
        .with_force_margins_y(TOP, BOTTOM + label)
        .with_theme(theme())
        .with_font_family(FONT)
        .with_label_size(15)
        .with_tick_size(13)
        .with_body_size(13)
        .with_axis_line_width(1.0)
        .with_tick_width(1.0)
        .with_grid_line_width(0.6)
        .with_box_axes();
    // the crate's estimate is for a narrower font
    layout.legend_width *= 1.12;
    // the label of the vertical axis stands beside the tick labels of this range
    if panel.y.scale == Scale::Linear {
        layout.y_range = y;
    }
    if !panel.x.label.is_empty() {
        layout = layout.with_x_label(panel.x.label.as_str());
    }
    if panel.x.scale == Scale::Logarithmic {
        layout = layout.with_log_x();
    }
    if panel.y.scale == Scale::Logarithmic {
        layout = layout.with_log_y();
    }
    if panel.equal_aspect {
        layout.with_equal_aspect()
    } else {
        layout
    }
}

/// The labels of an axis's ticks.
fn ticks(axis: &Axis, range: (f64, f64), raise: f64) -> TickFormat {
    TickFormat::Custom(match axis.scale {
        Scale::Linear => Arc::new(move |value| linear_label(value, range)),
        Scale::Logarithmic => {
            let decades = (range.1 / range.0).log10();
            Arc::new(move |value| logarithmic_label(value / raise, decades))
        }
    })
}

/// Black on white with a light grid.
fn theme() -> Theme {
    Theme {
        grid_color: "#e4e4e4".into(),
        legend_border: "#cccccc".into(),
        ..Theme::light()
    }
}
