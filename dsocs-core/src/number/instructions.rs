//! Sets of machine instructions, chosen when the program runs.

use core::cell::Cell;
use core::fmt;

use crate::number::lanes::{Lanes, Register};
use crate::number::scalar::Scalar as _;

/// Sets of instructions that compute several numbers at once.
///
/// An [`Ensemble`](crate::Ensemble) uses the widest set that the machine has; no compiler flag is needed. All of them give the same
/// bits, because no product is fused with a sum. A debug build (with `debug_assertions`) has only [`Compiled`](Self::Compiled), because
/// compiling every step three times would take longer than debug runs gain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum Instructions {
    /// The set for which the program was compiled: by default on x86-64 SSE2, with two numbers in a register.
    Compiled,
    /// AVX2 with four numbers in a register (x86-64-v3).
    Avx2,
    /// AVX-512 with eight numbers in a register (x86-64-v4).
    Avx512,
}

/// Whether steps are also compiled for wider instructions than those of the program.
pub(crate) const OTHERS: bool = cfg!(any(test, not(debug_assertions)));

impl Instructions {
    /// All sets, the narrowest first.
    pub const ALL: [Self; 3] = [Self::Compiled, Self::Avx2, Self::Avx512];

    /// The widest set that this machine has.
    ///
    /// ```
    /// use dsocs_core::Instructions;
    ///
    /// assert!(Instructions::best().are_available());
    /// ```
    #[must_use]
    pub fn best() -> Self {
        let available = Self::ALL.into_iter().rev().find(|these| these.are_available());
        available.unwrap_or(Self::Compiled)
    }

    /// Whether this machine, and this build, has the set.
    #[must_use]
    pub fn are_available(self) -> bool {
        match self {
            Self::Compiled => true,
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => OTHERS && pulp::x86::V3::try_new().is_some(),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => OTHERS && pulp::x86::V4::try_new().is_some(),
            #[cfg(not(target_arch = "x86_64"))]
            Self::Avx2 | Self::Avx512 => false,
        }
    }
}

impl fmt::Display for Instructions {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Compiled => "as compiled",
            Self::Avx2 => "AVX2",
            Self::Avx512 => "AVX-512",
        })
    }
}

/// Work on lanes. All functions that it calls have to be inlined: others are not compiled for the
/// instructions, and are many times slower.
pub(crate) trait InLanes {
    /// The result.
    type Output;

    /// Does the work.
    fn run(self) -> Self::Output;
}

/// Registers of instructions that are chosen when the program runs.
pub(crate) trait Chosen: Register {
    /// Proof that the machine has them.
    type Token: Copy + Send + Sync;

    /// The proof, if the machine has them.
    fn token() -> Option<Self::Token>;

    /// Does work that is compiled for these instructions.
    fn run<W: InLanes>(token: Self::Token, work: W) -> W::Output;

    /// Calls `work` with a workspace of `length` lanes. Sparse elimination needs it; it uses the registers
    /// for which the program was compiled.
    fn with_workspace<T>(length: usize, work: impl FnOnce(&mut [Lanes<Self>]) -> T) -> T {
        work(&mut vec![Lanes::splat(0.0); length])
    }
}

impl Chosen for wide::f64x8 {
    type Token = ();

    fn token() -> Option<()> {
        Some(())
    }

    #[inline]
    fn run<W: InLanes>((): (), work: W) -> W::Output {
        work.run()
    }

    fn with_workspace<T>(length: usize, work: impl FnOnce(&mut [Lanes]) -> T) -> T {
        thread_local! {
            static ROOM: Cell<Vec<Lanes>> = const { Cell::new(Vec::new()) };
        }
        // a user's function in the rows may run another system, whose elimination then takes an empty workspace of its own
        let mut room = ROOM.take();
        if room.len() < length {
            room.resize(length, Lanes::splat(0.0));
        }
        let result = work(&mut room[..length]);
        ROOM.set(room);
        result
    }
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use pulp::{Simd, WithSimd, x86::V3, x86::V4};

    use super::{Chosen, InLanes};
    use crate::number::lanes::x86::{Avx2, Avx512};

    /// Work whose caller is compiled for more instructions.
    struct Vectorized<W>(W);

    impl<W: InLanes> WithSimd for Vectorized<W> {
        type Output = W::Output;

        #[inline(always)]
        #[allow(clippy::inline_always)] // compiled for the instructions of its caller
        fn with_simd<S: Simd>(self, _: S) -> W::Output {
            self.0.run()
        }
    }

    macro_rules! chosen {
        ($($registers:ty: $token:ty),*) => {
            $(
                impl Chosen for $registers {
                    type Token = $token;

                    fn token() -> Option<$token> {
                        <$token>::try_new()
                    }

                    #[inline]
                    fn run<W: InLanes>(token: $token, work: W) -> W::Output {
                        Simd::vectorize(token, Vectorized(work))
                    }
                }
            )*
        };
    }

    chosen!(Avx2: V3, Avx512: V4);
}
