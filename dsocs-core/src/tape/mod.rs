//! The cold form of a declaration: its operations as bytes, and the one evaluator that walks them.
//!
//! What a run evaluates often is straight-line code ([`Compiled`](crate::compiled::Compiled)). All the rest, rounding bounds,
//! derivatives, starts, certificates, geometry, checks, is evaluated rarely, and with many types of numbers: compiled, it
//! would be most of the code of a system. So the attribute writes the same operations, in the same order, once more as a
//! constant [`Tape`]. [`Number::walk`] evaluates it, compiled once for each type of number, in this crate.
//!
//! # The format
//!
//! A tape is a sequence of bytes that the attribute writes and nobody else reads: it belongs to one version of this crate. It
//! begins with [`VERSION`]; then come the [`SEGMENTS`], in their order, each as its length in bytes and its body. A body is the
//! number of operations, the operations, the number of results, how many of them belong to the [`Part::Head`], and
//! the results. Whole numbers are unsigned LEB128. An operand is the place of an operation in the same segment, before the
//! one that reads it; a result is the place of an operation. In place of a result, the number of operations says that the last result comes
//! again, and a number follows that says how often: a large Jacobian is mostly zero. An operation is a byte, and what it reads:
//!
//! | byte | operation | followed by |
//! |---|---|---|
//! | 0 | a number | eight bytes, little-endian |
//! | 1 | a leaf | its kind (see [`Leaf`]) and its index |
//! | 2 | a result of [`Segment::Constants`] | its place |
//! | 3 | a result of [`Segment::Known`] | its place |
//! | 4 | `-a` | `a` |
//! | 5 … 8 | `a + b`, `a - b`, `a b`, `a / b` | `a`, `b` |
//! | 9 | `1 / a` | `a` |
//! | 10 | `a` to a whole power | `a`, four bytes of the power, little-endian |
//! | 11, 12 | `powf(a, b)`, `atan2(a, b)` | `a`, `b` |
//! | 13, 14 | `if a < b { c } else { d }`, the same with `≤` | `a`, `b`, `c`, `d` |
//! | 15 | a call of the user's ([`Source::call`]) | which, the number of arguments, the arguments |
//! | 32 … 51 | a function | `a` |
//!
//! A tape that breaks these rules has no results: every number that it is asked for is NaN.

mod differential;
mod eight;
mod evaluate;
mod link;
pub(crate) mod origin;
mod read;
#[cfg(test)]
mod tests;

use std::borrow::Cow;
use std::sync::OnceLock;

use thiserror::Error;

pub(crate) use differential::{Differential, Input, Room, Sweeps};
pub(crate) use eight::Eight;
pub use evaluate::Number;
pub use link::Program;

use crate::dual::Dual;
use crate::kernel::Shape;
use read::Body;

/// The first byte of a tape.
pub(crate) const VERSION: u8 = 4;

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
    /// The same on the first leg of a step (15).
    FirstSide(usize),
    /// A result of [`Segment::Constants`], in a program to which these are handed.
    Constant(usize),
    /// A result of [`Segment::Known`], in a program to which these are handed.
    Known(usize),
}

/// What a tape computes, in the order in which it stands there.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Segment {
    /// What is known when the run begins, as [`Compiled::constants`](crate::compiled::Compiled::constants).
    Constants,
    /// What is known when the step begins, as [`Compiled::known`](crate::compiled::Compiled::known).
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
}

/// How many segments a tape has.
pub(crate) const SEGMENTS: usize = Segment::SidedContinuous as usize + 1;

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
const PARTS: usize = Part::Tail as usize + 1;

/// Where a tape gets from what is no expression of its leaves: the system, as the attribute implements it.
pub trait Source: Send + Sync {
    /// The names, counts and kinds of the declaration.
    fn shape(&self) -> &Shape;

    /// The tape of the declaration.
    fn tape(&self) -> &Tape;

