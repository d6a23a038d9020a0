//! A declaration that was never compiled gives the motions of the compiled one, bit for bit: the interpreter
//! of its tape has the bits of the code that the attribute writes.

use dsocs_core::__private::{Tape, TapeError, TapeKernel};
use dsocs_core::taylor::AnyTaylorFlow;
use dsocs_core::text::Text;
use dsocs_core::{
    AnyEnsemble, AnyFlow, AnyPath, AnyStart, DerivativeError, Dual, Ensemble, Instructions, Kernel, Node,
    OwnedNode, Path, Run, RunError, Samples, SetupError, Start, Stepper, Stop, System, TaylorFlow, Tolerance,
    Trajectory, Variable, dsocs,
};
use dsocs_systems::Entry;
use dsocs_systems::check::{Begin, Expected, Settings, check, check_tape};
use dsocs_systems::systems::*;
use dsocs_tests::rods::Rods;
use dsocs_tests::tape::same_everywhere;

/// A system from the tape and the shape of a compiled one, copied as if they had been read from a file.
fn of_tape(kernel: &dyn Kernel) -> Result<TapeKernel, TapeError> {
    let shape = kernel.shape().clone();
    let values = (0..shape.parameters.len()).map(|place| kernel.value(place));
    let tape = Tape::owned(kernel.tape().bytes().to_vec()).unwrap();
    let of_tape = TapeKernel::new(tape, shape.clone(), values.collect())?;
    match kernel.sparse() {
        Some(sparse) => of_tape.sparse(sparse.clone()),
        None => Ok(of_tape),
    }
}

/// Compares a compiled system with its tape at many points. Returns the number of finite numbers, and of all.
fn same_bits<S: System<N>, const N: usize>(system: &S) -> [usize; 2] {
    let compiled = system.kernel();
    same_everywhere(compiled, &of_tape(compiled).unwrap(), 200)
}

/// Passes the systems without user's functions to a macro.
macro_rules! with_all {
    ($check:ident) => {
        $check!(
            Arm,
            CartPole,
            PlanarChain2,
            PlanarChain8,
            Clothoid,
            ContactOscillator,
            Crane,
            ExactDecrease,
            FrictionPendulum,
            StalledPendulum,
            GravityTurn,
            QuaternionTop,
            Kapitza,
            KnifeEdge,
            MagneticParticle,
            NonholonomicParticle,
            InertiaWheelPendulum,
            PlanarPendulum,
            RodAndWheel,
            RollingDisk,
            Sleigh,
            Snakeboard,
            Sphere,
            SphericalPendulum,
            Train,
            Vehicle
        )
    };
}

#[test]
fn a_tape_gives_the_bits_of_the_compiled_system() {
    let mut finite = 0.0_f64;
    let mut systems = 0;
    macro_rules! check {
        ($($system:ty),*) => {
            $({
                let [known, all] = same_bits(&<$system>::default());
                println!("{:>30}: {known} of {all} finite", stringify!($system));
                finite += known as f64 / all as f64;
                systems += 1;
            })*
        };
    }
    with_all!(check);
    // numbers that are not finite show nothing
    assert!(finite > 0.5 * f64::from(systems), "{finite} of {systems}");
}

#[test]
fn a_tape_that_calls_functions_is_refused() {
    let particle = CurvedParticle::default();
    assert_eq!(of_tape(particle.kernel()).unwrap_err(), TapeError::Functions);
}

/// Position and velocity at the start of a system's own run, its acceleration if it has one, the step, and
/// the time up to which series are compared.
struct DefaultStart {
    q: Vec<f64>,
    v: Vec<f64>,
    a: Option<Vec<f64>>,
    h: f64,
    last: f64,
}

impl DefaultStart {
    /// The start in the entry of a system.
    fn of(kernel: &dyn Kernel) -> Self {
        let name = &kernel.shape().name;
        let entries = all();
        let mut entries = entries.iter();
        let Some(entry) = entries.find(|entry| entry.description().itself.name == *name) else {
            // the longer chain has no entry
            let n = kernel.shape().dimension();
            return Self {
                q: vec![0.5; n],
                v: vec![0.0; n],
                a: None,
                h: 0.01,
                last: 50.0,
            };
        };
        let [q, v] = entry.default_start().unwrap().clone();
        let a = entry.default_acceleration().or(entry.default_near());
        Self {
            q,
            v,
            a: a.map(<[f64]>::to_vec),
            h: entry.default_step(),
            last: 50.0,
        }
    }

