//! Every system that the command line can run, with its type erased.
//!
//! A further system is one further [`Entry`] in [`SYSTEMS`].

use std::ops::ControlFlow;

use dsocs_core::{Flow, Node, Regularity, RunError, SetupError, Start, System, until_break};
use thiserror::Error;

use crate::chain::PlanarChain8;
use crate::particle::{Constant, CurvedParticle};
use crate::pendulum::InertiaWheelPendulum;

/// The systems.
pub const SYSTEMS: &[Entry] = &[
    Entry {
        name: "particle",
        kind: "second-order",
        summary: "a particle in the plane with prescribed signed curvature",
        units: &["m", "m"],
        q0: &[0.0, 0.0],
        v0: &[1.0, 1.0],
        step: 0.1,
        until: 500.0,
        build: || {
            Box::new(Erased {
                system: CurvedParticle::default(),
                extra: &[Extra {
                    name: "curvature",
                    doc: "The prescribed curvature, positive to the left [1/m].",
                    place: |particle: &mut CurvedParticle<Constant>| &mut particle.curvature.0,
                }],
            })
        },
    },
    Entry {
        name: "pendulum",
        kind: "second-order",
        summary: "the inertia wheel pendulum with a Lyapunov constraint",
        units: &["rad", "rad"],
        q0: &[0.5, 0.0],
        v0: &[0.0, 0.5],
        step: 0.1,
        until: 2000.0,
        build: || {
            Box::new(Erased {
                system: InertiaWheelPendulum::default(),
                extra: &[],
            })
        },
    },
    Entry {
        name: "chain",
        kind: "unconstrained",
        summary: "a planar chain of eight links, hanging from a pivot",
        units: &["rad"; 8],
        q0: &[1.0; 8],
        v0: &[0.0; 8],
        step: 0.005,
        until: 20.0,
        build: || {
            Box::new(Erased {
                system: PlanarChain8::default(),
                extra: &[],
            })
        },
    },
];

/// A system that can be run by name.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// The name.
    pub name: &'static str,
    /// The kind of its constraints: `second-order` or `unconstrained`.
    pub kind: &'static str,
    /// What it is, in a line.
    pub summary: &'static str,
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

/// A name that does not exist, and those that do.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("there is no {kind} `{name}`{}; known: {}", suggestion(.nearest.as_deref()), .known.join(", "))]
pub struct UnknownName {
    /// What the name should have named.
    pub kind: &'static str,
    /// The name.
    pub name: String,
    /// The name that is nearest, if one is near.
    pub nearest: Option<String>,
    /// All names.
    pub known: Vec<String>,
}

impl UnknownName {
    /// The error for a name that is none of `known`.
    pub fn new<T: Into<String>>(kind: &'static str, name: &str, known: impl IntoIterator<Item = T>) -> Self {
        let known: Vec<String> = known.into_iter().map(Into::into).collect();
        let lower = name.to_lowercase();
        let nearest = known
            .iter()
            .map(|candidate| (strsim::jaro_winkler(&candidate.to_lowercase(), &lower), candidate))
            .filter(|&(similarity, _)| similarity > 0.7)
            .max_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(_, candidate)| candidate.clone());
        Self {
            kind,
            name: name.to_owned(),
            nearest,
            known,
        }
    }
}

/// The question after the nearest name.
fn suggestion(nearest: Option<&str>) -> String {
    nearest.map_or_else(String::new, |nearest| format!(" (did you mean `{nearest}`?)"))
}

/// A parameter and its value.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterValue {
    /// The name.
    pub name: &'static str,
    /// The value.
    pub value: f64,
    /// The unit, 1 for a number without.
    pub unit: &'static str,
    /// What it is.
    pub description: &'static str,
}

impl ParameterValue {
    /// Takes the unit off the end of a parameter's documentation.
    fn new(name: &'static str, doc: &'static str, value: f64) -> Self {
        let doc = doc.trim_end().trim_end_matches('.');
        // a unit of one word is written `\[kg\]`, since `[kg]` would be a link
        let parts = doc.strip_suffix(']').and_then(|doc| doc.rsplit_once('['));
        let (description, unit) = parts.unwrap_or((doc, "1"));
        let (description, unit) = (
            description.trim_end_matches('\\').trim_end(),
            unit.trim_end_matches('\\'),
        );
        Self {
            name,
            value,
            unit,
            description,
        }
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
    /// How regular the equations are at the node, in a certified run.
    pub regularity: Option<Regularity>,
}

impl Row<'_> {
    /// The value of each column, in the order of [`columns`], and of [`CERTIFIED`] in a certified run.
    pub fn values(&self) -> impl Iterator<Item = f64> {
        let vectors = [self.q, self.v, self.force].into_iter().flatten();
        [self.t]
            .into_iter()
            .chain(vectors.copied())
            .chain([self.energy])
            .chain(self.observed.iter().copied())
            .chain(
                self.regularity
                    .into_iter()
                    .flat_map(|at| [at.forward, at.backward]),
            )
    }
}