    /// The value of a parameter as the system has it; NaN beyond the last. A run may hold others.
    fn value(&self, parameter: usize) -> f64;

    /// A function of the user's, or a derivative of one, at some arguments; without arguments an expression of parameters that
    /// are no numbers. NaN if there is none of this number.
    fn call(&self, which: usize, arguments: &[f64]) -> f64;

    /// The same with a derivative along; NaN where the function is called with plain numbers alone.
    fn call_dual(&self, which: usize, arguments: &[Dual<f64>]) -> Dual<f64> {
        called_with_plain(arguments, &|plain| self.call(which, plain))
    }
}

/// [`Source::call_dual`] by the function that takes plain numbers; compiled once, not for every system.
fn called_with_plain(arguments: &[Dual<f64>], call: &dyn Fn(&[f64]) -> f64) -> Dual<f64> {
    let plain: Vec<f64> = arguments.iter().map(|argument| argument.re).collect();
    let moves = arguments.iter().any(|argument| argument.eps != 0.0);
    Dual::new(call(&plain), if moves { f64::NAN } else { 0.0 })
}

/// Bytes that are no tape, or a tape of another version of this crate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("these bytes are no tape of this version")]
pub struct MalformedTape;

/// The operations of a declaration, and the programs that were made of them so far.
#[derive(Debug)]
pub struct Tape {
    bytes: Cow<'static, [u8]>,
    bodies: OnceLock<Vec<Body>>,
    programs: [[OnceLock<Program>; PARTS]; SEGMENTS],
}

impl Tape {
    /// A tape of bytes. Nothing is read before it is needed.
    #[must_use]
    pub const fn new(bytes: &'static [u8]) -> Self {
        Self {
            bytes: Cow::Borrowed(bytes),
            bodies: OnceLock::new(),
            programs: [const { [const { OnceLock::new() }; PARTS] }; SEGMENTS],
        }
    }

    /// A tape of bytes that were read or made at run time.
    ///
    /// # Errors
    ///
    /// [`MalformedTape`] if the bytes break the format.
    pub fn owned(bytes: Vec<u8>) -> Result<Self, MalformedTape> {
        let bodies = read::read(&bytes).ok_or(MalformedTape)?;
        Ok(Self {
            bytes: Cow::Owned(bytes),
            bodies: OnceLock::from(bodies),
            ..Self::new(&[])
        })
    }

    /// The bytes of the tape.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// The program that computes a part of a segment.
    pub fn program(&self, segment: Segment, part: Part) -> &Program {
        let place = &self.programs[segment as usize][part as usize];
        place.get_or_init(|| link::link(self.bodies(), segment, part))
    }

    /// The program that computes some results of a segment, by their places. It reads the results of the `given` segments as leaves.
    pub(crate) fn later(&self, segment: Segment, results: &[usize], given: &[Segment]) -> Program {
        link::later(self.bodies(), segment, results, given)
    }

    /// Whether a function of the user's is called, or an expression of parameters that are no numbers.
    pub(crate) fn calls(&self) -> bool {
        let mut ops = self.bodies().iter().flat_map(|body| &body.ops);
        ops.any(|op| matches!(op, read::Op::Call(..)))
    }

    /// Whether a segment has a sign or a comparison.
    pub(crate) fn branches(&self, segment: Segment) -> bool {
        let body = self.bodies().get(segment as usize);
        body.is_some_and(|body| body.ops.iter().any(read::Op::branches))
    }

    /// How many results a part of a segment has.
    pub fn count(&self, segment: Segment, part: Part) -> usize {
        self.bodies()
            .get(segment as usize)
            .map_or(0, |body| body.part(part).len())
    }

    /// The segments; none of a tape that is malformed.
    fn bodies(&self) -> &[Body] {
        self.bodies
            .get_or_init(|| read::read(&self.bytes).unwrap_or_default())
    }
}
