//! Many runs side by side.

use std::num::NonZeroU64;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::Duration;

use dsocs_core::text::TapeKernel;
use dsocs_core::{AnyEnsemble, AnyNode, AnyPoint, AnyStart, Declaration, Kernel};
use dsocs_systems::entry::Method;
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::beginning::{BeginningParts, method};
use crate::error::{guarded, of_run, of_setup, plain, with_workspace};
use crate::many::{End, ManyRuns};
use crate::text::PyText;

/// The number of nodes after which a trajectory checks whether it is to stop.
const NODES_PER_CHECK: NonZeroU64 = NonZeroU64::new(256).unwrap();

/// The time between two checks for signals.
const CHECK_INTERVAL: Duration = Duration::from_millis(20);

/// The number of runs that are made at a time, which bounds the memory for starts and nodes; a multiple of
/// all lanes.
const RUNS_AT_A_TIME: usize = 1 << 17;

/// A parameter that varies, by its name: a value for each run.
type VariedParameter<'py> = (String, PyReadonlyArray1<'py, f64>);

/// The ends of many runs as a dict of arrays, and the failures: the index of the run and its error. Positions
/// and velocities at the start, and the parameters that vary, have a row for each run.
#[pyfunction]
#[pyo3(signature = (text, values, h, beginning, q, v, varied, t, order, tolerance, threads, progress))]
pub fn ensemble<'py>(
    py: Python<'py>,
    text: &PyText,
    values: Vec<f64>,
    h: f64,
    beginning: BeginningParts,
    q: PyReadonlyArray2<'py, f64>,
    v: PyReadonlyArray2<'py, f64>,
    varied: Vec<VariedParameter<'py>>,
    t: f64,
    order: u32,
    tolerance: Option<f64>,
    threads: Option<usize>,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let (kernel, n) = (text.kernel(&values), text.dimension());
    let method = method(order, tolerance)?;
    let (q, v) = (q.as_slice()?, v.as_slice()?);
    let varied: Vec<(&str, &[f64])> = varied
        .iter()
        .map(|(name, values)| Ok((name.as_str(), values.as_slice()?)))
        .collect::<PyResult<_>>()?;
    let count = q.len() / n.max(1);
    let observables = (&kernel as &dyn Kernel).shape().observables.len();
    let mut arrays = Arrays::of([n, observables], count)?;
    let (stop, finished) = (AtomicBool::new(false), AtomicUsize::new(0));
    let mut interrupted = None;
    for first in (0..count).step_by(RUNS_AT_A_TIME) {
        let some = first..count.min(first + RUNS_AT_A_TIME);
        let rows = some.start * n..some.end * n;
        let rows = q[rows.clone()].chunks(n.max(1)).zip(v[rows].chunks(n.max(1)));
        let starts: Vec<AnyStart> = rows.map(|(q, v)| beginning.from(q, v)).collect::<PyResult<_>>()?;
        let varied: Vec<(&str, &[f64])> = varied
            .iter()
            .map(|(name, values)| (*name, values.get(some.clone()).unwrap_or_default()))
            .collect();
        let tell = |total: usize| finished.store(first + total, Ordering::Relaxed);
        let lanes = match method {
            Method::Step => Some(in_lanes(py, &kernel, h, (&starts, &varied), threads)?.progress(&tell)),
            _ => None,
        };
        let other = ManyRuns {
            kernel: &kernel,
            h,
            method,
            starts: &starts,
            varied: &varied,
            t,
            stop: &stop,
            finished: &finished,
        };
        let ends = with_signal_checks(
            py,
            || match &lanes {
                Some(lanes) => to_the_end(lanes, t, &stop),
                None => other.ends(threads),
            },
            || {
                if interrupted.is_some() {
                    return;
                }
                let done = finished.load(Ordering::Relaxed);
                let reported = progress.as_ref().map_or(Ok(()), |progress| {
                    #[allow(clippy::cast_precision_loss)]
                    let part = done as f64 / count.max(1) as f64;
                    progress.call1((part,)).map(drop)
                });
                if let Err(error) = py.check_signals().and(reported) {
                    stop.store(true, Ordering::Relaxed);
                    interrupted = Some(error);
                }
            },
        )?;
        arrays.take(py, &ends, &kernel, &varied);
    }
    let dict = arrays.into_dict(py)?;
    dict.set_item("interrupted", interrupted)?;
    Ok(dict)
}

/// Runs in another thread, while this one checks for signals.
fn with_signal_checks(
    py: Python<'_>,
    runs: impl FnOnce() -> Vec<End> + Send,
    mut look: impl FnMut(),
) -> PyResult<Vec<End>> {
    std::thread::scope(|scope| {
        let (done, mut wait) = mpsc::channel::<()>();
        let runs = scope.spawn(|| {
            // dropped when the runs end, which ends the wait
            let _done = done;
            guarded(runs)
        });
        loop {
            let wait = &mut wait;
            let waited = py.detach(move || wait.recv_timeout(CHECK_INTERVAL));
            if waited == Err(RecvTimeoutError::Disconnected) {
                break;
            }
            look();
        }
        let ends = py.detach(|| runs.join());
        let ends = ends.map_err(|_| plain(py, "Error", "a mistake of this library: a thread has ended"))?;
        Ok(ends?)
    })
}

