//! An [`Entry`]: a system with its defaults, as the command line knows it. It is made from the system itself.
//!
//! Names, units and texts come from the declaration. An entry adds what a declaration does not contain: a start, a step, an end, a
//! literature source, symmetries.
//!
//! ```
//! use dsocs_core::dsocs;
//! use dsocs_systems::Entry;
//!
//! /// A mass on a spring.
//! #[dsocs {
//!     coordinates(
//!         /// The elongation [m].
//!         x,
//!     );
//!     lagrangian = mass / 2 * dot(x).powi(2) - stiffness / 2 * x.powi(2);
//! }]
//! #[derive(Clone)]
//! struct MassOnSpring {
//!     /// The mass \[kg\].
//!     mass: f64,
//!     /// The stiffness of the spring [N/m].
//!     stiffness: f64,
//! }
//!
//! let entry = Entry::new(MassOnSpring { mass: 1.0, stiffness: 4.0 })
//!     .start([1.0], [0.0])
//!     .step(0.05)
//!     .until(20.0);
//! assert_eq!(entry.name(), "mass-on-spring");
//! assert_eq!(entry.summary(), "A mass on a spring");
//! ```

mod checks;
mod columns;
mod defaults;
mod description;
mod drawing;
mod error;
mod name;
mod run;
mod shipped;
mod symmetry;
mod text;
mod verify;

use std::fmt;
use std::sync::Arc;

use dsocs_core::text::{Run as TextRun, Table, Text};
use dsocs_core::{Kernel, Quantity, Samples, System};

use crate::check::Expected;

pub use columns::{Column, LastNodes, Row, columns};
pub use description::{Description, Kind};
pub(crate) use drawing::Face;
pub use drawing::{Drawing, Parameters, Shape, Solid, about, along, rotated};
pub use error::{CheckFailure, EntryError, Mistake};
pub use name::UnknownName;
pub use run::{Beginning, ExtraParameter, HeldInput, Method, Plan, RunFailure};
#[cfg(feature = "sweep")]
pub use run::{EventQuantity, RunItem, VariedParameter, WatchedEvent, can_share_lanes, failure_code};
pub(crate) use run::{Motions, TypedSystem};
pub use shipped::Shipped;
pub use symmetry::Symmetry;
pub use text::NoText;

use drawing::DrawingFunction;
use run::{AnySystem, EntrySystem};

/// The default step, in s, if neither the entry nor the command line sets one.
pub const STEP: f64 = 0.01;

/// The default end of a run, in s, if neither the entry nor the command line sets one.
pub const UNTIL: f64 = 10.0;

/// A system that the command line can run by name.
pub struct Entry {
    /// The system.
    system: Box<dyn AnySystem>,
    /// The names, texts and units of the declaration.
    description: Description,
    /// The name on the command line.
    name: String,
    /// The summary, in a line.
    summary: String,
    /// The literature source.
    source: Option<String>,
    /// Its tables of samples with their contents, if it was read from a text.
    tables: Vec<(Table, Arc<Samples>)>,
    /// The start unless the command line gives one: position and velocity.
    start: Option<[Vec<f64>; 2]>,
    /// The default initial acceleration, where a constraint is of third order.
    acceleration: Option<Vec<f64>>,
    /// The acceleration near which the initial one is looked for by default, where there are several.
    near: Option<Vec<f64>>,
    /// Whether the start is projected onto the constraints by default.
    project: bool,
    /// The text that it was read from, and the names of that text's runs.
    text: Option<(String, Vec<Option<String>>)>,
    /// The step.
    step: f64,
    /// The end.
    until: f64,
    /// The end of the motion that is checked, if it differs from that of a run.
    checked: Option<f64>,
    /// Symmetries of the Lagrangian.
    symmetries: Vec<Symmetry>,
    /// Its drawing, if the entry has one.
    drawn: Option<DrawingFunction>,
    /// The order of the scheme.
    order: f64,
    /// Whether the step with `−h` is the inverse of that with `h`.
    reversible: bool,
}

impl fmt::Debug for Entry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Entry")
            .field("name", &self.name)
            .field("description", &self.description)
            .finish_non_exhaustive()
    }
}

