//! What a run begins with.

mod consistency;
mod rest;
pub(crate) mod third;

use core::marker::PhantomData;

use crate::any::{Accelerated, AnyPoint, AnySystem, map, moved, sized};
use crate::array;
use crate::compensated::{Compensated, Sum};
use crate::declaration::Declaration;
use crate::deficiency;
use crate::dense::Matrix;
use crate::error::{NewtonFailure, SetupError, StepFailure};
use crate::multipliers::of_motion;
use crate::run::{RunError, Stepper as _};
use crate::scalar::Scalar as _;
use crate::step::Begins;
use crate::step::newton::{self, Equations};
use crate::step::unknown::{Linearization, Unknown};
use crate::sticking;
use crate::system::{Point, System};
use crate::tangent::Tangent;
use crate::taylor::{TaylorFlow, Tolerance};
use crate::undefined::{self, Undefined};
use third::Free;

/// How often the acceleration at the start is improved before its solution is given up.
const MAX_ITERATIONS: u32 = 50;

/// The start of a run, for every method: a position and a velocity, or the first two nodes.
///
/// A [`crate::Flow`] begins with two nodes `q0` and `q1`, and the start says how the second node is found. The other methods use only the
/// position and the velocity. They cannot use a start of two nodes, because it gives no velocity.
///
/// Positions are in the units of the coordinates, velocities and accelerations in these units per unit of time and its square.
///
/// ```
/// use dsocs_core::Start;
///
/// let start = Start::second_order([0.0, 0.0], [1.0, 1.0]).at(2.5);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[must_use]
pub struct Start<const N: usize> {
    /// The first node.
    q0: [f64; N],
    /// What leads to the second.
    rule: Rule<N>,
    /// The time of the first node.
    t0: f64,
    /// Whether it is projected onto the constraints.
    projected: bool,
    /// Where the acceleration is looked for.
    near: Option<[f64; N]>,
}

/// What leads from the first node to the second.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Rule<const N: usize> {
    /// `q1 = q0 + h v0`.
    Paper { v0: [f64; N] },
    /// `q1 = q0 + h v0 + h²/2 a0`.
    SecondOrder { v0: [f64; N] },
    /// The second node itself.
    Nodes { q1: [f64; N] },
    /// The second and the third node themselves, where constraints are of third order.
    ThreeNodes { q1: [f64; N], q2: [f64; N] },
    /// `q1 = q0 + h v0 + h²/2 a0 + h³/6 j0`, and a third node, where constraints of third order leave the acceleration free.
    ThirdOrder { v0: [f64; N], free: Free<N> },
    /// The increment of the continuous motion over the step `h` from the time `t0`, and its first velocity and acceleration.
    Exact {
        v0: [f64; N],
        a0: [f64; N],
        d: Compensated<N>,
        h: f64,
        t0: f64,
    },
}

/// The tolerance of [`Start::exact`]: rounding is what is left.
const EXACT: f64 = 1e-17;

impl<const N: usize> Start<N> {
    /// The paper's start `q1 = q0 + h v0`, whose error is of first order in `h`.
    pub const fn paper(q0: [f64; N], v0: [f64; N]) -> Self {
        Self {
            q0,
            rule: Rule::Paper { v0 },
            t0: 0.0,
            projected: false,
            near: None,
        }
    }

    /// `q1 = q0 + h v0 + h²/2 a0` with the acceleration `a0` of the continuous system at `(q0, v0)`: the start that
    /// keeps the scheme's second order. If there are holonomic or nonholonomic constraints, `q1` is then moved onto them by the
    /// smallest possible change. This does not change the order.
    pub const fn second_order(q0: [f64; N], v0: [f64; N]) -> Self {
        Self {
            q0,
            rule: Rule::SecondOrder { v0 },
            t0: 0.0,
            projected: false,
            near: None,
        }
    }

