//! Motions of the Taylor flow that pass close to the pole of their angles. There an angle turns almost at
//! once; elsewhere its velocity is much smaller than the other one's. This slow velocity keeps its own
//! relative accuracy: the conserved momentum of the angle stays constant, and the position is that of the
//! Cartesian equations, which are integrated by DOP853.

use dsocs_core::{Start, Stepper as _, Tolerance};
use dsocs_tests::declared;
use dsocs_tests::text::TaylorFlow;

use dsocs_tests::dop853;

/// The relative error of the conserved momentum, in tolerances, after several passages of some hundred steps:
/// a step may lose a thousand.
const MOMENTUM_ERROR: f64 = 3e6;

const GRAVITY: f64 = 9.81;

declared! {
    /// A pendulum in space, by the angle from below and the angle about the vertical.
    struct Swing;
    coordinates(theta, phi);
    lagrangian = (dot(theta).powi(2) + theta.sin().powi(2) * dot(phi).powi(2)) / 2 + 9.81 * theta.cos();
}

declared! {
    /// A mass on a spring, in polar coordinates.
    struct Polar;
    coordinates(r, phi);
    lagrangian = (dot(r).powi(2) + r.powi(2) * dot(phi).powi(2)) / 2 - r.powi(2) / 2;
}

declared! {
    /// Two uncoupled masses, one of them far slower than the other.
    struct WithSlowMass;
    coordinates(r, phi, y);
    lagrangian = (dot(r).powi(2) + r.powi(2) * dot(phi).powi(2)) / 2 - r.powi(2) / 2 + dot(y).powi(2) / 2 - 1e-7 * y;
}

/// The rates of a pendulum of length one in space: place and velocity.
fn cartesian(_: f64, [x, y, z, u, v, w]: [f64; 6]) -> [f64; 6] {
    let pull = (u * u + v * v + w * w - GRAVITY * z) / (x * x + y * y + z * z);
    [u, v, w, -pull * x, -pull * y, -pull * z - GRAVITY]
}

#[test]
fn a_pendulum_in_space_keeps_the_momentum_about_the_vertical() {
    for (rate, theta) in [
        (1e-3, 1.0_f64),
        (1e-5, 0.4),
        (1e-6, 1.0),
        (1e-6, 2.0),
        (1e-8, 1.3),
    ] {
        for tolerance in [1e-8, 1e-10, 1e-12] {
            let start = Start::second_order([theta, 0.0], [0.0, rate]);
            let mut flow = TaylorFlow::new(&Swing, start, Tolerance::relative(tolerance)).unwrap();
            let end = flow.to(10.0).unwrap();
            let [theta_end, phi] = end.q;
            let momentum = theta_end.sin().powi(2) * end.v[1];
            let own = theta.sin().powi(2) * rate;
            // relative to its own size, or to a millionth of the other velocity where it is smaller
            let size = own.max(1e-6);
            assert!(
                (momentum - own).abs() < MOMENTUM_ERROR * tolerance * size,
                "{rate:e}, {theta}, {tolerance:e}: {momentum:e} for {own:e}"
            );
            let state = [theta.sin(), 0.0, -theta.cos(), 0.0, theta.sin() * rate, 0.0];
            let truth = dop853::integrate(cartesian, state, 10.0, 1e-12);
            let place = [
                theta_end.sin() * phi.cos(),
                theta_end.sin() * phi.sin(),
                -theta_end.cos(),
            ];
            for (x, y) in place.iter().zip(truth) {
                assert!(
                    (x - y).abs() < 1e-9 + 1e3 * tolerance,
                    "{rate:e}, {theta}, {tolerance:e}: {place:?} for {truth:?}"
                );
            }
        }
    }
}

#[test]
fn a_mass_on_a_spring_passes_the_origin() {
    // an ellipse that is nearly a line
    for rate in [1e-2, 1e-4, 1e-6] {
        for tolerance in [1e-8, 1e-10, 1e-12] {
            let start = Start::second_order([1.0, 0.0], [0.0, rate]);
            let mut flow = TaylorFlow::new(&Polar, start, Tolerance::relative(tolerance)).unwrap();
            let end = flow.to(20.0).unwrap();
            let [r, phi] = end.q;
            let truth = [20.0_f64.cos(), rate * 20.0_f64.sin()];
            let momentum = r * r * end.v[1];
            assert!(
                (momentum / rate - 1.0).abs() < MOMENTUM_ERROR * tolerance,
                "{rate:e}, {tolerance:e}: {momentum:e}"
            );
            assert!(
                (r * phi.cos() - truth[0]).abs() < 1e3 * tolerance,
                "{rate:e}, {tolerance:e}"
            );
            // the error across the line, relative to the small extent there
            assert!(
                (r * phi.sin() - truth[1]).abs() < MOMENTUM_ERROR * tolerance * rate + 1e2 * tolerance,
                "{rate:e}, {tolerance:e}: {} for {}",
                r * phi.sin(),
                truth[1]
            );
        }
    }
}

/// A mass that is 1e4 times slower than the one beside it keeps its own relative accuracy: its position after
/// 20 s is the closed form to 1e3 tolerances of its size of 1e-5.
#[test]
fn what_is_slow_all_along_keeps_its_digits_beside_it() {
    for tolerance in [1e-7, 1e-10] {
        let start = Start::second_order([1.0, 0.0, 0.0], [0.0, 1e-4, 1e-6]);
        let mut flow = TaylorFlow::new(&WithSlowMass, start, Tolerance::relative(tolerance)).unwrap();
        let end = flow.to(20.0).unwrap();
        let truth = 1e-6 * 20.0 - 1e-7 * 200.0;
        assert!(
            (end.q[2] - truth).abs() < 1e3 * tolerance * 1e-5,
            "{tolerance:e}: {:e}",
            end.q[2] - truth
        );
    }
}
