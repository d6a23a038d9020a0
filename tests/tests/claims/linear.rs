//! Linear models: against models by hand, the exponential function, and differences of the motion itself.

mod library;
mod random;
mod step;

use dsocs_core::linear::{LinearModel, LinearizationError, OperatingPoint};
use dsocs_core::{AnyStart, Kernel, SetupError};
use dsocs_tests::text::parsed;

/// A state.
pub fn at(q: &[f64], v: &[f64]) -> AnyStart {
    AnyStart::second_order(q, v)
}

/// The linear model of the continuous motion at a state, with all inputs and outputs.
pub fn model(system: &dyn Kernel, q: &[f64], v: &[f64]) -> LinearModel {
    OperatingPoint::new(system, at(q, v)).continuous().unwrap()
}

/// Checks that two matrices agree.
#[track_caller]
pub fn assert_close(found: &[Vec<f64>], expected: &[Vec<f64>], bar: f64) {
    assert_eq!(found.len(), expected.len());
    for (i, (found, expected)) in found.iter().zip(expected).enumerate() {
        assert_eq!(found.len(), expected.len());
        for (j, (x, y)) in found.iter().zip(expected).enumerate() {
            assert!(
                (x - y).abs() <= bar * (1.0 + y.abs()),
                "({i}, {j}): {x} {y}\n{found:?}"
            );
        }
    }
}

/// The names of the states.
fn states(model: &LinearModel) -> Vec<&str> {
    model.states.iter().map(|state| &*state.name).collect()
}

/// A cart of the mass `M` with a pole, a point mass `m` at the length `l` above it, driven by a force. The equations of motion are those of any
/// textbook: `(M + m) x″ + m l (cos θ θ″ − sin θ θ′²) = u`, `cos θ x″ + l θ″ − g sin θ = 0`.
const CART_POLE: &str = "
    parameters { cart = 1.5, mass = 0.3, length = 0.7, gravity = 9.81, force = 0.0, damping = 0.0 }
    coordinates(
        /// The cart [m]
        x,
        /// The pole [rad]
        theta
    );
    let height = length * theta.cos();
    lagrangian = cart / 2 * dot(x).powi(2)
        + mass / 2 * (dot(x).powi(2) + 2 * length * theta.cos() * dot(x) * dot(theta) + (length * dot(theta)).powi(2))
        - mass * gravity * height;
    external_forces = (force - damping * dot(x), 0);
    observe = [height];
";

#[test]
fn a_cart_pole_by_hand() {
    let (cart, mass, length, gravity) = (1.5, 0.3, 0.7, 9.81);
    let system = parsed(CART_POLE);
    let upright = OperatingPoint::new(&system, at(&[0.2, 0.0], &[0.0, 0.0]))
        .inputs(["force"])
        .outputs(["x", "v_theta", "a_x", "height", "energy"])
        .continuous()
        .unwrap();
    // x″ = (u − m g θ)/M, θ″ = ((M + m) g θ − u)/(M l)
    let [by_angle, by_force] = [-mass * gravity / cart, 1.0 / cart];
    let [turn, turned] = [(cart + mass) * gravity / (cart * length), -1.0 / (cart * length)];
    let a = [
        [0.0, 0.0, 1.0, 0.0],
        [0.0, 0.0, 0.0, 1.0],
        [0.0, by_angle, 0.0, 0.0],
        [0.0, turn, 0.0, 0.0],
    ];
    assert_close(&upright.a, &a.map(Vec::from), 1e-15);
    assert_close(
        &upright.b,
        &[[0.0], [0.0], [by_force], [turned]].map(Vec::from),
        1e-15,
    );
    let c = [
        [1.0, 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, 1.0],
        [0.0, by_angle, 0.0, 0.0],
        [0.0; 4],
        [0.0; 4],
    ];
    assert_close(&upright.c, &c.map(Vec::from), 1e-15);
    assert_close(
        &upright.d,
        &[[0.0], [0.0], [by_force], [0.0], [0.0]].map(Vec::from),
        1e-15,
    );
    assert_eq!(states(&upright), ["x", "theta", "v_x", "v_theta"]);
    assert_eq!(upright.states[3].unit(), Some("rad/s"));
    assert_eq!(upright.outputs[2].unit(), Some("m/s²"));
    assert_close(
        &[upright.measured],
        &[vec![0.2, 0.0, 0.0, 0.7, mass * gravity * length]],
        1e-15,
    );
    assert_eq!(upright.drift, [0.0; 4]);

    // away from it, at rest: cos θ x″ + l θ″ = g sin θ, differentiated by θ at the accelerations x″, θ″ of
    // the drift
    let beside = model(&system, &[0.0, 0.5], &[0.3, 0.0]);
    let [x2, theta2] = [beside.drift[2], beside.drift[3]];
    let (sin, cos) = 0.5_f64.sin_cos();
    assert!((cos * x2 + length * theta2 - gravity * sin).abs() < 1e-14);
    assert!(((cart + mass) * x2 + mass * length * cos * theta2).abs() < 1e-14);
    let [by_theta, by_theta2] = [beside.a[2][1], beside.a[3][1]];
    assert!((cos * by_theta + length * by_theta2 - sin * x2 - gravity * cos).abs() < 1e-13);
    assert!(((cart + mass) * by_theta + mass * length * (cos * by_theta2 - sin * theta2)).abs() < 1e-13);
    // by the damping: the force is −v
    let place = beside
        .inputs
        .iter()
        .position(|input| input.name == "damping")
        .unwrap();
    let force = beside
        .inputs
        .iter()
        .position(|input| input.name == "force")
        .unwrap();
    for row in &beside.b {
        assert!((row[place] + 0.3 * row[force]).abs() < 1e-15);
    }
}

