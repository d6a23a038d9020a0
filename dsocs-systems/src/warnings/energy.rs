//! Detects an energy that explodes, or that changes although no declared force changes it.

use dsocs_core::geometry::power_with;
use dsocs_core::{AnyNode, Shape, Stop};

use crate::entry::{Method, Row};

use super::{constraint_power, energy_terms, is_closed};

/// The energy has exploded if it is this many times its first value.
const EXPLOSION: f64 = 1e4;

/// The smallest number of nodes at which a growth from zero is reported.
const LEAST_NODES: u64 = 64;

/// The work is summed from an energy of this many times the first on: earlier work is no part of an
/// explosion.
const WORK_FROM: f64 = 1e3;

/// A growth is explained if the work of the declared forces makes at least this part of it.
const EXPLAINED_PART: f64 = 0.5;

/// The smallest defect of the energy balance that is reported, relative to the mean of its terms, and to its terms at that time: where a motion
/// leaves an equilibrium, as `x = e^t` does, the terms grow exponentially, and with them the error of their difference, at any step.
const LEAST_DEFECT: f64 = 0.15;

/// The energy's terms are summed at every node whose number is a multiple of this, and later at fewer: after node `n` next at
/// node `n + n / TERMS_APART`, if that is farther.
const TERMS_EVERY: u64 = 16;
const TERMS_APART: u64 = 256;

/// The energy of a run.
#[derive(Default)]
pub struct Energy {
    /// Whether the energy may change by external forces, by terms that depend on time, or by inputs, too.
    pub is_open: bool,
    /// At the start.
    first: Option<f64>,
    /// Its terms.
    terms: Terms,
    /// The largest energy by absolute value, and its time.
    largest: (f64, f64),
    /// The size of its terms about that time.
    terms_at_largest: f64,
    /// The work of all declared forces, up to that time.
    given: f64,
    /// The work up to the last node.
    work: Option<Work>,
    /// Its growth.
    growth: Growth,
    /// The energy balance, where the forces that change the energy are known.
    balance: Balance,
}

/// The largest energy at earlier nodes, counted from the first that is not zero: shows the growth while the
/// run becomes two to four times as long.
///
/// A force that drives a system from rest gives it an energy that grows as a power of the time, by a factor of some tens; where steps are too
/// long, the energy grows exponentially.
#[derive(Default)]
struct Growth {
    /// The number of nodes.
    nodes: u64,
    /// The largest energy by absolute value, and its time, at the last power of two of nodes, and at half as
    /// many.
    before: [(f64, f64); 2],
}

impl Growth {
    /// Looks at a node, with the largest energy so far.
    #[inline]
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

/// The work of everything declared: external forces, constraint forces, and terms that depend on time.
struct Work {
    /// The energy at which the sum begins.
    from: f64,
    /// The time and the power at the last node.
    last: (f64, f64),
    /// The sum, in J.
    sum: f64,
}

impl Work {
    /// Looks at a node.
    #[cold]
    fn look(work: &mut Option<Self>, row: &Row<'_>) {
        let node = &row.node;
        let power = power_with(&row.declaration, (node.t, node.q, node.v), node.force);
        let Some(Self { last, sum, .. }) = work else {
            *work = Some(Self {
                from: node.energy,
                last: (node.t, power),
                sum: 0.0,
            });
            return;
        };
        let (before, earlier) = core::mem::replace(last, (node.t, power));
        *sum += (node.t - before) * (earlier + power) / 2.0;
    }
}

/// The energy less the work of the constraint forces.
#[derive(Default)]
struct Balance {
    /// Whether there are constraints; without them the constraint force is rounding.
    is_constrained: bool,
    /// The power of the constraint forces at the last nodes, the latest at the end.
    powers: [f64; WINDOW],
    /// The last nodes, the latest at the end, and the time of the first.
    last: [Moment; 3],
    start: f64,
    /// The number of nodes.
    count: u64,
    /// The median power at the node before the middle one.
    before: Option<f64>,
    /// The work up to the middle node.
    work: f64,
    /// The largest defect of the balance since the start among those that are a part of the terms, the energy there, and its time.
    missing: (f64, f64, f64),
}

/// The size of the energy's terms.
#[derive(Default)]
struct Terms {
    /// The number of nodes, and that at which the terms are summed next.
    count: u64,
    next: u64,
    /// Their size at the last such node.
    latest: f64,
    /// The sum of their size over all nodes, those between two sums taken as the first of them, and the number of nodes.
    sum: (f64, f64),
}

impl Terms {
    /// Looks at a node.
    #[inline]
    fn look<'r>(&mut self, row: &impl Fn() -> Row<'r>) {
        if self.count == self.next {
            self.add(&row());
        }
        self.count += 1;
    }

