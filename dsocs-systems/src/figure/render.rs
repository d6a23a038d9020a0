//! From drawn text and lines to files that look alike everywhere.

use std::path::Path;
use std::sync::Arc;

use resvg::tiny_skia::{Color, Pixmap, Transform};
use resvg::usvg::{self, Options, Tree, WriteOptions};
use thiserror::Error;

/// The family of the embedded font.
pub(super) const FONT: &str = "DejaVu Sans";

/// How many pixels of the PNG one pixel of the SVG becomes.
const PIXELS: f32 = 2.0;

/// Digits after the point of coordinates in the SVG: a hundredth of a pixel.
const DIGITS: u8 = 2;

/// A figure could not be drawn or written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum FigureError {
    /// The plotting crate's SVG cannot be read.
    #[error("the drawing is not valid SVG: {0}")]
    Svg(#[from] usvg::Error),
    /// The picture has no size, or one too large for memory.
    #[error("a picture of {0} × {1} pixels cannot be made")]
    Size(u32, u32),
    /// The PNG cannot be encoded.
    #[error("the picture cannot be encoded: {0}")]
    Png(String),
    /// The file name says neither SVG nor PNG.
    #[error("`{0}` is no figure format: a figure's file name ends in .svg or .png")]
    Format(String),
}

/// The format of a figure's file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Scalable vector graphics.
    Svg,
    /// Portable network graphics, at twice the pixels.
    Png,
}

impl Format {
    /// The format that a file's name asks for.
    ///
    /// # Errors
    ///
    /// [`FigureError::Format`] for another ending than `.svg` and `.png`.
    pub fn of(path: &Path) -> Result<Self, FigureError> {
        let ending = path
            .extension()
            .map(|ending| ending.to_string_lossy().to_lowercase());
        match ending.as_deref() {
            Some("svg") => Ok(Self::Svg),
            Some("png") => Ok(Self::Png),
            _ => Err(FigureError::Format(path.display().to_string())),
        }
    }
}

/// A drawn figure, all of its text turned into outlines.
pub struct Rendered {
    /// The drawing.
    tree: Tree,
}

impl Rendered {
    /// Lays out the text of a drawing with the embedded font, and no other.
    pub(super) fn new(svg: &str) -> Result<Self, FigureError> {
        let mut fonts = usvg::fontdb::Database::new();
        fonts.load_font_data(dejavu::sans::regular().to_vec());
        fonts.load_font_data(dejavu::sans::bold().to_vec());
        fonts.set_sans_serif_family(FONT);
        fonts.set_serif_family(FONT);
        fonts.set_monospace_family(FONT);
        let options = Options {
            font_family: FONT.to_owned(),
            fontdb: Arc::new(fonts),
            ..Options::default()
        };
        Ok(Self {
            tree: Tree::from_str(svg, &options)?,
        })
    }

    /// The figure's file.
    ///
    /// # Errors
    ///
    /// [`FigureError`] if the picture cannot be encoded.
    pub fn encode(&self, format: Format) -> Result<Vec<u8>, FigureError> {
        match format {
            Format::Svg => Ok(self.svg().into_bytes()),
            Format::Png => self.png(),
        }
    }

    /// The figure as SVG without text elements.
    #[must_use]
    pub fn svg(&self) -> String {
        self.tree.to_string(&WriteOptions {
            coordinates_precision: DIGITS,
            transforms_precision: 6,
            ..WriteOptions::default()
        })
    }

    /// The figure as PNG.
    fn png(&self) -> Result<Vec<u8>, FigureError> {
        let size = self.tree.size().to_int_size();
        let size = size
            .scale_by(PIXELS)
            .ok_or(FigureError::Size(size.width(), size.height()))?;
        let mut pixels =
            Pixmap::new(size.width(), size.height()).ok_or(FigureError::Size(size.width(), size.height()))?;
        pixels.fill(Color::WHITE);
        resvg::render(
            &self.tree,
            Transform::from_scale(PIXELS, PIXELS),
            &mut pixels.as_mut(),
        );
        pixels
            .encode_png()
            .map_err(|error| FigureError::Png(error.to_string()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::{Axis, BLUE, Curve, Figure, Panel, Style};

    #[test]
    fn text_becomes_outlines() -> Result<(), FigureError> {
        let curve = Curve {
            points: vec![[0.0, 1.0], [1.0, f64::NAN], [2.0, 3.0]],
            style: Style::Line(1.0),
            colour: BLUE,
            label: Some("ψ = θ".to_owned()),
        };
        let panel = Panel {
            x: Axis::linear("t [s]"),
            y: Axis::logarithmic("θ [rad]"),
            curves: vec![curve],
            ..Panel::default()
        };
        let rendered = Figure {
            size: [400.0, 300.0],
            columns: 1,
            panels: vec![panel],
        }
        .draw()?;
        let svg = rendered.svg();
        assert!(!svg.contains("<text") && !svg.contains("font-family"));
        assert!(svg.matches("<path").count() > 10, "outlines of letters and ticks");
        assert!(rendered.encode(Format::Png)?.starts_with(b"\x89PNG"));
        Ok(())
    }
}
