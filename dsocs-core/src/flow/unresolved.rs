//! Whether a step is short enough for the external forces.
//!
//! A step takes a force for what it is on its two legs. A switch that is thrown and over between these (dry friction where the velocity
//! turns) leaves no trace in the rows: they are met, and the motion is off by the first order in the step. It shows between the legs, where a
//! force that the step resolves goes nearly straight from the one value to the other.

use super::Flow;
use crate::declaration::Declaration;
use crate::system::{Leg, System};

/// How far between the legs the force is looked at, from the first to the second.
const BETWEEN: [f64; 3] = [0.25, 0.5, 0.75];

/// A step is looked at where its second difference is farther than this from what the past foresaw, relative to itself: a force that has
/// changed as the past knew it has not been switched.
const FORESEEN: f64 = 0.1;

/// A force is unresolved if what it does between the legs, over a step, is this part of the change of the momentum.
const UNRESOLVED: f64 = 0.1;

/// The steps of a run that were too long for the external forces: between their two legs a force departed from the straight line through its
/// values there by more than a tenth of all that changes the momentum. At each of them the order of the run falls to 1.
///
/// Dry friction that turns round within a step is the usual case. The nodes obey the discrete equations all the same, and the run goes on:
/// a smaller step, a softer switch or [`TaylorFlow`](crate::TaylorFlow), which finds the place, is what helps. The force is looked at in
/// three places between the legs of steps that the past did not foresee; a pulse that is over within a quarter of a step may lie between them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unresolved {
    /// How many steps.
    pub steps: u64,
    /// The time of the middle node of the first of them.
    pub first: f64,
    /// How far the force departed at the worst of them, over the step and relative to the change of the momentum \[1\].
    pub largest: f64,
}

impl<S: System<N>, const N: usize> Flow<'_, S, N> {
    /// Whether the past foresaw a solution, with which the second difference is `e`.
    #[inline]
    pub(super) fn foresees(&self, z: &S::Unknown<f64>, e: &[f64; N]) -> bool {
        if !z.as_ref().is_empty() {
            return self.predictor.foresees(z, FORESEEN);
        }
        // steps without unknowns have none that are predicted
        self.solved.is_some_and(|last| {
            let pairs = e.iter().zip(&last.e);
            pairs
                .into_iter()
                .all(|(e, last)| (e - last).abs() <= FORESEEN * e.abs())
        })
    }

    /// Looks at the forces between the legs of the step that begins with `leg` and has the second difference `e`.
    #[cold]
    pub(super) fn look_between(&mut self, leg: &Leg<f64, N>, e: &[f64; N]) {
        let time = self.time();
        let leg = Leg { t: time, ..*leg };
        let part = departure(&Declaration::of(&*self.system), self.h, &leg, e);
        // false also where the force has no value there
        if part > UNRESOLVED {
            let unresolved = self.unresolved.get_or_insert_with(|| {
                Box::new(Unresolved {
                    steps: 0,
                    first: time,
                    largest: 0.0,
                })
            });
            unresolved.steps += 1;
            unresolved.largest = unresolved.largest.max(part);
        }
    }
}

/// How far the forces depart from the straight line between the middles of two legs, over a step and relative to the change of the
/// momentum or to the force, of all components the largest.
fn departure<const N: usize>(
    declaration: &Declaration<'_, N>,
    h: f64,
    leg: &Leg<f64, N>,
    e: &[f64; N],
) -> f64 {
    let next: [f64; N] = core::array::from_fn(|i| leg.d[i] + e[i]);
    let force = |part: f64| {
        let place = part - 0.5;
        let d = if place < 0.0 { &leg.d } else { &next };
        let q = core::array::from_fn(|i| leg.q[i] + place * d[i]);
        let v = core::array::from_fn(|i| (leg.d[i] + part * e[i]) / h);
        declaration.external_forces(leg.t + place * h, &q, &v)
    };
    let [first, last] = [0.0, 1.0].map(force);
    let mut aside = [0.0_f64; N];
    for part in BETWEEN {
        for (i, (aside, force)) in aside.iter_mut().zip(force(part)).enumerate() {
            *aside = aside.max((force - (first[i] + part * (last[i] - first[i]))).abs());
        }
    }
    let arrives = declaration.arriving(h, leg);
    let leaves = declaration.arriving(
        h,
        &Leg {
            t: leg.t + h,
            q: core::array::from_fn(|i| leg.q[i] + next[i]),
            d: next,
        },
    );
    let parts = aside.iter().enumerate().map(|(i, aside)| {
        // L_d is no action but a Lagrangian: its derivatives are momenta over the step
        let change = (leaves[i] - arrives[i]).abs();
        aside / change.max(first[i].abs()).max(last[i].abs())
    });
    parts.fold(0.0, f64::max)
}
