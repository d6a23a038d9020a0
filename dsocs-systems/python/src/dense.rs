//! The motion of a run between its nodes, events, and both solutions of a step.

use std::ops::ControlFlow;
use std::time::Instant;

use dsocs_core::taylor::Jet;
use dsocs_core::text::TapeKernel;
use dsocs_core::{AnyEvent, AnyEvents, AnyObserver, AnyOccurrence, AnyPoint, Declaration, Run, RunError};
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1};
use pyo3::prelude::*;

use crate::error::{guarded, of_run, plain, with_workspace};
use crate::motion::CHECK_INTERVAL;
use crate::run::{PyRun, State};

/// The largest number of nodes between two checks for signals.
const NODES_PER_CHECK: f64 = 8192.0;

/// An array with a row for each point.
type Rows<'py> = Bound<'py, PyArray2<f64>>;

/// An event: the kind of quantity, its index, the value that it passes, the direction (1, −1 or 0), and
/// whether it ends the run.
type WatchedEvent = (String, usize, f64, i32, bool);

/// An event that happened: its index, whether the quantity rises, time, position, velocity, acceleration.
type OccurredEvent = (usize, bool, f64, Vec<f64>, Vec<f64>, Vec<f64>);

/// The motion at some times: positions, velocities, accelerations and observed expressions. The run goes on
/// to the last of them, and keeps no node.
#[pyfunction]
pub fn sample<'py>(
    py: Python<'py>,
    run: PyRef<'py, PyRun>,
    times: PyReadonlyArray1<'py, f64>,
) -> PyResult<[Rows<'py>; 4]> {
    let times = times.as_slice()?;
    run.with(|state| {
        let n = state.motion.dimension();
        let observables = state.motion.system().shape().observables.len();
        let room = |width: usize| with_workspace(times.len().checked_mul(width), "times");
        let mut vectors = [room(n)?, room(n)?, room(n)?];
        let mut observed = room(observables)?;
        let (now, step) = state.motion.look(|run| (run.clock().time(), run.clock().step()));
        let asked = with_stops(now, step, times);
        let at: Vec<f64> = asked.iter().map(|(t, _)| *t).collect();
        let mut wanted = asked.iter().map(|(_, wanted)| *wanted);
        let (mut checked, mut signals) = (Instant::now(), Ok(()));
        let mut take = |some: &[f64], numbers: &[f64]| {
            for (place, wanted) in wanted.by_ref().take(some.len()).enumerate() {
                for (kind, vector) in vectors.iter_mut().enumerate() {
                    let begin = n * (3 * place + kind);
                    let row = numbers.get(begin..begin + n).filter(|_| wanted);
                    vector.extend_from_slice(row.unwrap_or_default());
                }
            }
            if checked.elapsed() > CHECK_INTERVAL {
                checked = Instant::now();
                signals = Python::attach(|py| py.check_signals());
            }
            if signals.is_ok() {
                ControlFlow::Continue(())
            } else {
                ControlFlow::Break(())
            }
        };
        let sampled =
            py.detach(|| guarded(|| state.motion.with(|run| run.sample_together(&at, &mut take))))?;
        signals?;
        sampled.map_err(|error| of_run(py, &error))?;
        observed.resize(times.len() * observables, 0.0);
        state.motion.look(|run| {
            let declaration = run.declaration();
            for ((row, &t), values) in times
                .iter()
                .enumerate()
                .zip(observed.chunks_mut(observables.max(1)))
            {
                let [q, v, a] = vectors
                    .each_ref()
                    .map(|vector| vector.get(n * row..n * (row + 1)).unwrap_or_default());
                declaration.observe(AnyPoint { t, q, v, a }, values);
            }
        });
        let [q, v, a] = vectors;
        let rows =
            |numbers: Vec<f64>, width: usize| PyArray1::from_vec(py, numbers).reshape([times.len(), width]);
        Ok([
            rows(q, n)?,
            rows(v, n)?,
            rows(a, n)?,
            rows(observed, observables)?,
        ])
    })
}

/// Runs towards a time and returns the events on the way. Ends with `true` at the first event that ends the
/// run.
#[pyfunction]
pub fn watch(
    py: Python<'_>,
    run: PyRef<'_, PyRun>,
    t: f64,
    watched: Vec<WatchedEvent>,
) -> PyResult<(Vec<OccurredEvent>, bool)> {
    run.with(|state| {
        let (ended, found) = py.detach(|| guarded(|| watch_to(state, t, &watched)))?;
        let ended = ended?.map_err(|error| of_run(py, &error))?;
        let found = found.iter().map(|at| {
            let AnyPoint { t, q, v, a } = at.point();
            (at.event, at.rising, t, q.to_vec(), v.to_vec(), a.to_vec())
        });
        Ok((found.collect(), ended))
    })
}

/// Whether an event has ended a run, or the error that has, or the exception of a signal; and the events up
/// to there.
type WatchResult = (PyResult<Result<bool, RunError>>, Vec<AnyOccurrence>);

