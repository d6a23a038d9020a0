//! The discrete flow for any number of coordinates: series of smooth steps, and steps solved on slices where one
//! of them is not smooth.

use smallvec::smallvec;

use super::inputs::NodeAtChange;
use super::jumps::{ArgumentSigns, StepConditions};
use super::stick::Contacts;
use crate::error::{SetupError, StepError};
use crate::kernel::Kernel;
use crate::kernel::clock::{Clock, End};
use crate::kernel::halt::{Halt, HaltReason};
use crate::kernel::report::{Guess, NodeMut, NodeScalars, StepReport};
use crate::kernel::run_state::RunState;
use crate::number::point::{AnyLeg, AnyPoint, copy};
use crate::regularity::sticking::Outlook;
use crate::regularity::{Regularity, forks};
use crate::run::{AnyNode, NearlySingular, Run, RunError, Unresolved};
use crate::solve::failure::{NewtonFailure, StepFailure};
use crate::solve::newton::Stop;
use crate::solve::predictor::Predictor;
use crate::solve::rotation;
use crate::solve::sum::Sum;
use crate::solve::{Numbers, Vector};
use crate::start::{self, ComputedStart, StartData};
use crate::step::{FailurePlace, Step, limit};
use crate::tape::Shape;
use crate::tape::declaration::Declaration;

/// A run by the paper's step.
#[derive(Clone)]
pub(crate) struct Discrete<'s> {
    /// The system.
    pub kernel: &'s dyn Kernel,
    /// The values of its parameters.
    pub values: Vec<f64>,
    /// The state that is carried from step to step.
    pub run_state: RunState,
    /// The start.
    pub computed_start: ComputedStart,
    /// The values of the parameters on the last leg, if inputs have changed since.
    pub(super) before: Option<Vec<f64>>,
    /// The last node where inputs changed.
    pub(super) changed: Option<Box<NodeAtChange>>,
    /// The steps so far that were too long for a jump in them.
    pub(super) unresolved: Option<Unresolved>,
    /// The steps near a singularity.
    pub(super) nearly_singular: Option<NearlySingular>,
    /// The state of functions that jump with the velocity, if there are any.
    pub(super) contacts: Option<Box<Contacts>>,
    /// The state of the arguments of piecewise functions, if there are any.
    pub(super) switches: Option<ArgumentSigns>,
    /// Whether the declaration has tables of samples.
    has_tables: bool,
    /// Whether the motion from the start is not unique, where a force jumps with the position.
    pub(super) begins_at_fork: bool,
}

/// The result of a step.
pub(super) struct StepResult {
    /// The position.
    pub q: Sum,
    /// The increment that leads to it.
    pub d: Sum,
    /// In third order, the second difference that ends there.
    pub second: Option<Sum>,
}

/// Checks the step and the parameters.
pub(crate) fn check(declaration: &Declaration<'_>, h: f64) -> Result<(), SetupError> {
    if !h.is_finite() || h == 0.0 {
        return Err(SetupError::Step { h });
    }
    let smallest = if declaration.shape().is_of_third_order() {
        h * h * h
    } else {
        h * h
    };
    if !smallest.is_normal() {
        return Err(SetupError::StepRange { h });
    }
    start::check_parameters(declaration)
}

/// The values of a system's parameters.
pub(crate) fn values_of(kernel: &dyn Kernel) -> Vec<f64> {
    (0..kernel.shape().parameters.len())
        .map(|place| kernel.value(place))
        .collect()
}

/// The constants of a run with the step `h`.
pub(crate) fn constants_of(kernel: &dyn Kernel, values: &[f64], h: f64) -> Numbers {
    let mut constants = smallvec![f64::NAN; kernel.shape().constants];
    kernel.constants(values, h, &mut constants);
    constants
}

