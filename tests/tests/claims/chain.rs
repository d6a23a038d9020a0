//! Chains that are declared with arrays and sums: their step is that of a Cartesian formulation by hand, its
//! order is 2, and the energy does not drift.

use dsocs_core::{Flow, Real, Start, Stepper, System};
use dsocs_systems::{PlanarChain2, PlanarChain8, planar_chain};
use dsocs_tests::check::{Kind, State, compare};
use dsocs_tests::dop853;
use dsocs_tests::fit::{local_slopes, slope};
use dsocs_tests::independent::{self, Declaration, Number, map2};
use proptest::prelude::*;

use crate::draws::{self, sized, vector};

planar_chain! {
    /// Three links.
    #[derive(Clone, Debug)]
    struct PlanarChain3; 3
}

/// The chain in Cartesian terms: `Σ m |dx/dt|² / 2 − m g height` over the points, each placed by the rods before it.
struct Cartesian<const N: usize> {
    masses: [f64; N],
    lengths: [f64; N],
    gravity: f64,
}

impl<const N: usize> Declaration<N> for Cartesian<N> {
    fn lagrangian<R: Number>(&self, q: [R; N], v: [R; N]) -> R {
        let zero = R::from(0.0);
        let (mut height, mut across, mut up, mut sum) = (zero, zero, zero, zero);
        for i in 0..N {
            height -= q[i].cos() * self.lengths[i];
            across += q[i].cos() * v[i] * self.lengths[i];
            up += q[i].sin() * v[i] * self.lengths[i];
            sum += ((across * across + up * up) * 0.5 - height * self.gravity) * self.masses[i];
        }
        sum
    }

    fn kinematic<R: Number>(&self, _: [R; N], _: [R; N], _: [R; N]) -> Vec<R> {
        Vec::new()
    }

    fn variational<R: Number>(&self, _: [R; N], _: [R; N], _: [R; N]) -> Vec<[R; N]> {
        let unit = |i| core::array::from_fn(|j| R::from(f64::from(u8::from(i == j))));
        (0..N).map(unit).collect()
    }

    fn phi_lagrangian<R: Number>(&self, h: R, q0: [R; N], q1: [R; N]) -> ([R; N], [R; N]) {
        (
            map2(q0, q1, |x0, x1| (x0 + x1) * 0.5),
            map2(q0, q1, |x0, x1| (x1 - x0) / h),
        )
    }
}

fn compare_with_cartesian<S: System<N>, const N: usize>(system: &S, cartesian: &Cartesian<N>, cases: u32) {
    let steps = (0.02..0.5).boxed();
    let states = (
        steps,
        vector::<N>(-2.0..2.0),
        vector::<N>(-2.0..2.0),
        vector::<N>(-3.0..3.0),
    );
    draws::test(cases, 3, states, &|(h, q, v, a)| {
        let [q, v, a] = [q, v, a].map(|x| sized(&x));
        compare(system, cartesian, State { h, q, v, a }, Kind::default())
            .map_err(|mismatch| TestCaseError::fail(format!("{mismatch:?}")))
    });
}

#[test]
fn two_links_are_those_of_cartesian_coordinates() {
    let (masses, lengths, gravity) = ([1.5, 0.7], [0.8, 1.3], 9.81);
    let chain = PlanarChain2 {
        masses,
        lengths,
        gravity,
    };
    compare_with_cartesian(
        &chain,
        &Cartesian {
            masses,
            lengths,
            gravity,
        },
        100,
    );
}

#[test]
fn eight_links_are_those_of_cartesian_coordinates() {
    let masses = core::array::from_fn(|i| 0.5 + 0.25 * i as f64);
    let lengths = core::array::from_fn(|i| 1.0 - 0.125 * i as f64 / 2.0);
    let chain = PlanarChain8 {
        masses,
        lengths,
        gravity: 9.81,
    };
    compare_with_cartesian(
        &chain,
        &Cartesian {
            masses,
            lengths,
            gravity: 9.81,
        },
        20,
    );
}

const TRIPLE: PlanarChain3 = PlanarChain3 {
    masses: [1.0, 0.5, 2.0],
    lengths: [1.0, 1.5, 0.75],
    gravity: 9.81,
};
const Q0: [f64; 3] = [1.0, 1.5, 0.25];
const V0: [f64; 3] = [0.0, -1.0, 2.0];
const UNTIL: f64 = 2.0;