    fn start(&self, kernel: &dyn Kernel) -> AnyStart {
        let start = AnyStart::second_order(&self.q, &self.v);
        match &self.a {
            Some(a) if kernel.shape().is_of_third_order() => AnyStart::third_order(&self.q, &self.v, a),
            Some(a) => start.near_acceleration(a),
            None => start,
        }
    }
}

/// The bits of all numbers at the node where a run stands.
fn bits(run: &dyn Run) -> (Vec<u64>, u32, Stop) {
    let mut node = OwnedNode::new(0);
    node.take(run);
    let node = node.any();
    let vectors = [node.q, node.v, node.a, node.force, &[node.t, node.energy]];
    let numbers = vectors.into_iter().flatten();
    let bits = numbers.map(|x| if x.is_nan() { 0 } else { x.to_bits() });
    (bits.collect(), node.iterations, node.stop)
}

/// Compares the discrete motion of a compiled system with that of its tape. Returns the number of equal
/// nodes.
fn same_steps(system: &dyn Kernel) -> u32 {
    let defaults = DefaultStart::of(system);
    let start = defaults.start(system);
    let tape = of_tape(system).unwrap();
    let mut flows = [system, &tape].map(|kernel| AnyFlow::new(kernel, defaults.h, &start).unwrap());
    for step in 0..1000 {
        let [one, other] = flows.each_mut().map(|flow| {
            let report = flow.run_mut().advance();
            report.map_err(|error| error.to_string())
        });
        assert_eq!(one, other, "{}", system.shape().name);
        if one.is_err() {
            return step;
        }
        let [one, other] = flows.each_ref().map(|flow| bits(flow.run()));
        assert_eq!(one, other, "{}: step {step}", system.shape().name);
    }
    1000
}

#[test]
fn a_tape_makes_the_steps_of_the_compiled_system() {
    let mut nodes = 0;
    macro_rules! check {
        ($($system:ty),*) => {
            $({
                let same = same_steps(<$system>::default().kernel());
                println!("{:>30}: {same} nodes", stringify!($system));
                nodes += same;
            })*
        };
    }
    with_all!(check);
    assert!(nodes > 20_000, "{nodes}");
}

/// The tolerance of series.
const TOLERANCE: f64 = 1e-11;

/// A system, parsed from its text.
fn of_text<S: System<N> + Clone + Send + 'static, const N: usize>(system: &S) -> TapeKernel {
    let text = Entry::new(system.clone()).text().unwrap();
    Text::parse(S::NAME, &text).unwrap().system
}

/// The bits of a run by Taylor series at some times on the way to the last one, at nodes and between them;
/// and the message that ends it.
fn on_the_way(run: &mut dyn Run, last: f64) -> (Vec<Vec<u64>>, Option<String>) {
    let mut seen = Vec::new();
    for t in [0.1, 0.5, 2.0, 4.0, last] {
        let end = run.to(t);
        seen.push(bits(run).0);
        if let Err(error) = end {
            return (seen, Some(error.to_string()));
        }
    }
    (seen, None)
}

/// Compares the Taylor series of a compiled system with that of its text, in a run from a start. Returns the
/// message that ends it, if there is one.
fn same_series<S: System<N> + Clone + Send + 'static, const N: usize>(
    system: &S,
    defaults: &DefaultStart,
) -> Result<Option<String>, SetupError> {
    same_series_of(system, &of_text(system), defaults)
}

