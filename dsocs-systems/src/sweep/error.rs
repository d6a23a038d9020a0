//! Why a sweep does not begin or go on.

use std::fmt::Display;
use std::io;
use std::path::{Path, PathBuf};

use parquet::errors::ParquetError;
use thiserror::Error;

use crate::entry::UnknownName;

/// A sweep does not begin or go on. A point that fails is none of these: it is a row of the table.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SweepError {
    /// A plan is not TOML.
    #[error("the plan cannot be read: {0}")]
    Syntax(String),
    /// A plan asks for what makes no sense.
    #[error("{at}: {reason}")]
    Plan {
        /// Where in the plan.
        at: String,
        /// What is wrong, and what was expected.
        reason: String,
    },
    /// A plan names what there is not.
    #[error("{at}: {unknown}")]
    Unknown {
        /// Where in the plan.
        at: String,
        /// The name, and those that there are.
        unknown: UnknownName,
    },
    /// A plan does not say which of several systems is meant.
    #[error("system: which one? known: {}", .known.join(", "))]
    Which {
        /// The systems.
        known: Vec<String>,
    },
    /// There is no such shard.
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
    /// There is no sweep in a folder.
    #[error("{} holds no sweep: it has no manifest.json", .0.display())]
    NoSweep(PathBuf),
    /// A file cannot be read.
    #[error("cannot read {}: {cause}", .path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why not.
        cause: String,
    },
    /// A file cannot be written. Parts that are there stay as they are.
    #[error("cannot write {}: {cause}; what was finished before is whole, and the same command goes on from there", .path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Why not.
        cause: io::Error,
    },
    /// A thread of the sweep has ended without a result.
    #[error("a thread of the sweep panicked: {0}")]
    Panicked(String),
}

impl SweepError {
    /// Something is wrong at a place of a plan.
    pub(super) fn plan(at: &str, reason: &str) -> Self {
        Self::Plan {
            at: at.to_owned(),
            reason: reason.to_owned(),
        }
    }

    /// A name at a place of a plan that there is not.
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

    /// Whether what is wrong is what was asked for, not what happened.
    #[must_use]
    pub fn is_a_question(&self) -> bool {
        !matches!(self, Self::Read { .. } | Self::Write { .. } | Self::Panicked(_))
    }
}
