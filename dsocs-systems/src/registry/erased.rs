//! A system with its type erased.

use std::ops::ControlFlow;

use dsocs_core::Start;
use dsocs_core::taylor::Jets;

use super::{AnySystem, Beginning, CheckFailure, Kind, ParameterValue, Row, RunFailure, UnknownName};
use crate::check::{self, Expected, Finding, Settings};
use crate::rung::{self, Plan};

/// A parameter that is not a field of type `f64` of the system's own.
pub struct Extra<S> {
    /// The name.
    pub name: &'static str,
    /// What it is, with its unit in brackets at the end.
    pub doc: &'static str,
    /// Where it is.
    pub place: fn(&mut S) -> &mut f64,
}

/// A symmetry of a system's Lagrangian, by its infinitesimal generator.
#[derive(Debug)]
pub struct Symmetry<S, const N: usize> {
    /// What it is, `rotation about the pivot`.
    pub name: &'static str,
    /// The generator `ξ_Q(q)`, a velocity of the configuration.
    pub generator: fn(&S, &[f64; N]) -> [f64; N],
}

/// A system with its type erased.
pub struct Erased<S: 'static, const N: usize> {
    /// The system.
    system: S,
    /// Parameters that the declaration does not list.
    extra: &'static [Extra<S>],
    /// Symmetries of the Lagrangian.
    symmetries: &'static [Symmetry<S, N>],
    /// The order of the scheme.
    order: f64,
    /// Whether the step with `−h` is the inverse of that with `h`.
    reversible: bool,
}

impl<S: 'static, const N: usize> Erased<S, N> {
    /// A system without more to be said of it.
    pub fn new(system: S) -> Self {
        Self {
            system,
            extra: &[],
            symmetries: &[],
            order: 2.0,
            reversible: true,
        }
    }

    /// Names parameters that the declaration does not list.
    #[must_use]
    pub fn extra(self, extra: &'static [Extra<S>]) -> Self {
        Self { extra, ..self }
    }

    /// Names symmetries of the Lagrangian.
    #[must_use]
    pub fn symmetries(self, symmetries: &'static [Symmetry<S, N>]) -> Self {
        Self { symmetries, ..self }
    }

    /// Says that the scheme's order is another than 2.
    #[must_use]
    pub fn order(self, order: f64) -> Self {
        Self { order, ..self }
    }

    /// Says that the step with `−h` is not the inverse of that with `h`.
    #[must_use]
    pub fn irreversible(self) -> Self {
        Self {
            reversible: false,
            ..self
        }
    }
}

impl<S: Jets<N>, const N: usize> Erased<S, N> {
    /// The coordinates' names, with a lifetime that does not depend on the system.
    const COORDINATES: &'static [&'static str] = &S::COORDINATES;

    /// Makes a vector an array, if it has the right length.
    fn array(vector: &'static str, components: &[f64]) -> Result<[f64; N], RunFailure> {
        let coordinates = Self::COORDINATES;
        components.try_into().map_err(|_| RunFailure::Length {
            vector,
            found: components.len(),
            coordinates,
        })
    }

    /// The start with arrays.
    fn start(beginning: &Beginning) -> Result<Start<N>, RunFailure> {
        Ok(match beginning {
            Beginning::Paper { q0, v0 } => Start::paper(Self::array("q0", q0)?, Self::array("v0", v0)?),
            Beginning::SecondOrder { q0, v0 } => {
                Start::second_order(Self::array("q0", q0)?, Self::array("v0", v0)?)
            }
            Beginning::Nodes { q0, q1 } => Start::nodes(Self::array("q0", q0)?, Self::array("q1", q1)?),
            Beginning::Projected(beginning) => Self::start(beginning)?.projected(),
        })
    }
}

impl<S: Jets<N> + Send + 'static, const N: usize> AnySystem for Erased<S, N> {
    fn coordinates(&self) -> &'static [&'static str] {
        Self::COORDINATES
    }

    fn observables(&self) -> &'static [&'static str] {
        S::OBSERVABLES
    }

    fn forms(&self) -> usize {
        S::FORMS
    }

    fn parameters(&mut self) -> Vec<ParameterValue> {
        let mut parameters = Vec::new();
        for (index, parameter) in S::PARAMETERS.iter().enumerate() {
            if let Some(value) = self.system.parameter(index) {
                parameters.push(ParameterValue::new(parameter.name, parameter.doc, value));
            }
        }
        for extra in self.extra {
            parameters.push(ParameterValue::new(
                extra.name,
                extra.doc,
                *(extra.place)(&mut self.system),
            ));
        }
        parameters
    }

    fn set(&mut self, name: &str, value: f64) -> Result<(), UnknownName> {
        let own = S::PARAMETERS.iter().position(|parameter| parameter.name == name);
        if let Some(place) = own.and_then(|index| self.system.parameter_mut(index)) {
            *place = value;
            return Ok(());
        }
        let known = S::PARAMETERS.iter().map(|parameter| parameter.name);
        match self.extra.iter().find(|extra| extra.name == name) {
            Some(extra) => {
                *(extra.place)(&mut self.system) = value;
                Ok(())
            }
            None => Err(UnknownName::new(
                "parameter",
                name,
                known.chain(self.extra.iter().map(|extra| extra.name)),
            )),
        }
    }

    fn run(
        &self,
        plan: &Plan,
        beginning: &Beginning,
        sink: &mut dyn FnMut(&Row<'_>) -> ControlFlow<()>,
    ) -> Result<(), RunFailure> {
        rung::run(&self.system, plan, Self::start(beginning)?, sink)
    }

    fn check(&self, kind: Kind, settings: &Settings<'_>) -> Result<Vec<Finding>, CheckFailure> {
        let start = (Self::array("q0", settings.q0)?, Self::array("v0", settings.v0)?);
        let expected = Expected {
            kind,
            order: self.order,
            reversible: self.reversible,
        };
        check::check(&self.system, self.symmetries, expected, settings, start)
    }
}
