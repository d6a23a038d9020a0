//! The format of a tape: which segments it has, and what their expressions are made of.

/// The first byte of a tape.
pub(crate) const VERSION: u8 = 6;

/// What an expression is made of in the end, besides numbers.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Leaf {
    /// A coordinate (kind 0).
    Q(usize),
    /// A velocity (1).
    V(usize),
    /// An acceleration (2).
    A(usize),
    /// A coordinate of a step's middle node (3).
    N(usize),
    /// A component of the increment that led to it (4).
    D(usize),
    /// A component of the second difference, or of the third where constraints are of third order (5).
    E(usize),
    /// An unknown of the step (6).
    Z(usize),
    /// A multiplier (7).
    Lambda(usize),
    /// The step (8).
    H,
    /// A parameter (9).
    Parameter(usize),
    /// Time (10).
    T,
    /// The time of a step's middle node (11).
    Clock,
    /// A component of the second difference before, where constraints are of third order (12).
    P(usize),
    /// A third derivative (13).
    J(usize),
    /// The side of a function that jumps with the velocity, a number between -1 and 1 (14).
    Side(usize),
    /// A result of [`Segment::Constants`], in a program to which these are handed.
    Constant(usize),
    /// A result of [`Segment::Known`], in a program to which these are handed.
    Known(usize),
}

/// What a tape computes, in the order in which it stands there.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Segment {
    /// What is known when the run begins, as [`Compiled::constants`](crate::kernel::generated::Compiled::constants).
    Constants,
    /// What is known when the step begins, as [`Compiled::known`](crate::kernel::generated::Compiled::known).
    Known,
    /// The rows of the step, then their Jacobian by the unknowns, row by row.
    Residual,
    /// What each row is, divided by the declared one.
    Scales,
    /// The second difference that belongs to the unknowns.
    SecondDifference,
    /// The unknowns that belong to a second difference and multipliers.
    Unknown,
    /// Position, velocity, acceleration and time of a node; then the constraint force there.
    Node,
    /// The forms of the constraint forces of a step, one after the other.
    Forms,
    /// The rows of the continuous system, then their Jacobian by accelerations and multipliers, row by row.
    Continuous,
    /// The constraint force of the continuous system.
    ContinuousForce,
    /// The forms of the constraint forces of the continuous system.
    ContinuousForms,
    /// What constraints of lower order ask of a position and a velocity.
    Phase,
    /// What they ask of a leg.
    Pair,
    /// The Lagrangian.
    Lagrangian,
    /// The discrete Lagrangian on a leg.
    DiscreteLagrangian,
    /// The energy.
    Energy,
    /// The observed expressions.
    Observe,
    /// The rows of a step as they were declared.
    Declared,
    /// The external forces.
    ExternalForces,
    /// Those on the first node of a leg, then those on the second.
    DiscreteExternalForces,
    /// The momentum with which a leg arrives at its second node.
    Arriving,
    /// The fields that span the virtual displacements of a step, one after the other.
    Fields,
    /// What is to be divided out of each kinematic row of a step.
    Factors,
    /// What constraints of lower order ask of a position, and the derivatives by its components, row by row; then what they ask of
    /// a velocity, and the derivatives by its components.
    PhaseSlopes,
    /// The arguments of functions that jump with the velocity.
    Sides,
    /// The rows of a step as they were declared, with sides in the place of signs; then the constraint force.
    Sided,
    /// The rows of the continuous system in the same way; then its constraint force.
    SidedContinuous,
    /// The arguments of whatever is given by pieces, and what is divided by: first those of [`Segment::Sides`].
    Switches,
    /// Of each table of samples the number of its call, 1 if it is differentiated, else 0, and its argument.
    Tables,
}

/// How many segments a tape has.
pub(crate) const SEGMENTS: usize = Segment::Tables as usize + 1;

/// Which of a segment's results are wanted: those of rows without their Jacobian, of a point without the force, or the rest.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Part {
    /// All results.
    All,
    /// The first results: rows, or a point.
    Head,
    /// The results after them: a Jacobian, or a force.
    Tail,
}

/// How many parts of a segment there are.
pub(super) const PARTS: usize = Part::Tail as usize + 1;
