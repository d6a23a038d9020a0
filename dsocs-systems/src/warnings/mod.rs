//! What is to be said of a run with steps of a fixed length whose nodes look wrong: an energy that explodes or changes where nothing changes it, bodies that turn too far in a
//! step, coordinates that go to and fro; and of constraints that nearly depend on each other. The command line and the Python package tell the same.

mod alternation;
mod dependence;
mod energy;
mod start;
mod turns;

use crate::entry::{Method, Row};

use alternation::Alternation;
use dependence::Dependence;
use energy::Energy;
pub use start::moved_start;
use turns::Turns;

/// What is looked at in the nodes of a run.
#[derive(Default)]
pub struct Warnings {
    energy: Energy,
    turns: Turns,
    alternation: Alternation,
    dependence: Dependence,
}

impl Warnings {
    /// Looks at the next node.
    #[inline]
    pub fn look(&mut self, row: &Row<'_>) {
        self.energy.look(row);
        self.turns.look(row);
        self.alternation.look(row);
        self.dependence.look(row);
    }

    /// What is to be said of a run with the step `h`, in the words of the command line, with the names of the coordinates: of its energy, of bodies that turn, and of coordinates
    /// that go to and fro, and of constraints that nearly depend on each other.
    #[must_use]
    pub fn notes(&self, names: &[&str], method: Method, h: f64) -> [Option<String>; 4] {
        let names = || names.iter().copied();
        [
            self.energy.note(method, h),
            self.turns.note(names(), method, h),
            self.alternation.note(names(), method),
            self.dependence.note(method),
        ]
    }
}
