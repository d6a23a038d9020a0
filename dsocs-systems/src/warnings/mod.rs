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

/// The observers of the nodes of a run.
#[derive(Default)]
pub struct Warnings(Observers);

#[derive(Default)]
#[expect(clippy::large_enum_variant, reason = "there is one for a run")]
enum Observers {
    /// With steps of a fixed length.
    Steps(Steps),
    /// With steps of a fixed length, and more to observe: every branch of the others would cost each of their steps.
    MoreOfSteps(Steps, More),
    /// With a tolerance: where the energy cannot change, and where constraints may depend on each other.
    Tolerance {
        tolerance: f64,
        conserved: Option<Conserved>,
        dependence: Option<Dependence>,
    },
    #[default]
    Nothing,
}

/// What is observed with all steps of a fixed length.
#[derive(Default)]
struct Steps {
    energy: Energy,
    turns: Turns,
    alternation: Alternation,
}

impl Steps {
    /// Looks at the next node.
    #[inline]
    fn look(&mut self, row: &Row<'_>) {
        self.energy.look(row);
        self.turns.look(row);
        self.alternation.look(row);
    }

    /// The warnings, as in [`Warnings::notes`].
    fn notes(&self, names: &[&str], method: Method, h: f64) -> [Option<String>; 4] {
        let names = || names.iter().copied();
        [
            self.energy.note(method, h),
            self.turns.note(names(), method, h),
            self.alternation.note(names(), method),
            None,
        ]
    }
}

/// What is observed with some.
struct More {
    /// Where external forces or the time change the energy.
    resolution: Option<Resolution>,
    /// Of a composition.
    increments: Option<Increments>,
}

impl More {
    /// The observers for a run of a system by a method, if there are any.
    fn of(method: Method, shape: &Shape) -> Option<Self> {
        let more = Self {
            resolution: (shape.external_forces || shape.depends_on_time).then(Resolution::default),
            increments: matches!(method, Method::Composed(_)).then(Increments::default),
        };
        (more.resolution.is_some() || more.increments.is_some()).then_some(more)
    }

    /// Looks at the next node.
    fn look(&mut self, row: &Row<'_>) {
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
            Method::Step | Method::Composed(_) => match More::of(method, shape) {
                None => Observers::Steps(Steps::default()),
                Some(more) => Observers::MoreOfSteps(Steps::default(), more),
            },
        })
    }

    /// Whether nodes are observed, and whether work and energy between them are needed.
    #[must_use]
    pub fn looks(&self) -> [bool; 2] {
        [
            match &self.0 {
                Observers::Steps(_) | Observers::MoreOfSteps(..) => true,
                Observers::Tolerance {
                    conserved,
                    dependence,
                    ..
                } => conserved.is_some() || dependence.is_some(),
                Observers::Nothing => false,
            },
            matches!(self.0, Observers::Steps(_) | Observers::MoreOfSteps(..)),
        ]
    }

    /// Looks at the next node.
    #[inline]
    pub fn look(&mut self, row: &Row<'_>) {
        match &mut self.0 {
            Observers::Steps(steps) => steps.look(row),
            Observers::MoreOfSteps(steps, more) => {
                steps.look(row);
                more.look(row);
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
        match &self.0 {
            Observers::Steps(steps) => steps.notes(names, method, h),
            Observers::MoreOfSteps(steps, more) => {
                let [energy, turns, alternation, dependence] = steps.notes(names, method, h);
                [
                    energy.or_else(|| more.resolution.as_ref()?.note(h)),
                    turns.or_else(|| more.increments.as_ref()?.note(names, h)),
                    alternation,
                    dependence,
                ]
            }
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
