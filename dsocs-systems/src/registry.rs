//! Every system that the command line can run, with its type erased.
//!
//! A system's file has its [`Entry`]; a further system is one further line in [`SYSTEMS`].

mod erased;
mod name;
mod parameter;

use std::fmt;
use std::ops::ControlFlow;

use dsocs_core::geometry::GeometryError;
use dsocs_core::{Regularity, RunError, SetupError};
use serde::Serialize;
use thiserror::Error;

use crate::check::{Finding, Settings};
use crate::rung::Plan;
use crate::systems::{
    cart_pole, chain, contact_oscillator, double_pendulum, exact_decrease, gravity_turn, knife_edge,
    magnetic, nonholonomic_particle, particle, pendulum, planar_pendulum, rod_and_wheel, rolling_disk,
    sleigh, snakeboard, sphere, spherical_pendulum,
};

pub use erased::{Erased, Extra, Symmetry};
pub use name::UnknownName;
pub use parameter::ParameterValue;

/// The systems, kind by kind.
pub const SYSTEMS: &[Entry] = &[
    chain::ENTRY,
    double_pendulum::ENTRY,
    spherical_pendulum::ENTRY,
    magnetic::ENTRY,
    planar_pendulum::ENTRY,
    sphere::ENTRY,
    nonholonomic_particle::ENTRY,
    knife_edge::ENTRY,
    rolling_disk::ENTRY,
    sleigh::ENTRY,
    snakeboard::ENTRY,
    contact_oscillator::ENTRY,
    particle::ENTRY,
    pendulum::ENTRY,
    gravity_turn::ENTRY,
    cart_pole::ENTRY,
    exact_decrease::ENTRY,
    rod_and_wheel::ENTRY,
];

/// The kind of a system's constraints.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// None.
    Unconstrained,
    /// On positions.
    Holonomic,
    /// On velocities.
    Nonholonomic,
    /// On accelerations.
    SecondOrder,
    /// Of several orders.
    Mixed,
}

impl Kind {
    /// Every kind, in the order of lists.
    pub const ALL: [Self; 5] = [
        Self::Unconstrained,
        Self::Holonomic,
        Self::Nonholonomic,
        Self::SecondOrder,
        Self::Mixed,
    ];
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Unconstrained => "unconstrained",
            Self::Holonomic => "holonomic",
            Self::Nonholonomic => "nonholonomic",
            Self::SecondOrder => "second-order",
            Self::Mixed => "mixed",
        })
    }
}

/// A system that can be run by name.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// The name.
    pub name: &'static str,
    /// The kind of its constraints.
    pub kind: Kind,
    /// What it is, in a line.
    pub summary: &'static str,
    /// Where it comes from.
    pub source: &'static str,
    /// The units of the coordinates.
    pub units: &'static [&'static str],
    /// The first node unless given.
    pub q0: &'static [f64],
    /// The initial velocity unless given.
    pub v0: &'static [f64],
    /// The step unless given, in s.
    pub step: f64,
    /// The end of the run unless given, in s.
    pub until: f64,
    /// Makes the system with its default parameters.
    pub build: fn() -> Box<dyn AnySystem>,
}

impl Entry {
    /// The system of a name.
    ///
    /// # Errors
    ///
    /// [`UnknownName`] with the nearest name.
    pub fn find(name: &str) -> Result<&'static Self, UnknownName> {
        SYSTEMS
            .iter()
            .find(|entry| entry.name == name)
            .ok_or_else(|| UnknownName::new("system", name, SYSTEMS.iter().map(|entry| entry.name)))
    }
}

/// How the first two nodes are found.
#[derive(Clone, Debug, PartialEq)]
pub enum Beginning {
    /// From position and velocity, `q1 = q0 + h v0`.
    Paper {
        /// The first node.
        q0: Vec<f64>,
        /// The initial velocity.
        v0: Vec<f64>,
    },
    /// From position and velocity, `q1 = q0 + h v0 + h²/2 a0`.
    SecondOrder {
        /// The first node.
        q0: Vec<f64>,
        /// The initial velocity.
        v0: Vec<f64>,
    },
    /// Both nodes.
    Nodes {
        /// The first node.
        q0: Vec<f64>,
        /// The second node.
        q1: Vec<f64>,
    },
    /// Another beginning, moved onto the constraints of positions and velocities.
    Projected(Box<Self>),
}

/// One node of a run.
#[derive(Clone, Copy, Debug)]
pub struct Row<'a> {
    /// The node's number.
    pub index: u64,
    /// Time, in s.
    pub t: f64,
    /// Position.
    pub q: &'a [f64],
    /// Velocity.
    pub v: &'a [f64],
    /// Generalized constraint force.
    pub force: &'a [f64],
    /// Energy.
    pub energy: f64,
    /// The observed expressions of the declaration.
    pub observed: &'a [f64],
    /// The multipliers of the constraints' forms.
    pub multipliers: &'a [f64],
    /// How regular the equations are at the node, in a certified run.
    pub regularity: Option<Regularity>,
    /// The estimated error of each coordinate, if it is asked for.
    pub errors: &'a [f64],
    /// How well the motion is known that errors are measured against.
    pub doubt: f64,
}

