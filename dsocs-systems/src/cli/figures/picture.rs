//! The picture of `dsocs run --picture`: the mechanism at some moments.

use std::path::Path;

use crate::cli::CliError;
use crate::cli::output::OutputFile;
use crate::cli::page::motion::MotionPage;
use crate::entry::{Column, Entry};
use crate::figure::{Format, encode};

/// A picture in the making.
pub struct Picture {
    /// The file.
    file: OutputFile,
    /// Its format.
    format: Format,
    /// The moments kept of the run, and the drawing.
    motion: MotionPage,
    /// The title.
    title: String,
}

impl Picture {
    /// Begins the file, so that a place that cannot be written is found before the run.
    ///
    /// # Errors
    ///
    /// [`CliError`] if the name asks for no known format, the file cannot be written, or nothing says how the system is drawn.
    pub fn create(path: &Path, entry: &mut Entry, columns: &[Column]) -> Result<Self, CliError> {
        let format = Format::of(path)?;
        let draw = entry.drawing();
        let motion = MotionPage::new(columns, entry.description(), draw);
        if !motion.is_drawn() {
            return Err(CliError::NoPicture(entry.name().to_owned()));
        }
        Ok(Self {
            file: OutputFile::create(path)?,
            format,
            motion,
            title: format!("{}: {}", entry.name(), entry.summary()),
        })
    }

    /// Takes the number of a node and the values of all columns there.
    pub fn push(&mut self, index: u64, values: &[f64]) {
        self.motion.push(index, values);
    }

    /// Draws the picture and completes the file.
    ///
    /// # Errors
    ///
    /// [`CliError`] if the picture cannot be drawn or written.
    pub fn finish(self) -> Result<(), CliError> {
        let Self {
            file,
            format,
            motion,
            title,
        } = self;
        let picture = encode(motion.picture(&title).unwrap_or_default(), format)?;
        file.complete(&picture)
    }
}
