//! Many runs side by side.

use std::num::NonZeroU64;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Duration;

use dsocs_core::{AnyEnsemble, AnyObserved, RunError};
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::begin::Begins;
use crate::error::{guarded, of_run, of_setup, plain};
use crate::text::PyText;

/// Every so many nodes a trajectory looks whether it is to end.
const LOOK: NonZeroU64 = NonZeroU64::new(256).unwrap();

/// Between two looks at signals pass so many milliseconds.
const PAUSE: Duration = Duration::from_millis(20);

/// The ends of many runs as a dict of arrays, and what failed: the number of the run and its error.
#[pyfunction]
#[pyo3(signature = (text, values, h, begins, varied, t, threads, progress))]
pub fn ensemble<'py>(
    py: Python<'py>,
    text: &PyText,
    values: Vec<f64>,
    h: f64,
    begins: Vec<Begins>,
    varied: Vec<(String, Vec<f64>)>,
    t: f64,
    threads: Option<usize>,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let kernel = text.kernel(&values);
    let starts: Vec<_> = begins
        .iter()
        .map(|begins| Ok(begins.beginning()?.start()))
        .collect::<PyResult<_>>()?;
    let count = starts.len();
    let mut ensemble = AnyEnsemble::of_tape(&kernel, h)
        .map_err(|error| of_setup(py, &error))?
        .starts(starts);
    for (parameter, values) in varied {
        ensemble = ensemble
            .varied(&parameter, values)
            .map_err(|error| of_run(py, &error))?;
    }
    if let Some(threads) = threads {
        ensemble = ensemble
            .threads(threads)
            .map_err(|error| plain(py, "Error", &error.to_string()))?;
    }
    let (stop, finished) = (AtomicBool::new(false), AtomicUsize::new(0));
    let tell = |total| finished.store(total, Ordering::Relaxed);
    let ensemble = ensemble.progress(&tell);
    // the runs in a thread of their own; this one looks at signals
    let ends = std::thread::scope(|scope| -> PyResult<_> {
        let runs = scope.spawn(|| {
            guarded(|| {
                ensemble.stream(
                    t,
                    LOOK,
                    |_| (),
                    |(), _| {
                        if stop.load(Ordering::Relaxed) {
                            ControlFlow::Break(())
                        } else {
                            ControlFlow::Continue(())
                        }
                    },
                )
            })
        });
        let mut interrupted = None;
        while !runs.is_finished() {
            py.detach(|| {
                // short runs are not waited for
                for _ in 0..20 {
                    if runs.is_finished() {
                        return;
                    }
                    std::thread::sleep(PAUSE / 20);
                }
            });
            let done = finished.load(Ordering::Relaxed);
            let told = progress.as_ref().map_or(Ok(()), |progress| {
                #[allow(clippy::cast_precision_loss)]
                let part = done as f64 / count.max(1) as f64;
                progress.call1((part,)).map(drop)
            });
            if let Err(error) = py.check_signals().and(told) {
                stop.store(true, Ordering::Relaxed);
                interrupted = Some(error);
                break;
            }
        }
        let ends = py.detach(|| runs.join());
        let ends =
            ends.map_err(|_| plain(py, "Error", "a mistake of this library: a thread has ended"))??;
        Ok((ends, interrupted))
    });
    let (ends, interrupted) = ends?;
    let told = arrays(py, &ends, text.dimension())?;
    told.set_item("interrupted", interrupted)?;
    Ok(told)
}

/// The last nodes as arrays; a run that failed has NaN.
fn arrays<'py>(py: Python<'py>, ends: &[AnyObserved<()>], n: usize) -> PyResult<Bound<'py, PyDict>> {
    let nan = vec![f64::NAN; n];
    let mut vectors: [Vec<f64>; 4] = Default::default();
    let (mut t, mut energy, mut failures) = (Vec::new(), Vec::new(), Vec::<(usize, &RunError)>::new());
    for (place, end) in ends.iter().enumerate() {
        let node = match &end.last {
            Ok(node) => Some(node.any()),
            Err(error) => {
                failures.push((place, error));
                None
            }
        };
        t.push(node.map_or(f64::NAN, |node| node.t));
        energy.push(node.map_or(f64::NAN, |node| node.energy));
        let rows = match &node {
            Some(node) => [node.q, node.v, node.a, node.force],
            None => [&nan[..]; 4],
        };
        for (vector, row) in vectors.iter_mut().zip(rows) {
            vector.extend_from_slice(row);
        }
    }
    let told = PyDict::new(py);
    told.set_item("t", PyArray1::from_vec(py, t))?;
    told.set_item("energy", PyArray1::from_vec(py, energy))?;
    for (name, vector) in ["q", "v", "a", "force"].into_iter().zip(vectors) {
        let array: Bound<'py, PyArray2<f64>> = PyArray1::from_vec(py, vector).reshape([ends.len(), n])?;
        told.set_item(name, array)?;
    }
    let failures = failures
        .into_iter()
        .map(|(place, error)| (place, of_run(py, error)));
    told.set_item("failures", failures.collect::<Vec<_>>())?;
    Ok(told)
}
