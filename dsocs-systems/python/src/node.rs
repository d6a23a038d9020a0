//! One node of a run.

use std::ops::Range;
use std::sync::Arc;

use dsocs_core::{AnyNode, OwnedNode, Shape};
use numpy::PyArray1;
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::PyFloat;

/// The names of the coordinates.
pub struct Names {
    /// Each by its place.
    names: Vec<String>,
    /// Where the rotations begin.
    rotations: Vec<usize>,
}

impl Names {
    /// Those of a system.
    pub fn of(shape: &Shape) -> Arc<Self> {
        let names = shape.coordinates.iter().map(|of| of.name.to_string());
        Arc::new(Self {
            names: names.collect(),
            rotations: shape.rotations.to_vec(),
        })
    }

    /// The place of a coordinate.
    fn place(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|known| known == name)
    }

    /// The places of an array or of a rotation. Of what is `moving`, a velocity, a rotation has three numbers.
    fn places(&self, name: &str, moving: bool) -> Option<Range<usize>> {
        let is_of = |known: &str, end: &str| known.strip_suffix(end) == Some(name);
        let turns = |first: &&usize| self.names.get(**first).is_some_and(|known| is_of(known, "_w"));
        if let Some(&first) = self.rotations.iter().find(turns) {
            return Some(first + usize::from(moving)..first + 4);
        }
        let first = self.names.iter().position(|known| is_of(known, "_0"))?;
        let others = self.names[first..].iter().zip(0..);
        let count = others.take_while(|(known, place): &(_, usize)| is_of(known, &format!("_{place}")));
        Some(first..first + count.count())
    }
}

/// A node of a run: its number, time, position, velocity, acceleration, constraint force and energy.
///
/// `node["theta"]` is a coordinate by its name, `node["v_theta"]`, `node["a_theta"]` and `node["force_theta"]` what belongs to it. Where the name is that of
/// an array or of a rotation, `node["x"]` and `node["v_x"]` are arrays; of a rotation `r`, `node["r"]` has four numbers, `node["v_r"]` three.
#[pyclass(frozen, name = "Node", module = "dsocs")]
pub struct PyNode {
    /// Its numbers.
    node: OwnedNode,
    /// The names of the coordinates.
    names: Arc<Names>,
}

impl PyNode {
    /// A node with the names of its coordinates.
    pub fn new(node: OwnedNode, names: &Arc<Names>) -> Self {
        let names = Arc::clone(names);
        Self { node, names }
    }

    /// The parts of a node in which there may be something of a name: what it is called there, the vector, and whether it is other than the position.
    fn parts<'n, 'a>(&'n self, name: &'a str) -> impl Iterator<Item = (&'a str, &'n [f64], bool)> {
        let AnyNode { q, v, a, force, .. } = self.node.any();
        let parts = [("", q), ("v_", v), ("a_", a), ("force_", force)].into_iter();
        parts.filter_map(move |(prefix, vector)| {
            Some((name.strip_prefix(prefix)?, vector, !prefix.is_empty()))
        })
    }

    /// The number of a name.
    fn number(&self, name: &str) -> Option<f64> {
        match name {
            "t" => Some(self.node.any().t),
            "energy" => Some(self.node.any().energy),
            _ => self
                .parts(name)
                .find_map(|(name, vector, _)| vector.get(self.names.place(name)?).copied()),
        }
    }

    /// The numbers of the name of several.
    fn numbers(&self, name: &str) -> Option<&[f64]> {
        self.parts(name)
            .find_map(|(name, vector, moving)| vector.get(self.names.places(name, moving)?))
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

    fn __getitem__<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        if let Some(number) = self.number(name) {
            return Ok(PyFloat::new(py, number).into_any());
        }
        if let Some(numbers) = self.numbers(name) {
            return Ok(PyArray1::from_slice(py, numbers).into_any());
        }
        let known = self.names.names.join(", ");
        let message = format!("a node has no `{name}`; its coordinates are {known}");
        Err(PyKeyError::new_err(message))
    }

    fn __repr__(&self) -> String {
        let AnyNode { index, t, q, v, .. } = self.node.any();
        let of = |prefix: &str, vector: &[f64]| {
            let pairs = self.names.names.iter().zip(vector);
            let parts = pairs.map(|(name, x)| format!("{prefix}{name}={x}"));
            parts.collect::<Vec<_>>().join(", ")
        };
        format!("Node({index}, t={t}, {}, {})", of("", q), of("v_", v))
    }
}
