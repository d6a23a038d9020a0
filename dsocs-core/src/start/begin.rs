//! The first leg of a run, or its position and velocity, from a start.

use super::consistency;
use super::determined;
use super::elsewhere;
use super::half_leg;
use super::rest;
use super::third::{self, ThirdOrderDatum};
use super::underflow;
use crate::error::SetupError;
use crate::number::point::{AnyPoint, map, moved};
use crate::number::scalar::Scalar as _;
use crate::number::tangent::Tangent;
use crate::regularity::deficiency;
use crate::regularity::dependence;
use crate::regularity::multipliers::of_motion;
use crate::regularity::resting;
use crate::regularity::undefined::{self, Undefined};
use crate::solve::failure::{NewtonFailure, StepFailure};
use crate::solve::newton::{self, Equations, Linearized};
use crate::solve::rotation;
use crate::solve::sum::Sum;
use crate::solve::{Square, Vector};
use crate::tape::Shape;
use crate::tape::declaration::Declaration;

/// Largest number of iterations for the acceleration at the start.
const MAX_ITERATIONS: u32 = 50;

/// The acceleration at the beginning of a motion.
#[derive(Clone, Debug)]
pub(crate) enum InitialAcceleration {
    /// Given by the user.
    Given(Vector),
    /// Computed at the start; a given second node overrides it.
    Computed(Vector),
}

/// Accelerations and multipliers.
pub(crate) type ContinuousSolution = (Vector, Vector);

/// A start with any number of coordinates; see [`Start`](crate::Start).
#[derive(Clone, Debug)]
pub(crate) struct StartData {
    /// The first node.
    pub q0: Vector,
    /// The rule for the second node.
    pub rule: Rule,
    /// The time of the first node.
    pub t0: f64,
    /// Whether it is projected onto the constraints.
    pub projected: bool,
    /// The acceleration near which that at the start is searched.
    pub near: Option<Vector>,
}

/// The rule that leads from the first node to the second.
#[derive(Clone, Debug)]
pub(crate) enum Rule {
    /// `q1 = q0 + h v0`.
    Paper { v0: Vector },
    /// `q1 = q0 + h v0 + h²/2 a0`.
    SecondOrder { v0: Vector },
    /// The given second node.
    Nodes { q1: Vector },
    /// The given second and third nodes, for constraints of third order.
    ThreeNodes { q1: Vector, q2: Vector },
    /// `q1 = q0 + h v0 + h²/2 a0 + h³/6 j0`, and a third node, for constraints of third order, which leave
    /// the acceleration free.
    ThirdOrder { v0: Vector, datum: ThirdOrderDatum },
    /// The increment of the continuous motion over the step `h` from the time `t0`, and its initial velocity
    /// and acceleration.
    Exact {
        v0: Vector,
        a0: Vector,
        d: Sum,
        h: f64,
        t0: f64,
    },
}

/// Checks that a vector of the start is finite.
pub(super) fn check_vector(
    declaration: &Declaration<'_>,
    vector: &'static str,
    components: &[f64],
) -> Result<(), SetupError> {
    let mut named = declaration.coordinates().iter().zip(components);
    match named.find(|(_, value)| !value.is_finite()) {
        Some((coordinate, &value)) => Err(SetupError::Start {
            vector,
            coordinate: coordinate.name.clone(),
            value,
        }),
        None => Ok(()),
    }
}