    /// `q1 = q(t0 + h)`, where `q` is the continuous motion from the position and the velocity of this start. It is computed by its Taylor
    /// series, so the start adds no error to the discrete motion. The step of the run has to be `h`. If the system depends on time, call
    /// [`Start::at`] before this function.
    ///
    /// ```
    /// # use dsocs_core::prelude::*;
    /// # #[dsocs { coordinates(x); lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2; }]
    /// # struct Oscillator {}
    /// let start = Start::second_order([1.0], [0.0]).exact(&Oscillator {}, 0.1)?;
    /// assert!((Flow::new(&Oscillator {}, 0.1, start)?.position()[0] - 0.1_f64.cos()).abs() < 1e-15);
    /// # Ok::<(), RunError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`RunError`] if the start gives no velocity, or if the motion does not get as far as `h`.
    pub fn exact<S: System<N>>(self, system: &S, h: f64) -> Result<Self, RunError> {
        let Phase { t0, q0, v0, .. } = self.phase(system)?;
        // where no clock is asked, the end of the step is known to more digits from 0
        let begin = if S::DEPENDS_ON_TIME { t0 } else { 0.0 };
        let mut flow = TaylorFlow::new(system, self.at(begin), Tolerance::relative(EXACT))?;
        let a0 = *flow.acceleration();
        if h < 0.0 {
            flow.reverse()?;
        }
        flow.to(begin + h)?;
        let d = flow.exact_position().plus(&Compensated::exact(q0).negated());
        Ok(Self {
            q0,
            rule: Rule::Exact { v0, a0, d, h, t0 },
            projected: false,
            near: None,
            ..self
        })
    }

