//! The hot form of a declaration: what a run evaluates often, as straight-line code.

use crate::number::array::Array;
use crate::number::point::{Leg, Point};
use crate::number::scalar::Scalar;
use crate::solve::sparse::Sparse;
use crate::solve::unknown::{Linearization, Unknown};
use crate::tape::Source;

/// What the solver needs of a system, beside its tape, as `#[dsocs]` generates it; see [`System`](crate::System) for the
/// equations.
///
/// What depends on the parameters and `h` alone is computed once a run ([`Compiled::constants`]); what depends on the
/// leg alone, once a step ([`Compiled::known`]); the rest, once an iteration. Everything is generic over its number, so that one
/// declaration serves a single trajectory and several side by side, which may have parameters of their own.
pub trait Compiled<const N: usize>: Source + Sized {
    /// The values of the parameters, an array of a literal size.
    type Parameters<T: Scalar>: Array<T>;
    /// The unknowns of one step, `[T; M]` for a literal `M`.
    type Unknown<T: Scalar>: Unknown<T> + Array<T>;
    /// What is known when the run begins, an array of a literal size.
    type Constants<T: Scalar>: Array<T>;
    /// What is known when the step begins, an array of a literal size.
    type Known<T: Scalar>: Array<T>;
    /// The unknowns of the continuous system: the accelerations, then the multipliers if there are any.
    type Motion: Unknown<f64> + Array<f64>;

    /// Whether every row of [`Compiled::linearize`] is affine in the unknowns, between its jumps if it has any: without jumps, one update solves
    /// the step.
    const LINEAR: bool = false;

    /// Whether a row may jump where an unknown changes, as with the sign of the next velocity: the rows may have no root but that jump.
    const JUMPS: bool = false;

    /// Whether a row has a `signum` or a comparison that positions or velocities decide: a step across it is too long for the scheme's order.
    const PIECEWISE: bool = false;

    /// Whether anything is given by pieces or divided by what may be zero, as the motion or the time decides: where that happens is watched.
    const SWITCHING: bool = false;

    /// Whether rows were multiplied by more than a number (see [`Compiled::scales`]).
    const SCALED: bool = false;

    /// Whether the declaration names a factor to be divided out of a row. It has then said which root is wanted, and steps
    /// are not watched for a second root nearby.
    const DIVIDED: bool = false;

    /// Whether so much of the Jacobian is zero that it is eliminated as a sparse matrix.
    const SPARSE: bool = false;

    /// The places of the constraints of third order among all constraints.
    const THIRD_ORDER: &'static [usize] = &[];

    /// The first of the four places of each coordinate that is a rotation.
    const ROTATIONS: &'static [usize] = &[];

    /// The parameters that holonomic constraints depend on, by their places: they cannot change during a run.
    const OF_POSITIONS: &'static [usize] = &[];

    /// The parameters inside a `dot(…)`, by their places: their rates are taken to be zero, so they cannot change during a run.
    const OF_RATES: &'static [usize] = &[];

    /// The values of the parameters, in order.
    fn parameters<T: Scalar>(&self) -> Self::Parameters<T>;

    /// Values known when the run begins; `h` is the step.
    fn constants<T: Scalar>(&self, parameters: &Self::Parameters<T>, h: T) -> Self::Constants<T>;

    /// The second difference before that a step of third order goes on from, as [`Compiled::remember`] has set it.
    fn past<T: Scalar>(constants: &Self::Constants<T>) -> [T; N] {
        let _ = constants;
        [T::splat(0.0); N]
    }

    /// Sets the second difference that ends with the middle node of the next step, which a step of third order has to know: it
    /// stands behind the constants. Steps of second order know none.
    fn remember<T: Scalar>(constants: &mut Self::Constants<T>, past: &[T; N]) {
        let _ = (constants, past);
    }

    /// Values known when the step begins.
    fn known<T: Scalar>(&self, constants: &Self::Constants<T>, leg: &Leg<T, N>) -> Self::Known<T>;

    /// The rows of the step at `z`, and their exact Jacobian `∂row/∂z`.
    fn linearize<T: Scalar>(
        &self,
        constants: &Self::Constants<T>,
        known: &Self::Known<T>,
        z: &Self::Unknown<T>,
    ) -> Linearization<T, Self::Unknown<T>>;

    /// The entries of the Jacobian that are not zero everywhere, and the order of their elimination, where [`Compiled::SPARSE`].
    fn sparse(&self) -> Option<&'static Sparse> {
        None
    }

    /// The rows of the step at `z`; `entries` are set to those of [`Compiled::sparse`].
    fn entries<T: Scalar>(
        &self,
        constants: &Self::Constants<T>,
        known: &Self::Known<T>,
        z: &Self::Unknown<T>,
        entries: &mut [T],
    ) -> Self::Unknown<T> {
        let _ = entries;
        self.linearize(constants, known, z).rows
    }

    /// What each row of [`Compiled::linearize`] is, divided by the declared row: denominators that were multiplied out, and
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
    /// Where no fields that span the virtual displacements are known, multipliers `λ_j` of the forms of the constraint forces are
    /// unknown too. Missing ones are zero, and what is beyond the last is left out.
    fn unknown<T: Scalar>(&self, e: &[T; N], multipliers: &[T]) -> Self::Unknown<T>;

    /// The second difference `e = q2 - 2 q1 + q0` that belongs to the unknowns; of third order, by how much it differs from the last one.
    fn second_difference<T: Scalar>(
        &self,
        constants: &Self::Constants<T>,
        known: &Self::Known<T>,
        z: &Self::Unknown<T>,
    ) -> [T; N];

    /// What is told of the middle node of a step.
    fn report<T: Scalar>(
        &self,
        constants: &Self::Constants<T>,
        known: &Self::Known<T>,
        leg: &Leg<T, N>,
        e: &[T; N],
    ) -> Report<T, N>;
}

/// What is told of a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Report<T, const N: usize> {
    /// `φ_{D_K}⁻¹(q0, q1, q2)`: where the kinematic constraints are imposed.
    pub point: Point<T, N>,
    /// The generalized constraint force at `q1`, `Q = -(D₁L_d(q1,q2) + D₂L_d(q0,q1))`, in units of `L` per unit of the coordinate.
    pub force: [T; N],
    /// The energy `⟨∂L/∂v, v⟩ - L` at the point.
    pub energy: T,
}
