//! A declaration that no compiler has seen is the same system: its tape, walked, gives the same bits as the code that the attribute writes.

use dsocs_core::__private::{AnyLeg, At, Tape, TapeError, TapeKernel, Told};
use dsocs_core::{Flow, Kernel, Node, SetupError, Start, Stepper, System, TaylorFlow, Tolerance, dsocs};
use dsocs_systems::systems::*;

/// The system of a compiled one's tape and shape, which are copied as if they had been read from a file.
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

/// Random numbers between -1 and 1.
struct Random(u64);

impl Random {
    fn number(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn numbers(&mut self, count: usize, size: f64) -> Vec<f64> {
        (0..count).map(|_| size * self.number()).collect()
    }
}

/// All that a kernel gives in one step.
fn step(kernel: &dyn Kernel, seed: u64) -> Vec<(&'static str, Vec<f64>)> {
    let shape = kernel.shape();
    let (n, m) = (shape.dimension(), shape.unknowns);
    let mut random = Random(seed);
    let h = [0.1, 0.01, 1e-3][usize::try_from(seed % 3).unwrap()];
    let parameters: Vec<f64> = (0..shape.parameters.len())
        .map(|place| kernel.value(place) * (1.0 + 0.5 * random.number()))
        .collect();
    let mut constants = vec![f64::NAN; shape.constants];
    kernel.constants(&parameters, h, &mut constants);
    kernel.remember(&mut constants, &random.numbers(n, h * h));
    let mut past = vec![f64::NAN; n];
    kernel.past(&constants, &mut past);
    let leg = AnyLeg {
        t: 5.0 * random.number(),
        q: &random.numbers(n, 2.0),
        d: &random.numbers(n, h),
    };
    let mut known = vec![f64::NAN; shape.known];
    kernel.known(&constants, leg, &mut known);
    let e = random.numbers(n, h * h);
    let multipliers = random.numbers(shape.forms, 1.0);
    let mut z = vec![f64::NAN; m];
    kernel.unknown(&e, &multipliers, &mut z);
    let at = At {
        constants: &constants,
        known: &known,
        z: &z,
    };
    let (mut rows, mut jacobian) = (vec![f64::NAN; m], vec![f64::NAN; m * m]);
    kernel.linearize(at, &mut rows, &mut jacobian);
    let (mut sparse_rows, mut entries) = (vec![f64::NAN; m], vec![f64::NAN; m * m]);
    kernel.entries(at, &mut sparse_rows, &mut entries);
    let mut scales = vec![f64::NAN; m];
    kernel.scales(at, &mut scales);
    let mut difference = vec![f64::NAN; n];
    kernel.second_difference(at, &mut difference);
    let mut point = [(); 4].map(|()| vec![f64::NAN; n]);
    let (mut t, mut energy) = (f64::NAN, f64::NAN);
    let [q, v, a, force] = &mut point;
    let told = Told {
        q,
        v,
        a,
        force,
        t: &mut t,
        energy: &mut energy,
    };
    kernel.report(&constants, leg, &e, told);
    vec![
        ("constants", constants),
        ("past", past),
        ("known", known),
        ("unknowns", z),
        ("rows", rows),
        ("jacobian", jacobian),
        ("rows beside entries", sparse_rows),
        ("entries", entries),
        ("scales", scales),
        ("second difference", difference),
        ("point and force", point.concat()),
        ("time and energy", vec![t, energy]),
    ]
}

/// Compares a compiled system with its tape, at many points. Returns how many of the numbers are finite, and how many there are.
fn same_bits<S: System<N>, const N: usize>(system: &S) -> [usize; 2] {
    let compiled = system.kernel();
    let of_tape = of_tape(compiled).unwrap();
    let mut counts = [0, 0];
    for seed in 0..200 {
        let steps = [compiled, &of_tape].map(|kernel| step(kernel, 977 * seed + 1));
        for ((what, one), (_, other)) in steps[0].iter().zip(&steps[1]) {
            for (place, (one, other)) in one.iter().zip(other).enumerate() {
                let same = one.to_bits() == other.to_bits() || one.is_nan() && other.is_nan();
                assert!(same, "{}: {what} {place}: {one:e} and {other:e}", S::NAME);
                counts[0] += usize::from(one.is_finite());
                counts[1] += 1;
            }
        }
    }
    counts
}

/// Hands the systems without functions to a macro.
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
            HeavyTop,
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
    // what is not finite compares nothing
    assert!(finite > 0.5 * f64::from(systems), "{finite} of {systems}");
}

#[test]
fn a_tape_that_calls_functions_is_refused() {
    let particle = CurvedParticle::default();
    assert_eq!(of_tape(particle.kernel()).unwrap_err(), TapeError::Functions);
}

/// The start of a system's own run, and its step.
fn start<S: System<N>, const N: usize>() -> Option<(Start<N>, f64)> {
    let entries = all();
    let entry = entries
        .iter()
        .find(|entry| entry.description().itself.name == S::NAME)?;
    let array = |vector: &[f64]| <[f64; N]>::try_from(vector).ok();
    let [q, v] = entry.default_start()?;
    let (q, v) = (array(q)?, array(v)?);
    let start = match (entry.default_acceleration(), entry.default_near()) {
        (Some(a), _) => Start::third_order(q, v, array(a)?),
        (None, Some(near)) => Start::second_order(q, v).near_acceleration(array(near)?),
        (None, None) => Start::second_order(q, v),
    };
    Some((start, entry.default_step()))
}

