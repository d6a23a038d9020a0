//! Detects a force that changes too fast for the steps, where the energy may change by forces, too.
//!
//! A step that leaps into a stiff contact has another energy after it than the work of the forces on its way gives.

use dsocs_core::geometry::work_between;
use dsocs_core::{AnyNode, Stop};

use crate::entry::Row;
use crate::stability::written_time;

/// A step is examined if the energy changes in it by more than this part of its range so far. A motion that
/// is resolved has few such steps, most of them at its start.
const OF_RANGE: f64 = 0.5;

/// The least difference between the change of the energy in a step and the work on its way, relative to the larger of the kinetic
/// energies at both nodes.
const LEAST_MISSING: f64 = 0.6;

/// The least change of the energy in such a step, and the least such difference, relative to the range of the energy in the whole run:
/// where a force begins from rest it grows by its own size in a step.
const LEAST_OF_RANGE: f64 = 0.01;

/// What the steps of a run resolve.
#[derive(Default)]
pub struct Resolution {
    /// The energy at the last node; `None` before the first.
    last: Option<f64>,
    /// The least and the largest energy so far.
    range: [f64; 2],
    /// The step with the largest difference.
    found: Option<Found>,
}

/// A step that does not resolve its forces.
struct Found {
    /// The time at its end.
    t: f64,
    /// The energy at its beginning and at its end.
    energy: [f64; 2],
    /// The work on the way.
    work: f64,
}

impl Found {
    /// The difference.
    fn missing(&self) -> f64 {
        let [before, after] = self.energy;
        (after - before - self.work).abs()
    }

    /// The change of the energy in the step, or the difference, if it is smaller.
    fn size(&self) -> f64 {
        let [before, after] = self.energy;
        self.missing().min((after - before).abs())
    }
}

impl Resolution {
    /// Looks at a node.
    #[inline]
    pub fn look<'r>(&mut self, energy: f64, row: &impl Fn() -> Row<'r>) {
        let Some(last) = self.last.replace(energy) else {
            self.range = [energy; 2];
            return;
        };
        let [least, largest] = self.range;
        if (energy - last).abs() > OF_RANGE * (largest - least) {
            self.look_at_step(&row());
        }
        self.range = [least.min(energy), largest.max(energy)];
    }

    #[cold]
    fn look_at_step(&mut self, row: &Row<'_>) {
        let found = row.before.and_then(|before| examine(row, &before.any()));
        let size = self.found.as_ref().map_or(0.0, Found::size);
        self.found = found.filter(|found| found.size() > size).or(self.found.take());
    }

    /// The warning for a run with the step `h`.
    pub fn note(&self, h: f64) -> Option<String> {
        let [least, largest] = self.range;
        let found = self.found.as_ref()?;
        let is_told = found.size() > LEAST_OF_RANGE * (largest - least);
        is_told.then(|| {
            let ([before, after], t) = (found.energy, written_time(found.t));
            format!(
                "warning: the energy changes from {before:.3e} to {after:.3e} in the step to t = {t}, where the work of the forces on the \
                 way between these two nodes is {:.3e}: \
                 a force changes there too fast for the step h = {h}, as that of a stiff contact does, and what comes after depends on where the nodes lie (a \
                 smaller `--step`, or `--tolerance`)",
                found.work
            )
        })
    }
}

/// Examines the step to a node from the one before.
fn examine(row: &Row<'_>, before: &AnyNode<'_>) -> Option<Found> {
    let (node, declaration) = (&row.node, &row.declaration);
    // how a force that jumps goes on is another question, and its steps are counted where they do not answer it
    if [node, before]
        .iter()
        .any(|at| matches!(at.stop, Stop::Sticks | Stop::Jump))
    {
        return None;
    }
    // with the values of this step's inputs
    let energy = |at: &AnyNode<'_>, v: &[f64]| declaration.energy::<f64>(at.t, at.q, v);
    let energies = [before, node].map(|at| energy(at, at.v));
    let found = Found {
        t: node.t,
        energy: energies,
        work: work_between(declaration, [before, node]),
    };
    let still = vec![0.0; node.v.len()];
    let kinetic = [before, node].map(|at| (energy(at, at.v) - energy(at, &still)).abs());
    (found.missing() > LEAST_MISSING * kinetic[0].max(kinetic[1])).then_some(found)
}
