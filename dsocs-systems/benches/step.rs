//! Nanoseconds per step and per residual with Jacobian, generated code beside hand-written code.
//!
//! Criterion measures the steps of each alone. Then both are measured in turn, batch by batch, and the table shows the median of each and the median
//! of the batches' ratios: noise of the machine affects both alike. Everything is built with cargo's release profile, as a user's crate is.
//!
//! The table is also written to `target/report/step.json`.

#![allow(missing_docs)] // a bench is no library
#![allow(clippy::inline_always)] // the hand-written codes have to be as fast as possible

mod handwritten;
mod measure;
mod report;

use dsocs_systems as systems;

use std::hint::black_box;

use criterion::{BatchSize, Criterion, Throughput};
use dsocs_systems::InertiaWheelPendulum;
use measure::{CIRCLE, H, PARTICLE, PENDULUM, Steps, field, flow, particle_by_hand, pendulum_by_hand, wavy};

/// A thousand steps from a state in the middle of the run.
fn criterion_steps<S: Steps>(criterion: &mut Criterion, name: &str, variant: &str, mut start: S) {
    const STEPS: u32 = 1000;
    for _ in 0..300 {
        start.step();
    }
    let mut group = criterion.benchmark_group(name);
    group.throughput(Throughput::Elements(u64::from(STEPS)));
    group.bench_function(variant, |bencher| {
        bencher.iter_batched_ref(
            || start.clone(),
            |stepper| {
                for _ in 0..STEPS {
                    black_box(stepper.step());
                }
            },
            BatchSize::SmallInput,
        );
    });
    group.finish();
}

fn main() {
    let wavy = wavy();
    let pendulum = InertiaWheelPendulum::default();
    let mut criterion = Criterion::default().configure_from_args();
    let name = "particle";
    criterion_steps(&mut criterion, name, "generated", flow(&CIRCLE, H, PARTICLE));
    criterion_steps(&mut criterion, name, "by hand", particle_by_hand(|_, _| 1.0));
    let name = "particle_field";
    criterion_steps(&mut criterion, name, "generated", flow(&wavy, H, PARTICLE));
    criterion_steps(&mut criterion, name, "by hand", particle_by_hand(field));
    let name = "pendulum";
    criterion_steps(&mut criterion, name, "generated", flow(&pendulum, H, PENDULUM));
    criterion_steps(&mut criterion, name, "by hand", pendulum_by_hand());
    criterion.final_summary();

    let given = |argument: &str| std::env::args().any(|given| given == argument);
    let is_test = given("--test");
    let batches = match (is_test, given("--quick")) {
        (true, _) => 2,
        (false, true) => 400,
        (false, false) => 4000,
    };
    let lines = measure::lines(batches);
    report::show(&lines);
    if !is_test {
        report::write(&lines);
    }
}