impl<'s> Discrete<'s> {
    /// Sets up a run with the step `h` and the given values of the parameters.
    pub fn new(
        kernel: &'s dyn Kernel,
        values: Vec<f64>,
        h: f64,
        start: &StartData,
    ) -> Result<Self, SetupError> {
        let (shape, declaration) = (kernel.shape(), Declaration::of(kernel).with(&values));
        check(&declaration, h)?;
        declaration.prepare();
        let computed_start = start.begin(&declaration, h)?;
        let contacts = if shape.jumps {
            Contacts::at_start(&declaration, h, &computed_start)
        } else {
            None
        };
        let switches = ArgumentSigns::of(&declaration);
        let has_tables = declaration.has_tables();
        let begins_at_fork = {
            let ComputedStart { t0, q0, v0, .. } = &computed_start;
            switches.is_some() && forks::at_start(&declaration, (*t0, q0, v0), h)
        };
        let constants = constants_of(kernel, &values, h);
        let run_state = RunState {
            given: computed_start.e.clone(),
            next_examination: if switches.is_some() { 0 } else { u64::MAX },
            ..RunState::new(
                shape,
                (h, constants),
                computed_start.t0,
                (&computed_start.q, &computed_start.d),
            )
        };
        Ok(Self {
            kernel,
            values,
            run_state,
            computed_start,
            before: None,
            changed: None,
            unresolved: None,
            nearly_singular: None,
            contacts,
            has_tables,
            switches,
            begins_at_fork,
        })
    }

