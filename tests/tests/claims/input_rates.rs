//! Inputs that stand under a `dot(…)` of the declaration cannot change in a run: their own rates would be
//! missing.

use dsocs_core::prelude::{Inputs, Node, RunError, Start, Stepper, Tolerance, dsocs};
use dsocs_core::{Composition, DerivativeError, Ensemble, InputError, Path, Samples};
use dsocs_tests::declared;
use dsocs_tests::text::{ComposedFlow, Flow, TaylorFlow};

use dsocs_tests::dop853;

/// A load on a cable from a cart; the cable's length is a number.
#[dsocs {
    coordinates(x, theta);
    let across = x + length * theta.sin();
    let up = -length * theta.cos();
    lagrangian = cart / 2 * dot(x).powi(2) + load / 2 * (dot(across).powi(2) + dot(up).powi(2)) - load * gravity * up;
    external_forces = (push, 0);
}]
#[derive(Clone)]
struct Crane {
    cart: f64,
    load: f64,
    length: f64,
    gravity: f64,
    push: f64,
}

declared! {
    /// The length is a function of time.
    #[derive(Clone)]
    struct Winch {
        cart: f64,
        load: f64,
        base: f64,
        swing: f64,
        rate: f64,
        gravity: f64,
    }
    coordinates(x, theta);
    let length = base + swing * (rate * t).sin();
    let across = x + length * theta.sin();
    let up = -length * theta.cos();
    lagrangian = cart / 2 * dot(x).powi(2) + load / 2 * (dot(across).powi(2) + dot(up).powi(2)) - load * gravity * up;
}

/// The length is given by samples.
#[dsocs {
    coordinates(x, theta);
    let across = x + length.at(t) * theta.sin();
    let up = -length.at(t) * theta.cos();
    lagrangian = cart / 2 * dot(x).powi(2) + load / 2 * (dot(across).powi(2) + dot(up).powi(2)) - load * gravity * up;
}]
#[derive(Clone)]
struct Sampled {
    cart: f64,
    load: f64,
    length: Samples,
    gravity: f64,
}

declared! {
    /// A motor on `y` makes a function decrease.
    #[derive(Clone)]
    struct Law {
        stiffness: f64,
        gain: f64,
    }
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2;
    let lyapunov = (dot(x).powi(2) + dot(y).powi(2) + stiffness * (x.powi(2) + y.powi(2))) / 2;
    kinematic = dot(lyapunov) + gain * dot(y).powi(2);
    constraint_forces = [(0, 1)];
}

const CRANE: Crane = Crane {
    cart: 1.5,
    load: 0.7,
    length: 1.2,
    gravity: 9.81,
    push: 0.0,
};

/// The base, the swing and the rate of the length as a function of time.
const LENGTH: [f64; 3] = [1.2, 0.3, 1.7];

/// The length at a time, and its first two derivatives.
fn length(t: f64) -> [f64; 3] {
    let [base, swing, rate] = LENGTH;
    let (sin, cos) = (rate * t).sin_cos();
    [base + swing * sin, swing * rate * cos, -swing * rate * rate * sin]
}

fn start() -> Start<2> {
    Start::second_order([0.0, 0.4], [0.1, -0.2])
}

/// The motion with the length as a function of time, from equations that were found by hand.
fn by_hand(end: f64) -> [f64; 4] {
    let Crane {
        cart, load, gravity, ..
    } = CRANE;
    let rate = |t: f64, [_, theta, v, w]: [f64; 4]| {
        let ([l, l1, l2], (sin, cos)) = (length(t), theta.sin_cos());
        // along the cable's normal: l θ″ + x″ cos θ = −2 l′ θ′ − g sin θ; along x: (M + m) x″ + m l cos θ θ″ = m (…)
        let across = -2.0 * l1 * w - gravity * sin;
        let along = -load * (l2 * sin + 2.0 * l1 * w * cos - l * w * w * sin);
        let x = (along - load * cos * across) / (cart + load - load * cos * cos);
        [v, w, x, (across - x * cos) / l]
    };
    dop853::integrate_from(rate, (0.0, [0.0, 0.4, 0.1, -0.2]), end, 1e-13)
}

