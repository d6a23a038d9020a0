//! Random planar scenes: trees of bodies on rods, with springs, rods and wheels as constraints, and motors that obey
//! constraints of second order; and a second formulation of their steps that shares nothing with the attribute or the solver.
//!
//! [`scene`] is a scene as data with its mechanics in Cartesian terms, [`discrete`] its steps in twice the
//! precision, [`random`] draws scenes and states, and [`exact`] follows a motion with the effect of rounding
//! on it. [`text`] writes scenes as declarations, and [`table`] some of them for the table of hard cases.
//! [`mod@dop853`] is a reference for motions of any kind.
//!
//! It is a crate of its own so that its arithmetic, on which tests spend their time, is optimized, while the
//! tests are not.

pub mod discrete;
pub mod dop853;
pub mod double;
pub mod elimination;
pub mod exact;
pub mod number;
pub mod random;
pub mod scene;
pub mod table;
pub mod text;

/// The extent of a test, such as its number of draws or its duration: the long one with `DSOCS_LONG=1 cargo test …`, else the short one,
/// which finds an error that occurs in one of several draws.
#[must_use]
pub fn short_or_long<T>(short: T, long: T) -> T {
    if std::env::var_os("DSOCS_LONG").is_some_and(|value| value == "1") {
        long
    } else {
        short
    }
}
