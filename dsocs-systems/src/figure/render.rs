//! The file of a figure: its format and its content.

use std::path::Path;

use thiserror::Error;

use super::{Figure, draw};

/// A figure could not be made.
#[derive(Error)]
#[non_exhaustive]
pub enum FigureError {
    /// The file name ends neither in `.svg` nor in `.png`.
    #[error("`{0}` is no figure format: a figure's file name ends in .svg or .png")]
    Format(String),
    /// A PNG is asked of a program that was built without the feature `png`.
    #[error(
        "this program writes figures as SVG alone: choose a file name that ends in .svg, or add the feature `png` of \
         dsocs-systems in `Cargo.toml` (in a checkout of dsocs: `cargo run --release --features png -- …`)"
    )]
    NoPng,
    /// The PNG cannot be made.
    #[error("the picture cannot be made: {0}")]
    Png(String),
}

dsocs_core::debug_is_message!(FigureError);

/// The format of a figure's file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Scalable vector graphics.
    Svg,
    /// Portable network graphics, at twice the pixels. Written where the feature `png` is on.
    Png,
}

impl Format {
    /// The formats that this program writes.
    pub const WRITTEN: &[Self] = if cfg!(feature = "png") {
        &[Self::Svg, Self::Png]
    } else {
        &[Self::Svg]
    };

    /// The format that a file's name asks for.
    ///
    /// # Errors
    ///
    /// [`FigureError::Format`] for another ending than `.svg` and `.png`, [`FigureError::NoPng`] for a PNG without the feature
    /// `png`.
    pub fn of(path: &Path) -> Result<Self, FigureError> {
        let ending = path
            .extension()
            .map(|ending| ending.to_string_lossy().to_lowercase());
        match ending.as_deref() {
            Some("svg") => Ok(Self::Svg),
            Some("png") if Self::WRITTEN.contains(&Self::Png) => Ok(Self::Png),
            Some("png") => Err(FigureError::NoPng),
            _ => Err(FigureError::Format(path.display().to_string())),
        }
    }

    /// The ending of a file's name.
    #[must_use]
    pub fn ending(self) -> &'static str {
        match self {
            Self::Svg => "svg",
            Self::Png => "png",
        }
    }
}

impl Figure {
    /// The figure as SVG. Its text is text, in whatever sans-serif font the reader has.
    #[must_use]
    pub fn svg(&self) -> String {
        draw::svg(self)
    }

    /// The figure as an element of a page, with a unique name and a title for those who cannot see it. It is
    /// as wide as its container, and each pair of axes has its position in `data-area` and its ranges in
    /// `data-x` and `data-y`.
    #[must_use]
    pub fn on_page(&self, name: &str, title: &str) -> String {
        draw::on_page(self, name, title)
    }

    /// The figure's file.
    ///
    /// # Errors
    ///
    /// [`FigureError::Png`] if the picture cannot be made, [`FigureError::NoPng`] without the feature `png`.
    pub fn encode(&self, format: Format) -> Result<Vec<u8>, FigureError> {
        encode(self.svg(), format)
    }
}

/// The file of a picture in SVG.
///
/// # Errors
///
/// As [`Figure::encode`].
pub fn encode(svg: String, format: Format) -> Result<Vec<u8>, FigureError> {
    match format {
        Format::Svg => Ok(svg.into_bytes()),
        #[cfg(feature = "png")]
        Format::Png => super::png::png(&svg),
        #[cfg(not(feature = "png"))]
        Format::Png => Err(FigureError::NoPng),
    }
}
