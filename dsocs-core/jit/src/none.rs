//! The crate's interface on machines for which no code is made.

use std::cell::Cell;

use crate::{Calls, JitError, Program, TooShort};

/// A compiler, of which there is none on this machine.
#[derive(Debug)]
pub struct Compiler(());

impl Compiler {
    /// A compiler for this machine.
    ///
    /// # Errors
    ///
    /// [`JitError::Machine`], always.
    pub fn new() -> Result<Self, JitError> {
        let machine = format!("{} on {}", std::env::consts::ARCH, std::env::consts::OS);
        Err(JitError::Machine(machine))
    }

    /// The code of some programs.
    ///
    /// # Errors
    ///
    /// [`JitError::Machine`], always.
    pub fn compile(self, _: &[Program]) -> Result<Vec<Code>, JitError> {
        Err(JitError::Machine(std::env::consts::ARCH.to_owned()))
    }
}

/// A program as machine code, of which there is none on this machine.
#[derive(Clone, Debug)]
pub enum Code {}

impl Code {
    /// The program with the numbers that it is run on.
    ///
    /// # Errors
    ///
    /// None: there is no code.
    pub fn on<'r>(&'r self, _: &'r [Cell<f64>], _: &'r dyn Calls) -> Result<Ready<'r>, TooShort> {
        match *self {}
    }
}

/// A program that is ready to run, of which there is none on this machine.
#[derive(Clone, Copy, Debug)]
pub struct Ready<'r>(&'r Code);

impl Ready<'_> {
    /// Runs the program.
    pub fn run(&self) {
        match *self.0 {}
    }
}
