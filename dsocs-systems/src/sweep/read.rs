//! Reads the folder of a sweep: its missing parts, and the content of its tables.

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::Value;

use super::error::SweepError;
use super::folder::{Folder, TableKind};
use super::table::{self, Cells};
use crate::entry::UnknownName;

/// The progress of a sweep.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Status {
    /// The number of points of the sweep.
    pub points: u64,
    /// The number of parts.
    pub parts: u64,
    /// The missing parts, in order.
    pub missing: Vec<u64>,
    /// The number of failed points in the existing parts, by the code of the failure.
    pub failed: BTreeMap<String, u64>,
}

/// Reads the progress of the sweep in a folder.
///
/// # Errors
///
/// [`SweepError`] if there is no sweep, or it cannot be read.
pub fn status(folder: &Path) -> Result<Status, SweepError> {
    let content = Content::open(folder)?;
    let mut failed = BTreeMap::new();
    for &part in &content.there {
        let path = content.folder.part(TableKind::Points, part);
        let cells = table::read(&path, &["error"]).map_err(|cause| SweepError::read(&path, cause))?;
        for cells in cells {
            if let Cells::Text(errors) = cells {
                for error in errors.into_iter().flatten() {
                    *failed.entry(error).or_default() += 1;
                }
            }
        }
    }
    Ok(Status {
        points: content.points,
        parts: content.parts,
        missing: (0..content.parts)
            .filter(|part| content.there.binary_search(part).is_err())
            .collect(),
        failed,
    })
}

/// The text of the system that was run, from the folder of a sweep or from one of its Parquet files.
///
/// The text may come from an untrusted source. [`Text::parse`](dsocs_core::text::Text::parse) uses only the
/// declaration in it, and opens none of the files that it names.
///
/// # Errors
///
/// [`SweepError`] if there is none, or it cannot be read.
pub fn text(path: &Path) -> Result<String, SweepError> {
    let text = if path.is_dir() {
        let manifest = Folder::new(path).manifest()?;
        let manifest = manifest.ok_or_else(|| SweepError::NoSweep(path.to_owned()))?;
        manifest["text"].as_str().map(str::to_owned)
    } else {
        table::text(path).map_err(|cause| SweepError::read(path, cause))?
    };
    text.ok_or_else(|| SweepError::NoText(path.to_owned()))
}

/// The content of the sweep in a folder, as far as it is computed.
#[derive(Clone, Debug)]
pub struct Content {
    /// The folder.
    folder: Folder,
    /// The number of points of the sweep.
    points: u64,
    /// The number of parts.
    parts: u64,
    /// The existing parts, in order.
    there: Vec<u64>,
    /// The quantities that vary.
    axes: Vec<Axis>,
    /// Whether points lie on a grid.
    grid: bool,
    /// The columns of the table of points.
    columns: Vec<String>,
    /// The manifest.
    manifest: Value,
}

/// A quantity that varies.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Its name, which is also the name of its column.
    pub name: String,
    /// Its unit, as far as it is known.
    pub unit: Option<String>,
    /// Whether its values are a geometric progression.
    pub logarithmic: bool,
    /// The number of its values on a grid.
    pub count: Option<u64>,
}

impl Content {
    /// Reads the manifest of a folder and finds the existing parts.
    ///
    /// # Errors
    ///
    /// [`SweepError`] if there is no sweep, or if it has another format than that of this version.
    pub fn open(path: &Path) -> Result<Self, SweepError> {
        let folder = Folder::new(path);
        let Some(manifest) = folder.manifest()? else {
            return Err(SweepError::NoSweep(path.to_owned()));
        };
        let read = || -> Option<Self> {
            let tables: Vec<TableKind> = manifest["tables"]
                .as_array()?
                .iter()
                .map(|name| match name.as_str() {
                    Some("nodes") => TableKind::Nodes,
                    _ => TableKind::Points,
                })
                .collect();
            let parts = manifest["parts"].as_u64()?;
            let axes = manifest["plan"]["vary"].as_array()?.iter().map(|axis| {
                let values = &axis["values"];
                Some(Axis {
                    name: axis["name"].as_str()?.to_owned(),
                    unit: axis["unit"].as_str().map(str::to_owned),
                    logarithmic: values["scale"] == "logarithmic",
                    count: match values["list"].as_array() {
                        Some(list) => Some(list.len() as u64),
                        None => values["count"].as_u64(),
                    },
                })
            });
            let texts = |value: &Value| -> Option<Vec<String>> {
                let texts = value.as_array()?.iter();
                texts.map(|text| text.as_str().map(str::to_owned)).collect()
            };
            Some(Self {
                points: manifest["points"].as_u64()?,
                parts,
                there: (0..parts).filter(|&part| folder.has(&tables, part)).collect(),
                axes: axes.collect::<Option<_>>()?,
                grid: manifest["plan"]["sample"].is_null(),
                columns: texts(&manifest["columns"])?,
                manifest: manifest.clone(),
                folder: folder.clone(),
            })
        };
        read().ok_or_else(|| SweepError::read(&folder.manifest_path(), "it is none that this version writes"))
    }

