//! Errors of the library as exceptions of the package, which are written in Python (`dsocs._errors`).

use std::panic::{AssertUnwindSafe, catch_unwind};

use dsocs_core::text::TextError;
use dsocs_core::{DerivativeError, RunError, SetupError};
use dsocs_systems::entry::{CheckFailure, RunFailure};
use pyo3::exceptions::PyMemoryError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// What the library advises in Rust, and how it is said in Python. What is longer comes first.
const IN_RUST: [(&str, &str); 29] = [
    (
        "give the first two nodes, `Start::nodes(q0, q1)`: those of a flow are `flow.node().q` and `flow.position()`",
        "give the first two nodes, `q=` and `q1=`: those of a run are `run.q[0]` and `run.q[1]`",
    ),
    (
        "`Start::second_order(q0, v0)`, and `near_acceleration`",
        "`q=` and `v=`, and `near=`",
    ),
    (
        "the start was computed by `Start::exact`",
        "the start was computed",
    ),
    (" (`Start::second_order`)", " (`q=`, `v=`)"),
    (" (`Start::third_order(q0, v0, a0)`)", " (`a=`)"),
    (" (`Start::third_order_by_force(q0, v0, force)`)", " (`force=`)"),
    ("`Start::third_order`", "`q=`, `v=`, `a=`"),
    ("`Start::projected`", "`project=True`"),
    ("(Start::projected)", "(`project=True`)"),
    ("`Start::near_acceleration`", "`near=`"),
    ("`Start::nodes`", "`q=`, `q1=`"),
    ("`Start::paper`", "`start=\"paper\"`"),
    (", as by Start::second_order", ": `q=`, `v=`"),
    (" (Start::exact)", ""),
    (" (geometry::DiscreteFlow)", ""),
    (" (linear::OperatingPoint)", ""),
    (" (Path)", " (`path`)"),
    (" (Flow)", ""),
    ("`Flow::advance_to`", "`run.advance_to`"),
    (
        "(a negative step, or `reverse`, runs back in time)",
        "(a negative `h` runs back in time)",
    ),
    (
        "allow more, or a larger tolerance; if",
        "take a larger `tolerance=`; if",
    ),
    (
        "`Samples::monotone` or `Samples::cubic` for `Samples::linear`",
        "`monotone` or `cubic` for `linear`",
    ),
    ("; take a smaller h, Flow or", "; take a smaller h, `order=2` or"),
    ("(TaylorFlow)", "(`tolerance=`)"),
    ("::dsocs_core::Samples", "a table of samples"),
    // what the command line says
    ("`--step`", "`h`"),
    ("`--step ", "`h="),
    ("`--estimate-error`", "estimate_error()"),
    ("`--tolerance 1e-9`", "`tolerance=1e-9`"),
];

/// A message as it is said in Python.
pub fn in_python(message: &str) -> String {
    let said = |message: String, (rust, python): &(&str, &str)| message.replace(rust, python);
    IN_RUST.iter().fold(message.to_owned(), said)
}

/// An exception of the package with a message and what it carries.
pub fn exception(py: Python<'_>, class: &str, message: &str, carried: &Bound<'_, PyDict>) -> PyErr {
    let made = py
        .import("dsocs._errors")
        .and_then(|errors| errors.getattr(class))
        .and_then(|class| class.call((in_python(message),), Some(carried)));
    match made {
        Ok(exception) => PyErr::from_value(exception),
        Err(error) => error,
    }
}

/// An exception of the package that carries nothing.
pub fn plain(py: Python<'_>, class: &str, message: &str) -> PyErr {
    exception(py, class, message, &PyDict::new(py))
}