    /// The start of a system with constraints of third order. The equations leave the initial acceleration free, and `a0` gives it. The
    /// first three nodes are accurate enough to keep the scheme's second order.
    ///
    /// The acceleration has to obey the other equations: the constraints of lower order, differentiated in time, and the condition that
    /// the constraint force does no work on virtual displacements. [`Start::projected`] takes the nearest acceleration that obeys them.
    ///
    /// ```
    /// # use dsocs_core::prelude::*;
    /// /// A trolley that is moved with a constant jerk.
    /// #[dsocs {
    ///     coordinates(x);
    ///     lagrangian = dot(x).powi(2) / 2;
    ///     kinematic = dddot(x) - jerk;
    ///     constraint_forces = [1];
    /// }]
    /// struct Trolley {
    ///     jerk: f64,
    /// }
    /// let trolley = Trolley { jerk: 6.0 };
    /// let start = Start::third_order([0.0], [1.0], [2.0]);
    /// let end = Flow::new(&trolley, 0.125, start)?.until(1.0)?.nodes[8].q[0];
    /// // t + t² + t³ at t = 1
    /// assert!((end - 3.0).abs() < 1e-13);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub const fn third_order(q0: [f64; N], v0: [f64; N], a0: [f64; N]) -> Self {
        Self {
            q0,
            rule: Rule::ThirdOrder {
                v0,
                free: Free::Acceleration(a0),
            },
            t0: 0.0,
            projected: false,
            near: None,
        }
    }

    /// Like [`Start::third_order`], with the generalized constraint force at the start in place of the acceleration. The force is in
    /// units of `L` per unit of the coordinate.
    pub const fn third_order_by_force(q0: [f64; N], v0: [f64; N], force: [f64; N]) -> Self {
        Self {
            q0,
            rule: Rule::ThirdOrder {
                v0,
                free: Free::Force(force),
            },
            t0: 0.0,
            projected: false,
            near: None,
        }
    }

    /// The first two nodes, taken as they are.
    pub const fn nodes(q0: [f64; N], q1: [f64; N]) -> Self {
        Self {
            q0,
            rule: Rule::Nodes { q1 },
            t0: 0.0,
            projected: false,
            near: None,
        }
    }

    /// The first three nodes, taken as they are, for systems with constraints of third order. Use it to continue a known motion.
    pub const fn three_nodes(q0: [f64; N], q1: [f64; N], q2: [f64; N]) -> Self {
        Self {
            q0,
            rule: Rule::ThreeNodes { q1, q2 },
            t0: 0.0,
            projected: false,
            near: None,
        }
    }

    /// The time of the first node.
    #[must_use]
    pub const fn time(&self) -> f64 {
        self.t0
    }

    /// Sets the time of the first node, which is 0 unless set.
    pub const fn at(mut self, t0: f64) -> Self {
        self.t0 = t0;
        self
    }

    /// Moves the start onto the holonomic and nonholonomic constraints. Position and velocity (or both nodes) are changed by the smallest
    /// amount in the norm of the mass matrix. Without this call, a start that violates these constraints is refused.
    pub const fn projected(mut self) -> Self {
        self.projected = true;
        self
    }

    /// Chooses the acceleration at the start near `a0`, if the equations allow several. For example, if only the square of a curvature is
    /// given, the path may turn to the left or to the right, and `a0` says which. Without this call the search begins at the acceleration
    /// zero, and the start is refused if there are several solutions and nothing decides between them.
    pub const fn near_acceleration(mut self, a0: [f64; N]) -> Self {
        self.near = Some(a0);
        self
    }

    /// Finds the first leg for the step `h`.
    ///
    /// The second node is moved onto the constraints of nodes and pairs of nodes, which no rule foresees, unless it is given.
    pub(crate) fn begin(&self, system: &dyn AnySystem<N>, h: f64) -> Result<Beginning<N>, SetupError> {
        let Self { q0, rule, t0, .. } = *self;
        if !t0.is_finite() {
            return Err(SetupError::StartTime { t0 });
        }
        check_vector(system, "q0", &q0)?;
        self.check_order(system)?;
        let mut e = None;
        let (q0, v0, a0, d) = match rule {
            Rule::ThirdOrder { v0, free } => {
                check_vector(system, "v0", &v0)?;
                let (q0, v0) = self.consistent(system, q0, v0)?;
                let third = system
                    .of_third_order()
                    .ok_or(SetupError::DeterminedAcceleration)?;
                let began = third.begin((t0, h), (&q0, &v0), free, self.projected)?;
                e = Some(began.e);
                (q0, v0, Some(began.a0), began.d)
            }
            Rule::Paper { v0 } => {
                check_vector(system, "v0", &v0)?;
                let (q0, v0) = self.consistent(system, q0, v0)?;
                let d = Compensated::exact(array::map(&v0, |v| h * v));
                check_rest(system, (t0, h), &q0, &d)?;
                (
                    q0,
                    v0,
                    None,
                    onto_pair(&system.declaration(), (t0, h), &q0, &v0, &d)?,
                )
            }
            Rule::SecondOrder { v0 } => {
                check_vector(system, "v0", &v0)?;
                let (q0, v0) = self.consistent(system, q0, v0)?;
                let a0 = state_acceleration(system, (t0, &q0, &v0), self.near.as_ref())?;
                let mut d = Compensated::exact(array::map(&v0, |v| h * v));
                d.add(&array::map(&a0, |a| h * h / 2.0 * a));
                (
                    q0,
                    v0,
                    Some(a0),
                    onto_pair(&system.declaration(), (t0, h), &q0, &v0, &d)?,
                )
            }
            Rule::ThreeNodes { q1, q2 } => {
                check_vector(system, "q1", &q1)?;
                check_vector(system, "q2", &q2)?;
                let d = self.first_leg(system, h, &q1)?;
                let second = Compensated::difference(&q2, &q1).plus(&d.negated());
                e = Some(second);
                (
                    q0,
                    array::map(&d.hi, |d| d / h),
                    Some(array::map(&second.hi, |e| e / (h * h))),
                    d,
                )
            }
            Rule::Nodes { q1 } => {
                check_vector(system, "q1", &q1)?;
                let d = self.first_leg(system, h, &q1)?;
                check_rest(system, (t0, h), &q0, &d)?;
                (q0, array::map(&d.hi, |d| d / h), None, d)
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
                if begun.to_bits() != t0.to_bits() && system.depends_on_time() {
                    return Err(SetupError::StartMoved { start: begun, t0 });
                }
                let (q0, v0) = self.consistent(system, q0, v0)?;
                (
                    q0,
                    v0,
                    Some(a0),
                    onto_pair(&system.declaration(), (t0, h), &q0, &v0, &d)?,
                )
            }
        };
        let q = Compensated::exact(q0).plus(&d);
        check_vector(system, "q1", &q.hi)?;
        Ok(Beginning {
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

    /// Checks that the start says an acceleration where constraints of third order leave it free, and there alone.
    fn check_order(&self, system: &dyn AnySystem<N>) -> Result<(), SetupError> {
        let says = matches!(self.rule, Rule::ThirdOrder { .. } | Rule::ThreeNodes { .. });
        match (says, system.third_order().is_empty()) {
            (true, true) => Err(SetupError::DeterminedAcceleration),
            (false, false) => Err(SetupError::FreeAcceleration),
            _ => Ok(()),
        }
    }

    /// The increment to a second node that is given, which has to obey the constraints or is moved onto them.
    fn first_leg(
        &self,
        system: &dyn AnySystem<N>,
        h: f64,
        q1: &[f64; N],
    ) -> Result<Compensated<N>, SetupError> {
        let (q0, declaration) = (&self.q0, system.declaration());
        let d = Compensated::difference(q1, q0);
        if self.projected {
            let v0 = array::map(&d.hi, |d| d / h);
            return onto_pair(&declaration, (self.t0, h), q0, &v0, &d);
        }
        consistency::check_pair(&declaration, (self.t0, h), q0, &Sum::from(&d))?;
        Ok(d)
    }

    /// What methods begin with that begin with a position and a velocity.
    pub(crate) fn phase(&self, system: &dyn AnySystem<N>) -> Result<Phase<N>, SetupError> {
        let Self { q0, rule, t0, .. } = *self;
        if !t0.is_finite() {
            return Err(SetupError::StartTime { t0 });
        }
        check_vector(system, "q0", &q0)?;
        let v0 = match rule {
            Rule::Paper { v0 } | Rule::SecondOrder { v0 } | Rule::Exact { v0, .. } => v0,
            Rule::ThirdOrder { .. } | Rule::ThreeNodes { .. } => {
                return Err(SetupError::DeterminedAcceleration);
            }
            Rule::Nodes { .. } => return Err(SetupError::Velocity),
        };
        check_vector(system, "v0", &v0)?;
        let (q0, v0) = self.consistent(system, q0, v0)?;
        let near = self.meant();
        Ok(Phase { t0, q0, v0, near })
    }

    /// How the second node depends on the position and the velocity of the start.
    pub(crate) fn order(&self) -> StartOrder {
        match self.rule {
            Rule::Paper { .. } => StartOrder::First,
            Rule::SecondOrder { .. } => StartOrder::Second,
            Rule::Nodes { .. } | Rule::ThreeNodes { .. } | Rule::ThirdOrder { .. } => StartOrder::Nodes,
            Rule::Exact { .. } => StartOrder::Exact,
        }
    }

    /// The acceleration that is meant, where it was said.
    fn meant(&self) -> Option<[f64; N]> {
        match self.rule {
            Rule::Exact { a0, .. } => Some(a0),
            _ => self.near,
        }
    }

    /// A position and a velocity that obey the constraints of lower order.
    fn consistent(
        &self,
        system: &dyn AnySystem<N>,
        q: [f64; N],
        v: [f64; N],
    ) -> Result<([f64; N], [f64; N]), SetupError> {
        if self.projected {
            let (q, v) = consistency::project(&system.declaration(), self.t0, &q, &v)?;
            return Ok((sized(&q), sized(&v)));
        }
        consistency::check(&system.declaration(), self.t0, &q, &v)?;
        Ok((q, v))
    }
}

/// Refuses two equal nodes where steps would go on with equal ones only because a constraint says nothing at rest.
fn check_rest<const N: usize>(
    system: &dyn AnySystem<N>,
    at: (f64, f64),
    q0: &[f64; N],
    d: &Compensated<N>,
) -> Result<(), SetupError> {
    if d.hi.iter().any(|&d| d != 0.0) {
        return Ok(());
    }
    match rest::left_open(&system.declaration(), at, q0) {
        Some(deficiency) => Err(SetupError::Rest {
            deficiency: Box::new(deficiency),
        }),
        None => Ok(()),
    }
}

/// The increment to the second node, moved onto the constraints of nodes and of pairs.
fn onto_pair<const N: usize>(
    declaration: &Declaration<'_>,
    at: (f64, f64),
    q0: &[f64; N],
    v0: &[f64; N],
    d: &Compensated<N>,
) -> Result<Compensated<N>, SetupError> {
    let moved = consistency::onto_pair(declaration, at, q0, v0, Sum::from(d))?;
    Ok(Compensated::from(&moved))
}

/// The kinds of starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum StartOrder {
    /// The velocity times the step leads to the second node.
    First,
    /// The acceleration comes in, too.
    Second,
    /// The second node is given.
    Nodes,
    /// The continuous motion leads there.
    Exact,
}

/// The start of a method that begins with a position and a velocity.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Phase<const N: usize> {
    /// The time.
    pub t0: f64,
    /// The position.
    pub q0: [f64; N],
    /// The velocity.
    pub v0: [f64; N],
    /// Where the acceleration is looked for.
    pub near: Option<[f64; N]>,
}

