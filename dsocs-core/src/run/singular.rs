//! Steps near a singularity.

/// The steps of a run in which its equations were nearly singular. Their determinant has passed zero in a
/// smooth motion, or falls so fast that it may pass zero within four such steps; or, at the beginning of a
/// run, it has grown by half of itself in the first step, so that the start lies beside a zero.
///
/// There the equations hardly determine the acceleration (in third order the jerk). The motion may be right,
/// for example where a factor of a constraint vanishes that could be divided out. But its error may be larger
/// than elsewhere, and multipliers are inaccurate. A smaller step decides. If no motion leads past a
/// singularity a run ends with [`StepFailure::PassesSingularity`](crate::StepFailure::PassesSingularity).
///
/// If only the equations of the step pass through zero, and not those of the continuous motion, the step is
/// too long for a force that depends on velocity or position, or the velocity grows beyond all bounds: a
/// force `dot(x).powi(3)` makes it infinite in a finite time. The nodes after that are not those of the
/// motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearlySingular {
    /// The number of such steps.
    pub steps: u64,
    /// The time of the middle node of the first of them; for a composed step, of the end of its stage.
    pub first: f64,
    /// The number of those in which only the equations of the step were nearly singular.
    pub of_step: u64,
}

impl NearlySingular {
    /// Counts a step; `of_step` if only the equations of the step were nearly singular.
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
