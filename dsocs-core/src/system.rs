//! What `#[dsocs]` generates, and what the rest of this crate works with.

use crate::composition::Symmetry;
use crate::scalar::Scalar;
use crate::step::unknown::{Linearization, Unknown};

/// A leg of the discrete path: the step's first two nodes, as a node and the increment that led to it.
///
/// The increment is carried beside the node because `q1 - q0` formed from rounded nodes loses the digits that the
/// second difference needs (see the crate's documentation on the form of the unknown).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leg<T, const N: usize> {
    /// The middle node `q1` of the step.
    pub q: [T; N],
    /// The increment `q1 - q0`.
    pub d: [T; N],
}

/// A point of the second order tangent bundle: `φ_D⁻¹(q0, q1, q2)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point<T, const N: usize> {
    /// Position.
    pub q: [T; N],
    /// Velocity.
    pub v: [T; N],
    /// Acceleration.
    pub a: [T; N],
}

/// A quantity of a declaration, for people: a coordinate, a parameter or an observed expression.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Quantity {
    /// The name in the declaration; `masses_2` for an element of an array.
    pub name: &'static str,
    /// The documentation in one line. By convention the unit stands in brackets at its end, `The mass of the rod \[kg\].`
    pub doc: &'static str,
}

impl Quantity {
    /// The unit, if the documentation ends with one in brackets.
    ///
    /// ```
    /// use dsocs_core::Quantity;
    ///
    /// let inertia = Quantity { name: "inertia", doc: "The moment of inertia `I` of the wheel [kg m²]." };
    /// assert_eq!((inertia.meaning(), inertia.unit()), ("The moment of inertia `I` of the wheel", Some("kg m²")));
    /// // a unit of one word is written `\[kg\]`, since rustdoc takes `[kg]` for a link
    /// let mass = Quantity { name: "mass", doc: r"The mass \[kg\]" };
    /// assert_eq!((mass.meaning(), mass.unit()), ("The mass", Some("kg")));
    /// assert_eq!(Quantity { name: "psi", doc: "The angle." }.unit(), None);
    /// ```
    #[must_use]
    pub fn unit(&self) -> Option<&'static str> {
        self.parts().1
    }

    /// The documentation without the unit and the full stop.
    #[must_use]
    pub fn meaning(&self) -> &'static str {
        self.parts().0
    }

    /// The documentation and the unit at its end.
    fn parts(&self) -> (&'static str, Option<&'static str>) {
        let doc = self.doc.trim_end().trim_end_matches('.');
        match doc.strip_suffix(']').and_then(|doc| doc.rsplit_once('[')) {
            Some((doc, unit)) => (
                doc.trim_end_matches('\\').trim_end(),
                Some(unit.trim_end_matches('\\')),
            ),
            None => (doc, None),
        }
    }
}

/// A discrete second order constrained Lagrangian system with `N` coordinates, as `#[dsocs]` generates it.
///
/// With `q0, q1` known (a [`Leg`]) the step looks for the second difference `e = (q2 - q1) - (q1 - q0)`, written in
/// the unknowns `z` of type [`System::Unknown`], such that the rows of [`System::residual`] vanish: the constraints,
/// holonomic ones at `q2`, nonholonomic ones at `φ_{L_d}⁻¹(q1, q2)`, kinematic ones at `φ_{D_K}⁻¹(q0, q1, q2)`; then for every
/// field `u` of the variational constraints the work `⟨u, Q⟩` of the constraint force `Q = -(D₁L_d(q1,q2) + D₂L_d(q0,q1))`, at
/// `φ_{D_V}⁻¹(q0, q1, q2)`, or, where no such fields are known, `Q - Σ λ_j α_j` with unknown multipliers. Rows that are linear in a second
/// difference, with a coefficient that the parameters and `h` decide, are solved for it beforehand and are not among the
/// rows left; [`System::second_difference`] gives all second differences back. A row with `branch = divide(w)` is divided by `w`.
///
/// What depends on the parameters and `h` alone is computed once a run ([`System::constants`]); what depends on the
/// leg alone, once a step ([`System::known`]); the rest, once an iteration.
pub trait System<const N: usize> {
    /// The unknowns of one step, `[T; M]` for a literal `M`.
    type Unknown<T: Scalar>: Unknown<T>;
    /// What is known when the run begins, an array of a literal size.
    type Constants<T: Scalar>: Copy;
    /// What is known when the step begins, an array of a literal size.
    type Known<T: Scalar>: Copy;
    /// The unknowns of the continuous system: the accelerations, then the multipliers if there are any.
    type Motion<T: Scalar>: Unknown<T>;

