//! The layout of a figure: the positions of panels, axes, labels and curves.

mod legend;

use crate::figure::band::{LinePart, parts};
use crate::figure::svg::{Anchor, Area, Lettering, Svg, width};
use crate::figure::{Axis, Curve, Figure, Legend, Panel, Scale, Style};

/// Space around a figure, in pixels.
const PADDING: f64 = 4.0;
/// Space between panels, in pixels.
const SPACING: f64 = 6.0;
/// Least width of the margin left of the axes, in pixels. It is the same in every panel so that their axes align.
const LEFT_MARGIN: f64 = 88.0;
/// Width that the label of the vertical axis takes of that margin, with space on both sides, in pixels.
const UPRIGHT_LABEL: f64 = 32.0;
/// Width of the margin right of the axes, in pixels.
const RIGHT_MARGIN: f64 = 22.0;
/// Width of a legend that stands beside the axes, in pixels.
const LEGEND_WIDTH: f64 = 236.0;
/// Height of the margin above the axes, in pixels.
const TOP_MARGIN: f64 = 14.0;
/// Height of the margin below axes with tick labels, in pixels.
const BOTTOM_MARGIN: f64 = 32.0;
/// Height of the margin below axes whose ticks have no labels, in pixels.
const BOTTOM_MARGIN_WITHOUT_LABELS: f64 = 8.0;
/// Height that the label of the horizontal axis takes, in pixels.
const LABEL_HEIGHT: f64 = 26.0;

/// Length of a tick, and the space from the axis to its label, in pixels.
const TICK: [f64; 2] = [5.0, 9.0];
/// Length of a minor tick, in pixels.
const MINOR_TICK: f64 = 3.0;
/// Space that a minor tick needs, in pixels.
const MINOR_TICK_SPACE: f64 = 6.0;
/// Size of the axes' labels, and of all other text, in pixels.
const TEXT_SIZES: [f64; 2] = [15.0, 13.0];
/// Space from the axes to a legend in the corner, in pixels.
const LEGEND_SPACE: f64 = 14.0;

/// Width of the space between a map and its bar of colours, of the bar, and of its ticks' labels with its own, in pixels.
#[cfg(feature = "sweep")]
const COLOUR_BAR: [f64; 3] = [14.0, 16.0, 72.0];

/// The colour of axes and their ticks.
const AXES_COLOUR: &str = "#000000";
/// The colour of the grid.
const GRID_COLOUR: &str = "#e4e4e4";
/// The colour of the frame of a legend.
const FRAME_COLOUR: &str = "#cccccc";

/// The figure as SVG.
pub(super) fn svg(figure: &Figure) -> String {
    draw(figure, Svg::new(figure.size))
}

/// The figure as an element of a page; see [`Svg::on_page`].
pub(super) fn on_page(figure: &Figure, name: &str, title: &str) -> String {
    draw(figure, Svg::on_page(figure.size, name, title))
}

/// Draws the figure.
fn draw(figure: &Figure, mut svg: Svg) -> String {
    let columns = figure.columns.max(1);
    let rows = figure.panels.len().div_ceil(columns).max(1);
    let columns_of = |row: usize| figure.panels.iter().skip(row * columns).take(columns);
    let bottoms: Vec<f64> = (0..rows)
        .map(|row| columns_of(row).map(bottom_margin).fold(0.0, f64::max))
        .collect();
    let margins = bottoms.iter().map(|bottom| TOP_MARGIN + bottom).sum::<f64>();
    let height = (figure.size[1] - 2.0 * PADDING - SPACING * (rows - 1) as f64 - margins) / rows as f64;
    let width = (figure.size[0] - 2.0 * PADDING - SPACING * (columns - 1) as f64) / columns as f64;
    let left = figure.panels.iter().map(left_margin).fold(LEFT_MARGIN, f64::max);
    for (place, panel) in figure.panels.iter().enumerate() {
        let (row, column) = (place / columns, place % columns);
        let cell = Area {
            left: PADDING + (width + SPACING) * column as f64,
            top: PADDING + (height + SPACING + TOP_MARGIN) * row as f64 + bottoms[..row].iter().sum::<f64>(),
            width,
            height: TOP_MARGIN + height + bottoms[row],
        };
        let axes = Axes::new(panel, &cell, left);
        let shown =
            [(&panel.x, 0), (&panel.y, 1)].map(|(axis, place)| axis.scale.script_data(axes.ranges[place]));
        svg.axes(&axes.area, [&shown[0], &shown[1]], |svg| axes.draw(svg));
    }
    svg.finish()
}