#[test]
fn a_pendulum_in_cartesian_coordinates_is_the_one_in_its_angle() {
    let (length, gravity) = (0.8_f64, 9.81_f64);
    let angle = parsed(
        "parameters { length = 0.8, gravity = 9.81 }
         coordinates(theta);
         lagrangian = (length * dot(theta)).powi(2) / 2 + gravity * length * theta.cos();",
    );
    let plane = parsed(
        "parameters { length = 0.8, gravity = 9.81 }
         coordinates(x, y);
         lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - gravity * y;
         holonomic = x.powi(2) + y.powi(2) - length.powi(2);",
    );
    let omega = (gravity / length).sqrt();
    for (theta, expected) in [
        (0.0, [[0.0, omega], [0.0, -omega]]),
        (core::f64::consts::PI, [[omega, 0.0], [-omega, 0.0]]),
    ] {
        let y = if theta == 0.0 { -length } else { length };
        let both = [
            model(&angle, &[theta], &[0.0]),
            model(&plane, &[0.0, y], &[0.0, 0.0]),
        ];
        for model in both {
            for (found, expected) in model.eigenvalues().unwrap().iter().zip(expected) {
                let apart = (found[0] - expected[0]).hypot(found[1] - expected[1]);
                assert!(apart < 1e-14 * omega, "{found:?} {expected:?}");
            }
        }
    }
    // in motion, the distance along the circle is the length times the angle: the model in angles, in other units, up to the
    // curvature of the circle
    let (theta, rate) = (0.4_f64, 1.3);
    let (sin, cos) = theta.sin_cos();
    let moving = model(
        &plane,
        &[length * sin, -length * cos],
        &[length * rate * cos, length * rate * sin],
    );
    assert_eq!(states(&moving), ["along_x", "v_along_x"]);
    let expected = model(&angle, &[theta], &[rate]);
    // v = Mᵀ δv: with the direction e of the circle, e · d/dt(l ω e(θ)) = l ω′, whose derivative along e(θ₀) has −l ω² · δθ besides
    let curved = [[0.0, 1.0], [expected.a[1][0] - rate * rate, 0.0]];
    assert_close(&moving.a, &curved.map(Vec::from), 1e-14);
    // by the length: with the same way along the tangent, the angle is another one
    let reference = OperatingPoint::new(&plane, at(&[0.0, -length], &[0.0, 0.0]))
        .outputs(["y"])
        .continuous()
        .unwrap();
    assert_close(&reference.d, &[vec![-1.0, 0.0]], 1e-15);
}

