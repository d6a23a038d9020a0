//! The step about a node where inputs change.

use super::discrete::{Discrete, constants_of};
use super::jumps::StepConditions;
use crate::error::StepError;
use crate::kernel::report::{Guess, StepReport};
use crate::number::point::{AnyLeg, OwnedLeg, map, moved};
use crate::number::scalar::Scalar as _;
use crate::number::tangent::Tangent;
use crate::regularity::multipliers;
use crate::run::{InputError, RunError};
use crate::solve::Vector;
use crate::solve::dense::Matrix;
use crate::solve::failure::{NewtonFailure, StepFailure};
use crate::solve::newton::Stop;
use crate::solve::predictor::Predictor;
use crate::start;
use crate::step::Step;
use crate::tape::declaration::Declaration;

/// Largest number of iterations for the second difference at a change.
const MAX_ITERATIONS: u32 = 60;

/// An update below this part of the unknowns is the last.
const LAST: f64 = 4.0 * f64::EPSILON;

/// Updates below this part that no longer shrink are rounding.
const ROUNDING: f64 = 1e-9;

/// Least size of a second difference, relative to the leg, with which an update is compared.
const LEAST: f64 = 1e-5;

/// The data of a node where inputs changed, beside its step.
#[derive(Clone)]
pub(super) struct NodeAtChange {
    /// The number of the node.
    pub(super) index: u64,
    /// The velocity with which the motion arrives there, as in a run that continues with the old values. The
    /// mean velocity of both legs differs from it by a quarter of the step times the jump of the
    /// acceleration.
    pub(super) velocity: Vector,
    /// The acceleration with which it arrives; the second difference of the node is the mean of both.
    pub(super) acceleration: Vector,
    /// Velocity and acceleration with which the motion goes on.
    pub(super) departing: [Vector; 2],
    /// The constraint force with which it arrives; that of the change itself is an impulse, visible in the
    /// momentum.
    pub(super) force: Vector,
    /// The values of the parameters before.
    pub(super) before: Vec<f64>,
}

impl Discrete<'_> {
    /// Sets a parameter to a value that holds from the last known position on.
    pub(super) fn change(&mut self, place: usize, value: f64) -> Result<(), RunError> {
        let shape = self.shape();
        if shape.is_of_third_order() {
            let parameter = shape.parameters.get(place);
            return Err(RunError::Input(Box::new(InputError::ThirdOrder {
                parameter: parameter.map_or_else(Default::default, |parameter| parameter.name.clone()),
            })));
        }
        // several changes at one node are one
        if self.before.is_none() {
            self.before = Some(self.values.clone());
        }
        if let Some(parameter) = self.values.get_mut(place) {
            *parameter = value;
        }
        self.run_state.constants = constants_of(self.kernel, &self.values, self.run_state.h);
        Ok(())
    }

    /// Solves the step about the last known position, between two values of the inputs, and moves on as
    /// [`Discrete::answer`] does.
    #[cold]
    pub(super) fn solve_changed(&mut self, before: Vec<f64>) -> Result<StepReport, StepError> {
        let (shape, h, max_iterations) = (self.shape(), self.run_state.h, self.run_state.max_iterations);
        // the steps with each of the values on both sides
        let constants = constants_of(self.kernel, &before, h);
        let mut predictor = Predictor::new(shape.unknowns);
        let solved = {
            let leg = self.next_leg();
            let mut old = Step::new((self.kernel, &before), &constants, leg, h);
            let next = self.next_step();
            (old.past_is_short, old.initial_acceleration) = (next.past_is_short, next.initial_acceleration);
            let arriving = old.solve(&mut self.run_state.predictor.clone(), max_iterations);
            let mut new = self.step_from(leg);
            new.past_is_short = true;
            let found = match (new.solve(&mut predictor, max_iterations), &arriving) {
                (Err(_), Ok((z, _))) => {
                    predictor = Predictor::new(shape.unknowns);
                    let size = new.size(&predictor);
                    new.solve_near(z, &mut predictor, &size, max_iterations)
                }
                (found, _) => found,
            };
            let (z, report) = match found {
                Ok(solution) => solution,
                Err(cause) => return Err(self.failed(cause)),
            };
            let e = new.second_difference(&z);
            let e_old = arriving.map_or_else(|_| e.clone(), |(z, _)| old.second_difference(&z));
            let change = StepAcrossChange::new(
                [Declaration::of(self.kernel).with(&before), self.declaration()],
                shape.kinematic,
                [shape.holonomic, shape.nonholonomic],
                h,
                leg,
            );
            let velocity = Vector::of(change.sides[1].point(h, leg, &e_old[..]).any().v);
            let force = Vector::of(&change.sides[0].force(h, leg, &e_old[..]));
            let accelerations = [&e_old, &e].map(|e| Vector::of(e).map(|e| e / (h * h)));
            change
                .solve([&e_old, &e])
                .map(|e| (z, report, Vector::of(&e), velocity, accelerations, force))
        };
        let (z, report, e, velocity, [acceleration, after], force) = match solved {
            Ok(solved) => solved,
            Err(cause) => return Err(self.failed(cause)),
        };
        let Some(next) = self.arriving(&e) else {
            return Err(self.not_finite(&z));
        };
        let index = self.run_state.index();
        // the following steps depend on the new values alone
        predictor.push(&z);
        self.run_state.predictor = predictor;
        self.run_state.since = index.saturating_sub(1);
        let report = StepReport {
            stop: Stop::Update,
            guess: Guess::Given,
            ..report
        };
        let pieces = self.contacts.as_ref().map(|contacts| contacts.pieces.clone());
        let span = StepConditions {
            before: pieces.as_deref().unwrap_or(&[]),
            after: &[],
            inputs: Some(&before),
        };
        self.look_for_jumps(span, &e);
        self.commit(next, &e, report);
        self.changed = Some(Box::new(NodeAtChange {
            index,
            velocity,
            acceleration,
            departing: self.departing(after),
            force,
            before,
        }));
        Ok(report)
    }

    /// Velocity and acceleration with which the motion goes on from the middle node of the last step, by the leg
    /// after it.
    pub(super) fn departing(&self, a: Vector) -> [Vector; 2] {
        let h = self.run_state.h;
        let v = Vector::of(self.next_leg().d).zip(&a, |d, a| d / h - 0.5 * h * a);
        [v, a]
    }
}

