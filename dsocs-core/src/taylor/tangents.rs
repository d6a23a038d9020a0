//! Derivatives of the continuous motion: its variational equations, solved by the same series.
//!
//! A step of the motion is a polynomial in its length, with coefficients that depend on its initial point.
//! With numbers that carry derivatives the recurrences give the derivatives of these coefficients. The length
//! of a step is that of the plain motion.

use super::control::Tolerance;
use super::flow::TaylorFlow;
use super::moved::{DIRECTIONS, Moved};
use crate::derivative::{DerivativeError, NodeTangent, Variable, parameter};
use crate::number::point::{Point, sized};
use crate::number::scalar::Scalar as _;
use crate::run::{RunError, Stepper as _};
use crate::series::rows::Series;
use crate::series::switch::Switches as _;
use crate::solve::rotation;
use crate::start::{self, Start, StartOrder};
use crate::system::System;

/// A [`TaylorFlow`] with the derivatives of its motion by components of the start and by parameters.
///
/// The motion is that of the flow, bit for bit, and the derivatives are those of the continuous motion, about
/// as accurate as the tolerance requires of the motion. Four variables together cost a few plain runs.
///
/// ```
/// use dsocs_core::prelude::*;
/// use dsocs_core::Variable;
/// use dsocs_core::taylor::TaylorTangents;
///
/// /// A mass on a spring.
/// #[dsocs {
///     coordinates(x);
///     lagrangian = dot(x).powi(2) / 2 - stiffness * x.powi(2) / 2;
/// }]
/// struct Oscillator {
///     stiffness: f64,
/// }
///
/// let oscillator = Oscillator { stiffness: 4.0 };
/// let variables = [Variable::Parameter("stiffness"), Variable::Velocity(0)];
/// let start = Start::second_order([1.0], [0.0]);
/// let mut tangents = TaylorTangents::new(&oscillator, start, Tolerance::relative(1e-14), &variables)?;
/// // x = cos(ω t) with ω² = k: ∂x/∂k = −t sin(ω t) / 2ω, and ∂x/∂v = sin(ω t) / ω
/// let [by_stiffness, by_velocity] = tangents.to(1.0)?[..] else { unreachable!() };
/// assert!((by_stiffness.q[0] + 2.0_f64.sin() / 4.0).abs() < 1e-14);
/// assert!((by_velocity.q[0] - 2.0_f64.sin() / 2.0).abs() < 1e-14);
/// # Ok::<(), dsocs_core::DerivativeError>(())
/// ```
///
/// # Limits
///
/// There are no derivatives across jumps and corners, for systems with constraints on positions or velocities
/// (their starts are not free), and for your own functions with arguments that change.
pub struct TaylorTangents<'s, const N: usize> {
    /// The motion.
    flow: TaylorFlow<'s, N>,
    /// The variables in groups.
    groups: Vec<Group<'s>>,
    /// The number of variables.
    count: usize,
}

impl<const N: usize> core::fmt::Debug for TaylorTangents<'_, N> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("TaylorTangents")
            .field("flow", &self.flow)
            .field("variables", &self.count)
            .finish_non_exhaustive()
    }
}

/// The derivatives by up to [`DIRECTIONS`] variables.
struct Group<'s> {
    /// The variational equations.
    kernel: Box<dyn TangentKernel + 's>,
    /// The derivatives of position, velocity and acceleration at the current point, one after the other, each
    /// by direction; for a rotation those of its quaternion.
    now: Vec<[f64; DIRECTIONS]>,
}

/// The series of a declared system with derivatives, without its type.
trait TangentKernel {
    /// Propagates the derivatives of position and velocity along a step with this plain series, and sets
    /// those of the acceleration.
    fn step(&mut self, plain: &Series, h: f64, now: &mut [[f64; DIRECTIONS]]);

    /// Whether a value of the user's functions depends on time.
    fn moves(&self) -> bool;
}

/// The recurrences that the attribute generates, with derivatives.
struct Recurrences<'s, S: System<N>, const N: usize> {
    /// The system.
    system: &'s S,
    /// The expressions of the parameters.
    fixed: S::Fixed<Moved>,
    /// The coefficients of lower orders that the recurrences need.
    table: S::Table<Moved>,
    /// The series.
    series: Series<Moved>,
}