#[test]
fn a_sleigh_by_hand() {
    let (mass, inertia, offset, speed) = (2.0, 0.3, 0.4, 1.7);
    let sleigh = parsed(
        "parameters { mass = 2.0, inertia = 0.3, offset = 0.4 }
         coordinates(x, y, theta);
         let across = dot(y) * theta.cos() - dot(x) * theta.sin();
         let along = dot(x) * theta.cos() + dot(y) * theta.sin();
         lagrangian = mass / 2 * (along.powi(2) + (across + offset * dot(theta)).powi(2)) + inertia / 2 * dot(theta).powi(2);
         nonholonomic = across;",
    );
    // along x: u′ = a ω², ω′ = −m a u ω/(I + m a²); y′ = u θ
    let straight = model(&sleigh, &[0.0; 3], &[speed, 0.0, 0.0]);
    assert_eq!(states(&straight), ["x", "y", "theta", "v_x", "v_theta"]);
    let rate = -mass * offset * speed / (inertia + mass * offset * offset);
    let expected = [
        [0.0, 0.0, 0.0, 1.0, 0.0],
        [0.0, 0.0, speed, 0.0, 0.0],
        [0.0, 0.0, 0.0, 0.0, 1.0],
        [0.0; 5],
        [0.0, 0.0, 0.0, 0.0, rate],
    ];
    assert_close(&straight.a, &expected.map(Vec::from), 1e-14);
    // turned by an angle, the eigenvalues stay
    let turned: f64 = 0.9;
    let turned = model(
        &sleigh,
        &[1.0, -2.0, turned],
        &[speed * turned.cos(), speed * turned.sin(), 0.0],
    );
    let [found, expected] = [&turned, &straight].map(|model| model.eigenvalues().unwrap());
    assert!((found[4][0] - rate).abs() < 1e-13 && (expected[4][0] - rate).abs() < 1e-13);
    let drift = OperatingPoint::new(&sleigh, at(&[0.0; 3], &[speed, 0.0, 0.5]))
        .continuous()
        .unwrap()
        .drift;
    assert_close(
        &[drift],
        &[vec![speed, 0.0, 0.5, offset * 0.25, rate * 0.5]],
        1e-14,
    );
}

#[test]
fn a_law_of_second_order_about_its_target() {
    // the force on the cart makes the pole's angle obey θ″ + 2 ζ ω θ′ + ω² θ = 0, so x″ = g θ − l θ″ to first order
    let (damping, omega, length, gravity) = (0.6, 3.0, 0.7, 9.81);
    let held = parsed(
        "parameters { cart = 1.5, mass = 0.3, length = 0.7, gravity = 9.81, damping = 0.6, omega = 3.0 }
         coordinates(x, theta);
         lagrangian = (cart + mass) / 2 * dot(x).powi(2) + mass * length * theta.cos() * dot(x) * dot(theta)
             + mass / 2 * (length * dot(theta)).powi(2) - mass * gravity * length * theta.cos();
         kinematic = ddot(theta) + 2 * damping * omega * dot(theta) + omega.powi(2) * theta;
         constraint_forces = [(1, 0)];",
    );
    let found = OperatingPoint::new(&held, at(&[0.0; 2], &[0.0; 2]))
        .outputs(["force_x", "force_theta"])
        .continuous()
        .unwrap();
    let [spring, brake] = [omega * omega, 2.0 * damping * omega];
    let expected = [
        [0.0, 0.0, 1.0, 0.0],
        [0.0, 0.0, 0.0, 1.0],
        [0.0, gravity + length * spring, 0.0, length * brake],
        [0.0, -spring, 0.0, -brake],
    ];
    assert_close(&found.a, &expected.map(Vec::from), 1e-14);
    // the motor's force, (M + m) x″ + m l θ″, is the law
    let force = |column: usize| 1.8 * expected[2][column] + 0.21 * expected[3][column];
    assert_close(&found.c, &[(0..4).map(force).collect(), vec![0.0; 4]], 1e-14);
    let eigenvalues = found.eigenvalues().unwrap();
    assert!((eigenvalues[2][0] + damping * omega).abs() < 1e-14);
    assert!((eigenvalues[2][1] - omega * (1.0 - damping * damping).sqrt()).abs() < 1e-13);

    // V = (θ′² + ω² θ²)/2 falls at the rate 2 ζ ω θ′²: the same law, multiplied by θ′, which vanishes at the target
    let lyapunov = |branch: &str| {
        parsed(&format!(
            "parameters {{ cart = 1.5, mass = 0.3, length = 0.7, gravity = 9.81, damping = 0.6, omega = 3.0 }}
             coordinates(x, theta);
             lagrangian = (cart + mass) / 2 * dot(x).powi(2) + mass * length * theta.cos() * dot(x) * dot(theta)
                 + mass / 2 * (length * dot(theta)).powi(2) - mass * gravity * length * theta.cos();
             let lyapunov = (dot(theta).powi(2) + (omega * theta).powi(2)) / 2;
             kinematic = dot(lyapunov) + 2 * damping * omega * dot(theta).powi(2);
             {branch}
             constraint_forces = [(1, 0)];"
        ))
    };
    let divided = model(&lyapunov("branch = divide(dot(theta));"), &[0.0; 2], &[0.0; 2]);
    assert_close(&divided.a, &expected.map(Vec::from), 1e-14);
    let plain = lyapunov("");
    let refused = OperatingPoint::new(&plain, at(&[0.0; 2], &[0.0; 2])).continuous();
    assert!(
        matches!(
            refused,
            Err(LinearizationError::Setup(SetupError::Acceleration { .. }))
        ),
        "{refused:?}"
    );
}

