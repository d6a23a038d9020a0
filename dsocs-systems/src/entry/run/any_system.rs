//! A system behind a trait object: the only code of the command line that is compiled for every system.

use dsocs_core::taylor::{AnyGlobalError, AnyTaylorFlow, GlobalError};
use dsocs_core::text::TapeKernel;
use dsocs_core::{
    AnyComposedFlow, ComposedFlow, Composition, Kernel, Quantity, Run, RunError, SetupError, Start, System,
    TaylorFlow, Tolerance,
};

#[cfg(feature = "sweep")]
use dsocs_core::AnyEnsemble;

use super::beginning::Beginning;
#[cfg(feature = "sweep")]
use super::lanes;
#[cfg(feature = "sweep")]
use super::plan::Plan;
use super::reference::Errors;
#[cfg(feature = "sweep")]
use crate::entry::Row;
use crate::entry::description::Description;

/// A system, and its continuous motions.
pub trait Motions {
    /// The system with the present values of its parameters.
    fn kernel(&self) -> &dyn Kernel;

    /// The continuous motion from a beginning that [fits](Beginning::fits), to a tolerance; with nodes
    /// `every` seconds apart if that is given.
    fn continuous<'s>(
        &'s self,
        beginning: &Beginning,
        tolerance: Tolerance,
        every: Option<f64>,
    ) -> Result<Box<dyn Run + 's>, SetupError>;
}

/// A reference to a system, with its type.
#[derive(Clone, Copy, Debug)]
pub struct TypedSystem<'a, S, const N: usize>(&'a S);

impl<'a, S: System<N>, const N: usize> TypedSystem<'a, S, N> {
    /// The system with its motions.
    pub fn new(system: &'a S) -> Self {
        Self(system)
    }
}

impl<S: System<N>, const N: usize> Motions for TypedSystem<'_, S, N> {
    fn kernel(&self) -> &dyn Kernel {
        self.0.kernel()
    }

    fn continuous<'s>(
        &'s self,
        beginning: &Beginning,
        tolerance: Tolerance,
        every: Option<f64>,
    ) -> Result<Box<dyn Run + 's>, SetupError> {
        continuous(self.0, start(beginning), tolerance, every)
    }
}

// a system that was not compiled
impl Motions for TapeKernel {
    fn kernel(&self) -> &dyn Kernel {
        self
    }

    fn continuous<'s>(
        &'s self,
        beginning: &Beginning,
        tolerance: Tolerance,
        every: Option<f64>,
    ) -> Result<Box<dyn Run + 's>, SetupError> {
        let flow = AnyTaylorFlow::of_tape(self, &beginning.start(), tolerance)?;
        Ok(Box::new(match every {
            Some(h) => flow.every(h)?,
            None => flow,
        }))
    }
}

/// The continuous motion of a system from a start.
fn continuous<'s, S: System<N>, const N: usize>(
    system: &'s S,
    start: Start<N>,
    tolerance: Tolerance,
    every: Option<f64>,
) -> Result<Box<dyn Run + 's>, SetupError> {
    let flow: TaylorFlow<'s, N> = TaylorFlow::new(system, start, tolerance)?;
    Ok(match every {
        Some(h) => flow.every(h)?.into_run(),
        None => flow.into_run(),
    })
}

impl AnySystem for TapeKernel {
    fn extra(&self) -> Vec<Quantity> {
        Vec::new()
    }

    fn parameter(&mut self, index: usize) -> Option<&mut f64> {
        self.parameter_mut(index)
    }

    fn copy(&self) -> Box<dyn AnySystem> {
        Box::new(self.clone())
    }

