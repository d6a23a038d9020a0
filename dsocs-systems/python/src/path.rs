//! Runs that can be differentiated.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Instant;

use dsocs_core::text::TapeKernel;
use dsocs_core::{AnyPath, AnyPoint, DerivativeError, Dual, Kernel, OwnedNode, Variable};
use dsocs_systems::entry::Beginning;
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use self_cell::self_cell;

use crate::beginning::BeginningParts;
use crate::error::{guarded, of_derivative};
use crate::motion::CHECK_INTERVAL;
use crate::node::{Names, PyNode};
use crate::text::PyText;

self_cell!(
    /// A path and its system.
    struct Owned {
        owner: Box<TapeKernel>,
        #[not_covariant]
        dependent: AnyPath,
    }
);

/// A run by the paper's step whose steps are kept: the engine of the Python class `Path`.
#[pyclass(frozen, name = "RawPath", module = "dsocs._dsocs")]
pub struct PyPath {
    /// The path.
    path: Owned,
    /// The names of the coordinates.
    names: Arc<Names>,
}

/// Runs to a time, with checks for signals.
fn begin<'s>(
    system: &'s TapeKernel,
    h: f64,
    from: &Beginning,
    until: f64,
    look: &mut dyn FnMut() -> ControlFlow<()>,
) -> Result<AnyPath<'s>, Box<DerivativeError>> {
    AnyPath::new_while(system, h, &from.start(), until, look).map_err(Box::new)
}

#[pymethods]
impl PyPath {
    /// Runs to a time.
    #[new]
    fn new(
        py: Python<'_>,
        text: &PyText,
        values: Vec<f64>,
        h: f64,
        beginning: BeginningParts,
        until: f64,
    ) -> PyResult<Self> {
        let (system, beginning) = (Box::new(text.kernel(&values)), beginning.beginning()?);
        let (mut looked, mut stopped) = (Instant::now(), None);
        let path = py.detach(|| {
            let mut look = || {
                if looked.elapsed() > CHECK_INTERVAL {
                    looked = Instant::now();
                    stopped = Python::attach(|py| py.check_signals()).err();
                }
                if stopped.is_some() {
                    ControlFlow::Break(())
                } else {
                    ControlFlow::Continue(())
                }
            };
            guarded(|| Owned::try_new(system, |system| begin(system, h, &beginning, until, &mut look)))
        })?;
        if let Some(error) = stopped {
            return Err(error);
        }
        let path = path.map_err(|error| of_derivative(py, &error))?;
        let kernel = &**path.borrow_owner();
        let names = Names::of((kernel as &dyn Kernel).shape(), kernel);
        Ok(Self { path, names })
    }

    /// The number of steps.
    #[getter]
    fn steps(&self, py: Python<'_>) -> usize {
        self.with(py, |path| path.steps())
    }

    /// The last node.
    #[getter]
    fn end(&self, py: Python<'_>) -> PyNode {
        let node = self.with(py, |path| OwnedNode::of(&path.end()));
        let kernel: &dyn Kernel = &**self.path.borrow_owner();
        let places = 0..kernel.shape().parameters.len();
        let values: Vec<f64> = places.map(|place| kernel.value(place)).collect();
        PyNode::new(node, &self.names, values.repeat(2))
    }

    /// The gradient of a cost: of a sum over the nodes or, with `at_end`, of a function of the last node. The
    /// function gets the index of a node, its time, position, velocity and acceleration. It returns the cost
    /// and its derivatives by these three, one after the other.
    fn gradient<'py>(
        &self,
        py: Python<'py>,
        at_end: bool,
        cost: Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let cost = cost.unbind();
        let mut failed = None;
        let found = py.detach(|| {
            self.path.with_dependent(|_, path| {
                // one call of the function serves all directions of derivatives at a node
                let mut last: Option<(usize, f64, Vec<f64>)> = None;
                let mut of_node = |index: usize, point: AnyPoint<'_, Dual<f64>>| {
                    if failed.is_some() {
                        return Dual::new(f64::NAN, 0.0);
                    }
                    if last.as_ref().is_none_or(|(own, ..)| *own != index) {
                        match Python::attach(|py| ask(py, &cost, index, point)) {
                            Ok((value, slopes)) => last = Some((index, value, slopes)),
                            Err(error) => {
                                failed = Some(error);
                                return Dual::new(f64::NAN, 0.0);
                            }
                        }
                    }
                    let Some((_, value, slopes)) = &last else {
                        return Dual::new(f64::NAN, 0.0);
                    };
                    let rates = [point.q, point.v, point.a].into_iter().flatten();
                    // a quantity with derivative zero may have a rate that is not finite
                    let parts = slopes.iter().zip(rates).filter(|(slope, _)| **slope != 0.0);
                    Dual::new(*value, parts.map(|(slope, rate)| slope * rate.eps).sum())
                };
                guarded(|| {
                    if at_end {
                        let steps = path.steps();
                        path.gradient_at_end(&mut |point| of_node(steps, point))
                    } else {
                        path.gradient(&mut of_node)
                    }
                })
            })
        });
        if let Some(error) = failed {
            return Err(error);
        }
        let found = found?.map_err(|error| of_derivative(py, &error))?;
        let dict = PyDict::new(py);
        dict.set_item("cost", found.cost)?;
        for (name, vector) in [
            ("q", found.q0),
            ("v", found.v0),
            ("q1", found.q1),
            ("parameters", found.parameters),
        ] {
            dict.set_item(name, PyArray1::from_vec(py, vector))?;
        }
        Ok(dict)
    }

    /// The derivatives of the last node with respect to some variables: `q`, `v` or `q1` with the index of a
    /// coordinate, or a parameter by its name. Each is position, velocity, acceleration and force, one after
    /// the other.
    fn tangents(&self, py: Python<'_>, variables: Vec<(String, usize)>) -> PyResult<Vec<[Vec<f64>; 2]>> {
        let found = py.detach(|| {
            self.path.with_dependent(|_, path| {
                let asked: Vec<Variable<'_>> = variables
                    .iter()
                    .map(|(name, place)| match name.as_str() {
                        "@q" => Variable::Position(*place),
                        "@v" => Variable::Velocity(*place),
                        "@q1" => Variable::SecondNode(*place),
                        parameter => Variable::Parameter(parameter),
                    })
                    .collect();
                guarded(|| {
                    path.tangents(&asked).map(|tangents| {
                        (0..asked.len())
                            .filter_map(|place| tangents.get(place))
                            .map(|tangent| [tangent.q.to_vec(), tangent.v.to_vec()])
                            .collect()
                    })
                })
            })
        });
        found?.map_err(|error| of_derivative(py, &error))
    }
}

impl PyPath {
    /// Calls a function with the path.
    fn with<R: Send>(&self, py: Python<'_>, look: impl FnOnce(&AnyPath<'_>) -> R + Send) -> R {
        py.detach(|| self.path.with_dependent(|_, path| look(path)))
    }
}

/// Calls the Python function for the cost of a node and its derivatives.
fn ask(
    py: Python<'_>,
    cost: &Py<PyAny>,
    index: usize,
    point: AnyPoint<'_, Dual<f64>>,
) -> PyResult<(f64, Vec<f64>)> {
    let numbers = |vector: &[Dual<f64>]| {
        let numbers: Vec<f64> = vector.iter().map(|x| x.re).collect();
        PyArray1::from_vec(py, numbers)
    };
    let arguments = (
        index,
        point.t.re,
        numbers(point.q),
        numbers(point.v),
        numbers(point.a),
    );
    cost.call1(py, arguments)?.extract(py)
}