/// A variable after its name and index were looked up.
enum Moving {
    Position(usize),
    Velocity(usize),
    Parameter(usize),
}

impl Moving {
    /// Looks a variable up.
    fn find<S: System<N>, const N: usize>(
        system: &S,
        variable: Variable<'_>,
    ) -> Result<Self, DerivativeError> {
        let coordinate = |index: usize| {
            if S::ROTATIONS.contains(&index) {
                Err(DerivativeError::Scalar {
                    rotation: start::name_of_rotation(system.kernel().shape(), index),
                    index,
                })
            } else if index < N {
                Ok(index)
            } else {
                Err(DerivativeError::Index {
                    what: "coordinate",
                    index,
                    count: N,
                })
            }
        };
        match variable {
            Variable::Position(index) => coordinate(index).map(Self::Position),
            Variable::Velocity(index) => coordinate(index).map(Self::Velocity),
            Variable::Parameter(name) => parameter(name, S::PARAMETERS).map(Self::Parameter),
            Variable::SecondNode(_) => Err(DerivativeError::Variable {
                start: "position and velocity",
                variable: "second node",
            }),
            Variable::Input { name, .. } => Err(DerivativeError::Input {
                name: name.to_owned(),
                inputs: Vec::new(),
            }),
        }
    }
}

impl<'s, const N: usize> TaylorTangents<'s, N> {
    /// A motion from a start, with its derivatives by some variables.
    ///
    /// # Errors
    ///
    /// [`DerivativeError::Run`] as [`TaylorFlow::new`]; the others if a variable is unknown or the motion has no derivatives.
    pub fn new<S: System<N>>(
        system: &'s S,
        start: Start<N>,
        tolerance: Tolerance,
        variables: &[Variable<'_>],
    ) -> Result<Self, DerivativeError> {
        if start.given().order() == StartOrder::Nodes {
            return Err(DerivativeError::Continuous {
                reason: "its start has to be given by position and velocity, as by Start::second_order",
            });
        }
        if S::HOLONOMIC + S::NONHOLONOMIC > 0 {
            return Err(DerivativeError::Continuous {
                reason: "constraints on positions or velocities bind its start; `Path` differentiates runs from two nodes",
            });
        }
        let flow = TaylorFlow::new(system, start, tolerance).map_err(RunError::from)?;
        let found: Vec<Moving> = variables
            .iter()
            .map(|variable| Moving::find::<S, N>(system, *variable))
            .collect::<Result<_, _>>()?;
        let groups = found
            .chunks(DIRECTIONS)
            .map(|some| Group::new::<S, N>(system, flow.any.motion.now.q(), some));
        let mut tangents = Self {
            groups: groups.collect(),
            count: found.len(),
            flow,
        };
        tangents.step_along(0.0)?;
        Ok(tangents)
    }

    /// The motion.
    #[must_use]
    pub fn flow(&self) -> &TaylorFlow<'s, N> {
        &self.flow
    }

    /// Runs to the time `t`, not before the last one, and returns the derivatives there, one for each variable.
    ///
    /// # Errors
    ///
    /// [`DerivativeError`] if the motion does not reach `t`, or has no derivatives on the way.
    pub fn to(&mut self, t: f64) -> Result<Vec<NodeTangent<N>>, DerivativeError> {
        self.along(t, &mut |_, _| {})?;
        Ok(self.tangents())
    }

    /// Runs like [`TaylorTangents::to`], and calls `visit` at the end of each step with the motion and its
    /// derivatives there.
    ///
    /// # Errors
    ///
    /// As [`TaylorTangents::to`].
    pub fn along(
        &mut self,
        t: f64,
        visit: &mut dyn FnMut(&Point<f64, N>, &[NodeTangent<N>]),
    ) -> Result<(), DerivativeError> {
        if !t.is_finite() {
            return Err(RunError::Until { until: t }.into());
        }
        let end = self.flow.clock().until(t)?;
        while self.flow.time() != end.time() {
            self.flow.step(end.time())?;
            let Some((_, h)) = self.flow.any.motion.last else {
                break;
            };
            if self.flow.any.motion.is_new {
                return Err(DerivativeError::Continuous {
                    reason: "it meets a jump or a corner; differences of whole runs have no such limit",
                });
            }
            self.step_along(h)?;
            visit(&Point::of(self.flow.any.motion.point()), &self.tangents());
        }
        Ok(())
    }

