//! The compiled form of a declaration: the expressions that a run evaluates often, as straight-line code.

use crate::number::array::Array;
use crate::number::point::{Leg, Point};
use crate::number::scalar::Scalar;
use crate::solve::sparse::Sparse;
use crate::solve::unknown::{Linearization, Unknown};
use crate::tape::Source;

/// The functions of a system that the solver needs, beside its tape, as `#[dsocs]` generates them; see
/// [`System`](crate::System) for the equations.
///
/// Expressions of the parameters and `h` alone are computed once a run ([`Compiled::constants`]), those of
/// the leg alone once a step ([`Compiled::known`]), the rest once an iteration. Everything is generic over
/// its number, so that one declaration serves a single trajectory and several in lanes, which may have
/// different parameters.
pub trait Compiled<const N: usize>: Source + Sized {
    /// The values of the parameters, an array of a literal size.
    type Parameters<T: Scalar>: Array<T>;
    /// The unknowns of one step, `[T; M]` for a literal `M`.
    type Unknown<T: Scalar>: Unknown<T> + Array<T>;
    /// The known values of a run, an array of a literal size.
    type Constants<T: Scalar>: Array<T>;
    /// The known values of a step, an array of a literal size.
    type Known<T: Scalar>: Array<T>;
    /// The unknowns of the continuous system: the accelerations, then the multipliers if there are any.
    type Motion: Unknown<f64> + Array<f64>;

    /// Whether every row of [`Compiled::linearize`] is affine in the unknowns, between its jumps if it has any: without jumps, one update solves
    /// the step.
    const LINEAR: bool = false;

    /// Whether a row may jump where an unknown changes, as with the sign of the next velocity: the rows may have no root but that jump.
    const JUMPS: bool = false;

    /// Whether a row has a `signum` or a comparison that depends on positions or velocities: a step across
    /// its jump has a lower order.
    const PIECEWISE: bool = false;

    /// Whether an expression is piecewise or has a divisor that may vanish, depending on the motion or on
    /// time: its arguments are watched.
    const SWITCHING: bool = false;

    /// Whether rows were multiplied by a factor that is not a number (see [`Compiled::scales`]).
    const SCALED: bool = false;

    /// Whether the declaration names a factor to be divided out of a row. Then it has chosen a root, and
    /// steps are not watched for a second one nearby.
    const DIVIDED: bool = false;

    /// Whether the Jacobian has so many zeros that it is eliminated as a sparse matrix.
    const SPARSE: bool = false;

    /// The places of the constraints of third order among all constraints.
    const THIRD_ORDER: &'static [usize] = &[];

    /// The first of the four places of each coordinate that is a rotation.
    const ROTATIONS: &'static [usize] = &[];

    /// The places of the parameters that holonomic constraints depend on: these parameters cannot change
    /// during a run.
    const OF_POSITIONS: &'static [usize] = &[];

    /// The places of the parameters inside a `dot(…)`: their rates are taken to be zero, so they cannot
    /// change during a run.
    const OF_RATES: &'static [usize] = &[];

    /// The values of the parameters, in order.
    fn parameters<T: Scalar>(&self) -> Self::Parameters<T>;

    /// Values known when the run begins; `h` is the step.
    fn constants<T: Scalar>(&self, parameters: &Self::Parameters<T>, h: T) -> Self::Constants<T>;

    /// The last second difference, which a step of third order continues, as set by [`Compiled::remember`].
    fn past<T: Scalar>(constants: &Self::Constants<T>) -> [T; N] {
        let _ = constants;
        [T::splat(0.0); N]
    }

    /// Sets the second difference that ends with the middle node of the next step, which a step of third
    /// order needs: it stands behind the constants. Steps of second order ignore it.
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

    /// The entries of the Jacobian that may be nonzero, and the order of their elimination, if
    /// [`Compiled::SPARSE`].
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

    /// The factor of each row of [`Compiled::linearize`], the row over the declared one: denominators that
    /// were multiplied out, and dropped factors of the parameters and of `h`.
    ///
    /// Where a factor vanishes the declared row is undefined, or zero for all unknowns: a root there is not
    /// accepted.
    fn scales<T: Scalar>(
        &self,
        constants: &Self::Constants<T>,
        known: &Self::Known<T>,
        z: &Self::Unknown<T>,
    ) -> Self::Unknown<T> {
        let _ = (constants, known);
        z.zip(z, |_, _| T::splat(1.0))
    }

    /// The unknowns of a second difference `e` and of multipliers (the starting point of Newton's iteration).
    ///
    /// If no fields that span the virtual displacements are known, the multipliers `λ_j` of the constraint
    /// forms are unknowns, too. Missing ones are zero, surplus ones are ignored.
    fn unknown<T: Scalar>(&self, e: &[T; N], multipliers: &[T]) -> Self::Unknown<T>;

    /// The second difference `e = q2 - 2 q1 + q0` of the unknowns; in third order, its difference from the
    /// last one.
    fn second_difference<T: Scalar>(
        &self,
        constants: &Self::Constants<T>,
        known: &Self::Known<T>,
        z: &Self::Unknown<T>,
    ) -> [T; N];

    /// The motion at the middle node of a step.
    fn report<T: Scalar>(
        &self,
        constants: &Self::Constants<T>,
        known: &Self::Known<T>,
        leg: &Leg<T, N>,
        e: &[T; N],
    ) -> Report<T, N>;
}

/// The motion at a node: point, constraint force and energy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Report<T, const N: usize> {
    /// `φ_{D_K}⁻¹(q0, q1, q2)`, the point at which the kinematic constraints are imposed.
    pub point: Point<T, N>,
    /// The generalized constraint force at `q1`, `Q = -(D₁L_d(q1,q2) + D₂L_d(q0,q1))`, in units of `L` per unit of the coordinate.
    pub force: [T; N],
    /// The energy `⟨∂L/∂v, v⟩ - L` at the point.
    pub energy: T,
}
