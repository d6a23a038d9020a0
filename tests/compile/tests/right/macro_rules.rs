//! A declaration that a macro by example writes.

use dsocs_core::{System, dsocs};

#[rustfmt::skip] // which would move the lines of the attribute further each time
macro_rules! oscillator {
    ($name:ident, $coordinate:ident, $potential:expr, $mass:ty, [$stiffness:ty; $count:literal]) => {
        #[dsocs {
            coordinates($coordinate);
            let kinetic = mass / 2 * dot($coordinate).powi(2);
            lagrangian = kinetic - $potential * 2;
        }]
        pub struct $name {
            pub mass: $mass,
            pub stiffness: [$stiffness; $count],
        }
    };
}

oscillator!(Linear, x, stiffness[0] * x.powi(2) + mass * 0, f64, [f64; 1]);
oscillator!(Angle, theta, 1 - theta.cos(), f64, [f64; 1]);

#[test]
fn works() {
    let linear = Linear {
        mass: 2.0,
        stiffness: [3.0],
    };
    assert_eq!(linear.lagrangian(0.0, &[1.0], &[2.0]), 4.0 - 6.0);
    let angle = Angle {
        mass: 2.0,
        stiffness: [3.0],
    };
    assert_eq!(angle.lagrangian(0.0, &[0.0], &[2.0]), 4.0);
}

#[test]
fn fields_are_parameters_whose_types_the_macro_was_given() {
    let names: Vec<_> = Linear::PARAMETERS
        .iter()
        .map(|parameter| &*parameter.name)
        .collect();
    assert_eq!(names, ["mass", "stiffness_0"]);
}
