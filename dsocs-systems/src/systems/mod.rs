//! The systems. Each has one file, with the declaration, its source, exact solutions or invariants, and the default run. Bodies that turn in space are text files
//! (`texts`), which are read when they are asked for.

pub mod arm;
pub mod cart_pole;
pub mod chain;
pub mod clothoid;
pub mod contact_oscillator;
pub mod crane;
pub mod double_pendulum;
pub mod exact_decrease;
pub mod friction;
pub mod gravity_turn;
pub mod kapitza;
pub mod knife_edge;
pub mod magnetic;
pub mod nonholonomic_particle;
pub mod particle;
pub mod pendulum;
pub mod planar_pendulum;
pub mod quaternion_top;
pub mod rod_and_wheel;
pub mod rolling_disk;
pub mod sleigh;
pub mod snakeboard;
pub mod sphere;
pub mod spherical_pendulum;
#[cfg(feature = "dsocs")]
pub mod texts;
pub mod train;
pub mod vehicle;

pub use arm::Arm;
pub use cart_pole::CartPole;
pub use chain::{PlanarChain2, PlanarChain8};
pub use clothoid::Clothoid;
pub use contact_oscillator::ContactOscillator;
pub use crane::Crane;
pub use exact_decrease::ExactDecrease;
pub use friction::{FrictionPendulum, StalledPendulum};
pub use gravity_turn::GravityTurn;
pub use kapitza::Kapitza;
pub use knife_edge::KnifeEdge;
pub use magnetic::MagneticParticle;
pub use nonholonomic_particle::NonholonomicParticle;
pub use particle::{Constant, Curvature, CurvedParticle, Wavy};
pub use pendulum::InertiaWheelPendulum;
pub use planar_pendulum::PlanarPendulum;
pub use quaternion_top::QuaternionTop;
pub use rod_and_wheel::RodAndWheel;
pub use rolling_disk::RollingDisk;
pub use sleigh::Sleigh;
pub use snakeboard::Snakeboard;
pub use sphere::Sphere;
pub use spherical_pendulum::SphericalPendulum;
pub use train::Train;
pub use vehicle::Vehicle;

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
        quaternion_top::entry(),
        arm::entry(),
        nonholonomic_particle::entry(),
        knife_edge::entry(),
        rolling_disk::entry(),
        sleigh::entry(),
        snakeboard::entry(),
        vehicle::entry(),
        contact_oscillator::entry(),
        particle::entry(),
        pendulum::entry(),
        gravity_turn::entry(),
        cart_pole::entry(),
        exact_decrease::entry(),
        rod_and_wheel::entry(),
        friction::motor_entry(),
        friction::pivot_entry(),
        clothoid::entry(),
        crane::entry(),
        friction::stalled_entry(),
    ]
}

/// A body in the plane, drawn as a rod along its direction, with the path of its point `(x, y)`.
#[cfg(feature = "dsocs")]
pub(crate) fn blade([x, y]: [f64; 2], direction: f64, length: f64) -> crate::entry::Drawing {
    let half = [length / 2.0 * direction.cos(), length / 2.0 * direction.sin()];
    crate::entry::Drawing::new()
        .trail([x, y])
        .rod([x - half[0], y - half[1]], [x + half[0], y + half[1]])
}

/// A pendulum that is upright at the angle 0, with a wheel at its end whose spoke rotates with it by `psi`.
/// The equations contain no sizes: the rod is drawn one metre long.
#[cfg(feature = "dsocs")]
pub(crate) fn wheel_on_a_rod(theta: f64, psi: f64) -> crate::entry::Drawing {
    let end = [theta.sin(), theta.cos()];
    // angles of the declaration are counted clockwise from the upright
    crate::entry::Drawing::new().rod([0.0, 0.0], end).wheel(
        end,
        0.2,
        std::f64::consts::FRAC_PI_2 - theta - psi,
    )
}

/// A chain of rods from a pivot, by their angles against the downward vertical.
#[cfg(feature = "dsocs")]
pub(crate) fn rods<const N: usize>(
    angles: &[f64; N],
    parameters: &crate::entry::Parameters,
) -> crate::entry::Drawing {
    let mut joints = vec![[0.0, 0.0]];
    for (place, angle) in angles.iter().enumerate() {
        let length = parameters.get(&format!("lengths_{place}"));
        let [x, y] = joints[place];
        joints.push([x + length * angle.sin(), y - length * angle.cos()]);
    }
    let mut drawing = crate::entry::Drawing::new().trail(joints[N]);
    for ends in joints.windows(2) {
        drawing = drawing.rod(ends[0], ends[1]);
    }
    joints[1..]
        .iter()
        .fold(drawing, |drawing, &joint| drawing.point(joint))
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
            let texts = [
                &description.coordinates,
                &description.parameters,
                &description.observables,
            ];
            for quantity in texts.into_iter().flatten() {
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