impl StartData {
    /// The first leg for the step `h`.
    ///
    /// The second node is moved onto the constraints of nodes and of pairs of nodes, which no rule takes into
    /// account, unless it is given.
    pub fn begin(&self, declaration: &Declaration<'_>, h: f64) -> Result<ComputedStart, SetupError> {
        let Self { q0, rule, t0, .. } = self.clone();
        if !t0.is_finite() {
            return Err(SetupError::StartTime { t0 });
        }
        check_vector(declaration, "q0", &q0)?;
        self.check_order(declaration)?;
        let q0 = of_norm_one(declaration, q0)?;
        let rotations = &declaration.shape().rotations;
        let mut e = None;
        let (q0, v0, a0, d) = match rule {
            Rule::ThirdOrder { v0, datum } => {
                check_vector(declaration, "v0", &v0)?;
                let (q0, v0) = self.consistent(declaration, q0, v0)?;
                let triple = third::begin(declaration, (t0, h), (&q0, &v0), datum, self.projected)?;
                e = Some(triple.e);
                (q0, v0, Some(triple.a0), triple.d)
            }
            Rule::Paper { v0 } => {
                check_vector(declaration, "v0", &v0)?;
                let (q0, v0) = self.consistent(declaration, q0, v0)?;
                let d = Sum::exact(v0.map(|v| h * v));
                check_rest(declaration, (t0, h), &q0, &d)?;
                let d = onto_pair(declaration, (t0, h), &q0, &v0, &d)?;
                (q0, v0, None, d)
            }
            Rule::SecondOrder { v0 } => {
                check_vector(declaration, "v0", &v0)?;
                let (q0, v0) = self.consistent(declaration, q0, v0)?;
                let a0 = state_acceleration(declaration, (t0, &q0, &v0), self.near.as_deref())?;
                let mut d = Sum::exact(v0.map(|v| h * v));
                let mean = half_leg::mean_acceleration(declaration, h, (t0, &q0, &v0), &a0);
                d.add(&mean.as_ref().unwrap_or(&a0).map(|a| h * h / 2.0 * a));
                let d = onto_pair(declaration, (t0, h), &q0, &v0, &d)?;
                (q0, v0, Some(a0), d)
            }
            Rule::ThreeNodes { q1, q2 } => {
                check_vector(declaration, "q1", &q1)?;
                check_vector(declaration, "q2", &q2)?;
                let d = self.first_leg(declaration, h, [&q0, &q1])?;
                let second = Sum::difference(&q2, &q1).plus(&d.negated());
                let second_difference = second.hi.map(|e| e / (h * h));
                e = Some(second);
                (q0, d.hi.map(|d| d / h), Some(second_difference), d)
            }
            Rule::Nodes { q1 } => {
                check_vector(declaration, "q1", &q1)?;
                let q1 = of_norm_one(declaration, q1)?;
                let d = self.first_leg(declaration, h, [&q0, &q1])?;
                check_rest(declaration, (t0, h), &q0, &d)?;
                (q0, d.hi.map(|d| d / h), None, d)
            }
            Rule::Exact {
                v0,
                a0,
                d,
                h: own,
                t0: begun,
            } => {
                if own.to_bits() != h.to_bits() {
                    return Err(SetupError::StartStep { start: own, h });
                }
                if begun.to_bits() != t0.to_bits() && declaration.shape().depends_on_time {
                    return Err(SetupError::StartMoved { start: begun, t0 });
                }
                let (q0, v0) = self.consistent(declaration, q0, v0)?;
                let d = onto_pair(declaration, (t0, h), &q0, &v0, &d)?;
                (q0, v0, Some(a0), d)
            }
        };
        if let Some(&first) = rotations.iter().find(|&&first| v0[first] != 0.0) {
            let (rotation, value) = (rotation_name(declaration, first), v0[first]);
            return Err(SetupError::AngularVelocity { rotation, value });
        }
        if let Some((first, turn)) = rotation::turns_too_far(rotations, &d.hi) {
            let rotation = rotation_name(declaration, first);
            return Err(SetupError::Turn { rotation, turn, h });
        }
        let q = rotation::moved_sum(rotations, &Sum::exact(q0.clone()), &d);
        check_vector(declaration, "q1", &q.hi)?;
        underflow::check(declaration, (t0, &q0, &v0), Some(h))?;
        Ok(ComputedStart {
            q0,
            v0,
            a0,
            near: self.meant(),
            t0,
            q,
            d,
            e,
        })
    }

