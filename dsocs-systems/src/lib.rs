//! The systems of the paper, declared with [`dsocs_core::dsocs`], and the command `dsocs` that runs them.
//!
//! A system is one file of [`systems`] with its entry, and one line of [`registry`]. [`experiment`] measures the paper's
//! errors, [`check`] holds systems against the paper's theorems, [`figure`] draws and knows nothing of mechanics, [`cli`] is what the command does.
#![forbid(unsafe_code)]

pub mod check;
pub mod cli;
pub mod experiment;
pub mod figure;
pub mod reference;
pub mod registry;
pub mod rung;
pub mod stability;
pub mod systems;

pub use systems::{
    CartPole, Constant, ContactOscillator, Curvature, CurvedParticle, ExactDecrease, GravityTurn,
    InertiaWheelPendulum, KnifeEdge, MagneticParticle, NonholonomicParticle, PlanarChain2, PlanarChain8,
    PlanarPendulum, RodAndWheel, RollingDisk, Sleigh, Snakeboard, Sphere, SphericalPendulum, Wavy,
};
pub use systems::{chain, particle, pendulum};
