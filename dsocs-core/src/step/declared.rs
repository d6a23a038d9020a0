//! The trait of systems for smooth steps on arrays, and its implementation for declared types.

#![allow(clippy::inline_always)] // parts of every step

use crate::number::array::Array;
use crate::number::point::Leg;
use crate::solve::Numbers;
use crate::solve::elimination::Determinant;
use crate::solve::newton::{Evaluation, Iterate};
use crate::solve::sparse::{Product, Update};
use crate::solve::unknown::{Linearization, Unknown};
use crate::system::System;

/// A system as smooth steps use it, with numbers of coordinates and unknowns that are known at compile time.
pub(crate) trait Smooth<const N: usize> {
    /// The unknowns of a step.
    type Unknown: Unknown<f64> + Array<f64>;
    /// Known values of a run.
    type Constants: ?Sized;
    /// Known values of a step.
    type Known;

    /// Whether the rows are affine in the unknowns, between their jumps if they have any.
    fn has_affine_rows(&self) -> bool;

    /// Whether a row may jump where an unknown changes.
    fn may_jump(&self) -> bool;

    /// Whether the declaration names a factor to be divided out of a row.
    fn is_divided(&self) -> bool;

    /// Whether rows were multiplied by a factor that is not a number.
    fn is_scaled(&self) -> bool;

    /// Whether an expression is piecewise, or divided by one that may be zero.
    fn is_switching(&self) -> bool;

    /// Whether any expression depends on time.
    fn asks_for_time(&self) -> bool;

    /// Whether a constraint is of third order.
    fn is_of_third_order(&self) -> bool;

    /// Whether external forces act.
    fn is_forced(&self) -> bool;

    /// The first of the four places of each coordinate that is a rotation.
    fn rotations(&self) -> &[usize];

    /// The constants in the known values of a run; `None` if they belong to another system.
    fn constants_of<'c>(&self, run: &'c mut Numbers) -> Option<&'c mut Self::Constants>;

    /// Sets the last second difference, which a step of third order continues.
    fn set_past(&self, constants: &mut Self::Constants, past: &[f64; N]);

    /// The known values of a step, from its leg.
    fn known_of(&self, constants: &Self::Constants, leg: &Leg<f64, N>) -> Self::Known;

    /// The rows and Newton's update.
    fn evaluation(
        &self,
        constants: &Self::Constants,
        known: &Self::Known,
        z: Self::Unknown,
    ) -> Evaluation<Self::Unknown>;

    /// The factor of each row: the row over the declared one.
    fn row_scales(
        &self,
        constants: &Self::Constants,
        known: &Self::Known,
        z: &Self::Unknown,
    ) -> Self::Unknown;

    /// The unknowns that belong to a second difference, without multipliers.
    fn unknown_of(&self, e: &[f64; N]) -> Self::Unknown;

    /// The second difference that belongs to the unknowns.
    fn difference(&self, constants: &Self::Constants, known: &Self::Known, z: &Self::Unknown) -> [f64; N];
}

impl<S: System<N>, const N: usize> Smooth<N> for S {
    type Unknown = S::Unknown<f64>;
    type Constants = S::Constants<f64>;
    type Known = S::Known<f64>;

    #[inline(always)]
    fn has_affine_rows(&self) -> bool {
        S::LINEAR
    }

    #[inline(always)]
    fn may_jump(&self) -> bool {
        S::JUMPS
    }

    #[inline(always)]
    fn is_divided(&self) -> bool {
        S::DIVIDED
    }

    #[inline(always)]
    fn is_scaled(&self) -> bool {
        S::SCALED
    }

    #[inline(always)]
    fn is_switching(&self) -> bool {
        S::SWITCHING
    }

    #[inline(always)]
    fn asks_for_time(&self) -> bool {
        S::DEPENDS_ON_TIME
    }

    #[inline(always)]
    fn is_of_third_order(&self) -> bool {
        S::ORDER > 2
    }

    #[inline(always)]
    fn rotations(&self) -> &[usize] {
        S::ROTATIONS
    }

    #[inline(always)]
    fn is_forced(&self) -> bool {
        S::EXTERNAL_FORCES
    }

    #[inline(always)]
    fn constants_of<'c>(&self, run: &'c mut Numbers) -> Option<&'c mut S::Constants<f64>> {
        let (constants, _) = <S::Constants<f64> as Array<f64>>::split(run)?;
        Some(constants)
    }

    #[inline(always)]
    fn set_past(&self, constants: &mut S::Constants<f64>, past: &[f64; N]) {
        S::remember(constants, past);
    }

    #[inline(always)]
    fn known_of(&self, constants: &S::Constants<f64>, leg: &Leg<f64, N>) -> S::Known<f64> {
        self.known(constants, leg)
    }

    #[inline(always)]
    fn evaluation(
        &self,
        constants: &S::Constants<f64>,
        known: &S::Known<f64>,
        z: S::Unknown<f64>,
    ) -> Evaluation<S::Unknown<f64>> {
        if const { S::SPARSE } {
            return sparse_evaluation(self, constants, known, z);
        }
        // in place: a copy of the matrix of a large system would take much of the stack
        evaluated(
            z,
            &mut self.linearize(constants, known, &z),
            S::LINEAR && !S::JUMPS,
        )
    }

    #[inline(always)]
    fn row_scales(
        &self,
        constants: &S::Constants<f64>,
        known: &S::Known<f64>,
        z: &S::Unknown<f64>,
    ) -> S::Unknown<f64> {
        self.scales(constants, known, z)
    }

    #[inline(always)]
    fn unknown_of(&self, e: &[f64; N]) -> S::Unknown<f64> {
        self.unknown(e, &[])
    }

    #[inline(always)]
    fn difference(
        &self,
        constants: &S::Constants<f64>,
        known: &S::Known<f64>,
        z: &S::Unknown<f64>,
    ) -> [f64; N] {
        self.second_difference(constants, known, z)
    }
}

/// The rows and Newton's update by dense elimination. The Jacobian is destroyed.
#[inline(always)]
pub(crate) fn evaluated<U: Unknown<f64>>(
    z: U,
    linearization: &mut Linearization<f64, U>,
    are_linear: bool,
) -> Evaluation<U> {
    let rows = linearization.rows;
    let (update, safe, determinant) = if are_linear {
        // a single update solves linear rows: it has to be accurate
        let (update, determinant) = linearization.update_and_determinant();
        (update.unwrap_or(rows), update.is_some(), determinant)
    } else {
        linearization.quick_update()
    };
    Evaluation {
        at: Iterate { z, rows, update },
        safe,
        determinant,
    }
}

/// The rows and Newton's update by sparse elimination; not `safe` if the update is inaccurate.
#[inline(always)]
fn sparse_evaluation<S: System<N>, const N: usize>(
    system: &S,
    constants: &S::Constants<f64>,
    known: &S::Known<f64>,
    z: S::Unknown<f64>,
) -> Evaluation<S::Unknown<f64>> {
    let Some(sparse) = system.sparse() else {
        let (rows, update) = (z, z);
        return Evaluation {
            at: Iterate { z, rows, update },
            safe: false,
            determinant: Determinant::UNKNOWN,
        };
    };
    let mut product = Product::new(sparse.is_odd());
    let Update { rows, update } = sparse.update(
        |entries| system.entries(constants, known, &z, entries),
        |pivot| product.take(pivot),
    );
    Evaluation {
        safe: update.as_ref().iter().all(|x| x.is_finite()),
        at: Iterate { z, rows, update },
        determinant: product.value(),
    }
}
