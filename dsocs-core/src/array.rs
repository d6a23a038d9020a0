//! Arrays by loops.
//!
//! [`core::array::from_fn`] and the method `map` of arrays bring half a dozen functions of the standard library for every closure and every
//! number of components; what is here is part of the function that it is called in.

#![allow(clippy::inline_always)] // that is what it is for

/// The array whose components are what a function makes of their places.
#[inline(always)]
pub(crate) fn from_fn<T: Copy + Default, const N: usize>(mut component: impl FnMut(usize) -> T) -> [T; N] {
    let mut array = [T::default(); N];
    for (i, place) in array.iter_mut().enumerate() {
        *place = component(i);
    }
    array
}

/// The array of what a function makes of each component.
#[inline(always)]
pub(crate) fn map<T: Copy, U: Copy + Default, const N: usize>(
    array: &[T; N],
    mut component: impl FnMut(T) -> U,
) -> [U; N] {
    let mut mapped = [U::default(); N];
    for (place, &x) in mapped.iter_mut().zip(array) {
        *place = component(x);
    }
    mapped
}