    /// The quantities that vary, in the order of the plan.
    #[must_use]
    pub fn axes(&self) -> &[Axis] {
        &self.axes
    }

    /// Whether points lie on a grid.
    #[must_use]
    pub fn is_grid(&self) -> bool {
        self.grid
    }

    /// The columns of the table of points.
    #[must_use]
    pub fn columns(&self) -> &[String] {
        &self.columns
    }

    /// The number of parts of the sweep, and the number of those that exist.
    #[must_use]
    pub fn parts(&self) -> (u64, u64) {
        (self.parts, self.there.len() as u64)
    }

    /// The system's name.
    #[must_use]
    pub fn system(&self) -> &str {
        self.manifest["plan"]["system"].as_str().unwrap_or_default()
    }

    /// The unit of a column, as far as it is known.
    #[must_use]
    pub fn unit(&self, column: &str) -> Option<&str> {
        if let Some(axis) = self.axes.iter().find(|axis| axis.name == column) {
            return axis.unit.as_deref();
        }
        let keep = &self.manifest["plan"]["keep"];
        let (of, name) = column.split_once('_')?;
        match of {
            "end" => keep["end"][name].as_str(),
            "least" | "greatest" => keep["extremes"][name].as_str(),
            "first" | "last" => Some("s"),
            _ => None,
        }
    }

    /// Columns of numbers of the table of points, over all existing parts. A null becomes NaN. All numbers of points that failed are NaN, too.
    ///
    /// # Errors
    ///
    /// [`SweepError`] if a column does not exist or has no numbers, or if a part cannot be read.
    pub fn numbers(&self, names: &[&str]) -> Result<Vec<Vec<f64>>, SweepError> {
        for name in names {
            if !self.columns.iter().any(|known| known == name) {
                return Err(SweepError::unknown(
                    &self.folder.path().display().to_string(),
                    UnknownName::new("column", name, self.columns.iter().cloned()),
                ));
            }
        }
        let mut all = vec![Vec::new(); names.len()];
        let with_error: Vec<&str> = names.iter().copied().chain(["error"]).collect();
        for &part in &self.there {
            let path = self.folder.part(TableKind::Points, part);
            let cells = table::read(&path, &with_error).map_err(|cause| SweepError::read(&path, cause))?;
            let failed: Vec<bool> = match cells.last() {
                Some(Cells::Text(errors)) => errors.iter().map(Option::is_some).collect(),
                _ => Vec::new(),
            };
            for ((all, cells), name) in all.iter_mut().zip(cells).zip(names) {
                let varies = self.axes.iter().any(|axis| axis.name == **name);
                let value = |(place, value): (usize, f64)| {
                    if !varies && failed.get(place) == Some(&true) {
                        f64::NAN
                    } else {
                        value
                    }
                };
                match cells {
                    Cells::Number(cells) => all.extend(cells.into_iter().enumerate().map(value)),
                    #[allow(clippy::cast_precision_loss)]
                    Cells::Whole(cells) => {
                        all.extend(cells.into_iter().map(|cell| cell as f64).enumerate().map(value));
                    }
                    Cells::Text(_) => {
                        return Err(SweepError::plan(
                            name,
                            "it is a column of texts; expected one of numbers",
                        ));
                    }
                }
            }
        }
        Ok(all)
    }
}
