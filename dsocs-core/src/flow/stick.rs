//! Steps of a flow in which a body comes to rest, rests or slips where a function jumps; see
//! [`crate::regularity::sticking`].

use super::discrete::Discrete;
use super::inputs::NodeAtChange;
use super::jumps::StepConditions;
use crate::error::StepError;
use crate::kernel::report::{Guess, StepReport};
use crate::number::point::{AnyLeg, AnyPoint, copy};
use crate::regularity::multipliers;
use crate::regularity::resting::{self, AtPoint};
use crate::regularity::sides::{self, Piece};
use crate::regularity::sticking::{self, Contact, Outlook, Solution};
use crate::solve::Vector;
use crate::solve::newton::Stop;
use crate::solve::predictor::PAST;
use crate::start::place::Place;
use crate::start::{self, ComputedStart, third};
use crate::tape::declaration::Declaration;

/// The state of the arguments of functions that jump with the velocity.
#[derive(Clone, Debug)]
pub(super) struct Contacts {
    /// The pieces of the arguments on the last leg; those between rest.
    pub(super) pieces: Vec<Piece>,
    /// The sides of a step that the declared rows do not solve, and the number of the step after it.
    sides: Option<(u64, Vec<f64>)>,
    /// The number of the step after the last one in which a side changed.
    changed: Option<u64>,
    /// The pieces before that change.
    earlier: Vec<Piece>,
    /// The number of the last step on whose first leg the arguments were evaluated.
    seen: u64,
    /// Whether the motion from the start is not unique.
    forks: bool,
}

impl Contacts {
    /// The state at the start; `None` if there are no such functions.
    #[cold]
    pub(super) fn at_start(
        declaration: &Declaration<'_>,
        h: f64,
        computed_start: &ComputedStart,
    ) -> Option<Box<Self>> {
        if declaration.sides() == 0 {
            return None;
        }
        let ComputedStart {
            t0, q0, v0, a0, q, d, ..
        } = computed_start;
        let leg = AnyLeg {
            t: t0 + h,
            q: &q.hi,
            d: &d.hi,
        };
        let mut pieces = sticking::pieces_of_leg(declaration, h, leg);
        let multipliers = declaration.shape().multipliers();
        if a0.is_some()
            && let Some(found) = resting::of_motion(declaration, (*t0, q0, v0), multipliers, None)
        {
            for (piece, still) in pieces.iter_mut().zip(&found.still) {
                if *still {
                    *piece = Piece::Between;
                }
            }
        }
        let resting = sticking::zero(declaration, *t0, q0, v0);
        let point = AtPoint::new(*declaration, (*t0, q0, v0));
        Some(Box::new(Self {
            forks: h > 0.0 && resting.contains(&true) && point.forks(&resting, multipliers, h),
            earlier: pieces.clone(),
            pieces,
            sides: None,
            changed: None,
            seen: 1,
        }))
    }
}