    /// The derivatives at the current point.
    #[must_use]
    pub fn tangents(&self) -> Vec<NodeTangent<N>> {
        let motion = &self.flow.any.motion;
        let rotations = &self.flow.any.equations.kernel().shape().rotations;
        let one = |place: usize| {
            let now = &self.groups[place / DIRECTIONS].now;
            let of = |kind: usize| core::array::from_fn(|i| now[kind * N + i][place % DIRECTIONS]);
            let q: [f64; N] = of(0);
            NodeTangent {
                q: sized(&rotation::body(rotations, motion.now.q(), &q)),
                v: of(1),
                a: of(2),
            }
        };
        (0..self.count).map(one).collect()
    }

    /// Propagates the derivatives along the last step of the length `h`; with 0 at the start.
    fn step_along(&mut self, h: f64) -> Result<(), DerivativeError> {
        let motion = &self.flow.any.motion;
        let series = if h == 0.0 { &motion.next } else { &motion.series };
        for group in &mut self.groups {
            group.kernel.step(series, h, &mut group.now);
            if group.kernel.moves() {
                return Err(DerivativeError::Continuous {
                    reason: "it depends on a function of yours, whose series have no derivatives; `Path` differentiates the discrete motion",
                });
            }
        }
        Ok(())
    }
}

impl<'s> Group<'s> {
    fn new<S: System<N>, const N: usize>(system: &'s S, q: &[f64], variables: &[Moving]) -> Self {
        let mut parameters = system.parameters::<Moved>();
        let mut now = vec![[0.0; DIRECTIONS]; 3 * N];
        for (direction, variable) in variables.iter().enumerate() {
            match *variable {
                Moving::Position(i) => {
                    let unit: [f64; N] = core::array::from_fn(|j| f64::from(u8::from(i == j)));
                    for (now, rate) in now.iter_mut().zip(rotation::rate(S::ROTATIONS, q, &unit).iter()) {
                        now[direction] = *rate;
                    }
                }
                Moving::Velocity(i) => now[N + i][direction] = 1.0,
                Moving::Parameter(place) => {
                    if let Some(parameter) = parameters.as_mut().get_mut(place) {
                        parameter.by[direction] = 1.0;
                    }
                }
            }
        }
        let kernel = Box::new(Recurrences {
            system,
            fixed: system.fixed(&parameters),
            table: S::Table::default(),
            series: Series::new(N, 2),
        });
        Self { kernel, now }
    }
}

impl<S: System<N>, const N: usize> TangentKernel for Recurrences<'_, S, N> {
    fn step(&mut self, plain: &Series, h: f64, now: &mut [[f64; DIRECTIONS]]) {
        let Self {
            system,
            fixed,
            table,
            series,
        } = self;
        let with = |values: &[f64], by: &[[f64; DIRECTIONS]]| -> [Moved; N] {
            core::array::from_fn(|i| Moved {
                value: values[i],
                by: by[i],
            })
        };
        let (q, v) = plain.start();
        series.set_order(plain.order());
        series.begin(
            Moved::splat(plain.time()),
            &with(q, &now[..N]),
            &with(v, &now[N..]),
        );
        for (a, &plain) in series.velocity_mut(1).iter_mut().zip(plain.velocity_of(1)) {
            *a = Moved::splat(plain);
        }
        if let Some(mut rows) = series.rows() {
            system.expand::<Moved, false>(fixed, &mut rows, table);
        }
        let [dq, dv, a] = series.increments_of::<false, N>(Moved::splat(h));
        for i in 0..N {
            for direction in 0..DIRECTIONS {
                now[i][direction] += dq[i].by[direction];
                now[N + i][direction] += dv[i].by[direction];
                now[2 * N + i][direction] = a[i].by[direction];
            }
        }
    }

    fn moves(&self) -> bool {
        self.table.moves()
    }
}