/// The names of the columns that a certified run has beside the others: the smallest singular values of `D₃` and `D₁`.
pub const CERTIFIED: [&str; 2] = ["regularity_forward", "regularity_backward"];

/// The names of a run's columns: time, position, velocity, force, energy, observed expressions.
#[must_use]
pub fn columns(system: &dyn AnySystem) -> Vec<String> {
    let coordinates = system.coordinates();
    let prefixed = |prefix: &'static str| coordinates.iter().map(move |name| format!("{prefix}{name}"));
    let mut columns = vec!["t".to_owned()];
    columns.extend(prefixed("").chain(prefixed("v_")).chain(prefixed("force_")));
    columns.push("energy".to_owned());
    columns.extend(system.observables().iter().map(|&name| name.to_owned()));
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
}

/// A system of any type and dimension.
pub trait AnySystem: Send {
    /// The names of the coordinates.
    fn coordinates(&self) -> &'static [&'static str];

    /// The names of the observed expressions.
    fn observables(&self) -> &'static [&'static str];

    /// The parameters with their values.
    fn parameters(&mut self) -> Vec<ParameterValue>;

    /// Gives a parameter a value.
    ///
    /// # Errors
    ///
    /// [`UnknownName`] with the nearest name.
    fn set(&mut self, name: &str, value: f64) -> Result<(), UnknownName>;

    /// Runs from the start up to the last node at or before `until` and hands each node to `sink`, which may end the
    /// run. A certified run tells the regularity at each node; at the start, where no step is solved, it is NaN.
    ///
    /// # Errors
    ///
    /// [`RunFailure`] if the run cannot be set up or a step has no solution.
    fn run(
        &self,
        h: f64,
        beginning: &Beginning,
        until: f64,
        certify: bool,
        sink: &mut dyn FnMut(&Row<'_>) -> ControlFlow<()>,
    ) -> Result<(), RunFailure>;
}

/// A parameter that is not a field of type `f64` of the system's own.
struct Extra<S> {
    /// The name.
    name: &'static str,
    /// What it is, with its unit in brackets at the end.
    doc: &'static str,
    /// Where it is.
    place: fn(&mut S) -> &mut f64,
}

/// A system with its type erased.
struct Erased<S: 'static, const N: usize> {
    /// The system.
    system: S,
    /// Parameters that the declaration does not list.
    extra: &'static [Extra<S>],
}

impl<S: System<N>, const N: usize> Erased<S, N> {
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
        })
    }
}

impl<S: System<N> + Send + 'static, const N: usize> AnySystem for Erased<S, N> {
    fn coordinates(&self) -> &'static [&'static str] {
        Self::COORDINATES
    }

    fn observables(&self) -> &'static [&'static str] {
        S::OBSERVABLES
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
        h: f64,
        beginning: &Beginning,
        until: f64,
        certify: bool,
        sink: &mut dyn FnMut(&Row<'_>) -> ControlFlow<()>,
    ) -> Result<(), RunFailure> {
        let mut flow = Flow::new(&self.system, h, Self::start(beginning)?)?;
        let mut observed = vec![0.0; S::OBSERVABLES.len()];
        if certify {
            flow = flow.watchful();
            flow.certify(until, |node, regularity| {
                self.system.observe(&node.point(), &mut observed);
                sink(&row(node, &observed, regularity.or(Some(Regularity::UNKNOWN))))
            })?;
        } else {
            flow.stream(
                until,
                &mut until_break(|node: &Node<N>| {
                    self.system.observe(&node.point(), &mut observed);
                    sink(&row(node, &observed, None))
                }),
            )?;
        }
        Ok(())
    }
}

/// A node with its type erased.
#[inline]
fn row<'a, const N: usize>(
    node: &'a Node<N>,
    observed: &'a [f64],
    regularity: Option<Regularity>,
) -> Row<'a> {
    Row {
        index: node.index,
        t: node.t,
        q: &node.q,
        v: &node.v,
        force: &node.force,
        energy: node.energy,
        observed,
        regularity,
    }
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

    #[test]
    fn units_come_from_the_documentation() {
        let parameter = ParameterValue::new("m", "The mass of the particle [kg].", 1.0);
        assert_eq!(
            (parameter.description, parameter.unit),
            ("The mass of the particle", "kg")
        );
    }
}