    /// Whether every row of [`System::residual`] is affine in the unknowns: then one update solves the step.
    const LINEAR: bool = false;

    /// Whether rows were multiplied by more than a number (see [`System::scales`]).
    const SCALED: bool = false;

    /// How many forms of constraint forces are known: one for each constraint, or none where the virtual displacements are
    /// given by fields.
    const FORMS: usize = 0;

    /// How many holonomic constraints there are.
    const HOLONOMIC: usize = 0;

    /// How many nonholonomic constraints there are, those imposed on pairs of nodes.
    const NONHOLONOMIC: usize = 0;

    /// Whether the declaration names a factor to be divided out of a row. It has then said which root is wanted, and steps
    /// are not watched for a second root nearby.
    const DIVIDED: bool = false;

    /// Whether steps of different lengths can be composed, or why not; the attribute finds out.
    const SYMMETRY: Symmetry = Symmetry::Unknown;

    /// How many kinematic constraints there are, those imposed on triples of nodes.
    const KINEMATIC: usize = 0;

    /// The name of the declared type.
    const NAME: &'static str;
    /// The first paragraph of the type's documentation, in one line.
    const DOC: &'static str = "";
    /// The coordinates, in order; `theta_2` is the name of one of an array.
    const COORDINATES: [Quantity; N];
    /// The parameters: fields of type `f64` and the elements of arrays of them, in order. Fields of other types are not
    /// listed.
    const PARAMETERS: &'static [Quantity];
    /// The observed expressions (`observe = […]`), in order.
    const OBSERVABLES: &'static [Quantity];

    /// The value of parameter `index`, or `None` beyond the last.
    fn parameter(&self, index: usize) -> Option<f64>;

    /// A mutable reference to parameter `index`, or `None` beyond the last.
    fn parameter_mut(&mut self, index: usize) -> Option<&mut f64>;

    /// Values known when the run begins; `h` is the step.
    fn constants<T: Scalar>(&self, h: T) -> Self::Constants<T>;

    /// Values known when the step begins.
    fn known<T: Scalar>(&self, constants: &Self::Constants<T>, leg: &Leg<T, N>) -> Self::Known<T>;

    /// The rows of the step at `z`, and their exact Jacobian `∂row/∂z`.
    fn residual<T: Scalar>(
        &self,
        constants: &Self::Constants<T>,
        known: &Self::Known<T>,
        z: &Self::Unknown<T>,
    ) -> Linearization<T, Self::Unknown<T>>;

    /// What each row of [`System::residual`] is, divided by the declared row: denominators that were multiplied out, and
    /// factors of the parameters and of `h` that were dropped.
    ///
    /// Where one of them vanishes the declared row does not exist, or is zero whatever the unknowns are: a root there is
    /// not accepted.
    fn scales<T: Scalar>(
        &self,
        constants: &Self::Constants<T>,
        known: &Self::Known<T>,
        z: &Self::Unknown<T>,
    ) -> Self::Unknown<T> {
        let _ = (constants, known);
        z.zip(z, |_, _| T::splat(1.0))
    }

    /// The unknowns that belong to a second difference `e` and to multipliers (the starting point of Newton's iteration).
    ///
    /// Where no fields that span the virtual displacements are known, multipliers `λ_j` of the forms of [`System::forms`] are
    /// unknown too. Missing ones are zero, and what is beyond the last is left out.
    fn unknown<T: Scalar>(&self, e: &[T; N], multipliers: &[T]) -> Self::Unknown<T>;

