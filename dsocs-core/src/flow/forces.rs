//! Multipliers at a node of a run: the constraint force, constraint by constraint.

use crate::run::Node;
use crate::system::System;
use crate::tape::declaration::Declaration;

/// The multipliers `λ` at a node of any run of the system, one for each constraint. With them the constraint force is
/// `Q = Σ λ_j α_j`, where `α_j` is the declared form or the form of the constraint's rule (d'Alembert's, Chetaev's). The unit of `λ_j`
/// is that of `L` divided by that of the constraint. For `constraint_forces = [(0, 1)]` the multiplier is the motor's torque.
///
/// The result is empty if the declaration gives the virtual displacements by fields. The forms are those at the node's position, velocity
/// and acceleration.
///
/// It needs no run, so it can be called during one:
///
/// ```
/// use dsocs_core::{multipliers, prelude::*};
///
/// /// A mass on a rod.
/// #[dsocs {
///     coordinates(x, y);
///     lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - 9.81 * y;
///     holonomic = (x.powi(2) + y.powi(2)).sqrt() - 1;
/// }]
/// struct Rod;
///
/// let mut flow = Flow::new(&Rod, 0.01, Start::second_order([0.0, -1.0], [0.0, 0.0]))?;
/// flow.stream(1.0, &mut |node: &Node<2>| {
///     // the rod pulls with the weight
///     assert!((multipliers(&Rod, node)[0] + 9.81).abs() < 1e-9);
/// })?;
/// # Ok::<(), RunError>(())
/// ```
#[must_use]
pub fn multipliers<S: System<N>, const N: usize>(system: &S, node: &Node<N>) -> Vec<f64> {
    Declaration::of(system).multipliers(&node.any())
}
