//! Systems read from text at run time, without a compiler.
//!
//! A text has the content of a Rust file: the parameters with their values, then the body of the attribute
//! `#[dsocs { … }]`.
//!
//! ```
//! use dsocs_core::{AnyFlow, AnyStart, text::Text};
//!
//! let text = Text::parse(
//!     "swing",
//!     "//! A pendulum.
//!      parameters {
//!          /// The length of the rod [m]
//!          length = 2.0,
//!      }
//!      coordinates(theta);
//!      lagrangian = dot(theta).powi(2) / 2 + 9.81 / length * theta.cos();
//!      run { start = ([pi / 2], [0]); step = 0.01; until = 5.0; }",
//! )?;
//! let mut flow = AnyFlow::new(&text.system, 0.01, &AnyStart::second_order(&[1.0], &[0.0]))?;
//! flow.run_mut().to(5.0)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The result is a [`TapeKernel`], which implements [`Kernel`](crate::Kernel). It gives the same bits as the
//! compiled system.
//!
//! A text can execute nothing but its declaration. It may name files of samples: [`Text::parse`] refuses
//! them, [`Text::read`] reads them from the folder of the text.

mod error;

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use dsocs_language::{Call, Data};

use crate::kernel::series::Series;
pub use crate::step::{TapeError, TapeKernel};
pub use dsocs_language::{Curve, Mistake, Place, Run, Table};
pub use error::TextError;

use crate::samples::{Samples, SamplesError};
use crate::solve::sparse::Sparse;
use crate::tape::quantity::Quantity;
use crate::tape::{Shape, Symmetry, Tape, TapeCall};

/// The stack size in bytes for reading a text, whose expressions may be deeply nested.
const STACK: usize = 256 << 20;

/// A system that was read from a text, and the runs that the text describes.
#[derive(Debug)]
pub struct Text {
    /// The system, with the values of its parameters.
    pub system: TapeKernel,
    /// Its tables of samples.
    pub tables: Vec<Table>,
    /// The samples of these tables, in the same order.
    pub samples: Vec<Arc<Samples>>,
    /// The runs of the text.
    pub runs: Vec<Run>,
    /// Warnings about declarations without effect.
    pub warnings: Vec<Mistake>,
    /// The text, unchanged.
    pub text: String,
}

impl Text {
    /// Reads a system from a text without files. `name` is the system's name.
    ///
    /// # Errors
    ///
    /// [`TextError`] with all mistakes of the text.
    pub fn parse(name: &str, text: &str) -> Result<Self, TextError> {
        Self::with(name, text, &Files::None, &[])
    }

    /// Like [`Text::parse`], with other values for the text's constants (`const n = 3;`), and with samples
    /// (pairs of a place and a value, under the name of a file) in place of files. A file without such
    /// samples is a mistake.
    ///
    /// ```
    /// use dsocs_core::text::Text;
    ///
    /// let text = "parameters { push = samples(\"push.csv\", linear) }
    ///             coordinates(x);
    ///             lagrangian = dot(x).powi(2) / 2 + push.at(t) * x;";
    /// let text = Text::parse_with("mass", text, &[], &[("push.csv".to_owned(), vec![(0.0, 1.0), (2.0, 0.0)])])?;
    /// assert_eq!(text.samples[0].at(1.0), 0.5);
    /// # Ok::<(), dsocs_core::text::TextError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// The errors of [`Text::parse`], and an error for a constant that the text does not have.
    pub fn parse_with(
        name: &str,
        text: &str,
        constants: &[(String, f64)],
        samples: &[(String, Vec<(f64, f64)>)],
    ) -> Result<Self, TextError> {
        Self::with(name, text, &Files::Given(samples), constants)
    }

    /// Reads a system from a file, whose name without its extension is the system's name. Sample files are
    /// relative to its folder.
    ///
    /// # Errors
    ///
    /// [`TextError`] if a file cannot be read, or with all mistakes of the text.
    pub fn read(file: impl AsRef<Path>) -> Result<Self, TextError> {
        Self::read_with(file, &[])
    }