impl Entry {
    /// The entry of a system with the current values of its parameters. A run with inputs (`--input`) changes a copy.
    ///
    /// Its name is that of the type in the form `my-system`, its summary the first sentence of the type's documentation. It has no
    /// start until [`Entry::start`] gives one. By default the step is 0.01 s and the end 10 s; [`Entry::step`] and [`Entry::until`] change
    /// them.
    pub fn new<S: System<N> + Clone + Send + 'static, const N: usize>(system: S) -> Self {
        Self::with_parameters(system, [])
    }

    /// As [`Entry::new`], for a system whose sweeps can run eight points at once, in SIMD lanes, where a plan
    /// says `lanes = true`. This is several times as fast. Its steps are compiled for each set of
    /// instructions, which takes some seconds more in a release build with the feature `sweep`; without the
    /// feature nothing changes.
    ///
    /// In lanes, functions such as the sine round differently than in a single run, so the last digits of the results differ. They never
    /// depend on which points run beside a point.
    pub fn in_lanes<S: System<N> + Clone + Send + Sync + 'static, const N: usize>(system: S) -> Self {
        Self::of(Box::new(EntrySystem::in_lanes(system)))
    }

    /// The entry of a system with parameters that its declaration does not list, such as those inside a field of generic type.
    pub fn with_parameters<S: System<N> + Clone + Send + 'static, const N: usize>(
        system: S,
        extra: impl Into<Vec<ExtraParameter<S>>>,
    ) -> Self {
        Self::of(Box::new(EntrySystem::new(system, extra.into())))
    }

    /// The entry of a system that was read from a text, with the start, step and end of one of the text's
    /// runs. `name` is its name.
    ///
    /// ```
    /// use dsocs_core::text::Text;
    /// use dsocs_systems::Entry;
    ///
    /// let text = Text::parse(
    ///     "spring",
    ///     "coordinates(x);
    ///      lagrangian = dot(x).powi(2) / 2 - 2 * x.powi(2);
    ///      run { start = ([1], [0]); until = 5.0; }",
    /// )?;
    /// let entry = Entry::of_text("spring", &text, text.runs.first());
    /// assert!(entry.verify().is_ok());
    /// # Ok::<(), dsocs_core::text::TextError>(())
    /// ```
    #[must_use]
    pub fn of_text(name: impl Into<String>, text: &Text, run: Option<&TextRun>) -> Self {
        let entry = Self {
            tables: text
                .tables
                .iter()
                .cloned()
                .zip(text.samples.iter().cloned())
                .collect(),
            text: Some((
                text.text.clone(),
                text.runs.iter().map(|run| run.name.clone()).collect(),
            )),
            ..Self::of(Box::new(text.system.clone())).named(name)
        };
        let Some(run) = run else { return entry };
        Self {
            start: run.start.clone(),
            acceleration: run.acceleration.clone(),
            near: run.near_acceleration.clone(),
            project: run.project,
            step: run.step.unwrap_or(entry.step),
            until: run.until.unwrap_or(entry.until),
            ..entry
        }
    }

    /// The entry of a system whose type is erased.
    fn of(system: Box<dyn AnySystem>) -> Self {
        let description = system.description();
        Self {
            name: name::kebab(&description.itself.name),
            summary: description::sentence(&description.itself.doc).to_owned(),
            system,
            description,
            source: None,
            tables: Vec::new(),
            start: None,
            acceleration: None,
            near: None,
            project: false,
            text: None,
            step: STEP,
            until: UNTIL,
            checked: None,
            symmetries: Vec::new(),
            drawn: None,
            order: 2.0,
            reversible: true,
        }
    }
}

/// The defaults and texts of an entry.
impl Entry {
    /// The name on the command line.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The summary, in a line.
    #[must_use]
    pub fn summary(&self) -> &str {
        &self.summary
    }

    /// The literature source, if the entry has one.
    #[must_use]
    pub fn origin(&self) -> Option<&str> {
        self.source.as_deref()
    }

    /// Names, texts and units from the declaration.
    #[must_use]
    pub fn description(&self) -> &Description {
        &self.description
    }

    /// The kind of its constraints.
    #[must_use]
    pub fn kind(&self) -> Kind {
        self.description.kind()
    }

    /// The default start of a run, position and velocity, if there is one.
    #[must_use]
    pub fn default_start(&self) -> Option<&[Vec<f64>; 2]> {
        self.start.as_ref()
    }

    /// The acceleration near which the initial one is looked for by default, if the entry has one.
    #[must_use]
    pub fn default_near(&self) -> Option<&[f64]> {
        self.near.as_deref()
    }

    /// The default acceleration at the start of a run, if the entry has one.
    #[must_use]
    pub fn default_acceleration(&self) -> Option<&[f64]> {
        self.acceleration.as_deref()
    }