/// The start, worked out.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Beginning<const N: usize> {
    /// The first node.
    pub q0: [f64; N],
    /// The velocity there.
    pub v0: [f64; N],
    /// The acceleration there, where it was needed.
    pub a0: Option<[f64; N]>,
    /// The acceleration with which the motion begins, where it was said.
    pub near: Option<[f64; N]>,
    /// The time of the first node.
    pub t0: f64,
    /// The second node.
    pub q: Compensated<N>,
    /// The increment from the first to the second.
    pub d: Compensated<N>,
    /// The second difference of the first three nodes, where a step of third order goes on from it.
    pub e: Option<Compensated<N>>,
}

impl<const N: usize> Beginning<N> {
    /// The acceleration for the first step.
    pub fn begins(&self) -> Option<Begins<N>> {
        match (self.near, self.a0) {
            // the solution that was meant says more than what it was to be near to
            (Some(near), a0) => Some(Begins::Said(a0.unwrap_or(near))),
            (None, a0) => a0.map(Begins::Found),
        }
    }
}

/// Checks that the parameters are finite.
pub(crate) fn check_parameters<const N: usize>(system: &dyn AnySystem<N>) -> Result<(), SetupError> {
    match system.parameters().iter().find(|(_, value)| !value.is_finite()) {
        Some(&(parameter, value)) => Err(SetupError::Parameter {
            name: parameter.name.clone(),
            value,
        }),
        None => Ok(()),
    }
}

