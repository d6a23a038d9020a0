//! `--input NAME=FILE`: a parameter that is held from time to time.

use std::path::Path;

use clap::Args;

use super::CliError;
use crate::entry::{Entry, HeldInput, UnknownName};

/// Parameters that change during a run.
#[derive(Args, Debug)]
pub struct InputArguments {
    /// A parameter that changes at nodes: a .csv file with two columns, the time in s and the value that holds from the next node on; before the first time the parameter has its own value; may be given
    /// several times
    #[arg(long, value_name = "NAME=FILE", value_parser = assignment, conflicts_with = "certify")]
    input: Vec<(String, String)>,
}

/// Reads `name=file`.
fn assignment(text: &str) -> Result<(String, String), String> {
    let (name, file) = text.split_once('=').ok_or("expected NAME=FILE")?;
    Ok((name.trim().to_owned(), file.to_owned()))
}

impl InputArguments {
    /// The inputs of a system.
    ///
    /// # Errors
    ///
    /// [`CliError`] if there is no such parameter, or a file is no plan.
    pub fn read(&self, entry: &Entry) -> Result<Vec<HeldInput>, CliError> {
        self.input
            .iter()
            .map(|(name, file)| {
                let known: Vec<_> = entry
                    .description()
                    .parameters
                    .iter()
                    .map(|known| known.name.clone())
                    .collect();
                let Some(parameter) = known.iter().find(|known| *known == name) else {
                    return Err(UnknownName::new("parameter", name, known).into());
                };
                let values = plan(Path::new(file)).map_err(|reason| CliError::Plan {
                    file: file.clone(),
                    reason,
                })?;
                Ok(HeldInput {
                    parameter: parameter.clone(),
                    values,
                })
            })
            .collect()
    }
}

/// The times and values of a plan.
fn plan(path: &Path) -> Result<Vec<[f64; 2]>, String> {
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .trim(csv::Trim::All)
        .comment(Some(b'#'))
        .from_path(path)
        .map_err(|error| error.to_string())?;
    let mut values: Vec<[f64; 2]> = Vec::new();
    for (place, record) in reader.records().enumerate() {
        let record = record.map_err(|error| error.to_string())?;
        let line = place + 1;
        let [time, value] = [0, 1].map(|column| record.get(column).map(str::parse::<f64>));
        match (time, value) {
            (Some(Ok(time)), Some(Ok(value)))
                if record.len() == 2 && time.is_finite() && value.is_finite() =>
            {
                if let Some(&[before, _]) = values.last().filter(|[before, _]| *before >= time) {
                    return Err(format!(
                        "the time {time} of row {line} comes after {before}; expected times that ascend"
                    ));
                }
                values.push([time, value]);
            }
            // names of the columns
            (Some(Err(_)), Some(Err(_))) if line == 1 && record.len() == 2 => {}
            _ => {
                let found: Vec<_> = record.iter().collect();
                return Err(format!(
                    "expected a time and a value in row {line}, found `{}`",
                    found.join(",")
                ));
            }
        }
    }
    if values.is_empty() {
        return Err("it has no rows; expected times and values".to_owned());
    }
    Ok(values)
}
