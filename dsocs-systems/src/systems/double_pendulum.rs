//! The planar double pendulum: two links of [`planar_chain!`](crate::planar_chain).
//!
//! Its motion is chaotic at large angles; the energy is its only invariant.

/// Both links at an angle where the motion is far from linear.
#[cfg(feature = "dsocs")]
#[must_use]
pub fn entry() -> crate::Entry {
    crate::Entry::new(crate::PlanarChain2::default())
        .named("double-pendulum")
        .described("the planar double pendulum, two point masses on massless rods")
        .source("textbooks, e.g. Landau and Lifshitz, Mechanics, section 5, problem 1")
        .start([2.0, 1.0], [0.0, 0.0])
        .step(0.005)
        .until(20.0)
        .drawn(super::rods::<2>)
}