#[test]
fn corners_are_refused_and_smooth_pieces_are_not() {
    let with = |force: &str| {
        parsed(&format!(
            "parameters {{ stiffness = 4.0, dry = 0.5 }}
             coordinates(x);
             lagrangian = dot(x).powi(2) / 2 - stiffness / 2 * x.powi(2);
             external_forces = ({force});"
        ))
    };
    let linearized = |force: &str, q: f64, v: f64| {
        let system = with(force);
        OperatingPoint::new(&system, at(&[q], &[v]))
            .continuous()
            .map(|model| model.a[1].clone())
    };
    let error = linearized("-dry * dot(x).signum()", 0.1, 0.0).unwrap_err();
    assert!(
        matches!(&error, LinearizationError::Corner { depends_on, .. } if depends_on == &["dot(x)"]),
        "{error}"
    );
    assert!(
        error.to_string().contains("function of `dot(x)` jumps there"),
        "{error}"
    );
    assert_eq!(
        linearized("-dry * dot(x).signum()", 0.1, 0.2).unwrap(),
        [-4.0, 0.0]
    );
    assert!(linearized("-dry * x.abs()", 0.0, 0.3).is_err());
    assert_eq!(linearized("-dry * x.abs()", -0.1, 0.0).unwrap(), [-3.5, 0.0]);
    // a jump of the second derivative alone is no corner
    assert_eq!(
        linearized("-dry * dot(x) * dot(x).abs()", 0.1, 0.0).unwrap(),
        [-4.0, 0.0]
    );
    assert_eq!(
        linearized("if x < 0 { 0 } else { x.powi(2) }", 0.0, 0.0).unwrap(),
        [-4.0, 0.0]
    );
    assert!(linearized("if x < 0 { 0 } else { x }", 0.0, 0.0).is_err());
    // infinite slopes
    assert!(linearized("-dry * x.abs().sqrt()", 0.0, 0.0).is_err());
    assert!(linearized("1 / x", 0.0, 0.0).is_err());
}

/// Unknown or repeated names, a step of zero, a start of the wrong length and one off its constraint are
/// refused, each with its reason.
#[test]
fn what_cannot_be_had_says_why() {
    let system = parsed(CART_POLE);
    let point = || OperatingPoint::new(&system, at(&[0.0; 2], &[0.0; 2]));
    let message = |result: Result<LinearModel, LinearizationError>| result.unwrap_err().to_string();
    assert_eq!(
        message(point().inputs(["torque"]).continuous()),
        "no parameter is called `torque`, so it is no input; expected `cart`, `mass`, `length`, `gravity`, `force` or `damping`"
    );
    assert!(
        message(point().outputs(["phi"]).continuous())
            .contains("expected `x`, `theta`, `height` or `energy`")
    );
    assert_eq!(
        message(point().outputs(["x", "x"]).step(0.1)),
        "`x` is named twice"
    );
    assert!(message(point().step(0.0)).contains("the step h = 0"));
    let short = OperatingPoint::new(&system, at(&[0.0], &[0.0])).continuous();
    assert!(message(short).contains("q0 has 1 components"));
    let rod = parsed(
        "coordinates(x, y);
         lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2;
         holonomic = x.powi(2) + y.powi(2) - 1;",
    );
    let off = OperatingPoint::new(&rod, at(&[1.1, 0.0], &[0.0, 0.0])).continuous();
    assert!(matches!(
        off,
        Err(LinearizationError::Setup(SetupError::Inconsistent { .. }))
    ));
    let projected = OperatingPoint::new(&rod, at(&[1.1, 0.0], &[0.0, 1.0]).projected())
        .continuous()
        .unwrap();
    assert_eq!(projected.point.any().q, [1.0, 0.0]);
    let jerk = parsed(
        "coordinates(x); lagrangian = dot(x).powi(2) / 2; kinematic = dddot(x) + ddot(x); constraint_forces = [(1)];",
    );
    let third = OperatingPoint::new(&jerk, at(&[0.0], &[0.0])).continuous();
    assert!(matches!(
        third,
        Err(LinearizationError::Setup(SetupError::ThirdOrder { .. }))
    ));
    let massless = parsed("coordinates(x, y); lagrangian = dot(x).powi(2) / 2 - y.powi(2);");
    assert!(
        OperatingPoint::new(&massless, at(&[0.0; 2], &[0.0; 2]))
            .continuous()
            .is_err()
    );
}