    /// The second difference `e = q2 - 2 q1 + q0` that belongs to the unknowns.
    fn second_difference<T: Scalar>(
        &self,
        constants: &Self::Constants<T>,
        known: &Self::Known<T>,
        z: &Self::Unknown<T>,
    ) -> [T; N];

    /// `φ_{D_K}⁻¹(q0, q1, q2)`: where the kinematic constraints are imposed.
    fn point<T: Scalar>(
        &self,
        constants: &Self::Constants<T>,
        known: &Self::Known<T>,
        leg: &Leg<T, N>,
        e: &[T; N],
    ) -> Point<T, N>;

    /// The generalized constraint force at `q1`, `Q = -(D₁L_d(q1,q2) + D₂L_d(q0,q1))`, in units of `L` per unit of
    /// the coordinate.
    fn force<T: Scalar>(
        &self,
        constants: &Self::Constants<T>,
        known: &Self::Known<T>,
        leg: &Leg<T, N>,
        e: &[T; N],
    ) -> [T; N];

    /// The forms `α_j` in whose directions the constraint forces of a step act, `Q = Σ λ_j α_j`; `out` has the length
    /// [`System::FORMS`].
    fn forms<T: Scalar>(
        &self,
        constants: &Self::Constants<T>,
        known: &Self::Known<T>,
        leg: &Leg<T, N>,
        e: &[T; N],
        out: &mut [[T; N]],
    ) {
        let _ = (constants, known, leg, e, out);
    }

    /// The same for the continuous system, at a point.
    fn continuous_forms<T: Scalar>(&self, point: &Point<T, N>, out: &mut [[T; N]]) {
        let _ = (point, out);
    }

    /// What holonomic and nonholonomic constraints ask of a position and a velocity: the rows `g(q)`, then `c(q, v)`, then
    /// `dg(q)·v`; `out` has their number, `2 HOLONOMIC + NONHOLONOMIC`.
    fn phase<T: Scalar>(&self, q: &[T; N], v: &[T; N], out: &mut [T]) {
        let _ = (q, v, out);
    }

    /// What they ask of a leg of the discrete path: the rows `g(q1)`, then `c(φ⁻¹(q0, q1))`; `out` has their number,
    /// `HOLONOMIC + NONHOLONOMIC`.
    fn pair<T: Scalar>(&self, h: T, leg: &Leg<T, N>, out: &mut [T]) {
        let _ = (h, leg, out);
    }

    /// The Lagrangian `L(q, v)`.
    fn lagrangian<T: Scalar>(&self, q: &[T; N], v: &[T; N]) -> T;

    /// The discrete Lagrangian `L_d(q0, q1) = L(φ_{L_d}⁻¹(q0, q1))` on a leg.
    fn discrete_lagrangian<T: Scalar>(&self, h: T, leg: &Leg<T, N>) -> T;

    /// The energy `⟨∂L/∂v, v⟩ - L`.
    fn energy<T: Scalar>(&self, q: &[T; N], v: &[T; N]) -> T;

    /// The observed expressions at a point, in the order of [`System::OBSERVABLES`]; `out` has their number.
    fn observe<T: Scalar>(&self, point: &Point<T, N>, out: &mut [T]);

    /// The rows of the continuous system at a point and their exact Jacobian with respect to acceleration and multipliers.
    ///
    /// They are the constraints, those of lower order differentiated until accelerations come in, then the works `⟨u, Q⟩`
    /// along the fields; where no fields are known, `Q - Σ λ_j α_j` instead.
    fn continuous<T: Scalar>(
        &self,
        point: &Point<T, N>,
        multipliers: &[T],
    ) -> Linearization<T, Self::Motion<T>>;

    /// The continuous system's generalized constraint force, `Q = -D_{EL}L = d/dt ∂L/∂v - ∂L/∂q`, at a point.
    fn continuous_force<T: Scalar>(&self, point: &Point<T, N>) -> [T; N];
}
