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

mod any_system;
mod beginning;
mod columns;
mod description;
mod drawing;
mod error;
mod failure;
mod held_inputs;
#[cfg(feature = "sweep")]
mod lanes;
mod name;
mod plan;
#[cfg(feature = "sweep")]
mod point;
mod reference;
mod run;
mod shipped;
mod solid;
mod symmetry;
mod text;

use std::fmt;
use std::ops::ControlFlow;
use std::sync::Arc;

#[cfg(feature = "sweep")]
use dsocs_core::Declaration;
use dsocs_core::text::{Run as TextRun, Table, Text};
use dsocs_core::{Kernel, Quantity, Samples, SetupError, System};

use crate::check::orders::{MAPS, Orders, Variant};
use crate::check::{self, Expected, Finding, Settings};

pub use any_system::ExtraParameter;
pub(crate) use any_system::{Motions, TypedSystem};
pub use beginning::Beginning;
pub use columns::{Column, Row, columns, is_closed};
pub(crate) use columns::{constraint_power, energy_terms};
pub use description::{Description, Kind};
pub use drawing::{Drawing, Parameters, Shape};
pub use error::{CheckFailure, EntryError, Mistake};
pub use failure::RunFailure;
#[cfg(feature = "sweep")]
pub use lanes::{VariedParameter, can_share_lanes};
pub use name::UnknownName;
pub use plan::{HeldInput, Method, Plan};
#[cfg(feature = "sweep")]
pub use point::{EventQuantity, RunItem, WatchedEvent, failure_code};
pub use shipped::Shipped;
pub(crate) use solid::Face;
pub use solid::{Solid, about, along, turned};
pub use symmetry::Symmetry;
pub use text::NoText;

