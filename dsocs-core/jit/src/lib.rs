//! Machine code for straight-line programs over doubles, made while a program runs.
//!
//! It stands behind the feature `jit` of `dsocs-core`, which hands it the programs of a step. A program reads numbers at places of a slice, does one
//! [`Operation`] after another, and writes some of their results to other places. Each operation is the one of IEEE 754 or a function that the caller gives,
//! and none is fused with another: so the results are those of whoever does the same
//! operations one by one. (Which NaN a result is, is not said.)
//!
//! ```
//! use dsocs_jit::{Compiler, NoCalls, Operand, Operation, Program};
//!
//! extern "C" fn sin(x: f64) -> f64 {
//!     x.sin()
//! }
//!
//! // the sine of the first number, plus the second one
//! let operations = [
//!     Operation::Function(sin, Operand::Place(0)),
//!     Operation::Add(Operand::Result(0), Operand::Place(1)),
//! ];
//! let program = Program::new(&operations, &[(Operand::Result(1), 2)])?;
//! if let Ok(code) = Compiler::new().and_then(|compiler| compiler.compile(&[program])) {
//!     let mut numbers = vec![0.5, 1.0, 0.0];
//!     code[0].run(&mut numbers, &NoCalls)?;
//!     assert_eq!(numbers[2], 0.5_f64.sin() + 1.0);
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Memory for code is freed with the last [`Code`] of a [`Compiler`].
//!
//! Code is made on x86-64. ARM64 would need a flush of the instruction cache, and a machine to test it on: there, and everywhere else, a [`Compiler`] says that there is none.
//!
//! # Why Cranelift
//!
//! It compiles exactly the operations that it is told, and neither fuses nor reorders them. The crate symjit (2.28), a smaller JIT for such expressions, has powers of its own
//! (its `x⁶` is the square of `x³`, where [`f64::powi`] multiplies `x²` and `x⁴`): the bits of the compiled step would be lost. The module of `cranelift-jit`
//! is not used: it takes a page for each function, and does not free them on Windows. What is made here refers to nothing outside, so it is copied into memory that
//! `memmap2` gives, makes executable and frees.

#[cfg(target_arch = "x86_64")]
mod machine;

#[cfg(not(target_arch = "x86_64"))]
#[path = "none.rs"]
mod machine;

use std::collections::HashSet;

use thiserror::Error;

pub use machine::{Code, Compiler};

/// How many operations a function of machine code has at most. The time that a function takes to compile grows faster than its length: the programs of a chain of 32
/// links take 77 to 94 ms in pieces of 500 or of 1000, 113 to 132 in pieces of 2000, and 185 to 260 in one.
pub const PIECE: usize = 500;

/// What an operation reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operand {
    /// The number at a place, as it was when the program began.
    Place(u32),
    /// The result of an operation before, by its number among all.
    Result(u32),
}

/// What is computed.
#[derive(Clone, Copy, Debug)]
pub enum Operation {
    /// `-a`.
    Neg(Operand),
    /// `1 / a`.
    Recip(Operand),
    /// As [`f64::sqrt`].
    Sqrt(Operand),
    /// As [`f64::abs`].
    Abs(Operand),
    /// As [`f64::signum`].
    Signum(Operand),
    /// `a` to a whole power: the products of [`f64::powi`], in its order.
    Powi(Operand, i32),
    /// `a + b`.
    Add(Operand, Operand),
    /// `a - b`.
    Sub(Operand, Operand),
    /// `a b`.
    Mul(Operand, Operand),
    /// `a / b`.
    Div(Operand, Operand),
    /// `if a < b { c } else { d }`.
    Less([Operand; 4]),
    /// `if a <= b { c } else { d }`.
    LessOrEqual([Operand; 4]),
    /// A function of one number.
    Function(extern "C" fn(f64) -> f64, Operand),
    /// A function of two numbers.
    Function2(extern "C" fn(f64, f64) -> f64, Operand, Operand),
    /// What [`Calls`] answers, at an argument.
    Call(u32, Operand),
    /// The same without arguments.
    Datum(u32),
}

impl Operation {
    /// The same operation of other operands: what each becomes is asked one by one, in the order in which they stand.
    fn map(self, mut of: impl FnMut(Operand) -> Operand) -> Self {
        match self {
            Self::Neg(a) => Self::Neg(of(a)),
            Self::Recip(a) => Self::Recip(of(a)),
            Self::Sqrt(a) => Self::Sqrt(of(a)),
            Self::Abs(a) => Self::Abs(of(a)),
            Self::Signum(a) => Self::Signum(of(a)),
            Self::Powi(a, power) => Self::Powi(of(a), power),
            Self::Add(a, b) => Self::Add(of(a), of(b)),
            Self::Sub(a, b) => Self::Sub(of(a), of(b)),
            Self::Mul(a, b) => Self::Mul(of(a), of(b)),
            Self::Div(a, b) => Self::Div(of(a), of(b)),
            Self::Less(parts) => Self::Less(parts.map(of)),
            Self::LessOrEqual(parts) => Self::LessOrEqual(parts.map(of)),
            Self::Function(function, a) => Self::Function(function, of(a)),
            Self::Function2(function, a, b) => Self::Function2(function, of(a), of(b)),
            Self::Call(which, a) => Self::Call(which, of(a)),
            Self::Datum(which) => Self::Datum(which),
        }
    }

