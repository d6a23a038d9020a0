//! Steps that were too long for jumps or steep changes.

/// The steps of a run that were too long for jumps or steep changes in them. Each reduces the order of the
/// run, to 1 at a jump.
///
/// - The arguments of piecewise functions (a `signum`, a comparison, an absolute value), and divisors, are watched on the
///   path of each step; so are the rates of the arguments of `sqrt`, `asin` and `acos`, and the ordinates of `atan2`, which
///   show corners and jumps of these functions. If one changes its sign, the accelerations (in third order also the jerks)
///   on both sides of the place are compared. If the acceleration jumps by more than a thousandth of itself, or by half of
///   itself within a sixteenth of the path, the step is counted; a corner does not lower the order, and is not counted.
///   [`Unresolved::largest`] is infinite if the acceleration grows without bound, as at a pole, or if the velocity has to
///   jump, as at a step of the potential: there the motion ends, or depends on the places of the nodes.
/// - Where a root is zero, as that of an absolute value, or a power below 1, the acceleration does not jump, but its rate has
///   no bound: the error of the motion is of the order `1 + p` at a power `p`. The step is counted if the acceleration changes by more than a
///   thousandth of itself within a quarter of the path.
/// - Functions that are only steep, and the user's functions, are examined in steps that differ from their prediction. If an
///   external force deviates there from the straight line between its values on the two legs by more than a tenth of the
///   change of the momentum over the step, or of the force if that is larger, the step is counted. It is not counted if the
///   force is nearly straight within a quarter of the step, as one that grows from nothing, or close to a polynomial of
///   degree 5, as at a multiple zero. A [`ComposedFlow`](crate::ComposedFlow) examines accelerations in this way. So a pulse
///   in a user's function between two of the examined places may be missed.
///
/// The usual case is dry friction that changes its direction within a step, on a surface that does not move. The nodes still obey the discrete
/// equations, and the run goes on. If these have no solution, because a function jumps over it, the node is that of the jump, and the step
/// is counted, too ([`Stop::Jump`](crate::Stop::Jump)). Steps in which friction stops a mass, holds it
/// ([`Stop::Sticks`](crate::Stop::Sticks)) or releases it are not counted, nor are those in which it changes its direction on a surface that
/// moves, since they do not lower the order: the forces before and after the event act on their parts of the step. They are counted if another
/// function jumps in them, such as a force whose jump releases the mass.
///
/// Three things help: a smaller step, a function that changes more smoothly, or [`TaylorFlow`](crate::TaylorFlow), whose steps end at the jump.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unresolved {
    /// The number of such steps.
    pub steps: u64,
    /// The time of the middle node of the first of them.
    pub first: f64,
    /// The largest jump, relative to the acceleration, or deviation from the straight line, relative to the change of the
    /// momentum over the step \[1\]; infinite where no motion continues, or the velocity has to jump.
    pub largest: f64,
    /// The time of the middle node of the step with the largest jump or deviation, the first of these if there are several.
    pub largest_at: f64,
}

impl Unresolved {
    /// Counts a step by the time of its middle node, with its jump or deviation.
    pub(crate) fn count(counted: &mut Option<Self>, time: f64, part: f64) {
        let counted = counted.get_or_insert(Self {
            steps: 0,
            first: time,
            largest: 0.0,
            largest_at: time,
        });
        counted.steps += 1;
        counted.take_larger(part, time);
    }

    /// Adds the steps of a later run.
    pub(crate) fn add(counted: &mut Option<Self>, other: Self) {
        let counted = counted.get_or_insert(Self { steps: 0, ..other });
        counted.steps += other.steps;
        counted.take_larger(other.largest, other.largest_at);
    }

    /// Takes a jump or deviation, if it is larger than those before.
    fn take_larger(&mut self, part: f64, time: f64) {
        if part > self.largest {
            (self.largest, self.largest_at) = (part, time);
        }
    }
}
