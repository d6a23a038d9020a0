//! The systems: a page each, with the declaration, its source, exact solutions or invariants, and the default run.

pub mod cart_pole;
pub mod chain;
pub mod contact_oscillator;
pub mod double_pendulum;
pub mod exact_decrease;
pub mod gravity_turn;
pub mod knife_edge;
pub mod magnetic;
pub mod nonholonomic_particle;
pub mod particle;
pub mod pendulum;
pub mod planar_pendulum;
pub mod rod_and_wheel;
pub mod rolling_disk;
pub mod sleigh;
pub mod snakeboard;
pub mod sphere;
pub mod spherical_pendulum;

pub use cart_pole::CartPole;
pub use chain::{PlanarChain2, PlanarChain8};
pub use contact_oscillator::ContactOscillator;
pub use exact_decrease::ExactDecrease;
pub use gravity_turn::GravityTurn;
pub use knife_edge::KnifeEdge;
pub use magnetic::MagneticParticle;
pub use nonholonomic_particle::NonholonomicParticle;
pub use particle::{Constant, Curvature, CurvedParticle, Wavy};
pub use pendulum::InertiaWheelPendulum;
pub use planar_pendulum::PlanarPendulum;
pub use rod_and_wheel::RodAndWheel;
pub use rolling_disk::RollingDisk;
pub use sleigh::Sleigh;
pub use snakeboard::Snakeboard;
pub use sphere::Sphere;
pub use spherical_pendulum::SphericalPendulum;
