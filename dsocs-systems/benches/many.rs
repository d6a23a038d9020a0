//! Many runs: steps and Taylor series in lanes, and on all threads, against one run after the other; and the
//! cost of derivatives of a run, in units of the run.
//!
//! All are measured in turn in one process. A result is the median of the ratios of all rounds: noise of the
//! machine affects both times of a ratio alike.

#![allow(missing_docs)] // a bench is no library

use std::hint::black_box;
use std::time::Instant;

use dsocs_core::taylor::{TaylorEnsemble, TaylorFlow, Tolerance};
use dsocs_core::{Dual, Ensemble, Flow, Instructions, Path, Point, Start, Stepper, System, Variable};
use dsocs_systems::{CurvedParticle, InertiaWheelPendulum, Wavy};

/// The step, in s.
const H: f64 = 0.1;

/// The number of runs: eight blocks of eight.
const RUNS: u32 = 64;

/// The factor by which there are more runs when they are shared among threads.
const MORE: u32 = 8;

/// The number of steps of each run.
const STEPS: u32 = 2000;

/// A variant that computes many runs, in lanes or on threads: its label and its function.
type Many<'a> = (String, Box<dyn Fn() + 'a>);

/// The number of rounds.
struct Rounds(usize);

impl Rounds {
    /// The medians of the times of all works over that of the first, and of the time of the first \[s\].
    fn ratios(&self, works: &mut [&mut dyn FnMut()]) -> (f64, Vec<f64>) {
        let mut first = Vec::new();
        let mut all = vec![Vec::new(); works.len()];
        for _ in 0..self.0 {
            let mut before = 0.0;
            for (place, (work, ratios)) in works.iter_mut().zip(&mut all).enumerate() {
                let begin = Instant::now();
                work();
                let time = begin.elapsed().as_secs_f64();
                if place == 0 {
                    before = time;
                    first.push(time);
                }
                ratios.push(time / before);
            }
        }
        (median(first), all.into_iter().map(median).collect())
    }