    /// Tells what it reads.
    fn each(self, mut tell: impl FnMut(Operand)) {
        self.map(|operand| {
            tell(operand);
            operand
        });
    }
}

/// A straight-line program over numbers.
#[derive(Clone, Debug)]
#[cfg_attr(not(target_arch = "x86_64"), allow(dead_code))] // nothing is made of it there
pub struct Program {
    /// The operations that are needed, each after those that it reads.
    operations: Vec<Operation>,
    /// What is written, and to which place.
    results: Vec<(Operand, u32)>,
    /// How many numbers it is run on: all places are below.
    length: usize,
}

impl Program {
    /// A program of some operations, each of which stands after those that it reads. `results` says what is written, and to which place; places that are
    /// written are read by none of the operations.
    ///
    /// The operations are put in another order, as late as they are read: few numbers wait at a time then. What nobody reads is left out.
    ///
    /// # Errors
    ///
    /// [`JitError::Program`] if an operation reads one that does not stand before it, or a place that is written.
    pub fn new(operations: &[Operation], results: &[(Operand, u32)]) -> Result<Self, JitError> {
        let written: HashSet<u32> = results.iter().map(|&(_, to)| to).collect();
        let mut length = results.iter().map(|&(_, to)| to as usize + 1).max().unwrap_or(0);
        let mut is_sound = written.len() == results.len();
        let mut check = |operand: Operand, before: usize| match operand {
            Operand::Place(place) => {
                length = length.max(place as usize + 1);
                is_sound &= !written.contains(&place);
            }
            Operand::Result(of) => is_sound &= (of as usize) < before,
        };
        for (at, operation) in operations.iter().enumerate() {
            operation.each(|operand| check(operand, at));
        }
        for &(from, _) in results {
            check(from, operations.len());
        }
        if !is_sound || u32::try_from(operations.len()).is_err() {
            return Err(JitError::Program);
        }
        Ok(Self::in_order(operations, results, length))
    }

    /// The program of operations that are sound.
    fn in_order(operations: &[Operation], results: &[(Operand, u32)], length: usize) -> Self {
        // the number of each operation in the new order
        let mut numbers: Vec<Option<u32>> = vec![None; operations.len()];
        let renamed = |operand: Operand, numbers: &[Option<u32>]| match operand {
            Operand::Result(of) => Operand::Result(numbers[of as usize].unwrap_or(0)),
            Operand::Place(_) => operand,
        };
        let mut ordered: Vec<Operation> = Vec::with_capacity(operations.len());
        let mut open: Vec<u32> = Vec::new();
        for &(from, _) in results {
            if let Operand::Result(of) = from {
                open.push(of);
            }
            while let Some(&of) = open.last() {
                if numbers[of as usize].is_some() {
                    open.pop();
                    continue;
                }
                let (operation, waiting) = (operations[of as usize], open.len());
                operation.each(|operand| match operand {
                    Operand::Result(part) if numbers[part as usize].is_none() => open.push(part),
                    _ => {}
                });
                if open.len() == waiting {
                    open.pop();
                    // there are no more of them than before
                    numbers[of as usize] = u32::try_from(ordered.len()).ok();
                    ordered.push(operation.map(|operand| renamed(operand, &numbers)));
                } else {
                    // the first operand comes first
                    open[waiting..].reverse();
                }
            }
        }
        let results = results.iter();
        let results = results.map(|&(from, to)| (renamed(from, &numbers), to));
        Self {
            results: results.collect(),
            operations: ordered,
            length,
        }
    }
}

/// What a program calls while it runs ([`Operation::Call`], [`Operation::Datum`]).
pub trait Calls {
    /// The value of a call, at its argument if it has one.
    fn call(&self, which: u32, argument: Option<f64>) -> f64;
}

/// Nothing to call: every answer is NaN.
#[derive(Clone, Copy, Debug)]
pub struct NoCalls;

impl Calls for NoCalls {
    fn call(&self, _: u32, _: Option<f64>) -> f64 {
        f64::NAN
    }
}

/// Why there is no machine code.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum JitError {
    /// Machine code is not made for this processor or operating system.
    #[error("no machine code is made for this machine: {0}")]
    Machine(String),
    /// A program reads what does not exist, or writes where it reads.
    #[error("the program reads what does not exist, or writes where it reads")]
    Program,
    /// The compiler failed, or the system gave no memory in which code may run.
    #[error("no machine code could be made: {0}")]
    Compiler(String),
}

/// Numbers that are fewer than a program is run on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("the program is run on {expected} numbers, and these are {found}")]
pub struct TooShort {
    /// How many there are.
    pub found: usize,
    /// How many the program reads and writes.
    pub expected: usize,
}