    /// Like [`Text::read`], with other values for the text's constants (`const n = 3;`).
    ///
    /// # Errors
    ///
    /// The errors of [`Text::read`], and an error for a constant that the text does not have.
    pub fn read_with(file: impl AsRef<Path>, constants: &[(String, f64)]) -> Result<Self, TextError> {
        let file = file.as_ref();
        let bytes = error::bytes(file)?;
        let name = file
            .file_stem()
            .map_or_else(|| "system".into(), |stem| stem.to_string_lossy());
        let text = error::decoded(file, bytes)?;
        let folder = file.parent().unwrap_or(Path::new(""));
        Self::with(&name, &text, &Files::In(folder), constants).map_err(|error| error.in_file(file))
    }

    /// Reads a text, with this source of its sample files.
    fn with(
        name: &str,
        text: &str,
        files: &Files<'_>,
        constants: &[(String, f64)],
    ) -> Result<Self, TextError> {
        let read = apart(|| {
            let read = dsocs_language::within_limits(|| {
                let read = dsocs_language::read(name, text, constants);
                read.map(|read| {
                    let warnings = read.model.warnings();
                    (read.model.data(), read.values, read.tables, read.runs, warnings)
                })
            });
            read.unwrap_or_else(|mistake| Err(vec![mistake]))
        })?;
        let (data, values, tables, runs, warnings) =
            read.map_err(|mistakes| TextError::mistakes(name, text, mistakes))?;
        let (mut found, mut missing) = (HashMap::new(), Vec::new());
        for table in &tables {
            match files.samples(&table.file, table.curve) {
                Ok(samples) => {
                    found.insert(table.name.clone(), samples);
                }
                Err(message) => missing.push(table.place.mistake(message)),
            }
        }
        if !missing.is_empty() {
            let files = tables.into_iter().map(|table| table.file).collect();
            return Err(TextError::mistakes(name, text, missing).with_files(files));
        }
        let declared = (name.to_owned(), text.to_owned(), constants.to_vec());
        let samples = tables.iter().filter_map(|table| found.get(&table.name));
        let samples = samples.cloned().collect();
        Ok(Self {
            system: system(data, values, &found)?.with_series(move || series(&declared, &found)),
            tables,
            samples,
            runs,
            warnings,
            text: text.to_owned(),
        })
    }

    /// The warnings with the lines of the text, the place of each underlined; `name` is the file's name. Each
    /// begins with `warning: `.
    #[must_use]
    pub fn warnings_shown(&self, name: &str) -> Vec<String> {
        error::shown(name, &self.text, &self.warnings, &error::Kind::Warning)
    }
}

/// Does work on a text in a thread with a large stack, so that no thread-local data of the reader remain in
/// this thread.
fn apart<R: Send>(work: impl FnOnce() -> R + Send) -> Result<R, TextError> {
    let thread = std::thread::scope(|scope| {
        let thread = std::thread::Builder::new()
            .stack_size(STACK)
            .spawn_scoped(scope, work);
        thread.map(std::thread::ScopedJoinHandle::join)
    });
    match thread {
        Ok(Ok(result)) => Ok(result),
        Ok(Err(_)) => Err(TextError::Panic),
        Err(error) => Err(TextError::Thread(error.to_string())),
    }
}

/// The recurrences of a text, for Taylor series. Not every run needs them, and they take as long as the rest,
/// so the text is read again on demand.
fn series(
    (name, text, constants): &(String, String, Vec<(String, f64)>),
    tables: &HashMap<String, Arc<Samples>>,
) -> Option<Series> {
    let read = || {
        let read = dsocs_language::within_limits(|| {
            let read = dsocs_language::read(name, text, constants).ok()?;
            read.model.series()
        });
        read.ok().flatten()
    };
    let series = apart(read).ok()??;
    let calls = calls(&series.calls, tables)?;
    Series::new(&series.recurrences, series.constants, calls).ok()
}

/// The functions that a tape calls; `None` if a table is missing.
fn calls(calls: &[Call], tables: &HashMap<String, Arc<Samples>>) -> Option<Vec<TapeCall>> {
    let calls = calls.iter().map(|call| match call {
        Call::Number(value) => Some(TapeCall::Number(*value)),
        Call::Samples { name, derivative } => tables.get(name).map(|samples| TapeCall::Samples {
            samples: Arc::clone(samples),
            derivative: *derivative,
        }),
        _ => None,
    });
    calls.collect()
}

