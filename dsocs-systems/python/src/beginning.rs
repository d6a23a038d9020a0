//! The beginning and the method of a run, from values of Python.

use dsocs_core::{AnyStart, Composition};
use dsocs_systems::entry::{Beginning, Method};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// The beginning of a run: the rule, two or three vectors, the acceleration near which one is looked for, the
/// time, and whether the start is projected.
#[derive(FromPyObject)]
pub struct BeginningParts(String, Vec<Vec<f64>>, Option<Vec<f64>>, f64, bool);

impl BeginningParts {
    /// The start by this rule from another position and velocity.
    pub fn from(&self, q0: &[f64], v0: &[f64]) -> PyResult<AnyStart> {
        let Self(rule, _, near, t0, projected) = self;
        let start = match rule.as_str() {
            "paper" => AnyStart::paper(q0, v0),
            "second-order" => AnyStart::second_order(q0, v0),
            _ => return Err(PyValueError::new_err("no such start of many runs")),
        };
        let start = match near {
            Some(near) => start.near_acceleration(near),
            None => start,
        };
        let start = if *t0 == 0.0 { start } else { start.at(*t0) };
        Ok(if *projected { start.projected() } else { start })
    }

    /// The beginning.
    pub fn beginning(&self) -> PyResult<Beginning> {
        let Self(rule, vectors, near, t0, projected) = self;
        let beginning = match (rule.as_str(), vectors.as_slice()) {
            ("paper", [q0, v0]) => Beginning::Paper {
                q0: q0.clone(),
                v0: v0.clone(),
            },
            ("second-order", [q0, v0]) => Beginning::SecondOrder {
                q0: q0.clone(),
                v0: v0.clone(),
            },
            ("acceleration", [q0, v0, a0]) => Beginning::ThirdOrder {
                q0: q0.clone(),
                v0: v0.clone(),
                a0: a0.clone(),
            },
            ("force", [q0, v0, force]) => Beginning::ThirdOrderByForce {
                q0: q0.clone(),
                v0: v0.clone(),
                force: force.clone(),
            },
            ("nodes", [q0, q1]) => Beginning::Nodes {
                q0: q0.clone(),
                q1: q1.clone(),
            },
            ("nodes", [q0, q1, q2]) => Beginning::ThreeNodes {
                q0: q0.clone(),
                q1: q1.clone(),
                q2: q2.clone(),
            },
            _ => return Err(PyValueError::new_err("no such start")),
        };
        // wrapped in the order in which the command line does it
        let beginning = match near {
            Some(near) => Beginning::Near(near.clone(), Box::new(beginning)),
            None => beginning,
        };
        let beginning = if *t0 == 0.0 {
            beginning
        } else {
            Beginning::At(*t0, Box::new(beginning))
        };
        Ok(if *projected {
            Beginning::Projected(Box::new(beginning))
        } else {
            beginning
        })
    }
}

/// The method for an order and a tolerance: with a tolerance the continuous motion, else the step or a
/// composition of it.
pub fn method(order: u32, tolerance: Option<f64>) -> PyResult<Method> {
    match (tolerance, Composition::of_order(order)) {
        (Some(tolerance), _) => Ok(Method::Tolerance(tolerance)),
        (None, Some(composition)) if order > 2 => Ok(Method::Composed(composition)),
        (None, Some(_)) => Ok(Method::Step),
        (None, None) => Err(PyValueError::new_err("no such order")),
    }
}
