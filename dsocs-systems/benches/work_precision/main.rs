//! Speed against error: our solvers and other crates on the same problems with the same output.
//!
//! `cargo bench --bench work_precision` measures all (below 15 minutes), with `-- --quick` a part (below 2). It prints
//! tables and writes `target/report/work_precision.csv` and a picture of each problem beside it. Names of problems
//! (`-- sphere contact`) measure these alone and write nothing.

#![allow(missing_docs)] // a bench is no library

mod candidate;
mod constrained;
mod differential_equations_peer;
mod diffsol_peer;
mod dsocs;
mod measure;
mod ode_solvers_peer;
mod problem;
mod report;
mod runge_kutta;

use std::error::Error;
use std::path::PathBuf;
use std::time::Duration;

use criterion::Criterion;
use dsocs_core::taylor::{TaylorFlow, Tolerance};
use dsocs_core::{RunError, Start, Stepper, System};

use constrained::{Contact, Sphere};
use measure::{Effort, Point, Reference, sweep};
use problem::{Called, Chain, Declared, Particle, ParticleField, Pendulum, Problem, grid};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().collect();
    if !arguments.iter().any(|argument| argument == "--bench") {
        return Ok(()); // run as a test, there is nothing to do
    }
    let quick = arguments.iter().any(|argument| argument == "--quick");
    let effort = Effort {
        longest: Duration::from_millis(if quick { 50 } else { 600 }),
        measured: Duration::from_millis(if quick { 30 } else { 150 }),
        every: if quick { 2 } else { 1 },
    };
    let mut bench = Bench {
        criterion: Criterion::default().without_plots(),
        effort,
        wanted: arguments
            .into_iter()
            .skip(1)
            .filter(|argument| !argument.starts_with("--"))
            .collect(),
        points: Vec::new(),
    };
    if bench.wants(Particle::NAME) {
        let exact: Vec<f64> = grid(Particle::END)
            .into_iter()
            .map(|t| Called(Particle).system().exact([0.0, 0.0], [1.0, 1.0], t).0[0])
            .collect();
        let reference = Reference {
            independent: exact.clone(),
            ours: exact,
        };
        bench.measure(Particle, &reference);
        bench.called(Called(Particle), &reference);
    }
    if let Some(reference) = bench.compare(ParticleField) {
        bench.called(Called(ParticleField), &reference);
    }
    bench.compare(Pendulum::default());
    bench.compare(Chain);
    bench.compare(Sphere);
    bench.compare(Contact);

    let Bench { wanted, points, .. } = bench;
    println!("\nms, median of the whole solution with output every 0.1; in brackets, times our best.");
    for problem in report::problems(&points) {
        println!("{}", report::table(problem, &points));
        for (target, ratio) in report::ratios(problem, &points) {
            match ratio {
                Some(ratio) => {
                    println!("{target:.0e}: the fastest of the others takes {ratio:.2} times our best");
                }
                None => println!("{target:.0e}: not reached by both"),
            }
        }
    }
    // a part is no report
    if wanted.is_empty() {
        let directory = target().join("report");
        report::write(&directory, &points)?;
        println!("\n{} points in {}", points.len(), directory.display());
    }
    Ok(())
}

/// The measurements.
struct Bench {
    /// What measures.
    criterion: Criterion,
    /// How long it may all take.
    effort: Effort,
    /// The names of the problems that are asked for; none for all.
    wanted: Vec<String>,
    /// What was measured.
    points: Vec<Point>,
}

impl Bench {
    /// Whether a problem is asked for.
    fn wants(&self, problem: &str) -> bool {
        self.wanted.is_empty() || self.wanted.iter().any(|wanted| wanted == problem)
    }

    /// Works out the reference of a problem and measures all solvers, if it is asked for.
    fn compare<P, const N: usize, const D: usize>(&mut self, problem: P) -> Option<Reference>
    where
        P: Problem<D> + Declared<N>,
        P::System: System<N> + 'static,
    {
        if !self.wants(P::NAME) {
            return None;
        }
        let reference = references(problem);
        println!(
            "{}: the references differ by {:.1e}",
            P::NAME,
            reference.difference()
        );
        self.measure(problem, &reference);
        Some(reference)
    }

    /// All solvers on one problem.
    fn measure<P, const N: usize, const D: usize>(&mut self, problem: P, reference: &Reference)
    where
        P: Problem<D> + Declared<N>,
        P::System: System<N> + 'static,
    {
        let mut take = |candidates: Box<dyn Iterator<Item = candidate::Candidate>>| {
            let points = sweep(&mut self.criterion, self.effort, P::NAME, reference, candidates);
            self.points.extend(points);
        };
        take(Box::new(dsocs::taylor(dsocs::TAYLOR, problem)));
        take(Box::new(dsocs::order2(problem)));
        for method in dsocs::composed(problem) {
            take(method);
        }
        take(Box::new(ode_solvers_peer::dop853(problem)));
        take(Box::new(ode_solvers_peer::dopri5(problem)));
        take(Box::new(differential_equations_peer::dop853(problem)));
        take(Box::new(differential_equations_peer::rkv98(problem)));
        take(Box::new(diffsol_peer::tsit45(problem)));
        take(Box::new(diffsol_peer::bdf(problem)));
        take(Box::new(runge_kutta::rk4(problem)));
    }

    /// Our continuous flow where the generated code calls a function.
    fn called<P, const N: usize, const D: usize>(&mut self, problem: P, reference: &Reference)
    where
        P: Problem<D> + Declared<N>,
        P::System: System<N> + 'static,
    {
        let candidates = dsocs::taylor(dsocs::TAYLOR_CALLED, problem);
        let points = sweep(&mut self.criterion, self.effort, P::NAME, reference, candidates);
        self.points.extend(points);
    }
}

/// The solution by our Taylor series, and by the method of Dormand and Prince at its smallest tolerance.
fn references<P, const N: usize, const D: usize>(problem: P) -> Reference
where
    P: Problem<D> + Declared<N>,
    P::System: System<N> + 'static,
{
    let system = problem.system();
    let (q, v) = problem.begin();
    let mut ours = Vec::new();
    // a low order rounds less
    let flow = TaylorFlow::new(
        &system,
        Start::second_order(q, v),
        Tolerance::relative(1e-16).order(18),
    );
    let result = flow.map_err(RunError::from).and_then(|mut flow| {
        flow.sample(&grid(P::END), &mut |_, point| {
            ours.extend_from_slice(&point.q[..P::MEASURED]);
        })
    });
    if let Err(error) = result {
        println!("{}: no reference by Taylor series: {error}", P::NAME);
    }
    Reference {
        independent: ode_solvers_peer::reference(problem).unwrap_or_default(),
        ours,
    }
}

/// The directory for what is built.
fn target() -> PathBuf {
    match std::env::var_os("CARGO_TARGET_DIR") {
        Some(target) => PathBuf::from(target),
        None => PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../target"),
    }
}
