//! A run that is controlled from Python.

use std::sync::{Arc, Mutex, TryLockError};

use dsocs_core::{AnyNode, AnyPoint, Declaration, End, LastLeg, OwnedNode, RunError, Stop};
use dsocs_systems::entry::Method;
use dsocs_systems::warnings::{Warnings, moved_start};
use numpy::PyReadonlyArrayDyn;
use pyo3::exceptions::{PyRuntimeError, PyTypeError};
use pyo3::prelude::*;

use crate::beginning::{BeginningParts, method};
use crate::control::Controller;
use crate::error::{guarded, in_python, of_run, of_setup};
use crate::motion::{Motion, Reached};
use crate::node::{Names, PyNode};
use crate::record::{Column, Record};
use crate::text::PyText;

/// A change of an input.
#[derive(Clone, Copy)]
struct Change {
    /// The node at which the run stood.
    index: u64,
    /// The time from which on the value holds: that of the last known position.
    time: f64,
    /// The index of the parameter.
    place: usize,
    /// The value.
    value: f64,
}

/// The state of a run.
pub(crate) struct State {
    /// The run.
    pub(crate) motion: Motion,
    /// The nodes.
    pub(crate) record: Record,
    /// The observed expressions at the kept nodes, computed on first use.
    observed: Derived,
    /// The multipliers at the kept nodes, computed on first use.
    multipliers: Derived,
    /// The changes of inputs.
    changes: Vec<Change>,
    /// The motion up to the node where events were last watched.
    pub(crate) leg: LastLeg,
    /// The method and the step.
    method: Method,
    h: f64,
    /// The warning about a start that was projected far onto the constraints.
    moved: Option<String>,
}

/// Values that are computed from the kept nodes on request.
struct Derived {
    /// The values.
    column: Column,
    /// The number of nodes at which they were computed.
    rows: usize,
}

impl Derived {
    /// No values yet; each node will have `width` numbers.
    fn new(width: usize) -> Self {
        Self {
            column: Column::new(width),
            rows: 0,
        }
    }
}

/// A run that is controlled from Python: the engine of the Python class `Run`.
#[pyclass(frozen, name = "RawRun", module = "dsocs._dsocs")]
pub struct PyRun {
    /// Its state. Only one thread at a time may use it; another one gets an error and does not wait.
    state: Mutex<State>,
    /// The names of the coordinates.
    pub(crate) names: Arc<Names>,
    /// The distance of two kept nodes, in nodes.
    #[pyo3(get)]
    every: u64,
}

impl PyRun {
    /// Calls a function with the state, unless another thread is using it.
    pub(crate) fn with<R>(&self, work: impl FnOnce(&mut State) -> PyResult<R>) -> PyResult<R> {
        match self.state.try_lock() {
            Ok(mut state) => work(&mut state),
            Err(TryLockError::Poisoned(poisoned)) => work(&mut poisoned.into_inner()),
            Err(TryLockError::WouldBlock) => Err(PyRuntimeError::new_err(
                "this run is at work: in another thread, or in the function that it calls between steps; a copy of it (`copy.copy`) is not",
            )),
        }
    }
}

impl State {
    /// An infinite end, in the direction of the run.
    fn forever(&self) -> Result<End, RunError> {
        self.motion.look(|run| {
            let forward = run.clock().is_forward();
            run.clock()
                .until(if forward { f64::INFINITY } else { f64::NEG_INFINITY })
        })
    }

    /// The current node.
    pub(crate) fn node(&self) -> OwnedNode {
        let mut node = OwnedNode::new(self.motion.dimension());
        self.motion.look(|run| node.take(run));
        node
    }

    /// The current node for Python.
    pub(crate) fn py_node(&self, names: &Arc<Names>) -> PyNode {
        let values = self.motion.look(|run| {
            let at_node = run.arriving_values().iter();
            at_node.chain(run.values()).copied().collect()
        });
        PyNode::new(self.node(), names, values)
    }

    /// Sets an input to another value.
    pub(crate) fn set(&mut self, parameter: &str, value: f64) -> Result<(), RunError> {
        let parameters = &self.motion.system().shape().parameters;
        let place = parameters.iter().position(|known| known.name == parameter);
        let ahead = u64::from(self.motion.is_ahead());
        let (changes, warnings) = (&mut self.changes, &mut self.record.warnings);
        self.motion.with(|run| {
            let before = place.and_then(|place| run.values().get(place).copied());
            let arriving = (!warnings.is_driven()).then(|| run.arriving_values().to_vec());
            run.set_input(parameter, value)?;
            if let Some(place) = place.filter(|_| before != Some(value)) {
                if let Some(arriving) = arriving {
                    warnings.drive(&arriving);
                }
                let clock = run.clock();
                let index = clock.index();
                let time = if ahead == 0 {
                    clock.time()
                } else {
                    clock.time_of(index + ahead)
                };
                changes.push(Change {
                    index,
                    time,
                    place,
                    value,
                });
            }
            Ok(())
        })
    }

