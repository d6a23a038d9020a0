//! Files that appear when they are complete.

pub mod destination;
pub mod interrupt;
pub mod number;
pub mod progress;
pub mod table;
pub mod terminal;

use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::Once;

use tempfile::NamedTempFile;

use crate::cli::CliError;
use crate::cli::output::terminal::tell;
use crate::temporary::temporary;

/// A file in the making. It is written beside its target and takes the target's name at the end, so that a target never
/// holds half a file.
pub struct OutputFile {
    /// The target.
    path: PathBuf,
    /// The file that is written meanwhile.
    place: Place,
}

/// The file that is written until the target is complete.
enum Place {
    /// To a temporary file, which takes the target's name at the end.
    Beside(BufWriter<NamedTempFile>),
    /// To the target, a device or pipe that must not be replaced.
    Itself(BufWriter<fs::File>),
}

impl OutputFile {
    /// Creates the file, and the folders above it.
    ///
    /// # Errors
    ///
    /// [`CliError::Write`] if the file cannot be written there.
    pub fn create(path: &Path) -> Result<Self, CliError> {
        let failed = |cause| CliError::Write {
            path: path.to_owned(),
            cause,
        };
        // a link is followed, not replaced
        let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        let place = match fs::metadata(&target) {
            Ok(existing) if existing.is_dir() => return Err(failed(io::ErrorKind::IsADirectory.into())),
            Ok(existing) if !existing.is_file() => Place::Itself(BufWriter::new(
                fs::File::options().write(true).open(&target).map_err(failed)?,
            )),
            _ => {
                let folder = match target.parent() {
                    Some(folder) if !folder.as_os_str().is_empty() => folder,
                    _ => Path::new("."),
                };
                fs::create_dir_all(folder).map_err(failed)?;
                // only before the first file of this process, whose own temporary files are not to be
                // reported
                LEFTOVERS_REPORTED.call_once(|| report_leftovers(folder));
                Place::Beside(BufWriter::new(temporary(folder, TEMPORARY_NAME).map_err(failed)?))
            }
        };
        Ok(Self { path: target, place })
    }

    /// Completes the file.
    ///
    /// # Errors
    ///
    /// [`CliError::Write`] if the last of it cannot be written or it cannot take its name.
    pub fn finish(self) -> Result<(), CliError> {
        let Self { path, place } = self;
        let result = match place {
            Place::Itself(mut file) => file.flush(),
            Place::Beside(file) => file
                .into_inner()
                .map_err(io::IntoInnerError::into_error)
                .and_then(|file| file.persist(&path).map(drop).map_err(|error| error.error)),
        };
        result.map_err(|cause| CliError::Write { path, cause })
    }

    /// Writes the content, and puts the file in its place.
    ///
    /// # Errors
    ///
    /// [`CliError::Write`] if it cannot be written.
    pub fn complete(mut self, content: &[u8]) -> Result<(), CliError> {
        match self.write_all(content) {
            Ok(()) => self.finish(),
            Err(cause) => Err(self.failed(cause)),
        }
    }

    /// The target.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// An error of writing this file.
    pub fn failed(&self, cause: io::Error) -> CliError {
        CliError::Write {
            path: self.path.clone(),
            cause,
        }
    }
}

impl Write for OutputFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match &mut self.place {
            Place::Beside(file) => file.write(bytes),
            Place::Itself(file) => file.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match &mut self.place {
            Place::Beside(file) => file.flush(),
            Place::Itself(file) => file.flush(),
        }
    }
}

/// The prefix and the suffix of a temporary file's name.
const TEMPORARY_NAME: [&str; 2] = [".dsocs-", ".part"];

/// Whether temporary files of other runs have been looked for.
static LEFTOVERS_REPORTED: Once = Once::new();

/// Reports temporary files that are there already: a run that was killed could not remove its own.
fn report_leftovers(folder: &Path) {
    let Ok(entries) = fs::read_dir(folder) else {
        return;
    };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        if name.starts_with(TEMPORARY_NAME[0]) && name.ends_with(TEMPORARY_NAME[1]) {
            tell(format_args!(
                "note: {} is half a file, of a run that was killed or is still going; unless a run is going there, it can be deleted",
                entry.path().display()
            ));
        }
    }
}

/// Writes a whole file.
///
/// # Errors
///
/// [`CliError::Write`] if it cannot be written.
pub fn write(path: &Path, content: &[u8]) -> Result<(), CliError> {
    OutputFile::create(path)?.complete(content)
}

/// Makes a folder and tests whether files can be written to it.
///
/// # Errors
///
/// [`CliError::Write`] if they cannot.
pub fn check_folder(folder: &Path) -> Result<(), CliError> {
    fs::create_dir_all(folder)
        .and_then(|()| temporary(folder, TEMPORARY_NAME)?.write_all(b"test"))
        .map_err(|cause| CliError::Write {
            path: folder.to_owned(),
            cause,
        })
}