    fn composed<'s>(
        &'s self,
        h: f64,
        composition: Composition,
        beginning: &Beginning,
    ) -> Result<Box<dyn Run + 's>, SetupError> {
        Ok(AnyComposedFlow::new(self, h, composition, &beginning.start())?.into_run())
    }

    fn errors<'s>(&'s self, beginning: &Beginning, until: f64) -> Result<Box<dyn Errors + 's>, RunError> {
        Ok(Box::new(AnyGlobalError::of_tape(
            self,
            &beginning.start(),
            until,
        )?))
    }

    #[cfg(feature = "sweep")]
    fn run_in_lanes(
        &self,
        plan: &Plan,
        beginnings: &[Beginning],
        parameters: &[lanes::VariedParameter],
        sink: &mut dyn FnMut(usize, &Row<'_>),
    ) -> bool {
        let ensemble = AnyEnsemble::of_tape(self, plan.h);
        lanes::run_in_lanes(self, ensemble, plan, beginnings, parameters, sink)
    }

    #[cfg(feature = "sweep")]
    fn has_lanes(&self) -> bool {
        true
    }
}

/// A system with its parameters, and the motions that it begins. A [`Beginning`] has to [fit](Beginning::fits).
pub(crate) trait AnySystem: Motions + Send {
    /// The parameters that its declaration does not list.
    fn extra(&self) -> Vec<Quantity>;

    /// A parameter's value, by its index in [`Description::parameters`].
    fn parameter(&mut self, index: usize) -> Option<&mut f64>;

    /// A copy of the system, with its own parameters.
    fn copy(&self) -> Box<dyn AnySystem>;

    /// The motion by a composition of the step.
    fn composed<'s>(
        &'s self,
        h: f64,
        composition: Composition,
        beginning: &Beginning,
    ) -> Result<Box<dyn Run + 's>, SetupError>;

    /// The errors of motions against the continuous one, up to the time `until`.
    fn errors<'s>(&'s self, beginning: &Beginning, until: f64) -> Result<Box<dyn Errors + 's>, RunError>;

    /// Runs several points side by side to their ends, if the system was made for lanes and can; see
    /// [`lanes::run_in_lanes`].
    #[cfg(feature = "sweep")]
    fn run_in_lanes(
        &self,
        plan: &Plan,
        beginnings: &[Beginning],
        parameters: &[lanes::VariedParameter],
        sink: &mut dyn FnMut(usize, &Row<'_>),
    ) -> bool;

    /// Whether the system was made for lanes.
    #[cfg(feature = "sweep")]
    fn has_lanes(&self) -> bool;
}

impl dyn AnySystem + '_ {
    /// The description in the declaration.
    pub(crate) fn description(&self) -> Description {
        let shape = self.kernel().shape();
        Description {
            itself: Quantity {
                name: shape.name.clone(),
                doc: shape.doc.clone(),
            },
            coordinates: shape.coordinates.to_vec(),
            rotations: shape.rotations.to_vec(),
            parameters: shape.parameters.iter().cloned().chain(self.extra()).collect(),
            observables: shape.observables.to_vec(),
            forms: shape.forms,
            constraints: [shape.holonomic, shape.nonholonomic, shape.kinematic],
            order: shape.order,
        }
    }
}

/// A parameter that the declaration does not list.
#[derive(Clone, Copy, Debug)]
pub struct ExtraParameter<S> {
    /// The name.
    pub name: &'static str,
    /// Its meaning, with the unit in brackets at the end.
    pub doc: &'static str,
    /// The field that holds it.
    pub place: fn(&mut S) -> &mut f64,
}

/// A system behind [`AnySystem`].
pub(crate) struct EntrySystem<S, const N: usize> {
    /// The system.
    system: S,
    /// Parameters that the declaration does not list.
    extra: Vec<ExtraParameter<S>>,
    /// Makes the ensemble that runs points side by side. Only a constructor that is named here is compiled.
    #[cfg(feature = "sweep")]
    lanes: Option<lanes::InLanes<S>>,
}

impl<S, const N: usize> EntrySystem<S, N> {
    /// Erases the type of a system.
    pub(crate) fn new(system: S, extra: Vec<ExtraParameter<S>>) -> Self {
        Self {
            system,
            extra,
            #[cfg(feature = "sweep")]
            lanes: None,
        }
    }