impl Row<'_> {
    /// The value of each column, in the order of [`columns`], of [`CERTIFIED`] in a certified run, and of [`error_columns`] where
    /// errors are estimated.
    pub fn values(&self) -> impl Iterator<Item = f64> {
        let vectors = [self.q, self.v, self.force].into_iter().flatten();
        [self.t]
            .into_iter()
            .chain(vectors.copied())
            .chain([self.energy])
            .chain(self.observed.iter().copied())
            .chain(self.multipliers.iter().copied())
            .chain(
                self.regularity
                    .into_iter()
                    .flat_map(|at| [at.forward, at.backward]),
            )
            .chain(self.errors.iter().copied())
    }
}

/// The names of the columns that a certified run has beside the others: the smallest singular values of `D₃` and `D₁`.
pub const CERTIFIED: [&str; 2] = ["regularity_forward", "regularity_backward"];

/// The names of the columns of estimated errors, one for each coordinate.
#[must_use]
pub fn error_columns(system: &dyn AnySystem) -> Vec<String> {
    let coordinates = system.coordinates().iter();
    coordinates.map(|name| format!("error_{name}")).collect()
}

/// The names of a run's columns: time, position, velocity, force, energy, observed expressions, multipliers.
#[must_use]
pub fn columns(system: &dyn AnySystem) -> Vec<String> {
    let coordinates = system.coordinates();
    let prefixed = |prefix: &'static str| coordinates.iter().map(move |name| format!("{prefix}{name}"));
    let mut columns = vec!["t".to_owned()];
    columns.extend(prefixed("").chain(prefixed("v_")).chain(prefixed("force_")));
    columns.push("energy".to_owned());
    columns.extend(system.observables().iter().map(|&name| name.to_owned()));
    columns.extend((0..system.forms()).map(|form| format!("lambda_{form}")));
    columns
}

/// A run did not reach its end.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum RunFailure {
    /// It did not begin.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// A vector has not as many components as the system has coordinates.
    #[error(
        "{vector} has {found} component{}, but there are {} coordinates: {}",
        if *.found == 1 { "" } else { "s" }, .coordinates.len(), .coordinates.join(", ")
    )]
    Length {
        /// Which vector.
        vector: &'static str,
        /// How many components it has.
        found: usize,
        /// The coordinates.
        coordinates: &'static [&'static str],
    },
    /// It ended early.
    #[error(transparent)]
    Run(#[from] RunError),
    /// There is no continuous motion to measure errors against.
    #[error("the error cannot be estimated: {0}")]
    Estimate(#[source] RunError),
}

/// A system could not be checked.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum CheckFailure {
    /// The start does not fit the system.
    #[error(transparent)]
    Start(#[from] RunFailure),
    /// The motion that was to be checked does not begin.
    #[error("the motion to check does not begin: {0}")]
    Setup(#[from] SetupError),
    /// It ends early.
    #[error("the motion to check ends early: {0}")]
    Run(#[from] RunError),
    /// A step of it has no solution by itself.
    #[error("the motion to check: {0}")]
    Geometry(#[from] GeometryError),
}

/// A system of any type and dimension.
pub trait AnySystem: Send {
    /// The names of the coordinates.
    fn coordinates(&self) -> &'static [&'static str];

    /// The names of the observed expressions.
    fn observables(&self) -> &'static [&'static str];

    /// How many forms of constraint forces are known, and so how many multipliers there are.
    fn forms(&self) -> usize;

    /// The parameters with their values.
    fn parameters(&mut self) -> Vec<ParameterValue>;

    /// Gives a parameter a value.
    ///
    /// # Errors
    ///
    /// [`UnknownName`] with the nearest name.
    fn set(&mut self, name: &str, value: f64) -> Result<(), UnknownName>;

    /// Runs as planned and hands each node to `sink`, which may end the run; see [`crate::rung::run`].
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

    /// Checks the paper's theorems on a motion of the system, whose constraints are of a kind.
    ///
    /// # Errors
    ///
    /// [`CheckFailure`] if the motion cannot be computed.
    fn check(&self, kind: Kind, settings: &Settings<'_>) -> Result<Vec<Finding>, CheckFailure>;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_entry_is_consistent() {
        for entry in SYSTEMS {
            let mut system = (entry.build)();
            let count = system.coordinates().len();
            assert_eq!(
                [entry.q0.len(), entry.v0.len(), entry.units.len()],
                [count; 3],
                "{}",
                entry.name
            );
            assert!(
                system
                    .parameters()
                    .iter()
                    .all(|parameter| !parameter.description.is_empty())
            );
            for parameter in system.parameters() {
                system.set(parameter.name, parameter.value + 1.0).unwrap();
            }
        }
    }

    #[test]
    fn the_nearest_name_is_suggested() {
        let error = Entry::find("pendulm").unwrap_err();
        assert_eq!(error.nearest.as_deref(), Some("pendulum"));
        assert_eq!(Entry::find("xyz").unwrap_err().nearest, None);
        let error = (Entry::find("particle").unwrap().build)()
            .set("Curvatur", 1.0)
            .unwrap_err();
        assert_eq!(error.nearest.as_deref(), Some("curvature"));
    }
}
