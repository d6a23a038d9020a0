//! Interpreted steps in lanes have the bits of compiled ones, with every set of instructions. Only systems
//! are compiled here whose steps other tests of this crate make in lanes, too: they take long to compile.
//! More systems are compared in `tests/tape_kernel.rs`.

use core::num::NonZeroU64;
use core::ops::ControlFlow;

use dsocs_macros::dsocs;

use crate::number::instructions::Instructions;
use crate::run::{Node, OwnedNode, Trajectory};
use crate::start::{AnyStart, Start};
use crate::step::TapeKernel;
use crate::system::System;
use crate::tape::Tape;
use crate::testing::{Cliff, Particle};
use crate::{AnyEnsemble, Ensemble, Kernel};

/// A swing with functions that have vector code.
#[dsocs {
    coordinates(x);
    lagrangian = (2 + x.cos()) * dot(x).powi(2) / 2 - stiff * (x.exp() - (x / 3).tanh() + x.exp_m1().powi(2));
    external_forces = (-dot(x) * x.sin() / 9);
}]
struct Swing {
    stiff: f64,
}

/// Masses that are tied together.
#[dsocs {
    coordinates(x: [3]);
    let mass = |k| 2 + x[k].powi(2);
    let tie = |k| dot(x[k]) * dot(x[k - 1]) * (x[k] - x[k - 1]) / 4 - (x[k] - x[k - 1]).powi(2);
    lagrangian = sum(0..3, |k| mass(k) * dot(x[k]).powi(2) / 2 - stiff * x[k].powi(2)) + sum(1..3, |k| tie(k));
}]
struct Tied {
    stiff: f64,
}

/// The system of a tape and a shape alone.
fn of_tape(kernel: &dyn Kernel) -> TapeKernel {
    let shape = kernel.shape().clone();
    let values = (0..shape.parameters.len()).map(|place| kernel.value(place));
    let tape = Tape::owned(kernel.tape().bytes().to_vec()).unwrap();
    let of_tape = TapeKernel::new(tape, shape.clone(), values.collect()).unwrap();
    match kernel.sparse() {
        Some(sparse) => of_tape.sparse(sparse.clone()).unwrap(),
        None => of_tape,
    }
}

/// Numbers for the start `k`.
fn numbers<const N: usize>(k: usize) -> [f64; N] {
    core::array::from_fn(|i| 0.1 + 0.37 * (1.7 * (k * N + i) as f64).sin())
}

/// The end of a run, and the spacing of its observed nodes.
fn spacing(until: f64) -> (f64, NonZeroU64) {
    (until, NonZeroU64::new(3).unwrap())
}

/// 11 runs of a tape: the text of their observed nodes, then of the last one or the error.
fn interpreted<const N: usize>(
    tape: &TapeKernel,
    h: f64,
    until: f64,
    instructions: Instructions,
) -> Vec<Vec<String>> {
    let start = |k: usize| {
        AnyStart::second_order(&numbers::<N>(k), &numbers::<N>(k + 20))
            .projected()
            .at(0.1 * k as f64)
    };
    let ensemble = AnyEnsemble::of_tape(tape, h)
        .unwrap()
        .starts((0..11).map(start))
        .instructions(instructions);
    let (until, every) = spacing(until);
    let runs = ensemble.stream(
        until,
        every,
        |_| Vec::new(),
        |nodes, node| {
            nodes.push(format!("{:?}", OwnedNode::of(node)));
            ControlFlow::Continue(())
        },
    );
    let text = runs.into_iter().map(|mut run| {
        run.observer.push(match run.last {
            Ok(last) => format!("{last:?}"),
            Err(error) => error.to_string(),
        });
        run.observer
    });
    text.collect()
}

/// [`interpreted`] for a compiled system.
fn compiled<S: System<N> + Sync, const N: usize>(
    system: &S,
    h: f64,
    until: f64,
    instructions: Instructions,
) -> Vec<Vec<String>> {
    let start = |k: usize| {
        Start::second_order(numbers::<N>(k), numbers::<N>(k + 20))
            .projected()
            .at(0.1 * k as f64)
    };
    let ensemble = Ensemble::new(system, h)
        .unwrap()
        .starts((0..11).map(start))
        .instructions(instructions);
    let (until, every) = spacing(until);
    let runs = ensemble.stream(until, every, |_| Trajectory::<N>::default());
    // with the shortest decimals, different numbers have different texts
    let of = |node: &Node<N>| format!("{:?}", OwnedNode::of(&node.any()));
    let text = runs.into_iter().map(|run| {
        let mut text: Vec<String> = run.observer.nodes.iter().map(of).collect();
        text.push(match run.last {
            Ok(last) => of(&last),
            Err(error) => error.to_string(),
        });
        text
    });
    text.collect()
}

/// Compares a compiled system with its tape, with every set of instructions. Returns the number of nodes that
/// were compared.
fn compare<S: System<N> + Sync, const N: usize>(system: &S, h: f64, until: f64) -> usize {
    let tape = of_tape(system.kernel());
    let count = |instructions| {
        let runs = interpreted::<N>(&tape, h, until, instructions);
        let name = S::NAME;
        assert_eq!(
            compiled(system, h, until, instructions),
            runs,
            "{name} {instructions}"
        );
        runs.iter().map(Vec::len).sum::<usize>()
    };
    Instructions::ALL.into_iter().map(count).sum()
}

#[test]
fn interpreted_lanes_have_the_bits_of_compiled_ones() {
    let count = compare(&Cliff, 0.01, 3.0) + compare(&Particle::default(), 0.1, 30.0);
    assert!(count > 4_500, "{count}");
}

#[test]
fn all_instructions_give_the_same_bits() {
    fn check<const N: usize>(kernel: &dyn Kernel) {
        let tape = of_tape(kernel);
        let [narrow, wide, widest] =
            Instructions::ALL.map(|instructions| interpreted::<N>(&tape, 0.02, 8.0, instructions));
        assert!(narrow.iter().all(|run| run.len() > 100));
        assert_eq!(narrow, wide);
        assert_eq!(narrow, widest);
    }
    check::<1>(&Swing { stiff: 1.0 });
    check::<3>(&Tied { stiff: 1.0 });
}
