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
    /// What the recurrences keep of the orders before.
    type Table<T: Coefficient>: Default + Switches + Send;

    /// What the switches are, as the declaration says it; then the user's functions, in the order of their calls. Those where a smooth
    /// function is steep have no names.
    const SWITCHES: &'static [&'static str] = &[];

    /// What the parameters alone decide.
    fn fixed<T: Coefficient>(&self, parameters: &Self::Parameters<T>) -> Self::Fixed<T>;

    /// The Taylor coefficients of the motion from the point where the series begins.
    fn expand<T: Coefficient, const FUSED: bool>(
        &self,
        constants: &Self::Fixed<T>,
        series: &mut Rows<'_, N, T>,
        table: &mut Self::Table<T>,
    );

    /// Whether [`Jets::phase_slopes`] is generated; where it is not, the tape knows the same.
    const PHASE_SLOPES: bool = false;

    /// What holonomic constraints ask of a position, or all those of lower order of a velocity, and the derivatives by its components, row by
    /// row.
    fn phase_slopes<T: Scalar>(
        &self,
        _of_velocity: bool,
        _parameters: &Self::Parameters<T>,
        _point: (T, &[T; N], &[T; N]),
        _out: &mut [T],
    ) {
    }
}