/// Compares the Taylor series of a compiled system with that of a parsed one.
fn same_series_of<S: System<N>, const N: usize>(
    system: &S,
    kernel: &TapeKernel,
    defaults: &DefaultStart,
) -> Result<Option<String>, SetupError> {
    let array = |vector: &[f64]| <[f64; N]>::try_from(vector).unwrap();
    let start = Start::second_order(array(&defaults.q), array(&defaults.v));
    let start = match &defaults.a {
        Some(a) => start.near_acceleration(array(a)),
        None => start,
    };
    let tolerance = Tolerance::relative(TOLERANCE);
    let compiled = TaylorFlow::new(system, start, tolerance);
    let of_text = AnyTaylorFlow::of_tape(kernel, &defaults.start(kernel), tolerance);
    let (mut compiled, mut of_text) = match (compiled, of_text) {
        (Ok(compiled), Ok(of_text)) => (compiled, of_text),
        (Err(one), Err(other)) => {
            assert_eq!(one.to_string(), other.to_string());
            return Err(one);
        }
        (one, other) => panic!("{}: {:?} {:?}", S::NAME, one.err(), other.err()),
    };
    let (one, other) = (
        on_the_way(compiled.run_mut(), defaults.last),
        on_the_way(&mut of_text, defaults.last),
    );
    assert_eq!(one, other, "{}", S::NAME);
    assert_eq!(compiled.steps(), of_text.steps(), "{}", S::NAME);
    Ok(one.1)
}

#[test]
fn a_text_has_the_series_of_the_compiled_system_bit_for_bit() {
    let mut compared = 0;
    macro_rules! check {
        ($($system:ty),*) => {
            $({
                let system = <$system>::default();
                let end = same_series(&system, &DefaultStart::of(system.kernel()));
                println!("{:>30}: {end:?}", stringify!($system));
                compared += usize::from(end.is_ok());
            })*
        };
    }
    with_all!(check);
    assert!(compared > 18, "{compared}");
}

/// A mass pulled by a table of samples, by its position and with time.
#[dsocs {
    coordinates(x);
    lagrangian = (1 + pull.at(t)) * dot(x).powi(2) / 2 - pull.at(x) * x / 10 - x.powi(2) / 2 + pull.at(1.5) * x / 100;
}]
struct Pulled {
    pull: Samples,
}

#[test]
fn tables_of_a_text_have_the_series_of_those_of_rust() {
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("pull.csv");
    std::fs::write(&table, "t,pull\n-2,0.1\n0,0\n1,1\n2,0.5\n4,0.7\n60,0.9\n").unwrap();
    let system = Pulled {
        pull: Samples::cubic(Samples::read(&table).unwrap()).unwrap(),
    };
    let declaration = &system.kernel().shape().declaration;
    let text = format!("parameters {{ pull = samples(\"pull.csv\") }}\n{declaration}");
    let file = folder.path().join("pulled.dsocs");
    std::fs::write(&file, text).unwrap();
    let kernel = Text::read(file).unwrap().system;
    let defaults = DefaultStart {
        q: vec![0.5],
        v: vec![0.4],
        a: None,
        h: 0.01,
        last: 50.0,
    };
    assert_eq!(same_series_of(&system, &kernel, &defaults).unwrap(), None);
}

#[test]
fn a_tape_alone_has_no_series() {
    let kernel = of_tape(InertiaWheelPendulum::default().kernel()).unwrap();
    let start = AnyStart::second_order(&[0.5, 0.0], &[0.0, 0.5]);
    let error = AnyTaylorFlow::of_tape(&kernel, &start, Tolerance::relative(TOLERANCE)).unwrap_err();
    assert!(matches!(error, SetupError::NoSeries), "{error}");
}

/// A system with every operation of a series, forces and a multiplier.
#[dsocs {
    coordinates(x, y, z);
    let all = x.exp() + y.exp_m1() + (2 + x).ln() + y.ln_1p() + x.cbrt() + (1 + y.powi(2)).powf(power) + (x / 4).asin() + (y / 4).acos()
        + x.atan() + y.sinh() + x.cosh() + y.tan() + (1 + x).asinh() + (3 + y).acosh() + (x / 5).atanh() + y.atan2(2 + x) + 1 / (3 + y)
        + x / (2 + y.powi(3)) + y.powf(x / 9) + (t / 7).cos() * x.sin() + x.abs() + y.signum() / 9 + x.min(y) + x.max(y / 3);
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2) * (2 + x.sin()))
        - (1 + x.powi(2)).sqrt() - (y / 3).exp() * z.cos() - all / 10;
    holonomic = [x.powi(2) + y.powi(2) + z - 1];
    external_forces = (-(dot(x) / 2).tanh(), t.sin() * y.atan(), dot(z).abs() / (2 + y.powi(2)));
}]
#[derive(Clone)]
struct Everything {
    mass: f64,
    power: f64,
}

