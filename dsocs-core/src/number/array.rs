//! Arrays by loops.
//!
//! [`core::array::from_fn`] and the method `map` of arrays bring half a dozen functions of the standard
//! library for every closure and every number of components. These functions are inlined into their callers
//! instead.

#![allow(clippy::inline_always)] // conversions of arrays, which cost nothing when inlined

/// An array of a literal size, whose size is kept out of signatures that do not need it.
pub trait Array<T>: Copy + Send + Sync + AsRef<[T]> + AsMut<[T]> {
    /// The number of components.
    const LENGTH: usize;

    /// The first components of a slice; `None` if it is shorter.
    fn read(slice: &[T]) -> Option<&Self>;

    /// The first components of a slice, and the rest; `None` if it is shorter.
    fn split(slice: &mut [T]) -> Option<(&mut Self, &mut [T])>;
}

impl<T: Copy + Send + Sync, const K: usize> Array<T> for [T; K] {
    const LENGTH: usize = K;

    #[inline(always)]
    fn read(slice: &[T]) -> Option<&Self> {
        slice.first_chunk()
    }

    #[inline(always)]
    fn split(slice: &mut [T]) -> Option<(&mut Self, &mut [T])> {
        slice.split_first_chunk_mut()
    }
}
