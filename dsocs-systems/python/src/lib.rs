//! The engine of the Python package `dsocs`, on which its Python files are built. Users see `dsocs`, not this
//! module.
//!
//! Long computations run without Python's lock, and check for signals every 30 ms.

mod beginning;
mod control;
mod dense;
mod ensemble;
mod error;
mod linear;
mod many;
mod motion;
mod node;
mod path;
mod record;
mod results;
mod run;
mod text;

/// The engine.
#[pyo3::pymodule]
mod _dsocs {
    use pyo3::prelude::*;

    #[pymodule_export]
    use crate::dense::{advance_to, roots, sample, watch};
    #[pymodule_export]
    use crate::ensemble::ensemble;
    #[pymodule_export]
    use crate::linear::{change, equilibria, linearize};
    #[pymodule_export]
    use crate::node::{PyNode, node_of};
    #[pymodule_export]
    use crate::path::PyPath;
    #[pymodule_export]
    use crate::results::{certify, check, estimate, page, program, samples};
    #[pymodule_export]
    use crate::run::PyRun;
    #[pymodule_export]
    use crate::text::PyText;

    /// Sets the version of the module.
    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
