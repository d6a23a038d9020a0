//! `--input NAME=FILE`: a parameter whose value is held between the times in a file.

use std::path::Path;

use clap::Args;
use dsocs_core::Samples;

use crate::cli::CliError;
use crate::entry::{Entry, HeldInput};

/// Parameters that change during a run.
#[derive(Args, Clone, Debug)]
pub struct InputArguments {
    /// A parameter that changes at nodes: a .csv file with two columns, the time in s and the value that holds from the next node on (back in time, up to it); before the first time the parameter has its own value; may be given
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
                    return Err(entry.unknown_parameter(name).into());
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
    let samples = Samples::read(path).map_err(|error| error.to_string())?;
    for (place, pair) in samples.windows(2).enumerate() {
        let ([before, time], row) = ([pair[0].0, pair[1].0], place + 2);
        if before >= time {
            return Err(format!(
                "the time {time} of row {row} comes after {before}; expected times that ascend"
            ));
        }
    }
    if let Some((time, value)) = samples
        .iter()
        .find(|(time, value)| !(time.is_finite() && value.is_finite()))
    {
        return Err(format!("it has the row {time}, {value}; expected finite numbers"));
    }
    if samples.is_empty() {
        return Err("it has no rows; expected times and values".to_owned());
    }
    Ok(samples.into_iter().map(|(time, value)| [time, value]).collect())
}
