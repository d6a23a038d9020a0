//! The page of a run, its errors, its regularity, and the checks of its motion.

use std::ffi::OsString;
use std::ops::ControlFlow;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::Instant;

use dsocs_core::{Regularity, Samples};
use dsocs_systems::check::{Begin, Settings};
use dsocs_systems::cli;
use dsocs_systems::entry::{Beginning, HeldInput, Plan, Row, RunFailure};
use dsocs_systems::stability::Bar;
use dsocs_systems::systems;
use numpy::{PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::beginning::{BeginningParts, method};
use crate::error::{guarded, in_python, of_check, of_failure, plain};
use crate::motion::CHECK_INTERVAL;
use crate::text::PyText;

/// The command `dsocs` with these words, its own name first; returns the exit status.
#[pyfunction]
pub fn program(py: Python<'_>, called: Vec<OsString>) -> u8 {
    py.detach(|| cli::dsocs::main_with_arguments(&called, systems::all()))
}

/// The samples in a file, as pairs of a place and a value.
#[pyfunction]
pub fn samples(py: Python<'_>, path: &str) -> PyResult<Vec<(f64, f64)>> {
    Samples::read(path).map_err(|error| plain(py, "DeclarationError", &format!("{path}: {error}")))
}

/// The inputs that change, by their names: times, and the values that hold from them on.
type HeldInputs = Vec<(String, Vec<(f64, f64)>)>;

/// The plan of a run.
fn plan(h: f64, until: f64, (order, tolerance): (u32, Option<f64>), held: HeldInputs) -> PyResult<Plan> {
    let inputs = held.into_iter().map(|(parameter, values)| HeldInput {
        parameter: parameter.into(),
        values: values.into_iter().map(|(t, value)| [t, value]).collect(),
    });
    Ok(Plan {
        h,
        until,
        method: method(order, tolerance)?,
        certify: false,
        estimate: false,
        inputs: inputs.collect(),
    })
}

/// The page of a run, from the values of all columns at its nodes; the last columns are parameters that
/// changed.
#[pyfunction]
pub fn page(
    py: Python<'_>,
    text: &PyText,
    values: Vec<f64>,
    h: f64,
    until: f64,
    order: u32,
    tolerance: Option<f64>,
    beginning: BeginningParts,
    changed: Vec<String>,
    rows: PyReadonlyArray2<'_, f64>,
    notes: Vec<String>,
) -> PyResult<String> {
    let (plan, beginning) = (
        plan(h, until, (order, tolerance), Vec::new())?,
        beginning.beginning()?,
    );
    let width = rows.shape()[1].max(1);
    let rows: Vec<Vec<f64>> = rows
        .as_slice()?
        .chunks_exact(width)
        .map(<[f64]>::to_vec)
        .collect();
    py.detach(|| {
        let mut entry = text.entry(None, &values)?;
        Ok(guarded(|| {
            cli::run_page(&mut entry, &plan, &beginning, &changed, rows, &notes)
        })?)
    })
}

/// The regularity at each kept node: the smallest singular values of the derivatives of the rows by the last
/// and by the first node, NaN at the start, and whether a flow forward and one backward are granted.
#[pyfunction]
pub fn certify(
    py: Python<'_>,
    text: &PyText,
    values: Vec<f64>,
    h: f64,
    until: f64,
    beginning: BeginningParts,
    every: u64,
) -> PyResult<Vec<(f64, f64, bool, bool)>> {
    let plan = Plan {
        certify: true,
        ..plan(h, until, (2, None), Vec::new())?
    };
    let mut found = Vec::new();
    run_again(py, text, &values, &plan, &beginning, &mut |row| {
        if row.node.index.is_multiple_of(every) {
            let at = row.regularity.unwrap_or(Regularity::UNKNOWN);
            found.push((at.forward, at.backward, at.grants_forward(), at.grants_backward()));
        }
    })?;
    Ok(found)
}

/// Repeats a run and passes on its rows, with checks for signals.
fn run_again(
    py: Python<'_>,
    text: &PyText,
    values: &[f64],
    plan: &Plan,
    beginning: &BeginningParts,
    look: &mut (dyn FnMut(&Row<'_>) + Send),
) -> PyResult<()> {
    let beginning = beginning.beginning()?;
    let (mut looked, mut stopped) = (Instant::now(), None);
    py.detach(|| {
        let entry = text.entry(None, values)?;
        let run = guarded(|| {
            entry.run(plan, &beginning, &mut |row| {
                look(row);
                if looked.elapsed() > CHECK_INTERVAL {
                    looked = Instant::now();
                    if let Err(error) = Python::attach(|py| py.check_signals()) {
                        stopped = Some(error);
                        return ControlFlow::Break(());
                    }
                }
                ControlFlow::Continue(())
            })
        })?;
        run.map_err(|failure| Python::attach(|py| of_failure(py, &failure)))
    })?;
    stopped.map_or(Ok(()), Err)
}

/// The errors of a run against the continuous motion: one for each coordinate at each kept node, one after
/// the other, and the uncertainty of that motion.
#[pyfunction]
pub fn estimate(
    py: Python<'_>,
    text: &PyText,
    values: Vec<f64>,
    h: f64,
    until: f64,
    order: u32,
    tolerance: Option<f64>,
    beginning: BeginningParts,
    held: HeldInputs,
    every: u64,
) -> PyResult<(Vec<f64>, f64)> {
    let plan = Plan {
        estimate: true,
        ..plan(h, until, (order, tolerance), held)?
    };
    let (mut errors, mut uncertainty, mut unknown) = (Vec::new(), 0.0, None);
    run_again(py, text, &values, &plan, &beginning, &mut |row| {
        if row.node.index.is_multiple_of(every) {
            errors.extend_from_slice(row.errors);
        }
        uncertainty = row.uncertainty;
        if unknown.is_none() {
            unknown = row.unknown.cloned();
        }
    })?;
    match unknown {
        Some(error) => Err(of_failure(py, &RunFailure::Estimate(error))),
        None => Ok((errors, uncertainty)),
    }
}

/// The findings of the checks of a motion, each as a dict.
#[pyfunction]
pub fn check<'py>(
    py: Python<'py>,
    text: &PyText,
    values: Vec<f64>,
    h: f64,
    until: f64,
    beginning: BeginningParts,
) -> PyResult<Vec<Bound<'py, PyDict>>> {
    let beginning = beginning.beginning()?;
    let (mut begin, mut t0, mut a0) = (Begin::default(), 0.0, None);
    let mut inner = &beginning;
    let (q0, v0) = loop {
        match inner {
            Beginning::Projected(other) => {
                begin.projected = true;
                inner = other;
            }
            Beginning::At(t, other) => {
                t0 = *t;
                inner = other;
            }
            Beginning::Near(near, other) => {
                a0 = Some(near.as_slice());
                inner = other;
            }
            Beginning::Paper { q0, v0 } => {
                begin.paper = true;
                break (q0, v0);
            }
            Beginning::SecondOrder { q0, v0 } => break (q0, v0),
            Beginning::ThirdOrder { q0, v0, a0: a } => {
                a0 = Some(a.as_slice());
                break (q0, v0);
            }
            _ => {
                let message = "the checks begin with a position and a velocity (and an acceleration, where a constraint is of third order)";
                return Err(plain(py, "SetupError", message));
            }
        }
    };
    let (q0, v0, a0) = (q0.clone(), v0.clone(), a0.map(<[f64]>::to_vec));
    let entry = text.entry(None, &values)?;
    // in a thread of its own, which is abandoned if the user interrupts: its findings are then dropped
    let (sender, mut receiver) = mpsc::channel();
    std::thread::spawn(move || {
        let settings = Settings {
            h,
            until: Some(until),
            t0,
            q0: &q0,
            v0: &v0,
            a0: a0.as_deref(),
            begin,
        };
        let found = guarded(|| entry.check(&settings));
        // the receiver may have been dropped by an interrupt
        let _ = sender.send(found);
    });
    let findings = loop {
        let wait = &mut receiver;
        match py.detach(move || wait.recv_timeout(CHECK_INTERVAL)) {
            Ok(found) => break found?,
            Err(RecvTimeoutError::Timeout) => py.check_signals()?,
            Err(RecvTimeoutError::Disconnected) => {
                return Err(plain(
                    py,
                    "Error",
                    "a mistake of this library: a thread has ended",
                ));
            }
        }
    };
    let findings = findings.map_err(|failure| of_check(py, &failure))?;
    let dicts = findings.iter().map(|finding| {
        let (bar, relation) = match finding.bar {
            Bar::AtMost(bar) => (Some(bar), Some("<=")),
            Bar::AtLeast(bar) => (Some(bar), Some(">=")),
            Bar::Reported => (None, None),
        };
        let dict = PyDict::new(py);
        dict.set_item("check", finding.check)?;
        dict.set_item("what", &finding.what)?;
        dict.set_item("figure", finding.figure)?;
        dict.set_item("bar", bar)?;
        dict.set_item("relation", relation)?;
        dict.set_item("ok", finding.ok())?;
        for (name, said) in [
            ("failure", &finding.failure),
            ("note", &finding.note),
            ("excuse", &finding.excuse),
        ] {
            dict.set_item(name, said.as_ref().map(|said| in_python(said)))?;
        }
        Ok(dict)
    });
    dicts.collect()
}