/// A row that is not affine in its acceleration, and rows that are solved together.
#[dsocs {
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - stiff * (x.powi(2) + y.powi(2)) / 2;
    kinematic = ddot(x) + ddot(x).powi(3) / 10 + x - y / 5;
    constraint_forces = [(1, 0)];
}]
#[derive(Clone)]
struct Cubic {
    stiff: f64,
}

#[test]
fn every_operation_of_a_series_has_its_bits() {
    let defaults = |q: &[f64], v: &[f64]| DefaultStart {
        q: q.to_vec(),
        v: v.to_vec(),
        a: None,
        h: 0.01,
        last: 50.0,
    };
    let system = Everything {
        mass: 1.5,
        power: 1.3,
    };
    for (q, v) in [
        ([0.5, 0.25, 0.6875], [1.0, -0.5, -0.75]),
        ([0.1, 0.7, 0.5], [0.2, 0.3, -0.46]),
    ] {
        let end = same_series(&system, &defaults(&q, &v));
        println!("{end:?}");
        assert!(end.is_ok());
    }
    let end = same_series(&Cubic { stiff: 2.0 }, &defaults(&[1.0, 0.5], &[0.0, 0.1])).unwrap();
    assert_eq!(end, None);
}

/// Dry friction, and a spring with a corner: functions that jump, which the motion crosses.
#[dsocs {
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2) - x.powi(2)) / 2 - y.abs();
    external_forces = (-dry * dot(x).signum(), -(steep * dot(y)).tanh() / 10);
}]
#[derive(Clone)]
struct Jumping {
    dry: f64,
    steep: f64,
}

#[test]
fn a_text_passes_switches_as_the_compiled_system_does() {
    // the mass comes to rest at the third turning point, at 3π s
    let system = Jumping {
        dry: 0.15,
        steep: 3.0,
    };
    let defaults = DefaultStart {
        q: vec![1.0, 0.5],
        v: vec![0.0, 0.3],
        a: None,
        h: 0.01,
        last: 12.0,
    };
    // also if the spring cannot pull the mass on, and it rests
    assert_eq!(same_series(&system, &defaults).unwrap(), None);
}

#[test]
fn a_text_passes_the_checks_as_the_compiled_system_does() {
    let mut compared = 0;
    macro_rules! compare {
        ($($system:ty),*) => {
            $(compared += same_findings(&<$system>::default());)*
        };
    }
    compare!(
        CartPole,
        PlanarChain2,
        QuaternionTop,
        KnifeEdge,
        InertiaWheelPendulum,
        RollingDisk,
        Sphere,
        Train
    );
    assert!(compared > 100, "{compared}");
}

/// Compares the findings of the checks for a compiled system and for its text. Returns the number of figures.
fn same_findings<S: System<N> + Clone + Send + 'static, const N: usize>(system: &S) -> usize {
    let defaults = DefaultStart::of(system.kernel());
    let kernel = of_text(system);
    let settings = Settings {
        h: defaults.h,
        until: None,
        t0: 0.0,
        q0: &defaults.q,
        v0: &defaults.v,
        a0: defaults.a.as_deref(),
        begin: Begin::default(),
    };
    let array = |vector: &[f64]| <[f64; N]>::try_from(vector).unwrap();
    let start = (array(&defaults.q), array(&defaults.v));
    let entries = all();
    let mut entries = entries.iter();
    let entry = entries.find(|entry| entry.description().itself.name == S::NAME);
    let expected = Expected {
        kind: entry.unwrap().kind(),
        order: 2.0,
        reversible: true,
    };
    let compiled = check(system, &[], expected, &settings, start).unwrap();
    let of_tape = check_tape(&kernel, &[], expected, &settings).unwrap();
    assert_eq!(compiled.len(), of_tape.len());
    for (one, other) in compiled.iter().zip(&of_tape) {
        assert_eq!(
            (one.check, &one.what, one.bar),
            (other.check, &other.what, other.bar)
        );
        assert_eq!(
            (one.ok(), &one.failure, &one.note),
            (other.ok(), &other.failure, &other.note)
        );
        let same =
            one.figure.to_bits() == other.figure.to_bits() || one.figure.is_nan() && other.figure.is_nan();
        assert!(
            same,
            "{}: {}: {:e} {:e}",
            S::NAME,
            one.what,
            one.figure,
            other.figure
        );
    }
    compiled.len()
}

