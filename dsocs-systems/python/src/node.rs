//! One node of a run.

use std::sync::Arc;

use dsocs_core::{AnyNode, OwnedNode};
use numpy::PyArray1;
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;

/// A node of a run: its number, time, position, velocity, acceleration, constraint force and energy.
///
/// `node["theta"]` is a coordinate by its name, `node["v_theta"]`, `node["a_theta"]` and `node["force_theta"]` what belongs to it.
#[pyclass(frozen, name = "Node", module = "dsocs")]
pub struct PyNode {
    /// Its numbers.
    node: OwnedNode,
    /// The names of the coordinates.
    names: Arc<[String]>,
}

impl PyNode {
    /// A node with the names of its coordinates.
    pub fn new(node: OwnedNode, names: &Arc<[String]>) -> Self {
        let names = Arc::clone(names);
        Self { node, names }
    }

    /// The number of a name.
    fn by_name(&self, name: &str) -> Option<f64> {
        let node = self.node.any();
        let of = |vector: &[f64], name: &str| {
            let place = self.names.iter().position(|known| known == name)?;
            vector.get(place).copied()
        };
        let part = |prefix, vector| name.strip_prefix(prefix).and_then(|name| of(vector, name));
        match name {
            "t" => Some(node.t),
            "energy" => Some(node.energy),
            _ => of(node.q, name)
                .or_else(|| part("v_", node.v))
                .or_else(|| part("a_", node.a))
                .or_else(|| part("force_", node.force)),
        }
    }
}

#[pymethods]
impl PyNode {
    /// The number of the node; 0 is the start.
    #[getter]
    fn index(&self) -> u64 {
        self.node.any().index
    }

    /// The time.
    #[getter]
    fn t(&self) -> f64 {
        self.node.any().t
    }

    /// The position, an array with a number for each coordinate.
    #[getter]
    fn q<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, self.node.any().q)
    }

    /// The velocity, an array with a number for each coordinate.
    #[getter]
    fn v<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, self.node.any().v)
    }

    /// The acceleration, an array with a number for each coordinate.
    #[getter]
    fn a<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, self.node.any().a)
    }

    /// The generalized constraint force, an array with a number for each coordinate.
    #[getter]
    fn force<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, self.node.any().force)
    }

    /// The energy.
    #[getter]
    fn energy(&self) -> f64 {
        self.node.any().energy
    }

    fn __getitem__(&self, name: &str) -> PyResult<f64> {
        self.by_name(name).ok_or_else(|| {
            let known = self.names.join(", ");
            PyKeyError::new_err(format!("a node has no `{name}`; its coordinates are {known}"))
        })
    }

    fn __repr__(&self) -> String {
        let AnyNode { index, t, q, v, .. } = self.node.any();
        let of = |prefix: &str, vector: &[f64]| {
            let pairs = self.names.iter().zip(vector);
            let parts = pairs.map(|(name, x)| format!("{prefix}{name}={x}"));
            parts.collect::<Vec<_>>().join(", ")
        };
        format!("Node({index}, t={t}, {}, {})", of("", q), of("v_", v))
    }
}
