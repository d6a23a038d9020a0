//! Regulators that start at rest and come to rest. The factor of their constraint follows only with the other
//! equations; it is divided out, also where it is zero.
//!
//! A motor pushes along `α(q)`. With a Lyapunov function `V = E + k s²/2`, where `ds = ⟨α, dq⟩`, it obeys
//! `dV/dt = -g w²` with `w = ⟨α, v⟩`. So `w` is a factor of this constraint where the other equations hold,
//! and the law `u = -k s - g w` is left. The reference is the same motor as an external force, which needs no
//! constraint and no factor.

use dsocs_core::{Start, Stepper, Tolerance};
use dsocs_tests::declared;
use dsocs_tests::fit::slope;
use dsocs_tests::scenes::random::Random;
use dsocs_tests::text::{Flow, System, TaylorFlow};

/// Declares a system twice: with the constraint, and with its control law as an external force.
macro_rules! regulated {
    (
        $(#[$meta:meta])* $ruled:ident, $driven:ident { $($field:ident: $type:tt),* };
        { $($statements:tt)* } push $push:tt; force $force:tt;
    ) => {
        declared! {
            $(#[$meta])*
            #[derive(Clone, Debug)]
            struct $ruled { $($field: $type,)* spring: f64, gain: f64 }
            $($statements)*
            kinematic = dot(kinetic + potential + spring / 2 * s.powi(2)) + gain * w.powi(2);
            constraint_forces = [$push];
            branch = divide(w);
        }

        declared! {
            struct $driven { $($field: $type,)* spring: f64, gain: f64 }
            $($statements)*
            let law = -spring * s - gain * w;
            external_forces = $force;
        }

        impl $ruled {
            fn driven(&self) -> $driven {
                let Self { $($field,)* spring, gain } = self.clone();
                $driven { $($field,)* spring, gain }
            }
        }
    };
}

regulated! {
    /// Three masses that any springs and inertial couplings join; the motor pushes along any direction.
    Sprung, SprungDriven { masses: [f64; 9], springs: [f64; 9], along: [f64; 3] };
    {
        coordinates(x: [3]);
        let kinetic = sum(0..3, |i| sum(0..3, |j| masses[3 * i + j] / 2 * dot(x[i]) * dot(x[j])));
        let potential = sum(0..3, |i| sum(0..3, |j| springs[3 * i + j] / 4 * (x[i] - x[j]).powi(2) + springs[3 * i + i] / 2 * x[i].sin().powi(2)));
        lagrangian = kinetic - potential;
        let s = sum(0..3, |i| along[i] * x[i]);
        let w = dot(s);
    }
    push (|i| along[i]); force (|i| along[i] * law);
}

regulated! {
    /// A swing of three links, with a motor between any of them: the mass matrix varies.
    Swing, SwingDriven { masses: [f64; 3], lengths: [f64; 3], along: [f64; 3], gravity: f64 };
    {
        coordinates(x: [3]);
        let beyond = |i| sum(i..3, |k| masses[k]);
        let cosine = |i, j| x[i].cos() * x[j].cos() + x[i].sin() * x[j].sin();
        let speed = |i| lengths[i] * dot(x[i]);
        let kinetic = sum(0..3, |i| beyond(i) * (speed(i).powi(2) / 2 + sum(0..i, |j| cosine(i, j) * speed(i) * speed(j))));
        let potential = -gravity * sum(0..3, |i| beyond(i) * lengths[i] * x[i].cos());
        lagrangian = kinetic - potential;
        let s = sum(0..3, |i| along[i] * x[i]);
        let w = dot(s);
    }
    push (|i| along[i]); force (|i| along[i] * law);
}

regulated! {
    /// A cart with a pendulum; the motor drives the cart.
    CartPole, CartPoleDriven { cart: f64, bob: f64, length: f64 };
    {
        coordinates(x, theta);
        let kinetic = (cart + bob) / 2 * dot(x).powi(2) + bob * length * theta.cos() * dot(x) * dot(theta)
            + bob * length.powi(2) / 2 * dot(theta).powi(2);
        let potential = -bob * length * theta.cos();
        lagrangian = kinetic - potential;
        let s = x;
        let w = dot(x);
    }
    push (1, 0); force (law, 0);
}

regulated! {
    /// A body on springs; a winch pulls it along a direction that varies.
    Winch, WinchDriven { mass: f64, stiffness: f64 };
    {
        coordinates(x, y);
        let kinetic = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
        let potential = stiffness / 2 * (x.powi(2) + 2 * y.powi(2));
        lagrangian = kinetic - potential;
        let s = x + x.powi(3) / 3 + y.sin();
        let w = dot(s);
    }
    push (1 + x.powi(2), y.cos()); force ((1 + x.powi(2)) * law, y.cos() * law);
}

regulated! {
    /// A sled on a blade, tied by springs, with a motor that turns it: beside a constraint of velocities.
    Sled, SledDriven { mass: f64, inertia: f64, stiffness: f64 };
    {
        coordinates(x, y, phi);
        let kinetic = mass / 2 * (dot(x).powi(2) + dot(y).powi(2)) + inertia / 2 * dot(phi).powi(2);
        let potential = stiffness / 2 * (x.powi(2) + 2 * y.powi(2));
        lagrangian = kinetic - potential;
        nonholonomic = dot(x) * phi.sin() - dot(y) * phi.cos();
        let s = phi;
        let w = dot(phi);
    }
    push (0, 0, 1); force (0, 0, law);
}

/// Declares an arm twice: with a constraint on `V = E + β E²/2 + k s²/2`, whose law is `u = -(k s + g w)/(1 + β E)`, and with this law as an
/// external force. Its mass matrix varies, and the discrete constraint does not have the factor.
macro_rules! arm {
    (
        $(#[$meta:meta])* $ruled:ident, $driven:ident;
        $kinetic:expr, $potential:expr; $s:ident; push $push:tt; force $force:tt;
    ) => {
        declared! {
            $(#[$meta])*
            struct $ruled { inertia: f64, weight: f64, bent: f64, spring: f64, gain: f64 }
            coordinates(r, theta);
            let kinetic = $kinetic;
            let potential = $potential;
            lagrangian = kinetic - potential;
            let energy = kinetic + potential;
            let s = $s;
            kinematic = dot(energy + bent / 2 * energy.powi(2) + spring / 2 * s.powi(2)) + gain * dot(s).powi(2);
            constraint_forces = [$push];
            branch = divide(dot(s));
        }

        declared! {
            struct $driven { inertia: f64, weight: f64, bent: f64, spring: f64, gain: f64 }
            coordinates(r, theta);
            let kinetic = $kinetic;
            let potential = $potential;
            lagrangian = kinetic - potential;
            let s = $s;
            let law = -(spring * s + gain * dot(s)) / (1 + bent * (kinetic + potential));
            external_forces = $force;
        }
    };
}

arm! {
    /// A mass that slides along an arm on a spring, with a motor in the arm's pivot.
    Slider, SliderDriven;
    dot(r).powi(2) / 2 + (inertia + r.powi(2)) / 2 * dot(theta).powi(2),
    (r - 1).powi(2) - weight * r * theta.cos(); theta; push (0, 1); force (0, law);
}

arm! {
    /// The arm with a motor that pulls the mass along it.
    Winder, WinderDriven;
    dot(r).powi(2) / 2 + (inertia + r.powi(2)) / 2 * dot(theta).powi(2),
    (r - 1).powi(2) - weight * r * theta.cos() + theta.powi(2); r; push (1, 0); force (law, 0);
}

/// From rest: the continuous motions are the same, and the discrete one converges to them with the order 2.
fn from_rest<S: System<N>, const N: usize>(ruled: &S, driven: &impl System<N>, q: [f64; N]) {
    with_steps([0.02, 0.01, 0.005], ruled, driven, q);
}

/// `from_rest` with given steps.
fn with_steps<S: System<N>, const N: usize>(
    steps: [f64; 3],
    ruled: &S,
    driven: &impl System<N>,
    q: [f64; N],
) {
    let name = ruled.name();
    let start = Start::second_order(q, [0.0; N]);
    let tolerance = Tolerance::relative(1e-13);
    let times = [0.5, 1.0, 1.5, 2.0];
    let mut driven = TaylorFlow::new(driven, start, tolerance).unwrap();
    let exact = times.map(|t| driven.to(t).unwrap().q);
    let distance = |found: [[f64; N]; 4]| {
        let all = found.as_flattened().iter().zip(exact.as_flattened());
        all.map(|(found, exact)| (found - exact).abs())
            .fold(0.0, f64::max)
    };
    let mut same = TaylorFlow::new(ruled, start, tolerance).unwrap();
    let error = distance(times.map(|t| same.to(t).unwrap().q));
    assert!(error < 1e-9, "{name}: {error}");
    let errors = steps.map(|h| {
        let mut flow = Flow::new(ruled, h, start).unwrap();
        distance(times.map(|t| flow.to(t).unwrap().q))
    });
    let order = slope(&steps, &errors);
    assert!((order - 2.0).abs() < 0.02, "{name}: {order} {errors:?}");
}

/// A direction in which some components are often zero.
fn direction(random: &mut Random) -> [f64; 3] {
    let mut along = [0.0; 3];
    while along.iter().all(|x| *x == 0.0) {
        along = along.map(|_| {
            if random.chance(0.5) {
                random.between(-1.0, 1.0)
            } else {
                0.0
            }
        });
    }
    along
}

/// Eight random systems of three coupled masses with a motor along a random direction: the continuous motion
/// is that of the motor as an external force, to 1e-9, and the step converges to it with the order 2.
#[test]
fn random_masses_on_springs() {
    for seed in 1..=8 {
        let random = &mut Random::new(seed);
        let root: [f64; 9] = core::array::from_fn(|_| random.between(-1.0, 1.0));
        let masses = core::array::from_fn(|ij| {
            let (i, j) = (ij / 3, ij % 3);
            let product: f64 = (0..3).map(|k| root[3 * i + k] * root[3 * j + k]).sum();
            product + f64::from(u8::from(i == j))
        });
        let system = Sprung {
            masses,
            springs: core::array::from_fn(|_| random.between(0.0, 2.0)),
            along: direction(random),
            spring: random.between(0.0, 2.0),
            gain: random.between(0.1, 1.0),
        };
        let q: [f64; 3] = core::array::from_fn(|_| random.between(-0.5, 0.5));
        from_rest(&system, &system.driven(), q);
    }
}

#[test]
fn random_swings() {
    for seed in 1..=5 {
        let random = &mut Random::new(seed);
        let system = Swing {
            masses: core::array::from_fn(|_| random.between(0.5, 2.0)),
            lengths: core::array::from_fn(|_| random.between(0.5, 1.5)),
            along: direction(random),
            gravity: random.between(0.5, 2.0),
            spring: random.between(0.0, 2.0),
            gain: random.between(0.1, 1.0),
        };
        let q: [f64; 3] = core::array::from_fn(|_| random.between(-0.5, 0.5));
        from_rest(&system, &system.driven(), q);
    }
}

#[test]
fn a_cart_a_winch_and_a_sled() {
    for seed in 1..=4 {
        let random = &mut Random::new(seed);
        let mut positive = || random.between(0.5, 2.0);
        let (mass, inertia, stiffness, spring) = (positive(), positive(), positive(), positive());
        let gain = 0.4;
        let cart = CartPole {
            cart: mass,
            bob: inertia,
            length: stiffness,
            spring,
            gain,
        };
        // its errors at twice these steps are not yet those of the order alone
        with_steps(
            [0.01, 0.005, 0.0025],
            &cart,
            &cart.driven(),
            [0.4, 0.3 * positive()],
        );
        let winch = Winch {
            mass,
            stiffness,
            spring,
            gain,
        };
        from_rest(&winch, &winch.driven(), [0.2, -0.4]);
        let sled = Sled {
            mass,
            inertia,
            stiffness,
            spring,
            gain,
        };
        from_rest(&sled, &sled.driven(), [0.5, 0.3, 0.4]);
    }
}

/// The constraint that replaces the declared one gives a discrete system like any other: of order 2,
/// symmetric in time, and with a flow by the theorem.
fn is_a_discrete_system<S: System<2>>(ruled: &S, driven: &impl System<2>, q: [f64; 2]) {
    let name = ruled.name();
    with_steps([0.005, 0.0025, 0.00125], ruled, driven, q);
    let mut flow = Flow::new(ruled, 0.02, Start::second_order(q, [0.0; 2])).unwrap();
    let (mut granted, mut there) = (0, Vec::new());
    flow.certify(2.0, &mut |node, regularity| {
        granted += u32::from(regularity.is_some_and(|at| at.grants_flow()));
        there.push(node.q);
        core::ops::ControlFlow::Continue(())
    })
    .unwrap();
    assert!(granted >= 100, "{name}: {granted}");
    flow.reverse().unwrap();
    let back = flow.to(0.2).unwrap().q;
    let apart = back
        .iter()
        .zip(&there[10])
        .map(|(back, there)| (back - there).abs());
    assert!(
        apart.fold(0.0, f64::max) < 1e-10,
        "{name}: {back:?} {:?}",
        there[10]
    );
}

#[test]
fn where_the_mass_matrix_varies_it_is_a_discrete_system_all_the_same() {
    let [inertia, weight, bent, spring, gain] = [0.3, 0.8, 0.2, 1.1, 0.6];
    let slider = Slider {
        inertia,
        weight,
        bent,
        spring,
        gain,
    };
    let driven = SliderDriven {
        inertia,
        weight,
        bent,
        spring,
        gain,
    };
    is_a_discrete_system(&slider, &driven, [1.3, 0.7]);
    let winder = Winder {
        inertia,
        weight,
        bent,
        spring,
        gain,
    };
    let driven = WinderDriven {
        inertia,
        weight,
        bent,
        spring,
        gain,
    };
    is_a_discrete_system(&winder, &driven, [0.6, -0.5]);
}

/// A decaying motion is followed until it has stopped, and stays there.
#[test]
fn to_rest() {
    let cart = CartPole {
        cart: 1.0,
        bob: 0.5,
        length: 1.0,
        spring: 2.0,
        gain: 1.5,
    };
    let start = Start::second_order([0.4, 0.5], [0.0; 2]);
    let mut flow = Flow::new(&cart, 0.05, start).unwrap();
    let node = flow.to(1500.0).unwrap();
    assert!(node.q.iter().chain(&node.v).all(|x| x.abs() < 1e-12), "{node:?}");
}

/// Declares a pendubot, two links with a motor in the shoulder (Fantoni and Lozano, Non-linear Control for Underactuated Mechanical Systems,
/// chapter 5). The angles are from the horizontal and from the first link.
macro_rules! pendubot {
    ($(#[$meta:meta])* $name:ident { $($statements:tt)* }) => {
        declared! {
            $(#[$meta])*
            struct $name { inertia: [f64; 3], weight: [f64; 2] }
            coordinates(shoulder, elbow);
            let m_11 = inertia[0] + inertia[1] + 2 * inertia[2] * elbow.cos();
            let m_12 = inertia[1] + inertia[2] * elbow.cos();
            let kinetic = m_11 / 2 * dot(shoulder).powi(2) + m_12 * dot(shoulder) * dot(elbow) + inertia[1] / 2 * dot(elbow).powi(2);
            let potential = weight[0] * shoulder.sin() + weight[1] * (shoulder + elbow).sin();
            lagrangian = kinetic - potential;
            // the energy missing to the upright equilibrium
            let missing = kinetic + potential - weight[0] - weight[1];
            $($statements)*
        }
    };
}

pendubot! {
    /// A Lyapunov function with the square of the energy: its rate is of degree 5 in the velocities, with the
    /// shoulder's velocity as a factor.
    Pumped {
        let lyapunov = missing.powi(2) / 2 + dot(shoulder).powi(2) / 2 + shoulder.powi(2) / 2;
        kinematic = dot(lyapunov) + dot(shoulder).powi(2);
        constraint_forces = [(1, 0)];
        branch = divide(dot(shoulder));
    }
}

pendubot! {
    /// The law by hand: `E u + s'' + s + s' = 0`, with `s''` from the equations of motion.
    PumpedByHand {
        let bend = inertia[2] * elbow.sin();
        // the generalized forces on shoulder and elbow without acceleration
        let first = weight[0] * shoulder.cos() + weight[1] * (shoulder + elbow).cos() - bend * dot(elbow) * (2 * dot(shoulder) + dot(elbow));
        let second = weight[1] * (shoulder + elbow).cos() + bend * dot(shoulder).powi(2);
        let determinant = m_11 * inertia[1] - m_12.powi(2);
        let free = (m_12 * second - inertia[1] * first) / determinant;
        let torque = -(free + shoulder + dot(shoulder)) / (missing + inertia[1] / determinant);
        external_forces = (torque, 0);
    }
}

#[test]
fn an_energy_is_pumped_from_rest() {
    let (inertia, weight) = ([0.0308, 0.0106, 0.0095], [2.05, 0.62]);
    let by_hand = PumpedByHand { inertia, weight };
    with_steps(
        [0.01, 0.005, 0.0025],
        &Pumped { inertia, weight },
        &by_hand,
        [-1.5, 0.0],
    );
}

declared! {
    /// A constraint with the factor, but not as a polynomial.
    struct NoPolynomial {}
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    kinematic = (ddot(x) + x) * dot(x).sinh();
    constraint_forces = [(1)];
    branch = divide(dot(x));
}

/// A constraint whose factor is no polynomial is not divided, so it has no value at rest: both starts are
/// refused, with advice on a velocity and on `branch`. With a velocity the acceleration is exact.
#[test]
fn what_has_no_value_at_rest_is_told_with_advice() {
    let [second, paper] = [Start::second_order, Start::paper].map(|start| start([1.0], [0.0]));
    let error = Flow::new(&NoPolynomial {}, 0.1, second).map(|_| ()).unwrap_err();
    let message = error.to_string();
    assert!(
        message.contains("`dot(x)` is zero there")
            && message.contains("is at rest there")
            && message.contains("`branch`"),
        "{message}"
    );
    let mut flow = Flow::new(&NoPolynomial {}, 0.1, paper).unwrap();
    let message = flow.advance().map(|_| ()).unwrap_err().to_string();
    assert!(
        message.contains("is at rest there") && message.contains("`branch`"),
        "{message}"
    );
    // as the message advises: with a velocity, and with the quotient
    let moving = Start::second_order([1.0], [0.1]);
    assert!((Flow::new(&NoPolynomial {}, 0.1, moving).unwrap().node().a[0] + 1.0).abs() < 1e-14);
}
