//! Machine code that is made at run time gives the bits of the interpreter, and so of compiled systems.

#![cfg(target_arch = "x86_64")] // where code is made

use std::sync::Arc;

use dsocs_core::text::{TapeKernel, Text};
use dsocs_core::{AnyComposedFlow, AnyFlow, AnyStart, Composition, Kernel, OwnedNode, Run, Shape};
use dsocs_systems::systems::all;

/// The bits of all numbers at the node where a run stands; all NaN are alike.
fn bits(run: &dyn Run) -> Vec<u64> {
    let mut node = OwnedNode::new(0);
    node.take(run);
    let node = node.any();
    let vectors = [node.q, node.v, node.a, node.force, &[node.t, node.energy]];
    let numbers = vectors.into_iter().flatten();
    numbers
        .map(|x| if x.is_nan() { 0 } else { x.to_bits() })
        .collect()
}

/// The shape of a system.
fn shape(kernel: &TapeKernel) -> &Shape {
    let kernel: &dyn Kernel = kernel;
    kernel.shape()
}

/// A system twice: interpreted, and compiled to machine code.
fn both(text: &str) -> [TapeKernel; 2] {
    let read = || Text::parse("system", text).unwrap().system;
    let compiled = read();
    compiled.compile().unwrap();
    [read().interpreted(), compiled]
}

/// Compares the steps of two kernels. Returns the number of steps made.
fn same_steps(kernels: &[TapeKernel; 2], h: f64, start: &AnyStart, steps: u32) -> u32 {
    let mut flows = kernels
        .each_ref()
        .map(|kernel| AnyFlow::new(kernel, h, start).unwrap());
    for step in 0..steps {
        let [one, other] = flows.each_mut().map(|flow| {
            let report = flow.run_mut().advance();
            report.map_err(|error| error.to_string())
        });
        let name = &shape(&kernels[0]).name;
        assert_eq!(one, other, "{name}: step {step}");
        if one.is_err() {
            return step;
        }
        let [one, other] = flows.each_ref().map(|flow| bits(flow.run()));
        assert_eq!(one, other, "{name}: step {step}");
    }
    steps
}

#[test]
fn every_system_makes_the_steps_of_the_interpreter() {
    let (mut systems, mut nodes) = (0, 0);
    for entry in all() {
        let name = &entry.description().itself.name;
        let Ok(kernels) = entry.text().map(|text| both(&text)) else {
            println!("{name}: no text");
            continue;
        };
        let [q, v] = entry.default_start().unwrap();
        let start = AnyStart::second_order(q, v);
        let start = match entry.default_acceleration().or(entry.default_near()) {
            Some(a) if shape(&kernels[0]).is_of_third_order() => AnyStart::third_order(q, v, a),
            Some(a) => start.near_acceleration(a),
            None => start,
        };
        let made = same_steps(&kernels, entry.default_step(), &start, 1000);
        println!("{name:>30}: {made} nodes");
        systems += 1;
        nodes += made;
    }
    assert!(systems > 24 && nodes > 20_000, "{systems} {nodes}");
}

/// A chain of many links, whose programs are split into several pieces of code.
fn chain(links: usize) -> String {
    format!(
        "const n = {links};
         parameters {{ gravity = 9.81, masses: [n] = [0.1; n] }}
         coordinates(theta: [n]);
         let cosine = |i, j| theta[i].cos() * theta[j].cos() + theta[i].sin() * theta[j].sin();
         let beyond = |i| sum(i..n, |k| masses[k]);
         lagrangian = sum(0..n, |i| beyond(i) * (dot(theta[i]).powi(2) / 2
                 + sum(0..i, |j| cosine(i, j) * dot(theta[i]) * dot(theta[j]))))
             + gravity * sum(0..n, |i| beyond(i) * theta[i].cos());
         phi_lagrangian = |q0, q1| ((q0 + q1) / 2, (q1 - q0) / h);"
    )
}

#[test]
fn a_long_program_is_made_in_pieces() {
    let kernels = both(&chain(12));
    let start = AnyStart::second_order(&[0.4; 12], &[0.1; 12]);
    assert_eq!(same_steps(&kernels, 0.001, &start, 200), 200);
}

/// A system with signs, comparisons, whole and other powers, a table, and functions without a processor
/// instruction.
const EVERYTHING: &str = "
    parameters { mass = 1.5, power = 1.3, push = samples(\"push.csv\") }
    coordinates(x, y, z);
    let all = x.exp() + y.exp_m1() + (2 + x).ln() + y.ln_1p() + x.cbrt() + (1 + y.powi(2)).powf(power) + (x / 4).asin() + (y / 4).acos()
        + x.atan() + y.sinh() + x.cosh() + y.tan() + (1 + x).asinh() + (3 + y).acosh() + (x / 5).atanh() + y.atan2(2 + x) + 1 / (3 + y)
        + x / (2 + y.powi(3)) + x.powi(-3) / 99 + (1 + x).powi(7) / 999 + y.powf(x / 9) + (t / 7).cos() * x.sin() + x.abs() + y.signum() / 9
        + x.min(y) + x.max(y / 3) + push.at(x) + push.at(t) * y;
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2) * (2 + x.sin()))
        - (1 + x.powi(2)).sqrt() - (y / 3).exp() * z.cos() - all / 10;
    holonomic = [x.powi(2) + y.powi(2) + z - 1];
    external_forces = (-(dot(x) / 2).tanh(), t.sin() * y.atan() - dot(y).signum() / 50, dot(z).abs() / (2 + y.powi(2)));
