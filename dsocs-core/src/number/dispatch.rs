//! The machine's own instructions.
//!
//! A program is compiled for every machine of its kind, so without fused products and wide registers. What is worth it
//! is compiled a second time with them, and the machine is asked when the program runs. The results of both differ by
//! rounding.

/// Work that is compiled for more than one machine. All that it calls is to be inlined.
pub(crate) trait Work {
    /// What it gives.
    type Output;

    /// Does the work, with products and sums rounded once if `FUSED`.
    fn run<const FUSED: bool>(self) -> Self::Output;
}

/// Does the work with the best instructions that there are, or, if `rounded`, with those that all machines have: then the results are the
/// same on all.
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

/// The same with wide registers alone, for work on many numbers side by side. Nothing is fused, and so the results are
/// the same on every machine.
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
