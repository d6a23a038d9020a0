//! Functions of the user's: free ones, methods of parameters, and methods of numbers.

use dsocs_core::{Real, System, dsocs};

fn friction<R: Real>(v: R) -> R {
    v * v * v
}

mod laws {
    use dsocs_core::Real;

    pub fn spring<R: Real>(x: R, y: R) -> R {
        (x - y).powi(2)
    }
}

trait Smooth {
    fn smooth(self) -> Self;
}

impl<R: Real> Smooth for R {
    fn smooth(self) -> Self {
        (self * self + 1.0).sqrt()
    }
}

#[dsocs {
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - stiffness * laws::spring(x, y) + x.smooth();
    let power = friction(dot(x)).smooth();
    kinematic = dot(power) + ddot(y);
    constraint_forces = [(1, y.smooth())];
    branch = divide(dot(x).smooth());
    observe = [power];
}]
pub struct Sliders {
    pub stiffness: f64,
}

#[test]
fn works() {
    let system = Sliders { stiffness: 2.0 };
    assert_eq!(system.lagrangian(0.0, &[0.0, 1.0], &[1.0, 1.0]), 1.0 - 2.0 + 1.0);
}