/// What an exception carries, in the order in which it is set.
fn carry<'py>(py: Python<'py>, set: impl FnOnce(&Bound<'py, PyDict>) -> PyResult<()>) -> Bound<'py, PyDict> {
    let carried = PyDict::new(py);
    // numbers and texts are always made; if there is no memory for them, the message says the same
    let _ = set(&carried);
    carried
}

/// That of a text that is no system.
pub fn of_text(py: Python<'_>, error: &TextError) -> PyErr {
    let TextError::Mistakes { mistakes, shown, .. } = error else {
        return plain(py, "DeclarationError", &error.to_string());
    };
    let carried = carry(py, |carried| {
        let places = mistakes.iter().map(|mistake| {
            (
                mistake.line,
                mistake.column,
                mistake.end_line,
                mistake.end_column,
                mistake.message.as_str(),
            )
        });
        carried.set_item("mistakes", places.collect::<Vec<_>>())
    });
    exception(py, "DeclarationError", shown, &carried)
}

/// That of a start, a step or a parameter that cannot be used.
pub fn of_setup(py: Python<'_>, error: &SetupError) -> PyErr {
    plain(py, "SetupError", &error.to_string())
}

/// That of a run.
pub fn of_run(py: Python<'_>, error: &RunError) -> PyErr {
    let class = match error {
        RunError::Setup(_)
        | RunError::Behind(_)
        | RunError::Until { .. }
        | RunError::Input(_)
        | RunError::OneWay(_) => return plain(py, "SetupError", &error.to_string()),
        _ => "StepError",
    };
    let carried = carry(py, |carried| {
        carried.set_item("time", error.time())?;
        if let Some(step) = error.failed_step() {
            carried.set_item("step", step.index)?;
            carried.set_item("h", step.h)?;
            carried.set_item("q0", step.q0.clone())?;
            carried.set_item("q1", step.q1.clone())?;
            carried.set_item("q2", step.q2.clone())?;
            carried.set_item("other", step.other.clone())?;
            carried.set_item("reason", step.cause.reason.to_string())?;
        } else if let RunError::Stage(stage) = error {
            carried.set_item("step", stage.details().index)?;
        }
        Ok(())
    });
    exception(py, class, &error.to_string(), &carried)
}

/// That of a run of the command line's entry.
pub fn of_failure(py: Python<'_>, failure: &RunFailure) -> PyErr {
    match failure {
        RunFailure::Setup(error) => of_setup(py, error),
        RunFailure::Run(error) => of_run(py, error),
        RunFailure::Estimate(error) => {
            let message = failure.to_string();
            let carried = carry(py, |carried| carried.set_item("time", error.time()));
            exception(py, "StepError", &message, &carried)
        }
        other => plain(py, "SetupError", &other.to_string()),
    }
}

/// That of a check that cannot be made.
pub fn of_check(py: Python<'_>, failure: &CheckFailure) -> PyErr {
    plain(py, "SetupError", &failure.to_string())
}

/// That of a run that has no derivative.
pub fn of_derivative(py: Python<'_>, error: &DerivativeError) -> PyErr {
    match error {
        DerivativeError::Run(error) => of_run(py, error),
        other => plain(py, "DerivativeError", &other.to_string()),
    }
}

/// That of a run that is too long for the memory.
pub fn no_memory() -> PyErr {
    PyMemoryError::new_err("there is no memory for so many nodes; `every=` keeps fewer of them")
}

/// Numbers for which there is room, or an error: an allocation that fails would end the process.
pub fn with_room(count: Option<usize>, what: &str) -> PyResult<Vec<f64>> {
    let mut numbers = Vec::new();
    let room = count.map(|count| numbers.try_reserve_exact(count));
    if matches!(room, Some(Ok(()))) {
        Ok(numbers)
    } else {
        Err(PyMemoryError::new_err(format!(
            "there is no memory for so many {what}; ask for some of them after others"
        )))
    }
}

/// Does something, and makes an error of a panic, which is a mistake of the library.
pub fn guarded<R>(work: impl FnOnce() -> R) -> Result<R, Panicked> {
    catch_unwind(AssertUnwindSafe(work)).map_err(|payload| {
        let told = payload.downcast_ref::<String>().map(String::as_str);
        let told = told.or_else(|| payload.downcast_ref::<&str>().copied());
        Panicked(told.unwrap_or("no more is known").to_owned())
    })
}

/// A mistake of the library.
pub struct Panicked(String);

impl From<Panicked> for PyErr {
    fn from(Panicked(told): Panicked) -> Self {
        Python::attach(|py| {
            let message = format!("a mistake of this library, not of yours; please tell its authors: {told}");
            plain(py, "Error", &message)
        })
    }
}
