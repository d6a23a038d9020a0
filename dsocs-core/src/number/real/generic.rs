//! Calls of the user's functions in generated code, and the error message for one that is not generic over
//! its number.

// these wrappers cost nothing once they are inlined
#![allow(clippy::inline_always)]

use super::Real;

/// The function takes and returns the number type of the caller.
///
/// Required for every argument and for the result at once, so that an unsuitable function gives one error.
/// `F` is the type of the closure: so the compiler proposes no bound for the number type of generated code,
/// which a user could not write down.
#[diagnostic::on_unimplemented(
    message = "a function that a declaration calls has to be generic over its number, and this one is of `{T}`: write it as \
               `fn f<R: dsocs_core::Real>(x: R) -> R`",
    label = "expected a function of `R: dsocs_core::Real` in place of `{T}`",
    note = "derivatives come from other numbers than `f64`; inside the function, `R::from(2.0)` makes a number of an `f64`"
)]
pub trait Generic<T, F>: Sized {
    /// The number in the type that the function takes.
    fn given(self) -> T;
    /// The function's result in the number type of the caller.
    fn taken(result: T) -> Self;
}

#[diagnostic::do_not_recommend]
impl<T: Real, F> Generic<T, F> for T {
    #[inline(always)]
    fn given(self) -> T {
        self
    }
    #[inline(always)]
    fn taken(result: T) -> Self {
        result
    }
}

/// Calls a function of one argument. Its types are inferred first, then the bounds are checked.
#[inline(always)]
pub fn call_1<F, A, T, N>(f: F, a: N) -> N
where
    F: Fn(A) -> T,
    N: Generic<A, F> + Generic<T, F>,
{
    <N as Generic<T, F>>::taken(f(Generic::<A, F>::given(a)))
}

/// [`call_1`] with two arguments.
#[inline(always)]
pub fn call_2<F, A, B, T, N>(f: F, a: N, b: N) -> N
where
    F: Fn(A, B) -> T,
    N: Generic<A, F> + Generic<B, F> + Generic<T, F>,
{
    <N as Generic<T, F>>::taken(f(Generic::<A, F>::given(a), Generic::<B, F>::given(b)))
}

/// [`call_1`] with three arguments.
#[inline(always)]
pub fn call_3<F, A, B, C, T, N>(f: F, a: N, b: N, c: N) -> N
where
    F: Fn(A, B, C) -> T,
    N: Generic<A, F> + Generic<B, F> + Generic<C, F> + Generic<T, F>,
{
    <N as Generic<T, F>>::taken(f(
        Generic::<A, F>::given(a),
        Generic::<B, F>::given(b),
        Generic::<C, F>::given(c),
    ))
}

/// [`call_1`] with four arguments.
#[inline(always)]
pub fn call_4<F, A, B, C, D, T, N>(f: F, a: N, b: N, c: N, d: N) -> N
where
    F: Fn(A, B, C, D) -> T,
    N: Generic<A, F> + Generic<B, F> + Generic<C, F> + Generic<D, F> + Generic<T, F>,
{
    <N as Generic<T, F>>::taken(f(
        Generic::<A, F>::given(a),
        Generic::<B, F>::given(b),
        Generic::<C, F>::given(c),
        Generic::<D, F>::given(d),
    ))
}

/// [`call_1`] with five arguments.
#[inline(always)]
pub fn call_5<F, A, B, C, D, E, T, N>(f: F, a: N, b: N, c: N, d: N, e: N) -> N
where
    F: Fn(A, B, C, D, E) -> T,
    N: Generic<A, F> + Generic<B, F> + Generic<C, F> + Generic<D, F> + Generic<E, F> + Generic<T, F>,
{
    <N as Generic<T, F>>::taken(f(
        Generic::<A, F>::given(a),
        Generic::<B, F>::given(b),
        Generic::<C, F>::given(c),
        Generic::<D, F>::given(d),
        Generic::<E, F>::given(e),
    ))
}

/// [`call_1`] with six arguments.
#[inline(always)]
pub fn call_6<F, A, B, C, D, E, G, T, N>(f: F, a: N, b: N, c: N, d: N, e: N, g: N) -> N
where
    F: Fn(A, B, C, D, E, G) -> T,
    N: Generic<A, F>
        + Generic<B, F>
        + Generic<C, F>
        + Generic<D, F>
        + Generic<E, F>
        + Generic<G, F>
        + Generic<T, F>,
{
    <N as Generic<T, F>>::taken(f(
        Generic::<A, F>::given(a),
        Generic::<B, F>::given(b),
        Generic::<C, F>::given(c),
        Generic::<D, F>::given(d),
        Generic::<E, F>::given(e),
        Generic::<G, F>::given(g),
    ))
}