/// Source of the sample files of a text.
enum Files<'f> {
    /// No source.
    None,
    /// A folder.
    In(&'f Path),
    /// Given samples, by the name of the file.
    Given(&'f [(String, Vec<(f64, f64)>)]),
}

impl Files<'_> {
    /// The interpolated samples of a file, or a message for the user.
    fn samples(&self, file: &str, curve: Curve) -> Result<Arc<Samples>, String> {
        let samples = match self {
            Self::None => {
                return Err(format!(
                    "the text names the file `{file}`, and has no folder in which it could lie; expected a text in a file"
                ));
            }
            Self::In(folder) => {
                let path = folder.join(file);
                error::bytes(&path).map_err(|cause| cause.to_string())?;
                Samples::read(path)
            }
            Self::Given(samples) => {
                let Some((_, samples)) = samples.iter().find(|(name, _)| name == file) else {
                    return Err(format!(
                        "the text names the file `{file}`, and no samples are given in its place"
                    ));
                };
                Ok(samples.clone())
            }
        };
        let samples = samples.and_then(|samples| match curve {
            Curve::Linear => Samples::linear(samples),
            Curve::Monotone => Samples::monotone(samples),
            _ => Samples::cubic(samples),
        });
        samples
            .map(Arc::new)
            .map_err(|cause: SamplesError| format!("these samples cannot be used: {cause}"))
    }
}

/// The system of parsed data.
fn system(
    data: Data,
    values: Vec<f64>,
    tables: &HashMap<String, Arc<Samples>>,
) -> Result<TapeKernel, TextError> {
    let calls = calls(&data.calls, tables).ok_or(TextError::Panic)?;
    let sparse = data.sparse.as_ref().and_then(|[entries, pivots]| {
        let narrow = |places: &[[usize; 2]]| {
            let places = places.iter();
            let places =
                places.map(|&[row, column]| Some([u16::try_from(row).ok()?, u16::try_from(column).ok()?]));
            places.collect::<Option<Vec<_>>>()
        };
        Sparse::owned(data.unknowns, narrow(entries)?, narrow(pivots)?)
    });
    let tape = Tape::owned(data.tape.clone()).map_err(|_| TextError::Panic)?;
    let kernel = TapeKernel::with_calls(tape, shape(data), values, calls).map_err(TextError::Tape)?;
    match sparse {
        Some(sparse) => kernel.sparse(sparse).map_err(TextError::Tape),
        None => Ok(kernel),
    }
}

/// The shape of parsed data.
fn shape(data: Data) -> Shape {
    let quantity = |of: dsocs_language::Quantity| Quantity {
        name: of.name.into(),
        doc: of.doc.into(),
    };
    let quantities = |all: Vec<dsocs_language::Quantity>| all.into_iter().map(quantity).collect::<Vec<_>>();
    Shape {
        name: data.itself.name.into(),
        doc: data.itself.doc.into(),
        declaration: data.declaration.into(),
        increments: data.coordinates.len(),
        coordinates: quantities(data.coordinates).into(),
        parameters: quantities(data.parameters).into(),
        others: quantities(data.others).into(),
        observables: quantities(data.observables).into(),
        unknowns: data.unknowns,
        motion: data.motion,
        constants: data.constants,
        known: data.known,
        order: data.order,
        holonomic: data.holonomic,
        nonholonomic: data.nonholonomic,
        kinematic: data.kinematic,
        forms: data.forms,
        third_order: data.third_order.into(),
        rotations: data.rotations.into(),
        of_positions: data.of_positions.into(),
        of_rates: data.of_rates.into(),
        depends_on_time: data.depends_on_time,
        external_forces: data.external_forces,
        linear: data.linear,
        jumps: data.jumps,
        piecewise: data.piecewise,
        switches: data.switches,
        scaled: data.scaled,
        divided: data.divided,
        symmetry: match data.symmetry {
            dsocs_language::Symmetry::AnyLegs => Symmetry::AnyLegs,
            dsocs_language::Symmetry::Momenta => Symmetry::Momenta,
            dsocs_language::Symmetry::LowerOrder => Symmetry::LowerOrder,
            dsocs_language::Symmetry::ThirdOrder => Symmetry::ThirdOrder,
            dsocs_language::Symmetry::LagrangianMap => Symmetry::LagrangianMap,
            dsocs_language::Symmetry::KinematicMap => Symmetry::KinematicMap,
            dsocs_language::Symmetry::VariationalMap => Symmetry::VariationalMap,
            _ => Symmetry::Unknown,
        },
    }
}
