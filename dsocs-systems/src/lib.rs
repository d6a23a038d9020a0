//! The systems of the paper and others, declared with [`dsocs_core::dsocs`]; a command line for any list of systems; and the book, the
//! module `guide`, which begins with *A system in a text file*.
//!
//! # Your own systems on the command line
//!
//! A crate that depends on this one, `dsocs-systems = { version = "0.1", default-features = false, features = ["cli"] }`, gets
//! the command line for its own systems by one line of code, `cli::main([Entry::new(system)])`. See `cli` and `entry`.
//!
//! # Layout
//!
//! | module | feature | |
//! |---|---|---|
//! | `systems` | `systems` | one file for each system: its declaration, exact solutions or invariants, and its entry |
//! | `entry` | `cli` | a system with its defaults, as the command line knows it |
//! | `cli` | `cli` | the commands `run`, `watch`, `check`, `stability`, `linearize`, `equilibrium`, `list`, `text`, `completions`, `man` |
//! | `check` | `cli` | measures whether the paper's theorems hold on a motion |
//! | `stability` | `cli` | hard cases, for any system (`stability::any`) and for those of this crate |
//! | `figure` | `cli` | draws plots; it contains no mechanics |
//! | `sweep` | `sweep` | many runs by a plan, on one machine or on a cluster: the commands `sweep` and `plot` |
//! | `guide` | `cli` | the book |
//! | `cli::dsocs`, `experiment`, `reference` | `dsocs` (default) | the program `dsocs`: this crate's systems, and the commands `paper`, `report` and `new` |
//!
//! The unit tests are built without the systems and without everything that uses them (`not(test)`), because a second build of the systems takes as
//! long as the first. Tests that need a system of this crate are in the folder `tests`.
#![forbid(unsafe_code)]

#[cfg(feature = "cli")]
pub mod check;
#[cfg(feature = "cli")]
pub mod cli;
#[cfg(feature = "cli")]
pub mod entry;
#[cfg(all(feature = "dsocs", not(test)))]
pub mod experiment;
#[cfg(feature = "cli")]
pub mod figure;
#[cfg(feature = "cli")]
pub mod guide;
#[cfg(all(feature = "dsocs", not(test)))]
pub mod reference;
#[cfg(feature = "cli")]
pub mod stability;
#[cfg(feature = "sweep")]
pub mod sweep;
#[cfg(all(feature = "systems", not(test)))]
pub mod systems;
#[cfg(feature = "cli")]
mod temporary;
#[cfg(feature = "cli")]
pub mod warnings;

#[cfg(feature = "cli")]
pub use entry::Entry;
#[cfg(all(feature = "systems", not(test)))]
pub use systems::{
    Arm, CartPole, Clothoid, Constant, ContactOscillator, Crane, Curvature, CurvedParticle, ExactDecrease,
    FrictionPendulum, GravityTurn, InertiaWheelPendulum, Kapitza, KnifeEdge, MagneticParticle,
    NonholonomicParticle, PlanarChain2, PlanarChain8, PlanarPendulum, QuaternionTop, RodAndWheel,
    RollingDisk, Sleigh, Snakeboard, Sphere, SphericalPendulum, StalledPendulum, Train, Vehicle, Wavy,
};
#[cfg(all(feature = "systems", not(test)))]
pub use systems::{chain, particle, pendulum};
