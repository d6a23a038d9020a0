//! Steps of a flow in which something rests where a function jumps; see [`crate::regularity::sticking`].

use super::discrete::Discrete;
use super::inputs::Changed;
use crate::error::StepError;
use crate::kernel::report::{Guess, StepReport};
use crate::number::point::{AnyLeg, AnyPoint, copy};
use crate::regularity::sticking::{self, Contact, Sticking};
use crate::run::Unresolved;
use crate::solve::Vector;
use crate::solve::newton::Stop;
use crate::start::Beginning;
use crate::tape::declaration::Declaration;

/// The sides of functions that jump at the last node.
#[derive(Clone, Debug)]
pub(super) struct Stuck {
    /// The number of the step that begins there.
    pub(super) index: u64,
    /// The sides.
    sticking: Sticking,
}

impl Stuck {
    /// What rests at the start.
    #[cold]
    pub(super) fn at_start(
        declaration: &Declaration<'_>,
        h: f64,
        beginning: &Beginning,
    ) -> Option<Box<Self>> {
        if declaration.sides() == 0 {
            return None;
        }
        let Beginning {
            t0, q0, v0, a0, q, d, ..
        } = beginning;
        let leg = AnyLeg {
            t: t0 + h,
            q: &q.hi,
            d: &d.hi,
        };
        let mut rests = sticking::rests_on(declaration, h, leg);
        let multipliers = declaration.shape().multipliers();
        if a0.is_some()
            && let Some(found) = sticking::of_motion(declaration, (*t0, q0, v0), multipliers, None)
        {
            for (rests, still) in rests.iter_mut().zip(&found.still) {
                *rests |= still;
            }
        }
        let sticking = Sticking::resting(rests);
        sticking.rests().then(|| Box::new(Self { index: 1, sticking }))
    }
}

