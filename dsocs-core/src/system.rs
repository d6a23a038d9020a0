//! The interface of a declared system.

use crate::kernel::Kernel;
use crate::kernel::generated::Compiled;
use crate::kernel::jets::Jets;
use crate::number::array::Array;
use crate::number::point::{Leg, Point, sized};
use crate::regularity::multipliers;
use crate::tape::Shape;
use crate::tape::Symmetry;
use crate::tape::declaration::Declaration;
use crate::tape::quantity::Quantity;
use std::borrow::Cow;

/// A discrete second order constrained Lagrangian system with `N` coordinates. The attribute `#[dsocs]` implements it.
///
/// Three nodes `q0, q1, q2` with the step `h` between them belong to the discrete motion if the rows of [`System::residual`]
/// vanish. The first rows are the constraints: holonomic ones at `q2`, nonholonomic ones at `φ_{L_d}⁻¹(q1, q2)`, kinematic ones
/// at `φ_{D_K}⁻¹(q0, q1, q2)`. The other rows are the works `⟨u, Q⟩` of the constraint force
/// `Q = -(D₁L_d(q1,q2) + D₂L_d(q0,q1))` along the fields `u` of the variational constraints, at `φ_{D_V}⁻¹(q0, q1, q2)`. If no
/// such fields are known, these rows are `Q - Σ λ_j α_j` with multipliers `λ_j` of the constraints' forms `α_j`.
///
/// These methods evaluate a system at single points, in some hundred nanoseconds each. Runs (such as
/// [`Flow`](crate::Flow)) use other, faster code.
///
/// ```
/// use dsocs_core::{System, dsocs};
///
/// /// A particle that falls.
/// #[dsocs {
///     coordinates(z);
///     lagrangian = mass * (dot(z).powi(2) / 2 - gravity * z);
/// }]
/// struct Stone {
///     mass: f64,
///     gravity: f64,
/// }
///
/// let stone = Stone { mass: 2.0, gravity: 10.0 };
/// assert_eq!(stone.energy(0.0, &[3.0], &[1.0]), 61.0);
/// // a parabola through the heights 0, 1/4 and 0 turns down as fast as the stone falls: nothing has to hold it
/// let h = (0.5_f64 / 10.0).sqrt();
/// assert!(stone.force(0.0, h, &[[0.0], [0.25], [0.0]])[0].abs() < 1e-14);
/// assert!(stone.residual(0.0, h, &[[0.0], [0.25], [0.0]])[0].abs() < 1e-14);
/// ```
pub trait System<const N: usize>: Compiled<N> + Jets<N> {
    /// The name of the declared type.
    const NAME: &'static str;
    /// The first paragraph of the type's documentation, in one line.
    const DOC: &'static str = "";
    /// The declaration as text: the body of the attribute. See [`Shape::declaration`].
    const DECLARATION: &'static str = "";
    /// The coordinates, in order. A component of an array has a name like `theta_2`.
    const COORDINATES: [Quantity; N];
    /// The parameters: fields of type `f64` and the elements of arrays of them, in order. Fields of other types are not
    /// listed.
    const PARAMETERS: &'static [Quantity];
    /// The fields of other types, which are no parameters; their `doc` is the type.
    const OTHERS: &'static [Quantity] = &[];
    /// The observed expressions (`observe = […]`), in order.
    const OBSERVABLES: &'static [Quantity];

    /// The highest order of a derivative in a constraint, at least 2. A step solves for the last of
    /// `ORDER + 1` nodes.
    const ORDER: usize = 2;

    /// The number of known one-forms of constraint forces: one for each constraint, or none if the virtual displacements are
    /// given by fields.
    const FORMS: usize = 0;

    /// The number of holonomic constraints.
    const HOLONOMIC: usize = 0;

    /// The number of nonholonomic constraints, which are imposed on pairs of nodes.
    const NONHOLONOMIC: usize = 0;

    /// The number of kinematic constraints, which are imposed on triples of nodes (those of third order on four nodes).
    const KINEMATIC: usize = 0;

    /// Whether any expression depends on time.
    const DEPENDS_ON_TIME: bool = true;

    /// Whether external forces act (`external_forces = (…)`).
    const EXTERNAL_FORCES: bool = false;

    /// Whether steps of different lengths can be composed, or the reason if not, as the attribute determined.
    const SYMMETRY: Symmetry = Symmetry::Unknown;

    /// The system as a trait object, without its type.
    fn kernel(&self) -> &dyn Kernel;

    /// The value of parameter `index`, or `None` beyond the last.
    fn parameter(&self, index: usize) -> Option<f64>;

    /// A mutable reference to parameter `index`, or `None` beyond the last. A change affects runs that begin
    /// later.
    fn parameter_mut(&mut self, index: usize) -> Option<&mut f64>;

    /// The Lagrangian `L(t, q, v)`.
    fn lagrangian(&self, t: f64, q: &[f64; N], v: &[f64; N]) -> f64 {
        Declaration::of(self).lagrangian(t, q, v)
    }

    /// The energy `⟨∂L/∂v, v⟩ - L`, in the units of `L`.
    fn energy(&self, t: f64, q: &[f64; N], v: &[f64; N]) -> f64 {
        Declaration::of(self).energy(t, q, v)
    }

    /// The external forces `f(t, q, v)`, in units of `L` per unit of the coordinate; zero where none are declared.
    fn external_forces(&self, t: f64, q: &[f64; N], v: &[f64; N]) -> [f64; N] {
        let mut forces = [0.0; N];
        Declaration::of(self).external_forces(t, q, v, &mut forces);
        forces
    }

