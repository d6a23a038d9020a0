//! The end of a series of smooth steps, and its reason.

/// The end of a series of smooth steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Halt {
    /// All steps were made.
    Done,
    /// The next step cannot be smooth, for this reason; those before it were made.
    NotSmooth(HaltReason),
}

/// The reason why the smooth code of the declared type does not make a step. Its equations are then solved on slices, and smooth steps go on
/// after it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HaltReason {
    /// There is no past for a prediction, or the second difference is given.
    Start,
    /// Three iterations of Newton's have not converged, or a row's factor vanishes at their root.
    NotConverged,
    /// The determinant of the Jacobian has become small, or large, or has passed zero: the equations may be
    /// singular during the step.
    DeterminantChanges,
    /// The determinant of the Jacobian departs from its extrapolation: the root may belong to another motion.
    Departs,
    /// The rows are so nonlinear on the way to the root that another root may be near.
    Nonlinear,
    /// The next node that belongs to the root is not finite.
    NotFinite,
    /// The solution differs from its prediction, and a force or a row may jump: the step may be too long for
    /// the jump.
    Unforeseen,
    /// The argument of a piecewise function may change its sign, or a body rests, or may soon rest, where a
    /// function jumps with the velocity.
    RestOrSignChange,
    /// An input changes at the middle node.
    InputChanges,
}