/// A driven system that is affine in its unknowns, with functions that lanes compute one by one, and with
/// tables.
#[dsocs {
    coordinates(x, y, z);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2)) / 2 - x.powi(2) - (1 + y.powi(2)).ln() + z * (2 * t).sin();
    holonomic = [x + y / 2 - z * (1 + t.cos() / 9)];
    external_forces = (-push * dot(x), (1 + x.powi(2)).cbrt() - y.atan2(2 + x), z.sinh() / 99 - z);
}]
struct Driven {
    push: f64,
}

/// A system with functions that lanes compute together.
#[dsocs {
    coordinates(x);
    lagrangian = (2 + x.cos()) * dot(x).powi(2) / 2 - stiff * (x.exp() - (x / 3).tanh() + x.exp_m1().powi(2));
    external_forces = (-dot(x) * x.sin() / 9);
}]
struct Swing {
    stiff: f64,
}

/// Coupled masses: three unknowns that do not enter affinely.
#[dsocs {
    coordinates(x: [3]);
    let mass = |k| 2 + x[k].powi(2);
    let tie = |k| dot(x[k]) * dot(x[k - 1]) * (x[k] - x[k - 1]) / 4 - (x[k] - x[k - 1]).powi(2);
    lagrangian = sum(0..3, |k| mass(k) * dot(x[k]).powi(2) / 2 - stiff * x[k].powi(2)) + sum(1..3, |k| tie(k));
}]
struct Tied {
    stiff: f64,
}

/// A system whose maps evaluate at a point other than the node.
#[dsocs {
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2;
    phi_lagrangian = midpoint;
    phi_kinematic = |q0, q1, q2| ((q0 + 2 * q1 + q2) / 4, (q2 - q0) / (2 * h), (q2 - 2 * q1 + q0) / h.powi(2));
}]
struct Between;

/// The bits of a node.
fn node_bits(node: &OwnedNode) -> Vec<u64> {
    let node = node.any();
    let vectors = [node.q, node.v, node.a, node.force, &[node.t, node.energy]];
    let numbers = vectors.into_iter().flatten();
    let numbers = numbers.map(|x| if x.is_nan() { 0 } else { x.to_bits() });
    numbers.chain([node.index, node.iterations.into()]).collect()
}

/// Compares a compiled system in lanes with its tape in lanes, in 11 runs with a varying parameter and, if
/// allowed, a held one. Returns the numbers of compared nodes and of runs that ended with an error.
fn same_lanes<S: System<N> + Sync, const N: usize>(system: &S, defaults: &DefaultStart) -> [usize; 2] {
    let tape = of_tape(system.kernel()).unwrap();
    let position =
        |k: usize| -> [f64; N] { core::array::from_fn(|i| defaults.q[i] + 1e-3 * (k * (i + 1)) as f64) };
    let velocity: [f64; N] = core::array::from_fn(|i| defaults.v[i]);
    let time = |k: usize| 0.1 * k as f64;
    let shape = system.kernel().shape();
    let varied = shape.parameters.first().map(|parameter| parameter.name.clone());
    let value = |k: usize| system.kernel().value(0) * (1.0 + 0.01 * k as f64);
    let every = core::num::NonZeroU64::new(5).unwrap();
    let until = 1.1 + 300.0 * defaults.h;
    let mut counts = [0, 0];
    // a debug build has the narrowest registers only
    for instructions in Instructions::ALL
        .into_iter()
        .filter(|these| these.are_available())
    {
        let starts = (0..11).map(|k| {
            let start = Start::second_order(position(k), velocity).at(time(k)).projected();
            match &defaults.a {
                Some(a) => start.near_acceleration(core::array::from_fn(|i| a[i])),
                None => start,
            }
        });
        let mut compiled = Ensemble::new(system, defaults.h)
            .unwrap()
            .starts(starts)
            .instructions(instructions);
        let starts = (0..11).map(|k| {
            let start = AnyStart::second_order(&position(k), &velocity)
                .at(time(k))
                .projected();
            match &defaults.a {
                Some(a) => start.near_acceleration(a),
                None => start,
            }
        });
        let mut walked = AnyEnsemble::of_tape(&tape, defaults.h)
            .unwrap()
            .starts(starts)
            .instructions(instructions);
        if let Some(name) = &varied {
            compiled = compiled.varied(name, (0..11).map(value)).unwrap();
            walked = walked.varied(name, (0..11).map(value)).unwrap();
        }
        let compiled = compiled.stream(until, every, |_| Trajectory::<N>::default());
        let walked = walked.stream(
            until,
            every,
            |_| Vec::new(),
            |nodes, node| {
                nodes.push(node_bits(&OwnedNode::of(node)));
                core::ops::ControlFlow::Continue(())
            },
        );
        let of = |node: &Node<N>| node_bits(&OwnedNode::of(&node.any()));
        for (one, other) in compiled.iter().zip(&walked) {
            let nodes: Vec<_> = one.observer.iter().map(of).collect();
            assert_eq!(nodes, other.observer, "{} {instructions}", S::NAME);
            counts[0] += nodes.len();
            match (&one.last, &other.last) {
                (Ok(one), Ok(other)) => assert_eq!(of(one), node_bits(other), "{} {instructions}", S::NAME),
                (Err(one), Err(other)) => {
                    assert_eq!(one.to_string(), other.to_string());
                    counts[1] += 1;
                }
                (one, other) => panic!("{}: {one:?} {other:?}", S::NAME),
            }
        }
    }
    counts
}