/// The margin that a panel's horizontal axis needs for its labels.
fn bottom_margin(panel: &Panel) -> f64 {
    let ticks = if panel.x.without_labels {
        BOTTOM_MARGIN_WITHOUT_LABELS
    } else {
        BOTTOM_MARGIN
    };
    if panel.x.label.is_empty() {
        ticks
    } else {
        ticks + LABEL_HEIGHT
    }
}

/// The margin that a panel's vertical axis needs for its labels.
fn left_margin(panel: &Panel) -> f64 {
    let ticks = panel.y.scale.ticks(ranges(panel)[1]);
    let widest = ticks.iter().map(|(_, label)| width(label, TEXT_SIZES[1]));
    widest.fold(0.0, f64::max) + TICK[1] + UPRIGHT_LABEL
}

/// The ranges of both axes.
fn ranges(panel: &Panel) -> [(f64, f64); 2] {
    [(&panel.x, 0), (&panel.y, 1)].map(|(axis, component)| {
        #[cfg(feature = "sweep")]
        if let (Some(map), None) = (&panel.map, axis.range) {
            let [from, to] = map.edges[component];
            return (from, to);
        }
        let points = panel.curves.iter().flat_map(|curve| &curve.points);
        axis.range_of(points.map(|point| point[component]))
    })
}

/// The axes of a panel on the picture.
struct Axes<'p> {
    /// The panel.
    panel: &'p Panel,
    /// The position of the axes in the picture.
    area: Area,
    /// The ranges of both axes.
    ranges: [(f64, f64); 2],
    /// The width of the margin on the left for the ticks' labels.
    left: f64,
}

impl<'p> Axes<'p> {
    /// The axes of a panel in a cell of the picture, with this margin on the left.
    fn new(panel: &'p Panel, cell: &Area, left: f64) -> Self {
        let right = match panel.legend {
            Legend::Right => RIGHT_MARGIN + LEGEND_WIDTH,
            Legend::TopLeft | Legend::At(_) | Legend::Ends => RIGHT_MARGIN,
        };
        #[cfg(feature = "sweep")]
        let right = right + panel.map.as_ref().map_or(0.0, |_| COLOUR_BAR.iter().sum());
        let bottom = bottom_margin(panel);
        let area = Area {
            left: cell.left + left,
            top: cell.top + TOP_MARGIN,
            width: (cell.width - left - right).max(1.0),
            height: (cell.height - TOP_MARGIN - bottom).max(1.0),
        };
        let mut ranges = ranges(panel);
        if panel.equal_aspect && [panel.x.scale, panel.y.scale] == [Scale::Linear; 2] {
            ranges = of_equal_aspect(ranges, &area);
        }
        Self {
            panel,
            area,
            ranges,
            left,
        }
    }

    /// The position of a horizontal coordinate.
    fn across(&self, x: f64) -> f64 {
        self.area.left + self.area.width * self.panel.x.scale.place(x, self.ranges[0])
    }

    /// The position of a vertical coordinate.
    fn down(&self, y: f64) -> f64 {
        self.area.bottom() - self.area.height * self.panel.y.scale.place(y, self.ranges[1])
    }

