//! Warnings about a run: an energy that changes without cause; with steps of a fixed length one that
//! explodes, forces that change too fast for the step, bodies that rotate and arguments of sines that change too far in a
//! step, coordinates that alternate from step to step, and with compositions coordinates that move otherwise than their
//! velocities say; constraints that nearly depend on each other; and velocities that jump since an input is a mass. The
//! command line and the Python package give the same warnings.

mod alternation;
mod arguments;
mod conserved;
mod dependence;
mod energy;
mod increments;
mod inputs;
mod masses;
mod resolution;
mod start;
mod turns;

use dsocs_core::{AnyNode, Declaration, Shape};

use crate::entry::{Method, Row};

use alternation::Alternation;
use arguments::Arguments;
use conserved::Conserved;
use dependence::Dependence;
use energy::Energy;
use increments::Increments;
pub use inputs::passed_inputs;
use masses::Masses;
use resolution::Resolution;
pub use start::moved_start;
use turns::Turns;

/// All of the first `FIRST_NODES` nodes are tested, and then `WINDOW_NODES` consecutive ones out of each `FIRST_NODES`,
/// so that the cost in a long run is small.
const FIRST_NODES: u64 = 2048;
const WINDOW_NODES: u64 = 32;

/// Whether a node is tested by observers that look at consecutive ones.
#[inline]
fn is_tested(index: u64) -> bool {
    index < FIRST_NODES || index % FIRST_NODES < WINDOW_NODES
}

/// Whether the energy of a system with constant inputs can change by forces of constraints on positions and
/// velocities only.
fn is_closed(shape: &Shape) -> bool {
    !shape.external_forces && !shape.depends_on_time && shape.kinematic == 0
}

/// The power of a node's constraint force.
#[inline]
fn constraint_power(node: &AnyNode<'_>) -> f64 {
    node.force.iter().zip(node.v).map(|(force, v)| force * v).sum()
}

/// The sum of the sizes of the energy's terms at a node: of the kinetic and the potential energy, whose sum is the energy and whose difference
/// the Lagrangian.
fn energy_terms(declaration: &Declaration<'_>, node: &AnyNode<'_>) -> f64 {
    let lagrangian = declaration.lagrangian(node.t, node.q, node.v);
    node.energy.abs().max(lagrangian.abs())
}

/// The observers of the nodes of a run.
pub struct Warnings {
    observers: Observers,
    /// Of a run with inputs that change.
    masses: Option<Masses>,
}

#[expect(clippy::large_enum_variant, reason = "there is one for a run")]
enum Observers {
    /// With steps of a fixed length.
    Steps(Steps),
    /// With a tolerance: where the energy cannot change, and where constraints may depend on each other.
    Tolerance {
        tolerance: f64,
        conserved: Option<Conserved>,
        dependence: Option<Dependence>,
    },
}

/// What is observed with steps of a fixed length.
struct Steps {
    energy: Energy,
    alternation: Alternation,
    arguments: Arguments,
    /// What only some systems and methods have. Behind one branch: each costs every step.
    special: Option<Box<Special>>,
}

/// What is observed of some systems, and with some methods.
struct Special {
    /// Of a system with rotations.
    turns: Option<Turns>,
    /// Where external forces or the time change the energy.
    resolution: Option<Resolution>,
    /// Of a composition.
    increments: Option<Increments>,
}

impl Steps {
    /// The observers for a run of a system by a method.
    fn of(method: Method, shape: &Shape) -> Self {
        let special = Special {
            turns: (!shape.rotations.is_empty()).then(|| Turns::of(&shape.rotations)),
            resolution: (shape.external_forces || shape.depends_on_time).then(Resolution::default),
            increments: matches!(method, Method::Composed(_)).then(Increments::default),
        };
        let is_special =
            special.turns.is_some() || special.resolution.is_some() || special.increments.is_some();
        Self {
            energy: Energy::of(shape),
            alternation: Alternation::default(),
            arguments: Arguments::default(),
            special: is_special.then(|| Box::new(special)),
        }
    }

    /// Looks at the next node.
    #[inline]
    fn look<'r>(&mut self, node: &AnyNode<'_>, row: &impl Fn() -> Row<'r>) {
        self.energy.look(node, row);
        self.alternation.look(node.index, row);
        self.arguments.look(node, row);
        if let Some(special) = &mut self.special {
            special.look(node, row);
        }
    }

    /// The warnings, as in [`Observers::notes`].
    fn notes(&self, names: &[&str], method: Method, h: f64) -> [Option<String>; 4] {
        let special = self.special.as_deref();
        let resolution = || special?.resolution.as_ref()?.note(h);
        let turns = || special?.turns.as_ref()?.note(names.iter().copied(), method, h);
        let increments = || special?.increments.as_ref()?.note(names, h);
        [
            self.energy.note(method, h).or_else(resolution),
            turns().or_else(|| self.arguments.note(h)).or_else(increments),
            self.alternation.note(names.iter().copied(), method),
            None,
        ]
    }
}

