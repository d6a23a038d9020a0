//! Steps of a flow in which something rests where a function jumps; see [`crate::sticking`].

use super::inputs::Changed;
use super::{Flow, Solved, Unresolved};
use crate::any::{continuous_force, sized};
use crate::declaration::Declaration;
use crate::error::StepError;
use crate::held::Held;
use crate::run::Node;
use crate::start::Beginning;
use crate::step::newton::Stop;
use crate::step::unknown::Unknown as _;
use crate::step::{Guess, Step, StepReport};
use crate::sticking::{self, Contact, Sticking};
use crate::system::{Leg, Point, System};

/// The sides of the last step, where it was solved with them.
#[derive(Clone, Debug)]
pub(super) struct Stuck {
    /// The number of the position that the step leads to.
    index: u64,
    /// The sides.
    sticking: Sticking,
}

impl<'s, S: System<N>, const N: usize> Flow<'s, S, N> {
    /// What rests on the first leg of a run.
    #[cold]
    pub(super) fn stuck_at_start(system: &S, h: f64, beginning: &Beginning<N>) -> Option<Box<Stuck>> {
        let declaration = Declaration::of(system);
        if declaration.sides() == 0 {
            return None;
        }
        let Beginning {
            t0, q0, v0, a0, q, d, ..
        } = beginning;
        let leg = Leg {
            t: t0 + h,
            q: q.hi,
            d: d.hi,
        };
        let mut rests = sticking::rests_on(&declaration, h, leg.any());
        if a0.is_some()
            && let Some(found) =
                sticking::of_motion(&declaration, (*t0, q0, v0), Self::multipliers_count(), None)
        {
            for (rests, still) in rests.iter_mut().zip(&found.still) {
                *rests |= still;
            }
        }
        let sticking = Sticking::resting(rests);
        sticking.rests().then(|| Box::new(Stuck { index: 1, sticking }))
    }

    /// How many multipliers are unknown.
    fn multipliers_count() -> usize {
        S::Motion::zero().as_ref().len() - N
    }

    /// Whether something rests on the leg that the next step begins with.
    #[inline]
    pub(crate) fn is_stuck(&self) -> bool {
        self.is_stuck_at(self.index())
    }

    /// The same if that is the step with this middle node.
    #[inline]
    pub(crate) fn is_stuck_at(&self, index: u64) -> bool {
        let stuck = self.stuck.as_ref();
        stuck.is_some_and(|stuck| stuck.index == index && stuck.sticking.rests())
    }

    /// The sides of the last step.
    fn last_sides(&self) -> Option<&Sticking> {
        let stuck = self.stuck.as_ref()?;
        (stuck.index == self.index()).then_some(&stuck.sticking)
    }

    /// Takes over what rests on the leg that is common with another run, which goes the other way.
    pub(super) fn rest_as(&mut self, other: &Self) {
        self.stuck = None;
        if let Some(sticking) = other.last_sides().filter(|sticking| sticking.rests()) {
            self.stuck = Some(Box::new(Stuck {
                index: self.index(),
                sticking: sticking.clone(),
            }));
        }
    }

    /// Solves the next step where something rests on the leg that it begins with; `None` if that leads to nothing.
    #[cold]
    pub(super) fn solve_stuck(&mut self) -> Option<Result<StepReport, StepError>> {
        let past = self
            .predictor
            .predict()
            .map(|z| self.next_step().second_difference(&z));
        let guess = past.unwrap_or([0.0; N]);
        if let Some(before) = self.before.take() {
            let change = self.solve_stuck_between(&before, &guess);
            if change.is_none() {
                self.before = Some(before);
            }
            return change.map(Ok);
        }
        self.settle(&guess, |_, _| true)
    }

    /// The same between two values of the inputs: the mean of the steps with both. So what rests up to the node is driven by the new force for half a step.
    fn solve_stuck_between(&mut self, before: &Held<'s, S>, guess: &[f64; N]) -> Option<StepReport> {
        let (leg, multipliers) = (self.next_leg(), vec![0.0; Self::multipliers_count()]);
        let rests = self.last_sides().map_or(&[][..], |sticking| &sticking.rests);
        let [old, new] = [before, &self.system].map(|system| {
            let contact = Contact {
                declaration: Declaration::of(&**system),
                h: self.h,
                leg: leg.any(),
                rests,
            };
            let solution = contact.solve(guess, &multipliers)?;
            let Sticking { first, second, .. } = &solution.sticking;
            let force = contact
                .declaration
                .sided_force(self.h, leg.any(), &solution.e, [first, second]);
            Some((solution, force))
        });
        let ((old, old_force), (new, new_force)) = (old?, new?);
        let mean = |x: &[f64], y: &[f64]| core::array::from_fn(|i| 0.5 * (x[i] + y[i]));
        let e: [f64; N] = mean(&old.e, &new.e);
        let rests = old.sticking.rests.iter().zip(&new.sticking.rests);
        let sticking = Sticking::resting(rests.map(|(old, new)| *old && *new).collect());
        let steady = old.sticking.is_steady() && new.sticking.is_steady() && sticking.rests();
        let report = StepReport {
            iterations: old.evaluations + new.evaluations,
            stop: if steady { Stop::Sticks } else { Stop::Update },
            guess: Guess::Given,
        };
        let multipliers: Vec<f64> = old
            .multipliers
            .iter()
            .zip(&new.multipliers)
            .map(|(old, new)| 0.5 * (old + new))
            .collect();
        let index = self.index();
        let changed = Changed {
            index,
            force: mean(&old_force, &new_force),
            before: before.clone(),
        };
        self.go(leg, e, &multipliers, report, sticking)?;
        self.since = index.saturating_sub(1);
        self.changed = Some(Box::new(changed));
        Some(report)
    }

