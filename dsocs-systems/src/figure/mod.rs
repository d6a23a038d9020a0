//! Figures: panels of curves with axes and legends, as SVG and, with the feature `png`, as PNG.
//!
//! A figure is plain data ([`Figure`], [`Panel`], [`Axis`], [`Curve`]). One file computes the layout, one
//! writes the elements of SVG, one converts them to pixels. Existing plotting crates are not used, because
//! they take longer to compile than everything else in the command line, or round to whole pixels.

mod axis;
mod band;
mod draw;
mod envelope;
#[cfg(feature = "sweep")]
mod map;
#[cfg(feature = "png")]
mod png;
mod render;
mod svg;

pub use axis::{Axis, Scale};
pub use envelope::Envelope;
#[cfg(feature = "sweep")]
pub use map::HeatMap;
pub use render::{FigureError, Format, encode};
pub(crate) use svg::escaped;

/// A colour-blind-safe blue (Okabe and Ito).
pub const BLUE: &str = "#0072B2";
/// A colour-blind-safe vermilion (Okabe and Ito).
pub const VERMILION: &str = "#D55E00";
/// A colour-blind-safe green (Okabe and Ito).
pub const GREEN: &str = "#009E73";
/// A colour-blind-safe purple (Okabe and Ito).
pub const PURPLE: &str = "#AA4499";

/// A figure: panels of one size, row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Width and height, in pixels.
    pub size: [f64; 2],
    /// The number of panels side by side.
    pub columns: usize,
    /// The panels, row by row.
    pub panels: Vec<Panel>,
}

/// One pair of axes with its curves.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Panel {
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// Colours behind the curves.
    #[cfg(feature = "sweep")]
    pub map: Option<HeatMap>,
    /// The curves, the first at the back. Points that are not finite are left out.
    pub curves: Vec<Curve>,
    /// The position of the curves' labels.
    pub legend: Legend,
    /// Whether one unit has the same length on both axes (linear axes only).
    pub equal_aspect: bool,
}

/// The position of the curves' labels in a panel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Legend {
    /// In the upper left corner.
    #[default]
    TopLeft,
    /// Beside the axes, on the right.
    Right,
    /// Each at the end of its curve, in its colour.
    Ends,
    /// With its upper left corner at this point of the data.
    At([f64; 2]),
}

/// A sequence of points.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// The points `[x, y]`.
    pub points: Vec<[f64; 2]>,
    /// The line or the marks.
    pub style: Style,
    /// The colour, as SVG writes it.
    pub colour: &'static str,
    /// The label in the legend.
    pub label: Option<String>,
}

/// The style of a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Style {
    /// Joined by a line of this width, in pixels.
    Line(f64),
    /// Joined by a dashed line of this width, in pixels.
    Dashed(f64),
    /// Discs of this radius, in pixels.
    Discs(f64),
    /// Squares of this half side, in pixels.
    Squares(f64),
}