    /// Whether the start is moved onto the constraints by default.
    #[must_use]
    pub fn projects(&self) -> bool {
        self.project
    }

    /// The text that the system was read from, word for word.
    #[must_use]
    pub fn source_text(&self) -> Option<&str> {
        self.text.as_ref().map(|(text, _)| text.as_str())
    }

    /// The names of the runs in the text that the system was read from; one may have none.
    pub fn runs(&self) -> impl Iterator<Item = Option<&str>> {
        let runs = self.text.iter().flat_map(|(_, runs)| runs);
        runs.map(Option::as_deref)
    }

    /// The tables of samples of a system that was read from a text.
    pub fn tables(&self) -> impl Iterator<Item = &Table> {
        self.tables.iter().map(|(table, _)| table)
    }

    /// The default step of a run, in s.
    #[must_use]
    pub fn default_step(&self) -> f64 {
        self.step
    }

    /// The default end of a run, in s.
    #[must_use]
    pub fn default_until(&self) -> f64 {
        self.until
    }

    /// The default end of the motion that `check` follows, in s.
    #[must_use]
    pub fn checked_end(&self) -> f64 {
        self.checked.unwrap_or(self.until)
    }

    /// The default end of a run with step `h`, in s from its start; negative with a negative step. A
    /// declaration whose own runs go back in time keeps its negative end.
    pub(crate) fn until_with(&self, h: f64) -> f64 {
        let until = self.default_until();
        if until < 0.0 { until } else { until.copysign(h) }
    }

    /// The properties that `check` expects: the kind of constraints, the order, and whether steps are
    /// reversible.
    #[must_use]
    pub fn expected(&self) -> Expected {
        Expected {
            kind: self.kind(),
            order: self.order,
            reversible: self.reversible,
        }
    }

    /// The system without its type, with the present values of its parameters.
    #[must_use]
    pub fn kernel(&self) -> &dyn Kernel {
        self.system.kernel()
    }

    /// The parameters, those of the declaration first, with their values.
    pub fn parameters(&mut self) -> Vec<(Quantity, f64)> {
        let parameters = self.description.parameters.clone().into_iter().enumerate();
        parameters
            .filter_map(|(index, parameter)| Some((parameter, *self.system.parameter(index)?)))
            .collect()
    }

    /// The function that draws the mechanism at a position, with the current values of the parameters, if the entry has one.
    pub fn drawing(&mut self) -> Option<impl Fn(&[f64]) -> Drawing + use<>> {
        let parameters = Parameters::new(self.parameters());
        let draw = self.drawn.as_ref()?.draw.clone();
        Some(move |q: &[f64]| draw(q, &parameters))
    }

    /// Gives a parameter a value.
    ///
    /// # Errors
    ///
    /// [`UnknownName`] with the nearest name.
    pub fn set(&mut self, name: &str, value: f64) -> Result<(), UnknownName> {
        let parameters = &self.description.parameters;
        let place = parameters.iter().position(|parameter| parameter.name == name);
        if let Some(place) = place.and_then(|place| self.system.parameter(place)) {
            *place = value;
            return Ok(());
        }
        Err(self.unknown_parameter(name))
    }

    /// The error for a name that no parameter has.
    pub(crate) fn unknown_parameter(&self, name: &str) -> UnknownName {
        let known = self.description.parameters.iter();
        let known = known.map(|parameter| parameter.name.clone());
        let unknown = UnknownName::new("parameter", name, known);
        match self.tables().find(|table| table.name == name) {
            Some(table) => unknown.of_other_kind(format!(
                ": `{name}` is a table of samples, which stands in the file `{}`; edit that file, or name another one in the text",
                table.file
            )),
            None => match self.system.kernel().shape().type_of_other(name) {
                Some(ty) => unknown.of_other_kind(format!(
                    ": the field of this name is of type `{ty}`, and parameters are fields of type `f64` and the elements of arrays of them"
                )),
                None => unknown,
            },
        }
    }

    /// A copy with the same system, start, step and end, for another thread. It has neither a drawing nor the
    /// settings of checks.
    #[cfg(feature = "sweep")]
    #[must_use]
    pub fn copy(&self) -> Self {
        Self {
            name: self.name.clone(),
            summary: self.summary.clone(),
            tables: self.tables.clone(),
            start: self.start.clone(),
            acceleration: self.acceleration.clone(),
            near: self.near.clone(),
            project: self.project,
            text: self.text.clone(),
            step: self.step,
            until: self.until,
            ..Self::of(self.system.copy())
        }
    }
}
