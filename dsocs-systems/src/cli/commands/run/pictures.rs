//! The figure, the picture and the page of a run.

use serde_json::{Map, Value};

use super::{RunArguments, chosen_columns};
use crate::cli::figures::picture::Picture;
use crate::cli::figures::plot::Plot;
use crate::cli::output::OutputFile;
use crate::cli::page::motion::MotionPage;
use crate::cli::{CliError, page};
use crate::entry::{Column, Entry};

/// The figure, the picture and the page of a run.
pub(super) struct Pictures {
    /// The figure.
    plot: Option<Plot>,
    /// The picture of the mechanism.
    picture: Option<Picture>,
    /// The page and its file.
    report: Option<(OutputFile, MotionPage)>,
}

impl Pictures {
    /// Creates those that were asked for.
    pub(super) fn create(
        arguments: &RunArguments,
        entry: &mut Entry,
        all: &[Column],
        chosen: &[usize],
    ) -> Result<Self, CliError> {
        let plot = match &arguments.plot {
            Some(path) => {
                let coordinates = 1..=entry.description().coordinates.len();
                let shown = match arguments.columns {
                    Some(_) => chosen.to_vec(),
                    None => coordinates.collect(),
                };
                let path_of = path_of(arguments.path.as_deref(), all)?;
                Some(Plot::create(path, all, &shown, path_of)?)
            }
            None => None,
        };
        let picture = match &arguments.picture {
            Some(path) => Some(Picture::create(path, entry, all)?),
            None => None,
        };
        let report = match &arguments.report {
            // a path that cannot be written is found before the run
            Some(path) => {
                page::check_name(path)?;
                let file = OutputFile::create(path)?;
                let draw = entry.drawing();
                Some((file, MotionPage::new(all, entry.description(), draw)))
            }
            None => None,
        };
        Ok(Self {
            plot,
            picture,
            report,
        })
    }

    /// Whether any was asked for.
    pub(super) fn any(&self) -> bool {
        self.plot.is_some() || self.picture.is_some() || self.report.is_some()
    }

    /// Takes the number of a node and, if anything is asked for, the values of all columns there.
    #[inline]
    pub(super) fn push(&mut self, index: u64, values: &[f64]) {
        // most runs have none
        if self.plot.is_some() || self.picture.is_some() || self.report.is_some() {
            self.draw(index, values);
        }
    }

    /// Takes a node; out of line, because most runs have no pictures.
    #[inline(never)]
    fn draw(&mut self, index: u64, values: &[f64]) {
        if let Some(plot) = &mut self.plot {
            plot.push(index, values);
        }
        if let Some(picture) = &mut self.picture {
            picture.push(index, values);
        }
        if let Some((_, report)) = &mut self.report {
            report.push(index, values);
        }
    }

    /// Completes them.
    pub(super) fn finish(
        self,
        titles: [&str; 3],
        about: &Map<String, Value>,
        notes: &[String],
    ) -> Result<(), CliError> {
        self.plot.map_or(Ok(()), Plot::finish)?;
        self.picture.map_or(Ok(()), Picture::finish)?;
        let Some((file, report)) = self.report else {
            return Ok(());
        };
        let page = report.finish(titles, about, notes);
        file.complete(page.as_bytes())
    }
}

/// The numbers of the two columns of a path.
fn path_of(names: Option<&[String]>, all: &[Column]) -> Result<Option<[usize; 2]>, CliError> {
    let Some(names) = names else { return Ok(None) };
    let columns = chosen_columns(Some(names), all)?;
    let pair = columns
        .try_into()
        .map_err(|columns: Vec<usize>| CliError::Path { found: columns.len() })?;
    Ok(Some(pair))
}
