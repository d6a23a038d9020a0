//! Compilation of programs to machine code by Cranelift.

mod code;
mod writer;

use std::fmt;
use std::sync::Arc;

use cranelift_codegen::Context;
use cranelift_codegen::control::ControlPlane;
use cranelift_codegen::ir::{AbiParam, Signature, UserFuncName};
use cranelift_codegen::isa::OwnedTargetIsa;
use cranelift_codegen::settings::{self, Configurable};
use cranelift_frontend::{FunctionBuilder, FunctionBuilderContext};

use crate::{JitError, PIECE, Program};
use code::executable;
pub use code::{Code, Ready};
use writer::{Cut, Writer};

/// Functions begin at multiples of this number of bytes.
const ALIGNMENT: usize = 64;

/// A compiler from programs to machine code.
pub struct Compiler {
    isa: OwnedTargetIsa,
    context: Context,
    builder: FunctionBuilderContext,
    /// The code so far.
    bytes: Vec<u8>,
}

impl fmt::Debug for Compiler {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Compiler").finish_non_exhaustive()
    }
}

impl Compiler {
    /// A compiler for this machine.
    ///
    /// # Errors
    ///
    /// [`JitError::Machine`] if Cranelift does not support this machine.
    pub fn new() -> Result<Self, JitError> {
        let machine = |error: &dyn fmt::Display| JitError::Machine(error.to_string());
        let mut flags = settings::builder();
        for (name, value) in [
            ("opt_level", "none"),
            ("regalloc_algorithm", "backtracking"),
            ("enable_verifier", "false"),
            ("enable_probestack", "false"),
            ("unwind_info", "false"),
        ] {
            flags.set(name, value).map_err(|error| machine(&error))?;
        }
        let native = cranelift_native::builder().map_err(|error| machine(&error))?;
        let isa = native.finish(settings::Flags::new(flags));
        Ok(Self {
            isa: isa.map_err(|error| machine(&error))?,
            context: Context::new(),
            builder: FunctionBuilderContext::new(),
            bytes: Vec::new(),
        })
    }

    /// The code of some programs, in their order.
    ///
    /// # Errors
    ///
    /// [`JitError::Compiler`] if the code cannot be made.
    pub fn compile(mut self, programs: &[Program]) -> Result<Vec<Code>, JitError> {
        let made = programs.iter().map(|program| self.functions(program));
        let made = made.collect::<Result<Vec<_>, _>>()?;
        let memory = Arc::new(executable(&self.bytes).map_err(|error| failed(&error))?);
        let code = made.into_iter();
        let code =
            code.map(|(first, others, homes, length)| Code::new(&memory, (first, &others), homes, length));
        Ok(code.collect())
    }

    /// Compiles the functions of a program. Returns the offset of its first piece in the code, those of the others, the number of values that one
    /// piece stores for another, and the number of places.
    fn functions(&mut self, program: &Program) -> Result<(usize, Vec<usize>, usize, usize), JitError> {
        let cut = Cut::new(program);
        let first = self.piece(program, &cut, 0)?;
        let count = program.operations.len().div_ceil(PIECE);
        let others = (1..count).map(|piece| self.piece(program, &cut, piece));
        let others = others.collect::<Result<_, _>>()?;
        Ok((first, others, cut.count, program.length))
    }

    /// Compiles one piece of a program, and returns its offset in the code.
    fn piece(&mut self, program: &Program, cut: &Cut, piece: usize) -> Result<usize, JitError> {
        let pointer = self.isa.pointer_type();
        let call_conv = self.isa.default_call_conv();
        self.context.clear();
        let function = &mut self.context.func;
        function.name = UserFuncName::user(0, 0);
        function.signature = Signature::new(call_conv);
        function.signature.params.extend([AbiParam::new(pointer); 3]);
        let builder = FunctionBuilder::new(function, &mut self.builder);
        let mut writer = Writer::new(builder, program, cut, (pointer, call_conv), piece);
        writer.write();
        writer.builder.seal_all_blocks();
        writer.builder.finalize();
        let compiled = self.context.compile(&*self.isa, &mut ControlPlane::default());
        let compiled = compiled.map_err(|error| failed(&error.inner))?;
        // functions are called by their addresses, so nothing is left to be linked
        if !compiled.buffer.relocs().is_empty() {
            return Err(JitError::Compiler(
                "the code refers to what is not in it".to_owned(),
            ));
        }
        let begin = self.bytes.len().next_multiple_of(ALIGNMENT);
        self.bytes.resize(begin, 0);
        self.bytes.extend_from_slice(compiled.code_buffer());
        Ok(begin)
    }
}

/// A failure of the compiler.
fn failed(error: &dyn fmt::Display) -> JitError {
    JitError::Compiler(error.to_string())
}