#[test]
fn a_tape_makes_the_steps_of_the_compiled_system_in_lanes() {
    let mut nodes = 0;
    macro_rules! check {
        ($($system:expr),* $(,)?) => {
            $({
                let system = $system;
                let [same, failed] = same_lanes(&system, &DefaultStart::of(system.kernel()));
                println!("{:>30}: {same} nodes, {failed} errors", stringify!($system));
                nodes += same;
            })*
        };
    }
    check!(
        InertiaWheelPendulum::default(),
        PlanarChain2::default(),
        Kapitza::default(),
        FrictionPendulum::default(),
        ContactOscillator::default(),
        SphericalPendulum::default(),
        NonholonomicParticle::default(),
        KnifeEdge::default(),
        Jumping {
            dry: 0.05,
            steep: 3.0
        },
        Driven { push: 1.0 },
        Swing { stiff: 1.0 },
        Tied { stiff: 1.0 },
        Between,
    );
    // hanging, and displaced a little to the side
    let mut hanging = DefaultStart {
        q: vec![0.0; 28],
        v: vec![0.0; 28],
        a: None,
        h: 1e-3,
        last: 50.0,
    };
    for i in 0..14 {
        hanging.q[i] = 0.1 * (i + 1) as f64;
        hanging.q[14 + i] = -0.24_f64.sqrt() * (i + 1) as f64;
    }
    let rods = Rods::default();
    assert!(rods.kernel().sparse().is_some());
    let [same, failed] = same_lanes(&rods, &hanging);
    assert!(same > 100 && failed == 0, "{same} {failed}");
    assert!(nodes > 5_000, "{nodes}");
}

#[test]
fn inputs_of_a_tape_are_held_in_lanes() {
    let driven = Driven { push: 1.0 };
    let tape = of_tape(driven.kernel()).unwrap();
    let plans = || (0..9).map(|k| vec![[0.2, f64::from(k)], [0.5 + 0.01 * f64::from(k), 0.3]]);
    let (q, v) = ([0.1, 0.2, 0.2 / (1.0 + 1.0 / 9.0)], [0.1, 0.0, 0.0]);
    let compiled = Ensemble::new(&driven, 0.01)
        .unwrap()
        .starts([Start::second_order(q, v).projected(); 9])
        .held("push", plans())
        .unwrap()
        .to(1.0);
    let walked = AnyEnsemble::of_tape(&tape, 0.01)
        .unwrap()
        .starts((0..9).map(|_| AnyStart::second_order(&q, &v).projected()))
        .held("push", plans())
        .unwrap()
        .here()
        .to(1.0);
    for (one, other) in compiled.iter().zip(&walked) {
        assert_eq!(
            node_bits(&OwnedNode::of(&one.as_ref().unwrap().any())),
            node_bits(other.as_ref().unwrap())
        );
    }
    assert_eq!(walked.len(), 9);
}

