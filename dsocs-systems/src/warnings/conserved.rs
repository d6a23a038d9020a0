//! Detects, in a run to a tolerance, that an energy which nothing declared can change is not constant.

use dsocs_core::AnyNode;

use crate::entry::Row;

use super::{constraint_power, energy_terms};

/// A change of the energy is reported if it exceeds this many tolerances, relative to the mean over the nodes
/// of the energy's size.
const TOLERANCES: f64 = 1000.0;
/// It also has to exceed this many tolerances, relative to the largest of these sums: near a pole the error
/// of a step is relative to the terms there.
const OF_LARGEST: f64 = 10.0;
/// A change that exceeds this part of the mean sum is reported, whatever the tolerance.
const MISSING: f64 = 0.005;

/// Smaller tolerances count as this one: no run is more accurate than rounding.
const LEAST: f64 = 1e-14;

/// A change of the energy is not reported if a bound for the work of constraint forces exceeds this part of
/// the change.
const EXPLAINS: f64 = 0.1;

/// After node `n` the terms are next summed at node `n + 1 + n / APART`: at every node at first, and less
/// often later.
const APART: u64 = 32;
/// They are also summed where the change of the energy has grown by this factor since the last sum.
const GROWS: f64 = 2.0;

/// The slope of the energy is a quotient of differences over this part of the velocity.
const SLOWER: f64 = 1e-7;

/// The energy of a run.
#[derive(Debug, Default)]
pub struct Conserved {
    /// At the start.
    first: Option<f64>,
    /// The largest change of the energy since the start, with its sign, and its time.
    missing: (f64, f64),
    /// The change at which the terms are summed next.
    grown: f64,
    /// The number of nodes, and that at which the terms are summed next.
    nodes: u64,
    next: u64,
    /// The number of nodes at the last sum of terms, the sum over all nodes, and the largest.
    terms: (u64, f64, f64),
    /// The time of that sum, and the size of the power of constraint forces there.
    power: (f64, f64),
    /// A bound for the work of constraint forces.
    work: f64,
    /// Whether inputs change the energy, too, from here on.
    pub is_open: bool,
}

impl Conserved {
    /// Looks at a node.
    #[inline]
    pub fn look<'r>(&mut self, node: &AnyNode<'_>, row: &impl Fn() -> Row<'r>) {
        if self.is_open {
            return;
        }
        let (energy, t) = (node.energy, node.t);
        let missing = energy - *self.first.get_or_insert(energy);
        if missing.abs() > self.missing.0.abs() {
            self.missing = (missing, t);
        }
        if self.nodes >= self.next || missing.abs() > self.grown {
            self.grown = GROWS * self.missing.0.abs();
            self.sum(&row());
        }
        self.nodes += 1;
    }

    /// Sums the terms of energy and power at a node.
    #[cold]
    fn sum(&mut self, row: &Row<'_>) {
        let (t, size) = (row.node.t, energy_size(row));
        let (before, sum, largest) = self.terms;
        let since = if self.nodes == 0 { 1 } else { self.nodes - before };
        self.terms = (self.nodes, sum + since as f64 * size, largest.max(size));
        self.next = self.nodes + 1 + self.nodes / APART;
        let shape = row.declaration.shape();
        if shape.holonomic + shape.nonholonomic == 0 {
            return;
        }
        let power = constraint_power(&row.node).abs();
        let (then, earlier) = core::mem::replace(&mut self.power, (t, power));
        if self.nodes > 0 {
            self.work += (t - then).abs() * power.max(earlier);
        }
    }

    /// The warning for a run to a tolerance.
    pub fn note(&self, tolerance: f64) -> Option<String> {
        let first = self.first?;
        let (change, t) = self.missing;
        let (last, sum, largest) = self.terms;
        let (missing, tolerance) = (change.abs(), tolerance.max(LEAST));
        let size = sum / (last + 1) as f64;
        let of_tolerance = tolerance * (TOLERANCES * size).max(OF_LARGEST * largest);
        let allowed = of_tolerance
            .min(MISSING * size)
            .max(TOLERANCES * f64::EPSILON * largest);
        let is_told = missing > allowed && self.work < EXPLAINS * missing;
        is_told.then(|| {
            let (part, times) = (missing / size, missing / size / tolerance);
            format!(
                "warning: the energy was {first:.4e} at the start and has changed by {change:.1e} up to t = {t}, although nothing that is declared changes it: by {part:.0e} \
                 of the size of its terms, which is {times:.0} tolerances. Either the errors of many steps have added up to that, or the motion has passed a place where it \
                 changes faster than the steps were short; a smaller `--tolerance` helps in both cases. Where the energy jumps and no force does, as with the angle \
                 `y.atan2(x)` on its cut, the motion is right, and the energy is that of another turn"
            )
        })
    }
}

