//! Code that is compiled for the instructions of the machine at hand.
//!
//! A program is compiled for every machine of its kind, so without fused products and wide registers. Code that gains by them is compiled a
//! second time with them; which of the two runs is decided at run time. The results of both differ by rounding.

/// Work that is compiled for more than one machine. All functions that it calls have to be inlined.
pub(crate) trait Work {
    /// The result.
    type Output;

    /// Does the work, with products and sums rounded once if `FUSED`.
    fn run<const FUSED: bool>(self) -> Self::Output;
}

/// Does the work with the best instructions of the machine. If `rounded`, only with those that all machines
/// have: then the results are the same on all.
#[inline]
pub(crate) fn run_as<W: Work>(rounded: bool, work: W) -> W::Output {
    #[cfg(target_arch = "x86_64")]
    if !rounded && let Some(simd) = pulp::x86::V3::try_new() {
        return pulp::Simd::vectorize(simd, Fused(work));
    }
    // every machine of this kind has fused products
    #[cfg(target_arch = "aarch64")]
    if !rounded {
        return work.run::<true>();
    }
    let _ = rounded;
    work.run::<false>()
}

/// [`run_as`] with wide registers alone, for work on many numbers side by side. Nothing is fused, so the
/// results are the same on every machine.
#[inline]
pub(crate) fn run_wide<W: Work>(work: W) -> W::Output {
    #[cfg(target_arch = "x86_64")]
    if let Some(simd) = pulp::x86::V3::try_new() {
        return pulp::Simd::vectorize(simd, Rounded(work));
    }
    work.run::<false>()
}

/// Does work that puts numbers into registers by itself; products and sums are rounded once where that is fast.
#[inline]
pub(crate) fn registers<W: pulp::WithSimd>(work: W) -> W::Output {
    #[cfg(target_arch = "x86_64")]
    if let Some(simd) = pulp::x86::V3::try_new() {
        return pulp::Simd::vectorize(simd, work);
    }
    #[cfg(target_arch = "aarch64")]
    return pulp::Arch::new().dispatch(work);
    #[cfg(not(target_arch = "aarch64"))]
    work.with_simd(pulp::Scalar)
}

/// Work whose products are rounded before they are summed.
#[cfg(target_arch = "x86_64")]
struct Rounded<W>(W);

#[cfg(target_arch = "x86_64")]
impl<W: Work> pulp::WithSimd for Rounded<W> {
    type Output = W::Output;

    #[inline(always)]
    #[allow(clippy::inline_always)] // for the machine's own instructions
    fn with_simd<S: pulp::Simd>(self, _: S) -> W::Output {
        self.0.run::<false>()
    }
}

/// Work with fused products.
#[cfg(target_arch = "x86_64")]
struct Fused<W>(W);

#[cfg(target_arch = "x86_64")]
impl<W: Work> pulp::WithSimd for Fused<W> {
    type Output = W::Output;

    #[inline(always)]
    #[allow(clippy::inline_always)] // for the machine's own instructions
    fn with_simd<S: pulp::Simd>(self, _: S) -> W::Output {
        self.0.run::<true>()
    }
}