/// Checks that a vector of the start is finite.
fn check_vector<const N: usize>(
    system: &dyn AnySystem<N>,
    vector: &'static str,
    components: &[f64; N],
) -> Result<(), SetupError> {
    let mut named = system.declaration().coordinates().iter().zip(components);
    match named.find(|(_, value)| !value.is_finite()) {
        Some((coordinate, &value)) => Err(SetupError::Start {
            vector,
            coordinate: coordinate.name.clone(),
            value,
        }),
        None => Ok(()),
    }
}

/// The acceleration of the continuous system at a start, which has to be finite.
pub(crate) fn state_acceleration<const N: usize>(
    system: &dyn AnySystem<N>,
    (t0, q0, v0): (f64, &[f64; N], &[f64; N]),
    near: Option<&[f64; N]>,
) -> Result<[f64; N], SetupError> {
    Ok(state(system, (t0, q0, v0), near)?.0)
}

/// The same, and the multipliers where they are unknown.
pub(crate) fn state<const N: usize>(
    system: &dyn AnySystem<N>,
    (t0, q0, v0): (f64, &[f64; N], &[f64; N]),
    near: Option<&[f64; N]>,
) -> Result<Accelerated<N>, SetupError> {
    check_vector(system, "q0", q0)?;
    check_vector(system, "v0", v0)?;
    if let Some(a0) = near {
        check_vector(system, "a0", a0)?;
    }
    match system.acceleration((t0, q0, v0), near) {
        Ok(found) => Ok(found),
        Err(cause) => Err(SetupError::Acceleration {
            at_any_velocity: fails_in_motion(system, (t0, q0), cause.reason),
            q0: q0.to_vec(),
            v0: v0.to_vec(),
            deficiency: deficiency::of_start(
                &system.declaration(),
                (t0, q0, v0),
                near.map(|near| &near[..]),
                &cause,
            )
            .map(Box::new),
            undefined: undefined(&system.declaration(), (t0, q0, v0), near, &cause).map(Box::new),
            cause: Box::new(cause),
        }),
    }
}