    /// Checks that the start gives an acceleration if constraints of third order leave it free, and only
    /// then.
    fn check_order(&self, declaration: &Declaration<'_>) -> Result<(), SetupError> {
        let says = matches!(self.rule, Rule::ThirdOrder { .. } | Rule::ThreeNodes { .. });
        match (says, !declaration.shape().is_of_third_order()) {
            (true, true) => Err(SetupError::DeterminedAcceleration),
            (false, false) => Err(SetupError::FreeAcceleration),
            _ => Ok(()),
        }
    }

    /// The increment to a given second node, which has to obey the constraints or is moved onto them.
    fn first_leg(
        &self,
        declaration: &Declaration<'_>,
        h: f64,
        [q0, q1]: [&Vector; 2],
    ) -> Result<Sum, SetupError> {
        let mut d = Sum::difference(q1, q0);
        let rotations = &declaration.shape().rotations;
        rotation::difference(rotations, [q0, q1], &mut d.hi);
        rotation::forget(rotations, &mut d.lo);
        if self.projected {
            let v0 = d.hi.map(|d| d / h);
            return onto_pair(declaration, (self.t0, h), q0, &v0, &d);
        }
        consistency::check_pair(declaration, (self.t0, h), q0, &d)?;
        Ok(d)
    }

    /// The start of methods that begin with a position and a velocity.
    pub fn phase(&self, declaration: &Declaration<'_>) -> Result<Phase, SetupError> {
        let Self { q0, rule, t0, .. } = self.clone();
        if !t0.is_finite() {
            return Err(SetupError::StartTime { t0 });
        }
        check_vector(declaration, "q0", &q0)?;
        let q0 = of_norm_one(declaration, q0)?;
        let v0 = match rule {
            Rule::Paper { v0 } | Rule::SecondOrder { v0 } | Rule::Exact { v0, .. } => v0,
            Rule::ThirdOrder { .. } | Rule::ThreeNodes { .. } => {
                return Err(SetupError::DeterminedAcceleration);
            }
            Rule::Nodes { .. } => return Err(SetupError::Velocity),
        };
        check_vector(declaration, "v0", &v0)?;
        let (q0, v0) = self.consistent(declaration, q0, v0)?;
        let near = self.meant();
        Ok(Phase { t0, q0, v0, near })
    }

    /// The kind of the start.
    pub fn order(&self) -> StartOrder {
        match &self.rule {
            Rule::Paper { .. } => StartOrder::First,
            Rule::SecondOrder { .. } => StartOrder::Second,
            Rule::Nodes { .. } | Rule::ThreeNodes { .. } | Rule::ThirdOrder { .. } => StartOrder::Nodes,
            Rule::Exact { .. } => StartOrder::Exact,
        }
    }

    /// Position and velocity as given, if they are moved onto the constraints.
    pub fn moved_from(&self) -> Option<[Vec<f64>; 2]> {
        match &self.rule {
            Rule::Paper { v0 } | Rule::SecondOrder { v0 } if self.projected => {
                Some([self.q0.to_vec(), v0.to_vec()])
            }
            _ => None,
        }
    }

    /// The acceleration near which that at the start is searched, if it was given.
    fn meant(&self) -> Option<Vector> {
        match &self.rule {
            Rule::Exact { a0, .. } => Some(a0.clone()),
            _ => self.near.clone(),
        }
    }

    /// A position and a velocity that obey the constraints of lower order, checked or projected.
    fn consistent(
        &self,
        declaration: &Declaration<'_>,
        q: Vector,
        v: Vector,
    ) -> Result<(Vector, Vector), SetupError> {
        if self.projected {
            let (q, v) = consistency::project(declaration, self.t0, &q, &v)?;
            return Ok((Vector::of(&q), Vector::of(&v)));
        }
        consistency::check(declaration, self.t0, &q, &v)?;
        Ok((q, v))
    }
}

