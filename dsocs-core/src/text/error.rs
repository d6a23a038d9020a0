//! The errors of a text.

use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use annotate_snippets::{AnnotationKind, Level, Renderer, Snippet};
use dsocs_language::{MOST_BYTES, Mistake};
use thiserror::Error;

use crate::samples::plainly;
use crate::step::TapeError;

/// The reason why a text is no system.
#[derive(Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum TextError {
    /// The text has mistakes.
    #[error("{shown}")]
    Mistakes {
        /// All mistakes, in the order of the text.
        mistakes: Vec<Mistake>,
        /// The lines of the text, with the place of each mistake underlined.
        shown: String,
        /// The text.
        text: String,
        /// The files of samples that it names, if these are the cause.
        files: Vec<String>,
    },
    /// A file cannot be read.
    #[error("cannot read {}: {cause}", .file.display())]
    File {
        /// The file.
        file: PathBuf,
        /// The reason.
        cause: String,
    },
    /// A file is no text.
    #[error("{} {reason}", .file.display())]
    Encoding {
        /// The file.
        file: PathBuf,
        /// The encoding of the file, and advice.
        reason: String,
    },
    /// The tape of the declaration does not fit its shape: a mistake of this library.
    #[error("the declaration makes no system, which is a mistake of this library: {0}")]
    Tape(TapeError),
    /// The front end failed on the text: a mistake of this library.
    #[error("the text could not be read, which is a mistake of this library, not of the text")]
    Panic,
    /// The system refused a thread for reading the text.
    #[error("no thread to read the text on: {0}")]
    Thread(String),
}

crate::debug_is_message!(TextError);

impl TextError {
    /// The mistakes of a text.
    pub(super) fn mistakes(name: &str, text: &str, mistakes: Vec<Mistake>) -> Self {
        Self::Mistakes {
            shown: shown(name, text, &mistakes, &Kind::Error).join("\n\n"),
            mistakes,
            text: text.to_owned(),
            files: Vec::new(),
        }
    }

    /// The error with the files of samples that are its cause.
    pub(super) fn with_files(self, named: Vec<String>) -> Self {
        match self {
            Self::Mistakes {
                mistakes,
                shown,
                text,
                ..
            } => Self::Mistakes {
                mistakes,
                shown,
                text,
                files: named,
            },
            other => other,
        }
    }

    /// The error with the name of the file, which is shown above its lines.
    #[must_use]
    pub fn in_file(self, file: &Path) -> Self {
        match self {
            Self::Mistakes {
                mistakes,
                text,
                files,
                ..
            } => Self::mistakes(&file.display().to_string(), &text, mistakes).with_files(files),
            other => other,
        }
    }
}

/// The kind of the messages.
pub(super) enum Kind {
    /// Errors. The caller labels the first one as an error when it prints them.
    Error,
    /// Warnings.
    Warning,
}

/// Largest number of places that are shown for one mistake.
const PLACES: usize = 10;

/// Mistakes with the lines of the text. Mistakes with the same message are shown together.
pub(super) fn shown(name: &str, text: &str, mistakes: &[Mistake], kind: &Kind) -> Vec<String> {
    let lines: Vec<usize> = core::iter::once(0)
        .chain(text.match_indices('\n').map(|(at, _)| at + 1))
        .collect();
    // the byte of a column, which is counted in characters
    let place = |line: usize, column: usize| {
        let from = line
            .checked_sub(1)
            .and_then(|line| lines.get(line))
            .copied()
            .unwrap_or(0);
        let rest = text.get(from..).unwrap_or_default();
        let places = rest.char_indices().map(|(at, _)| at).chain([rest.len()]);
        from + places.take(column.max(1)).last().unwrap_or(0)
    };
    let range = |mistake: &Mistake| {
        let from = place(mistake.line, mistake.column);
        let to = place(mistake.end_line, mistake.end_column).max(from);
        // of a long part the first line is shown
        let first_line = text.get(from..to).and_then(|part| part.find('\n'));
        from..first_line.map_or(to, |at| from + at)
    };
    let mut messages: Vec<(&str, Vec<&Mistake>)> = Vec::new();
    for mistake in mistakes {
        match messages
            .iter_mut()
            .find(|(message, _)| *message == mistake.message)
        {
            Some((_, places)) => places.push(mistake),
            None => messages.push((&mistake.message, vec![mistake])),
        }
    }
    let renderer = Renderer::plain();
    let told = messages.iter().enumerate().map(|(count, (message, places))| {
        let places = places.iter().take(PLACES).map(|mistake| range(mistake));
        let snippet = Snippet::source(text)
            .path(name)
            .annotations(places.map(|range| AnnotationKind::Primary.span(range)));
        let level = match kind {
            Kind::Error if count == 0 => Level::ERROR.no_name(),
            Kind::Error => Level::ERROR,
            Kind::Warning => Level::WARNING,
        };
        let title = level.primary_title(*message);
        renderer.render(&[title.element(snippet)])
    });
    told.collect()
}

/// Decodes the bytes of a text.
pub(super) fn decoded(file: &Path, bytes: Vec<u8>) -> Result<String, TextError> {
    let refused = |reason: String| TextError::Encoding {
        file: file.to_owned(),
        reason,
    };
    if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
        return Err(refused("is saved as UTF-16; save the file as UTF-8".to_owned()));
    }
    let text = String::from_utf8(bytes).map_err(|error| {
        let good = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        let line = String::from_utf8_lossy(good).matches('\n').count() + 1;
        refused(format!(
            "is no text in UTF-8: line {line} has a character in another encoding; save the file as UTF-8"
        ))
    })?;
    // a byte order mark, as some editors write it
    Ok(match text.strip_prefix('\u{feff}') {
        Some(text) => text.to_owned(),
        None => text,
    })
}

/// The bytes of a regular file that is not too long.
pub(super) fn bytes(file: &Path) -> Result<Vec<u8>, TextError> {
    let refused = |cause: String| TextError::File {
        file: file.to_owned(),
        cause,
    };
    let metadata = std::fs::metadata(file).map_err(|error| refused(plainly(&error)))?;
    if metadata.is_dir() {
        return Err(refused("it is a folder".to_owned()));
    }
    if !metadata.is_file() {
        return Err(refused("it is no file, but a device or a pipe".to_owned()));
    }
    let opened = File::open(file).map_err(|error| refused(plainly(&error)))?;
    let mut bytes = Vec::new();
    let most = 64 * MOST_BYTES as u64;
    let read = opened.take(most + 1).read_to_end(&mut bytes);
    read.map_err(|error| refused(plainly(&error)))?;
    if bytes.len() as u64 > most {
        return Err(refused(format!("it has more than {most} bytes")));
    }
    Ok(bytes)
}