    /// The shape of the system.
    pub fn shape(&self) -> &'s Shape {
        self.kernel.shape()
    }

    /// The declaration, with the current values of the parameters.
    pub fn declaration(&self) -> Declaration<'_> {
        Declaration::of(self.kernel).with(&self.values)
    }

    /// The first leg of the next step.
    pub(super) fn next_leg(&self) -> AnyLeg<'_, f64> {
        self.run_state.next_leg(self.shape())
    }

    /// Makes up to `count` steps.
    #[inline]
    pub fn steps(&mut self, count: u64) -> Result<(), StepError> {
        let end = self.run_state.clock.index() + count;
        loop {
            let left = end.saturating_sub(self.run_state.clock.index());
            let halt = if self.before.is_some() && left > 0 {
                Halt::NotSmooth(HaltReason::InputChanges)
            } else {
                self.kernel.smooth(&mut self.run_state, left)
            };
            match halt {
                Halt::Done => return Ok(()),
                Halt::NotSmooth(HaltReason::RestOrSignChange)
                    if matches!(self.outlook(), Outlook::Clear(_)) => {}
                Halt::NotSmooth(_) => {
                    self.answer()?;
                    self.run_state.clock.tick();
                }
            }
        }
    }

    /// Solves the next step on slices, from every guess and with sides if need be, and moves to its position. The clock is left as it is.
    #[cold]
    pub fn answer(&mut self) -> Result<StepReport, StepError> {
        let shape = self.shape();
        self.catch_up();
        let outlook = self.is_to_look().then(|| self.outlook());
        let is_near = outlook == Some(Outlook::Sided);
        if self.begins_at_fork() {
            return Err(self.forked());
        }
        if is_near {
            if self.forks() {
                return Err(self.forked());
            }
            if let Some(report) = self.solve_sided(None, false) {
                return report;
            }
        }
        if let Some(before) = self.before.take() {
            let report = self.solve_changed(before)?;
            self.take_signs();
            self.look_again();
            return Ok(report);
        }
        if let Some(second) = self.run_state.given.take() {
            return Ok(self.take_given(&second));
        }
        // taken out, since the equations borrow the rest of the run
        let mut predictor = core::mem::replace(&mut self.run_state.predictor, Predictor::new(0));
        let solution = {
            let step = self.next_step();
            step.solve_or_limit(&mut predictor, self.run_state.max_iterations)
        };
        self.run_state.predictor = predictor;
        let (e, z, report) = match solution {
            Ok(solution) => solution,
            Err(cause) => {
                let none = Vector::zero(shape.increments);
                if let Some(report) = self.solve_sided(Some(&none), true) {
                    return report;
                }
                return Err(self.failed(cause));
            }
        };
        let Some(next) = self.arriving(&e) else {
            return Err(self.not_finite(&z));
        };
        let may_switch = self.may_switch();
        let (mut foreseen, mut changes) = (true, false);
        if !shape.is_of_third_order() {
            foreseen = (!may_switch || self.is_near_prediction(&z, &e))
                && !(shape.jumps && report.stop == Stop::Jump);
            if self.contacts.is_some() && (is_near || !foreseen) {
                changes = report.stop == Stop::Jump || !self.keeps_sides(&e);
                if changes && let Some(report) = self.solve_sided(Some(&e), report.stop == Stop::Jump) {
                    return report;
                }
                self.look_again();
            }
        }
        if report.stop != Stop::Jump {
            self.look_for_singularity(&e, &z, report.guess)?;
        }
        self.run_state.predictor.push(&z);
        let before = self.contacts.as_ref().map(|contacts| contacts.pieces.clone());
        let span = StepConditions {
            before: before.as_deref().unwrap_or(&[]),
            after: &[],
            inputs: None,
        };
        let meets_switch = self.look_for_jumps(span, &e);
        if meets_switch || outlook == Some(Outlook::Switches) {
            self.look_again();
        }
        // just after a release the argument is still near zero, and its force changes fast, but does not jump
        if !foreseen && !meets_switch && (changes || report.stop == Stop::Jump || !self.is_torn_off()) {
            self.look_between(&e, report.stop);
        }
        if may_switch || shape.jumps {
            self.run_state.is_examined = !foreseen || meets_switch;
        }
        self.commit(next, &e, report);
        if changes {
            self.take_signs();
        }
        Ok(report)
    }

    /// The position that an increment leads to.
    pub(super) fn moved(&self, q: &Sum, d: &Sum) -> Sum {
        rotation::moved_sum(&self.shape().rotations, q, d)
    }

    /// The next position for a solution; `None` if it is not finite, or a rotation turns too far in the step.
    pub(super) fn arriving(&self, e: &[f64]) -> Option<StepResult> {
        let next = self.leads_to(e);
        let turns_too_far = rotation::turns_too_far(&self.shape().rotations, &next.d.hi).is_some();
        (next.q.hi.is_finite() && !turns_too_far).then_some(next)
    }

    /// The next position for a solution.
    pub(super) fn leads_to(&self, e: &[f64]) -> StepResult {
        let vectors = &self.run_state.vectors;
        let mut d = vectors.d();
        let second = self.shape().is_of_third_order().then(|| {
            let mut second = vectors.second();
            second.add(e);
            second
        });
        match &second {
            Some(second) => d = d.plus(second),
            None => d.add(e),
        }
        let q = self.moved(&vectors.q(), &d);
        StepResult { q, d, second }
    }

    /// Moves to the next position.
    pub(super) fn commit(&mut self, StepResult { q, d, second }: StepResult, e: &[f64], report: StepReport) {
        let t = self.next_leg().t;
        let run_state = &mut self.run_state;
        run_state.vectors.commit(&q, &d, e);
        (run_state.solved_at, run_state.report) = (t, report);
        run_state.has_solved = true;
        if let Some(second) = second {
            self.go_on(&second);
        }
    }

    /// In third order: moves on to a second difference.
    pub(super) fn go_on(&mut self, second: &Sum) {
        let run_state = &mut self.run_state;
        self.kernel.remember(&mut run_state.constants, &second.hi);
        run_state.vectors.go_on(second);
        run_state.given = None;
    }

    /// Makes the step whose second difference is given.
    fn take_given(&mut self, second: &Sum) -> StepReport {
        let report = StepReport {
            iterations: 0,
            stop: Stop::Start,
            guess: Guess::Given,
        };
        let d = self.run_state.vectors.d().plus(second);
        let q = self.moved(&self.run_state.vectors.q(), &d);
        let e = second.hi.clone();
        let next = StepResult { q, d, second: None };
        self.commit(next, &e, report);
        // the given second difference counts as a third difference that follows a second difference of zero
        self.run_state
            .vectors
            .set_second(&Sum::exact(Vector::zero(e.len())));
        self.go_on(second);
        report
    }

    /// The equations of the next step.
    pub fn next_step(&self) -> Step<'_> {
        // with the time even if the system does not depend on it: errors report it
        let mut step = self.step_from(AnyLeg {
            t: self.run_state.time(),
            ..self.next_leg()
        });
        step.past_is_short = self.run_state.past_is_short();
        if self.run_state.index() == 1 {
            step.initial_acceleration = self.computed_start.initial_acceleration();
        }
        step
    }

    /// The equations of a step after a leg.
    pub(super) fn step_from<'a>(&'a self, leg: AnyLeg<'a, f64>) -> Step<'a> {
        let RunState { constants, h, .. } = &self.run_state;
        Step::new((self.kernel, &self.values), constants, leg, *h)
    }

    /// The error of the next step.
    #[cold]
    pub(super) fn failed(&self, cause: NewtonFailure) -> StepError {
        let run_state = &self.run_state;
        let failing = FailurePlace {
            index: run_state.index(),
            time: run_state.time(),
            q0: &self
                .moved(&run_state.vectors.q(), &run_state.vectors.d().negated())
                .hi,
        };
        self.next_step().error(&failing, cause)
    }

    /// The error of a step whose motion may go on in more than one way.
    #[cold]
    pub(super) fn forked(&self) -> StepError {
        let step = self.next_step();
        let z = step.unknown(
            &Vector::zero(self.shape().increments),
            &vec![0.0; self.shape().multipliers()],
        );
        self.failed(step.refused(StepFailure::Forks, &z))
    }

    /// The error of a step whose root leads to no finite node.
    #[cold]
    pub(super) fn not_finite(&self, z: &[f64]) -> StepError {
        let step = self.next_step();
        let next = self.leads_to(&step.second_difference(z));
        let turns_too_far = rotation::turns_too_far(&self.shape().rotations, &next.d.hi).is_some();
        self.failed(if next.d.hi.is_finite() && turns_too_far {
            step.refused(StepFailure::TurnsTooFar, z)
        } else {
            step.not_finite(z)
        })
    }

    /// Writes the middle node of the last step.
    #[inline]
    fn write_solved(&self, node: NodeMut<'_>) {
        let RunState { clock, report, .. } = &self.run_state;
        let NodeMut { vectors, scalars } = node;
        self.kernel.report(
            &self.run_state,
            NodeMut {
                vectors: &mut *vectors,
                scalars: &mut *scalars,
            },
        );
        (scalars.index, scalars.t) = (clock.index(), clock.time());
        (scalars.iterations, scalars.stop) = (report.iterations, report.stop);
        if report.guess == Guess::Limit {
            self.write_limit(NodeMut {
                vectors: &mut *vectors,
                scalars: &mut *scalars,
            });
        }
        if self.contacts.is_some() || self.changed.is_some() || self.before.is_some() {
            self.write_others(NodeMut { vectors, scalars });
        } else if self.has_tables {
            self.write_arrival(NodeMut { vectors, scalars });
        }
    }

    /// Replaces the constraint force and the energy of a node at which the declaration has limits in place of values.
    #[cold]
    fn write_limit(&self, mut node: NodeMut<'_>) {
        let (shape, run_state) = (self.shape(), &self.run_state);
        let of_step = (run_state.h, &run_state.constants[..]);
        let past = [run_state.vectors.e(), run_state.vectors.before()];
        let mut numbers = vec![f64::NAN; node.vectors.len()];
        let data = |leg: AnyLeg<'_, f64>| {
            let mut scalars = NodeScalars::UNKNOWN;
            self.kernel.report(
                &RunState::of_step(shape, of_step, leg, past),
                NodeMut {
                    vectors: &mut numbers,
                    scalars: &mut scalars,
                },
            );
            let (_, force) = numbers.split_at(numbers.len() / 4 * 3);
            Some(force.iter().copied().chain([scalars.energy]).collect())
        };
        let place = (run_state.h, run_state.solved_leg());
        if let Some(limit) = limit::of_vector(&shape.rotations, place, data)
            && let [limit @ .., energy] = &limit[..]
        {
            let [.., force] = node.split();
            copy(force, limit);
            node.scalars.energy = *energy;
        }
    }

    /// Replaces the data of a node whose step solved other equations than the declared ones with the current values: where inputs change,
    /// where functions have values between their sides, and at a corner of a table.
    #[cold]
    fn write_others(&self, node: NodeMut<'_>) {
        let NodeMut { vectors, scalars } = node;
        if let Some(before) = &self.before {
            // values that are set here hold from the next node on
            let mut run_state = self.run_state.clone();
            run_state.constants = constants_of(self.kernel, before, run_state.h);
            let (index, t, iterations, stop) = (scalars.index, scalars.t, scalars.iterations, scalars.stop);
            self.kernel.report(
                &run_state,
                NodeMut {
                    vectors: &mut *vectors,
                    scalars: &mut *scalars,
                },
            );
            (scalars.index, scalars.t, scalars.iterations, scalars.stop) = (index, t, iterations, stop);
        }
        if self.contacts.is_some() {
            let (_, force) = vectors.split_at_mut(vectors.len() / 4 * 3);
            self.write_sided_force(force);
        }
        let changed = self.changed.as_ref();
        if let Some(changed) = changed.filter(|changed| changed.index == scalars.index) {
            self.write_changed(changed, NodeMut { vectors, scalars });
        } else if self.has_tables && !self.rests() {
            self.write_arrival(NodeMut { vectors, scalars });
        }
    }

    /// Writes the velocity, the acceleration, the constraint force and the energy of a node where inputs changed.
    fn write_changed(&self, changed: &NodeAtChange, mut node: NodeMut<'_>) {
        let t = node.scalars.t;
        let [q, v, a, force] = node.split();
        copy(v, &changed.velocity);
        copy(a, &changed.acceleration);
        copy(force, &changed.force);
        let arriving = Declaration::of(self.kernel).with(&changed.before);
        node.scalars.energy = arriving.energy(t, &*q, &*v);
    }

    /// Writes the node of the start.
    #[cold]
    fn write_first(&self, node: NodeMut<'_>) {
        let ComputedStart { q0, v0, a0, t0, .. } = &self.computed_start;
        let declaration = self.declaration();
        let found;
        let a = if let Some(a0) = a0 {
            a0
        } else {
            let acceleration = start::acceleration(&declaration, (*t0, q0, v0), None);
            found = acceleration.map_or_else(|_| Vector::nan(q0.len()), |(a, _)| a);
            &found
        };
        let point = AnyPoint {
            t: *t0,
            q: q0,
            v: v0,
            a,
        };
        let mut force = Vector::nan(q0.len());
        self.first_force(point, &mut force);
        node.write(&AnyNode {
            index: self.run_state.clock.index(),
            t: self.run_state.clock.time(),
            q: q0,
            v: v0,
            a,
            force: &force,
            energy: declaration.energy(*t0, &q0[..], &v0[..]),
            iterations: 0,
            stop: Stop::Start,
        });
    }

    /// Reverses the run in time; see [`Flow`](crate::Flow), "Back in time".
    fn turn(&mut self) -> Result<(), StepError> {
        let mut turned = self.clone();
        turned.run_state.h = -self.run_state.h;
        // at a change of inputs, the reversed run exchanges the values before and after the node
        let index = self.run_state.clock.index();
        if let Some(changed) = self.changed.as_ref().filter(|changed| changed.index == index) {
            let before = core::mem::replace(&mut turned.values, changed.before.clone());
            turned.before = Some(before);
        }
        let run_state = &mut turned.run_state;
        run_state.constants = constants_of(self.kernel, &turned.values, run_state.h);
        let d = self.run_state.vectors.d().negated();
        run_state
            .vectors
            .set_leg(&self.moved(&self.run_state.vectors.q(), &d), &d);
        run_state.predictor.turn();
        if self.shape().is_of_third_order() {
            turned.turn_third();
        }
        let run_state = &mut turned.run_state;
        run_state.clock.turn();
        run_state.ahead = 0;
        run_state.since = 0;
        turned.turn_contacts();
        turned.answer()?;
        turned.run_state.ahead = 1;
        *self = turned;
        Ok(())
    }

    /// Reverses the past of third order. The second difference about the current node is its own reverse, and so gives the first step back.
    /// At the start, where no step was solved, the given second difference becomes the past of the first step back.
    fn turn_third(&mut self) {
        if self.run_state.has_solved {
            self.run_state.given = Some(self.run_state.vectors.second());
        } else if let Some(first) = self.run_state.given.take() {
            self.go_on(&first);
        }
        // third differences change their signs, so past solutions are not extrapolated
        self.run_state.predictor = Predictor::new(self.shape().unknowns);
    }

    /// The certificate of the last step's equations.
    fn regularity_of_last(&self) -> Option<Regularity> {
        let RunState {
            vectors, report, h, ..
        } = &self.run_state;
        if !self.run_state.has_solved {
            return None;
        }
        let declaration = self.declaration();
        if !self.shape().is_of_third_order() {
            return Some(Regularity::of_declaration(
                &declaration,
                *h,
                self.run_state.solved_leg(),
                vectors.e(),
            ));
        }
        // the step of the start does not solve the declared equations
        if report.guess == Guess::Given && report.stop == Stop::Start {
            return None;
        }
        Some(Regularity::of_third(
            &declaration.after(vectors.before()),
            vectors.before(),
            &self.shape().third_order,
            *h,
            self.run_state.solved_leg(),
            vectors.e(),
        ))
    }
}

