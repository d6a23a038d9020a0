//! Errors of the library as exceptions of the package, which are written in Python (`dsocs._errors`).

use std::panic::{AssertUnwindSafe, catch_unwind};

use dsocs_core::text::TextError;
use dsocs_core::{DerivativeError, RunError, SetupError};
use dsocs_systems::entry::{CheckFailure, RunFailure};
use pyo3::exceptions::PyMemoryError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Advice in terms of Rust, and in terms of Python. Longer texts come first, so that they are replaced before
/// their parts.
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
    // options of the command line
    ("`--step`", "`h`"),
    ("`--step ", "`h="),
    ("`--estimate-error`", "estimate_error()"),
    ("(`TaylorFlow`, `--tolerance`)", "(`tolerance=`)"),
];

/// A message with its advice in terms of Python.
pub fn in_python(message: &str) -> String {
    let said = |message: String, (rust, python): &(&str, &str)| message.replace(rust, python);
    let message = IN_RUST.iter().fold(message.to_owned(), said);
    // an option of the command line that is left is an argument of the same name: `--order 2`, `--until`
    let mut parts = message.split("`--");
    let first = parts.next().unwrap_or_default().to_owned();
    let rest = parts.map(|part| {
        let (option, after) = part.split_once('`').unwrap_or((part, ""));
        let (name, value) = option.split_once(' ').unwrap_or((option, ""));
        format!("`{}={value}`{after}", name.replace('-', "_"))
    });
    std::iter::once(first).chain(rest).collect()
}

/// An exception of the package with a message and attributes.
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

/// An exception of the package without attributes.
pub fn plain(py: Python<'_>, class: &str, message: &str) -> PyErr {
    exception(py, class, message, &PyDict::new(py))
}

/// The attributes of an exception, in the order in which they are set.
fn carry<'py>(py: Python<'py>, set: impl FnOnce(&Bound<'py, PyDict>) -> PyResult<()>) -> Bound<'py, PyDict> {
    let carried = PyDict::new(py);
    // this fails only without memory, and the message contains the attributes as well
    let _ = set(&carried);
    carried
}

/// The exception for a text that is not a system.
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

/// The exception for a start, a step or a parameter that cannot be used.
pub fn of_setup(py: Python<'_>, error: &SetupError) -> PyErr {
    plain(py, "SetupError", &error.to_string())
}

/// The exception for an error of a run.
pub fn of_run(py: Python<'_>, error: &RunError) -> PyErr {
    let class = match error {
        RunError::Setup(_)
        | RunError::TimeBehind(_)
        | RunError::Until { .. }
        | RunError::Input(_)
        | RunError::NotReversible(_) => return plain(py, "SetupError", &error.to_string()),
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

/// The exception for an error of a run by an entry of the command line.
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

/// The exception for a check that cannot be made.
pub fn of_check(py: Python<'_>, failure: &CheckFailure) -> PyErr {
    plain(py, "SetupError", &failure.to_string())
}

/// The exception for a run that has no derivative.
pub fn of_derivative(py: Python<'_>, error: &DerivativeError) -> PyErr {
    match error {
        DerivativeError::Run(error) => of_run(py, error),
        other => plain(py, "DerivativeError", &other.to_string()),
    }
}

/// At a step in about a microsecond, these are days.
const MANY_NODES: u64 = 200_000_000_000;

/// The exception for a run of this many nodes that does not fit into memory.
pub fn no_memory(nodes: u64) -> PyErr {
    let hint = if nodes < MANY_NODES {
        ""
    } else {
        ", but so many steps take days: a longer `h=` makes fewer"
    };
    PyMemoryError::new_err(format!(
        "there is no memory for so many nodes; `every=` keeps fewer of them{hint}"
    ))
}

/// An empty vector with room for `count` numbers, or an error: an allocation that fails would end the
/// process.
pub fn with_workspace(count: Option<usize>, what: &str) -> PyResult<Vec<f64>> {
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

/// Calls a function, and turns a panic, which is a mistake of the library, into an error.
pub fn guarded<R>(work: impl FnOnce() -> R) -> Result<R, Panicked> {
    catch_unwind(AssertUnwindSafe(work)).map_err(|payload| {
        let message = payload.downcast_ref::<String>().map(String::as_str);
        let message = message.or_else(|| payload.downcast_ref::<&str>().copied());
        Panicked(message.unwrap_or("no more is known").to_owned())
    })
}

/// A panic of the library, with its message.
pub struct Panicked(String);

impl From<Panicked> for PyErr {
    fn from(Panicked(message): Panicked) -> Self {
        Python::attach(|py| {
            let message =
                format!("a mistake of this library, not of yours; please tell its authors: {message}");
            plain(py, "Error", &message)
        })
    }
}
