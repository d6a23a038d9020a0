//! Steps that were too long.

/// The steps of a run that were too long for what switches in them. In such a step, an external force departs from the straight line between its
/// values on the two legs. The step is counted if this departure is more than a tenth of the change of the momentum over the step, or of the force
/// if that is larger, and if it is left within a quarter of the step: a smooth force is nearly straight there, also where it grows from nothing. If a constraint or the Lagrangian has a `signum` or a comparison, the step is also counted if the acceleration jumps by more than
/// a tenth of itself; and if the velocity changes by a tenth of itself although no acceleration explains it. Each such step reduces the
/// order of the run to 1, and a velocity that jumps makes the motion depend on where the nodes lie.
///
/// Dry friction is an exception, and any `signum` or comparison of an argument with velocities in forces, kinematic constraints and the directions of
/// constraint forces: where it changes its direction in a step or stops a mass ([`Stop::Jump`](crate::Stop::Jump)), the step is counted, too, but takes
/// the place of the change into account, and the order stays 2. Steps in which it holds a mass ([`Stop::Sticks`](crate::Stop::Sticks)) are not counted.
/// Where the equations of a step have no solution, because another function jumps over it, the node is that of the jump, and the step is counted.
///
/// Three things help: a smaller step, a function that changes more smoothly, or [`TaylorFlow`](crate::TaylorFlow), whose steps end at the jump, unless the motion
/// sticks there. What switches is evaluated at some places between the legs, and only in steps that differ from their prediction. So a pulse
/// shorter than a quarter of a step may be missed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unresolved {
    /// How many steps.
    pub steps: u64,
    /// The time of the middle node of the first of them.
    pub first: f64,
    /// The largest departure from the straight line, relative to the change of the momentum over the step, or to the acceleration \[1\].
    pub largest: f64,
}
