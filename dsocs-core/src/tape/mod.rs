//! The tape of a declaration: its operations as bytes, and the one evaluator that reads them.
//!
//! The expressions that a run evaluates often are straight-line code
//! ([`Compiled`](crate::kernel::generated::Compiled)). All others (rounding bounds, derivatives, starts,
//! certificates, geometry, checks) are evaluated rarely, and with many types of numbers: compiled, they would
//! be most of the code of a system. So the attribute writes the same operations, in the same order, once more
//! as a constant [`Tape`]. [`Number::walk`] evaluates it, compiled once for each type of number, in this
//! crate.
//!
//! # The format
//!
//! A tape is a sequence of bytes that the attribute writes and nobody else reads: it belongs to one version of this crate. It
//! begins with [`VERSION`]; then come the [`SEGMENTS`], in their order, each as its length in bytes and its body. A body is the
//! number of operations, the operations, the number of results, how many of them belong to the [`Part::Head`], and
//! the results. Whole numbers are unsigned LEB128. An operand is the place of an operation in the same segment, before the
//! one that reads it; a result is the place of an operation. In place of a result, the number of operations
//! means that the last result is repeated, as often as the next number says: a large Jacobian is mostly zero.
//! An operation is a byte, followed by its operands:
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
//! A tape that breaks these rules has no results: all its numbers are NaN.

#[cfg(feature = "jit")]
mod code;
pub(crate) mod declaration;
mod differential;
mod eight;
mod evaluate;
mod format;
mod link;
pub(crate) mod origin;
pub(crate) mod quantity;
mod read;
mod shape;
mod straight;
mod symmetry;
mod table;
#[cfg(test)]
mod tests;

use std::borrow::Cow;
use std::sync::OnceLock;

use thiserror::Error;

#[cfg(feature = "jit")]
pub(crate) use code::Tier;
pub(crate) use differential::{Differential, Input, Sweeps, Workspace};
pub(crate) use eight::Eight;
pub use evaluate::Number;
use format::PARTS;
pub use format::{Leaf, Part, Segment};
pub(crate) use format::{SEGMENTS, VERSION};
pub use link::Program;
pub use shape::Shape;
pub(crate) use straight::{FIXED, MemoryLayout, Numbers, Place, ProgramMemory, Ready, Straight};
pub use symmetry::Symmetry;
pub(crate) use table::TapeCalls;
pub use table::{CallData, TapeCall, table};

use crate::number::dual::Dual;
use read::Body;
pub(crate) use read::Reader;

/// The source of a tape's parameters and calls: the system, as the attribute implements it.
pub trait Source: Send + Sync {
    /// The names, counts and kinds of the declaration.
    fn shape(&self) -> &Shape;

    /// The tape of the declaration.
    fn tape(&self) -> &Tape;

    /// The value of a parameter in the system; NaN beyond the last. A run may hold other values.
    fn value(&self, parameter: usize) -> f64;

    /// A user's function, or a derivative of one, at some arguments; without arguments, an expression of
    /// parameters that are no numbers. NaN if there is none of this number.
    fn call(&self, which: usize, arguments: &[f64]) -> f64;

    /// [`Source::call`] with a derivative; NaN if the function is known for plain numbers alone.
    fn call_dual(&self, which: usize, arguments: &[Dual<f64>]) -> Dual<f64> {
        called_with_plain(arguments, &|plain| self.call(which, plain))
    }

    /// The data of a call that is data: it is evaluated with numbers of all types, without [`Source::call`].
    fn data(&self, which: usize) -> Option<CallData<'_>> {
        let _ = which;
        None
    }
}

/// [`Source::call_dual`] by a function of plain numbers; compiled once, not for every system.
fn called_with_plain(arguments: &[Dual<f64>], call: &dyn Fn(&[f64]) -> f64) -> Dual<f64> {
    let plain: Vec<f64> = arguments.iter().map(|argument| argument.re).collect();
    let moves = arguments.iter().any(|argument| argument.eps != 0.0);
    Dual::new(call(&plain), if moves { f64::NAN } else { 0.0 })
}

/// Bytes that are no tape, or a tape of another version of this crate.
#[derive(Clone, Copy, PartialEq, Eq, Error)]
#[error("these bytes are no tape of this version")]
pub struct MalformedTape;

crate::debug_is_message!(MalformedTape);

/// The operations of a declaration, and the programs that were linked from them so far.
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

    /// The program of some results of a segment, by their places. It reads the results of the `given`
    /// segments as leaves.
    pub(crate) fn later(&self, segment: Segment, results: &[usize], given: &[Segment]) -> Program {
        link::later(self.bodies(), segment, results, given)
    }

    /// Whether a user's function is called, or an expression of parameters that are no numbers.
    #[must_use]
    pub fn calls_functions(&self) -> bool {
        self.calls() > 0
    }

    /// The number of the user's functions, and of expressions of parameters that are no numbers, that may be
    /// called.
    pub(crate) fn calls(&self) -> usize {
        let ops = self.bodies().iter().flat_map(|body| &body.ops);
        let calls = ops.filter_map(|op| match op {
            read::Op::Call(which, _) => Some(which + 1),
            _ => None,
        });
        calls.max().unwrap_or(0)
    }

    /// The number of results of a part of a segment.
    pub fn count(&self, segment: Segment, part: Part) -> usize {
        self.bodies()
            .get(segment as usize)
            .map_or(0, |body| body.part(part).len())
    }

    /// The segments; none if the tape is malformed.
    fn bodies(&self) -> &[Body] {
        self.bodies
            .get_or_init(|| read::read(&self.bytes).unwrap_or_default())
    }
}