    /// Solves a step anew whose rows jump, in which something may come to rest. `plain` is the second difference that solves it without that, if any does,
    /// and how it was found; `None` if it stays.
    #[cold]
    pub(super) fn solve_jump(
        &mut self,
        plain: Option<(&[f64; N], Stop)>,
    ) -> Option<Result<StepReport, StepError>> {
        let declaration = Declaration::of(&*self.system);
        if declaration.sides() == 0 {
            return None;
        }
        let Some((e, stop)) = plain else {
            #[allow(clippy::redundant_closure_for_method_calls)] // the method is of one lifetime
            return self.settle(&[0.0; N], |contact, solution| contact.is_declared(solution));
        };
        let leg = self.next_leg();
        let contact = Contact {
            declaration,
            h: self.h,
            leg: leg.any(),
            rests: &[],
        };
        if stop != Stop::Jump && !contact.may_rest(e) {
            return None;
        }
        self.settle(e, |contact, solution| {
            solution.sticking.rests() || stop == Stop::Jump && contact.is_declared(solution)
        })
    }

    /// Solves the next step with sides and goes to its node, if the solution is wanted.
    fn settle(
        &mut self,
        guess: &[f64; N],
        is_wanted: impl Fn(&Contact<'_>, &sticking::Solution) -> bool,
    ) -> Option<Result<StepReport, StepError>> {
        let leg = self.next_leg();
        let rests: &[bool] = if self.is_stuck() {
            self.last_sides().map_or(&[], |sticking| &sticking.rests)
        } else {
            &[]
        };
        let contact = Contact {
            declaration: Declaration::of(&*self.system),
            h: self.h,
            leg: leg.any(),
            rests,
        };
        let multipliers = vec![0.0; Self::multipliers_count()];
        let solution = contact.solve(guess, &multipliers)?;
        if !is_wanted(&contact, &solution) {
            return None;
        }
        let sticking = solution.sticking;
        let stop = match (sticking.rests(), sticking.is_steady()) {
            (true, true) => Stop::Sticks,
            (true, false) => Stop::Jump,
            (false, _) => Stop::Update,
        };
        let report = StepReport {
            iterations: solution.evaluations,
            stop,
            guess: Guess::Predicted,
        };
        if !sticking.is_steady() {
            let time = self.time();
            self.count_unresolved(time, 0.0);
        }
        let e = sized(&solution.e);
        self.go(leg, e, &solution.multipliers, report, sticking)?;
        Some(Ok(report))
    }

    /// Goes on to the node of a solution; `None` if it is not finite.
    fn go(
        &mut self,
        leg: Leg<f64, N>,
        e: [f64; N],
        multipliers: &[f64],
        report: StepReport,
        sticking: Sticking,
    ) -> Option<()> {
        let mut d = self.d;
        d.add(&e);
        let q = self.q.plus(&d);
        if !q.hi.iter().all(|q| q.is_finite()) {
            return None;
        }
        let z = Step::new(&*self.system, &self.constants, leg, self.h)
            .any()
            .unknown(&e, multipliers);
        self.predictor.push(&z);
        self.looked = true;
        self.solved = Some(Solved { leg, e, report });
        (self.q, self.d) = (q, d);
        // the clock has not gone on yet
        self.stuck = Some(Box::new(Stuck {
            index: self.index() + 1,
            sticking,
        }));
        Some(())
    }

    /// Gives a node the constraint force with the sides of its step.
    #[cold]
    pub(super) fn tell_sides(&self, solved: &Solved<N>, node: &mut Node<N>) {
        if let Some(Sticking { first, second, .. }) = self.last_sides() {
            let declaration = Declaration::of(&*self.system);
            let force = declaration.sided_force(self.h, solved.leg.any(), &solved.e, [first, second]);
            node.force = sized(&force);
        }
    }

    /// The constraint force at the start.
    pub(super) fn first_force(&self, point: &Point<f64, N>) -> [f64; N] {
        let declaration = Declaration::of(&*self.system);
        let at = (point.t, &point.q[..], &point.v[..]);
        if S::JUMPS
            && declaration.sides() > 0
            && let Some(found) = sticking::of_motion(&declaration, at, Self::multipliers_count(), None)
        {
            return sized(&declaration.sided_continuous_force(point.any(), &found.sides));
        }
        continuous_force(&declaration, point)
    }

    /// Counts a step that was too long.
    pub(super) fn count_unresolved(&mut self, time: f64, part: f64) {
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
