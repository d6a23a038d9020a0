//! Parameters of many types, and expressions of them.

use dsocs_core::{System, dsocs};

const GRAVITY: f64 = 10.0;

pub struct Table(Vec<f64>);

impl Table {
    fn value(&self, index: usize) -> f64 {
        self.0[index]
    }
}

#[dsocs {
    coordinates(x);
    let scale = teeth * ratio * table.value(1) + std::f64::consts::PI * 0 + Self::SCALE + user(GRAVITY);
    lagrangian = scale * dot(x).powi(2) - GRAVITY * x * geometry.0 + if damped { x } else { 0 };
}]
pub struct Gear {
    /// Teeth of the gear.
    pub teeth: u32,
    pub ratio: f32,
    pub table: Table,
    pub geometry: (f64, f64),
    pub damped: bool,
}

impl Gear {
    const SCALE: f64 = 1.0;
}

fn user(x: f64) -> f64 {
    x / 10.0
}

#[test]
fn works() {
    let gear = Gear {
        teeth: 4,
        ratio: 0.5,
        table: Table(vec![0.0, 3.0]),
        geometry: (1.0, 2.0),
        damped: true,
    };
    assert_eq!(gear.lagrangian(0.0, &[1.0], &[1.0]), 8.0 - 10.0 + 1.0);
}
