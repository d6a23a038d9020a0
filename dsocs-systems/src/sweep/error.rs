//! The errors that keep a sweep from beginning or from going on.

use std::fmt::Display;
use std::io;
use std::path::{Path, PathBuf};

use parquet::errors::ParquetError;
use thiserror::Error;

use crate::entry::UnknownName;

/// A sweep cannot begin or go on. A point that fails is not such an error: the table has a row with the
/// reason.
#[derive(Error)]
#[non_exhaustive]
pub enum SweepError {
    /// The plan is not valid TOML.
    #[error("the plan cannot be read: {0}")]
    Syntax(String),
    /// Something in the plan makes no sense.
    #[error("{at}: {reason}")]
    Plan {
        /// Where in the plan.
        at: String,
        /// The mistake, and what was expected.
        reason: String,
    },
    /// The plan uses an unknown name.
    #[error("{at}: {unknown}")]
    Unknown {
        /// Where in the plan.
        at: String,
        /// The name, and the known ones.
        unknown: UnknownName,
    },
    /// The plan does not name one of several systems.
    #[error("system: which one? known: {}", .known.join(", "))]
    TableKind {
        /// The systems.
        known: Vec<String>,
    },
    /// The shard does not exist, or cannot be determined.
    #[error("{0}")]
    Shard(String),
    /// The folder holds the sweep of another plan.
    #[error(
        "{} holds another sweep: {difference}; give another folder, or the plan that began this one (it stands in its manifest.json)",
        .folder.display()
    )]
    Another {
        /// The folder.
        folder: PathBuf,
        /// The first difference.
        difference: String,
    },
    /// The folder contains no sweep.
    #[error("{} holds no sweep: it has no manifest.json", .0.display())]
    NoSweep(PathBuf),
    /// A table or a folder does not contain the text of its system.
    #[error("{} has no text of its system, which is more than a text can say, or is of an earlier version", .0.display())]
    NoText(PathBuf),
    /// A file cannot be read.
    #[error("cannot read {}: {cause}", .path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The reason.
        cause: String,
    },
    /// A file cannot be written. Finished parts stay as they are.
    #[error("cannot write {}: {cause}; what was finished before is whole, and the same command goes on from there", .path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The reason.
        cause: io::Error,
    },
    /// A thread of the sweep ended without a result.
    #[error("a thread of the sweep panicked: {0}")]
    Panicked(String),
}

dsocs_core::debug_is_message!(SweepError);

impl SweepError {
    /// A mistake at a place of a plan.
    pub(super) fn plan(at: &str, reason: &str) -> Self {
        Self::Plan {
            at: at.to_owned(),
            reason: reason.to_owned(),
        }
    }

    /// An unknown name at a place of a plan.
    pub(super) fn unknown(at: &str, unknown: UnknownName) -> Self {
        Self::Unknown {
            at: at.to_owned(),
            unknown,
        }
    }

    /// A file that cannot be read.
    pub(super) fn read(path: &Path, cause: impl Display) -> Self {
        Self::Read {
            path: path.to_owned(),
            cause: cause.to_string(),
        }
    }

    /// A file that cannot be written.
    pub(super) fn write(path: &Path, cause: io::Error) -> Self {
        Self::Write {
            path: path.to_owned(),
            cause,
        }
    }

    /// A table that cannot be written.
    pub(super) fn table(path: &Path, cause: ParquetError) -> Self {
        let cause = match cause {
            ParquetError::External(cause) => match cause.downcast::<io::Error>() {
                Ok(cause) => *cause,
                Err(cause) => io::Error::other(cause),
            },
            other => io::Error::other(other),
        };
        Self::write(path, cause)
    }

    /// Whether the request is wrong, and not something that happened during the sweep.
    #[must_use]
    pub fn is_wrong_request(&self) -> bool {
        !matches!(self, Self::Read { .. } | Self::Write { .. } | Self::Panicked(_))
    }
}