    /// Computes the derived values at the kept nodes that have none yet.
    fn derive(
        &mut self,
        py: Python<'_>,
        which: fn(&mut Self) -> &mut Derived,
        compute: impl Fn(&Declaration<'_>, &AnyNode<'_>) -> Vec<f64>,
    ) -> PyResult<()> {
        let (from, rows) = (which(self).rows, self.record.rows());
        let mut derived = Vec::new();
        self.look_at_nodes(py, from, &mut |declaration, node| {
            derived.extend(compute(declaration, node));
        })?;
        let to = which(self);
        to.column.extend(&derived);
        to.rows = rows;
        Ok(())
    }

    /// Passes on the kept nodes, from one on, each with the declaration at its values of the parameters.
    fn look_at_nodes(
        &mut self,
        py: Python<'_>,
        from: usize,
        look: &mut dyn FnMut(&Declaration<'_>, &AnyNode<'_>),
    ) -> PyResult<()> {
        let (n, rows) = (self.motion.dimension(), self.record.rows());
        if from == rows {
            return Ok(());
        }
        let arrays = [0, 1, 2, 3, 4, 5].map(|place| self.record.array(py, place));
        let mut numbers: Vec<PyReadonlyArrayDyn<'_, f64>> = Vec::with_capacity(arrays.len());
        for array in arrays {
            numbers.push(array?.extract()?);
        }
        let mut slices: Vec<&[f64]> = Vec::with_capacity(numbers.len());
        for numbers in &numbers {
            slices.push(numbers.as_slice()?);
        }
        let [t, q, v, a, force, energy] = slices[..] else {
            return Ok(());
        };
        let system = self.motion.system();
        let mut values = self.first_values();
        let mut changes = self.changes.iter().peekable();
        let (every, ahead) = (self.record.every(), u64::from(self.motion.is_ahead()));
        for row in 0..rows {
            // with the values just before the node, as on the command line
            let index = row as u64 * every;
            while let Some(change) = changes.next_if(|change| change.index + ahead < index) {
                if let Some(value) = values.get_mut(change.place) {
                    *value = change.value;
                }
            }
            if row < from {
                continue;
            }
            let of = |vector| -> &[f64] {
                let vector: &[f64] = vector;
                &vector[n * row..n * (row + 1)]
            };
            let node = AnyNode {
                index,
                t: t[row],
                q: of(q),
                v: of(v),
                a: of(a),
                force: of(force),
                energy: energy[row],
                iterations: 0,
                stop: Stop::Start,
            };
            look(&Declaration::of(system).with(&values), &node);
        }
        Ok(())
    }

    /// The values of the parameters at the start.
    fn first_values(&self) -> Vec<f64> {
        let system = self.motion.system();
        let places = 0..system.shape().parameters.len();
        places.map(|place| system.value(place)).collect()
    }
}

#[pymethods]
impl PyRun {
    /// Sets up a run.
    #[new]
    #[pyo3(signature = (text, values, h, order, tolerance, beginning, every))]
    fn new(
        py: Python<'_>,
        text: &PyText,
        values: Vec<f64>,
        h: f64,
        order: u32,
        tolerance: Option<f64>,
        beginning: BeginningParts,
        every: u64,
    ) -> PyResult<Self> {
        let (method, beginning) = (method(order, tolerance)?, beginning.beginning()?);
        let system = text.kernel(&values);
        let begun = py.detach(|| guarded(|| Motion::begin(system, h, method, &beginning)))?;
        let motion = begun.map_err(|error| of_setup(py, &error))?;
        let shape = motion.system().shape();
        let names = Names::of(shape, motion.kernel());
        let (observed, forms) = (shape.observables.len(), shape.forms);
        let warnings = Warnings::of(method, shape);
        let mut state = State {
            record: Record::new(motion.dimension(), every, warnings),
            observed: Derived::new(observed),
            multipliers: Derived::new(forms),
            changes: Vec::new(),
            leg: LastLeg::default(),
            method,
            h,
            moved: None,
            motion,
        };
        // the first node of a run is its start
        let begun = state.forever().and_then(|end| {
            let State { motion, record, .. } = &mut state;
            motion.next(&end, record)
        });
        begun.map_err(|error| of_run(py, &error))?;
        let mut first = OwnedNode::new(state.motion.dimension());
        state.motion.look(|run| first.take(run));
        state.moved = moved_start(&beginning, state.motion.system().shape(), first.any().q);
        let state = Mutex::new(state);
        Ok(Self { state, names, every })
    }

