//! Steps near a singularity.

/// The steps of a run in which its equations were nearly singular: their determinant has passed zero in a smooth motion, or falls so
/// fast that it may pass zero in four such steps; or, where a run begins, it has grown by half of itself in the first step, so that the start lies
/// beside a place where it is zero.
///
/// There the equations hardly determine the acceleration, of third order the jerk. The motion may be right, as where a factor of a constraint vanishes
/// that might be divided out; its error may also be larger than that of the step elsewhere, and what is told of multipliers is uncertain. A smaller step decides. Where no motion
/// leads past a singularity a run ends with [`StepFailure::PassesSingularity`](crate::StepFailure::PassesSingularity).
///
/// Where the equations of the step pass through zero alone, and those of the continuous motion do not, the step is too long for a force that changes with the
/// velocity or the position, or the velocity grows beyond all bounds: a force `dot(x).powi(3)` makes it infinite in a finite time. What comes
/// after is then not the motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearlySingular {
    /// How many steps.
    pub steps: u64,
    /// The time of the middle node of the first of them; of a composed step, of the end of its stage.
    pub first: f64,
    /// In how many of them it was the equations of the step alone.
    pub of_step: u64,
}

impl NearlySingular {
    /// Counts a step, and whether it was the equations of the step alone.
    pub(crate) fn count(counted: &mut Option<Self>, time: f64, of_step: bool) {
        let counted = counted.get_or_insert(Self {
            steps: 0,
            first: time,
            of_step: 0,
        });
        counted.steps += 1;
        counted.of_step += u64::from(of_step);
    }
}
