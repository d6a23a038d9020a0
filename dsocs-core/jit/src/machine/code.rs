//! Machine code, and how it is run: all that is unsafe.

use std::cell::Cell;
use std::fmt;
use std::sync::Arc;

use memmap2::{Mmap, MmapMut};

use crate::{Calls, TooShort};

/// A piece of a program: the numbers, the values that go from piece to piece, and what is called.
type Piece = unsafe extern "C" fn(*mut f64, *mut f64, *const &dyn Calls);

/// Memory in which code may run, and not be changed any more.
pub(super) fn executable(code: &[u8]) -> std::io::Result<Mmap> {
    let mut memory = MmapMut::map_anon(code.len().max(1))?;
    if let Some(room) = memory.get_mut(..code.len()) {
        room.copy_from_slice(code);
    }
    memory.make_exec()
}

/// The function that begins somewhere in the memory.
#[expect(unsafe_code, reason = "bytes become a function")]
fn piece(memory: &Mmap, begin: usize) -> Piece {
    // SAFETY: there stands a function that `Compiler::piece` has made, with the signature of `Piece` and the calling convention of `extern "C"` on this
    // machine. `Code` keeps the memory, which is not changed any more, as long as the function.
    unsafe { std::mem::transmute::<*const u8, Piece>(memory.as_ptr().add(begin)) }
}

/// A program as machine code.
#[derive(Clone)]
pub struct Code {
    pieces: Vec<Piece>,
    /// How many values go from piece to piece.
    homes: usize,
    /// How many numbers it is run on.
    length: usize,
    /// Where the pieces are.
    #[expect(dead_code, reason = "the pieces live as long as it does")]
    memory: Arc<Mmap>,
}

impl fmt::Debug for Code {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut f = f.debug_struct("Code");
        let f = f.field("pieces", &self.pieces.len()).field("homes", &self.homes);
        f.field("length", &self.length).finish_non_exhaustive()
    }
}

thread_local! {
    /// Room for values that go from piece to piece; kept, so that a run allocates nothing.
    static HOMES: Cell<Vec<f64>> = const { Cell::new(Vec::new()) };
}

impl Code {
    /// The code of a program whose pieces begin at some places of the memory.
    pub(super) fn new(memory: &Arc<Mmap>, begins: &[usize], homes: usize, length: usize) -> Self {
        Self {
            pieces: begins.iter().map(|&begin| piece(memory, begin)).collect(),
            homes,
            length,
            memory: Arc::clone(memory),
        }
    }

    /// Runs the program.
    ///
    /// # Errors
    ///
    /// [`TooShort`] if there are fewer numbers than the program has places. Nothing is run then.
    #[inline]
    pub fn run(&self, numbers: &mut [f64], calls: &dyn Calls) -> Result<(), TooShort> {
        if numbers.len() < self.length {
            return Err(TooShort {
                found: numbers.len(),
                expected: self.length,
            });
        }
        if self.homes == 0 {
            self.pieces(numbers, &mut [], calls);
        } else {
            self.run_with_homes(numbers, calls);
        }
        Ok(())
    }

    /// The same where values go from piece to piece.
    #[inline(never)]
    fn run_with_homes(&self, numbers: &mut [f64], calls: &dyn Calls) {
        // whoever runs a program inside finds another, empty room, and so does who runs one where the thread ends
        let mut homes = HOMES.try_with(Cell::take).unwrap_or_default();
        if homes.len() < self.homes {
            homes.resize(self.homes, 0.0);
        }
        self.pieces(numbers, &mut homes, calls);
        let _ = HOMES.try_with(|kept| kept.set(homes));
    }

    /// Runs the pieces, where there is room for all.
    #[expect(unsafe_code, reason = "code that was made when the program ran is called")]
    #[inline]
    fn pieces(&self, numbers: &mut [f64], homes: &mut [f64], calls: &dyn Calls) {
        debug_assert!(numbers.len() >= self.length && homes.len() >= self.homes);
        for piece in &self.pieces {
            // SAFETY: it reads and writes places below `length` of the numbers (`Program::new`) and below `homes` of the homes (`Cut`), hands the third
            // pointer to `at_argument` and `without_argument` alone, and calls functions of the types that the operations say.
            unsafe { piece(numbers.as_mut_ptr(), homes.as_mut_ptr(), &raw const calls) };
        }
    }
}

/// What a program calls, at an argument.
#[expect(unsafe_code, reason = "machine code hands over a pointer")]
pub(super) unsafe extern "C" fn at_argument(calls: *const &dyn Calls, which: u32, argument: f64) -> f64 {
    // SAFETY: `Code::pieces` has lent it for the time of the run
    unsafe { *calls }.call(which, Some(argument))
}

/// The same without an argument.
#[expect(unsafe_code, reason = "as above")]
pub(super) unsafe extern "C" fn without_argument(calls: *const &dyn Calls, which: u32) -> f64 {
    // SAFETY: as above
    unsafe { *calls }.call(which, None)
}
