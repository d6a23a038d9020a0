//! The commands, each with its arguments.

pub mod check;
pub mod linear;
pub mod list;
pub mod manual;
#[cfg(all(feature = "dsocs", not(test)))]
pub mod new;
#[cfg(all(feature = "dsocs", not(test)))]
pub mod paper;
#[cfg(all(feature = "dsocs", not(test)))]
pub mod report;
pub mod run;
pub mod stability;
#[cfg(feature = "sweep")]
pub mod sweep;
pub mod text;
pub mod watch;