/// Runs to a time, watching for events. The nodes are kept.
fn watch_to(state: &mut State, t: f64, watched: &[WatchedEvent]) -> WatchResult {
    let kernel = state.motion.kernel().clone();
    let values = state.motion.look(|run| run.values().to_vec());
    let functions = watched.iter().map(|one| event(&kernel, &values, one)).collect();
    let mut events = AnyEvents::new(functions).after(std::mem::take(&mut state.leg));
    let mut found = Vec::new();
    let ended = go_on_watching(state, t, &mut events, &mut found);
    state.leg = events.last_leg();
    (ended, found)
}

/// Runs to a time, watching for events, with checks for signals in between.
fn go_on_watching(
    state: &mut State,
    t: f64,
    events: &mut AnyEvents<'_>,
    found: &mut Vec<AnyOccurrence>,
) -> PyResult<Result<bool, RunError>> {
    let State { motion, record, .. } = state;
    loop {
        let begun = Instant::now();
        let mut paused = false;
        let mut watching = EventWatcher {
            take: &mut |run| {
                record.take(run);
                paused = begun.elapsed() > CHECK_INTERVAL;
                paused
            },
            found,
        };
        match motion.with(|run| run.watch(t, events, &mut watching)) {
            Err(error) => return Ok(Err(error)),
            Ok(Some(_)) => return Ok(Ok(true)),
            Ok(None) if !paused => return Ok(Ok(false)),
            Ok(None) => {}
        }
        Python::attach(|py| py.check_signals())?;
    }
}

/// The event function of a watched quantity.
fn event<'e>(
    kernel: &'e TapeKernel,
    values: &'e [f64],
    (of, place, level, direction, ends): &WatchedEvent,
) -> AnyEvent<'e> {
    let (place, level) = (*place, *level);
    let part = move |vector: &[Jet]| vector.get(place).copied().unwrap_or(Jet::from(f64::NAN)) - level;
    let event = match of.as_str() {
        "q" => AnyEvent::function(move |at: AnyPoint<'_, Jet>| part(at.q)),
        "v" => AnyEvent::function(move |at: AnyPoint<'_, Jet>| part(at.v)),
        "a" => AnyEvent::function(move |at: AnyPoint<'_, Jet>| part(at.a)),
        _ => AnyEvent::function(move |at: AnyPoint<'_, Jet>| {
            let declaration = Declaration::of(kernel).with(values);
            let mut observed = vec![Jet::from(f64::NAN); declaration.shape().observables.len()];
            declaration.observe(at, &mut observed);
            part(&observed)
        }),
    };
    let event = match direction {
        1 => event.rising(),
        -1 => event.falling(),
        _ => event,
    };
    if *ends { event.terminal() } else { event }
}

/// The solutions of the next step: the one that Newton's iteration finds, and another one if there is one.
#[pyfunction]
pub fn roots(py: Python<'_>, run: PyRef<'_, PyRun>) -> PyResult<(Vec<f64>, Option<Vec<f64>>)> {
    run.with(|state| {
        let roots = guarded(|| state.motion.with_step(|flow| flow.roots()))?;
        let roots = roots.ok_or_else(|| other_method_error(py, "roots"))?;
        roots.map_err(|error| of_run(py, &error.into()))
    })
}

/// Makes the step whose solution is nearest to a position.
#[pyfunction]
pub fn advance_to(py: Python<'_>, run: PyRef<'_, PyRun>, q2: Vec<f64>) -> PyResult<()> {
    run.with(|state| {
        let made = guarded(|| state.motion.with_step(|flow| flow.advance_to(&q2)))?;
        let made = made.ok_or_else(|| other_method_error(py, "advance_to"))?;
        made.map_err(|error| of_run(py, &error.into()))?;
        let State { motion, record, .. } = state;
        motion.with(|run| record.take(run));
        Ok(())
    })
}

/// The error for a method other than the step of order 2.
fn other_method_error(py: Python<'_>, what: &str) -> PyErr {
    let message = format!("{what} is of the step of order 2 alone: order=2, without a tolerance");
    plain(py, "SetupError", &message)
}

/// Times, and whether each was asked for. Between two that are far apart further ones are inserted, at which
/// signals are checked.
fn with_stops(now: f64, step: Option<f64>, times: &[f64]) -> Vec<(f64, bool)> {
    let longest = NODES_PER_CHECK * step.unwrap_or(f64::INFINITY).abs();
    let mut all = Vec::with_capacity(times.len());
    let mut before = now;
    for &t in times {
        let stops = ((t - before).abs() / longest).floor();
        // times that are not finite are refused later
        if stops.is_finite() && stops < 1e7 {
            let mut stop = 1.0;
            while stop <= stops {
                all.push((before + (t - before) * (stop / (stops + 1.0)), false));
                stop += 1.0;
            }
        }
        all.push((t, true));
        before = t;
    }
    all
}

/// Takes nodes and events of a run.
struct EventWatcher<'w> {
    /// Takes a node, and returns whether to pause for a check for signals.
    take: &'w mut dyn FnMut(&dyn Run) -> bool,
    /// The events so far.
    found: &'w mut Vec<AnyOccurrence>,
}

impl AnyObserver for EventWatcher<'_> {
    fn node(&mut self, run: &dyn Run) -> ControlFlow<()> {
        if (self.take)(run) {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }

    fn event(&mut self, occurrence: &AnyOccurrence) -> ControlFlow<()> {
        self.found.push(occurrence.clone());
        ControlFlow::Continue(())
    }
}