/// The runs by the paper's step, in lanes.
fn in_lanes<'k>(
    py: Python<'_>,
    kernel: &'k TapeKernel,
    h: f64,
    (starts, varied): (&[AnyStart], &[(&str, &[f64])]),
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

/// Runs all to their ends, or until `stop` is set.
fn to_the_end(lanes: &AnyEnsemble<'_>, t: f64, stop: &AtomicBool) -> Vec<End> {
    let visit = |(): &mut (), _: &AnyNode<'_>| {
        if stop.load(Ordering::Relaxed) {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    };
    let ends = lanes.stream(t, NODES_PER_CHECK, |_| (), visit);
    ends.into_iter().map(|end| end.last).collect()
}

/// The last nodes as arrays; a run that failed has NaN.
struct Arrays {
    /// The numbers of coordinates and observed expressions.
    widths: [usize; 2],
    /// Times.
    t: Vec<f64>,
    /// Energies.
    energy: Vec<f64>,
    /// Positions, velocities, accelerations and constraint forces.
    vectors: [Vec<f64>; 4],
    /// The observed expressions.
    observed: Vec<f64>,
    /// The failures: the index of the run, and its exception.
    failures: Vec<(usize, PyErr)>,
}

impl Arrays {
    /// Arrays with room for `count` runs.
    fn of([n, observables]: [usize; 2], count: usize) -> PyResult<Self> {
        let room = |width: usize| with_workspace(count.checked_mul(width), "runs");
        Ok(Self {
            widths: [n, observables],
            t: room(1)?,
            energy: room(1)?,
            vectors: [room(n)?, room(n)?, room(n)?, room(n)?],
            observed: room(observables)?,
            failures: Vec::new(),
        })
    }

    /// Appends the next ends; the parameters of `varied` have other values in each run.
    fn take(&mut self, py: Python<'_>, ends: &[End], kernel: &TapeKernel, varied: &[(&str, &[f64])]) {
        let [n, observables] = self.widths;
        let nan = vec![f64::NAN; n];
        let known: &dyn Kernel = kernel;
        let parameters = &known.shape().parameters;
        let place = |name: &str| parameters.iter().position(|parameter| parameter.name == name);
        let places: Vec<(usize, &[f64])> = varied
            .iter()
            .filter_map(|(name, values)| Some((place(name)?, *values)))
            .collect();
        let mut values: Vec<f64> = (0..parameters.len()).map(|place| known.value(place)).collect();
        let mut observed = vec![f64::NAN; observables];
        for (number, end) in ends.iter().enumerate() {
            let node = match end {
                Ok(node) => Some(node.any()),
                Err(error) => {
                    self.failures.push((self.t.len(), of_run(py, error)));
                    None
                }
            };
            self.t.push(node.map_or(f64::NAN, |node| node.t));
            self.energy.push(node.map_or(f64::NAN, |node| node.energy));
            let rows = match &node {
                Some(node) => [node.q, node.v, node.a, node.force],
                None => [&nan[..]; 4],
            };
            for (vector, row) in self.vectors.iter_mut().zip(rows) {
                vector.extend_from_slice(row);
            }
            if observables == 0 {
                continue;
            }
            observed.fill(f64::NAN);
            if let Some(AnyNode { t, q, v, a, .. }) = node {
                for (place, varied) in &places {
                    values[*place] = varied.get(number).copied().unwrap_or(f64::NAN);
                }
                let declaration = Declaration::of(kernel).with(&values);
                declaration.observe(AnyPoint { t, q, v, a }, &mut observed);
            }
            self.observed.extend_from_slice(&observed);
        }
    }

    /// All arrays as a dict.
    fn into_dict(self, py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
        let (count, [n, observables]) = (self.t.len(), self.widths);
        let dict = PyDict::new(py);
        dict.set_item("t", PyArray1::from_vec(py, self.t))?;
        dict.set_item("energy", PyArray1::from_vec(py, self.energy))?;
        for (name, vector) in ["q", "v", "a", "force"].into_iter().zip(self.vectors) {
            let array: Bound<'_, PyArray2<f64>> = PyArray1::from_vec(py, vector).reshape([count, n])?;
            dict.set_item(name, array)?;
        }
        let observed = PyArray1::from_vec(py, self.observed).reshape([count, observables])?;
        dict.set_item("observed", observed)?;
        dict.set_item("failures", self.failures)?;
        Ok(dict)
    }
}
