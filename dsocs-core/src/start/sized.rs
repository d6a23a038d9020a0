//! The start of a run, with its number of coordinates at compile time.

use super::begin::{self, StartData};
use super::third::ThirdOrderDatum;
use crate::number::compensated::Compensated;
use crate::solve::Vector;
use crate::solve::sum::Sum;

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
    /// The rule for the second node.
    rule: Rule<N>,
    /// The time of the first node.
    t0: f64,
    /// Whether it is projected onto the constraints.
    projected: bool,
    /// The acceleration near which that at the start is searched.
    near: Option<[f64; N]>,
}

/// The rule that leads from the first node to the second.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Rule<const N: usize> {
    /// `q1 = q0 + h v0`.
    Paper { v0: [f64; N] },
    /// `q1 = q0 + h v0 + h²/2 a0`.
    SecondOrder { v0: [f64; N] },
    /// The given second node.
    Nodes { q1: [f64; N] },
    /// The given second and third nodes, for constraints of third order.
    ThreeNodes { q1: [f64; N], q2: [f64; N] },
    /// `q1 = q0 + h v0 + h²/2 a0 + h³/6 j0`, and a third node, for constraints of third order, which leave
    /// the acceleration free: `a0` is the acceleration or the force at the start.
    ThirdOrder {
        v0: [f64; N],
        a0: [f64; N],
        is_force: bool,
    },
    /// The increment of the continuous motion over the step `h` from the time `t0`, and its initial velocity
    /// and acceleration.
    Exact {
        v0: [f64; N],
        a0: [f64; N],
        d: Compensated<N>,
        h: f64,
        t0: f64,
    },
}

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
                a0,
                is_force: false,
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
                a0: force,
                is_force: true,
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
    /// amount in the norm of the mass matrix, to first order: where constraints hold in several assemblies, a start that is far from them may come to
    /// another one than the nearest. Without this call, a start that violates these constraints is refused.
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

    /// A start on the continuous motion: with the increment `d` over a step from a position, the initial
    /// velocity and acceleration, the time there, and the step.
    pub(crate) const fn along(
        self,
        q0: [f64; N],
        [v0, a0]: [[f64; N]; 2],
        d: Compensated<N>,
        [t0, h]: [f64; 2],
    ) -> Self {
        Self {
            q0,
            rule: Rule::Exact { v0, a0, d, h, t0 },
            projected: false,
            near: None,
            ..self
        }
    }

    /// The start with any number of coordinates.
    pub(crate) fn given(&self) -> StartData {
        let rule = match &self.rule {
            Rule::Paper { v0 } => begin::Rule::Paper { v0: Vector::of(v0) },
            Rule::SecondOrder { v0 } => begin::Rule::SecondOrder { v0: Vector::of(v0) },
            Rule::Nodes { q1 } => begin::Rule::Nodes { q1: Vector::of(q1) },
            Rule::ThreeNodes { q1, q2 } => begin::Rule::ThreeNodes {
                q1: Vector::of(q1),
                q2: Vector::of(q2),
            },
            Rule::ThirdOrder { v0, a0, is_force } => begin::Rule::ThirdOrder {
                v0: Vector::of(v0),
                datum: if *is_force {
                    ThirdOrderDatum::Force(Vector::of(a0))
                } else {
                    ThirdOrderDatum::Acceleration(Vector::of(a0))
                },
            },
            Rule::Exact { v0, a0, d, h, t0 } => begin::Rule::Exact {
                v0: Vector::of(v0),
                a0: Vector::of(a0),
                d: Sum::from(d),
                h: *h,
                t0: *t0,
            },
        };
        StartData {
            q0: Vector::of(&self.q0),
            rule,
            t0: self.t0,
            projected: self.projected,
            near: self.near.as_ref().map(|near| Vector::of(near)),
        }
    }
}
