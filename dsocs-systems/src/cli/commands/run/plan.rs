//! The plan and the start of the run that was asked for.

use dsocs_core::RunError;

use super::RunArguments;
use crate::cli::CliError;
use crate::cli::arguments::start::{StartOption, vector};
use crate::entry::{Beginning, Entry, Plan, RunFailure};

/// The plan of the run that was asked for.
pub(super) fn plan(arguments: &RunArguments, entry: &Entry) -> Result<Plan, CliError> {
    let accuracy = &arguments.accuracy;
    let (nodes, start) = (arguments.q1.is_some(), arguments.begin.start.is_some());
    accuracy.check(nodes, start, arguments.certify)?;
    let h = arguments.step.unwrap_or(entry.default_step());
    let until = arguments
        .until
        .unwrap_or(arguments.from.t0() + entry.until_with(h));
    if until.is_infinite() {
        return Err(RunFailure::from(RunError::Until { until }).into());
    }
    Ok(Plan {
        h,
        until,
        method: accuracy.method(),
        certify: arguments.certify,
        estimate: accuracy.estimates(),
        inputs: arguments.inputs.read(entry)?,
    })
}

/// The start that was asked for.
pub(super) fn beginning(arguments: &RunArguments, entry: &Entry) -> Result<Beginning, CliError> {
    let q0 = arguments.from.q0(entry)?;
    let v0 = || arguments.from.v0(entry);
    let q1 = vector("--q1", arguments.q1.as_deref(), None, entry)?;
    let given = match (q1, arguments.begin.start) {
        (Some(q1), _) => Beginning::Nodes { q0, q1 },
        (None, Some(StartOption::Paper)) => Beginning::Paper { q0, v0: v0()? },
        (None, Some(StartOption::SecondOrder)) => Beginning::SecondOrder { q0, v0: v0()? },
        (None, None) => match arguments.from.third_order(entry, &q0)? {
            Some(third) => third,
            None => Beginning::SecondOrder { q0, v0: v0()? },
        },
    };
    let given = match arguments.from.near(entry)? {
        Some(near) => Beginning::Near(near, Box::new(given)),
        None => given,
    };
    let t0 = arguments.from.t0();
    let given = if t0 == 0.0 {
        given
    } else {
        Beginning::At(t0, Box::new(given))
    };
    Ok(if arguments.begin.project || entry.projects() {
        Beginning::Projected(Box::new(given))
    } else {
        given
    })
}
