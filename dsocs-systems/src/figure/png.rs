//! The conversion of SVG to pixels, with an embedded font: a picture looks the same on a machine without any
//! fonts.

use std::sync::Arc;

use resvg::tiny_skia::{Color, Pixmap, Transform};
use resvg::usvg::{self, Options, Tree};

use super::FigureError;

/// The family of the embedded font.
const FONT: &str = "DejaVu Sans";

/// The number of pixels of the PNG per pixel of the SVG, in each direction.
const PIXEL_RATIO: f32 = 2.0;

/// The SVG as PNG.
///
/// # Errors
///
/// [`FigureError::Png`] if the picture has no size, one too large for memory, or cannot be encoded.
pub(super) fn png(svg: &str) -> Result<Vec<u8>, FigureError> {
    let mut fonts = usvg::fontdb::Database::new();
    fonts.load_font_data(dejavu::sans::regular().to_vec());
    fonts.set_sans_serif_family(FONT);
    let options = Options {
        font_family: FONT.to_owned(),
        fontdb: Arc::new(fonts),
        ..Options::default()
    };
    let failed = |error: &dyn std::fmt::Display| FigureError::Png(error.to_string());
    let tree = Tree::from_str(svg, &options).map_err(|error| failed(&error))?;
    let size = tree.size().to_int_size();
    let none = || FigureError::Png(format!("{} × {} pixels", size.width(), size.height()));
    let size = size.scale_by(PIXEL_RATIO).ok_or_else(none)?;
    let mut pixels = Pixmap::new(size.width(), size.height()).ok_or_else(none)?;
    pixels.fill(Color::WHITE);
    resvg::render(
        &tree,
        Transform::from_scale(PIXEL_RATIO, PIXEL_RATIO),
        &mut pixels.as_mut(),
    );
    pixels.encode_png().map_err(|error| failed(&error))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::{Axis, Figure, Format, Panel};

    /// The picture of a figure with this label.
    fn picture(label: &str) -> Result<Vec<u8>, FigureError> {
        let panel = Panel {
            x: Axis::linear(label),
            ..Panel::default()
        };
        let figure = Figure {
            size: [300.0, 200.0],
            columns: 1,
            panels: vec![panel],
        };
        figure.encode(Format::Png)
    }

    #[test]
    fn text_is_drawn_without_fonts_of_the_machine() -> Result<(), FigureError> {
        let (with, without) = (picture("ψ = θ")?, picture("")?);
        assert!(with.starts_with(b"\x89PNG"));
        assert_ne!(with, without, "the label is seen");
        Ok(())
    }
}
