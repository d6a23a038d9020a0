//! Warnings about a run: an energy that changes without cause; with steps of a fixed length one that
//! explodes, bodies that rotate too far in a step, and coordinates that alternate from step to step; and
//! constraints that nearly depend on each other. The command line and the Python package give the same warnings.

mod alternation;
mod conserved;
mod dependence;
mod energy;
mod inputs;
mod start;
mod turns;

use dsocs_core::Shape;

use crate::entry::{Method, Row, is_closed};

use alternation::Alternation;
use conserved::Conserved;
use dependence::Dependence;
use energy::Energy;
pub use inputs::passed_inputs;
pub use start::moved_start;
use turns::Turns;

/// The observers of the nodes of a run.
#[derive(Default)]
pub struct Warnings(Observers);

#[derive(Default)]
#[expect(clippy::large_enum_variant, reason = "there is one for a run")]
enum Observers {
    /// With steps of a fixed length.
    Steps {
        energy: Energy,
        turns: Turns,
        alternation: Alternation,
    },
    /// With a tolerance: where the energy cannot change, and where constraints may depend on each other.
    Tolerance {
        tolerance: f64,
        conserved: Option<Conserved>,
        dependence: Option<Dependence>,
    },
    #[default]
    Nothing,
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
            Method::Step | Method::Composed(_) => Observers::Steps {
                energy: Energy::default(),
                turns: Turns::default(),
                alternation: Alternation::default(),
            },
        })
    }

    /// Whether nodes are observed, and whether work and energy between them are needed.
    #[must_use]
    pub fn looks(&self) -> [bool; 2] {
        [
            match &self.0 {
                Observers::Steps { .. } => true,
                Observers::Tolerance {
                    conserved,
                    dependence,
                    ..
                } => conserved.is_some() || dependence.is_some(),
                Observers::Nothing => false,
            },
            matches!(self.0, Observers::Steps { .. }),
        ]
    }

    /// Looks at the next node.
    #[inline]
    pub fn look(&mut self, row: &Row<'_>) {
        match &mut self.0 {
            Observers::Steps {
                energy,
                turns,
                alternation,
            } => {
                energy.look(row);
                turns.look(row);
                alternation.look(row);
            }
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
        let names = || names.iter().copied();
        match &self.0 {
            Observers::Steps {
                energy,
                turns,
                alternation,
            } => [
                energy.note(method, h),
                turns.note(names(), method, h),
                alternation.note(names(), method),
                None,
            ],
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
