//! One node of a run.

use std::ops::Range;
use std::sync::{Arc, OnceLock};

use dsocs_core::text::TapeKernel;
use dsocs_core::{AnyNode, Declaration, OwnedNode, Quantity, Shape, Stop};
use numpy::PyArray1;
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::PyFloat;

/// The names of the quantities at a node.
pub struct Names {
    /// The names of the coordinates, in their order.
    coordinates: Vec<String>,
    /// The index of the first number of each rotation.
    rotations: Vec<usize>,
    /// The names of the observed expressions.
    observables: Vec<String>,
    /// The names of the parameters.
    parameters: Vec<String>,
    /// The number of multipliers of the constraint forces.
    forms: usize,
    /// The system, which computes the observed expressions and the multipliers; a node that was pickled has
    /// their values instead.
    kernel: Option<TapeKernel>,
}

impl Names {
    /// The names of a system.
    pub fn of(shape: &Shape, kernel: &TapeKernel) -> Arc<Self> {
        let names = |of: &[Quantity]| of.iter().map(|of| of.name.to_string()).collect();
        Arc::new(Self {
            coordinates: names(&shape.coordinates),
            rotations: shape.rotations.to_vec(),
            observables: names(&shape.observables),
            parameters: names(&shape.parameters),
            forms: shape.forms,
            kernel: Some(kernel.clone()),
        })
    }

    /// All names that a node knows, for messages.
    fn all(&self) -> String {
        let mut known = vec!["t".to_owned(), "energy".to_owned()];
        known.extend(self.coordinates.iter().cloned());
        for prefix in ["v_", "a_", "force_"] {
            let moving = (0..)
                .zip(&self.coordinates)
                .filter(|(place, _)| !self.rotations.contains(place));
            known.extend(moving.map(|(_, name)| format!("{prefix}{name}")));
        }
        known.extend(self.observables.iter().cloned());
        known.extend((0..self.forms).map(|form| format!("lambda_{form}")));
        known.extend(self.parameters.iter().cloned());
        known.join(", ")
    }

    /// The index of a coordinate.
    fn place(&self, name: &str) -> Option<usize> {
        self.coordinates.iter().position(|known| known == name)
    }

    /// The range of an array or of a rotation. For a `moving` quantity (a velocity, acceleration or force) a
    /// rotation has three numbers.
    fn places(&self, name: &str, moving: bool) -> Option<Range<usize>> {
        let is_of = |known: &str, end: &str| known.strip_suffix(end) == Some(name);
        let turns = |first: &&usize| {
            self.coordinates
                .get(**first)
                .is_some_and(|known| is_of(known, "_w"))
        };
        if let Some(&first) = self.rotations.iter().find(turns) {
            return Some(first + usize::from(moving)..first + 4);
        }
        array(&self.coordinates, name)
    }
}

/// The range of the elements of an array.
fn array(names: &[String], name: &str) -> Option<Range<usize>> {
    let is_of = |known: &str, end: &str| known.strip_suffix(end) == Some(name);
    let first = names.iter().position(|known| is_of(known, "_0"))?;
    let others = names[first..].iter().zip(0..);
    let count = others.take_while(|(known, place): &(_, usize)| is_of(known, &format!("_{place}")));
    Some(first..first + count.count())
}

/// A node of a run: its number, time, position, velocity, acceleration, constraint force and energy.
///
/// `node["theta"]` is a coordinate by its name, `node["v_theta"]`, `node["a_theta"]` and `node["force_theta"]` its velocity, acceleration and force,
/// `node["height"]` an observed expression, `node["lambda_0"]` a multiplier,
/// `node["torque"]` a parameter, with the value that was set last, there or before. Where the name is that of
/// an array or of a rotation, `node["x"]` and `node["v_x"]` are arrays; of a rotation `r`, `node["r"]` has four numbers, `node["v_r"]` three.
#[pyclass(frozen, name = "Node", module = "dsocs")]
pub struct PyNode {
    /// Its numbers.
    node: OwnedNode,
    /// The names of the coordinates.
    names: Arc<Names>,
    /// The values of the parameters just before the node, followed by those from the node on.
    values: Vec<f64>,
    /// The observed expressions, computed on first use.
    observed: OnceLock<Vec<f64>>,
    /// The multipliers, computed on first use.
    multipliers: OnceLock<Vec<f64>>,
}

impl PyNode {
    /// A node with its names, and the values of the parameters just before it, followed by those from there
    /// on.
    pub fn new(node: OwnedNode, names: &Arc<Names>, values: Vec<f64>) -> Self {
        Self {
            node,
            names: Arc::clone(names),
            values,
            observed: OnceLock::new(),
            multipliers: OnceLock::new(),
        }
    }

    /// The observed expressions.
    fn observed(&self) -> &[f64] {
        self.observed.get_or_init(|| {
            let mut observed = vec![f64::NAN; self.names.observables.len()];
            if let Some(declaration) = self.arriving() {
                declaration.observe(self.node.any().point(), &mut observed);
            }
            observed
        })
    }

    /// The multipliers of the constraint forces.
    fn multipliers(&self) -> &[f64] {
        self.multipliers.get_or_init(|| match self.arriving() {
            Some(declaration) => declaration.multipliers(&self.node.any()),
            None => vec![f64::NAN; self.names.forms],
        })
    }