/// A step between two values of the inputs.
struct StepAcrossChange<'s> {
    /// The declaration with the values up to the node, and with those from there on.
    sides: [Declaration<'s>; 2],
    /// The number of kinematic constraints.
    kinematic: usize,
    /// The number of constraints of lower order, which are imposed on the leg after the node.
    lower: usize,
    /// The length of the step.
    h: f64,
    /// The first two nodes.
    leg: AnyLeg<'s, f64>,
    /// The momentum `D₂L_d + f⁺_d` of the arriving leg: that with the new values minus that with the old
    /// ones.
    jump: Vec<f64>,
    /// The size of that momentum: a multiplier small beside it is rounding.
    momentum: Vec<f64>,
}

/// The kinematic rows.
enum KinematicRows<'k> {
    /// The declared kinematic rows, with the known values of this side.
    Side(usize),
    /// Rows that hold the second difference at a mean: derivatives of the rows, and the mean.
    Mean(&'k [Vec<f64>], &'k [f64]),
}

impl<'s> StepAcrossChange<'s> {
    fn new(
        sides: [Declaration<'s>; 2],
        kinematic: usize,
        [holonomic, nonholonomic]: [usize; 2],
        h: f64,
        leg: AnyLeg<'s, f64>,
    ) -> Self {
        let [mut old, new] = [&sides[0], &sides[1]].map(|side| side.arriving(h, leg));
        if nonholonomic > 0 {
            old = arrived(&sides, h, leg, old);
        }
        Self {
            jump: new.iter().zip(&old).map(|(new, old)| new - old).collect(),
            momentum: new
                .iter()
                .zip(&old)
                .map(|(new, old)| new.abs().max(old.abs()))
                .collect(),
            sides,
            kinematic,
            lower: holonomic + nonholonomic,
            h,
            leg,
        }
    }

    /// The second difference at the change, from the second differences with each of the values on both
    /// sides.
    fn solve(&self, guesses: [&[f64]; 2]) -> Result<Vec<f64>, NewtonFailure> {
        let n = guesses[1].len();
        let sides = [0, 1].map(|side| self.multipliers(side, guesses[side]));
        let mut x: Vec<f64> = guesses[1].to_vec();
        x.extend((0..sides[1].len()).map(|j| 0.5 * (sides[0][j] + sides[1][j])));
        let mut mean = guesses[1].to_vec();
        let mut slopes = Vec::new();
        if self.kinematic > 0 {
            // the mean of the two accelerations: for rows that are not affine it differs from that of the
            // mean rows
            let mut found = [Vec::new(), Vec::new()];
            for side in [0, 1] {
                let mut start = guesses[side].to_vec();
                start.extend(&sides[side]);
                found[side] = self.newton(start, &KinematicRows::Side(side))?;
                found[side].truncate(n);
            }
            mean = (0..n).map(|i| 0.5 * (found[0][i] + found[1][i])).collect();
            slopes = self.slopes(&found);
            x[..n].copy_from_slice(&mean);
        }
        let mut e = self.newton(x, &KinematicRows::Mean(&slopes, &mean))?;
        e.truncate(n);
        Ok(e)
    }

    /// The unknown multipliers, with the values of one side.
    fn multipliers(&self, side: usize, e: &[f64]) -> Vec<f64> {
        multipliers::of_step(&self.sides[side], self.h, self.leg, e)
    }

    /// The kinematic rows with the values of one side, without their declared factors.
    fn kinematic_rows(&self, side: usize, e: &[Tangent]) -> Vec<Tangent> {
        let (declaration, h, leg) = (&self.sides[side], Tangent::splat(self.h), self.fixed_leg());
        let rows = declaration.declared(h, leg.any(), e, &[]);
        let factors = declaration.factors(h, leg.any(), e);
        let rows = rows.into_iter().skip(self.lower).zip(factors);
        rows.map(|(row, factor)| row / factor).collect()
    }

    /// The mean of the derivatives of the kinematic rows on both sides.
    fn slopes(&self, at: &[Vec<f64>; 2]) -> Vec<Vec<f64>> {
        let n = at[0].len();
        let mut slopes = vec![vec![0.0; n]; self.kinematic];
        for (side, e) in at.iter().enumerate() {
            for j in 0..n {
                for (slopes, row) in slopes.iter_mut().zip(self.kinematic_rows(side, &moved(e, j))) {
                    slopes[j] += 0.5 * row.derivative();
                }
            }
        }
        slopes
    }

    /// The leg as constants.
    fn fixed_leg(&self) -> OwnedLeg<Tangent> {
        self.leg.map(Tangent::splat)
    }

    /// All rows at the second difference and the multipliers `x`.
    fn rows(&self, x: &[Tangent], kinematic: &KinematicRows<'_>) -> Vec<Tangent> {
        let (h, leg) = (Tangent::splat(self.h), self.fixed_leg());
        let (e, multipliers) = x.split_at(self.leg.q.len());
        let mut rows = self.sides[1].declared(h, leg.any(), e, multipliers);
        rows.truncate(self.lower);
        match kinematic {
            KinematicRows::Side(side) => rows.extend(self.kinematic_rows(*side, e)),
            KinematicRows::Mean(slopes, mean) => rows.extend(slopes.iter().map(|slopes| {
                let terms = slopes.iter().zip(e).zip(*mean);
                terms.fold(Tangent::splat(0.0), |sum, ((&slope, &e), &mean)| {
                    sum + Tangent::splat(slope) * (e - Tangent::splat(mean))
                })
            })),
        }
        // a mass that changes suddenly gives an impulse, which the mean of the two accelerations does not
        // contain
        let (of, jumps) = match kinematic {
            KinematicRows::Side(side) => (*side, 0.0),
            KinematicRows::Mean(..) => (1, 1.0),
        };
        let mut force = self.sides[of].force(h, leg.any(), e);
        for (force, jump) in force.iter_mut().zip(&self.jump) {
            *force = *force + Tangent::splat(jumps * jump);
        }
        let sides = match kinematic {
            KinematicRows::Side(side) => [*side; 2],
            // rows of positions and velocities are those of the leg after the node, and so are their forces
            KinematicRows::Mean(..) if self.lower > 0 => [1; 2],
            KinematicRows::Mean(..) => [0, 1],
        };
        let half = Tangent::splat(0.5);
        let [old, new] = sides.map(|side| works(&self.sides[side], h, leg.any(), e, &force, multipliers));
        rows.extend(old.into_iter().zip(new).map(|(old, new)| half * (old + new)));
        rows
    }

    /// Newton's iteration, with scaled rows and unknowns.
    fn newton(&self, mut x: Vec<f64>, kinematic: &KinematicRows<'_>) -> Result<Vec<f64>, NewtonFailure> {
        let n = self.leg.q.len();
        let longest = self.leg.d.iter().fold(0.0_f64, |longest, d| longest.max(d.abs()));
        let forms = self.sides[1].forms(self.h, self.leg, x.get(..n).unwrap_or(&[]));
        let least: Vec<f64> = (0..x.len())
            .map(|i| match i.checked_sub(n).and_then(|j| forms.get(j)) {
                None => LEAST * longest,
                Some(form) => {
                    let parts = self.momentum.iter().zip(form).filter(|(_, form)| **form != 0.0);
                    parts.fold(0.0, |most, (momentum, form)| {
                        f64::max(most, momentum / form.abs())
                    })
                }
            })
            .collect();
        let (mut updates, mut residual) = (Vec::new(), Vec::new());
        let mut reason = StepFailure::NotConverged;
        for _ in 0..MAX_ITERATIONS {
            let columns = (0..x.len()).map(|j| self.rows(&moved(&x, j), kinematic));
            let columns: Vec<Vec<Tangent>> = columns.collect();
            residual = columns
                .first()
                .map_or_else(Vec::new, |rows| rows.iter().map(|row| row.value()).collect());
            let Some(update) = update(&columns, &residual) else {
                reason = StepFailure::NotFinite;
                break;
            };
            let mut largest = 0.0_f64;
            for (i, (x, update)) in x.iter_mut().zip(&update).enumerate() {
                *x -= update;
                let size = x.abs().max(least[i]);
                largest = largest.max(if *update == 0.0 { 0.0 } else { update.abs() / size });
            }
            let last = updates.last().copied().unwrap_or(f64::INFINITY);
            updates.push(largest);
            if largest <= LAST || largest <= ROUNDING && largest >= 0.5 * last {
                return Ok(x);
            }
        }
        Err(NewtonFailure {
            reason,
            unknowns: x,
            residual,
            updates,
            other: Vec::new(),
        })
    }
}

/// The momentum of the arriving leg, `D₂L_d + f⁺_d`. If velocity constraints change, their old forces act up
/// to the node; the new ones begin there, with an impulse.
fn arrived(sides: &[Declaration<'_>; 2], h: f64, leg: AnyLeg<'_, f64>, old: Vec<f64>) -> Vec<f64> {
    let node = (leg.t, leg.q);
    let momentum = map(&old, |momentum| h * momentum);
    let guess = map(leg.d, |d| d / h);
    let on = |side: &Declaration<'_>, momentum: &[f64]| {
        start::arriving_on_constraints(side, node, momentum, &guess)
    };
    let both = on(&sides[0], &momentum).and_then(|kept| {
        let after = on(&sides[1], &kept)?;
        Ok((kept, after))
    });
    match both {
        // equal constraints on both sides need no separation of their forces
        Ok((kept, after)) if changed(&kept, &after) => map(&kept, |momentum| momentum / h),
        _ => old,
    }
}

/// Whether two momenta differ by more than rounding.
fn changed(x: &[f64], y: &[f64]) -> bool {
    let size = x.iter().fold(0.0_f64, |size, x| size.max(x.abs()));
    x.iter().zip(y).any(|(x, y)| (x - y).abs() > ROUNDING * size)
}

/// The works of a force along the fields or, without fields, the force minus that of the multipliers.
pub(crate) fn works(
    declaration: &Declaration<'_>,
    h: Tangent,
    leg: AnyLeg<'_, Tangent>,
    e: &[Tangent],
    force: &[Tangent],
    multipliers: &[Tangent],
) -> Vec<Tangent> {
    let zero = Tangent::splat(0.0);
    if declaration.has_multipliers() {
        let forms = declaration.forms(h, leg, e);
        return (0..force.len())
            .map(|i| {
                let terms = forms.iter().zip(multipliers);
                terms.fold(force[i], |left, (form, &multiplier)| left - multiplier * form[i])
            })
            .collect();
    }
    let fields = declaration.fields(h, leg, e);
    let work = |field: &Vec<Tangent>| {
        let terms = field.iter().zip(force);
        terms.fold(zero, |sum, (&field, &force)| sum + field * force)
    };
    fields.iter().map(work).collect()
}

/// Newton's update from the columns of the Jacobian, to be subtracted; `None` if it is not finite.
fn update(columns: &[Vec<Tangent>], residual: &[f64]) -> Option<Vec<f64>> {
    let size = columns.len();
    if residual.len() != size {
        return None;
    }
    let matrix = Matrix::from_fn(size, size, |i, j| columns[j][i].derivative());
    let mut right = residual.to_vec();
    let (singular, lengths) = matrix.equilibrated(&mut right)?;
    let mut update = singular.solve(&right, f64::EPSILON);
    for (update, length) in update.iter_mut().zip(&lengths) {
        *update /= length;
    }
    update.iter().all(|x| x.is_finite()).then_some(update)
}
