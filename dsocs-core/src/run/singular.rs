//! Steps near a singularity.

/// The steps of a run in which its equations were nearly singular: their determinant has passed zero in a smooth motion, or falls so
/// fast that it may pass zero in four such steps; or, where a run begins, it has grown by half of itself in the first step, so that the start lies
/// beside a place where it is zero.
///
/// There the equations hardly determine the acceleration. The motion may be right, as where a factor of a constraint vanishes that might be divided out;
/// its error may also be larger than that of the step elsewhere, and what is told of multipliers is uncertain. A smaller step decides. Where no motion
/// leads past a singularity a run ends with [`StepFailure::PassesSingularity`](crate::StepFailure::PassesSingularity).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearlySingular {
    /// How many steps.
    pub steps: u64,
    /// The time of the middle node of the first of them; of a composed step, of the end of its stage.
    pub first: f64,
}

impl NearlySingular {
    /// Counts a step.
    pub(crate) fn count(counted: &mut Option<Self>, time: f64) {
        counted
            .get_or_insert(Self {
                steps: 0,
                first: time,
            })
            .steps += 1;
    }
}
