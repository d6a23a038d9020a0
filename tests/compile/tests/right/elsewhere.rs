//! Names that mean something in other languages: functions of the user's own by their paths, and the constants of the circle without
//! an import.

#![allow(unused_qualifications)] // it is how a message says to write a call of a function of the user
use dsocs_core::{Real, System, dsocs};

fn sign<R: Real>(v: R) -> R {
    (v * 20.0).tanh()
}

trait Powers {
    fn squared(self) -> Self;
}

impl<R: Real> Powers for R {
    fn squared(self) -> Self {
        self * self
    }
}

#[dsocs {
    coordinates(x, y);
    lagrangian = (Powers::squared(dot(x)) + dot(y).powi(2)) / 2 - PI * x + (0.5 * TAU).cos() * y - self::sign(x);
}]
pub struct Circle;

mod own {
    use dsocs_core::dsocs;

    const PI: f64 = 3.0;

    #[dsocs {
        coordinates(x);
        lagrangian = dot(x).powi(2) / 2 - PI * x + 0.0 * PI.powi(2);
    }]
    pub struct Own;
}

mod imported {
    #![deny(warnings)]
    use std::f64::consts::PI;

    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(x);
        lagrangian = dot(x).powi(2) / 2 - PI * x;
    }]
    pub struct Imported;
}

#[test]
fn works() {
    let pi = std::f64::consts::PI;
    let value = Circle.lagrangian(0.0, &[1.0, 2.0], &[3.0, 0.0]);
    assert_eq!(value, 4.5 - pi - 2.0 - 20.0_f64.tanh());
    assert_eq!(own::Own.lagrangian(0.0, &[1.0], &[0.0]), -3.0);
    assert_eq!(imported::Imported.lagrangian(0.0, &[1.0], &[0.0]), -pi);
}