    /// Prints the speed of the variants relative to one run after the other.
    fn gains(&self, name: &str, unit: f64, alone: &mut dyn FnMut(), many: &[Many<'_>]) {
        let mut works: Vec<Box<dyn FnMut() + '_>> = vec![Box::new(alone)];
        works.extend(many.iter().map(|(_, run)| Box::new(run) as Box<dyn FnMut()>));
        let mut works: Vec<&mut dyn FnMut()> = works.iter_mut().map(|work| &mut **work as _).collect();
        let (time, ratios) = self.ratios(&mut works);
        print!("{name:<24} alone {:>8.1} ns", time * 1e9 / unit);
        for ((label, _), ratio) in many.iter().zip(&ratios[1..]) {
            print!(", {label} {:.2} times as fast", 1.0 / ratio);
        }
        println!();
    }

    /// Steps of a fixed length.
    fn steps<S: System<2> + Sync>(&self, name: &str, system: &S, start: &dyn Fn(f64) -> Start<2>) {
        let starts = starts(start);
        let ensemble = |threads: usize, these: Instructions| {
            let ensemble = Ensemble::new(system, H).expect("a usable step");
            let ensemble = ensemble.starts(starts.iter().copied()).instructions(these);
            ensemble.threads(threads).expect("threads")
        };
        let mut many: Vec<Many<'_>> = Vec::new();
        let until = H * f64::from(STEPS);
        for these in available() {
            let ensemble = ensemble(1, these);
            let run = move || drop(black_box(ensemble.to(until)));
            many.push((these.to_string(), Box::new(run)));
        }
        let mut alone = || {
            for &start in &starts {
                let mut flow = Flow::new(system, H, start).expect("a usable start");
                for _ in 0..STEPS {
                    flow.advance().expect("the step has a solution");
                }
                black_box(flow.position());
            }
        };
        self.gains(name, f64::from(RUNS * STEPS), &mut alone, &many);
        // enough runs for the time of waking a thread not to matter
        let longer = |threads: usize| {
            let many = (0..MORE).flat_map(|_| starts.iter().copied());
            let ensemble = Ensemble::new(system, H).expect("a usable step").starts(many);
            ensemble.threads(threads).expect("threads")
        };
        let [one, all] = [longer(1), longer(0)];
        let mut on_one = || _ = black_box(one.to(until));
        let mut on_all = || _ = black_box(all.to(until));
        let (_, ratios) = self.ratios(&mut [&mut on_one, &mut on_all]);
        println!(
            "{:<24} all threads {:.2} times as fast as one, {} runs",
            "",
            1.0 / ratios[1],
            RUNS * MORE
        );
    }

    /// Taylor series.
    fn series<S: System<2> + Sync>(
        &self,
        name: &str,
        system: &S,
        (relative, until): (f64, f64),
        start: &dyn Fn(f64) -> Start<2>,
    ) {
        let starts = starts(start);
        let tolerance = Tolerance::relative(relative);
        let mut many: Vec<Many<'_>> = Vec::new();
        for these in available() {
            let ensemble = TaylorEnsemble::new(system, tolerance).expect("a usable tolerance");
            let ensemble = ensemble.starts(starts.iter().copied()).instructions(these);
            let ensemble = ensemble.threads(1).expect("threads");
            let run = move || drop(black_box(ensemble.to(until)));
            many.push((these.to_string(), Box::new(run)));
        }
        let mut alone = || {
            for &start in &starts {
                let mut flow = TaylorFlow::new(system, start, tolerance).expect("a usable start");
                black_box(flow.to(until).expect("the motion goes on"));
            }
        };
        let unit = f64::from(RUNS) * until;
        self.gains(
            &format!("{name}, {relative:e}, a second"),
            unit,
            &mut alone,
            &many,
        );
    }

    /// Derivatives of a run.
    fn derivatives<S: System<2>>(&self, name: &str, system: &S, start: Start<2>, parameter: &str) {
        let until = H * f64::from(STEPS);
        let path = || Path::new(system, H, start, until).expect("the run goes on");
        let (kept, again) = (
            path(),
            Path::within(system, H, start, until, 0).expect("the same"),
        );
        let of_all: Vec<Variable> = (S::PARAMETERS.iter())
            .map(|quantity| Variable::Parameter(&quantity.name))
            .chain((0..2).flat_map(|i| [Variable::Position(i), Variable::Velocity(i)]))
            .collect();
        let of_end = |path: &Path<'_, 2>| {
            black_box(path.gradient_at_end(&mut |end| end.q[0]).expect("a gradient"));
        };
        let mut of_nodes =
            |_: usize, node: &Point<Dual<f64>, 2>| node.q[0] * node.q[0] + node.v[1] * node.v[1];
        let (_, ratios) = self.ratios(&mut [
            &mut || _ = black_box(Flow::new(system, H, start).expect("a start").to(until)),
            &mut || _ = black_box(path()),
            &mut || _ = black_box(kept.tangents(&[Variable::Parameter(parameter)])),
            &mut || _ = black_box(kept.tangents(&of_all)),
            &mut || of_end(&kept),
            &mut || _ = black_box(kept.gradient(&mut of_nodes)),
            &mut || of_end(&again),
        ]);
        let [_, keeping, one, all, end, sum, again] = ratios[..] else {
            return;
        };
        println!(
            "{name:<16} over a plain run: kept {keeping:.2}; one tangent {one:.2}, {} tangents {all:.2}; with the run, gradient at the end \
             {:.2}, over all nodes {:.2}, at the end by checkpoints {:.2}",
            of_all.len(),
            keeping + end,
            keeping + sum,
            keeping + again,
        );
    }
}

/// The instruction sets of this machine, the narrowest first.
fn available() -> impl DoubleEndedIterator<Item = Instructions> {
    { Instructions::ALL }
        .into_iter()
        .filter(|these| these.are_available())
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// The starts of all runs.
fn starts(start: &dyn Fn(f64) -> Start<2>) -> Vec<Start<2>> {
    (0..RUNS).map(|k| start(f64::from(k) / f64::from(RUNS))).collect()
}

fn main() {
    let given = |argument: &str| std::env::args().any(|given| given == argument);
    let rounds = Rounds(match (given("--test"), given("--quick")) {
        (true, _) => 1,
        (false, true) => 15,
        (false, false) => 45,
    });
    let (circle, pendulum) = (CurvedParticle::default(), InertiaWheelPendulum::default());
    let wavy = CurvedParticle {
        mass: 1.0,
        curvature: Wavy::default(),
    };
    let particle = |part: f64| Start::second_order([0.0, 0.0], [1.0 + 0.1 * part, 1.0 - 0.1 * part]);
    let swing = |part: f64| Start::second_order([0.5, 0.0], [0.1 * part, 0.5 - 0.1 * part]);
    println!("many runs in lanes, one thread where nothing is said:");
    rounds.steps("particle, a step", &circle, &particle);
    rounds.steps("particle_field, a step", &wavy, &particle);
    rounds.steps("pendulum, a step", &pendulum, &swing);
    for relative in [1e-6, 1e-9, 1e-12] {
        rounds.series("particle", &circle, (relative, 100.0), &particle);
        rounds.series("pendulum", &pendulum, (relative, 40.0), &swing);
    }
    println!("derivatives of {STEPS} steps, one thread:");
    rounds.derivatives("particle", &circle, particle(0.0), "mass");
    rounds.derivatives("particle_field", &wavy, particle(0.0), "mass");
    rounds.derivatives("pendulum", &pendulum, swing(0.0), "rho");
}
