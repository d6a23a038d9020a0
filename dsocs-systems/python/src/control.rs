//! A controller: a function of Python that is called with nodes, and returns the inputs from there on.

use std::sync::Arc;

use dsocs_core::{End, RunError};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};

use crate::error::guarded;
use crate::motion::{Reached, has_reached};
use crate::node::Names;
use crate::run::State;

/// A controller.
pub struct Controller<'py> {
    /// The function.
    pub control: Bound<'py, PyAny>,
    /// The distance, in nodes, of its calls.
    pub every: u64,
    /// Splits an array that is given by its own name into its elements, `name, value -> [(element, number)]`;
    /// raises for a value that does not fit.
    pub elements: Bound<'py, PyAny>,
}

impl Controller<'_> {
    /// Makes steps towards an end, and calls the function.
    pub(crate) fn run(
        &self,
        state: &mut State,
        end: &End,
        names: &Arc<Names>,
    ) -> PyResult<Result<Reached, RunError>> {
        for _ in 0..1024 {
            if state.motion.look(|run| has_reached(run, end)) {
                return Ok(Ok(Reached::End));
            }
            let index = state.motion.look(|run| run.clock().index());
            if index.is_multiple_of(self.every) {
                let inputs = self.control.call1((state.py_node(names),))?;
                if let Err(error) = self.set(state, &inputs)? {
                    return Ok(Err(error));
                }
            }
            let made = guarded(|| state.motion.next(end, &mut state.record))?;
            match made {
                Ok(true) => {}
                Ok(false) => return Ok(Ok(Reached::End)),
                Err(error) => return Ok(Err(error)),
            }
        }
        Ok(Ok(Reached::OnTheWay))
    }

    /// Sets the inputs to the values that the function returned.
    fn set(&self, state: &mut State, inputs: &Bound<'_, PyAny>) -> PyResult<Result<(), RunError>> {
        if inputs.is_none() {
            return Ok(Ok(()));
        }
        let Ok(inputs) = inputs.cast::<PyDict>() else {
            return Err(PyTypeError::new_err(format!(
                "control returned {}; expected a dict with the values of inputs by name, or None",
                inputs.get_type().name()?
            )));
        };
        for (parameter, value) in inputs {
            let name = parameter.cast::<PyString>()?.to_str()?;
            let parameters = &state.motion.system().shape().parameters;
            let is_number = parameters.iter().any(|known| known.name == name);
            if is_number && let Ok(value) = value.extract() {
                if let Err(error) = state.set(name, value) {
                    return Ok(Err(error));
                }
                continue;
            }
            let elements: Vec<(String, f64)> = self.elements.call1((name, value))?.extract()?;
            for (element, value) in elements {
                if let Err(error) = state.set(&element, value) {
                    return Ok(Err(error));
                }
            }
        }
        Ok(Ok(()))
    }
}
