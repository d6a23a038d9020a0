//! Whether the energy of a run explodes, or changes where nothing changes it.

use crate::entry::{Method, Row};

/// So many times its first value the energy of a run has to become before anything is said.
const EXPLODED: f64 = 1e4;

/// What is missing in the balance of the energy is told from this part of the mean of its terms on.
const MISSING: f64 = 0.1;

/// The energy of a run.
#[derive(Default)]
pub struct Energy {
    /// At the start.
    first: Option<f64>,
    /// The largest without its sign, and its time.
    largest: (f64, f64),
    /// Where it is known what changes it.
    balance: Balance,
}

/// The energy less the work of the constraint forces.
#[derive(Default)]
struct Balance {
    /// Time and power at the last node.
    last: Option<(f64, f64)>,
    /// The work so far.
    work: f64,
    /// The sum of the energy's terms at the nodes that tell them, and how many there are.
    terms: (f64, f64),
    /// The largest difference from the start's energy, the energy there, and its time.
    missing: (f64, f64, f64),
}

impl Balance {
    /// Looks at a node whose energy is compared with that of the start.
    fn look(&mut self, row: &Row<'_>, first: f64, (power, terms): (f64, Option<f64>)) {
        if let Some((t, before)) = self.last.replace((row.t, power)) {
            self.work += (row.t - t) * (power + before) / 2.0;
        }
        if let Some(terms) = terms {
            self.terms = (self.terms.0 + terms, self.terms.1 + 1.0);
        }
        let missing = (row.energy - first - self.work).abs();
        if missing > self.missing.0 {
            self.missing = (missing, row.energy, row.t);
        }
    }
}

impl Energy {
    /// Looks at a node.
    pub fn look(&mut self, row: &Row<'_>) {
        let first = *self.first.get_or_insert(row.energy);
        if row.energy.abs() > self.largest.0.abs() {
            self.largest = (row.energy, row.t);
        }
        if let Some(balance) = row.balance {
            self.balance.look(row, first, balance);
        }
    }

    /// What is to be said of a run with steps of its own. Where the energy begins with zero there is nothing to compare with.
    pub fn note(&self, method: Method, h: f64) -> Option<String> {
        let (first, (largest, t)) = (self.first?, self.largest);
        let exploded = first != 0.0 && largest.abs() >= EXPLODED * first.abs();
        if matches!(method, Method::Tolerance(_)) {
            return None;
        }
        if exploded {
            return Some(format!(
                "warning: the energy grows from {first:.3} at the start to {largest:.1e} at t = {t}: unless something drives the system \
                 that far, the step h = {h} is too long for it (a smaller `--step`; `--estimate-error` measures what it costs). If half the \
                 step gives the same energy, look at the signs of the forces"
            ));
        }
        let (missing, energy, t) = self.balance.missing;
        let (sum, count) = self.balance.terms;
        (missing * count > MISSING * sum).then(|| {
            format!(
                "warning: the energy is {energy:.3e} at t = {t}, and was {first:.3e} at the start, although nothing that is declared changes it so: \
                 the step h = {h} is too long somewhere before, or the motion has passed a corner of a constraint, a jump or a singularity, \
                 where the step does not know how to go on (a smaller `--step` tells; a run with `--tolerance 1e-9` ends at such a place)"
            )
        })
    }
}
