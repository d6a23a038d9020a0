//! `dsocs paper`: the paper's figures, their numbers and the tables of errors.

mod figures;
mod report;
mod summary;

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use dsocs_core::Node;
use rayon::prelude::*;

use crate::cli::CliError;
use crate::cli::output;
use crate::cli::output::progress;
use crate::experiment::pendulum::Moment;
use crate::experiment::{ErrorRow, ExperimentError, particle, pendulum};
use crate::figure::Format;
use crate::reference::Reference;

pub use figures::all as figures;

/// The arguments of `dsocs paper`.
#[derive(Args, Debug)]
pub struct PaperArguments {
    /// The folder for figures and numbers
    #[arg(long, value_name = "DIR", default_value = "results")]
    out: PathBuf,
}

/// The results behind the figures.
pub struct Results {
    /// The particle's motion.
    particle: Vec<Node<2>>,
    /// The particle's errors.
    pub particle_errors: Vec<ErrorRow>,
    /// The pendulum's motion.
    pendulum: Vec<Moment>,
    /// The pendulum's errors.
    pub pendulum_errors: Vec<ErrorRow>,
    /// The pendulum's errors with smaller steps, which no figure shows.
    pendulum_further: Vec<ErrorRow>,
    /// The pendulum's continuous motion.
    reference: Reference,
}

/// Reproduces the paper's figures.
///
/// # Errors
///
/// [`CliError`] if the folder cannot be written (which is tried before anything is computed) or an experiment fails.
pub fn paper(arguments: &PaperArguments) -> Result<(), CliError> {
    let folder = &arguments.out;
    output::check_folder(folder)?;
    let begun = Instant::now();

    let results = compute()?;
    output::write(&folder.join("summary.json"), &summary::json(&results))?;
    let computed = begun.elapsed();

    let figures = figures::all(&results);
    let bar = progress::bar((Format::WRITTEN.len() * figures.len()) as u64, "figures");
    figures.par_iter().try_for_each(|(name, figure)| {
        for &format in Format::WRITTEN {
            let file = format!("{name}.{}", format.ending());
            output::write(&folder.join(file), &figure.encode(format)?)?;
            bar.inc(1);
        }
        Ok::<_, CliError>(())
    })?;
    bar.finish_and_clear();

    let names: Vec<&str> = figures.iter().map(|&(name, _)| name).collect();
    report::print(&results, folder, &names, [computed, begun.elapsed()])
}

/// Runs all experiments, independent ones at the same time.
///
/// # Errors
///
/// [`ExperimentError`] if one fails.
pub fn compute() -> Result<Results, ExperimentError> {
    let steps = particle::STEPS.len() + pendulum::STEPS.len() + pendulum::FURTHER_STEPS.len();
    let runs = 2 * steps as u64;
    let bar = progress::bar(runs + 3, "computing");
    let done = || bar.inc(1);
    let particle_runs = || (particle::motion().inspect(|_| done()), particle::errors(done));
    let pendulum_runs = || {
        let reference = pendulum::reference().inspect(|_| done())?;
        // the longest runs first
        let further = pendulum::errors_at(&pendulum::FURTHER_STEPS, &reference, done)?;
        let errors = pendulum::errors(&reference, done)?;
        Ok::<_, ExperimentError>((reference, errors, further))
    };
    let shown_pendulum = || pendulum::motion().inspect(|_| done());
    let ((particle, particle_errors), (shown, pendulum_results)) =
        rayon::join(particle_runs, || rayon::join(shown_pendulum, pendulum_runs));
    bar.finish_and_clear();
    let (reference, pendulum_errors, pendulum_further) = pendulum_results?;
    Ok(Results {
        particle: particle?,
        particle_errors: particle_errors?,
        pendulum: shown?,
        pendulum_errors,
        pendulum_further,
        reference,
    })
}