impl Discrete<'_> {
    /// Whether something rests where the next step begins.
    pub(crate) fn is_stuck(&self) -> bool {
        self.is_stuck_at(self.course.index())
    }

    /// Whether something rests where the step of this number begins.
    pub(crate) fn is_stuck_at(&self, index: u64) -> bool {
        let stuck = self.stuck.as_ref();
        stuck.is_some_and(|stuck| stuck.index == index && stuck.sticking.rests())
    }

    /// The sides at the last node.
    fn last_sides(&self) -> Option<&Sticking> {
        let stuck = self.stuck.as_ref()?;
        (stuck.index == self.course.index()).then_some(&stuck.sticking)
    }

    /// What rests there.
    fn resting(&self) -> &[bool] {
        self.last_sides().map_or(&[], |sticking| &sticking.rests)
    }

    /// Sets the sides with which the step of a number begins.
    fn stick(&mut self, index: u64, sticking: Sticking) {
        self.course.rests_at = sticking.rests().then_some(index);
        self.stuck = Some(Box::new(Stuck { index, sticking }));
    }

    /// Rests where another run rests, which has turned round.
    pub(super) fn rest_as(&mut self, other: &Self) {
        (self.stuck, self.course.rests_at) = (None, None);
        if let Some(sticking) = other.last_sides().filter(|sticking| sticking.rests()) {
            self.stick(self.course.index(), sticking.clone());
        }
    }

    /// Solves a step that begins at rest; `None` if no values of the functions hold.
    #[cold]
    pub(super) fn solve_stuck(&mut self) -> Option<Result<StepReport, StepError>> {
        let past = self
            .course
            .predictor
            .predict()
            .map(|z| self.next_step().second_difference(&z));
        let guess = past.unwrap_or_else(|| Vector::zero(self.shape().increments));
        if let Some(before) = self.before.take() {
            let change = self.solve_stuck_between(&before, &guess);
            if change.is_none() {
                self.before = Some(before);
            }
            return change.map(Ok);
        }
        self.settle(&guess, |_, _| true)
    }

    /// The same where inputs change: the mean of what both values say.
    fn solve_stuck_between(&mut self, before: &[f64], guess: &[f64]) -> Option<StepReport> {
        let (h, index) = (self.course.h, self.course.index());
        let (e, multipliers, report, sticking, force) = {
            let (leg, multipliers) = (self.next_leg(), vec![0.0; self.shape().multipliers()]);
            let rests = self.resting();
            let [old, new] = [before, &self.values[..]].map(|values| {
                let contact = Contact {
                    declaration: Declaration::of(self.kernel).with(values),
                    h,
                    leg,
                    rests,
                };
                let solution = contact.solve(guess, &multipliers)?;
                let Sticking { first, second, .. } = &solution.sticking;
                let force = contact
                    .declaration
                    .sided_force(h, leg, &solution.e[..], [first, second]);
                Some((solution, force))
            });
            let ((old, old_force), (new, new_force)) = (old?, new?);
            let mean = |x: &[f64], y: &[f64]| Vector::of(x).zip(y, |x, y| 0.5 * (x + y));
            let rests = old.sticking.rests.iter().zip(&new.sticking.rests);
            let sticking = Sticking::resting(rests.map(|(old, new)| *old && *new).collect());
            let steady = old.sticking.is_steady() && new.sticking.is_steady() && sticking.rests();
            let report = StepReport {
                iterations: old.evaluations + new.evaluations,
                stop: if steady { Stop::Sticks } else { Stop::Update },
                guess: Guess::Given,
            };
            (
                mean(&old.e, &new.e),
                mean(&old.multipliers, &new.multipliers),
                report,
                sticking,
                mean(&old_force, &new_force),
            )
        };
        self.go(&e, &multipliers, report, sticking)?;
        self.course.since = index.saturating_sub(1);
        self.changed = Some(Box::new(Changed {
            index,
            force,
            before: before.to_vec(),
        }));
        Some(report)
    }

    /// Solves a step across a jump with the functions' values unknown: where it has no other solution, or where the one it has may come to rest.
    #[cold]
    pub(super) fn solve_jump(
        &mut self,
        plain: Option<(&[f64], Stop)>,
    ) -> Option<Result<StepReport, StepError>> {
        let declaration = self.declaration();
        if declaration.sides() == 0 {
            return None;
        }
        let Some((e, stop)) = plain else {
            #[allow(clippy::redundant_closure_for_method_calls)] // the method is of one lifetime
            return self.settle(&Vector::zero(self.shape().increments), |contact, solution| {
                contact.is_declared(solution)
            });
        };
        let contact = Contact {
            declaration,
            h: self.course.h,
            leg: self.next_leg(),
            rests: &[],
        };
        if stop != Stop::Jump && !contact.may_rest(e) {
            return None;
        }
        self.settle(e, |contact, solution| {
            solution.sticking.rests() || stop == Stop::Jump && contact.is_declared(solution)
        })
    }

    /// Solves the step with the functions' values unknown, and goes on if the solution is wanted.
    fn settle(
        &mut self,
        guess: &[f64],
        is_wanted: impl Fn(&Contact<'_>, &sticking::Solution) -> bool,
    ) -> Option<Result<StepReport, StepError>> {
        let solution = {
            let contact = Contact {
                declaration: self.declaration(),
                h: self.course.h,
                leg: self.next_leg(),
                rests: if self.is_stuck() { self.resting() } else { &[] },
            };
            let multipliers = vec![0.0; self.shape().multipliers()];
            let solution = contact.solve(guess, &multipliers)?;
            if !is_wanted(&contact, &solution) {
                return None;
            }
            solution
        };
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
            self.count_unresolved(self.course.time(), 0.0);
        }
        self.go(&solution.e, &solution.multipliers, report, sticking)?;
        Some(Ok(report))
    }

    /// Goes on with a second difference that was solved for with sides.
    fn go(&mut self, e: &[f64], multipliers: &[f64], report: StepReport, sticking: Sticking) -> Option<()> {
        let mut d = self.course.vectors.d();
        d.add(e);
        let q = self.course.vectors.q().plus(&d);
        if !q.hi.is_finite() {
            return None;
        }
        let z = self.step_from(self.next_leg()).unknown(e, multipliers);
        self.course.predictor.push(&z);
        self.course.looked = true;
        let index = self.course.index();
        self.commit(super::discrete::Next { q, d, second: None }, e, report);
        // the clock has not gone on yet
        self.stick(index + 1, sticking);
        Some(())
    }

    /// Writes the constraint force of a step that was solved with sides.
    #[cold]
    pub(super) fn tell_sides(&self, force: &mut [f64]) {
        if let Some(Sticking { first, second, .. }) = self.last_sides() {
            let course = &self.course;
            let (leg, e) = (course.solved_leg(), course.vectors.e());
            let sided = self.declaration().sided_force(course.h, leg, e, [first, second]);
            copy(force, &sided);
        }
    }

    /// Writes the constraint force at the start.
    pub(super) fn first_force(&self, point: AnyPoint<'_, f64>, force: &mut [f64]) {
        let declaration = self.declaration();
        let shape = self.shape();
        if shape.jumps
            && declaration.sides() > 0
            && let Some(found) = sticking::of_motion(
                &declaration,
                (point.t, point.q, point.v),
                shape.multipliers(),
                None,
            )
        {
            copy(force, &declaration.sided_continuous_force(point, &found.sides));
            return;
        }
        declaration.continuous_force_into(point, force);
    }

    /// Counts a step that is too long for what jumps in it.
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
