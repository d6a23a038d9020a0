//! The linear models of all systems of the library, about their default starts.

use dsocs_core::geometry::motion_near;
use dsocs_core::linear::{LinearizationError, OperatingPoint};
use dsocs_core::{AnyStart, Declaration, SetupError};
use dsocs_systems::{Entry, systems};

use super::random::slope;
use super::step::{exponential, product};

/// The default start of a system, projected onto the constraints: the state about which it is linearized.
fn start(entry: &Entry) -> AnyStart {
    let [q, v] = entry.default_start().unwrap();
    let start = AnyStart::second_order(q, v).at(0.3).projected();
    match entry.default_near() {
        Some(near) => start.near_acceleration(near),
        None => start,
    }
}

#[test]
fn models_are_derivatives_of_the_motion_and_of_the_step() {
    let (mut compared, mut worst) = (Vec::new(), [0.0_f64; 2]);
    for entry in systems::all() {
        let kernel = entry.kernel();
        let point = OperatingPoint::new(kernel, start(&entry));
        let model = match point.continuous() {
            Ok(model) => model,
            Err(LinearizationError::Setup(SetupError::ThirdOrder { .. })) => {
                assert_eq!(kernel.shape().order, 3);
                continue;
            }
            Err(error) => panic!("{}: {error}", entry.name()),
        };
        let at = model.point.any();
        let n = at.q.len();
        let lower = Declaration::of(kernel).lower() + Declaration::of(kernel).holonomic();
        assert_eq!(model.states.len(), 2 * n - lower, "{}", entry.name());
        // by differences of the motion, one state after another
        let size = model
            .a
            .iter()
            .flatten()
            .fold(1.0_f64, |most, x| most.max(x.abs()));
        for (k, direction) in model.basis.iter().enumerate() {
            let moved = |by: f64| {
                let state = |own: &[f64], part: &[f64]| -> Vec<f64> {
                    own.iter().zip(part).map(|(x, y)| x + by * y).collect()
                };
                let (q, v) = (state(at.q, &direction[..n]), state(at.v, &direction[n..]));
                let there = motion_near(kernel, (at.t, &q, &v), Some(at.a)).unwrap();
                let rate = [there.any().v, there.any().a].concat();
                model
                    .projection
                    .iter()
                    .map(|row| row.iter().zip(&rate).map(|(x, y)| x * y).sum())
                    .collect()
            };
            // steep functions, as the tanh of the pendulum's law, need a short shift, rounded ones a long
            // shift
            let apart = |shift: f64| -> f64 {
                let pairs = model.a.iter().zip(slope(&moved, shift));
                pairs.fold(0.0, |most, (row, found)| most.max((row[k] - found).abs() / size))
            };
            let least = [2e-3, 1e-4, 5e-6]
                .map(apart)
                .into_iter()
                .fold(f64::INFINITY, f64::min);
            worst[0] = worst[0].max(least);
            assert!(least < 1e-8, "{}, state {k}: {least:e}", entry.name());
        }
        // for a short step: I + h A, with a remainder of second order
        let left = |h: f64| -> f64 {
            let scaled: Vec<Vec<f64>> = model
                .a
                .iter()
                .map(|row| row.iter().map(|x| h * x).collect())
                .collect();
            let step = OperatingPoint::new(kernel, start(&entry)).step(h).unwrap();
            assert_eq!(step.states, model.states);
            // the free directions of the next node may differ, so its state is expressed in those of this
            // node
            let after: Vec<Vec<f64>> = (0..2 * n)
                .map(|i| step.basis_after.iter().map(|own| own[i]).collect())
                .collect();
            let found = product(&model.projection, &product(&after, &step.a));
            let pairs = found.concat().into_iter().zip(exponential(&scaled).concat());
            pairs.fold(0.0, |most: f64, (x, y)| most.max((x - y).abs()))
        };
        let h = 0.004 / size.sqrt().max(size / 100.0);
        let [coarse, fine] = [left(h), left(h / 4.0)];
        worst[1] = worst[1].max(fine);
        assert!(
            fine < coarse / 12.0 || fine < 1e-9 * size,
            "{}: {coarse:e} {fine:e}",
            entry.name()
        );
        compared.push(entry.name().to_owned());
    }
    println!(
        "{} systems, at most {:.1e} away in A, {:.1e} in the step: {compared:?}",
        compared.len(),
        worst[0],
        worst[1]
    );
    assert!(compared.len() >= 24, "{compared:?}");
}
