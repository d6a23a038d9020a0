//! Compilation of straight-line programs over doubles to machine code, at run time.
//!
//! The crate is behind the feature `jit` of `dsocs-core`, which passes it the programs of a step. A program reads numbers at places of a
//! slice, performs one [`Operation`] after another, and writes some of their results to other places. Each operation is that of IEEE 754, or
//! a function that the caller gives, and none is fused with another. So the results have the bits of the same operations in Rust, one by one.
//! (A NaN may have other bits.)
//!
//! ```
//! use std::cell::Cell;
//!
//! use dsocs_jit::{Compiler, NoCalls, Operand, Operation, Program};
//!
//! // the sine of the first number, plus the second one
//! let operations = [
//!     Operation::Sin(Operand::Place(0)),
//!     Operation::Add(Operand::Result(0), Operand::Place(1)),
//! ];
//! let program = Program::new(&operations, &[(Operand::Result(1), 2)])?;
//! if let Ok(code) = Compiler::new().and_then(|compiler| compiler.compile(&[program])) {
//!     let numbers = [0.5, 1.0, 0.0].map(Cell::new);
//!     code[0].on(&numbers, &NoCalls)?.run();
//!     assert_eq!(numbers[2].get(), 0.5_f64.sin() + 1.0);
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Memory for code is freed with the last [`Code`] of a [`Compiler`].
//!
//! Machine code is made on x86-64 only. On ARM64 the instruction cache would have to be flushed, which could not be tested. On other machines
//! [`Compiler::new`] returns [`JitError::Machine`].
//!
//! # Why Cranelift
//!
//! Cranelift compiles exactly the given operations, and neither fuses nor reorders them. The crate symjit (2.28), a smaller JIT for such
//! expressions, computes powers in its own way (`x⁶` is the square of `x³`, where [`f64::powi`] multiplies `x²` and `x⁴`), so the bits of the
//! compiled step would be lost. The module of `cranelift-jit` is not used: it takes a page for each function, and does not free pages on
//! Windows. The code made here refers to no address outside that would have to be linked, so it is copied into memory from `memmap2`, which
//! makes it executable and frees it.

#[cfg(target_arch = "x86_64")]
mod machine;

#[cfg(not(target_arch = "x86_64"))]
#[path = "none.rs"]
mod machine;

use std::collections::HashSet;

use thiserror::Error;

pub use machine::{Code, Compiler, Ready};

/// The largest number of operations in a function of machine code. The time to compile a function grows faster than its length: the programs
/// of a chain of 32 links take 77 to 94 ms in pieces of 500 or 1000 operations, 113 to 132 ms in pieces of 2000, and 185 to 260 ms in one.
pub const PIECE: usize = 500;

/// An operand of an operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Operand {
    /// The number at a place, before the program writes to any place.
    Place(u32),
    /// The result of an earlier operation, by its number among all operations.
    Result(u32),
}

/// An operation.
#[derive(Clone, Copy, Debug)]
pub enum Operation {
    /// `-a`.
    Neg(Operand),
    /// `1 / a`.
    Recip(Operand),
    /// The square root, as [`f64::sqrt`].
    Sqrt(Operand),
    /// The absolute value, as [`f64::abs`].
    Abs(Operand),
    /// The sign, as [`f64::signum`].
    Signum(Operand),
    /// As [`f64::sin`].
    Sin(Operand),
    /// As [`f64::cos`].
    Cos(Operand),
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
    /// A value of [`Calls`], by its number, at an argument.
    Call(u32, Operand),
    /// A value of [`Calls`], by its number, without an argument.
    Datum(u32),
}

impl Operation {
    /// The operation with other operands: `of` maps each operand, in their order.
    fn map(self, mut of: impl FnMut(Operand) -> Operand) -> Self {
        match self {
            Self::Neg(a) => Self::Neg(of(a)),
            Self::Recip(a) => Self::Recip(of(a)),
            Self::Sqrt(a) => Self::Sqrt(of(a)),
            Self::Abs(a) => Self::Abs(of(a)),
            Self::Signum(a) => Self::Signum(of(a)),
            Self::Sin(a) => Self::Sin(of(a)),
            Self::Cos(a) => Self::Cos(of(a)),
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

    /// Calls `tell` with each operand, in their order.
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
    /// The operations that the results need, each after those that it reads.
    operations: Vec<Operation>,
    /// The results: an operand, and the place to which its value is written.
    results: Vec<(Operand, u32)>,
    /// The number of places that the program needs: all its places are below.
    length: usize,
}

impl Program {
    /// A program of operations, each after those that it reads. `results` are operands, each with the place to which its value is written. No
    /// operation may read such a place.
    ///
    /// Operations are reordered so that each comes shortly before its result is read: then few intermediate results are alive at a time.
    /// Operations whose results are not needed are left out.
    ///
    /// # Errors
    ///
    /// [`JitError::Program`] if an operation reads one that does not come before it, or a place that is written, or if a place is written
    /// twice.
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

    /// The program of operations that have been checked.
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
                    // the new order has at most as many operations, so the number fits
                    numbers[of as usize] = u32::try_from(ordered.len()).ok();
                    ordered.push(operation.map(|operand| renamed(operand, &numbers)));
                } else {
                    // the stack is taken from its end: the first operand comes first
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

/// The values that a program calls while it runs ([`Operation::Call`], [`Operation::Datum`]).
pub trait Calls {
    /// The value of call number `which`, at its argument if it has one.
    fn call(&self, which: u32, argument: Option<f64>) -> f64;
}

/// No calls: every value is NaN.
#[derive(Clone, Copy, Debug)]
pub struct NoCalls;

impl Calls for NoCalls {
    fn call(&self, _: u32, _: Option<f64>) -> f64 {
        f64::NAN
    }
}

/// The reason why there is no machine code.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum JitError {
    /// Machine code is not made for this processor or operating system.
    #[error("no machine code is made for this machine: {0}")]
    Machine(String),
    /// The program reads an operation or a place that it must not read, or writes a place twice.
    #[error("the program reads what does not exist, or writes where it reads")]
    Program,
    /// The compiler failed, or the operating system gave no executable memory.
    #[error("no machine code could be made: {0}")]
    Compiler(String),
}

/// A slice with fewer numbers than the program has places.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("the program is run on {expected} numbers, and these are {found}")]
pub struct TooShort {
    /// The length of the slice.
    pub found: usize,
    /// The number of places of the program.
    pub expected: usize,
}