    /// The declaration with the values with which the motion arrives at the node.
    fn arriving(&self) -> Option<Declaration<'_>> {
        let kernel = self.names.kernel.as_ref()?;
        let values = self.values.get(..self.names.parameters.len())?;
        Some(Declaration::of(kernel).with(values))
    }

    /// The values of the parameters from the node on.
    fn inputs(&self) -> &[f64] {
        self.values.get(self.names.parameters.len()..).unwrap_or_default()
    }

    /// The vectors of a node that may contain a name: the name without its prefix, the vector, and whether it
    /// is not the position.
    fn parts<'n, 'a>(&'n self, name: &'a str) -> impl Iterator<Item = (&'a str, &'n [f64], bool)> {
        let AnyNode { q, v, a, force, .. } = self.node.any();
        let parts = [("", q), ("v_", v), ("a_", a), ("force_", force)].into_iter();
        parts.filter_map(move |(prefix, vector)| {
            Some((name.strip_prefix(prefix)?, vector, !prefix.is_empty()))
        })
    }

    /// The value of a name that denotes one number.
    fn number(&self, name: &str) -> Option<f64> {
        match name {
            "t" => Some(self.node.any().t),
            "energy" => Some(self.node.any().energy),
            _ => self
                .parts(name)
                .find_map(|(name, vector, _)| vector.get(self.names.place(name)?).copied())
                .or_else(|| self.other_number(name)),
        }
    }

    /// An observed expression, a multiplier, or the value of a parameter.
    fn other_number(&self, name: &str) -> Option<f64> {
        let Names {
            observables,
            parameters,
            ..
        } = &*self.names;
        if let Some(place) = observables.iter().position(|known| known == name) {
            return self.observed().get(place).copied();
        }
        if let Some(form) = name.strip_prefix("lambda_").and_then(|form| form.parse().ok())
            && form < self.names.forms
        {
            return self.multipliers().get::<usize>(form).copied();
        }
        let place = parameters.iter().position(|known| known == name)?;
        self.inputs().get(place).copied()
    }

    /// The values of a name that denotes several numbers.
    fn numbers(&self, name: &str) -> Option<&[f64]> {
        let Names {
            observables,
            parameters,
            ..
        } = &*self.names;
        self.parts(name)
            .find_map(|(name, vector, moving)| vector.get(self.names.places(name, moving)?))
            .or_else(|| self.observed().get(array(observables, name)?))
            .or_else(|| self.inputs().get(array(parameters, name)?))
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
        let message = format!("a node has no `{name}`; it has {}", self.names.all());
        Err(PyKeyError::new_err(message))
    }

    fn __copy__(slf: PyRef<'_, Self>) -> PyRef<'_, Self> {
        slf
    }

    fn __deepcopy__<'py>(slf: PyRef<'py, Self>, _memo: &Bound<'py, PyAny>) -> PyRef<'py, Self> {
        slf
    }

    /// A node is pickled with all that it has.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (NodeNames, NodeNumbers))> {
        let Names {
            coordinates,
            rotations,
            observables,
            parameters,
            ..
        } = &*self.names;
        let AnyNode {
            index,
            t,
            q,
            v,
            a,
            force,
            energy,
            ..
        } = self.node.any();
        let names = (
            coordinates.clone(),
            rotations.clone(),
            observables.clone(),
            parameters.clone(),
        );
        let vectors = [q, v, a, force, self.observed(), self.multipliers(), &self.values];
        let numbers = (index, t, energy, vectors.map(<[f64]>::to_vec));
        Ok((py.import("dsocs._dsocs")?.getattr("node_of")?, (names, numbers)))
    }

    fn __repr__(&self) -> String {
        let AnyNode { index, t, q, v, .. } = self.node.any();
        let of = |prefix: &str, vector: &[f64]| {
            let pairs = self.names.coordinates.iter().zip(vector);
            let parts = pairs.map(|(name, x)| format!("{prefix}{name}={x}"));
            parts.collect::<Vec<_>>().join(", ")
        };
        format!("Node({index}, t={t}, {}, {})", of("", q), of("v_", v))
    }
}

/// The names of a pickled node: coordinates, indices of rotations, observed expressions, parameters.
type NodeNames = (Vec<String>, Vec<usize>, Vec<String>, Vec<String>);

/// The numbers of a pickled node: its index, time, energy; position, velocity, acceleration, force, observed
/// expressions, multipliers, values of parameters.
type NodeNumbers = (u64, f64, f64, [Vec<f64>; 7]);

/// A node from its pickled parts.
#[pyfunction]
pub fn node_of(names: NodeNames, numbers: NodeNumbers) -> PyNode {
    let (coordinates, rotations, observables, parameters) = names;
    let (index, t, energy, vectors) = numbers;
    let [q, v, a, force, observed, multipliers, values] = vectors;
    let node = AnyNode {
        index,
        t,
        q: &q,
        v: &v,
        a: &a,
        force: &force,
        energy,
        iterations: 0,
        stop: Stop::Start,
    };
    PyNode {
        node: OwnedNode::of(&node),
        names: Arc::new(Names {
            coordinates,
            rotations,
            observables,
            parameters,
            forms: multipliers.len(),
            kernel: None,
        }),
        values,
        observed: OnceLock::from(observed),
        multipliers: OnceLock::from(multipliers),
    }
}