    /// Runs up to the last node at or before a time. `progress` is called with the time reached. `control` is
    /// a function that is called with each node (or every so many of them) and returns the inputs from there
    /// on, with that number, and with a function for the elements of arrays.
    #[pyo3(signature = (t, progress, control))]
    fn until(
        &self,
        py: Python<'_>,
        t: f64,
        progress: Option<Bound<'_, PyAny>>,
        control: Option<(Bound<'_, PyAny>, u64, Bound<'_, PyAny>)>,
    ) -> PyResult<()> {
        let control = control.map(|(control, every, elements)| Controller {
            control,
            every,
            elements,
        });
        self.with(|state| {
            let end = state.motion.look(|run| run.clock().until(t));
            let end = end.map_err(|error| of_run(py, &error))?;
            if !t.is_finite() && control.is_none() {
                return Err(of_run(py, &RunError::Until { until: t }));
            }
            if let Some(step) = state.motion.look(|run| run.clock().step())
                && t.is_finite()
            {
                let now = state.motion.look(|run| run.clock().time());
                #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // saturates
                state
                    .record
                    .reserve((((t - now) / step).abs() as u64).saturating_add(1))?;
            }
            loop {
                let reached = match &control {
                    None => py.detach(|| guarded(|| state.motion.go(&end, &mut state.record)))?,
                    Some(control) => control.run(state, &end, &self.names)?,
                };
                let now = state.motion.look(|run| run.clock().time());
                if let Some(progress) = &progress {
                    progress.call1((now,))?;
                }
                match reached.map_err(|error| of_run(py, &error))? {
                    Reached::End => return Ok(()),
                    Reached::OnTheWay => py.check_signals()?,
                }
            }
        })
    }

    /// Makes some steps; if a time is given, at most to the end of a run to this time.
    #[pyo3(signature = (steps, toward))]
    fn advance(&self, py: Python<'_>, steps: u64, toward: Option<f64>) -> PyResult<()> {
        self.with(|state| {
            let end = match toward {
                Some(t) => state.motion.look(|run| run.clock().until(t)),
                None => state.forever(),
            };
            let end = end.map_err(|error| of_run(py, &error))?;
            let mut left = steps;
            while left > 0 {
                let some = left.min(256);
                left -= some;
                let made = py.detach(|| {
                    guarded(|| {
                        for _ in 0..some {
                            state.motion.next(&end, &mut state.record)?;
                        }
                        Ok(())
                    })
                })?;
                made.map_err(|error: RunError| of_run(py, &error))?;
                py.check_signals()?;
            }
            Ok(())
        })
    }

    /// Makes the next step of a run to a time; `None` at the end.
    fn next(&self, py: Python<'_>, toward: f64) -> PyResult<Option<PyNode>> {
        self.with(|state| {
            let end = state.motion.look(|run| run.clock().until(toward));
            let end = end.map_err(|error| of_run(py, &error))?;
            let made = guarded(|| state.motion.next(&end, &mut state.record))?;
            let goes = made.map_err(|error| of_run(py, &error))?;
            Ok(goes.then(|| state.py_node(&self.names)))
        })
    }

    /// Sets an input to another value, from the last known position on.
    fn set_input(&self, py: Python<'_>, parameter: &str, value: f64) -> PyResult<()> {
        self.with(|state| {
            let set = guarded(|| state.set(parameter, value))?;
            set.map_err(|error| of_run(py, &error))
        })
    }

    /// The value of an input.
    fn input(&self, parameter: &str) -> PyResult<Option<f64>> {
        self.with(|state| Ok(state.motion.look(|run| run.input(parameter))))
    }

    /// The changes of inputs: the number of the node at which the run stood, the time from which on the value
    /// holds, the index of the parameter, the value.
    fn changes(&self) -> PyResult<Vec<(u64, f64, usize, f64)>> {
        self.with(|state| {
            let changes = state.changes.iter();
            let changes = changes.map(|change| (change.index, change.time, change.place, change.value));
            Ok(changes.collect())
        })
    }

    /// The number of changes of inputs.
    fn change_count(&self) -> PyResult<usize> {
        self.with(|state| Ok(state.changes.len()))
    }

    /// The current node.
    fn node(&self) -> PyResult<PyNode> {
        self.with(|state| Ok(state.py_node(&self.names)))
    }

