//! Warnings about a run: an energy that changes without cause; with steps of a fixed length one that
//! explodes, forces that change too fast for the step, bodies that rotate too far in a step, coordinates that alternate from step to step, and with
//! compositions coordinates that move otherwise than their velocities say; and constraints that nearly depend on
//! each other. The command line and the Python package give the same warnings.

mod alternation;
mod conserved;
mod dependence;
mod energy;
mod increments;
mod inputs;
mod resolution;
mod start;
mod turns;

use dsocs_core::Shape;

use crate::entry::{Method, Row, is_closed};

use alternation::Alternation;
use conserved::Conserved;
use dependence::Dependence;
use energy::Energy;
use increments::Increments;
pub use inputs::passed_inputs;
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

/// The observers of the nodes of a run.
#[derive(Default)]
pub struct Warnings(Observers);

#[derive(Default)]
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
    #[default]
    Nothing,
}

/// What is observed with steps of a fixed length.
#[derive(Default)]
struct Steps {
    energy: Energy,
    alternation: Alternation,
    /// What only some systems and methods have. Behind one branch: each costs every step.
    special: Option<Box<Special>>,
}

/// What is observed of some systems, and with some methods.
#[derive(Default)]
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
            turns: (!shape.rotations.is_empty()).then(Turns::default),
            resolution: (shape.external_forces || shape.depends_on_time).then(Resolution::default),
            increments: matches!(method, Method::Composed(_)).then(Increments::default),
        };
        let is_special =
            special.turns.is_some() || special.resolution.is_some() || special.increments.is_some();
        Self {
            special: is_special.then(|| Box::new(special)),
            ..Self::default()
        }
    }

    /// Looks at the next node.
    #[inline]
    fn look(&mut self, row: &Row<'_>) {
        self.energy.look(row);
        self.alternation.look(row);
        if let Some(special) = &mut self.special {
            special.look(row);
        }
    }

    /// The warnings, as in [`Warnings::notes`].
    fn notes(&self, names: &[&str], method: Method, h: f64) -> [Option<String>; 4] {
        let special = self.special.as_deref();
        let resolution = || special?.resolution.as_ref()?.note(h);
        let turns = || special?.turns.as_ref()?.note(names.iter().copied(), method, h);
        let increments = || special?.increments.as_ref()?.note(names, h);
        [
            self.energy.note(method, h).or_else(resolution),
            turns().or_else(increments),
            self.alternation.note(names.iter().copied(), method),
            None,
        ]
    }
}

impl Special {
    /// Looks at the next node.
    fn look(&mut self, row: &Row<'_>) {
        if let Some(turns) = &mut self.turns {
            turns.look(row);
        }
        if let Some(resolution) = &mut self.resolution {
            resolution.look(row);
        }
        if let Some(increments) = &mut self.increments {
            increments.look(row);
        }
    }
}

impl Warnings {
    /// The observers for a run of a system by a method.
    #[must_use]
    pub fn of(method: Method, shape: &Shape) -> Self {
        Self(match method {
            Method::Tolerance(tolerance) => Observers::Tolerance {
                tolerance,
                conserved: is_closed(shape).then(Conserved::default),
                dependence: (shape.holonomic + shape.nonholonomic > 1).then(Dependence::default),
            },
            Method::Step | Method::Composed(_) => Observers::Steps(Steps::of(method, shape)),
        })
    }

    /// Whether nodes are observed, and whether work and energy between them are needed.
    #[must_use]
    pub fn looks(&self) -> [bool; 2] {
        [
            match &self.0 {
                Observers::Steps(_) => true,
                Observers::Tolerance {
                    conserved,
                    dependence,
                    ..
                } => conserved.is_some() || dependence.is_some(),
                Observers::Nothing => false,
            },
            matches!(self.0, Observers::Steps(_)),
        ]
    }

    /// Looks at the next node.
    #[inline]
    pub fn look(&mut self, row: &Row<'_>) {
        match &mut self.0 {
            Observers::Steps(steps) => steps.look(row),
            Observers::Tolerance {
                conserved,
                dependence,
                ..
            } => {
                if let Some(conserved) = conserved {
                    conserved.look(row);
                }
                if let Some(dependence) = dependence {
                    dependence.look(row);
                }
            }
            Observers::Nothing => {}
        }
    }

    /// The warnings for a run with the step `h`, in the words of the command line, with the names of the
    /// coordinates: on its energy, on bodies that rotate too far, on coordinates that alternate, and on
    /// constraints that nearly depend on each other.
    #[must_use]
    pub fn notes(&self, names: &[&str], method: Method, h: f64) -> [Option<String>; 4] {
        match &self.0 {
            Observers::Steps(steps) => steps.notes(names, method, h),
            Observers::Tolerance {
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
            Observers::Nothing => [None, None, None, None],
        }
    }
}
