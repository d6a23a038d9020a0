//! The number of instructions of a thousand steps, generated code beside hand-written code: unlike times,
//! counts do not vary.
//!
//! Behind the feature `instructions`. Needs valgrind, and `cargo install gungraun-runner` in the version of `gungraun`.

#![allow(missing_docs, dead_code)] // a bench is no library, and counts what another bench times
#![allow(unused_qualifications)] // in the code that the attribute of the counting crate writes
#![allow(clippy::inline_always)] // the hand-written codes have to be as fast as possible
#![allow(clippy::large_types_passed_by_value)] // a counted function takes its prepared state by value

mod handwritten;
mod measure;

use dsocs_systems as systems;

use std::hint::black_box;
use std::sync::LazyLock;

use dsocs_core::Flow;
use dsocs_systems::{Constant, CurvedParticle, InertiaWheelPendulum, PlanarChain8, Wavy};
use gungraun::{library_benchmark, library_benchmark_group, main};
use handwritten::{chain::Chain, particle::Particle, pendulum::Pendulum};
use measure::{CHAIN, CIRCLE, H, H_CHAIN, PARTICLE, PENDULUM, Steps, flow};

static WAVY: LazyLock<CurvedParticle<Wavy>> = LazyLock::new(measure::wavy);
static WHEEL: LazyLock<InertiaWheelPendulum> = LazyLock::new(InertiaWheelPendulum::default);
static LINKS: LazyLock<PlanarChain8> = LazyLock::new(PlanarChain8::default);

/// A curvature, as a function pointer.
type Field = fn(f64, f64) -> f64;

/// A state in the middle of a run.
fn warm<S: Steps>(mut start: S) -> S {
    for _ in 0..300 {
        start.step();
    }
    start
}

fn thousand<S: Steps>(mut stepper: S) -> u32 {
    (0..1000).map(|_| black_box(stepper.step())).sum()
}

#[library_benchmark]
#[bench::generated(warm(flow(&CIRCLE, H, PARTICLE)))]
fn particle(stepper: Flow<'static, 2>) -> u32 {
    thousand(stepper)
}

#[library_benchmark]
#[bench::by_hand(warm(measure::particle_by_hand(measure::one as Field)))]
fn particle_by_hand(stepper: Particle<Field>) -> u32 {
    thousand(stepper)
}

#[library_benchmark]
#[bench::generated(warm(flow(&*WAVY, H, PARTICLE)))]
fn particle_field(stepper: Flow<'static, 2>) -> u32 {
    thousand(stepper)
}

#[library_benchmark]
#[bench::by_hand(warm(measure::particle_by_hand(measure::field as Field)))]
fn particle_field_by_hand(stepper: Particle<Field>) -> u32 {
    thousand(stepper)
}

#[library_benchmark]
#[bench::generated(warm(flow(&*WHEEL, H, PENDULUM)))]
fn pendulum(stepper: Flow<'static, 2>) -> u32 {
    thousand(stepper)
}

#[library_benchmark]
#[bench::by_hand(warm(measure::pendulum_by_hand()))]
fn pendulum_by_hand(stepper: Pendulum) -> u32 {
    thousand(stepper)
}

#[library_benchmark]
#[bench::generated(warm(flow(&*LINKS, H_CHAIN, CHAIN)))]
fn chain8(stepper: Flow<'static, 8>) -> u32 {
    thousand(stepper)
}

#[library_benchmark]
#[bench::by_hand(warm(measure::chain_by_hand()))]
fn chain8_by_hand(stepper: Chain<8>) -> u32 {
    thousand(stepper)
}

library_benchmark_group!(
    name = steps;
    benchmarks = particle, particle_by_hand, particle_field, particle_field_by_hand,
        pendulum, pendulum_by_hand, chain8, chain8_by_hand
);

main!(library_benchmark_groups = steps);
