//! Many runs side by side.

use std::num::NonZeroU64;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::Duration;

use dsocs_core::text::TapeKernel;
use dsocs_core::{AnyEnsemble, AnyNode, AnyStart, RunError};
use dsocs_systems::entry::Method;
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::begin::{Begins, method};
use crate::error::{guarded, of_run, of_setup, plain};
use crate::many::{End, Many};
use crate::text::PyText;

/// Every so many nodes a trajectory looks whether it is to end.
const LOOK: NonZeroU64 = NonZeroU64::new(256).unwrap();

/// Between two looks at signals pass so many milliseconds.
const PAUSE: Duration = Duration::from_millis(20);

/// The ends of many runs as a dict of arrays, and what failed: the number of the run and its error. The positions and velocities at the start have a row
/// for each run, and so have the parameters that vary.
#[pyfunction]
#[pyo3(signature = (text, values, h, begins, q, v, varied, t, order, tolerance, threads, progress))]
pub fn ensemble<'py>(
    py: Python<'py>,
    text: &PyText,
    values: Vec<f64>,
    h: f64,
    begins: Begins,
    q: PyReadonlyArray2<'py, f64>,
    v: PyReadonlyArray2<'py, f64>,
    varied: Vec<(String, Vec<f64>)>,
    t: f64,
    order: u32,
    tolerance: Option<f64>,
    threads: Option<usize>,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let (kernel, n) = (text.kernel(&values), text.dimension());
    let method = method(order, tolerance)?;
    let rows = q.as_slice()?.chunks(n.max(1)).zip(v.as_slice()?.chunks(n.max(1)));
    let starts: Vec<AnyStart> = rows.map(|(q, v)| begins.from(q, v)).collect::<PyResult<_>>()?;
    let count = starts.len();
    let (stop, finished) = (AtomicBool::new(false), AtomicUsize::new(0));
    let tell = |total| finished.store(total, Ordering::Relaxed);
    let lanes = match method {
        Method::Step => Some(in_lanes(py, &kernel, h, (&starts, &varied), threads)?.progress(&tell)),
        _ => None,
    };
    let other = Many {
        kernel: &kernel,
        h,
        method,
        starts: &starts,
        varied: &varied,
        t,
        stop: &stop,
        finished: &finished,
    };
    // the runs in a thread of their own; this one looks at signals
    let ends = std::thread::scope(|scope| -> PyResult<_> {
        let (done, mut wait) = mpsc::channel::<()>();
        let runs = scope.spawn(|| {
            // when it ends, nobody waits any more
            let _done = done;
            guarded(|| match &lanes {
                Some(lanes) => to_the_end(lanes, t, &stop),
                None => other.ends(threads),
            })
        });
        let mut interrupted = None;
        loop {
            let wait = &mut wait;
            let waited = py.detach(move || wait.recv_timeout(PAUSE));
            if waited == Err(RecvTimeoutError::Disconnected) {
                break;
            }
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
    let told = arrays(py, &ends, n)?;
    told.set_item("interrupted", interrupted)?;
    Ok(told)
}

/// The runs by the paper's step, in lanes.
fn in_lanes<'k>(
    py: Python<'_>,
    kernel: &'k TapeKernel,
    h: f64,
    (starts, varied): (&[AnyStart], &[(String, Vec<f64>)]),
    threads: Option<usize>,
) -> PyResult<AnyEnsemble<'k>> {
    let mut ensemble = AnyEnsemble::of_tape(kernel, h)
        .map_err(|error| of_setup(py, &error))?
        .starts(starts.iter().cloned());
    for (parameter, values) in varied {
        ensemble = ensemble
            .varied(parameter, values.iter().copied())
            .map_err(|error| of_run(py, &error))?;
    }
    match threads {
        Some(threads) => ensemble
            .threads(threads)
            .map_err(|error| plain(py, "Error", &error.to_string())),
        None => Ok(ensemble),
    }
}

/// Runs all to their ends, or until someone stops them.
fn to_the_end(lanes: &AnyEnsemble<'_>, t: f64, stop: &AtomicBool) -> Vec<End> {
    let visit = |(): &mut (), _: &AnyNode<'_>| {
        if stop.load(Ordering::Relaxed) {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    };
    let ends = lanes.stream(t, LOOK, |_| (), visit);
    ends.into_iter().map(|end| end.last).collect()
}

/// The last nodes as arrays; a run that failed has NaN.
fn arrays<'py>(py: Python<'py>, ends: &[End], n: usize) -> PyResult<Bound<'py, PyDict>> {
    let nan = vec![f64::NAN; n];
    let mut vectors: [Vec<f64>; 4] = Default::default();
    let (mut t, mut energy, mut failures) = (Vec::new(), Vec::new(), Vec::<(usize, &RunError)>::new());
    for (place, end) in ends.iter().enumerate() {
        let node = match end {
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