";

#[test]
fn every_operation_and_a_table_have_the_bits_of_the_interpreter() {
    let table = vec![(-2.0, 0.1), (0.0, 0.0), (1.0, 1.0), (2.0, 0.5), (60.0, 0.9)];
    let tables = [("push.csv".to_owned(), table)];
    let read = || {
        Text::parse_with("everything", EVERYTHING, &[], &tables)
            .unwrap()
            .system
    };
    let compiled = read();
    compiled.compile().unwrap();
    let kernels = [read().interpreted(), compiled];
    for (q, v) in [
        ([0.5, 0.25, 0.6875], [1.0, -0.5, -0.75]),
        ([0.1, 0.7, 0.5], [0.2, 0.3, -0.46]),
    ] {
        // the motion may leave the domain of a function at the end
        let made = same_steps(&kernels, 0.001, &AnyStart::second_order(&q, &v), 1000);
        assert!(made > 300, "{made}");
    }
}

const PENDULUM: &str = "parameters { gravity = 9.81 }
    coordinates(theta);
    lagrangian = dot(theta).powi(2) / 2 + gravity * theta.cos();
    external_forces = (-dot(theta) / 10);";

#[test]
fn a_run_goes_over_to_machine_code_on_its_way() {
    let read = || Text::parse("pendulum", PENDULUM).unwrap().system;
    let kernels = [read().interpreted(), read()];
    let start = AnyStart::second_order(&[2.0], &[0.0]);
    // step by step, and in one call
    assert_eq!(same_steps(&kernels, 0.01, &start, 3000), 3000);
    let fresh = read();
    let ends = [&kernels[0], &fresh].map(|kernel| {
        let mut flow = AnyFlow::new(kernel, 0.01, &start).unwrap();
        flow.run_mut().to(50.0).unwrap();
        bits(flow.run())
    });
    assert_eq!(ends[0], ends[1]);
}

#[test]
fn a_kernel_with_other_values_has_the_same_code() {
    let kernels = both(PENDULUM).map(|mut kernel| {
        *kernel.parameter_mut(0).unwrap() = 1.62;
        kernel
    });
    let start = AnyStart::second_order(&[2.0], &[0.0]);
    let on_earth = both(PENDULUM);
    assert_eq!(same_steps(&kernels, 0.01, &start, 1000), 1000);
    let end = |kernel: &TapeKernel| {
        let mut flow = AnyFlow::new(kernel, 0.01, &start).unwrap();
        flow.run_mut().to(1.0).unwrap();
        bits(flow.run())
    };
    assert_ne!(end(&kernels[1]), end(&on_earth[1]));
}

#[test]
fn composed_steps_have_the_bits_of_the_interpreter() {
    let kernels = both(PENDULUM.split("external").next().unwrap());
    let start = AnyStart::second_order(&[2.0], &[0.0]);
    let ends = kernels.each_ref().map(|kernel| {
        let flow = AnyComposedFlow::new(kernel, 0.05, Composition::KAHAN_LI_6, &start).unwrap();
        let mut run = flow.into_run();
        run.to(20.0).unwrap();
        bits(&*run)
    });
    assert_eq!(ends[0], ends[1]);
}

#[test]
fn kernels_that_are_dropped_leave_nothing() {
    let make = || {
        let kernel = Text::parse("pendulum", PENDULUM).unwrap().system;
        kernel.compile().unwrap();
        let start = AnyStart::second_order(&[2.0], &[0.0]);
        AnyFlow::new(&kernel, 0.01, &start)
            .unwrap()
            .run_mut()
            .to(0.1)
            .unwrap();
    };
    // thread-local memory is allocated once
    make();
    let counted = allocation_counter::measure(|| {
        for _ in 0..20 {
            make();
        }
    });
    // a text is parsed on a thread of its own, whose allocations are freed here
    let kept = counted.bytes_current.max(0);
    assert!(kept < 4096, "{kept} bytes");
}

#[test]
fn threads_share_the_code_of_a_kernel() {
    let kernel = Arc::new(Text::parse("pendulum", PENDULUM).unwrap().system);
    let start = AnyStart::second_order(&[2.0], &[0.0]);
    let ends: Vec<_> = (0..4)
        .map(|_| {
            let (kernel, start) = (Arc::clone(&kernel), start.clone());
            std::thread::spawn(move || {
                let mut flow = AnyFlow::new(&*kernel, 0.01, &start).unwrap();
                flow.run_mut().to(40.0).unwrap();
                bits(flow.run())
            })
        })
        .collect();
    let ends: Vec<_> = ends.into_iter().map(|end| end.join().unwrap()).collect();
    assert!(ends.iter().all(|end| *end == ends[0]));
}
