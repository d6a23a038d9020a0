//! Steps that were too long.

/// The steps of a run that were too long for what switches in them. In such a step, an external force departs from the straight line between its
/// values on the two legs. The step is counted if this departure is more than a tenth of the change of the momentum over the step, or of the force
/// if that is larger, and if it is left within a quarter of the step: a smooth force is nearly straight there, also where it grows from nothing,
/// or it is nearly a polynomial of the fifth degree, as where it has a multiple zero. If a constraint or the Lagrangian has a `signum` or a comparison, the step is also counted if the acceleration jumps by more than
/// a tenth of itself; and if the velocity changes by a tenth of itself although no acceleration explains it. Each such step reduces the
/// order of the run to 1, and a velocity that jumps makes the motion depend on where the nodes lie.
///
/// The usual case is dry friction that changes its direction within a step. The nodes still obey the discrete equations, and the run goes on. Where these
/// have no solution, because a function jumps over it, the node is that of the jump, and the step is counted, too ([`Stop::Jump`](crate::Stop::Jump)). Steps
/// in which friction stops a mass, holds it ([`Stop::Sticks`](crate::Stop::Sticks)) or lets it go are not counted, since they cost no order: what acts
/// before the event and after it has its part of the step. They are counted if anything else jumps in them, as a force that lets the mass go by its jump.
///
/// A [`ComposedFlow`](crate::ComposedFlow) looks at accelerations: a step is counted if one jumps in it by more than a tenth of itself.
///
/// Three things help: a smaller step, a function that changes more smoothly, or [`TaylorFlow`](crate::TaylorFlow), whose steps end at the jump. What switches is evaluated at some places between the legs, and only in steps that differ from their prediction. So a pulse
/// that lies between two of these places may be missed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unresolved {
    /// How many steps.
    pub steps: u64,
    /// The time of the middle node of the first of them.
    pub first: f64,
    /// The largest departure from the straight line, relative to the change of the momentum over the step, or to the acceleration \[1\].
    pub largest: f64,
}

impl Unresolved {
    /// Counts a step with a middle node at a time, and how far it departs or jumps.
    pub(crate) fn count(counted: &mut Option<Self>, time: f64, part: f64) {
        let counted = counted.get_or_insert(Self {
            steps: 0,
            first: time,
            largest: 0.0,
        });
        counted.steps += 1;
        counted.largest = counted.largest.max(part);
    }

    /// Adds the steps of another run, which came later.
    pub(crate) fn add(counted: &mut Option<Self>, other: Self) {
        let counted = counted.get_or_insert(Self { steps: 0, ..other });
        counted.steps += other.steps;
        counted.largest = counted.largest.max(other.largest);
    }
}
