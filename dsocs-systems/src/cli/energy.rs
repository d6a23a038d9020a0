//! Whether the energy of a run explodes.

use crate::entry::{Method, Row};

/// So many times its first value the energy of a run has to become before anything is said.
const EXPLODED: f64 = 1e4;

/// The energy of a run.
#[derive(Default)]
pub struct Energy {
    /// At the start.
    first: Option<f64>,
    /// The largest without its sign, and its time.
    largest: (f64, f64),
}

impl Energy {
    /// Looks at a node.
    pub fn look(&mut self, row: &Row<'_>) {
        self.first.get_or_insert(row.energy);
        if row.energy.abs() > self.largest.0.abs() {
            self.largest = (row.energy, row.t);
        }
    }

    /// What is to be said of a run with steps of its own. Where the energy begins with zero there is nothing to compare with.
    pub fn note(&self, method: Method, h: f64) -> Option<String> {
        let (first, (largest, t)) = (self.first?, self.largest);
        let exploded = first != 0.0 && largest.abs() >= EXPLODED * first.abs();
        if !exploded || matches!(method, Method::Tolerance(_)) {
            return None;
        }
        Some(format!(
            "warning: the energy grows from {first:.3} at the start to {largest:.1e} at t = {t}: unless something drives the system \
             that far, the step h = {h} is too long for it (a smaller `--step`; `--estimate-error` measures what it costs)"
        ))
    }
}
