//! The systems: a page each, with the declaration, its source, exact solutions or invariants, and the default run.

pub mod cart_pole;
pub mod chain;
pub mod double_pendulum;
pub mod gravity_turn;
pub mod magnetic;
pub mod particle;
pub mod pendulum;
pub mod spherical_pendulum;

pub use cart_pole::CartPole;
pub use chain::{PlanarChain2, PlanarChain8};
pub use gravity_turn::GravityTurn;
pub use magnetic::MagneticParticle;
pub use particle::{Constant, Curvature, CurvedParticle, Wavy};
pub use pendulum::InertiaWheelPendulum;
pub use spherical_pendulum::SphericalPendulum;
