//! The systems of the paper, declared with [`dsocs_core::dsocs`], and the command `dsocs` that runs them.
//!
//! A system is one file ([`particle`], [`pendulum`], [`mod@chain`]) and one entry of [`registry`]. [`experiment`] measures the paper's
//! errors, [`figure`] draws and knows nothing of mechanics, [`cli`] is what the command does.
#![forbid(unsafe_code)]

pub mod chain;
pub mod cli;
pub mod experiment;
pub mod figure;
pub mod particle;
pub mod pendulum;
pub mod reference;
pub mod registry;
pub mod stability;

pub use chain::{PlanarChain2, PlanarChain8};
pub use particle::{Constant, Curvature, CurvedParticle, Wavy};
pub use pendulum::InertiaWheelPendulum;