/// The size of the energy at a node: the sum of its terms, or the velocity times the energy's slope by it, if that is larger. Near the
/// speed of light an error of the velocity of one tolerance is one of many in the energy.
fn energy_size(row: &Row<'_>) -> f64 {
    let (node, declaration) = (&row.node, &row.declaration);
    let slower: Vec<f64> = node.v.iter().map(|v| v * (1.0 - SLOWER)).collect();
    let change = node.energy - declaration.energy::<f64>(node.t, node.q, &slower);
    energy_terms(declaration, node).max((change / SLOWER).abs())
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use dsocs_core::text::Text;

    use super::super::Warnings;
    use crate::entry::{Beginning, Entry, Method, Plan};

    /// The warning about the energy of a run of a text to a tolerance, with nodes `h` apart.
    fn told(text: &str, [q0, v0]: [&[f64]; 2], tolerance: f64, [h, until]: [f64; 2]) -> Option<String> {
        let entry = Entry::of_text("system", &Text::parse("system", text).unwrap(), None);
        let method = Method::Tolerance(tolerance);
        let plan = Plan {
            h,
            until,
            method,
            certify: false,
            estimate: false,
            inputs: Vec::new(),
        };
        let start = Beginning::SecondOrder {
            q0: q0.to_vec(),
            v0: v0.to_vec(),
        };
        let mut warnings = Warnings::of(method, entry.kernel().shape());
        entry
            .run(&plan, &start, &mut |row| {
                warnings.look(&row.node, || *row);
                ControlFlow::Continue(())
            })
            .unwrap();
        let [energy, ..] = warnings.notes(&["x", "y"], method, h);
        energy
    }

    const KEPLER: &str = "coordinates(x, y);
        lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 + 1 / (x.powi(2) + y.powi(2)).sqrt();";

    #[test]
    fn an_energy_that_nothing_changes_is_watched() {
        // from the farthest point, for ten revolutions
        for (e, tolerance, is_told) in [
            (0.999_f64, 1e-4, true),
            (0.999, 1e-3, true),
            (0.9, 1e-9, false),
            (0.3, 1e-4, false),
            (0.3, 1e-13, false),
        ] {
            let v = ((1.0 - e) / (1.0 + e)).sqrt();
            for h in [0.01, 0.37] {
                let said = told(KEPLER, [&[1.0 + e, 0.0], &[0.0, v]], tolerance, [h, 62.9]);
                assert_eq!(said.is_some(), is_told, "{e} {tolerance}: {said:?}");
                let words = "although nothing that is declared changes it";
                assert!(said.is_none_or(|said| said.contains(words)));
            }
        }
        // the errors of many steps
        let spring = "coordinates(r, p);
            lagrangian = (dot(r).powi(2) + (r * dot(p)).powi(2)) / 2 + 9.81 * r * p.cos() - 200 * (r - 1).powi(2);";
        let said = |tolerance: f64| told(spring, [&[1.0, 1.5], &[0.0; 2]], tolerance, [1.0, 2000.0]);
        assert!(said(1e-4).is_some());
        assert_eq!(said(1e-9), None);
    }

    #[test]
    fn an_energy_that_magnifies_the_errors_of_the_velocity_is_not() {
        // a particle of unit mass in a constant field, nearly at the speed of light
        let text = "coordinates(x, y);
            lagrangian = -(1 - dot(x).powi(2) - dot(y).powi(2)).sqrt() + x;";
        for tolerance in [1e-6, 1e-9, 1e-12] {
            let said = told(text, [&[0.0; 2], &[0.0, 0.1]], tolerance, [0.1, 300.0]);
            assert_eq!(said, None, "{tolerance}");
        }
    }

    #[test]
    fn nothing_is_said_where_the_energy_may_change() {
        // a turntable of constant rate, a damped mass, and one on a moving carriage
        for text in [
            "coordinates(x, y);
            lagrangian = (dot(x).powi(2) + dot(y).powi(2) * (1 + x.powi(2)) - 3 * x.powi(2)) / 2;
            nonholonomic = dot(y) - 1.3;",
            "coordinates(x, y); lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2; external_forces = (-dot(x), 0);",
            "coordinates(x, y); lagrangian = ((dot(x) + t.cos()).powi(2) + dot(y).powi(2)) / 2;",
        ] {
            for tolerance in [1e-4, 1e-9] {
                for h in [0.01, 0.7] {
                    let said = told(text, [&[1.0, 0.0], &[0.3, 1.3]], tolerance, [h, 4.2]);
                    assert_eq!(said, None, "{text}");
                }
            }
        }
    }
}