/// A position whose quaternions are normalised.
fn of_norm_one(declaration: &Declaration<'_>, mut q: Vector) -> Result<Vector, SetupError> {
    match rotation::normalize(&declaration.shape().rotations, &mut q) {
        Ok(()) => Ok(q),
        Err((first, norm)) => {
            let rotation = rotation_name(declaration, first);
            Err(SetupError::Quaternion { rotation, norm })
        }
    }
}

/// The name of a rotation, given the place of its quaternion's first component.
fn rotation_name(declaration: &Declaration<'_>, first: usize) -> String {
    name_of_rotation(declaration.shape(), first)
}

/// [`rotation_name`] from a shape.
pub(crate) fn name_of_rotation(shape: &Shape, first: usize) -> String {
    let name = shape.coordinates.get(first);
    let name = name.map_or("", |coordinate| &coordinate.name);
    name.strip_suffix("_w").unwrap_or(name).to_owned()
}

/// Refuses two equal nodes if steps would stay there only because a constraint determines nothing at rest.
fn check_rest(declaration: &Declaration<'_>, at: (f64, f64), q0: &[f64], d: &Sum) -> Result<(), SetupError> {
    if d.hi.iter().any(|&d| d != 0.0) {
        return Ok(());
    }
    match rest::left_open(declaration, at, q0) {
        Some(deficiency) => Err(SetupError::Rest {
            deficiency: Box::new(deficiency),
        }),
        None => Ok(()),
    }
}

/// The increment to the second node, moved onto the constraints of nodes and of pairs.
pub(super) fn onto_pair(
    declaration: &Declaration<'_>,
    at: (f64, f64),
    q0: &[f64],
    v0: &[f64],
    d: &Sum,
) -> Result<Sum, SetupError> {
    consistency::onto_pair(declaration, at, q0, v0, d.clone())
}

/// The kinds of starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum StartOrder {
    /// Velocity times step leads to the second node.
    First,
    /// The acceleration is used, too.
    Second,
    /// The second node is given.
    Nodes,
    /// The second node is on the continuous motion.
    Exact,
}

/// The start of methods that begin with a position and a velocity.
#[derive(Clone, Debug)]
pub(crate) struct Phase {
    /// The time.
    pub t0: f64,
    /// The position.
    pub q0: Vector,
    /// The velocity.
    pub v0: Vector,
    /// The acceleration near which that at the start is searched.
    pub near: Option<Vector>,
}

/// The computed start of a run.
#[derive(Clone, Debug)]
pub(crate) struct ComputedStart {
    /// The first node.
    pub q0: Vector,
    /// The velocity there.
    pub v0: Vector,
    /// The acceleration there, if it was needed.
    pub a0: Option<Vector>,
    /// The acceleration that was given for the beginning.
    pub near: Option<Vector>,
    /// The time of the first node.
    pub t0: f64,
    /// The second node.
    pub q: Sum,
    /// The increment from the first to the second.
    pub d: Sum,
    /// The second difference of the first three nodes, in third order.
    pub e: Option<Sum>,
}

impl ComputedStart {
    /// The acceleration for the first step.
    pub fn initial_acceleration(&self) -> Option<InitialAcceleration> {
        match (self.near.clone(), self.a0.clone()) {
            // the solution near the given acceleration is better than the given one
            (Some(near), a0) => Some(InitialAcceleration::Given(a0.unwrap_or(near))),
            (None, a0) => a0.map(InitialAcceleration::Computed),
        }
    }
}

/// Checks that the parameters are finite and not subnormal.
pub(crate) fn check_parameters(declaration: &Declaration<'_>) -> Result<(), SetupError> {
    let mut parameters = declaration.parameters().iter().enumerate();
    let wrong = parameters.find_map(|(place, parameter)| {
        let (name, value) = (parameter.name.clone(), declaration.value(place));
        if value.is_subnormal() {
            return Some(SetupError::SubnormalParameter { name, value });
        }
        (!value.is_finite()).then_some(SetupError::Parameter { name, value })
    });
    wrong.map_or(Ok(()), Err)
}