/// What in the equations for the acceleration has no value, where that is why they have no solution.
#[cold]
fn undefined<const N: usize>(
    declaration: &Declaration<'_>,
    (t, q, v): (f64, &[f64; N], &[f64; N]),
    near: Option<&[f64; N]>,
    cause: &NewtonFailure,
) -> Option<Undefined> {
    let a = near.unwrap_or(&[0.0; N]);
    (cause.reason == StepFailure::NotFinite)
        .then(|| undefined::of_point(declaration, AnyPoint { t, q, v, a }))
        .flatten()
}

/// Whether the equations fail for a reason at a position whatever the velocity: along no axis, and of one size or another.
fn fails_in_motion<const N: usize>(
    system: &dyn AnySystem<N>,
    (t, q): (f64, &[f64; N]),
    reason: StepFailure,
) -> bool {
    [1.0, -1e-3, 1e3].into_iter().all(|size| {
        let v = array::from_fn(|i| size / (i as f64 + 1.3));
        let found = system.acceleration((t, q, &v), None);
        found.is_err_and(|failure| failure.reason == reason)
    })
}

/// The acceleration and the multipliers of the continuous system at `(t, q, v)`, looked for near an acceleration, or near none.
pub(crate) fn acceleration<S: System<N>, const N: usize>(
    system: &S,
    at: (f64, &[f64; N], &[f64; N]),
    near: Option<&[f64; N]>,
) -> Result<Accelerated<N>, NewtonFailure> {
    let declaration = Declaration::of(system);
    if S::JUMPS && declaration.sides() > 0 {
        let (t, q, v) = at;
        let multipliers = S::Motion::zero().as_ref().len() - N;
        let near = near.map(|near| &near[..]);
        if let Some(found) = sticking::of_motion(&declaration, (t, q, v), multipliers, near) {
            return Ok((sized(&found.x), found.x[N..].to_vec()));
        }
    }
    solve_continuous::<S::Motion, N>(declaration, at, near)
}