/// The acceleration of the continuous chain, from the Cartesian formulation: `Q(q, v, a) = M a + Q(q, v, 0) = 0`, which no
/// generated code has a part in.
fn acceleration(q: [f64; 3], v: [f64; 3]) -> [f64; 3] {
    let cartesian = Cartesian {
        masses: TRIPLE.masses,
        lengths: TRIPLE.lengths,
        gravity: TRIPLE.gravity,
    };
    let force = |a| independent::continuous_force(&cartesian, q, v, a);
    let rest = force([0.0; 3]);
    let columns: [[f64; 3]; 3] = core::array::from_fn(|j| {
        let along = force(core::array::from_fn(|i| f64::from(u8::from(i == j))));
        core::array::from_fn(|i| along[i] - rest[i])
    });
    let cross = |x: [f64; 3], y: [f64; 3]| {
        [
            x[1] * y[2] - x[2] * y[1],
            x[2] * y[0] - x[0] * y[2],
            x[0] * y[1] - x[1] * y[0],
        ]
    };
    let dot = |x: [f64; 3], y: [f64; 3]| x[0] * y[0] + x[1] * y[1] + x[2] * y[2];
    // Cramer's rule
    let [x, y, z] = columns;
    let whole = dot(x, cross(y, z));
    [
        -dot(rest, cross(y, z)) / whole,
        -dot(x, cross(rest, z)) / whole,
        -dot(x, cross(y, rest)) / whole,
    ]
}

/// The position at [`UNTIL`] by a Runge–Kutta method.
fn by_hand(tolerance: f64) -> [f64; 3] {
    let rate = |_, [a, b, c, u, v, w]: [f64; 6]| {
        let [x, y, z] = acceleration([a, b, c], [u, v, w]);
        [u, v, w, x, y, z]
    };
    let ([a, b, c], [u, v, w]) = (Q0, V0);
    let [x, y, z, ..] = dop853::integrate(rate, [a, b, c, u, v, w], UNTIL, tolerance);
    [x, y, z]
}

#[test]
fn three_links_are_of_order_two() {
    let exact = by_hand(1e-14);
    let coarse = by_hand(1e-12);
    let uncertainty = distance(exact, coarse);
    assert!(uncertainty < 1e-10, "{uncertainty:e}");
    let steps = [800_u32, 1600, 3200, 6400, 12_800];
    let h = steps.map(|steps| UNTIL / f64::from(steps));
    let errors = core::array::from_fn::<_, 5, _>(|i| {
        let mut flow = Flow::new(&TRIPLE, h[i], Start::second_order(Q0, V0)).unwrap();
        let last = flow.until(UNTIL).unwrap().nodes.pop().unwrap();
        assert_eq!(last.index, u64::from(steps[i]));
        distance(last.q, exact)
    });
    println!("errors {errors:?}, slopes {:?}", local_slopes(&h, &errors));
    let slope = slope(&h, &errors);
    assert!((slope - 2.0).abs() < 0.02, "{slope}");
}

fn distance(x: [f64; 3], y: [f64; 3]) -> f64 {
    x.iter().zip(y).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
}

#[test]
fn the_energy_does_not_drift() {
    let chain = PlanarChain8::default();
    let q0 = core::array::from_fn(|i| 0.5 + 0.0625 * i as f64);
    // the energy at a leg's middle, where the midpoint map evaluates the Lagrangian
    let deviation = |h: f64, until: f64| {
        let mut flow = Flow::new(&chain, h, Start::second_order(q0, [0.0; 8])).unwrap();
        let mut energies: Vec<f64> = Vec::new();
        while flow.time() < until {
            flow.advance().unwrap();
            let leg = flow.leg();
            let middle = core::array::from_fn(|i| leg.q[i] - leg.d[i] / 2.0);
            energies.push(chain.energy(0.0, &middle, &leg.d.map(|d| d / h)));
        }
        let half = energies.len() / 2;
        let size = |part: &[f64]| {
            part.iter()
                .map(|energy| (energy - energies[0]).abs())
                .fold(0.0, f64::max)
        };
        (size(&energies[..half]), size(&energies[half..]))
    };
    let (early, late) = deviation(2e-3, 20.0);
    println!("energy deviates by {early:e} in the first half, {late:e} in the second");
    assert!(late < 2.0 * early, "{early:e} {late:e}");
    // and falls with the square of the step
    let steps = [2e-3, 1e-3, 5e-4];
    let deviations = steps.map(|h| deviation(h, 10.0).0);
    let order = slope(&steps, &deviations);
    println!("{deviations:?}, order {order}");
    assert!((order - 2.0).abs() < 0.1, "{order} from {deviations:?}");
}

/// In a chain at rest, a pull at the inner end moves the outer end by only 1e-10 as much within one or two steps. The
/// second differences span many decades, and the small ones are known to as many digits as the rounding of the rows
/// leaves. No step takes more than 8 evaluations, over 500 steps of six sizes from two starts.
#[test]
fn a_chain_at_rest_is_solved_in_few_evaluations() {
    let chain = PlanarChain8 {
        masses: [0.1; 8],
        lengths: [0.1; 8],
        gravity: 9.81,
    };
    let bent = core::array::from_fn(|i| if i == 0 { 1.0 } else { 0.0 });
    for q0 in [[1.0; 8], bent] {
        for h in [0.005, 0.004, 0.003, 0.002, 0.001, 0.0005] {
            let mut flow = Flow::new(&chain, h, Start::second_order(q0, [0.0; 8])).unwrap();
            let most = (0..500)
                .map(|_| flow.advance().unwrap().iterations)
                .max()
                .unwrap();
            println!("h = {h}: at most {most} evaluations in one of 500 steps");
            // a search from guess to guess took hundreds
            assert!(most <= 8, "h = {h}: {most}");
        }
    }
}
