//! The destination of a run's rows: a file, standard output, or none.

use std::io::{self, BufWriter, Stdout, Write};
use std::path::Path;

use crate::cli::CliError;
use crate::cli::output::OutputFile;
use crate::cli::output::table::TableFormat;

/// The destination of rows.
pub enum Destination {
    /// To a file.
    File(OutputFile),
    /// To standard output.
    Stdout(BufWriter<Stdout>),
    /// Rows are dropped.
    Nowhere,
}

impl Destination {
    /// The destination that was asked for, and the format of the table. A file is created at once, so that a
    /// path that cannot be written is found before the run. Without a file rows go to standard output, unless
    /// no rows are wanted. A given format has precedence over that of the file's name.
    ///
    /// # Errors
    ///
    /// [`CliError`] if the file's name asks for no known format or it cannot be written.
    pub fn new(
        out: Option<&Path>,
        format: Option<TableFormat>,
        rows_wanted: bool,
    ) -> Result<(TableFormat, Self), CliError> {
        let on_stdout = format.unwrap_or(TableFormat::Csv);
        match out {
            Some(path) if path.as_os_str() != "-" => {
                let format = format.map_or_else(|| TableFormat::of(path), Ok)?;
                Ok((format, Self::File(OutputFile::create(path)?)))
            }
            None if !rows_wanted => Ok((on_stdout, Self::Nowhere)),
            _ => Ok((on_stdout, Self::Stdout(BufWriter::new(io::stdout())))),
        }
    }

    /// The file, if it is one.
    pub fn path(&self) -> Option<&Path> {
        match self {
            Self::File(file) => Some(file.path()),
            Self::Stdout(_) | Self::Nowhere => None,
        }
    }

    /// An error of writing, with this destination.
    pub fn failed(&self, error: io::Error) -> CliError {
        match self {
            Self::File(file) => file.failed(error),
            Self::Stdout(_) | Self::Nowhere => CliError::stdout(error),
        }
    }

    /// Completes what was written.
    ///
    /// # Errors
    ///
    /// [`CliError`] if the last of it cannot be written.
    pub fn finish(self) -> Result<(), CliError> {
        match self {
            Self::File(file) => file.finish(),
            Self::Stdout(mut stdout) => stdout.flush().map_err(CliError::stdout),
            Self::Nowhere => Ok(()),
        }
    }
}

impl Write for Destination {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self {
            Self::File(file) => file.write(bytes),
            Self::Stdout(stdout) => stdout.write(bytes),
            Self::Nowhere => Ok(bytes.len()),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match self {
            Self::File(file) => file.flush(),
            Self::Stdout(stdout) => stdout.flush(),
            Self::Nowhere => Ok(()),
        }
    }
}