/// The acceleration of the continuous system at a start, which has to be finite and determined by the
/// equations. If they are singular to the rounding of the start, as with `theta = pi / 2` and a factor
/// `cos(theta)`, a solution is only rounding.
pub(crate) fn state_acceleration(
    declaration: &Declaration<'_>,
    (t0, q0, v0): (f64, &[f64], &[f64]),
    near: Option<&[f64]>,
) -> Result<Vector, SetupError> {
    let (a, _) = state(declaration, (t0, q0, v0), near)?;
    determined::check(declaration, (t0, q0, v0), &a)?;
    Ok(a)
}

/// The acceleration of the continuous system at a start, and the unknown multipliers.
pub(crate) fn state(
    declaration: &Declaration<'_>,
    (t0, q0, v0): (f64, &[f64], &[f64]),
    near: Option<&[f64]>,
) -> Result<ContinuousSolution, SetupError> {
    check_vector(declaration, "q0", q0)?;
    check_vector(declaration, "v0", v0)?;
    if let Some(a0) = near {
        check_vector(declaration, "a0", a0)?;
    }
    match acceleration(declaration, (t0, q0, v0), near) {
        Ok(found) => Ok(found),
        Err(cause) => Err(SetupError::Acceleration {
            at_any_velocity: fails_in_motion(declaration, (t0, q0), cause.reason),
            q0: q0.to_vec(),
            v0: v0.to_vec(),
            deficiency: deficiency::of_start(declaration, (t0, q0, v0), near, &cause)
                .or_else(|| dependence::to_rounding(declaration, (t0, q0, v0), near))
                .map(Box::new),
            undefined: undefined(declaration, (t0, q0, v0), near, &cause).map(Box::new),
            cause: Box::new(cause),
        }),
    }
}

/// The expression without a value in the equations for the acceleration, if that is why they have no
/// solution.
#[cold]
fn undefined(
    declaration: &Declaration<'_>,
    (t, q, v): (f64, &[f64], &[f64]),
    near: Option<&[f64]>,
    cause: &NewtonFailure,
) -> Option<Undefined> {
    let rest = Vector::zero(q.len());
    let a = near.unwrap_or(&rest);
    (cause.reason == StepFailure::NotFinite)
        .then(|| undefined::of_point(declaration, AnyPoint { t, q, v, a }))
        .flatten()
}

/// Whether the equations at a position fail for the same reason with every velocity, judged by velocities of different sizes along no axis.
fn fails_in_motion(declaration: &Declaration<'_>, (t, q): (f64, &[f64]), reason: StepFailure) -> bool {
    [1.0, -1e-3, 1e3].into_iter().all(|size| {
        let v = Vector::from_fn(q.len(), |i| size / (i as f64 + 1.3));
        let found = acceleration(declaration, (t, q, &v), None);
        found.is_err_and(|failure| failure.reason == reason)
    })
}

/// The acceleration and the multipliers of the continuous system at `(t, q, v)`, searched near an
/// acceleration or from zero.
pub(crate) fn acceleration(
    declaration: &Declaration<'_>,
    (t, q, v): (f64, &[f64], &[f64]),
    near: Option<&[f64]>,
) -> Result<ContinuousSolution, NewtonFailure> {
    let shape = declaration.shape();
    let split = |x: &[f64]| {
        let a = Vector::from_fn(q.len(), |i| x.get(i).copied().unwrap_or(f64::NAN));
        (a, Vector::of(of_motion(q.len(), x)))
    };
    if shape.jumps
        && declaration.sides() > 0
        && let Some(found) = resting::of_motion(declaration, (t, q, v), shape.multipliers(), near)
    {
        return Ok(split(&found.x));
    }
    let equations = ContinuousEquations { declaration, t, q, v };
    let zero = Vector::zero(shape.motion);
    let guess = Vector::resized(near.unwrap_or(&[]), shape.motion);
    let solve = |guess: &Vector| {
        let root = newton::solve(&equations, guess, &zero, MAX_ITERATIONS, &mut ());
        root.ok().map(|root| root.z)
    };
    if let Some(z) = solve(&guess) {
        return Ok(split(&z));
    }
    let failure = newton::explain(&equations, &guess, &zero, MAX_ITERATIONS);
    let elsewhere = if near.is_none() && !failure.is_at_multiple_root() {
        elsewhere::only(q.len(), shape.motion, &solve)
    } else {
        None
    };
    elsewhere.map_or(Err(failure), |z| Ok(split(&z)))
}