impl Discrete<'_> {
    /// The next step as a contact problem.
    fn contact<'a>(&'a self, declaration: Declaration<'a>, contacts: &'a Contacts) -> Contact<'a> {
        Contact {
            declaration,
            before: None,
            h: self.run_state.h,
            leg: AnyLeg {
                t: self.run_state.time(),
                ..self.next_leg()
            },
            pieces: &contacts.pieces,
        }
    }

    /// The predicted second difference, and its change from the last one.
    pub(super) fn expected(&self) -> Option<[Vector; 2]> {
        let predictor = &self.run_state.predictor;
        let step = self.next_step();
        let e = step.second_difference(&predictor.predict()?);
        let last = step.second_difference(predictor.vectors().next()?);
        let bend = e.zip(&last, |e, last| e - last);
        (e.is_finite() && bend.is_finite()).then_some([e, bend])
    }

    /// Updates the signs of arguments after smooth steps, in which they were not evaluated: a motion may
    /// change faster than its last steps suggested. An argument that has changed its sign in the last step
    /// alone counts as arriving at zero where the next begins, which is solved with sides.
    #[cold]
    pub(super) fn catch_up(&mut self) {
        let index = self.run_state.index();
        let Some(contacts) = self.contacts.as_ref().filter(|contacts| contacts.seen < index) else {
            return;
        };
        let mut contacts = contacts.clone();
        contacts.seen = index;
        if self.run_state.has_solved {
            let (declaration, h, t) = (self.declaration(), self.run_state.h, self.run_state.time());
            let legs = [(t, self.next_leg()), (t - h, self.run_state.solved_leg())];
            let [last, before] =
                legs.map(|(t, leg)| sticking::pieces_of_leg(&declaration, h, AnyLeg { t, ..leg }));
            for ((piece, last), before) in contacts.pieces.iter_mut().zip(last).zip(before) {
                if last == before && last != Piece::Between {
                    *piece = last;
                }
            }
        }
        self.contacts = Some(contacts);
    }

    /// The possible events of the next step. If there are none, smooth steps go on for a while.
    #[cold]
    pub(crate) fn outlook(&mut self) -> Outlook {
        self.catch_up();
        let expected = self.expected();
        let none = Vector::zero(self.shape().increments);
        let [e, bend] = expected.as_ref().map_or([&none, &none], |[e, bend]| [e, bend]);
        let mut outlook = Outlook::Clear(u64::MAX);
        if let Some(contacts) = &self.contacts {
            outlook = self.contact(self.declaration(), contacts).outlook(e, bend);
            if let Some(before) = &self.before {
                let old = Declaration::of(self.kernel).with(before);
                // past steps do not know the new values of the inputs
                let next = self.new_second_difference();
                let of_new = |e: Vector| self.contact(self.declaration(), contacts).outlook(&e, &none);
                if self.contact(old, contacts).outlook(e, bend) == Outlook::Sided
                    || next.map_or(Outlook::Sided, of_new) == Outlook::Sided
                {
                    return Outlook::Sided;
                }
            }
        }
        if let Outlook::Clear(steps) = outlook
            && self.before.is_none()
        {
            let steps = steps.min(self.clear_of_switches(e));
            // rates of arguments need a full past: a motion that begins where its velocity reverses seems
            // uniform
            let has_past = self.run_state.predictor.past().len() == PAST;
            let steps = if has_past || steps == 0 { steps } else { 1 };
            if steps == 0 || expected.is_none() {
                return Outlook::Switches;
            }
            self.run_state.next_examination = self.run_state.index() + steps;
            return Outlook::Clear(steps);
        }
        outlook
    }

    /// The second difference of the acceleration at the middle node for the velocity of the leg before, with
    /// the new values of inputs.
    fn new_second_difference(&self) -> Option<Vector> {
        let (leg, h) = (self.next_leg(), self.run_state.h);
        let v = Vector::of(leg.d).map(|d| d / h);
        let found = start::acceleration(&self.declaration(), (self.run_state.time(), leg.q, &v), None);
        found.ok().map(|(a, _)| a.map(|a| h * h * a))
    }

    /// Whether arguments are to be evaluated in the next step.
    pub(super) fn is_to_look(&self) -> bool {
        self.switches.is_some()
            && (self.before.is_some() || self.run_state.next_examination <= self.run_state.index())
    }

    /// Whether a solution of the declared rows keeps the sides.
    pub(super) fn keeps_sides(&self, e: &[f64]) -> bool {
        let Some(contacts) = &self.contacts else {
            return true;
        };
        let contact = self.contact(self.declaration(), contacts);
        let multipliers = multipliers::of_step(&contact.declaration, contact.h, contact.leg, e);
        contact.keeps(e, &multipliers)
    }

    /// Requires that arguments are evaluated in the next step.
    pub(super) fn look_again(&mut self) {
        if self.switches.is_some() {
            self.run_state.next_examination = self.run_state.index() + 1;
        }
    }

    /// Updates the signs of arguments after a step that was solved without sides.
    #[cold]
    pub(super) fn take_signs(&mut self) {
        if self.contacts.is_none() {
            return;
        }
        let leg = AnyLeg {
            t: self.run_state.time() + self.run_state.h,
            q: self.run_state.vectors.position(),
            d: self.run_state.vectors.increment(),
        };
        let pieces = sticking::pieces_of_leg(&self.declaration(), self.run_state.h, leg);
        let index = self.run_state.index();
        if let Some(contacts) = &mut self.contacts {
            if pieces != contacts.pieces {
                contacts.changed = Some(index + 1);
                contacts.earlier.clone_from(&contacts.pieces);
            }
            contacts.pieces = pieces;
            contacts.seen = index + 1;
        }
    }

    /// Adapts the contacts to a run that has been reversed.
    pub(super) fn turn_contacts(&mut self) {
        if let Some(contacts) = &mut self.contacts {
            contacts.sides = None;
            contacts.seen = 0;
        }
        if let Some(switches) = &mut self.switches {
            switches.forget();
            self.run_state.next_examination = 0;
        }
    }

    /// Whether a resting argument was released in the last step.
    pub(super) fn is_torn_off(&self) -> bool {
        self.contacts.as_ref().is_some_and(|contacts| {
            contacts.changed == Some(self.run_state.index()) && contacts.earlier.contains(&Piece::Between)
        })
    }

    /// Whether the next step is the first, and the motion from the start is not unique.
    pub(super) fn begins_at_fork(&self) -> bool {
        let forks = self.contacts.as_ref().is_some_and(|contacts| contacts.forks);
        (forks || self.begins_at_fork) && self.run_state.index() == self.first_step()
    }

    /// Whether the motion is not unique where the next step begins, at rest.
    #[cold]
    pub(super) fn forks(&self) -> bool {
        let v = self.next_leg().d.iter().map(|d| d / self.run_state.h);
        self.forks_with(&v.collect::<Vec<_>>(), &self.resting_arguments())
    }

    /// Whether the motion is not unique with a velocity at the middle node of the next step, at which some
    /// arguments are zero.
    fn forks_with(&self, v: &[f64], zero: &[bool]) -> bool {
        let h = self.run_state.h;
        h > 0.0
            && zero.contains(&true)
            && AtPoint::new(self.declaration(), (self.run_state.time(), self.next_leg().q, v)).forks(
                zero,
                self.shape().multipliers(),
                h,
            )
    }

    /// Whether an argument that changes its sign in the next step, from the leg before to that of the second
    /// difference `e`, could go on in another way where it is zero.
    fn passes_fork(&self, contacts: &Contacts, solution: &Solution) -> bool {
        let (leg, h, t) = (self.next_leg(), self.run_state.h, self.run_state.time());
        let (first, declaration) = (AnyLeg { t, ..leg }, self.declaration());
        let next = self.contact(declaration, contacts).next(&solution.e);
        let [before, after] = [first, next.any()].map(|leg| sticking::in_the_middle(&declaration, h, leg));
        (0..before.len()).any(|g| {
            let [from, to] = [contacts.pieces[g], solution.pieces[g]];
            from.side() * to.side() < 0.0 && {
                let part = before[g] / (before[g] - after[g]);
                let v = leg.d.iter().zip(&solution.e).map(|(d, e)| (d + part * e) / h);
                let zero: Vec<bool> = (0..before.len()).map(|k| k == g).collect();
                self.forks_with(&v.collect::<Vec<_>>(), &zero)
            }
        })
    }

    /// Whether an argument rests on the last leg.
    pub(super) fn rests(&self) -> bool {
        let contacts = self.contacts.as_ref();
        contacts.is_some_and(|contacts| contacts.pieces.contains(&Piece::Between))
    }

    /// Whether each argument is zero on the last leg; empty if none is.
    pub(crate) fn resting_arguments(&self) -> Vec<bool> {
        let contacts = self.contacts.as_ref().filter(|_| self.rests());
        contacts.map_or_else(Vec::new, |contacts| sides::resting(&contacts.pieces))
    }

    /// Begins with some arguments at zero, which another run has found to rest.
    pub(crate) fn begin_at_rest(&mut self, resting: &[bool]) {
        if let Some(contacts) = &mut self.contacts {
            for (piece, rests) in contacts.pieces.iter_mut().zip(resting) {
                if *rests {
                    *piece = Piece::Between;
                }
            }
            contacts.earlier.clone_from(&contacts.pieces);
        }
    }

    /// Whether the last step solves the declared rows only with sides.
    pub(crate) fn has_sides(&self) -> bool {
        self.last_sides().is_some()
    }

    /// Whether a function that jumps with the velocity changed its side in the last step, or has a value
    /// between its sides.
    pub(super) fn meets_jump(&self) -> bool {
        let changed = self.contacts.as_ref().and_then(|contacts| contacts.changed);
        changed == Some(self.run_state.index()) || self.rests() || self.has_sides()
    }

    /// The sides of the last step.
    fn last_sides(&self) -> Option<&[f64]> {
        let (index, sides) = self.contacts.as_ref()?.sides.as_ref()?;
        (*index == self.run_state.index()).then_some(sides)
    }

    /// Solves the next step with sides. `None` if no sides are found, or if arguments only change their signs on
    /// surfaces that do not move: then the declared rows have a root. `none` says that no such root was found.
    #[cold]
    pub(super) fn solve_sided(
        &mut self,
        guess: Option<&[f64]>,
        none: bool,
    ) -> Option<Result<StepReport, StepError>> {
        let expected = || match self.expected() {
            Some([e, _]) => e,
            None => Vector::zero(self.shape().increments),
        };
        let guess = guess.map_or_else(expected, Vector::of);
        // taken out, since the step borrows the rest of the run
        let mut contacts = self.contacts.take()?;
        let report = match self.before.take() {
            None => self.solve_with(&mut contacts, &guess, none),
            Some(before) => {
                let report = self.solve_between(&mut contacts, &before, &guess).map(Ok);
                if report.is_none() {
                    self.before = Some(before);
                }
                report
            }
        };
        self.contacts = Some(contacts);
        report
    }

    /// Solves the step from a guess of its second difference.
    fn solve_with(
        &mut self,
        contacts: &mut Contacts,
        guess: &[f64],
        none: bool,
    ) -> Option<Result<StepReport, StepError>> {
        let (solution, is_declared, only_crosses) = {
            let contact = self.contact(self.declaration(), contacts);
            let solution = contact.solve(guess, &vec![0.0; self.shape().multipliers()])?;
            let is_declared =
                !solution.rests() && contact.is_declared(&solution.e, &solution.multipliers, &solution.sides);
            // rows of positions and velocities have a root at the jump itself; only kinematic rows may jump over zero
            let is_root = is_declared || self.shape().kinematic == 0;
            if self.passes_fork(contacts, &solution) {
                return Some(Err(self.forked()));
            }
            let only_crosses = contact.only_crosses(&solution);
            if only_crosses && !(none && is_root) {
                return None;
            }
            (solution, is_declared, only_crosses)
        };
        if !solution.rests() && !solution.switches {
            let z = self
                .step_from(self.next_leg())
                .unknown(&solution.e, &solution.multipliers);
            if let Some(error) = self.passes_singularity(&solution.e, &z) {
                return Some(Err(error));
            }
        }
        let stop = match (solution.rests(), solution.switches) {
            (true, false) => Stop::Sticks,
            (true, true) => Stop::Jump,
            (false, _) => Stop::Update,
        };
        let report = StepReport {
            iterations: solution.evaluations,
            stop,
            guess: Guess::Predicted,
        };
        let index = self.run_state.index();
        let span = StepConditions {
            before: &contacts.pieces,
            // the turns of such a motion are of first order in other steps
            after: if only_crosses { &[] } else { &solution.pieces },
            inputs: None,
        };
        self.look_for_jumps(span, &solution.e);
        self.go(&solution.e, &solution.multipliers, report)?;
        if solution.pieces != contacts.pieces {
            contacts.changed = Some(index + 1);
            contacts.earlier.clone_from(&contacts.pieces);
        }
        contacts.pieces = solution.pieces;
        contacts.seen = index + 1;
        contacts.sides = (!is_declared).then_some((index + 1, solution.sides));
        Some(Ok(report))
    }

    /// Solves the step where inputs change: each of their values holds in one half of it.
    fn solve_between(
        &mut self,
        contacts: &mut Contacts,
        before: &[f64],
        guess: &[f64],
    ) -> Option<StepReport> {
        let index = self.run_state.index();
        let h = self.run_state.h;
        let (solution, velocity, accelerations, force) = {
            let contact = Contact {
                before: Some(Declaration::of(self.kernel).with(before)),
                ..self.contact(self.declaration(), contacts)
            };
            let none = vec![0.0; self.shape().multipliers()];
            let solution = contact.solve(guess, &none)?;
            let force = Vector::of(&contact.force(&solution));
            // as if the motion continued with the old values
            let old = Declaration::of(self.kernel).with(before);
            let arriving = self.contact(old, contacts).solve(guess, &none);
            let e = arriving.as_ref().map_or(&solution.e, |arriving| &arriving.e);
            let velocity = Vector::of(self.declaration().point(contact.h, contact.leg, &e[..]).any().v);
            let departing = self.contact(self.declaration(), contacts).solve(guess, &none);
            let after = departing.as_ref().map_or(&solution.e, |departing| &departing.e);
            let accelerations = [e, after].map(|e| Vector::of(e).map(|e| e / (h * h)));
            (solution, velocity, accelerations, force)
        };
        let [acceleration, after] = accelerations;
        let report = StepReport {
            iterations: solution.evaluations,
            stop: if solution.rests() && !solution.switches {
                Stop::Sticks
            } else {
                Stop::Update
            },
            guess: Guess::Given,
        };
        let Solution {
            e,
            multipliers,
            pieces,
            ..
        } = solution;
        let span = StepConditions {
            before: &contacts.pieces,
            after: &pieces,
            inputs: Some(before),
        };
        self.look_for_jumps(span, &e);
        self.go(&e, &multipliers, report)?;
        contacts.pieces = pieces;
        contacts.seen = index + 1;
        contacts.sides = None;
        self.run_state.since = index.saturating_sub(1);
        self.changed = Some(Box::new(NodeAtChange {
            index,
            velocity,
            acceleration,
            departing: self.departing(after),
            force,
            before: before.to_vec(),
        }));
        Some(report)
    }

    /// Moves to the next position with a second difference that was solved with sides.
    fn go(&mut self, e: &[f64], multipliers: &[f64], report: StepReport) -> Option<()> {
        let mut d = self.run_state.vectors.d();
        d.add(e);
        let q = self.moved(&self.run_state.vectors.q(), &d);
        if !q.hi.is_finite() {
            return None;
        }
        let z = self.step_from(self.next_leg()).unknown(e, multipliers);
        self.run_state.predictor.push(&z);
        self.run_state.is_examined = true;
        // the clock has not advanced yet
        self.look_again();
        self.commit(super::discrete::StepResult { q, d, second: None }, e, report);
        Some(())
    }

    /// Writes the constraint force of a step that was solved with sides.
    #[cold]
    pub(super) fn write_sided_force(&self, force: &mut [f64]) {
        if let Some(sides) = self.last_sides() {
            let run_state = &self.run_state;
            let (leg, e) = (run_state.solved_leg(), run_state.vectors.e());
            let sided = self.declaration().sided_force(run_state.h, leg, e, sides);
            copy(force, &sided);
        }
    }

    /// Writes the constraint force at the start.
    pub(super) fn first_force(&self, point: AnyPoint<'_, f64>, force: &mut [f64]) {
        let declaration = self.declaration();
        let shape = self.shape();
        if shape.jumps
            && declaration.sides() > 0
            && let Some(sided) = resting::force(&declaration, point)
        {
            copy(force, &sided);
            return;
        }
        if shape.is_of_third_order()
            && let Some(Place { t, q, v, .. }) = third::left_to(&declaration, point, self.run_state.h)
        {
            let (q, v) = (&q[..], &v[..]);
            declaration.continuous_force_into(AnyPoint { t, q, v, ..point }, force);
            return;
        }
        declaration.continuous_force_into(point, force);
    }
}
