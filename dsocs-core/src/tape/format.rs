//! The format of a tape: its segments, and the leaves of their expressions.

/// The first byte of a tape.
pub(crate) const VERSION: u8 = 8;

/// A leaf of an expression that is not a number; the kinds have numbers in the format.
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
    /// A component of the increment that led to the middle node (4).
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
    /// In third order, a component of the last second difference (12).
    P(usize),
    /// A third derivative (13).
    J(usize),
    /// The side of a function that jumps with the velocity, a number between -1 and 1 (14).
    Side(usize),
    /// A result of [`Segment::Constants`], in a program that receives these as inputs.
    Constant(usize),
    /// A result of [`Segment::Known`], in a program that receives these as inputs.
    Known(usize),
}

/// The segments of a tape, in their order.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Segment {
    /// The constants of a run, as [`Compiled::constants`](crate::kernel::generated::Compiled::constants).
    Constants,
    /// The known values of a step, as [`Compiled::known`](crate::kernel::generated::Compiled::known).
    Known,
    /// The rows of the step, then their Jacobian by the unknowns, row by row.
    Residual,
    /// The factor of each row, the row over the declared one.
    Scales,
    /// The second difference of the unknowns.
    SecondDifference,
    /// The unknowns of a second difference and multipliers.
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
    /// The rows of the constraints of lower order at a position and a velocity.
    Phase,
    /// Their rows on a leg.
    Pair,
    /// The Lagrangian.
    Lagrangian,
    /// The discrete Lagrangian on a leg.
    DiscreteLagrangian,
    /// The energy.
    Energy,
    /// The observed expressions.
    Observe,
    /// The rows of a step as declared.
    Declared,
    /// The external forces.
    ExternalForces,
    /// The external forces on the first node of a leg, then those on the second.
    DiscreteExternalForces,
    /// The momentum of a leg at its second node.
    Arriving,
    /// The fields that span the virtual displacements of a step, one after the other.
    Fields,
    /// The factor to be divided out of each kinematic row of a step.
    Factors,
    /// The rows of the holonomic constraints at a position and their derivatives by its components, row by
    /// row; then those of all constraints of lower order by the velocity.
    PhaseSlopes,
    /// The arguments of functions that jump with the velocity.
    Sides,
    /// The rows of a step as declared, with given values in place of signs; then the constraint force.
    Sided,
    /// The rows of the continuous system with given values in place of signs; then its constraint force and the
    /// forms.
    SidedContinuous,
    /// The arguments of all piecewise functions, and the divisors; first the arguments of [`Segment::Sides`].
    Switches,
    /// For each table of samples: the number of its call, 1 if it is differentiated and 0 if not, and its
    /// argument.
    Tables,
    /// For each function that may be flat but for a narrow feature: 0 and the argument of `exp`, `exp_m1`, `sinh`,
    /// `cosh` or `tanh`, or the exponent and the base of a power.
    Steep,
}

/// The number of segments.
pub(crate) const SEGMENTS: usize = Segment::Steep as usize + 1;

/// A part of a segment's results: for example the rows without their Jacobian, or a point without the force.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Part {
    /// All results.
    All,
    /// The first results: rows, or a point.
    Head,
    /// The results after them: a Jacobian, or a force.
    Tail,
}

/// The number of parts of a segment.
pub(super) const PARTS: usize = Part::Tail as usize + 1;
