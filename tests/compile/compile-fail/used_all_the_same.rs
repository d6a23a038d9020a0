//! One mistake gives one error, also where the system is used.

use dsocs_core::{System, dsocs};

#[dsocs {
    coordinates(x, y);
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(z).powi(2));
}]
pub struct Particle<'a, T: Copy> {
    pub mass: f64,
    pub label: &'a T,
}

fn energy<S: System<2>>(system: &S) -> f64 {
    system.energy(0.0, &[0.0, 0.0], &[1.0, 1.0])
}

fn main() {
    energy(&Particle {
        mass: 1.0,
        label: &"particle",
    });
}
