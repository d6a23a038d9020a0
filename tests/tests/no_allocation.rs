//! A step allocates no memory, and a long path allocates little.

use std::hint::black_box;

use dsocs_core::__private::{Tape, TapeKernel};
use dsocs_core::taylor::{TaylorFlow, Tolerance};
use dsocs_core::{
    AnyFlow, AnyStart, ComposedFlow, Composition, Flow, Kernel, Node, OwnedNode, Path, Start, Stepper, System,
};
use dsocs_systems::{CurvedParticle, InertiaWheelPendulum, PlanarChain8, Wavy};
use dsocs_tests::closed_form::pendulum::START;

fn allocations<S: System<2>>(system: &S, h: f64, start: Start<2>) {
    let mut flow = Flow::new(system, h, start).unwrap();
    let steps = allocation_counter::measure(|| {
        for _ in 0..1000 {
            flow.advance().unwrap();
        }
    });
    assert_eq!(
        steps.count_total, 0,
        "1000 steps allocate {} bytes",
        steps.bytes_total
    );

    let mut flow = Flow::new(system, h, start).unwrap();
    let nodes = allocation_counter::measure(|| {
        for _ in 0..1000 {
            flow.next().unwrap().unwrap();
        }
    });
    assert_eq!(
        nodes.count_total, 0,
        "1000 nodes allocate {} bytes",
        nodes.bytes_total
    );

    let mut energy = 0.0;
    let stream = allocation_counter::measure(|| {
        flow.stream(2000.0 * h, &mut |node: &Node<2>| energy += node.energy)
            .unwrap();
    });
    assert_eq!(
        stream.count_total, 0,
        "a stream of 1000 nodes allocates {} bytes",
        stream.bytes_total
    );
    assert!(energy.is_finite());
}

#[test]
fn the_particle() {
    let start = Start::second_order([0.0, 0.0], [1.0, 1.0]);
    allocations(&CurvedParticle::default(), 0.1, start);
    allocations(
        &CurvedParticle {
            mass: 1.0,
            curvature: Wavy::default(),
        },
        0.01,
        start,
    );
}

#[test]
fn the_pendulum() {
    allocations(
        &InertiaWheelPendulum::default(),
        0.1,
        Start::paper(START.0, START.1),
    );
}

#[test]
fn a_system_that_was_not_compiled() {
    // the chain has more unknowns than fit into an inline vector
    fn allocations(kernel: &dyn Kernel, start: &AnyStart) {
        let shape = kernel.shape().clone();
        let values = (0..shape.parameters.len()).map(|place| kernel.value(place));
        let tape = Tape::owned(kernel.tape().bytes().to_vec()).unwrap();
        let mut of_tape = TapeKernel::new(tape, shape, values.collect()).unwrap();
        if let Some(sparse) = kernel.sparse() {
            of_tape = of_tape.sparse(sparse.clone()).unwrap();
        }
        let mut flow = AnyFlow::new(&of_tape, 0.005, start).unwrap();
        let flow = flow.run_mut();
        let mut node = OwnedNode::new(kernel.shape().dimension());
        // memory for the first steps is kept by the thread
        for _ in 0..10 {
            flow.advance().unwrap();
        }
        let steps = allocation_counter::measure(|| {
            for _ in 0..300 {
                flow.advance().unwrap();
                flow.write_node(node.as_node_mut());
            }
        });
        assert_eq!(
            steps.count_total, 0,
            "300 steps allocate {} bytes",
            steps.bytes_total
        );
    }
    allocations(
        InertiaWheelPendulum::default().kernel(),
        &AnyStart::paper(&START.0, &START.1),
    );
    allocations(
        PlanarChain8::default().kernel(),
        &AnyStart::second_order(&[1.0; 8], &[0.0; 8]),
    );
}

#[test]
fn a_composed_step() {
    fn allocations<S: System<2>>(system: &S, q0: [f64; 2], v0: [f64; 2]) {
        for method in [
            Composition::SUZUKI_4,
            Composition::KAHAN_LI_6,
            Composition::KAHAN_LI_8,
        ] {
            let mut flow = ComposedFlow::new(system, 0.1, method, Start::second_order(q0, v0)).unwrap();
            let steps = allocation_counter::measure(|| {
                for _ in 0..300 {
                    flow.next().unwrap().unwrap();
                }
            });
            assert_eq!(
                steps.count_total, 0,
                "300 steps of {method} allocate {} bytes",
                steps.bytes_total
            );
        }
    }
    allocations(&CurvedParticle::default(), [0.0, 0.0], [1.0, 1.0]);
    allocations(&InertiaWheelPendulum::default(), START.0, START.1);
}

#[test]
fn the_taylor_flow() {
    fn allocations<S: System<N>, const N: usize>(system: &S, start: Start<N>) {
        let mut flow = TaylorFlow::new(system, start, Tolerance::relative(1e-10)).unwrap();
        flow.step(1e6).unwrap();
        let steps = allocation_counter::measure(|| {
            for _ in 0..300 {
                flow.step(1e6).unwrap();
            }
        });
        assert_eq!(
            steps.count_total, 0,
            "300 steps allocate {} bytes",
            steps.bytes_total
        );
    }
    let particle = Start::second_order([0.0, 0.0], [1.0, 1.0]);
    allocations(&CurvedParticle::default(), particle);
    let field = CurvedParticle {
        mass: 1.0,
        curvature: Wavy::default(),
    };
    allocations(&field, particle);
    allocations(
        &InertiaWheelPendulum::default(),
        Start::second_order(START.0, START.1),
    );
    allocations(&PlanarChain8::default(), Start::second_order([0.3; 8], [0.0; 8]));
}

#[test]
fn the_counter_counts() {
    let counted = allocation_counter::measure(|| drop(black_box(Box::new(1.0))));
    assert_eq!(counted.count_total, 1);
}

/// The memory of a path grows with the square root of its length if it is bounded.
#[test]
fn a_long_path_needs_little_memory() {
    let particle = CurvedParticle::default();
    let start = Start::second_order([0.0, 0.0], [1.0, 0.0]);
    let needed = |steps: f64, memory: usize| {
        let measured = allocation_counter::measure(|| {
            let path = Path::within(&particle, 0.01, start, 0.01 * steps, memory).unwrap();
            black_box(path.gradient_at_end(&mut |end| end.q[0]).unwrap());
        });
        measured.bytes_max as f64
    };
    let (kept, short, long) = (
        needed(40_000.0, usize::MAX),
        needed(40_000.0, 0),
        needed(160_000.0, 0),
    );
    assert!(short < 0.2 * kept && long < 2.5 * short, "{kept} {short} {long}");
}
