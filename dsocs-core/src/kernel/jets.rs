//! The recurrences that the attribute generates for a system.

use crate::kernel::generated::Compiled;
use crate::number::scalar::Scalar;
use crate::series::coefficient::Coefficient;
use crate::series::rows::Rows;
use crate::series::switch::Switches;

/// The recurrences for the Taylor series of the continuous motion, as `#[dsocs]` generates them.
pub trait Jets<const N: usize>: Compiled<N> {
    /// Expressions of the parameters, an array of a literal size.
    type Fixed<T: Coefficient>: Copy + Send;
    /// The coefficients of the lower orders that the recurrences need.
    type Table<T: Coefficient>: Default + Switches + Send;

    /// The switching arguments as the declaration writes them; then the user's functions, in the order of
    /// their calls. Arguments of steep smooth functions have empty names.
    const SWITCHES: &'static [&'static str] = &[];

    /// The expressions of the parameters alone.
    fn fixed<T: Coefficient>(&self, parameters: &Self::Parameters<T>) -> Self::Fixed<T>;

    /// The Taylor coefficients of the motion from the point where the series begins.
    fn expand<T: Coefficient, const FUSED: bool>(
        &self,
        constants: &Self::Fixed<T>,
        series: &mut Rows<'_, N, T>,
        table: &mut Self::Table<T>,
    );

    /// Whether [`Jets::phase_slopes`] is generated; if not, the tape gives the same.
    const PHASE_SLOPES: bool = false;

    /// The rows of the holonomic constraints at a position, or of all constraints of lower order at a
    /// velocity, and their derivatives by its components, row by row.
    fn phase_slopes<T: Scalar>(
        &self,
        _of_velocity: bool,
        _parameters: &Self::Parameters<T>,
        _point: (T, &[T; N], &[T; N]),
        _out: &mut [T],
    ) {
    }
}
