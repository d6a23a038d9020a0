//! Many trajectories: one flow after the other, against an ensemble on one thread and on all.

use std::hint::black_box;
use std::time::Instant;

use dsocs_core::{Ensemble, Flow, Start, Stepper, System};

/// Trajectories: thirty-two blocks of eight.
const TRAJECTORIES: u32 = 256;

/// Steps of each.
const STEPS: u32 = 500;

/// Nanoseconds per step and trajectory, medians; and the medians of the rounds' gains.
pub struct Throughput {
    pub system: &'static str,
    pub flows: f64,
    pub ensemble: f64,
    pub all_threads: f64,
    /// Of an ensemble on one thread over single flows.
    pub lanes: f64,
    /// Of all threads over one.
    pub threads: f64,
}

/// Measures the three in turn.
pub fn measure<S: System<2> + Sync>(
    system: &S,
    name: &'static str,
    h: f64,
    start: impl Fn(f64) -> Start<2>,
    rounds: usize,
) -> Throughput {
    let starts: Vec<Start<2>> = (0..TRAJECTORIES)
        .map(|k| start(f64::from(k) / f64::from(TRAJECTORIES)))
        .collect();
    let until = h * f64::from(STEPS);
    let ensemble = |threads| {
        let ensemble = Ensemble::new(system, h).expect("a usable step");
        ensemble.starts(starts.clone()).threads(threads).expect("threads")
    };
    let (one, all) = (ensemble(1), ensemble(0));
    let time = |work: &dyn Fn()| {
        let begin = Instant::now();
        work();
        begin.elapsed().as_secs_f64() * 1e9 / f64::from(TRAJECTORIES * STEPS)
    };
    let flows = || {
        for start in &starts {
            let mut flow = Flow::new(system, h, *start).expect("a usable start");
            for _ in 0..STEPS {
                flow.advance().expect("the step has a solution");
            }
            black_box(flow.position());
        }
    };
    let on = |ensemble: &Ensemble<'_, S, 2>| drop(black_box(ensemble.to(until)));
    let mut columns: [Vec<f64>; 5] = Default::default();
    for _ in 0..rounds {
        let times = [time(&flows), time(&|| on(&one)), time(&|| on(&all))];
        for (column, time) in columns.iter_mut().zip(times) {
            column.push(time);
        }
        columns[3].push(times[0] / times[1]);
        columns[4].push(times[1] / times[2]);
    }
    let [flows, ensemble, all_threads, lanes, threads] = columns.map(crate::measure::median);
    Throughput {
        system: name,
        flows,
        ensemble,
        all_threads,
        lanes,
        threads,
    }
}