/// The same of a declaration whose continuous system has the unknowns `U`.
fn solve_continuous<U: Unknown<f64>, const N: usize>(
    declaration: Declaration<'_>,
    (t, q, v): (f64, &[f64; N], &[f64; N]),
    near: Option<&[f64; N]>,
) -> Result<Accelerated<N>, NewtonFailure> {
    let equations = Continuous {
        declaration,
        t,
        q,
        v,
        unknowns: PhantomData,
    };
    let zero = U::zero();
    let mut guess = zero;
    for (guess, a) in guess.as_mut().iter_mut().zip(near.into_iter().flatten()) {
        *guess = *a;
    }
    match newton::solve_apart(&equations, guess, &zero, MAX_ITERATIONS, &mut ()) {
        Ok(root) => Ok((equations.point(&root.z).a, of_motion(N, root.z.as_ref()).to_vec())),
        Err(_) => Err(newton::explain(&equations, guess, &zero, MAX_ITERATIONS)),
    }
}

/// The continuous system as equations for the acceleration and the multipliers.
struct Continuous<'a, U, const N: usize> {
    /// The declaration.
    declaration: Declaration<'a>,
    /// The time.
    t: f64,
    /// The position.
    q: &'a [f64; N],
    /// The velocity.
    v: &'a [f64; N],
    /// What the unknowns are.
    unknowns: PhantomData<U>,
}

impl<U: Unknown<f64>, const N: usize> Continuous<'_, U, N> {
    /// The point with the acceleration that is among the unknowns.
    fn point(&self, z: &U) -> Point<f64, N> {
        let z = z.as_ref();
        Point {
            t: self.t,
            q: *self.q,
            v: *self.v,
            a: array::from_fn(|i| z.get(i).copied().unwrap_or(f64::NAN)),
        }
    }
}

impl<U: Unknown<f64>, const N: usize> Equations for Continuous<'_, U, N> {
    type Z = U;

    fn linearize(&self, z: &U) -> Linearization<f64, U> {
        let multipliers = of_motion(N, z.as_ref());
        self.declaration
            .linearize_continuous(self.point(z).any(), multipliers)
    }

    fn rounding(&self, z: &U) -> U {
        let mut bounds = U::zero();
        let multipliers = of_motion(N, z.as_ref());
        self.declaration
            .continuous_bounds(self.point(z).any(), multipliers, bounds.as_mut());
        bounds
    }
}

/// The velocity with which a motion goes on where its parameters change from those of the first declaration to those of the second: the
/// momentum stays, but for what the constraints do to it at once: where a constraint of velocities is another, the velocity is brought onto
/// it by the shortest way, measured by the mass matrix (the impulse of its force).
pub(crate) fn velocity_after(
    [before, after]: &[Declaration<'_>; 2],
    (t, q, v): (f64, &[f64], &[f64]),
) -> Result<Vec<f64>, SetupError> {
    let kept = momentum(before, (t, q, v));
    let velocity = velocity_of(after, (t, q), &kept, v);
    let (_, velocity) = consistency::project(after, t, q, &velocity)?;
    Ok(velocity)
}

/// The momentum with which a leg arrives, where the forces of constraints of velocities have acted up to its end: `(q, momentum)` moved
/// along these forces until the velocity at the node obeys the constraints.
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

/// The velocity that has a momentum, from a guess.
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

/// The mass matrix at `(t, q, v)`.
pub(crate) fn mass_matrix(declaration: &Declaration<'_>, (t, q, v): (f64, &[f64], &[f64])) -> Matrix {
    consistency::mass_matrix(declaration, t, q, v)
}

/// The inverse of the mass matrix at `(t, q, v)`; the identity where there is none.
pub(crate) fn inverse_mass(declaration: &Declaration<'_>, (t, q, v): (f64, &[f64], &[f64])) -> Matrix {
    consistency::inverse_mass(declaration, t, q, v)
}

/// As many unknowns as values; NaN where there are fewer values.
pub(crate) fn vector<U: Unknown<f64>>(values: &[f64]) -> U {
    let mut vector = U::zero();
    for (i, place) in vector.as_mut().iter_mut().enumerate() {
        *place = values.get(i).copied().unwrap_or(f64::NAN);
    }
    vector
}
