//! A system with the motion that it is checked on: its legs, triples and states.

pub mod extrapolation;
pub mod motions;

use std::cell::OnceCell;
use std::ops::Range;
use std::rc::Rc;

use dsocs_core::geometry::{DiscreteFlow, FlowTheorem, Triple, corners, moved};
use dsocs_core::{AnyPoint, Kernel, OwnedLeg};

use crate::check::order::{self, Compared, Shared};
use crate::check::reasons::dependence::NearlyDependentConstraint;
use crate::check::reasons::large_numbers::RoundingOfLargeNumbers;
use crate::check::{Expected, Settings, excuse, larger};
use crate::entry::{CheckFailure, Motions, Symmetry};
use motions::{DoubtfulSteps, MotionLegs, SecondNode, State, less};

/// The largest number of evenly spread triples of the motion that are tested.
const SPREAD_TRIPLES: usize = 24;

/// The number of further triples, where the second difference changes most: at switches and impacts.
const SHARPEST_TRIPLES: usize = 8;

/// The number of first steps in which the tangent map is compared with difference quotients.
const EARLY_STEPS: usize = 40;

/// The number of states of the continuous motion at which the discrete system is compared with it.
const STATES: usize = 4;

/// The tolerance of the motion to these states.
const STATES_TOLERANCE: f64 = 1e-13;

/// A system with the motion that it is checked on.
pub struct CheckedMotion<'a> {
    /// The system with its motions.
    pub system: &'a dyn Motions,
    /// The system.
    pub kernel: &'a dyn Kernel,
    /// Its step as a map.
    pub flow: DiscreteFlow<'a>,
    /// Its expected properties.
    pub expected: Expected,
    /// Symmetries of its Lagrangian.
    pub symmetries: &'a [Symmetry],
    /// The step.
    pub h: f64,
    /// The end that was asked for.
    pub asked: f64,
    /// The time that was reached.
    pub until: f64,
    /// The reason why this is not the end that was asked for.
    pub ended: Option<String>,
    /// The steps in which assumptions of the theorems do not hold.
    pub doubtful: DoubtfulSteps,
    /// The number of steps in which a function jumps, or holds something at rest.
    pub held: usize,
    /// The start.
    pub start: State,
    /// The rule for the second node.
    pub first: SecondNode,
    /// The legs of the motion.
    pub legs: Vec<OwnedLeg<f64>>,
    /// The index of the first leg of each triple.
    pub places: Vec<usize>,
    /// Triples along the motion: evenly spread ones, and the hardest ones.
    pub triples: Vec<Triple>,
    /// The evenly spread triples alone.
    pub spread: Vec<Triple>,
    /// Triples of the first steps.
    pub early: Vec<Triple>,
    /// States of the continuous motion, evenly spread.
    pub states: Vec<State>,
    /// The number of triples that are left out, since the equations have no derivatives there.
    pub without_derivative: usize,
    /// The constraint that is nearly dependent on the others, if its rounding shows.
    pub dependent: Option<NearlyDependentConstraint>,
    /// The rounding of large times and positions.
    pub large_numbers: RoundingOfLargeNumbers,
    /// The time up to which the step follows the motion, if it is a small part of the window.
    pub followed_until: OnceCell<Option<f64>>,
    /// The errors of the motion's own step and of its halves.
    pub errors: OnceCell<Result<Rc<Compared>, Shared>>,
}

impl<'a> CheckedMotion<'a> {
    /// A system with its motion from the start of the settings, for the time `default_duration` unless they give an end.
    pub fn new(
        system: &'a dyn Motions,
        symmetries: &'a [Symmetry],
        expected: Expected,
        settings: &Settings<'_>,
        default_duration: f64,
    ) -> Result<Self, CheckFailure> {
        let start = State::of(settings);
        let (h, asked) = (
            settings.h,
            settings.until.unwrap_or(settings.t0 + default_duration),
        );
        let kernel = system.kernel();
        let flow = DiscreteFlow::new(kernel, h)?;
        let start = if settings.begin.projected {
            motions::projected(kernel, h, &start)?
        } else {
            start
        };
        let first = if settings.begin.paper {
            SecondNode::Paper
        } else {
            SecondNode::SecondOrder
        };
        let motion = motions::legs(kernel, h, (&start, first), asked)?;
        let (places, spread) = triple_indices(&motion);
        let early = (0..motion.legs.len().min(EARLY_STEPS) - 1).step_by(2);
        let early: Vec<usize> = early.filter(|&place| !motion.held[place]).collect();
        let of = |places: &[usize]| triples(&flow, &motion.legs, places);
        let mut all = [of(&places)?, of(&spread)?, of(&early)?];
        let count = all[0].len();
        for triples in &mut all {
            triples.retain(|triple| FlowTheorem::at(kernel, h, triple.leg.any(), &triple.e).differentiable);
        }
        let [at_places, at_spread, at_early] = all;
        Ok(Self {
            system,
            kernel,
            large_numbers: RoundingOfLargeNumbers::along(kernel, h, &motion.legs, &at_places),
            without_derivative: count - at_places.len(),
            triples: at_places,
            spread: at_spread,
            early: at_early,
            expected,
            symmetries,
            h,
            asked,
            until: motion.until,
            ended: motion.ended,
            doubtful: motion.doubtful,
            held: motion.held.iter().filter(|held| **held).count(),
            states: states(system, h, &start, motion.until),
            dependent: NearlyDependentConstraint::along(kernel, h, &motion.legs),
            followed_until: OnceCell::new(),
            errors: OnceCell::new(),
            start,
            first,
            places,
            legs: motion.legs,
            flow,
        })
    }