    /// A kept node, by its index among them.
    fn kept(&self, py: Python<'_>, row: usize) -> PyResult<PyNode> {
        self.with(|state| {
            let n = state.motion.dimension();
            let mut numbers = Vec::with_capacity(Record::NAMES.len());
            for place in 0..Record::NAMES.len() {
                let column = state.record.array(py, place)?.get_item(row)?;
                let row: Vec<f64> = match column.extract::<f64>() {
                    Ok(number) if place == 0 || place == 5 => vec![number],
                    _ => column.extract()?,
                };
                numbers.push(row);
            }
            let [t, q, v, a, force, energy] = &numbers[..] else {
                return Ok(PyNode::new(OwnedNode::new(n), &self.names, Vec::new()));
            };
            let index = row as u64 * self.every;
            let ahead = u64::from(state.motion.is_ahead());
            let (mut at_node, mut from_there) = (state.first_values(), state.first_values());
            for change in &state.changes {
                if change.index + ahead < index {
                    at_node[change.place] = change.value;
                }
                if change.index <= index {
                    from_there[change.place] = change.value;
                }
            }
            at_node.extend(from_there);
            let node = AnyNode {
                index,
                t: t[0],
                q,
                v,
                a,
                force,
                energy: energy[0],
                iterations: 0,
                stop: Stop::Start,
            };
            Ok(PyNode::new(OwnedNode::of(&node), &self.names, at_node))
        })
    }

    /// The number of the current node.
    fn index(&self) -> PyResult<u64> {
        self.with(|state| Ok(state.motion.look(|run| run.clock().index())))
    }

    /// The array of a column: `t`, `q`, `v`, `a`, `force`, `energy`, `observed`, `multipliers`.
    fn array<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        self.with(|state| match name {
            "observed" => {
                state.derive(
                    py,
                    |state| &mut state.observed,
                    |declaration, node| {
                        let AnyPoint { t, q, v, a } = node.point();
                        let mut values = vec![0.0; declaration.shape().observables.len()];
                        declaration.observe(AnyPoint { t, q, v, a }, &mut values);
                        values
                    },
                )?;
                state.derived(py, |state| &mut state.observed)
            }
            "multipliers" => {
                state.derive(
                    py,
                    |state| &mut state.multipliers,
                    |declaration, node| declaration.multipliers(node),
                )?;
                state.derived(py, |state| &mut state.multipliers)
            }
            _ => {
                let place = Record::NAMES.iter().position(|known| *known == name);
                let place = place.ok_or_else(|| PyTypeError::new_err("no such column"))?;
                state.record.array(py, place)
            }
        })
    }

    /// Steps that did not resolve a jump: their number, the time of the first, the largest departure, and its time.
    fn unresolved(&self) -> PyResult<Option<(u64, f64, f64, f64)>> {
        self.with(|state| {
            let found = state.motion.look(|run| run.unresolved());
            Ok(found.map(|found| (found.steps, found.first, found.largest, found.largest_at)))
        })
    }

    /// Steps in which the equations were nearly singular: their number, the time of the first, and the number
    /// of those in which only the equations of the step were.
    fn nearly_singular(&self) -> PyResult<Option<(u64, f64, u64)>> {
        self.with(|state| {
            let found = state.motion.look(|run| run.nearly_singular());
            Ok(found.map(|found| (found.steps, found.first, found.of_step)))
        })
    }

    /// The warnings about the nodes so far: on the energy, on bodies that rotate too far, on coordinates that
    /// alternate, on constraints that nearly depend on each other, on inputs that are masses, and on a start that was projected far.
    fn warnings(&self) -> PyResult<[Option<String>; 6]> {
        self.with(|state| {
            let coordinates = &state.motion.system().shape().coordinates;
            let names: Vec<&str> = coordinates.iter().map(|of| &*of.name).collect();
            let [energy, turns, alternation, dependence, masses] =
                state.record.warnings.notes(&names, state.method, state.h);
            let notes = [
                energy,
                turns,
                alternation,
                dependence,
                masses,
                state.moved.clone(),
            ];
            Ok(notes.map(|note| note.map(|note| in_python(note.trim_start_matches("warning: ")))))
        })
    }

    fn __len__(&self) -> PyResult<usize> {
        self.with(|state| Ok(state.record.rows()))
    }
}

impl State {
    /// The array of derived values.
    fn derived<'py>(
        &mut self,
        py: Python<'py>,
        which: fn(&mut Self) -> &mut Derived,
    ) -> PyResult<Bound<'py, PyAny>> {
        let rows = self.record.rows();
        let derived = which(self);
        if derived.column.is_empty_row() {
            return Ok(numpy::PyArray2::<f64>::zeros(py, [rows, 0], false).into_any());
        }
        derived.column.array(py, false)
    }
}
