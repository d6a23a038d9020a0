//! What can be wrong with a text.

use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use annotate_snippets::{AnnotationKind, Level, Renderer, Snippet};
use dsocs_language::{MOST_BYTES, Mistake};
use thiserror::Error;

use crate::samples::SamplesError;
use crate::step::TapeError;

/// Why a text is no system.
#[derive(Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum TextError {
    /// The text has mistakes.
    #[error("{shown}")]
    Mistakes {
        /// All of them, in the order of the text.
        mistakes: Vec<Mistake>,
        /// Where they are: the lines of the text with the place of each underlined.
        shown: String,
        /// The text, to say where it stands.
        text: String,
    },
    /// A file cannot be read.
    #[error("cannot read {}: {cause}", .file.display())]
    File {
        /// The file.
        file: PathBuf,
        /// Why not.
        cause: String,
    },
    /// A file is no text.
    #[error("{} is no text: the byte after the first {at} is no UTF-8; expected the text of a declaration", .file.display())]
    Utf8 {
        /// The file.
        file: PathBuf,
        /// How many bytes are text.
        at: usize,
    },
    /// A text that is in no folder names a file.
    #[error(
        "the text names the file `{file}`, and has no folder in which it could be; expected a text in a file, `Text::read`"
    )]
    Files {
        /// The file.
        file: String,
    },
    /// The samples of a file cannot be used.
    #[error("the samples in `{file}` cannot be used: {cause}")]
    Samples {
        /// The file, as the text names it.
        file: String,
        /// Why not.
        cause: SamplesError,
    },
    /// The tape of the declaration does not fit its shape: a mistake of this library.
    #[error("the declaration makes no system, which is a mistake of this library: {0}")]
    Tape(TapeError),
    /// The front end failed on the text: a mistake of this library.
    #[error("the text could not be read, which is a mistake of this library, not of the text")]
    Panic,
    /// There is no room for a thread to read the text on.
    #[error("no thread to read the text on: {0}")]
    Thread(String),
}

crate::debug_is_message!(TextError);

impl TextError {
    /// The mistakes of a text.
    pub(super) fn mistakes(name: &str, text: &str, mistakes: Vec<Mistake>) -> Self {
        Self::Mistakes {
            shown: shown(name, text, &mistakes),
            mistakes,
            text: text.to_owned(),
        }
    }

    /// The same with the name of the file.
    pub(super) fn in_file(self, file: &Path) -> Self {
        match self {
            Self::Mistakes { mistakes, text, .. } => {
                Self::mistakes(&file.display().to_string(), &text, mistakes)
            }
            other => other,
        }
    }
}

/// The mistakes with the lines of the text.
fn shown(name: &str, text: &str, mistakes: &[Mistake]) -> String {
    let lines: Vec<usize> = core::iter::once(0)
        .chain(text.match_indices('\n').map(|(at, _)| at + 1))
        .collect();
    // the place of a column, which is counted in characters
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
    let renderer = Renderer::plain();
    let told = mistakes.iter().enumerate().map(|(count, mistake)| {
        let from = place(mistake.line, mistake.column);
        let to = place(mistake.end_line, mistake.end_column).max(from);
        // what is long is shown by its first line
        let first_line = text.get(from..to).and_then(|part| part.find('\n'));
        let to = first_line.map_or(to, |at| from + at);
        let snippet = Snippet::source(text)
            .path(name)
            .annotation(AnnotationKind::Primary.span(from..to));
        // whoever prints the error says of the first one that it is one
        let level = if count == 0 {
            Level::ERROR.no_name()
        } else {
            Level::ERROR
        };
        let title = level.primary_title(mistake.message.as_str());
        renderer.render(&[title.element(snippet)])
    });
    told.collect::<Vec<_>>().join("\n\n")
}

/// The bytes of a regular file that is not too long.
pub(super) fn bytes(file: &Path) -> Result<Vec<u8>, TextError> {
    let refused = |cause: String| TextError::File {
        file: file.to_owned(),
        cause,
    };
    let metadata = std::fs::metadata(file).map_err(|error| refused(error.to_string()))?;
    if !metadata.is_file() {
        return Err(refused("it is no file".to_owned()));
    }
    let opened = File::open(file).map_err(|error| refused(error.to_string()))?;
    let mut bytes = Vec::new();
    let most = 64 * MOST_BYTES as u64;
    let read = opened.take(most + 1).read_to_end(&mut bytes);
    read.map_err(|error| refused(error.to_string()))?;
    if bytes.len() as u64 > most {
        return Err(refused(format!("it has more than {most} bytes")));
    }
    Ok(bytes)
}
