//! Steps that were too long.

/// The steps of a run that were too long for what switches in them. Each reduces the order of the run to 1.
///
/// - The arguments of what is given by pieces (a `signum`, a comparison, an absolute value), and what is divided by, are watched on the way of each step; and
///   the rates of what `sqrt`, `asin` and `acos` are taken of, and the ordinates of `atan2`, which tell of corners and jumps that these have.
///   Where one changes its sign, the acceleration, of third order also the jerk, is compared on both sides of the place. If it jumps by more than a
///   thousandth of itself, or by half of itself within a sixteenth of the way, the step is counted; a corner costs no order, and is not. [`Unresolved::largest`] is infinite where the acceleration grows without bound, as at a pole, and
///   where the velocity has to jump, as at a step of the potential: there the motion ends, or depends on where the nodes lie.
/// - What is only steep, or a function of the user's, is looked at in steps that differ from their prediction. If an external force departs there from the
///   straight line between its values on the two legs by more than a tenth of the change of the momentum over the step, or of the force if that is larger,
///   the step is counted. Not so what is nearly straight within a quarter of the step, as a force that grows from nothing, or nearly a polynomial of the
///   fifth degree, as where it has a multiple zero. A [`ComposedFlow`](crate::ComposedFlow) looks at accelerations in this way. So a pulse in a function
///   of the user's that lies between two places may be missed.
///
/// The usual case is dry friction that changes its direction within a step. The nodes still obey the discrete equations, and the run goes on. Where these
/// have no solution, because a function jumps over it, the node is that of the jump, and the step is counted, too ([`Stop::Jump`](crate::Stop::Jump)). Steps
/// in which friction stops a mass, holds it ([`Stop::Sticks`](crate::Stop::Sticks)) or lets it go are not counted, since they cost no order: what acts
/// before the event and after it has its part of the step. They are counted if anything else jumps in them, as a force that lets the mass go by its jump.
///
/// Three things help: a smaller step, a function that changes more smoothly, or [`TaylorFlow`](crate::TaylorFlow), whose steps end at the jump.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unresolved {
    /// How many steps.
    pub steps: u64,
    /// The time of the middle node of the first of them.
    pub first: f64,
    /// The largest jump, relative to the acceleration, or departure from the straight line, relative to the change of the momentum over the step \[1\]; infinite
    /// where no motion goes on, or the velocity has to jump.
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