    /// Draws all of the panel.
    fn draw(&self, svg: &mut Svg) {
        let area = &self.area;
        let across: Vec<_> = self.ticks(0, |x| self.across(x));
        let down: Vec<_> = self.ticks(1, |y| self.down(y));
        // a grid line on the axes would not be visible
        let inside = |place: f64, from: f64, to: f64| place - from > 1.0 && to - place > 1.0;
        for &(x, _) in across.iter().filter(|(x, _)| inside(*x, area.left, area.right())) {
            svg.polyline([[x, area.top], [x, area.bottom()]], GRID_COLOUR, 0.6, None);
        }
        for &(y, _) in down.iter().filter(|(y, _)| inside(*y, area.top, area.bottom())) {
            svg.polyline([[area.left, y], [area.right(), y]], GRID_COLOUR, 0.6, None);
        }
        #[cfg(feature = "sweep")]
        self.map(svg);
        svg.clipped(area, |svg| {
            for curve in &self.panel.curves {
                self.curve(svg, curve);
            }
        });
        svg.rectangle(area, "none", AXES_COLOUR);
        let minor = |axis: &Axis, range, length: f64| {
            let ticks = axis.scale.minor_ticks(range);
            let crowded = ticks.len() as f64 * MINOR_TICK_SPACE > length;
            if crowded { Vec::new() } else { ticks }
        };
        for x in minor(&self.panel.x, self.ranges[0], area.width) {
            let x = self.across(x);
            svg.polyline(
                [[x, area.bottom()], [x, area.bottom() + MINOR_TICK]],
                AXES_COLOUR,
                0.8,
                None,
            );
        }
        for y in minor(&self.panel.y, self.ranges[1], area.height) {
            let y = self.down(y);
            svg.polyline(
                [[area.left - MINOR_TICK, y], [area.left, y]],
                AXES_COLOUR,
                0.8,
                None,
            );
        }
        for (x, label) in &across {
            svg.polyline(
                [[*x, area.bottom()], [*x, area.bottom() + TICK[0]]],
                AXES_COLOUR,
                1.0,
                None,
            );
            if !self.panel.x.without_labels {
                let below = area.bottom() + TICK[1] + 0.4 * TEXT_SIZES[1];
                svg.text(label, &plain([*x, below], Anchor::Middle));
            }
        }
        for (y, label) in &down {
            svg.polyline(
                [[area.left - TICK[0], *y], [area.left, *y]],
                AXES_COLOUR,
                1.0,
                None,
            );
            svg.text(label, &plain([area.left - TICK[1], *y], Anchor::End));
        }
        self.labels(svg);
        self.legend(svg);
    }

    /// The map behind the curves, with its bar of colours.
    #[cfg(feature = "sweep")]
    fn map(&self, svg: &mut Svg) {
        use crate::figure::map;
        let Some(shown) = &self.panel.map else { return };
        let [[left, right], [below, above]] = shown.edges;
        let (left, right) = (self.across(left), self.across(right));
        let (top, bottom) = (self.down(above), self.down(below));
        let place = Area {
            left,
            top,
            width: right - left,
            height: bottom - top,
        };
        let [across, up] = shown.cells.map(|count| count as f64);
        svg.clipped(&self.area, |svg| {
            svg.picture(
                &place,
                &shown.picture(),
                across < place.width && up < place.height,
            );
        });
        let [space, width, beside] = COLOUR_BAR;
        let bar = Area {
            left: self.area.right() + space,
            width,
            ..self.area
        };
        svg.picture(&bar, &map::bar(), true);
        svg.rectangle(&bar, "none", AXES_COLOUR);
        let (scale, range) = map::scale(shown);
        for (tick, label) in scale.ticks(range) {
            let y = bar.bottom() - bar.height * scale.place(tick, range);
            svg.polyline(
                [[bar.right(), y], [bar.right() + TICK[0], y]],
                AXES_COLOUR,
                1.0,
                None,
            );
            svg.text(&label, &plain([bar.right() + TICK[1], y], Anchor::Start));
        }
        let lettering = Lettering {
            at: [bar.right() + beside, bar.top + bar.height / 2.0],
            anchor: Anchor::Middle,
            size: TEXT_SIZES[0],
            upright: true,
            colour: AXES_COLOUR,
        };
        svg.text(&shown.colours.label, &lettering);
    }