    /// The generalized constraint force at a point of a motion, such as a sample ([`crate::Stepper::sample`])
    /// or an event ([`crate::Occurrence::point`]), by the continuous equations: `Q = d/dt ∂L/∂v − ∂L/∂q − f`
    /// with the external forces `f`, in units of `L` per unit of the coordinate. It is as accurate as the
    /// acceleration of the point.
    ///
    /// ```
    /// use dsocs_core::{System, prelude::*};
    ///
    /// /// A mass on a rod.
    /// #[dsocs {
    ///     coordinates(x, y);
    ///     lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - 9.81 * y;
    ///     holonomic = x.powi(2) + y.powi(2) - 1;
    /// }]
    /// struct Rod;
    ///
    /// let start = Start::second_order([1.0, 0.0], [0.0, 0.0]);
    /// let mut motion = TaylorFlow::new(&Rod, start, Tolerance::relative(1e-12))?;
    /// motion.sample(&[0.1, 0.2, 0.3], &mut |_, point| {
    ///     let [x, y] = Rod.constraint_force(point);
    ///     // from rest at the height of the pivot the rod pulls with three times the weight's part along it
    ///     assert!((x.hypot(y) - 3.0 * 9.81 * point.q[1].abs()).abs() < 1e-9);
    /// })?;
    /// # Ok::<(), RunError>(())
    /// ```
    fn constraint_force(&self, point: &Point<f64, N>) -> [f64; N] {
        sized(&Declaration::of(self).continuous_force(point.any()))
    }

    /// The generalized constraint force at the second of three nodes with the step `h` between them, in units
    /// of `L` per unit of the coordinate: `Q = -(D₁L_d(q1,q2) + D₂L_d(q0,q1) + f⁻_d(q1,q2) + f⁺_d(q0,q1))`,
    /// with the external forces `f_d`. The second node is at the time `t`.
    ///
    /// It is computed from differences of the nodes, so it loses the digits in which they agree.
    fn force(&self, t: f64, h: f64, nodes: &[[f64; N]; 3]) -> [f64; N] {
        let (leg, e) = differences(t, nodes);
        sized(&Declaration::of(self).force(h, leg.any(), &e))
    }

    /// The residual of the declared equations at three nodes with the step `h` between them. The second node
    /// is at the time `t`. There is one number for each row: first the constraints, then the works of the
    /// constraint force along the virtual displacements. Unknown multipliers are fitted to the force.
    ///
    /// A holonomic constraint has the row `g(q2) − (1 − 2⁻¹⁰) g(q1)`: the change from the middle node, and a
    /// small part of the error there, so that rounding errors do not accumulate.
    ///
    /// It is computed from differences of the nodes, so it loses the digits in which they agree.
    fn residual(&self, t: f64, h: f64, nodes: &[[f64; N]; 3]) -> Vec<f64> {
        let (leg, e) = differences(t, nodes);
        let declaration = Declaration::of(self);
        let multipliers = multipliers::of_step(&declaration, h, leg.any(), &e);
        declaration.declared(h, leg.any(), &e, &multipliers)
    }

    /// Writes the observed expressions at a point to `out`, in the order of [`System::OBSERVABLES`], up to
    /// its length.
    fn observe(&self, point: &Point<f64, N>, out: &mut [f64]) {
        Declaration::of(self).observe(point.any(), out);
    }
}

/// Three nodes, the second at the time `t`, as a leg and a second difference.
fn differences<const N: usize>(t: f64, [q0, q1, q2]: &[[f64; N]; 3]) -> (Leg<f64, N>, [f64; N]) {
    let d: [f64; N] = core::array::from_fn(|i| q1[i] - q0[i]);
    let e = core::array::from_fn(|i| (q2[i] - q1[i]) - d[i]);
    (Leg { t, q: *q1, d }, e)
}

impl Shape {
    /// The shape of a declared type.
    #[must_use]
    pub const fn of<S: System<N>, const N: usize>() -> Self {
        Self {
            name: Cow::Borrowed(S::NAME),
            doc: Cow::Borrowed(S::DOC),
            declaration: Cow::Borrowed(S::DECLARATION),
            coordinates: Cow::Borrowed(const { &S::COORDINATES }),
            parameters: Cow::Borrowed(S::PARAMETERS),
            others: Cow::Borrowed(S::OTHERS),
            observables: Cow::Borrowed(S::OBSERVABLES),
            increments: N,
            unknowns: <S::Unknown<f64> as Array<f64>>::LENGTH,
            motion: <S::Motion as Array<f64>>::LENGTH,
            constants: <S::Constants<f64> as Array<f64>>::LENGTH,
            known: <S::Known<f64> as Array<f64>>::LENGTH,
            order: S::ORDER,
            holonomic: S::HOLONOMIC,
            nonholonomic: S::NONHOLONOMIC,
            kinematic: S::KINEMATIC,
            forms: S::FORMS,
            third_order: Cow::Borrowed(S::THIRD_ORDER),
            rotations: Cow::Borrowed(S::ROTATIONS),
            of_positions: Cow::Borrowed(S::OF_POSITIONS),
            of_rates: Cow::Borrowed(S::OF_RATES),
            depends_on_time: S::DEPENDS_ON_TIME,
            external_forces: S::EXTERNAL_FORCES,
            linear: S::LINEAR,
            jumps: S::JUMPS,
            piecewise: S::PIECEWISE,
            switches: S::SWITCHING,
            scaled: S::SCALED,
            divided: S::DIVIDED,
            symmetry: S::SYMMETRY,
        }
    }
}
