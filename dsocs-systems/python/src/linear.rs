//! Linear models and equilibria.

use dsocs_core::linear::{
    Equilibrium, EquilibriumError, EquilibriumSearch, LinearModel, LinearTime, LinearizationError,
    OperatingPoint, state_change,
};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::beginning::BeginningParts;
use crate::error::{exception, guarded, of_setup, plain};
use crate::text::{PyText, quantities};

/// The exception of a system that has no linear model at a state.
fn of_linearization(py: Python<'_>, error: &LinearizationError) -> PyErr {
    match error {
        LinearizationError::Setup(error) => of_setup(py, error),
        LinearizationError::Input { .. }
        | LinearizationError::Output { .. }
        | LinearizationError::Twice { .. } => plain(py, "SetupError", &error.to_string()),
        other => plain(py, "DerivativeError", &other.to_string()),
    }
}

/// The exception of a system that has no equilibrium.
fn of_equilibrium(py: Python<'_>, error: &EquilibriumError) -> PyErr {
    let q = match error {
        EquilibriumError::Setup(error) => return of_setup(py, error),
        EquilibriumError::Undefined { q, .. }
        | EquilibriumError::NotFound { q, .. }
        | EquilibriumError::Moving { q, .. }
        | EquilibriumError::TimeDependent { q, .. } => q.clone(),
        other => return plain(py, "SetupError", &other.to_string()),
    };
    let carried = PyDict::new(py);
    // this fails only without memory, and the message contains the position as well
    let _ = carried.set_item("q", q);
    exception(py, "EquilibriumError", &error.to_string(), &carried)
}

/// The rows, one after the other, as one array.
fn flat<'py>(py: Python<'py>, rows: &[Vec<f64>]) -> Bound<'py, PyArray1<f64>> {
    PyArray1::from_vec(py, rows.concat())
}

/// A model as a dict; each matrix as its numbers row by row.
fn model_dict<'py>(py: Python<'py>, model: &LinearModel) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    let point = model.point.any();
    dict.set_item(
        "step",
        match model.time {
            LinearTime::Continuous => None,
            LinearTime::Step { h } => Some(h),
        },
    )?;
    dict.set_item("t", point.t)?;
    for (name, vector) in [
        ("q", point.q),
        ("v", point.v),
        ("a", point.a),
        ("drift", &model.drift),
        ("measured", &model.measured),
    ] {
        dict.set_item(name, PyArray1::from_slice(py, vector))?;
    }
    for (name, of) in [
        ("states", &model.states),
        ("inputs", &model.inputs),
        ("outputs", &model.outputs),
    ] {
        dict.set_item(name, quantities(of))?;
    }
    for (name, rows) in [
        ("A", &model.a),
        ("B", &model.b),
        ("C", &model.c),
        ("D", &model.d),
        ("projection", &model.projection),
        ("basis", &model.basis),
        ("basis_after", &model.basis_after),
    ] {
        dict.set_item(name, flat(py, rows))?;
    }
    dict.set_item("eigenvalues", model.eigenvalues())?;
    Ok(dict)
}

/// The linear model at a state, of the continuous motion or of the step `h`.
#[pyfunction]
pub fn linearize<'py>(
    py: Python<'py>,
    text: &PyText,
    values: Vec<f64>,
    h: Option<f64>,
    beginning: BeginningParts,
    inputs: Option<Vec<String>>,
    outputs: Option<Vec<String>>,
) -> PyResult<Bound<'py, PyDict>> {
    let (system, beginning) = (text.kernel(&values), beginning.beginning()?);
    let model = py.detach(|| {
        guarded(|| {
            let mut point = OperatingPoint::new(&system, beginning.start());
            if let Some(names) = inputs {
                point = point.inputs(names);
            }
            if let Some(names) = outputs {
                point = point.outputs(names);
            }
            h.map_or_else(|| point.continuous(), |h| point.step(h))
        })
    })?;
    model_dict(py, &model.map_err(|error| of_linearization(py, &error))?)
}

/// The change from one state to another, each a position and a velocity; for a rotation, the rotation vector.
#[pyfunction(name = "state_change")]
pub fn change(
    py: Python<'_>,
    rotations: Vec<usize>,
    before: [Vec<f64>; 2],
    after: [Vec<f64>; 2],
) -> Bound<'_, PyArray1<f64>> {
    let [from, to] = [&before, &after].map(|[q, v]| [&q[..], &v[..]]);
    PyArray1::from_vec(py, state_change(&rotations, from, to))
}

/// An equilibrium as a dict.
fn equilibrium_dict<'py>(py: Python<'py>, found: &Equilibrium) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    for (name, vector) in [
        ("q", &found.q),
        ("parameters", &found.parameters),
        ("force", &found.force),
    ] {
        dict.set_item(name, PyArray1::from_slice(py, vector))?;
    }
    dict.set_item("directions", &found.directions)?;
    dict.set_item("held_by_friction", found.is_held_by_friction())?;
    dict.set_item("frozen", found.frozen_at.is_some())?;
    let eigenvalues = found.eigenvalues();
    dict.set_item("failure", eigenvalues.as_ref().err().map(ToString::to_string))?;
    dict.set_item("eigenvalues", eigenvalues.ok())?;
    dict.set_item(
        "stability",
        found.stability().ok().map(|stability| stability.to_string()),
    )?;
    Ok(dict)
}

/// Equilibria; and for each guess the index of its equilibrium or an exception.
type FoundEquilibria<'py> = (Vec<Bound<'py, PyDict>>, Vec<Bound<'py, PyAny>>);

/// The equilibria near some positions; and for each position the index of its equilibrium, or the exception
/// with the reason why there is none.
#[pyfunction]
pub fn equilibria<'py>(
    py: Python<'py>,
    text: &PyText,
    values: Vec<f64>,
    t: f64,
    guesses: Vec<Vec<f64>>,
    free: Vec<String>,
    held: Vec<String>,
) -> PyResult<FoundEquilibria<'py>> {
    let system = text.kernel(&values);
    let found = py.detach(|| {
        guarded(|| {
            EquilibriumSearch::new(&system)
                .at(t)
                .free(free)
                .held(held)
                .near_all(&guesses)
        })
    })?;
    let found = found.map_err(|error| of_equilibrium(py, &error))?;
    let places = found.of_guess.iter().map(|place| {
        Ok(match place {
            Ok(place) => place.into_pyobject(py)?.into_any(),
            Err(error) => of_equilibrium(py, error).into_value(py).into_bound(py).into_any(),
        })
    });
    let equilibria = found
        .equilibria
        .iter()
        .map(|found| equilibrium_dict(py, found))
        .collect::<PyResult<_>>()?;
    Ok((equilibria, places.collect::<PyResult<_>>()?))
}