impl Special {
    /// Looks at the next node.
    #[inline]
    fn look<'r>(&mut self, node: &AnyNode<'_>, row: &impl Fn() -> Row<'r>) {
        if let Some(turns) = &mut self.turns {
            turns.look(node);
        }
        if let Some(resolution) = &mut self.resolution {
            resolution.look(node.energy, row);
        }
        if let Some(increments) = &mut self.increments {
            increments.look(node.index, row);
        }
    }
}

impl Warnings {
    /// The observers for a run of a system by a method, with constant inputs.
    #[must_use]
    pub fn of(method: Method, shape: &Shape) -> Self {
        let observers = match method {
            Method::Tolerance(tolerance) => Observers::Tolerance {
                tolerance,
                conserved: is_closed(shape).then(Conserved::default),
                dependence: (shape.holonomic + shape.nonholonomic > 1).then(Dependence::default),
            },
            Method::Step | Method::Composed(_) => Observers::Steps(Steps::of(method, shape)),
        };
        Self {
            observers,
            masses: None,
        }
    }

    /// Inputs change from the next node on, and with them the energy. `values` are those of all parameters on the leg to the current node; empty if the
    /// first node is not made yet.
    pub fn drive(&mut self, values: &[f64]) {
        self.masses.get_or_insert_with(|| Masses::of(values));
        match &mut self.observers {
            Observers::Steps(steps) => steps.energy.is_open = true,
            Observers::Tolerance { conserved, .. } => {
                if let Some(conserved) = conserved {
                    conserved.is_open = true;
                }
            }
        }
    }

    /// Whether inputs have changed.
    #[must_use]
    pub fn is_driven(&self) -> bool {
        self.masses.is_some()
    }

    /// Whether all nodes of the run have to be looked at: the work between others is not known.
    #[inline]
    #[must_use]
    pub fn ask_for_all(&self) -> bool {
        matches!(&self.observers, Observers::Steps(steps) if steps.energy.is_open)
    }

    /// Looks at the next node. Its row is made where more than the node itself is needed: at few nodes of a long run.
    #[inline]
    pub fn look<'r>(&mut self, node: &AnyNode<'_>, row: impl Fn() -> Row<'r>) {
        if self.masses.is_some() {
            self.look_driven(node, &row);
        } else {
            self.observers.look(node, &row);
        }
    }

    /// [`Warnings::look`] in a run with inputs that change, kept apart from the others' loop.
    #[cold]
    fn look_driven<'r>(&mut self, node: &AnyNode<'_>, row: &dyn Fn() -> Row<'r>) {
        let departing = self.masses.as_mut().and_then(|masses| masses.look(&row()));
        // a velocity that has jumped is that with which the step begins
        self.observers.look(node, &|| match &departing {
            Some(departing) => Row {
                before: Some(departing),
                ..row()
            },
            None => row(),
        });
    }

    /// Looks at the inputs alone, where nodes between this one and the last were not looked at.
    pub fn look_at_inputs(&mut self, row: &Row<'_>) {
        if let Some(masses) = &mut self.masses {
            masses.look(row);
        }
    }

    /// The warnings for a run with the step `h`, in the words of the command line, with the names of the
    /// coordinates: on its energy, on bodies that rotate too far, on coordinates that alternate, on
    /// constraints that nearly depend on each other, and on inputs that are masses.
    #[must_use]
    pub fn notes(&self, names: &[&str], method: Method, h: f64) -> [Option<String>; 5] {
        let [energy, turns, alternation, dependence] = self.observers.notes(names, method, h);
        let masses = self.masses.as_ref().and_then(|masses| masses.note(names));
        [energy, turns, alternation, dependence, masses]
    }
}

impl Observers {
    /// Looks at the next node.
    #[inline]
    fn look<'r>(&mut self, node: &AnyNode<'_>, row: &impl Fn() -> Row<'r>) {
        match self {
            Self::Steps(steps) => steps.look(node, row),
            Self::Tolerance {
                conserved,
                dependence,
                ..
            } => {
                if let Some(conserved) = conserved {
                    conserved.look(node, row);
                }
                if let Some(dependence) = dependence {
                    dependence.look(node.index, row);
                }
            }
        }
    }

    /// The first four of [`Warnings::notes`].
    fn notes(&self, names: &[&str], method: Method, h: f64) -> [Option<String>; 4] {
        match self {
            Self::Steps(steps) => steps.notes(names, method, h),
            Self::Tolerance {
                tolerance,
                conserved,
                dependence,
            } => [
                conserved
                    .as_ref()
                    .and_then(|conserved| conserved.note(*tolerance)),
                None,
                None,
                dependence
                    .as_ref()
                    .and_then(|dependence| dependence.note(*tolerance)),
            ],
        }
    }
}