    /// Erases the type of a system whose sweeps run in lanes.
    pub(crate) fn in_lanes(system: S) -> Self
    where
        S: System<N> + Clone + Sync,
    {
        Self {
            #[cfg(feature = "sweep")]
            lanes: Some(lanes::ensemble::<S, N>),
            ..Self::new(system, Vec::new())
        }
    }
}

/// A vector as an array; NaN if the lengths differ.
fn array<const N: usize>(vector: &[f64]) -> [f64; N] {
    vector.try_into().unwrap_or([f64::NAN; N])
}

/// The start with arrays.
fn start<const N: usize>(beginning: &Beginning) -> Start<N> {
    match beginning {
        Beginning::Paper { q0, v0 } => Start::paper(array(q0), array(v0)),
        Beginning::SecondOrder { q0, v0 } => Start::second_order(array(q0), array(v0)),
        Beginning::ThirdOrder { q0, v0, a0 } => Start::third_order(array(q0), array(v0), array(a0)),
        Beginning::ThirdOrderByForce { q0, v0, force } => {
            Start::third_order_by_force(array(q0), array(v0), array(force))
        }
        Beginning::Nodes { q0, q1 } => Start::nodes(array(q0), array(q1)),
        Beginning::ThreeNodes { q0, q1, q2 } => Start::three_nodes(array(q0), array(q1), array(q2)),
        Beginning::Projected(beginning) => start(beginning).projected(),
        Beginning::Near(a0, beginning) => start(beginning).near_acceleration(array(a0)),
        Beginning::At(t0, beginning) => start(beginning).at(*t0),
    }
}

impl<S: System<N>, const N: usize> Motions for EntrySystem<S, N> {
    fn kernel(&self) -> &dyn Kernel {
        self.system.kernel()
    }

    fn continuous<'s>(
        &'s self,
        beginning: &Beginning,
        tolerance: Tolerance,
        every: Option<f64>,
    ) -> Result<Box<dyn Run + 's>, SetupError> {
        continuous(&self.system, start(beginning), tolerance, every)
    }
}

impl<S: System<N> + Clone + Send + 'static, const N: usize> AnySystem for EntrySystem<S, N> {
    fn extra(&self) -> Vec<Quantity> {
        let extra = self.extra.iter();
        extra
            .map(|&ExtraParameter { name, doc, .. }| Quantity {
                name: name.into(),
                doc: doc.into(),
            })
            .collect()
    }

    fn parameter(&mut self, index: usize) -> Option<&mut f64> {
        match index.checked_sub(self.system.kernel().shape().parameters.len()) {
            None => self.system.parameter_mut(index),
            Some(index) => Some((self.extra.get(index)?.place)(&mut self.system)),
        }
    }

    fn copy(&self) -> Box<dyn AnySystem> {
        Box::new(Self {
            system: self.system.clone(),
            extra: self.extra.clone(),
            #[cfg(feature = "sweep")]
            lanes: self.lanes,
        })
    }

    fn composed<'s>(
        &'s self,
        h: f64,
        composition: Composition,
        beginning: &Beginning,
    ) -> Result<Box<dyn Run + 's>, SetupError> {
        let flow: ComposedFlow<'s, N> = ComposedFlow::new(&self.system, h, composition, start(beginning))?;
        Ok(flow.into_run())
    }

    fn errors<'s>(&'s self, beginning: &Beginning, until: f64) -> Result<Box<dyn Errors + 's>, RunError> {
        Ok(Box::new(GlobalError::new(&self.system, start(beginning), until)?))
    }

    #[cfg(feature = "sweep")]
    fn run_in_lanes(
        &self,
        plan: &Plan,
        beginnings: &[Beginning],
        parameters: &[lanes::VariedParameter],
        sink: &mut dyn FnMut(usize, &Row<'_>),
    ) -> bool {
        let Some(in_lanes) = self.lanes else { return false };
        let ensemble = in_lanes(&self.system, plan.h);
        lanes::run_in_lanes(self.kernel(), ensemble, plan, beginnings, parameters, sink)
    }

    #[cfg(feature = "sweep")]
    fn has_lanes(&self) -> bool {
        self.lanes.is_some()
    }
}