    /// Sums the terms at a node: some nodes are enough for their mean.
    #[cold]
    fn add(&mut self, row: &Row<'_>) {
        let apart = TERMS_EVERY.max(self.count / TERMS_APART);
        let (sum, count) = self.sum;
        self.latest = energy_terms(&row.declaration, &row.node);
        self.sum = (sum + apart as f64 * self.latest, count + apart as f64);
        self.next += apart;
    }
}

/// The number of consecutive powers of which the median is taken.
///
/// Where a velocity jumps, the computed force is that of an impact: its power at the two nodes of the step
/// across the jump would explain a part of the change of the energy. The power of a constraint force that
/// does work is nonzero at more nodes than these.
const WINDOW: usize = 5;

/// The time and the energy of a node.
#[derive(Clone, Copy, Default)]
struct Moment {
    /// Its time.
    t: f64,
    /// Its energy.
    energy: f64,
}

impl Balance {
    /// Looks at a node, with the energy at the start and the size of the terms.
    #[inline(never)]
    fn look(&mut self, node: &AnyNode<'_>, first: f64, terms: f64) {
        self.count += 1;
        let now = Moment {
            t: node.t,
            energy: node.energy,
        };
        if self.is_constrained {
            self.look_at_power(now, (first, terms), constraint_power(node));
        } else {
            self.compare(now, (first, terms));
        }
    }

    /// Looks at the power of the constraint forces at a node.
    #[inline]
    fn look_at_power(&mut self, node: Moment, to: (f64, f64), power: f64) {
        let [_, b, c, d, e] = self.powers;
        self.powers = [b, c, d, e, power];
        let [earlier, now, next] = self.last;
        self.last = [now, next, node];
        if self.count < WINDOW as u64 {
            self.start = if self.count == 1 { node.t } else { self.start };
            return;
        }
        let power = median(self.powers);
        // the first interval begins at the start
        self.work += match self.before.replace(power) {
            Some(before) => (now.t - earlier.t) * (power + before) / 2.0,
            None => (now.t - self.start) * power,
        };
        self.compare(now, to);
    }

    /// Compares the energy at a node with that at the start and the work.
    #[inline]
    fn compare(&mut self, now: Moment, (first, terms): (f64, f64)) {
        let missing = (now.energy - first - self.work).abs();
        if missing > self.missing.0 && missing > LEAST_DEFECT * terms {
            self.missing = (missing, now.energy, now.t);
        }
    }
}

/// The median of five numbers.
#[inline]
fn median([a, b, c, d, e]: [f64; WINDOW]) -> f64 {
    // in order, as the powers of a smooth motion nearly always are
    if (a <= b && b <= c && c <= d && d <= e) || (a >= b && b >= c && c >= d && d >= e) {
        return c;
    }
    // neither the least nor the largest of the first four
    let (low, high) = (a.min(b).max(c.min(d)), a.max(b).min(c.max(d)));
    low.min(high).max(low.max(high).min(e))
}

impl Energy {
    /// The observer for a run of a system.
    pub fn of(shape: &Shape) -> Self {
        Self {
            is_open: !is_closed(shape),
            balance: Balance {
                is_constrained: shape.holonomic + shape.nonholonomic > 0,
                ..Balance::default()
            },
            ..Self::default()
        }
    }