/// The continuous system as equations for the acceleration and the multipliers.
struct ContinuousEquations<'a> {
    /// The declaration.
    declaration: &'a Declaration<'a>,
    /// The time.
    t: f64,
    /// The position.
    q: &'a [f64],
    /// The velocity.
    v: &'a [f64],
}

impl ContinuousEquations<'_> {
    /// The point with the acceleration from the unknowns, and the multipliers.
    fn at<'z>(&'z self, z: &'z [f64]) -> (AnyPoint<'z, f64>, &'z [f64]) {
        let Self { t, q, v, .. } = *self;
        let a = z.get(..q.len()).unwrap_or(z);
        (AnyPoint { t, q, v, a }, of_motion(q.len(), z))
    }
}

impl Equations for ContinuousEquations<'_> {
    fn linearize(&self, z: &[f64]) -> Linearized {
        let (point, multipliers) = self.at(z);
        let (mut rows, mut jacobian) = (Vector::nan(z.len()), Square::zero(z.len()));
        self.declaration
            .linearize_continuous(point, multipliers, &mut rows, jacobian.entries_mut());
        Linearized { rows, jacobian }
    }

    fn rounding(&self, z: &[f64]) -> Vector {
        let (point, multipliers) = self.at(z);
        let mut bounds = Vector::zero(z.len());
        self.declaration
            .continuous_bounds(point, multipliers, &mut bounds);
        bounds
    }
}

/// The momentum of a leg at its second node, including the forces of velocity constraints up to there:
/// `arriving` moved along these forces until the velocity at the node obeys the constraints.
pub(crate) fn arriving_on_constraints(
    declaration: &Declaration<'_>,
    (t, q): (f64, &[f64]),
    arriving: &[f64],
    guess: &[f64],
) -> Result<Vec<f64>, SetupError> {
    let velocity = velocity_of(declaration, (t, q), arriving, guess);
    let (_, velocity) = consistency::project(declaration, t, q, &velocity)?;
    Ok(momentum(declaration, (t, q, &velocity)))
}

/// The momentum `∂L/∂v`.
pub(crate) fn momentum(declaration: &Declaration<'_>, (t, q, v): (f64, &[f64], &[f64])) -> Vec<f64> {
    let q = map(q, Tangent::splat);
    let derivative = |j| {
        declaration
            .lagrangian(Tangent::splat(t), &q, &moved(v, j))
            .derivative()
    };
    (0..v.len()).map(derivative).collect()
}

/// The velocity with a given momentum, by iteration from a guess.
pub(crate) fn velocity_of(
    declaration: &Declaration<'_>,
    (t, q): (f64, &[f64]),
    wanted: &[f64],
    guess: &[f64],
) -> Vec<f64> {
    let mut velocity = guess.to_vec();
    for _ in 0..MAX_ITERATIONS {
        let found = momentum(declaration, (t, q, &velocity));
        let missing: Vec<f64> = wanted
            .iter()
            .zip(&found)
            .map(|(wanted, found)| wanted - found)
            .collect();
        if missing.iter().all(|missing| *missing == 0.0) {
            break;
        }
        let inverse = consistency::inverse_mass(declaration, t, q, &velocity);
        let update = inverse.times_vector(&missing);
        let (mut step, mut size) = (0.0_f64, 0.0_f64);
        for (velocity, update) in velocity.iter_mut().zip(&update) {
            *velocity += update;
            (step, size) = (step.max(update.abs()), size.max(velocity.abs()));
        }
        if step <= 4.0 * f64::EPSILON * size {
            break;
        }
    }
    velocity
}
