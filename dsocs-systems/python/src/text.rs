//! A system that was read from a text.

use std::path::Path;
use std::sync::Arc;

use dsocs_core::text::{Run, TapeKernel, Text};
use dsocs_core::{Kernel, Quantity};
use dsocs_systems::Entry;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::{guarded, of_text, plain};

/// A system that was read from a text: the engine of the Python class `System`. It never changes.
#[pyclass(frozen, name = "Text", module = "dsocs._dsocs")]
pub struct PyText {
    /// The text with its declaration.
    pub text: Arc<Text>,
    /// The name.
    #[pyo3(get)]
    name: String,
}

/// Name, meaning and unit of each of some quantities.
pub fn quantities(all: &[Quantity]) -> Vec<(&str, &str, Option<&str>)> {
    all.iter()
        .map(|of| (&*of.name, of.meaning(), of.unit()))
        .collect()
}

impl PyText {
    /// The system as it was read.
    fn kernel_as_read(&self) -> &dyn Kernel {
        &self.text.system
    }

    /// The number of coordinates.
    pub fn dimension(&self) -> usize {
        self.kernel_as_read().shape().dimension()
    }

    /// The system with other values of its parameters.
    pub fn kernel(&self, values: &[f64]) -> TapeKernel {
        let mut kernel = self.text.system.clone();
        for (place, value) in values.iter().enumerate() {
            if let Some(parameter) = kernel.parameter_mut(place) {
                *parameter = *value;
            }
        }
        kernel
    }

    /// The command line's entry of the system, with other values of its parameters and with one of its runs.
    pub fn entry(&self, run: Option<&Run>, values: &[f64]) -> PyResult<Entry> {
        let mut entry = Entry::of_text(self.name.as_str(), &self.text, run);
        let parameters = &self.kernel_as_read().shape().parameters;
        for (parameter, value) in parameters.iter().zip(values) {
            entry
                .set(&parameter.name, *value)
                .map_err(|error| Python::attach(|py| plain(py, "SetupError", &error.to_string())))?;
        }
        Ok(entry)
    }
}

#[pymethods]
impl PyText {
    /// Reads a text, with other values for its constants, and samples in place of files. Mistakes are shown
    /// under the name of its file.
    #[staticmethod]
    fn parse(
        py: Python<'_>,
        name: String,
        shown_as: &str,
        text: &str,
        constants: Vec<(String, f64)>,
        samples: Vec<(String, Vec<(f64, f64)>)>,
    ) -> PyResult<Self> {
        let read = py.detach(|| guarded(|| Text::parse_with(&name, text, &constants, &samples)))?;
        let read = read.map_err(|error| of_text(py, &error.in_file(Path::new(shown_as))));
        let text = Arc::new(read?);
        Ok(Self { text, name })
    }

    /// The text, word for word.
    #[getter]
    fn text(&self) -> &str {
        &self.text.text
    }

    /// The warnings, each with the place underlined.
    fn warnings(&self, shown_as: &str) -> Vec<String> {
        self.text.warnings_shown(shown_as)
    }

    /// The values of the parameters.
    fn values(&self) -> Vec<f64> {
        let kernel = self.kernel_as_read();
        (0..kernel.shape().parameters.len())
            .map(|place| kernel.value(place))
            .collect()
    }

    /// The declaration as a dict: texts, names, units and counts.
    fn description<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let shape = self.kernel_as_read().shape();
        let entry = Entry::of_text(self.name.as_str(), &self.text, None);
        let dict = PyDict::new(py);
        dict.set_item("doc", &*shape.doc)?;
        dict.set_item("declaration", &*shape.declaration)?;
        dict.set_item("kind", entry.kind().to_string())?;
        dict.set_item("order", shape.order)?;
        dict.set_item("forms", shape.forms)?;
        dict.set_item("may_divide", shape.may_divide())?;
        dict.set_item(
            "constraints",
            (shape.holonomic, shape.nonholonomic, shape.kinematic),
        )?;
        dict.set_item("coordinates", quantities(&shape.coordinates))?;
        dict.set_item("rotations", shape.rotations.to_vec())?;
        dict.set_item("parameters", quantities(&shape.parameters))?;
        dict.set_item("observables", quantities(&shape.observables))?;
        let tables = self.text.tables.iter();
        let tables = tables.map(|table| (&*table.name, &*table.file, table.curve.name()));
        dict.set_item("samples", tables.collect::<Vec<_>>())?;
        Ok(dict)
    }

    /// The runs of the text, each as a dict.
    fn runs<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        let runs = self.text.runs.iter().map(|run| {
            let dict = PyDict::new(py);
            dict.set_item("name", run.name.as_deref())?;
            let start = run.start.clone().map(|[q0, v0]| (q0, v0));
            dict.set_item("start", start)?;
            dict.set_item("acceleration", run.acceleration.clone())?;
            dict.set_item("near", run.near_acceleration.clone())?;
            dict.set_item("project", run.project)?;
            dict.set_item("step", run.step)?;
            dict.set_item("until", run.until)?;
            Ok(dict)
        });
        runs.collect()
    }
}