#[test]
fn an_ensemble_of_any_kernel_makes_the_steps_of_flows() {
    let system = InertiaWheelPendulum::default();
    let starts: Vec<AnyStart> = (0..9)
        .map(|k| AnyStart::second_order(&[0.5 - 0.01 * f64::from(k), 0.0], &[0.0, 0.5]))
        .collect();
    let ends = AnyEnsemble::new(&system, 0.1)
        .unwrap()
        .starts(starts.clone())
        .to(20.0);
    for (start, end) in starts.iter().zip(ends) {
        let mut flow = AnyFlow::new(&system, 0.1, start).unwrap();
        flow.run_mut().to(20.0).unwrap();
        let mut node = OwnedNode::new(2);
        node.take(flow.run());
        assert_eq!(node_bits(&end.unwrap()), node_bits(&node));
    }
    // vectors of the wrong length, and starts that cannot be used
    let ends = AnyEnsemble::new(&system, 0.1)
        .unwrap()
        .starts([AnyStart::second_order(&[0.5], &[0.0, 0.5])])
        .to(1.0);
    assert!(matches!(
        &ends[0],
        Err(RunError::Setup(error)) if matches!(**error, SetupError::StartLength { .. })
    ));
    let third = of_tape(Clothoid::default().kernel()).unwrap();
    let error = AnyEnsemble::of_tape(&third, 0.1).unwrap_err();
    assert!(matches!(error, SetupError::ThirdOrder { .. }), "{error}");
}

/// Compares the derivatives of a run of a compiled system with those of its tape, by all parameters and the
/// start. Returns the number of compared numbers.
fn same_derivatives<S: System<N>, const N: usize>(system: &S) -> Result<usize, DerivativeError> {
    let defaults = DefaultStart::of(system.kernel());
    let tape = of_tape(system.kernel()).unwrap();
    let array = |vector: &[f64]| <[f64; N]>::try_from(vector).unwrap();
    let second = |i: usize| defaults.q[i] + defaults.h * defaults.v[i];
    // constraints on positions and velocities are imposed on two nodes
    let bound = system.kernel().shape().holonomic + system.kernel().shape().nonholonomic > 0;
    let nodes: [f64; N] = core::array::from_fn(second);
    let start = match (bound, &defaults.a) {
        (true, _) => Start::nodes(array(&defaults.q), nodes),
        (_, Some(a)) => {
            Start::second_order(array(&defaults.q), array(&defaults.v)).near_acceleration(array(a))
        }
        _ => Start::second_order(array(&defaults.q), array(&defaults.v)),
    };
    let any = match (bound, &defaults.a) {
        (true, _) => AnyStart::nodes(&defaults.q, &nodes),
        (_, Some(a)) => AnyStart::second_order(&defaults.q, &defaults.v).near_acceleration(a),
        _ => AnyStart::second_order(&defaults.q, &defaults.v),
    };
    let until = 53.0 * defaults.h;
    // with checkpoints, too
    let memory = 3000;
    let compiled = Path::within(system, defaults.h, start, until, memory);
    let walked = AnyPath::within(&tape, defaults.h, &any, until, memory);
    let (compiled, walked) = match (compiled, walked) {
        (Ok(compiled), Ok(walked)) => (compiled, walked),
        (Err(one), Err(other)) => {
            assert_eq!(one.to_string(), other.to_string());
            return Err(one);
        }
        (one, other) => panic!("{}: {:?} {:?}", S::NAME, one.err(), other.err()),
    };
    assert_eq!(
        node_bits(&OwnedNode::of(&compiled.end().any())),
        node_bits(&OwnedNode::of(&walked.end()))
    );
    let names: Vec<String> = system
        .kernel()
        .shape()
        .parameters
        .iter()
        .map(|p| p.name.to_string())
        .collect();
    let mut variables: Vec<Variable<'_>> = names.iter().map(|name| Variable::Parameter(name)).collect();
    variables.extend((0..N).map(Variable::Position));
    variables.extend((0..N).map(if bound {
        Variable::SecondNode
    } else {
        Variable::Velocity
    }));
    let bits = |vectors: [&[f64]; 3]| -> Vec<u64> {
        let numbers = vectors.into_iter().flatten();
        numbers
            .map(|x| if x.is_nan() { 0 } else { x.to_bits() })
            .collect()
    };
    let mut count = 0;
    let (one, other) = (compiled.tangents(&variables)?, walked.tangents(&variables)?);
    assert_eq!(one.len(), other.len());
    for (one, other) in one.iter().zip(other.iter()) {
        assert_eq!(
            bits([&one.q, &one.v, &one.a]),
            bits([other.q, other.v, other.a]),
            "{}",
            S::NAME
        );
        count += 3 * N;
    }
    let mut along = Vec::new();
    compiled.tangents_along(&variables, &mut |_, _, tangents| {
        along.extend(tangents.iter().flat_map(|by| bits([&by.q, &by.v, &by.a])));
    })?;
    let mut walked_along = Vec::new();
    walked.tangents_along(&variables, &mut |_, _, tangents| {
        walked_along.extend(tangents.flat_map(|by| bits([by.q, by.v, by.a])));
    })?;
    assert_eq!(along, walked_along, "{}", S::NAME);
    let cost = |k: usize, q: &[Dual<f64>], a: &[Dual<f64>]| q[0] * q[0] * (k as f64) + a[N - 1] * 1e-3;
    let one = compiled.gradient(&mut |k, node| cost(k, &node.q, &node.a))?;
    let other = walked.gradient(&mut |k, node| cost(k, node.q, node.a))?;
    assert_eq!(one.cost.to_bits(), other.cost.to_bits());
    assert_eq!(
        bits([&one.q0, &one.v0, &one.q1]),
        bits([&other.q0, &other.v0, &other.q1]),
        "{}",
        S::NAME
    );
    assert_eq!(
        bits([&one.parameters, &[], &[]]),
        bits([&other.parameters, &[], &[]])
    );
    let one = compiled.gradient_at_end(&mut |end| end.q[0])?;
    let other = walked.gradient_at_end(&mut |end| end.q[0])?;
    assert_eq!(
        bits([&one.q0, &one.v0, &one.parameters]),
        bits([&other.q0, &other.v0, &other.parameters])
    );
    Ok(count + along.len())
}