use any_system::{AnySystem, EntrySystem};
use drawing::DrawingFunction;

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

    /// Gives another name than the type's.
    #[must_use]
    pub fn named(mut self, name: impl Into<String>) -> Self {
        self.name = name.into();
        self
    }

    /// Gives another summary than the first sentence of the type's documentation.
    #[must_use]
    pub fn described(mut self, summary: impl Into<String>) -> Self {
        self.summary = summary.into();
        self
    }

    /// Sets the literature source of the system.
    #[must_use]
    pub fn source(mut self, source: impl Into<String>) -> Self {
        self.source = Some(source.into());
        self
    }

    /// Sets the default start of a run: the position `q0` and the velocity `v0`, with one number for each coordinate.
    #[must_use]
    pub fn start<const N: usize>(mut self, q0: [f64; N], v0: [f64; N]) -> Self {
        self.start = Some([q0.to_vec(), v0.to_vec()]);
        self
    }

    /// Sets the default start of a run of a system with a constraint of third order: position `q0`, velocity `v0` and acceleration `a0`.
    #[must_use]
    pub fn start_with_acceleration<const N: usize>(self, q0: [f64; N], v0: [f64; N], a0: [f64; N]) -> Self {
        Self {
            acceleration: Some(a0.to_vec()),
            ..self.start(q0, v0)
        }
    }

    /// Sets the acceleration near which the initial one is looked for by default, where the equations have
    /// several solutions.
    #[must_use]
    pub fn near_acceleration<const N: usize>(mut self, a0: [f64; N]) -> Self {
        self.near = Some(a0.to_vec());
        self
    }

    /// Moves the start onto the constraints on positions and velocities by default, by the smallest change to first order. Without it a start that violates them is
    /// refused.
    #[must_use]
    pub fn projected(mut self) -> Self {
        self.project = true;
        self
    }

    /// Sets the default step of a run, in s; negative to run back in time.
    #[must_use]
    pub fn step(mut self, h: f64) -> Self {
        self.step = h;
        self
    }

    /// Sets the default end of a run, in s.
    #[must_use]
    pub fn until(mut self, until: f64) -> Self {
        self.until = until;
        self
    }

    /// Sets the default end of the motion that `check` follows, in s. Unless set, it is that of a run.
    #[must_use]
    pub fn checked_until(mut self, until: f64) -> Self {
        self.checked = Some(until);
        self
    }

    /// Adds a symmetry of the Lagrangian, given by its infinitesimal generator `ξ_Q(q)`, a velocity of the configuration. `check`
    /// tests its momentum law on the motion.
    #[must_use]
    pub fn symmetry<const N: usize>(
        mut self,
        name: impl Into<String>,
        generator: impl Fn(&[f64; N]) -> [f64; N] + Send + Sync + 'static,
    ) -> Self {
        self.symmetries.push(Symmetry::new(name, generator));
        self
    }

    /// Sets how the mechanism is drawn at a position, with its parameters. The page of a run (`run --report`) shows it moving. The function has
    /// to return the same shapes in the same order for every position. Without a drawing the page draws a path.
    ///
    /// ```
    /// use dsocs_core::dsocs;
    /// use dsocs_systems::Entry;
    /// use dsocs_systems::entry::{Drawing, Parameters};
    ///
    /// /// A pendulum.
    /// #[dsocs {
    ///     coordinates(theta);
    ///     lagrangian = (length * dot(theta)).powi(2) / 2 + 9.81 * length * theta.cos();
    /// }]
    /// #[derive(Clone)]
    /// struct Pendulum { length: f64 }
    ///
    /// let entry = Entry::new(Pendulum { length: 1.0 })
    ///     .start([1.0], [0.0])
    ///     .drawn(|[theta]: &[f64; 1], parameters: &Parameters| {
    ///         let length = parameters.get("length");
    ///         let bob = [length * theta.sin(), -length * theta.cos()];
    ///         Drawing::new().trail(bob).rod([0.0, 0.0], bob).point(bob)
    ///     });
    /// assert!(entry.verify().is_ok());
    /// ```
    #[must_use]
    pub fn drawn<const N: usize>(
        mut self,
        draw: impl Fn(&[f64; N], &Parameters) -> Drawing + Send + Sync + 'static,
    ) -> Self {
        self.drawn = Some(DrawingFunction::new(draw));
        self
    }

    /// Sets the order of the scheme that `check` expects (2 by default).
    #[must_use]
    pub fn order(mut self, order: f64) -> Self {
        self.order = order;
        self
    }

    /// States that the step with `−h` is not the inverse of the step with `h`. Then `check` reports the difference, and does not fail.
    #[must_use]
    pub fn irreversible(mut self) -> Self {
        self.reversible = false;
        self
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

    /// Runs as planned and hands each node to `sink`, which may end the run.
    ///
    /// # Errors
    ///
    /// [`RunFailure`] if the run cannot be set up or does not reach its end.
    pub fn run(
        &self,
        plan: &Plan,
        beginning: &Beginning,
        sink: &mut dyn FnMut(&Row<'_>) -> ControlFlow<()>,
    ) -> Result<(), RunFailure> {
        run::run(&*self.system, plan, beginning, sink)
    }

    /// Runs as planned, to the end or to the first event that ends the run, and returns the index of this
    /// event among those `watched`. `sink` gets the events, each node if `nodes` is set, and the point where
    /// the run ended. For a run that fails, this is its last node.
    ///
    /// # Errors
    ///
    /// [`RunFailure`] if the run cannot be set up or does not reach its end.
    #[cfg(feature = "sweep")]
    pub fn run_point(
        &self,
        plan: &Plan,
        beginning: &Beginning,
        watched: &[WatchedEvent],
        nodes: bool,
        sink: &mut dyn FnMut(RunItem<'_>),
    ) -> Result<Option<usize>, RunFailure> {
        let plan = &*plan.with_own_values(&*self.system);
        let request = point::ObservedRun { plan, watched, nodes };
        let mut ended = None;
        run::with_run(&*self.system, plan, beginning, &mut |run, system| {
            let system = Declaration::of(system.kernel());
            ended = point::run_point(run, &system, &request, sink)?;
            Ok(())
        })?;
        Ok(ended)
    }

    /// Whether sweeps run in lanes ([`Entry::in_lanes`]).
    #[cfg(feature = "sweep")]
    #[must_use]
    pub fn has_lanes(&self) -> bool {
        self.system.has_lanes()
    }

    /// Runs several points to their ends side by side, each from its beginning and with its values of the
    /// parameters that vary, and passes the last node of each to `sink`, with its index. Points that fail are
    /// left out: [`Entry::run_point`] gives the reason. Returns whether this could be done.
    #[cfg(feature = "sweep")]
    pub fn run_in_lanes(
        &self,
        plan: &Plan,
        beginnings: &[Beginning],
        parameters: &[VariedParameter],
        sink: &mut dyn FnMut(usize, &Row<'_>),
    ) -> bool {
        let shape = self.kernel().shape();
        let all_fit = beginnings.iter().all(|beginning| beginning.fits(shape).is_ok());
        all_fit && self.system.run_in_lanes(plan, beginnings, parameters, sink)
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

    /// Checks the paper's theorems on a motion of the system. It ends at [`Entry::checked_end`] unless the settings have another end.
    ///
    /// # Errors
    ///
    /// [`CheckFailure`] if the motion cannot be computed.
    pub fn check(&self, settings: &Settings<'_>) -> Result<Vec<Finding>, CheckFailure> {
        let default_duration = self.checked_end().abs() * settings.h.signum();
        let shape = self.kernel().shape();
        beginning::fits("q0", settings.q0, shape)?;
        beginning::fits("v0", settings.v0, shape)?;
        if self.system.kernel().shape().is_of_third_order() {
            let a0 = settings.a0.ok_or(SetupError::FreeAcceleration)?;
            beginning::fits("a0", a0, shape)?;
            return check::third::check_to(self.system.kernel(), self.expected(), settings, default_duration);
        }
        if let Some(a0) = settings.a0 {
            beginning::fits("a0", a0, shape)?;
        }
        let motions: &dyn Motions = &*self.system;
        check::check_to(
            motions,
            &self.symmetries,
            self.expected(),
            settings,
            default_duration,
        )
    }

    /// Measures the orders of the parts of the discrete system on a motion of it: chapter *The orders of the parts*. The motion ends after 200 steps, or at
    /// the default end where that comes first, unless the settings have another end.
    ///
    /// # Errors
    ///
    /// [`CheckFailure`] if the motion cannot be computed, and for systems with rotations or with constraints of third order.
    pub fn orders(&self, settings: &Settings<'_>) -> Result<Orders, CheckFailure> {
        let shape = self.kernel().shape();
        beginning::fits("q0", settings.q0, shape)?;
        beginning::fits("v0", settings.v0, shape)?;
        if let Some(a0) = settings.a0 {
            beginning::fits("a0", a0, shape)?;
        }
        check::orders::orders_to(&*self.system, settings, self.until)
    }

    /// Measures the orders with each of the [`MAPS`] that its declaration admits. A system that cannot be
    /// written as a text is measured with its own maps only.
    ///
    /// # Errors
    ///
    /// As [`Entry::orders`] for the maps as declared.
    pub fn orders_by_map(&self, settings: &Settings<'_>) -> Result<Vec<Variant>, CheckFailure> {
        let [_, others @ ..] = MAPS;
        let mut variants = vec![Variant::declared(self.orders(settings)?)];
        let Ok(text) = self.text() else {
            return Ok(variants);
        };
        let samples = self.tables.iter().map(|(table, samples)| {
            let places = samples.places().iter();
            (
                table.file.clone(),
                places.map(|&place| (place, samples.at(place))).collect(),
            )
        });
        let samples: Vec<(String, Vec<(f64, f64)>)> = samples.collect();
        let shape = self.system.kernel().shape();
        for map in others
            .into_iter()
            .filter(|map| map.is_for(&shape.declaration, shape.kinematic))
        {
            let measured = || {
                let text = map.read(&self.name, &text, &samples)?;
                let entry = Self::of_text(self.name.clone(), &text, text.runs.first());
                entry.orders(settings).map_err(|failure| failure.to_string())
            };
            let orders = measured();
            variants.push(Variant { map, orders });
        }
        Ok(variants)
    }

    /// The position and the velocity of settings, projected onto the constraints by the smallest change.
    pub(crate) fn projected_state(&self, settings: &Settings<'_>) -> Result<[Vec<f64>; 2], CheckFailure> {
        let shape = self.kernel().shape();
        beginning::fits("q0", settings.q0, shape)?;
        beginning::fits("v0", settings.v0, shape)?;
        check::projected(&*self.system, settings)
    }

    /// Looks for mistakes in the parts that the entry adds to the declaration.
    ///
    /// # Errors
    ///
    /// [`EntryError`] for the first mistake.
    pub fn verify(&self) -> Result<(), EntryError> {
        let coordinates = self.description.coordinates.len();
        let fail = |cause| {
            Err(EntryError {
                name: self.name.clone(),
                cause,
            })
        };
        let vectors = self.start.iter().flatten().zip(["q0", "v0"]);
        let accelerations = self.acceleration.iter().chain(&self.near);
        let vectors = vectors.chain(accelerations.map(|a0| (a0, "a0")));
        let vectors = vectors.map(|(vector, name)| (format!("{name} of its start"), vector.len()));
        let generators = self.symmetries.iter();
        let generators = generators.map(|symmetry| {
            (
                format!("its symmetry `{}`", symmetry.name()),
                symmetry.components(),
            )
        });
        let drawn = self
            .drawn
            .iter()
            .map(|drawn| ("its drawing".to_owned(), drawn.components));
        for (what, found) in vectors.chain(generators).chain(drawn) {
            if found != coordinates {
                return fail(Mistake::Length {
                    what,
                    found,
                    coordinates: self.description.names().map(str::to_owned).collect(),
                });
            }
        }
        if self.name.is_empty() || self.name.starts_with('-') || self.name.contains(char::is_whitespace) {
            return fail(Mistake::Name);
        }
        if let Some(drawn) = &self.drawn {
            let parameters = &self.description.parameters;
            let values = Parameters::new(parameters.iter().map(|parameter| (parameter.clone(), 1.0)));
            let zeros = vec![0.0; coordinates];
            let _drawing = (drawn.draw)(self.start.as_ref().map_or(&zeros, |[q0, _]| q0), &values);
            if let Some(name) = values.unknown_name() {
                let known = parameters.iter().map(|parameter| parameter.name.clone());
                return fail(Mistake::Parameter(UnknownName::new("parameter", name, known)));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dsocs_core::dsocs;

    /// A mass on a rod,
    /// in a plane.
    ///
    /// Not part of the summary.
    #[dsocs {
        coordinates(
            /// The position [m]
            x,
            /// The height [m]
            y
        );
        lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2)) - mass * gravity * y;
        holonomic = x.powi(2) + y.powi(2) - length.powi(2);
    }]
    #[derive(Clone)]
    struct PlanarPendulum {
        mass: f64,
        length: f64,
        gravity: f64,
    }

    const PENDULUM: PlanarPendulum = PlanarPendulum {
        mass: 1.0,
        length: 1.0,
        gravity: 9.81,
    };

    /// A rod whose one end slides along itself.
    #[dsocs {
        coordinates(x, y, u, w);
        lagrangian = (dot(x).powi(2) + dot(y).powi(2) + dot(u).powi(2) + dot(w).powi(2)) / 2;
        holonomic = (x - u).powi(2) + (y - w).powi(2) - 1;
        nonholonomic = dot(x) * (w - y) - dot(y) * (u - x);
    }]
    #[derive(Clone)]
    struct RodAndWheel {}

    #[test]
    fn an_entry_says_what_its_declaration_says() {
        let mut entry = Entry::new(PENDULUM);
        assert_eq!(entry.name(), "planar-pendulum");
        assert_eq!(entry.summary(), "A mass on a rod, in a plane");
        assert_eq!(entry.kind(), Kind::Holonomic);
        assert_eq!(Entry::new(RodAndWheel {}).kind(), Kind::Mixed);
        let units: Vec<_> = entry
            .description()
            .coordinates
            .iter()
            .map(Quantity::unit)
            .collect();
        assert_eq!(units, [Some("m"), Some("m")]);
        entry.set("length", 2.0).unwrap();
        let lengths = entry
            .parameters()
            .into_iter()
            .filter(|(of, _)| of.name == "length");
        assert_eq!(lengths.map(|(_, value)| value).collect::<Vec<_>>(), [2.0]);
        let error = entry.set("lenght", 2.0).unwrap_err();
        assert_eq!(error.nearest.as_deref(), Some("length"));
        assert!(
            error.to_string().contains("known: mass, length, gravity"),
            "{error}"
        );
    }

    #[test]
    fn what_contradicts_the_declaration_is_told() {
        let entry = || Entry::new(PENDULUM);
        assert_eq!(entry().verify(), Ok(()));
        for (entry, expected) in [
            (
                entry().start([0.0], [0.0]),
                "q0 of its start has 1 component, but there are 2 coordinates: x, y",
            ),
            (
                entry().symmetry("rotation", |[x, y, _]| [-y, *x, 0.0]),
                "its symmetry `rotation` has 3 components, but",
            ),
            (
                entry().drawn(|[x, _]: &[f64; 2], parameters| {
                    Drawing::new().point([*x, parameters.get("lenght")])
                }),
                "no parameter `lenght` (did you mean `length`?)",
            ),
            (entry().named("a pendulum"), "has no blanks"),
            (entry().named(""), "is not empty"),
        ] {
            let error = entry.verify().unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        }
    }
}