impl Run for Discrete<'_> {
    fn kernel(&self) -> &dyn Kernel {
        self.kernel
    }

    fn values(&self) -> &[f64] {
        &self.values
    }

    fn arriving_values(&self) -> &[f64] {
        let index = self.run_state.clock.index();
        let changed = self.changed.as_ref().filter(|changed| changed.index == index);
        let until_now = self.before.as_ref().unwrap_or(&self.values);
        changed.map_or(until_now, |changed| &changed.before)
    }

    fn resting(&self) -> Vec<bool> {
        self.resting_arguments()
    }

    fn has_differences(&self) -> bool {
        true
    }

    #[inline]
    fn step(&mut self, _: f64) -> Result<StepReport, RunError> {
        self.steps(1)?;
        Ok(self.run_state.report)
    }

    fn reach(&mut self, end: &End) -> Result<(), RunError> {
        self.run_state.clock.hand_out(true);
        let left = end
            .index()
            .map(|end| end.saturating_sub(self.run_state.clock.index()));
        Ok(self.steps(left.unwrap_or(0))?)
    }

    #[inline]
    fn write_node(&self, node: NodeMut<'_>) {
        if self.run_state.has_solved {
            self.write_solved(node);
        } else {
            self.write_first(node);
        }
    }

    fn write_departure(&self, node: NodeMut<'_>) {
        let NodeMut { vectors, scalars } = node;
        self.write_node(NodeMut {
            vectors: &mut *vectors,
            scalars: &mut *scalars,
        });
        let index = self.run_state.clock.index();
        if let Some(changed) = self.changed.as_ref().filter(|changed| changed.index == index) {
            let mut node = NodeMut { vectors, scalars };
            let [_, v, a, _] = node.split();
            let [after, acceleration] = &changed.departing;
            copy(v, after);
            copy(a, acceleration);
        }
    }

    fn clock(&self) -> &Clock {
        &self.run_state.clock
    }

    fn clock_mut(&mut self) -> &mut Clock {
        &mut self.run_state.clock
    }

    /// Solves the step back about the current node at once. The node then has the velocity and the force of
    /// this step, and the last known position is the node before it.
    fn reverse(&mut self) -> Result<(), RunError> {
        Ok(self.turn()?)
    }

    fn regularity(&self) -> Option<Regularity> {
        self.regularity_of_last()
    }

    fn unresolved(&self) -> Option<Unresolved> {
        self.unresolved
    }

    fn nearly_singular(&self) -> Option<NearlySingular> {
        self.nearly_singular
    }

    fn set_value(&mut self, place: usize, value: f64) -> Result<(), RunError> {
        self.change(place, value)
    }
}
