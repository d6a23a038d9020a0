//! Blocks, choices and the functions of `f64`.

use dsocs_core::{System, dsocs};

#[dsocs {
    coordinates(x, y);
    let kinetic = {
        let vx = dot(x);
        let vy = dot(y);
        (vx * vx + vy * vy) / 2
    };
    let wall = if x < 0 && !(y >= 1) { x.powi(2) } else if x > limit { (x - limit).powi(2) } else { 0 };
    lagrangian = mass * kinetic - wall - y.min(x).max(limit) - f64::hypot(x, y) - x.mul_add(2, y).exp2().log(3);
    let all = x.sqrt() + x.cbrt() + x.exp() + x.exp_m1() + x.ln() + x.ln_1p() + x.log10() + x.log2() + x.sin()
        + x.cos() + x.tan() + x.asin() + x.acos() + x.atan() + x.sinh() + x.cosh() + x.tanh() + x.asinh()
        + (x + 1).acosh() + x.atanh() + x.abs() + x.signum() + x.recip() + x.to_radians() + x.to_degrees()
        + x.powi(-3) + x.powf(y) + x.atan2(y);
    kinematic = dot(all) + ddot(y);
    constraint_forces = [(0, 1)];
    observe = [kinetic, all];
}]
pub struct Particle {
    pub mass: f64,
    pub limit: f64,
}

#[test]
fn works() {
    let particle = Particle {
        mass: 2.0,
        limit: 1.0,
    };
    let value = particle.lagrangian(0.0, &[0.5, 0.25], &[1.0, 2.0]);
    let expected = 5.0 - 1.0 - f64::hypot(0.5, 0.25) - 1.25 * 2.0_f64.ln() / 3.0_f64.ln();
    assert!((value - expected).abs() < 1e-14);
}
