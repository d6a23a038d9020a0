//! The systems of the paper, declared with [`dsocs_core::dsocs`], and the command `dsocs` that runs them.
//!
//! A system is one file of [`systems`] with its entry, and one line of [`registry`]. [`experiment`] measures the paper's
//! errors, [`check`] holds systems against the paper's theorems, [`figure`] draws and knows nothing of mechanics, [`cli`] is what the command does.
#![forbid(unsafe_code)]

#[cfg(feature = "cli")]
pub mod check;
#[cfg(feature = "cli")]
pub mod cli;
#[cfg(feature = "cli")]
pub mod experiment;
#[cfg(feature = "cli")]
pub mod figure;
#[cfg(feature = "cli")]
pub mod reference;
#[cfg(feature = "cli")]
pub mod registry;
#[cfg(feature = "cli")]
pub mod rung;
#[cfg(feature = "cli")]
pub mod stability;
pub mod systems;

pub use systems::{
    CartPole, Constant, ContactOscillator, Curvature, CurvedParticle, ExactDecrease, GravityTurn,
    InertiaWheelPendulum, KnifeEdge, MagneticParticle, NonholonomicParticle, PlanarChain2, PlanarChain8,
    PlanarPendulum, RodAndWheel, RollingDisk, Sleigh, Snakeboard, Sphere, SphericalPendulum, Wavy,
};
pub use systems::{chain, particle, pendulum};