#[test]
fn are_refused_by_every_method() {
    let refused = |result: Result<(), RunError>, name: &str| {
        let Err(error) = result else {
            panic!("`{name}` was taken");
        };
        let RunError::Input(input) = &error else {
            panic!("{error:?}");
        };
        assert_eq!(
            **input,
            InputError::Rate {
                parameter: name.to_owned().into()
            }
        );
        let text = error.to_string();
        assert!(
            text.contains("`Samples`") && text.contains("a function of `t`"),
            "{text}"
        );
    };
    let tolerance = Tolerance::relative(1e-12);
    let mut flow = Flow::new(&CRANE, 0.01, start()).unwrap();
    let mut composed = ComposedFlow::new(&CRANE, 0.01, Composition::SUZUKI_4, start()).unwrap();
    let mut taylor = TaylorFlow::new(&CRANE, start(), tolerance).unwrap();
    let runs: [&mut dyn Inputs<2>; 3] = [&mut flow, &mut composed, &mut taylor];
    for run in runs {
        refused(run.set_input("length", 1.3), "length");
        assert_eq!(run.input("length"), Some(1.2));
        // inputs outside of any `dot`
        run.set_input("push", 0.2).unwrap();
        run.set_input("gravity", 9.8).unwrap();
    }
    let plans = |plan: &[[f64; 2]]| [plan.to_vec()];
    let ensemble = || Ensemble::new(&CRANE, 0.01).unwrap().starts([start()]);
    refused(
        ensemble().held("length", plans(&[[0.5, 1.3]])).map(|_| ()),
        "length",
    );
    assert!(ensemble().held("push", plans(&[[0.5, 0.1]])).is_ok());
    match Path::plan(&CRANE, 0.01, start(), ["length"], &[[1.2], [1.3]]) {
        Err(DerivativeError::Run(error)) => refused(Err(error), "length"),
        other => panic!("{other:?}"),
    }
    // a jump of a function whose decrease is declared would be no decrease; the rate of the decrease may jump
    let law = Law {
        stiffness: 2.0,
        gain: 0.3,
    };
    let mut flow = Flow::new(&law, 0.01, Start::second_order([0.5, 0.0], [0.0, 1.0])).unwrap();
    refused(flow.set_input("stiffness", 2.1), "stiffness");
    flow.set_input("gain", 0.4).unwrap();
    flow.to(0.1).unwrap();
}

/// A field that is not a number is no parameter: the error names it.
#[test]
fn of_other_types_are_told() {
    let sampled = Sampled {
        cart: 1.5,
        load: 0.7,
        length: Samples::linear([(0.0, 1.0), (1.0, 1.2)]).unwrap(),
        gravity: 9.81,
    };
    let mut flow = Flow::new(&sampled, 0.01, start()).unwrap();
    let Err(RunError::Input(error)) = flow.set_input("length", 1.3) else {
        panic!("samples were taken for a number");
    };
    let expected = InputError::Type {
        field: "length".to_owned(),
        ty: "Samples".to_owned(),
    };
    assert_eq!(*error, expected);
    assert!(
        error.to_string().contains("parameters are fields of type `f64`"),
        "{error}"
    );
}

/// A lane or a run may have a value of its own from the start.
#[test]
fn may_vary_between_runs() {
    let lengths = [0.8, 1.2, 1.6];
    let ends = Ensemble::new(&CRANE, 0.01).unwrap().starts([start(); 3]);
    let ends = ends.varied("length", lengths.to_vec()).unwrap().to(1.0);
    for (length, end) in lengths.into_iter().zip(ends) {
        let crane = Crane { length, ..CRANE };
        let alone = Flow::new(&crane, 0.01, start()).unwrap().to(1.0).unwrap();
        let end = end.unwrap();
        let off = (0..2).map(|i| (end.q[i] - alone.q[i]).abs()).fold(0.0, f64::max);
        assert!(off < 1e-13, "{length}: {off:e}");
    }
}

/// Written as functions of time, as the message advises, the length gives the motion of equations by hand.
#[test]
fn are_right_as_functions_of_time() {
    let exact = by_hand(2.0);
    let [base, swing, rate] = LENGTH;
    let Crane {
        cart, load, gravity, ..
    } = CRANE;
    let winch = Winch {
        cart,
        load,
        base,
        swing,
        rate,
        gravity,
    };
    let start = start();
    let node = TaylorFlow::new(&winch, start, Tolerance::relative(1e-13));
    let node = node.unwrap().to(2.0).unwrap();
    let off = |node: &Node<2>| {
        let now = [node.q[0], node.q[1], node.v[0], node.v[1]];
        let parts = now.iter().zip(&exact).map(|(now, exact)| (now - exact).abs());
        parts.fold(0.0, f64::max)
    };
    assert!(off(&node) < 1e-11, "{:e}", off(&node));
    // the length is constant beyond the last sample, so the samples go beyond the end
    let places = (-10..=1000).map(|k| 0.0025 * f64::from(k));
    let sampled = Sampled {
        cart,
        load,
        length: Samples::cubic(places.map(|t| (t, length(t)[0]))).unwrap(),
        gravity,
    };
    let node = TaylorFlow::new(&sampled, start, Tolerance::relative(1e-13));
    let node = node.unwrap().to(2.0).unwrap();
    assert!(off(&node) < 1e-7, "{:e}", off(&node));
    let node = Flow::new(&sampled, 0.0025, start).unwrap().to(2.0).unwrap();
    assert!(off(&node) < 1e-4, "{:e}", off(&node));
}