    /// Lets runs begin with two nodes of the continuous motion, if its expansion at the start is known.
    pub fn start_on_the_motion(&mut self) {
        if let Ok(motion) = motions::expansion(self.system, &self.start) {
            self.start.expansion = Some(motion);
            self.first = SecondNode::Exact;
        }
    }

    /// The numbers of constraints: on positions, on velocities, on accelerations.
    pub fn constraints(&self) -> [usize; 3] {
        let shape = self.kernel.shape();
        [shape.holonomic, shape.nonholonomic, shape.kinematic]
    }

    /// The number of changes between pieces of functions along the motion.
    pub fn corners(&self) -> usize {
        // with constraints of second order no piece depends on the acceleration
        let a = vec![0.0; self.kernel.shape().dimension()];
        // the contact with a stiff spring may be shorter than a step, and contain one node or one middle of a
        // leg only
        let places = self.legs.iter().flat_map(|leg| {
            let back: Vec<f64> = leg.d.iter().map(|d| -d / 2.0).collect();
            let v: Vec<f64> = leg.d.iter().map(|d| d / self.h).collect();
            let middle = moved(self.kernel, &leg.q, &back);
            [
                (leg.t - self.h / 2.0, middle, v.clone()),
                (leg.t, leg.q.clone(), v),
            ]
        });
        let places: Vec<(f64, Vec<f64>, Vec<f64>)> = places.collect();
        let points = places.iter().map(|(t, q, v)| AnyPoint { t: *t, q, v, a: &a });
        let points: Vec<AnyPoint<'_, f64>> = points.collect();
        let pairs = points.iter().zip(points.iter().skip(1));
        pairs
            .map(|(before, now)| corners(self.kernel, [*before, *now]))
            .sum()
    }

    /// The time up to which the step follows the motion, if it is a small part of the window: the step is
    /// then too long for errors that fall as a power of it.
    pub fn followed_until(&self) -> Option<f64> {
        *self.followed_until.get_or_init(|| order::followed_until(self))
    }

    /// The reason why the theorems on the motion as a whole are not required: the assumption that does not
    /// hold.
    pub fn excuse(&self) -> Option<String> {
        excuse(self.doubtful, self.held, self.legs.len() - 1)
    }
}

/// The indices of legs at which triples begin: evenly spread and where the second difference changes most;
/// and the evenly spread alone. Legs in which a function jumps or holds something are left out.
fn triple_indices(motion: &MotionLegs) -> (Vec<usize>, Vec<usize>) {
    let legs = &motion.legs;
    let last = legs.len() - 1;
    let smooth: Vec<usize> = (0..last).filter(|&place| !motion.held[place]).collect();
    let every = smooth.len().div_ceil(SPREAD_TRIPLES).max(1);
    let spread: Vec<usize> = smooth.iter().copied().step_by(every).collect();
    let change = |k: usize| -> f64 {
        let parts = (0..legs[k].d.len()).map(|i| {
            let [a, b, c] = [legs[k - 1].d[i], legs[k].d[i], legs[k + 1].d[i]];
            let size = a.abs().max(b.abs()).max(c.abs());
            if size > 0.0 {
                ((c - b) - (b - a)).abs() / size
            } else {
                0.0
            }
        });
        parts.fold(0.0, larger)
    };
    let inner = smooth.iter().filter(|&&place| place > 0);
    let mut hardest: Vec<(usize, f64)> = inner.map(|&k| (k, change(k))).collect();
    hardest.sort_by(|x, y| y.1.total_cmp(&x.1));
    let mut places = spread.clone();
    places.extend(hardest.iter().take(SHARPEST_TRIPLES).map(|(place, _)| place));
    places.sort_unstable();
    places.dedup();
    (places, spread)
}

/// Triples at these places of a motion.
fn triples(
    flow: &DiscreteFlow<'_>,
    legs: &[OwnedLeg<f64>],
    places: &[usize],
) -> Result<Vec<Triple>, CheckFailure> {
    let mut found = Vec::new();
    for &place in places {
        let [first, last] = [&legs[place], &legs[place + 1]];
        let e = less(&last.d, &first.d);
        found.push(flow.forward_near(first.any(), &e)?);
    }
    Ok(found)
}

/// States of the continuous motion: the start, and others as far as the motion is known.
fn states(system: &dyn Motions, h: f64, start: &State, until: f64) -> Vec<State> {
    // a piecewise function may have a corner at the start, whose other side the motion does not reach
    let (first, aside) = if system.kernel().shape().piecewise {
        (None, 0.5)
    } else {
        (Some(start.clone()), 0.0)
    };
    let times = first.iter().len()..STATES;
    let others = states_at(system, h, start, until, (times, STATES, aside));
    let mut states: Vec<State> = first.into_iter().chain(others).collect();
    if states.is_empty() {
        states.push(start.clone());
    }
    states
}

/// States of the continuous motion, as far as it is known. The time is divided into `count` equal parts; the
/// states are at the beginnings of those in `numbers`, each later by the fraction `aside` of a part.
pub fn states_at(
    system: &dyn Motions,
    h: f64,
    start: &State,
    until: f64,
    (numbers, count, aside): (Range<usize>, usize, f64),
) -> Vec<State> {
    let time = |k: usize| start.t + (until - start.t) * (k as f64 + aside) / count as f64;
    let times: Vec<f64> = numbers.map(time).collect();
    let Ok((motion, _)) = motions::continuous_to_its_end(system, h, start, &times, STATES_TOLERANCE) else {
        return Vec::new();
    };
    let states = motion.iter().map(|point| {
        let AnyPoint { t, q, v, a } = point.any();
        State {
            t,
            q: q.to_vec(),
            v: v.to_vec(),
            near: start.near.as_ref().map(|_| a.to_vec()),
            expansion: None,
        }
    });
    states.collect()
}