    /// Looks at a node.
    #[inline]
    pub fn look<'r>(&mut self, node: &AnyNode<'_>, row: &impl Fn() -> Row<'r>) {
        let (energy, size) = (node.energy, node.energy.abs());
        let first = *self.first.get_or_insert(energy);
        if self.is_open && (self.work.is_some() || size >= WORK_FROM * first.abs()) {
            Work::look(&mut self.work, &row());
        }
        // where a force may change the energy, its terms tell only whether a large one is a small difference
        if !self.is_open || size >= WORK_FROM * first.abs() {
            self.terms.look(row);
        }
        if size > self.largest.0.abs() {
            self.largest = (energy, node.t);
            self.terms_at_largest = self.terms.latest;
            self.given = self.work.as_ref().map_or(0.0, |work| work.sum);
        }
        // at rest the energy is rounding
        if node.stop != Stop::Sticks {
            self.growth.look(self.largest);
        }
        if !self.is_open {
            self.balance.look(node, first, self.terms.latest);
        }
    }

    /// The warning for a run with steps of a fixed length.
    pub fn note(&self, method: Method, h: f64) -> Option<String> {
        let (first, (largest, t)) = (self.first?, self.largest);
        if matches!(method, Method::Tolerance(_)) {
            return None;
        }
        let exploded = |before: f64| {
            largest.abs() >= EXPLOSION * before.abs() && largest.abs() >= LEAST_DEFECT * self.terms_at_largest
        };
        // an energy that is nearly zero at the start, as that of a pendulum that begins level with its pivot,
        // is no scale
        let (before, then) = self.growth.before[1];
        // the work has errors of the step, too: with a step that is too long it differs from the energy
        // several times over
        let growth = largest - self.work.as_ref().map_or(first, |work| work.from);
        let is_given =
            growth.is_finite() && (growth - self.given).abs() <= (1.0 - EXPLAINED_PART) * growth.abs();
        let grows = if is_given || !exploded(first) || !exploded(before) {
            None
        } else if first != 0.0 {
            let first = if first.abs() >= 1e-2 {
                format!("{first:.3}")
            } else {
                format!("{first:.1e}")
            };
            Some(format!("{first} at the start"))
        } else if self.growth.nodes >= LEAST_NODES {
            Some(format!("0 at the start, and {before:.1e} at t = {then},"))
        } else {
            None
        };
        if let Some(before) = grows {
            let changes = if largest < first { "falls" } else { "grows" };
            return Some(format!(
                "warning: the energy {changes} from {before} to {largest:.1e} at t = {t}: unless something drives the system \
                 that far, the step h = {h} is too long for it (a smaller `--step`; `--estimate-error` measures what it costs). If half the \
                 step gives the same energy, look at the signs of the forces"
            ));
        }
        let (missing, energy, t) = self.balance.missing;
        let (sum, count) = self.terms.sum;
        (missing * count > LEAST_DEFECT * sum).then(|| {
            format!(
                "warning: the energy is {energy:.3e} at t = {t}, and was {first:.3e} at the start, although nothing that is declared changes it so: \
                 the step h = {h} is too long somewhere before, or the motion has passed a corner of a constraint, a jump or a singularity, \
                 where the step does not know how to go on (a smaller `--step` tells; a run with `--tolerance 1e-9` ends where forces or velocities would \
                 have to jump). Where the energy jumps and no force does, as with the angle `y.atan2(x)` on its cut, the motion is right, and the \
                 energy is that of another turn"
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use dsocs_core::text::Text;

    use super::*;
    use crate::entry::{Beginning, Entry, Plan};

    /// An entry from a text, with values of its parameters.
    fn entry(text: &str, values: &[(&str, f64)]) -> Entry {
        let mut entry = Entry::of_text("system", &Text::parse("system", text).unwrap(), None);
        for (name, value) in values {
            entry.set(name, *value).unwrap();
        }
        entry
    }

    #[test]
    fn a_push_that_frees_what_rests_is_no_growth() {
        let pushed = entry(
            "coordinates(x);
            lagrangian = dot(x).powi(2) / 2;
            external_forces = (2 * (1.3 * t).sin().powi(3) - dot(x).signum());",
            &[],
        );
        for h in [0.01, 0.004] {
            assert_eq!(note(&pushed, &[0.0], h, 2.5), None);
        }
    }

    /// A driven mass on a spring.
    const DRIVEN: &str = "
        parameters { stiffness = 0, pull = 0 }
        coordinates(x);
        lagrangian = dot(x).powi(2) / 2 - stiffness / 2 * x.powi(2);
        external_forces = (3 * t).sin() + pull;
    ";

    /// The warning for a run from a position, at rest.
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
        let mut energy = Energy::of(entry.kernel().shape());
        let run = entry.run(&plan, &beginning, &mut |row| {
            energy.look(&row.node, &|| *row);
            ControlFlow::Continue(())
        });
        run.unwrap();
        energy.note(plan.method, h)
    }

    #[test]
    fn steps_that_are_too_long_are_told_also_where_the_energy_begins_with_zero() {
        let driven = |stiffness, pull| entry(DRIVEN, &[("stiffness", stiffness), ("pull", pull)]);
        for (x0, words) in [
            (1.0, "from 50.000 at the start"),
            (0.0, "from 0 at the start, and"),
        ] {
            let warning = note(&driven(100.0, 0.0), &[x0], 0.21, 20.0).unwrap();
            assert!(warning.contains(words), "{warning}");
            assert_eq!(note(&driven(100.0, 0.0), &[x0], 0.01, 20.0), None);
            // also where the energy overflows
            let warning = note(&driven(100.0, 0.0), &[x0], 0.21, 150.0).unwrap();
            assert!(
                warning.contains(words) && warning.contains("to inf at t ="),
                "{warning}"
            );
        }
        // a force that drives the system all the time: without a spring, in resonance, and with a constant
        // pull
        for (stiffness, pull) in [(0.0, 5.0), (0.0, 0.0), (9.0, 0.0)] {
            for until in [1.0, 300.0] {
                assert_eq!(note(&driven(stiffness, pull), &[0.0], 0.01, until), None);
            }
        }
    }

    /// `x = cosh(w t)`: the energy is the small difference of two numbers that grow exponentially, as the error of a resolved motion does.
    #[test]
    fn a_motion_that_leaves_an_equilibrium_is_no_explosion() {
        for text in [
            "parameters { w = 0 } coordinates(x); lagrangian = dot(x).powi(2) / 2 + (w * x).powi(2) / 2;",
            // beside a swing, and with a force that makes the energy open
            "parameters { w = 0 } coordinates(x, y); lagrangian = dot(x).powi(2) / 2 + (w * x).powi(2) / 2 + dot(y).powi(2) / 2 - y * y / 2;",
            "parameters { w = 0 } coordinates(x); lagrangian = dot(x).powi(2) / 2 + (w * x).powi(2) / 2; external_forces = 1e-9 * t.sin();",
        ] {
            for (w, until) in [(1.0, 30.0), (0.3, 80.0), (5.0, 12.0)] {
                let hill = entry(text, &[("w", w)]);
                let n = hill.kernel().shape().dimension();
                for h in [0.1 / w, 0.013 / w, 1e-3 / w] {
                    for x0 in [1.0, 1e-3] {
                        let warning = note(&hill, &vec![x0; n], h, until);
                        assert_eq!(warning, None, "{text} {w} {h} {x0}");
                    }
                }
                // a step that does not resolve it
                let warning = note(&hill, &vec![1e-3; n], 4.0 / w, until);
                assert!(warning.is_some(), "{text} {w}");
            }
        }
    }

    #[test]
    fn an_energy_below_that_of_the_start_falls() {
        // a repelling spring, with a step that is too long for an attracting one
        let pushed = entry(
            "coordinates(x, y); lagrangian = dot(x).powi(2) / 2 - dot(y).powi(2) / 2 - 50 * x.powi(2) + 50 * y.powi(2);",
            &[],
        );
        for (q0, words) in [
            ([0.0, 1e-3], "the energy falls from -5.0e-5 at the start to -"),
            ([1e-3, 0.0], "the energy grows from 5.0e-5 at the start to "),
        ] {
            let warning = note(&pushed, &q0, 0.21, 20.0).unwrap();
            assert!(warning.contains(words), "{warning}");
        }
    }

    #[test]
    fn an_energy_that_is_nearly_zero_at_the_start_is_no_scale() {
        let driven = |stiffness, pull| entry(DRIVEN, &[("stiffness", stiffness), ("pull", pull)]);
        for x0 in [1e-9, 1e-6] {
            assert_eq!(note(&driven(9.0, 0.0), &[x0], 0.01, 20.0), None);
            assert_eq!(note(&driven(0.0, 1.0), &[x0], 0.01, 20.0), None);
            assert!(note(&driven(100.0, 0.0), &[x0], 0.21, 20.0).is_some());
        }
    }

    /// A bead on a wire that is bent at the origin.
    const BENT: &str = "
        parameters { slope = 0, gravity = 0 }
        coordinates(x, y);
        lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - gravity * y;
        holonomic = y - slope * x.abs();
    ";

    /// The wire, rounded at the bend.
    const ROUNDED: &str = "
        parameters { slope = 0, radius = 0, gravity = 0 }
        coordinates(x, y);
        lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - gravity * y;
        holonomic = y - slope * (x.powi(2) + radius.powi(2)).sqrt();
    ";

    /// A blade whose direction jumps at the line x = 0.
    const BLADE: &str = "
        parameters { slope = 0 }
        coordinates(x, y);
        lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2;
        nonholonomic = dot(y) - slope * x.signum() * dot(x);
    ";

    /// A mass and a potential that jump at x = 0.
    const PIECES: &str = "
        parameters { mass = 0, potential = 0 }
        coordinates(x);
        lagrangian = (1 + mass * x.signum()) * dot(x).powi(2) / 2 - potential * x.signum();
    ";

    #[test]
    fn the_median_is_that_of_five() {
        // all orders of up to five different numbers
        for code in 0..3125_u32 {
            let digits = [1, 5, 25, 125, 625].map(|unit| f64::from(code / unit % 5));
            let mut sorted = digits;
            sorted.sort_by(f64::total_cmp);
            assert_eq!(median(digits).to_bits(), sorted[2].to_bits(), "{digits:?}");
        }
    }

    /// The warning for a run to t = 4, or t = −4 with a negative step.
    fn warning_of<const N: usize>(entry: &Entry, h: f64, [q0, v0]: [[f64; N]; 2]) -> Option<String> {
        let plan = Plan {
            h,
            until: 4.0 * h.signum(),
            method: Method::Step,
            certify: false,
            estimate: false,
            inputs: Vec::new(),
        };
        let start = Beginning::SecondOrder {
            q0: q0.to_vec(),
            v0: v0.to_vec(),
        };
        let mut energy = Energy::of(entry.kernel().shape());
        entry
            .run(&plan, &start, &mut |row| {
                energy.look(&row.node, &|| *row);
                ControlFlow::Continue(())
            })
            .unwrap();
        energy.note(plan.method, plan.h)
    }

    #[test]
    fn a_step_across_a_jump_is_told() {
        let bent = entry(BENT, &[("slope", 0.5), ("gravity", 0.0)]);
        let blade = entry(BLADE, &[("slope", 0.5)]);
        let mass = entry(PIECES, &[("mass", 0.5), ("potential", 0.0)]);
        let potential = entry(PIECES, &[("mass", 0.0), ("potential", 0.2)]);
        for h in [0.02, 0.003, 1e-4] {
            let along = [[-1.01], [1.0]];
            let notes = [
                warning_of(&bent, h, [[1.0, 0.5], [-1.0, -0.5]]),
                warning_of(&blade, h, [[-1.01, 0.0], [1.0, -0.5]]),
                warning_of(&mass, h, along),
                warning_of(&potential, h, along),
                // back in time
                warning_of(&potential, -h, [[1.01], [1.0]]),
            ];
            for (place, note) in notes.into_iter().enumerate() {
                let note = note.unwrap_or_else(|| panic!("h = {h}: nothing is said of run {place}"));
                assert!(
                    note.contains("although nothing that is declared changes it so"),
                    "{note}"
                );
            }
        }
    }

    /// A turntable of constant rate: the constraint force does work all the time.
    const TURNTABLE: &str = "
        parameters { rate = 0 }
        coordinates(x, w);
        lagrangian = (dot(x).powi(2) + dot(w).powi(2) * (1 + x.powi(2)) - 3 * x.powi(2)) / 2;
        nonholonomic = dot(w) - rate;
    ";

    #[test]
    fn nothing_is_said_of_a_motion_that_goes_on() {
        for h in [0.02_f64, 0.003, -0.02] {
            let v = -h.signum();
            // around the rounded bend, and on one side of the corner
            let round = entry(ROUNDED, &[("slope", 1.0), ("radius", 0.2), ("gravity", 1.0)]);
            let high = 1.0_f64.hypot(0.2);
            let start = [[1.0, high], [v, v / high]];
            assert_eq!(warning_of(&round, h, start), None, "h = {h}");
            let bent = entry(BENT, &[("slope", 1.0), ("gravity", 1.0)]);
            let start = [[1.0, 1.0], [-3.0 * v, -3.0 * v]];
            assert_eq!(warning_of(&bent, h, start), None, "h = {h}");
            assert_eq!(
                warning_of(&entry(TURNTABLE, &[("rate", 1.3)]), h, [[1.0, 0.0], [0.0, 1.3]]),
                None
            );
            let blade = [[-1.01, 0.0], [0.2 * h.signum(), -0.2 * h.signum()]];
            assert_eq!(warning_of(&entry(BLADE, &[("slope", 1.0)]), h, blade), None);
            let pieces = entry(PIECES, &[("mass", 0.5), ("potential", 0.2)]);
            assert_eq!(warning_of(&pieces, h, [[-1.01], [0.2 * h.signum()]]), None);
        }
    }
}
