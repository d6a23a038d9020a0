//! The systems: a page each, with the declaration, its source, exact solutions or invariants, and the default run.

pub mod arm;
pub mod cart_pole;
pub mod chain;
pub mod contact_oscillator;
pub mod double_pendulum;
pub mod exact_decrease;
pub mod friction;
pub mod gravity_turn;
pub mod heavy_top;
pub mod kapitza;
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
pub mod train;

pub use arm::Arm;
pub use cart_pole::CartPole;
pub use chain::{PlanarChain2, PlanarChain8};
pub use contact_oscillator::ContactOscillator;
pub use exact_decrease::ExactDecrease;
pub use friction::{FrictionPendulum, StalledPendulum};
pub use gravity_turn::GravityTurn;
pub use heavy_top::HeavyTop;
pub use kapitza::Kapitza;
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
pub use train::Train;

/// The entries of all systems, kind by kind.
#[cfg(feature = "dsocs")]
#[must_use]
pub fn all() -> Vec<crate::Entry> {
    vec![
        chain::entry(),
        double_pendulum::entry(),
        spherical_pendulum::entry(),
        magnetic::entry(),
        kapitza::entry(),
        train::entry(),
        planar_pendulum::entry(),
        sphere::entry(),
        heavy_top::entry(),
        arm::entry(),
        nonholonomic_particle::entry(),
        knife_edge::entry(),
        rolling_disk::entry(),
        sleigh::entry(),
        snakeboard::entry(),
        contact_oscillator::entry(),
        particle::entry(),
        pendulum::entry(),
        gravity_turn::entry(),
        cart_pole::entry(),
        exact_decrease::entry(),
        rod_and_wheel::entry(),
        friction::motor_entry(),
        friction::pivot_entry(),
        friction::stalled_entry(),
    ]
}

#[cfg(all(test, feature = "dsocs"))]
mod tests {
    use super::*;
    use crate::entry::Kind;

    #[test]
    fn every_entry_is_consistent() {
        for mut entry in all() {
            entry.verify().unwrap();
            assert!(entry.default_start().is_some() && entry.origin().is_some());
            let description = entry.description().clone();
            let said = [
                &description.coordinates,
                &description.parameters,
                &description.observables,
            ];
            for quantity in said.into_iter().flatten() {
                assert!(
                    !quantity.meaning().is_empty() && quantity.unit().is_some(),
                    "{}: {quantity:?}",
                    entry.name()
                );
            }
            for (parameter, value) in entry.parameters() {
                entry.set(parameter.name, value + 1.0).unwrap();
                let parameters = entry.parameters();
                let mut set = parameters.iter().filter(|(other, _)| *other == parameter);
                assert_eq!(set.next().map(|(_, value)| *value), Some(value + 1.0));
            }
        }
    }

    #[test]
    fn kinds_follow_from_the_declarations() {
        let kinds: Vec<_> = all()
            .iter()
            .map(|entry| (entry.name().to_owned(), entry.kind()))
            .collect();
        for (name, kind) in [
            ("chain", Kind::Unconstrained),
            ("sphere", Kind::Holonomic),
            ("snakeboard", Kind::Nonholonomic),
            ("particle", Kind::SecondOrder),
            ("exact-decrease", Kind::SecondOrder),
            ("rod-and-wheel", Kind::Mixed),
            ("train", Kind::Unconstrained),
            ("arm", Kind::Holonomic),
        ] {
            assert!(kinds.contains(&(name.to_owned(), kind)), "{name}");
        }
    }
}