#[test]
fn a_tape_has_the_derivatives_of_the_compiled_system() {
    let mut compared = 0;
    macro_rules! check {
        ($($system:ty),*) => {
            $({
                let found = same_derivatives(&<$system>::default());
                println!("{:>30}: {found:?}", stringify!($system));
                compared += found.unwrap_or(0);
            })*
        };
    }
    with_all!(check);
    assert!(compared > 10_000, "{compared}");
}

#[test]
fn a_plan_of_a_tape_has_the_derivatives_of_the_compiled_one() {
    let jumping = Pushed { push: 0.0 };
    let tape = of_tape(jumping.kernel()).unwrap();
    let values: Vec<[f64; 1]> = (0..20).map(|k| [f64::from(k).sin()]).collect();
    let legs: Vec<&[f64]> = values.iter().map(|values| &values[..]).collect();
    let start = Start::second_order([0.1], [0.2]);
    let compiled = Path::plan(&jumping, 0.1, start, ["push"], &values).unwrap();
    let any = AnyStart::second_order(&[0.1], &[0.2]);
    let walked = AnyPath::plan(&tape, 0.1, &any, &["push"], &legs).unwrap();
    let one = compiled.gradient_at_end(&mut |end| end.q[0]).unwrap();
    let other = walked.gradient_at_end(&mut |end| end.q[0]).unwrap();
    assert_eq!((one.inputs, one.parameters), (other.inputs, other.parameters));
    // a missing value is an error
    let error = AnyPath::plan(&tape, 0.1, &any, &["push"], &[&[]]).unwrap_err();
    assert!(matches!(error, DerivativeError::Run(_)), "{error}");
    let error = AnyPath::new(&tape, 0.1, &AnyStart::paper(&[0.0, 1.0], &[0.0]), 1.0).unwrap_err();
    assert!(matches!(error, DerivativeError::Run(_)), "{error}");
}

/// A driven mass on a spring.
#[dsocs {
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2 - x.powi(4) / 9;
    external_forces = push;
}]
struct Pushed {
    push: f64,
}
