//! Whether the energy of a run explodes, or changes where nothing changes it.

use crate::entry::{Method, Row};

/// So many times its first value the energy of a run has to become before anything is said.
const EXPLODED: f64 = 1e4;

/// Of a run with fewer nodes nothing is said of a growth from zero.
const FEW: u64 = 64;

/// What is missing in the balance of the energy is told from this part of the mean of its terms on.
const MISSING: f64 = 0.1;

/// The energy of a run.
#[derive(Default)]
pub struct Energy {
    /// At the start.
    first: Option<f64>,
    /// The largest without its sign, and its time.
    largest: (f64, f64),
    /// How it grows, where it begins with zero.
    growth: Growth,
    /// Where it is known what changes it.
    balance: Balance,
}

/// The largest energy at earlier nodes, counted from the first that has any: what it grows by while the run becomes two to four times as long.
///
/// A force that drives a system from rest gives it an energy that grows as a power of the time, by a factor of some tens; where steps are too
/// long, the energy grows exponentially.
#[derive(Default)]
struct Growth {
    /// How many nodes there were.
    nodes: u64,
    /// The largest energy without its sign, and its time, after the last power of two of nodes, and after half as many.
    before: [(f64, f64); 2],
}

impl Growth {
    /// Looks at a node, with the largest energy so far.
    fn look(&mut self, largest: (f64, f64)) {
        if largest.0 == 0.0 {
            return;
        }
        self.nodes += 1;
        if self.nodes.is_power_of_two() {
            self.before = [largest, self.before[0]];
        }
    }
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
        if first == 0.0 {
            self.growth.look(self.largest);
        }
        if let Some(balance) = row.balance {
            self.balance.look(row, first, balance);
        }
    }

    /// What is to be said of a run with steps of its own.
    pub fn note(&self, method: Method, h: f64) -> Option<String> {
        let (first, (largest, t)) = (self.first?, self.largest);
        if matches!(method, Method::Tolerance(_)) {
            return None;
        }
        let exploded = |before: f64| largest.abs() >= EXPLODED * before.abs();
        let grows = if first != 0.0 && exploded(first) {
            Some(format!("{first:.3} at the start"))
        } else if first == 0.0 && self.growth.nodes >= FEW {
            let (before, then) = self.growth.before[1];
            exploded(before).then(|| format!("0 at the start, and {before:.1e} at t = {then},"))
        } else {
            None
        };
        if let Some(before) = grows {
            return Some(format!(
                "warning: the energy grows from {before} to {largest:.1e} at t = {t}: unless something drives the system \
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

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use dsocs_core::dsocs;

    use super::*;
    use crate::entry::{Beginning, Entry, Plan};

    /// A mass on a spring that a force drives.
    #[dsocs {
        coordinates(x);
        lagrangian = dot(x).powi(2) / 2 - stiffness / 2 * x.powi(2);
        external_forces = (3 * t).sin() + pull;
    }]
    #[derive(Clone)]
    struct Driven {
        stiffness: f64,
        pull: f64,
    }

    /// A bead that slides down to the corner of its wire.
    #[dsocs {
        coordinates(x, y);
        lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - 9.81 * y;
        holonomic = y - sharp * x.abs() - (0.8 - sharp) * (x.powi(2) + 1).sqrt();
    }]
    #[derive(Clone)]
    struct Corner {
        sharp: f64,
    }

    /// What is said of a run from a position, at rest.
    fn note(entry: &Entry, q0: &[f64], h: f64, until: f64) -> Option<String> {
        let plan = Plan {
            h,
            until,
            method: Method::Step,
            certify: false,
            estimate: false,
            inputs: Vec::new(),
        };
        let beginning = Beginning::Projected(Box::new(Beginning::SecondOrder {
            q0: q0.to_vec(),
            v0: vec![0.0; q0.len()],
        }));
        let mut energy = Energy::default();
        let run = entry.run(&plan, &beginning, &mut |row| {
            energy.look(row);
            ControlFlow::Continue(())
        });
        run.unwrap();
        energy.note(plan.method, h)
    }

    #[test]
    fn steps_that_are_too_long_are_told_also_where_the_energy_begins_with_zero() {
        let driven = |stiffness, pull| Entry::new(Driven { stiffness, pull });
        for (x0, words) in [
            (1.0, "from 50.000 at the start"),
            (0.0, "from 0 at the start, and"),
        ] {
            let told = note(&driven(100.0, 0.0), &[x0], 0.21, 20.0).unwrap();
            assert!(told.contains(words), "{told}");
            assert_eq!(note(&driven(100.0, 0.0), &[x0], 0.01, 20.0), None);
        }
        // a force that drives the system all the time: no spring, in resonance, and none for a long time
        for (stiffness, pull) in [(0.0, 5.0), (0.0, 0.0), (9.0, 0.0)] {
            for until in [1.0, 300.0] {
                assert_eq!(note(&driven(stiffness, pull), &[0.0], 0.01, until), None);
            }
        }
    }

    #[test]
    fn an_energy_that_a_corner_changes_is_told() {
        let corner = |sharp| note(&Entry::new(Corner { sharp }), &[1.0, 1.0], 0.01, 3.0);
        let told = corner(0.8).unwrap();
        assert!(
            told.contains("although nothing that is declared changes it so"),
            "{told}"
        );
        assert_eq!(corner(0.0), None);
    }
}
