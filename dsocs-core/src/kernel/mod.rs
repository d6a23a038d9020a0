//! A declared system as the engine uses it: without its type, on slices.
//!
//! [`Shape`](crate::Shape) has its fixed properties, [`Kernel`] its functions. The attribute implements both
//! through [`compiled`].

pub(crate) mod clock;
pub mod compiled;
pub(crate) mod generated;
pub(crate) mod halt;
pub(crate) mod jets;
pub(crate) mod report;
pub(crate) mod run_state;
pub(crate) mod series;

use crate::kernel::halt::Halt;
use crate::kernel::report::NodeMut;
use crate::kernel::run_state::RunState;
use crate::number::point::AnyLeg;
use crate::solve::sparse::Sparse;
use crate::tape::Source;

/// A declared system without its type: code that is compiled once for all systems takes `&dyn Kernel`, and
/// slices in place of arrays.
///
/// Every declared system is a kernel: pass `&pendulum`, or in code that is generic over a
/// [`System`](crate::System) [`system.kernel()`](crate::System::kernel). The attribute implements the trait.
/// Its methods are those that the engine needs in steps; for your own code there are [`mod@crate::geometry`],
/// [`Regularity`](crate::Regularity) and [`Declaration`](crate::Declaration).
///
/// ```
/// use dsocs_core::prelude::*;
/// use dsocs_core::{Kernel, Leg, Regularity};
///
/// /// A pendulum.
/// #[dsocs {
///     coordinates(theta);
///     lagrangian = dot(theta).powi(2) / 2 + theta.cos();
/// }]
/// struct Pendulum;
///
/// let system: &dyn Kernel = &Pendulum;
/// assert_eq!((system.shape().dimension(), &*system.shape().coordinates[0].name), (1, "theta"));
/// let leg = Leg { t: 0.0, q: [1.0], d: [0.05] };
/// assert!(Regularity::of(system, 0.1, leg.any(), &[-0.008]).grants_flow());
/// ```
///
/// # Arguments
///
/// Vectors are slices of the lengths in [`Shape`](crate::Shape); parameters are values that the caller holds,
/// not the system's own. With a slice of another length the output stays as it was, or becomes NaN; the
/// engine makes all slices from the shape.
pub trait Kernel: Source {
    /// Values known when a run with the step `h` begins: [`Shape::constants`](crate::Shape::constants) numbers.
    fn constants(&self, parameters: &[f64], h: f64, constants: &mut [f64]);

    /// Sets the last second difference, which a step of third order continues; it stands behind the
    /// constants.
    fn remember(&self, constants: &mut [f64], past: &[f64]) {
        let _ = (constants, past);
    }

    /// The last second difference of third order; zero in second order.
    fn past(&self, constants: &[f64], past: &mut [f64]) {
        let _ = constants;
        fill(past, 0.0);
    }

    /// Values known when a step begins: [`Shape::known`](crate::Shape::known) numbers.
    fn known(&self, constants: &[f64], leg: AnyLeg<'_, f64>, known: &mut [f64]);

    /// The rows of a step at the unknowns `z`, and their exact Jacobian `∂row/∂z`, row by row.
    fn linearize(&self, at: At<'_>, rows: &mut [f64], jacobian: &mut [f64]);

    /// The entries of the Jacobian that may be nonzero; `None` if it is dense.
    fn sparse(&self) -> Option<&Sparse> {
        None
    }

    /// The rows of a step, and the entries of the Jacobian that [`Kernel::sparse`] lists.
    fn entries(&self, at: At<'_>, rows: &mut [f64], entries: &mut [f64]) {
        let _ = (at, rows, entries);
    }

    /// The factor of each row, the row over the declared one; ones unless
    /// [`Shape::scaled`](crate::Shape::scaled).
    fn scales(&self, at: At<'_>, scales: &mut [f64]) {
        let _ = at;
        fill(scales, 1.0);
    }

    /// The unknowns of a second difference `e` and of multipliers; missing multipliers are zero.
    fn unknown(&self, e: &[f64], multipliers: &[f64], z: &mut [f64]);

    /// The second difference of the unknowns; in third order, its difference from the last one.
    fn second_difference(&self, at: At<'_>, e: &mut [f64]);

    /// Makes up to `count` steps of a run, as long as they are smooth.
    fn smooth(&self, run_state: &mut RunState, count: u64) -> Halt;

    /// Writes the motion at the middle node of the last solved step: position, velocity and acceleration, the
    /// generalized constraint force (in units of `L` per unit of the coordinate) and the energy. Velocity,
    /// acceleration, force and energy are those at `φ_{D_K}⁻¹(q0, q1, q2)`; the position is the node `q1`,
    /// whatever the maps are.
    fn report(&self, run_state: &RunState, node: NodeMut<'_>);
}

/// Fills a slice; compiled once, not for every system that uses a default.
#[inline(never)]
fn fill(out: &mut [f64], value: f64) {
    out.fill(value);
}

/// The arguments of the rows of a step.
#[derive(Clone, Copy, Debug)]
pub struct At<'a> {
    /// The known values of the run.
    pub constants: &'a [f64],
    /// The known values of the step.
    pub known: &'a [f64],
    /// The unknowns.
    pub z: &'a [f64],
}