    /// The positions of an axis's ticks, with their labels.
    fn ticks(&self, axis: usize, place: impl Fn(f64) -> f64) -> Vec<(f64, String)> {
        let scale = [self.panel.x.scale, self.panel.y.scale][axis];
        let ticks = scale.ticks(self.ranges[axis]).into_iter();
        ticks.map(|(tick, label)| (place(tick), label)).collect()
    }

    /// The labels of the axes.
    fn labels(&self, svg: &mut Svg) {
        let area = &self.area;
        let lettering = |at, upright| Lettering {
            at,
            anchor: Anchor::Middle,
            size: TEXT_SIZES[0],
            upright,
            colour: AXES_COLOUR,
        };
        let middle = [area.left + area.width / 2.0, area.top + area.height / 2.0];
        if !self.panel.x.label.is_empty() {
            let below = area.bottom() + BOTTOM_MARGIN + LABEL_HEIGHT / 2.0;
            svg.text(&self.panel.x.label, &lettering([middle[0], below], false));
        }
        if !self.panel.y.label.is_empty() {
            let beside = area.left - self.left + UPRIGHT_LABEL / 2.0;
            svg.text(&self.panel.y.label, &lettering([beside, middle[1]], true));
        }
    }

    /// A curve.
    fn curve(&self, svg: &mut Svg, curve: &Curve) {
        let shown = |point: &&[f64; 2]| self.panel.x.shows(point[0]) && self.panel.y.shows(point[1]);
        let points = curve.points.iter().filter(shown);
        let points: Vec<_> = points.map(|&[x, y]| [self.across(x), self.down(y)]).collect();
        if let (&[only], Style::Line(width) | Style::Dashed(width)) = (points.as_slice(), curve.style) {
            // a line through one point would not be visible
            return svg.disc(only, width.max(LEAST_RADIUS), curve.colour);
        }
        match curve.style {
            Style::Line(width) => {
                for part in parts(points) {
                    match part {
                        LinePart::Line(points) => svg.polyline(points, curve.colour, width, None),
                        LinePart::Band(outline) => svg.band(outline, curve.colour, width),
                    }
                }
            }
            Style::Dashed(width) => svg.polyline(points, curve.colour, width, Some(DASHES)),
            Style::Discs(size) => points.into_iter().for_each(|at| svg.disc(at, size, curve.colour)),
            Style::Squares(size) => points
                .into_iter()
                .for_each(|at| square(svg, at, size, curve.colour)),
        }
    }
}

/// The least radius of a curve of one point, in pixels.
const LEAST_RADIUS: f64 = 3.0;

/// The dashes of a dashed line, and the spaces between them, in pixels.
const DASHES: &str = "8 4";

/// The style of ticks' labels and of the legend.
fn plain(at: [f64; 2], anchor: Anchor) -> Lettering {
    Lettering {
        at,
        anchor,
        size: TEXT_SIZES[1],
        upright: false,
        colour: AXES_COLOUR,
    }
}

/// A square about a point, with this half side.
fn square(svg: &mut Svg, [x, y]: [f64; 2], half: f64, colour: &str) {
    let area = Area {
        left: x - half,
        top: y - half,
        width: 2.0 * half,
        height: 2.0 * half,
    };
    svg.rectangle(&area, colour, "none");
}

/// The ranges, one of them enlarged about its middle so that a unit has the same length on both axes.
fn of_equal_aspect([x, y]: [(f64, f64); 2], area: &Area) -> [(f64, f64); 2] {
    let unit = (area.width / (x.1 - x.0)).min(area.height / (y.1 - y.0));
    let enlarged = |(from, to): (f64, f64), length: f64| {
        let (middle, half) = (f64::midpoint(from, to), length / (2.0 * unit));
        (middle - half, middle + half)
    };
    [enlarged(x, area.width), enlarged(y, area.height)]
}

#[cfg(test)]
mod tests;
