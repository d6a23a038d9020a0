//! How a run of smooth steps ends, and why.

/// How a run of smooth steps has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Halt {
    /// All steps were made.
    Done,
    /// The next step asks something first; those before it were made.
    Asks(Question),
}

/// Why a step is not made by the code that is compiled for the declared type: its equations are looked at as a whole, and then smooth steps go on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Question {
    /// There is no past to predict the step by, or its second difference is given.
    Start,
    /// Three iterations of Newton's have not settled, or what the rows were multiplied by degenerates at their root.
    Unsettled,
    /// The determinant of the Jacobian has become small, or large, or has passed zero: the equations may be singular on the way of the step.
    Varies,
    /// The determinant of the Jacobian departs from its continuation: the root may be another motion's.
    Departs,
    /// The rows bend so much on the way to the root that another root may be near.
    Bends,
    /// The root leads to no finite node.
    NotFinite,
    /// The solution was not foreseen, where a force or a row may jump: the step may be too long for it.
    Unforeseen,
    /// An argument of what is given by pieces may change its sign, or something rests where a function jumps with the velocity, or may do so soon.
    Sides,
    /// An input changes at the middle node.
    InputChanges,
}
