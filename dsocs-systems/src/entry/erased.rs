//! A system with its type erased: all code of the command line that is made anew for every system.

use std::ops::ControlFlow;

use dsocs_core::{Quantity, SetupError, Start, System};

use super::{Beginning, CheckFailure, Description, Plan, Row, RunFailure, Symmetry, run};
#[cfg(feature = "sweep")]
use super::{lanes, point};
use crate::check::probe::Of;
use crate::check::{self, Expected, Finding, Settings};

/// A system of any type and dimension.
pub(super) trait AnySystem: Send {
    /// What its declaration says.
    fn description(&self) -> Description;

    /// The place of a parameter, by its number in [`Description::parameters`].
    fn parameter(&mut self, index: usize) -> Option<&mut f64>;

    /// Runs as planned and hands each node to `sink`, which may end the run; see [`run::run`].
    ///
    /// # Errors
    ///
    /// [`RunFailure`] if the run cannot be set up or does not reach its end.
    fn run(
        &self,
        plan: &Plan,
        beginning: &Beginning,
        sink: &mut dyn FnMut(&Row<'_>) -> ControlFlow<()>,
    ) -> Result<(), RunFailure>;

    /// Runs as planned, to the end or to the first event that ends the run, whose place is given back; see [`point::go`].
    ///
    /// # Errors
    ///
    /// [`RunFailure`] if the run cannot be set up or does not reach its end.
    #[cfg(feature = "sweep")]
    fn point(
        &self,
        request: &point::Request<'_>,
        beginning: &Beginning,
        sink: &mut dyn FnMut(point::Shown<'_>),
    ) -> Result<Option<usize>, RunFailure>;

    /// Runs several points side by side to their ends, if the system was asked to and can; see [`lanes::ends`].
    #[cfg(feature = "sweep")]
    fn ends(
        &self,
        plan: &Plan,
        beginnings: &[Beginning],
        parameters: &[lanes::Varied],
        sink: &mut dyn FnMut(usize, &Row<'_>),
    ) -> bool;

    /// Whether the system was asked to run in lanes.
    #[cfg(feature = "sweep")]
    fn has_lanes(&self) -> bool;

    /// The same system once more, for another thread.
    #[cfg(feature = "sweep")]
    fn copy(&self) -> Box<dyn AnySystem>;

    /// Checks the paper's theorems on a motion of the system, whose end is `own` unless the settings say another.
    ///
    /// # Errors
    ///
    /// [`CheckFailure`] if the motion cannot be computed.
    fn check(
        &self,
        symmetries: &[Symmetry],
        expected: Expected,
        settings: &Settings<'_>,
        own: f64,
    ) -> Result<Vec<Finding>, CheckFailure>;
}

/// A parameter that the declaration does not list.
#[derive(Clone, Copy, Debug)]
pub struct Extra<S> {
    /// The name.
    pub name: &'static str,
    /// What it is, with its unit in brackets at the end.
    pub doc: &'static str,
    /// Where it is.
    pub place: fn(&mut S) -> &mut f64,
}

/// A system behind [`AnySystem`].
pub(super) struct Erased<S, const N: usize> {
    /// The system.
    system: S,
    /// Parameters that the declaration does not list.
    extra: Vec<Extra<S>>,
    /// What runs points side by side. Only what is named here is compiled.
    #[cfg(feature = "sweep")]
    lanes: Option<lanes::Ends<S, N>>,
}

impl<S, const N: usize> Erased<S, N> {
    /// Erases the type of a system.
    pub(super) fn new(system: S, extra: Vec<Extra<S>>) -> Self {
        Self {
            system,
            extra,
            #[cfg(feature = "sweep")]
            lanes: None,
        }
    }

    /// The same for a system whose sweeps run in lanes.
    pub(super) fn in_lanes(system: S) -> Self
    where
        S: System<N> + Clone + Sync,
    {
        Self {
            #[cfg(feature = "sweep")]
            lanes: Some(lanes::ends),
            ..Self::new(system, Vec::new())
        }
    }
}

/// Why a vector does not fit a system.
fn misfit(vector: &'static str, components: &[f64], coordinates: &[Quantity]) -> RunFailure {
    RunFailure::Length {
        vector,
        found: components.len(),
        coordinates: coordinates
            .iter()
            .map(|coordinate| coordinate.name.clone())
            .collect(),
    }
}

/// Makes a vector an array, if it has the right length.
fn array<const N: usize>(
    vector: &'static str,
    components: &[f64],
    coordinates: &[Quantity; N],
) -> Result<[f64; N], RunFailure> {
    components
        .try_into()
        .map_err(|_| misfit(vector, components, coordinates))
}

/// The start with arrays.
fn start<const N: usize>(beginning: &Beginning, names: &[Quantity; N]) -> Result<Start<N>, RunFailure> {
    let array = |vector, components: &[f64]| array(vector, components, names);
    Ok(match beginning {
        Beginning::Paper { q0, v0 } => Start::paper(array("q0", q0)?, array("v0", v0)?),
        Beginning::SecondOrder { q0, v0 } => Start::second_order(array("q0", q0)?, array("v0", v0)?),
        Beginning::ThirdOrder { q0, v0, a0 } => {
            Start::third_order(array("q0", q0)?, array("v0", v0)?, array("a0", a0)?)
        }
        Beginning::ThirdOrderByForce { q0, v0, force } => {
            Start::third_order_by_force(array("q0", q0)?, array("v0", v0)?, array("f0", force)?)
        }
        Beginning::Nodes { q0, q1 } => Start::nodes(array("q0", q0)?, array("q1", q1)?),
        Beginning::ThreeNodes { q0, q1, q2 } => {
            Start::three_nodes(array("q0", q0)?, array("q1", q1)?, array("q2", q2)?)
        }
        Beginning::Projected(beginning) => start(beginning, names)?.projected(),
        Beginning::Near(a0, beginning) => start(beginning, names)?.near_acceleration(array("a0", a0)?),
        Beginning::At(t0, beginning) => start(beginning, names)?.at(*t0),
    })
}

impl<S: System<N> + Clone + Send + 'static, const N: usize> AnySystem for Erased<S, N> {
    fn description(&self) -> Description {
        let extra = self
            .extra
            .iter()
            .map(|&Extra { name, doc, .. }| Quantity::new(name, doc));
        Description {
            itself: Quantity::new(S::NAME, S::DOC),
            coordinates: S::COORDINATES.to_vec(),
            parameters: S::PARAMETERS.iter().cloned().chain(extra).collect(),
            observables: S::OBSERVABLES.to_vec(),
            forms: S::FORMS,
            constraints: [S::HOLONOMIC, S::NONHOLONOMIC, S::KINEMATIC],
            order: S::ORDER,
        }
    }

    fn parameter(&mut self, index: usize) -> Option<&mut f64> {
        match index.checked_sub(S::PARAMETERS.len()) {
            None => self.system.parameter_mut(index),
            Some(index) => Some((self.extra.get(index)?.place)(&mut self.system)),
        }
    }

    fn run(
        &self,
        plan: &Plan,
        beginning: &Beginning,
        sink: &mut dyn FnMut(&Row<'_>) -> ControlFlow<()>,
    ) -> Result<(), RunFailure> {
        let start = start(beginning, &S::COORDINATES)?;
        run::run(&self.system, plan, start, sink)
    }

    #[cfg(feature = "sweep")]
    fn point(
        &self,
        request: &point::Request<'_>,
        beginning: &Beginning,
        sink: &mut dyn FnMut(point::Shown<'_>),
    ) -> Result<Option<usize>, RunFailure> {
        let start = start(beginning, &S::COORDINATES)?;
        let mut ended = None;
        run::begin(&self.system, request.plan, start, &mut |run, system| {
            ended = point::go(run, system, request, sink)?;
            Ok(())
        })?;
        Ok(ended)
    }

    #[cfg(feature = "sweep")]
    fn ends(
        &self,
        plan: &Plan,
        beginnings: &[Beginning],
        parameters: &[lanes::Varied],
        sink: &mut dyn FnMut(usize, &Row<'_>),
    ) -> bool {
        let starts: Result<Vec<_>, _> = beginnings
            .iter()
            .map(|beginning| start(beginning, &S::COORDINATES))
            .collect();
        match (self.lanes, starts) {
            (Some(ends), Ok(starts)) => ends(&self.system, plan, starts, parameters, sink),
            _ => false,
        }
    }

    #[cfg(feature = "sweep")]
    fn has_lanes(&self) -> bool {
        self.lanes.is_some()
    }

    #[cfg(feature = "sweep")]
    fn copy(&self) -> Box<dyn AnySystem> {
        Box::new(Self {
            system: self.system.clone(),
            extra: self.extra.clone(),
            lanes: self.lanes,
        })
    }

    fn check(
        &self,
        symmetries: &[Symmetry],
        expected: Expected,
        settings: &Settings<'_>,
        own: f64,
    ) -> Result<Vec<Finding>, CheckFailure> {
        let checked = |vector, components: &[f64]| match components.len() == N {
            true => Ok(()),
            false => Err(misfit(vector, components, &S::COORDINATES)),
        };
        checked("q0", settings.q0)?;
        checked("v0", settings.v0)?;
        let of = Of::new(&self.system);
        if const { S::ORDER > 2 } {
            let a0 = settings.a0.ok_or(SetupError::FreeAcceleration)?;
            checked("a0", a0)?;
            return check::third::check_to(&of, expected, settings, own);
        }
        if let Some(a0) = settings.a0 {
            checked("a0", a0)?;
        }
        check::check_to(&of, symmetries, expected, settings, own)
    }
}
