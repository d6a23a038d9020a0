//! Machine code and its execution. All unsafe code of the crate is here.

use std::cell::Cell;
use std::fmt;
use std::sync::Arc;

use memmap2::{Mmap, MmapMut};

use crate::{Calls, TooShort};

/// A piece of a program: a function of the numbers, of the values that one piece stores for another, and of the [`Calls`].
type Piece = unsafe extern "C" fn(*mut f64, *mut f64, *const &dyn Calls);

/// Executable memory with a copy of some code. It can no longer be written.
pub(super) fn executable(code: &[u8]) -> std::io::Result<Mmap> {
    let mut memory = MmapMut::map_anon(code.len().max(1))?;
    if let Some(room) = memory.get_mut(..code.len()) {
        room.copy_from_slice(code);
    }
    memory.make_exec()
}

/// The function that begins at an offset in the memory.
#[expect(unsafe_code, reason = "bytes become a function")]
fn piece(memory: &Mmap, begin: usize) -> Piece {
    // SAFETY: at this offset begins a function that `Compiler::piece` has made, with the signature of `Piece` and the calling convention of
    // `extern "C"` on this machine. `Code` keeps the memory as long as the function, and the memory is never written again.
    unsafe { std::mem::transmute::<*const u8, Piece>(memory.as_ptr().add(begin)) }
}

/// A program as machine code.
#[derive(Clone)]
pub struct Code {
    first: Piece,
    /// The pieces behind the first.
    others: Vec<Piece>,
    /// The number of values that one piece stores for another.
    homes: usize,
    /// The number of places of the program.
    length: usize,
    /// The memory of the pieces.
    #[expect(dead_code, reason = "the pieces live as long as it does")]
    memory: Arc<Mmap>,
}

impl fmt::Debug for Code {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut f = f.debug_struct("Code");
        let f = f
            .field("pieces", &(1 + self.others.len()))
            .field("homes", &self.homes);
        f.field("length", &self.length).finish_non_exhaustive()
    }
}

thread_local! {
    /// Workspace for values that one piece stores for another; kept, so that a run allocates nothing.
    static HOMES: Cell<Vec<f64>> = const { Cell::new(Vec::new()) };
}

impl Code {
    /// The code of a program whose pieces begin at these offsets of the memory.
    pub(super) fn new(
        memory: &Arc<Mmap>,
        (first, others): (usize, &[usize]),
        homes: usize,
        length: usize,
    ) -> Self {
        Self {
            first: piece(memory, first),
            others: others.iter().map(|&begin| piece(memory, begin)).collect(),
            homes,
            length,
            memory: Arc::clone(memory),
        }
    }

    /// The program with the numbers that it is run on, and with what it calls.
    ///
    /// # Errors
    ///
    /// [`TooShort`] if there are fewer numbers than the program has places.
    pub fn on<'r>(&'r self, numbers: &'r [Cell<f64>], calls: &'r dyn Calls) -> Result<Ready<'r>, TooShort> {
        if numbers.len() < self.length {
            return Err(TooShort {
                found: numbers.len(),
                expected: self.length,
            });
        }
        Ok(Ready {
            whole: self.others.is_empty().then_some(self.first),
            code: self,
            numbers,
            calls,
        })
    }
}

/// A program that is ready to run.
#[derive(Clone, Copy)]
pub struct Ready<'r> {
    /// The code, if it is in one piece.
    whole: Option<Piece>,
    code: &'r Code,
    numbers: &'r [Cell<f64>],
    calls: &'r dyn Calls,
}

impl fmt::Debug for Ready<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Ready").field(&self.code).finish()
    }
}

impl Ready<'_> {
    /// Runs the program.
    #[inline]
    pub fn run(&self) {
        match self.whole {
            // nothing goes from piece to piece
            Some(whole) => self.call(whole, &mut []),
            None => self.run_in_pieces(),
        }
    }

    /// Runs a program of several pieces.
    #[inline(never)]
    fn run_in_pieces(&self) {
        // a program that runs inside a call, or while the thread ends, finds an empty workspace
        let mut homes = HOMES.try_with(Cell::take).unwrap_or_default();
        if homes.len() < self.code.homes {
            homes.resize(self.code.homes, 0.0);
        }
        for &piece in [self.code.first].iter().chain(&self.code.others) {
            self.call(piece, &mut homes);
        }
        let _ = HOMES.try_with(|kept| kept.set(homes));
    }

    /// Runs a piece. There has to be memory for all of its numbers and values.
    #[expect(unsafe_code, reason = "code that was made when the program ran is called")]
    #[inline]
    fn call(&self, piece: Piece, homes: &mut [f64]) {
        debug_assert!(
            self.numbers.len() >= self.code.length
                && (homes.len() >= self.code.homes || self.whole.is_some())
        );
        // SAFETY: a piece accesses places below `length` of the numbers (checked by `Program::new`), which are cells of this thread and at least as many
        // (checked by `Code::on`), and below `homes` of the stored values (`Cut`), passes the third pointer only to `at_argument` and
        // `without_argument`, and calls functions with the types of their operations.
        unsafe {
            let numbers = self.numbers.as_ptr().cast_mut().cast();
            piece(numbers, homes.as_mut_ptr(), &raw const self.calls);
        }
    }
}

/// The value of a call at an argument.
#[expect(unsafe_code, reason = "machine code hands over a pointer")]
pub(super) unsafe extern "C" fn at_argument(calls: *const &dyn Calls, which: u32, argument: f64) -> f64 {
    // SAFETY: `Ready::call` has lent it for the time of the run
    unsafe { *calls }.call(which, Some(argument))
}

/// The value of a call without an argument.
#[expect(unsafe_code, reason = "as above")]
pub(super) unsafe extern "C" fn without_argument(calls: *const &dyn Calls, which: u32) -> f64 {
    // SAFETY: as above
    unsafe { *calls }.call(which, None)
}