/// All numbers of a node.
fn bits<const N: usize>(node: &Node<N>) -> Vec<u64> {
    let vectors = [&node.q, &node.v, &node.a, &node.force];
    let numbers = vectors.into_iter().flatten().chain([&node.t, &node.energy]);
    numbers
        .map(|x| if x.is_nan() { 0 } else { x.to_bits() })
        .collect()
}

/// Compares the discrete motion of a compiled system with that of its tape. Returns how many nodes are the same.
fn same_steps<S: System<N>, const N: usize>(system: &S) -> u32 {
    let Some((start, h)) = start::<S, N>() else {
        return 0;
    };
    let kernel = of_tape(system.kernel()).unwrap();
    let compiled = Flow::new(system, h, start);
    let of_tape = Flow::<N>::of(&kernel, h, start);
    let (mut compiled, mut of_tape) = match (compiled, of_tape) {
        (Ok(compiled), Ok(of_tape)) => (compiled, of_tape),
        (one, other) => panic!("{}: {:?} {:?}", S::NAME, one.err(), other.err()),
    };
    for step in 0..1000 {
        match (compiled.next(), of_tape.next()) {
            (Some(Ok(one)), Some(Ok(other))) => {
                assert_eq!(bits(&one), bits(&other), "{}: {one:?} {other:?}", S::NAME);
                assert_eq!((one.iterations, one.stop), (other.iterations, other.stop));
            }
            (Some(Err(one)), Some(Err(other))) => {
                assert_eq!(one.to_string(), other.to_string());
                return step;
            }
            (one, other) => panic!("{}: {one:?} {other:?}", S::NAME),
        }
    }
    1000
}

#[test]
fn a_tape_makes_the_steps_of_the_compiled_system() {
    let mut nodes = 0;
    macro_rules! check {
        ($($system:ty),*) => {
            $({
                let same = same_steps(&<$system>::default());
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

/// How far the Taylor series of a compiled system and that of its tape are apart in a run from a start, in units of the tolerance; `None` where there
/// is no series. Both make the same number of steps.
fn apart_by_series<S: System<N>, const N: usize>(system: &S, start: Start<N>) -> Option<f64> {
    let tolerance = Tolerance::relative(TOLERANCE);
    let kernel = of_tape(system.kernel()).unwrap();
    let compiled = TaylorFlow::new(system, start, tolerance);
    let of_tape = TaylorFlow::<N>::of(&kernel, start, tolerance);
    let (mut compiled, mut of_tape) = match (compiled, of_tape) {
        (Ok(compiled), Ok(of_tape)) => (compiled, of_tape),
        (Err(one @ SetupError::ThirdOrder { .. }), Err(other)) => {
            assert_eq!(one.to_string(), other.to_string());
            return None;
        }
        (one, other) => panic!("{}: {:?} {:?}", S::NAME, one.err(), other.err()),
    };
    let (mut apart, mut size) = (0.0_f64, 1.0_f64);
    for t in [0.1, 0.5, 2.0, 4.0] {
        let one = compiled.to(t).unwrap();
        let other = of_tape.to(t).unwrap();
        let numbers = |node: &Node<N>| [node.q, node.v].concat();
        for (one, other) in numbers(&one).iter().zip(&numbers(&other)) {
            size = size.max(one.abs());
            apart = apart.max((one - other).abs());
        }
        let energy = one.energy.abs().max(1.0);
        assert!((one.energy - other.energy).abs() <= 1e-10 * energy, "{}", S::NAME);
    }
    assert_eq!(compiled.steps(), of_tape.steps(), "{}", S::NAME);
    Some(apart / (TOLERANCE * size))
}

#[test]
fn a_tape_has_the_motion_of_the_compiled_system() {
    let mut compared = 0;
    macro_rules! check {
        ($($system:ty),*) => {
            $({
                let system = <$system>::default();
                let found = start_of(&system).and_then(|start| apart_by_series(&system, start));
                println!("{:>30}: {found:?} tolerances", stringify!($system));
                compared += usize::from(found.is_some());
                assert!(found.is_none_or(|apart| apart < 1.0), "{found:?}");
            })*
        };
    }
    with_all!(check);
    assert!(compared > 18, "{compared}");
}

/// The start of a system's own run.
fn start_of<S: System<N>, const N: usize>(_: &S) -> Option<Start<N>> {
    start::<S, N>().map(|(start, _)| start)
}

/// Dry friction, and a spring with a corner: functions that jump, which the motion crosses.
#[dsocs {
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2) - x.powi(2)) / 2 - y.abs();
    external_forces = (-dry * dot(x).signum(), -(steep * dot(y)).tanh() / 10);
}]
struct Jumping {
    dry: f64,
    steep: f64,
}

#[test]
fn a_tape_passes_switches_as_the_compiled_system_does() {
    let system = Jumping {
        dry: 0.05,
        steep: 3.0,
    };
    let start = Start::second_order([1.0, 0.5], [0.0, 0.3]);
    let apart = apart_by_series(&system, start).unwrap();
    assert!(apart < 10.0, "{apart}");
    // and both get stuck where the spring cannot pull the mass on
    let kernel = of_tape(&system).unwrap();
    let tolerance = Tolerance::relative(TOLERANCE);
    let ends = [
        TaylorFlow::new(&system, start, tolerance).unwrap().to(50.0),
        TaylorFlow::<2>::of(&kernel, start, tolerance).unwrap().to(50.0),
    ];
    for end in ends {
        let error = end.unwrap_err().to_string();
        assert!(error.contains("sticks"), "{error}");
    }
}
