//! What is walked in lanes has the bits of what is compiled, with every set of instructions.

use core::num::NonZeroU64;
use core::ops::ControlFlow;

use dsocs_macros::dsocs;

use crate::number::instructions::Instructions;
use crate::run::{Node, OwnedNode};
use crate::start::{AnyStart, Start};
use crate::step::TapeKernel;
use crate::system::System;
use crate::tape::Tape;
use crate::testing::{Cliff, Particle};
use crate::{AnyEnsemble, Ensemble, Kernel};

/// A swing with functions that lanes have code of their own for.
#[dsocs {
    coordinates(x);
    lagrangian = (2 + x.cos()) * dot(x).powi(2) / 2 - stiff * (x.exp() - (x / 3).tanh() + x.exp_m1().powi(2));
    external_forces = (-dot(x) * x.sin() / 9);
}]
struct Swing {
    stiff: f64,
}

/// Masses that are tied together.
macro_rules! tied {
    ($($name:ident: $count:literal),*) => {
        $(
            /// Masses.
            #[dsocs {
                coordinates(x: [$count]);
                let mass = |k| 2 + x[k].powi(2);
                let tie = |k| dot(x[k]) * dot(x[k - 1]) * (x[k] - x[k - 1]) / 4 - (x[k] - x[k - 1]).powi(2);
                lagrangian = sum(0..$count, |k| mass(k) * dot(x[k]).powi(2) / 2 - stiff * x[k].powi(2)) + sum(1..$count, |k| tie(k));
            }]
            struct $name {
                stiff: f64,
            }
        )*
    };
}

tied!(Two: 2, Three: 3);

/// Maps whose point is not the node.
#[dsocs {
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2;
    phi_lagrangian = midpoint;
    phi_kinematic = |q0, q1, q2| ((q0 + 2 * q1 + q2) / 4, (q2 - q0) / (2 * h), (q2 - 2 * q1 + q0) / h.powi(2));
}]
struct Between;

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

/// All that is told of some nodes, with the shortest decimals: no two numbers are the same.
fn told<const N: usize>(nodes: &[Node<N>]) -> Vec<String> {
    nodes
        .iter()
        .map(|node| format!("{:?}", OwnedNode::of(&node.any())))
        .collect()
}

/// Compares a compiled system with its tape, in 11 runs with every set of instructions. Returns how many nodes were compared.
fn compare<S: System<N> + Sync, const N: usize>(system: &S, h: f64, until: f64) -> usize {
    let tape = of_tape(system.kernel());
    let numbers =
        |k: usize| core::array::from_fn::<f64, N, _>(|i| 0.1 + 0.37 * (1.7 * (k * N + i) as f64).sin());
    let starts = |k: usize| (numbers(k), numbers(k + 20), 0.1 * k as f64);
    let every = NonZeroU64::new(3).unwrap();
    let mut count = 0;
    for instructions in Instructions::ALL {
        let compiled = Ensemble::new(system, h)
            .unwrap()
            .starts(
                (0..11)
                    .map(starts)
                    .map(|(q, v, t0)| Start::second_order(q, v).projected().at(t0)),
            )
            .instructions(instructions)
            .stream(until, every, |_| crate::Trajectory::<N>::default());
        let walked = AnyEnsemble::of_tape(&tape, h)
            .unwrap()
            .starts(
                (0..11)
                    .map(starts)
                    .map(|(q, v, t0)| AnyStart::second_order(&q, &v).projected().at(t0)),
            )
            .instructions(instructions);
        let walked = walked.stream(
            until,
            every,
            |_| Vec::new(),
            |nodes, node| {
                nodes.push(format!("{:?}", OwnedNode::of(node)));
                ControlFlow::Continue(())
            },
        );
        for (one, other) in compiled.iter().zip(walked) {
            assert_eq!(
                told(&one.observer.nodes),
                other.observer,
                "{} {instructions}",
                S::NAME
            );
            let (one, other) = (&one.last, &other.last);
            match (one, other) {
                (Ok(one), Ok(other)) => assert_eq!(told(&[*one]), [format!("{other:?}")]),
                (Err(one), Err(other)) => assert_eq!(one.to_string(), other.to_string()),
                (one, other) => panic!("{}: {one:?} {other:?}", S::NAME),
            }
        }
        count += compiled.iter().map(|run| run.observer.nodes.len()).sum::<usize>();
    }
    count
}

#[test]
fn what_is_walked_has_the_bits_of_what_is_compiled() {
    let mut count = compare(&Swing { stiff: 1.0 }, 0.02, 8.0);
    count += compare(&Two { stiff: 1.0 }, 0.02, 8.0);
    count += compare(&Three { stiff: 1.0 }, 0.02, 8.0);
    count += compare(&Between, 0.02, 8.0);
    count += compare(&Cliff, 0.01, 3.0);
    count += compare(&Particle::default(), 0.1, 30.0);
    assert!(count > 20_000, "{count}");
}
