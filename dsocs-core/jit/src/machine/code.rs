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
    /// The other pieces, if it is cut.
    others: Vec<Piece>,
    /// How many values go from piece to piece.
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
        let f = f.field("pieces", &(1 + self.others.len())).field("homes", &self.homes);
        f.field("length", &self.length).finish_non_exhaustive()
    }
}

thread_local! {
    /// Workspace for values that one piece stores for another; kept, so that a run allocates nothing.
    static HOMES: Cell<Vec<f64>> = const { Cell::new(Vec::new()) };
}

impl Code {
    /// The code of a program whose pieces begin at some places of the memory.
    pub(super) fn new(memory: &Arc<Mmap>, (first, others): (usize, &[usize]), homes: usize, length: usize) -> Self {
        Self {
            first: piece(memory, first),
            others: others.iter().map(|&begin| piece(memory, begin)).collect(),
            homes,
            length,
            memory: Arc::clone(memory),
        }
    }

    /// Runs the program.
    ///
    /// # Errors
    ///
    /// [`TooShort`] if there are fewer numbers than the program has places; then nothing is written.
    #[inline]
    pub fn run(&self, numbers: &[Cell<f64>], calls: &dyn Calls) -> Result<(), TooShort> {
        if numbers.len() < self.length {
            return Err(TooShort {
                found: numbers.len(),
                expected: self.length,
            });
        }
        if self.others.is_empty() {
            // nothing goes from piece to piece
            self.call(self.first, numbers, &mut [], calls);
        } else {
            self.run_in_pieces(numbers, calls);
        }
        Ok(())
    }

    /// The same for a program of several pieces.
    #[inline(never)]
    fn run_in_pieces(&self, numbers: &[Cell<f64>], calls: &dyn Calls) {
        // whoever runs a program inside finds another, empty room, and so does who runs one where the thread ends
        let mut homes = HOMES.try_with(Cell::take).unwrap_or_default();
        if homes.len() < self.homes {
            homes.resize(self.homes, 0.0);
        }
        for &piece in [self.first].iter().chain(&self.others) {
            self.call(piece, numbers, &mut homes, calls);
        }
        let _ = HOMES.try_with(|kept| kept.set(homes));
    }

    /// Runs a piece, where there is room for all.
    #[expect(unsafe_code, reason = "code that was made when the program ran is called")]
    #[inline]
    fn call(&self, piece: Piece, numbers: &[Cell<f64>], homes: &mut [f64], calls: &dyn Calls) {
        debug_assert!(numbers.len() >= self.length && (homes.len() >= self.homes || self.others.is_empty()));
        // SAFETY: it reads and writes places below `length` of the numbers (`Program::new`), which are cells of this thread, and below `homes` of the
        // homes (`Cut`), hands the third pointer to `at_argument` and `without_argument` alone, and calls functions of the types that the operations say.
        unsafe { piece(numbers.as_ptr().cast_mut().cast(), homes.as_mut_ptr(), &raw const calls) };
    }
}

/// The value of a call at an argument.
#[expect(unsafe_code, reason = "machine code hands over a pointer")]
pub(super) unsafe extern "C" fn at_argument(calls: *const &dyn Calls, which: u32, argument: f64) -> f64 {
    // SAFETY: `Code::pieces` passes a pointer that is valid during the run
    unsafe { *calls }.call(which, Some(argument))
}

/// The value of a call without an argument.
#[expect(unsafe_code, reason = "as above")]
pub(super) unsafe extern "C" fn without_argument(calls: *const &dyn Calls, which: u32) -> f64 {
    // SAFETY: as above
    unsafe { *calls }.call(which, None)
}
