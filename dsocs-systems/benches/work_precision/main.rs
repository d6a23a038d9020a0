//! Speed against error: the methods of this library and other codes on the same problems with the same
//! output.
//!
//! `cargo bench --bench work_precision` measures this library, the crate `ode_solvers` and RK4 by hand on the
//! two systems of the paper; with `-- --all` on all eight problems. With the feature `peers` two more crates
//! are measured, and with `-- --with-heyoka` heyoka, where Python has it; `-- --with-mujoco` adds `MuJoCo`
//! for the chain of rigid bodies. Names of problems (`-- sphere contact`) measure these alone; `-- --quick`
//! measures less. It prints tables and writes `target/report/work_precision.csv` and a picture of each
//! problem beside it.

#![allow(missing_docs)] // a bench is no library

mod bodies;
mod candidate;
mod constrained;
#[cfg(feature = "peers")]
mod differential_equations_peer;
#[cfg(feature = "peers")]
mod diffsol_peer;
mod dsocs;
mod heyoka;
mod measure;
mod mujoco;
mod ode_solvers_peer;
mod problem;
mod process;
mod report;
mod runge_kutta;
mod turning;

use std::error::Error;
use std::path::PathBuf;
use std::time::Duration;

use dsocs_core::taylor::{TaylorFlow, Tolerance};
use dsocs_core::{RunError, Start, Stepper, System};

use bodies::Bodies;
use candidate::Candidate;
use constrained::{Contact, Sphere};
use measure::{Chosen, Effort, Point, Reference, choose, measure};
use problem::{Called, Chain, Declared, Equations, Particle, ParticleField, Pendulum, Problem, grid};
use turning::Top;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let given = |option: &str| arguments.iter().any(|argument| argument == option);
    if !given("--bench") {
        return Ok(()); // run as a test, there is nothing to do
    }
    let quick = given("--quick");
    let names = arguments.iter().filter(|argument| !argument.starts_with("--"));
    let mut wanted: Vec<String> = names.cloned().collect();
    if wanted.is_empty() && !given("--all") {
        wanted = [Particle::NAME, Pendulum::NAME].map(str::to_owned).to_vec();
    }
    let mut bench = Bench {
        effort: Effort {
            longest: Duration::from_millis(if quick { 50 } else { 600 }),
            sample: Duration::from_millis(if quick { 3 } else { 15 }),
            rounds: 11,
            every: if quick { 2 } else { 1 },
        },
        wanted,
        with_heyoka: given("--with-heyoka"),
        with_mujoco: given("--with-mujoco"),
        points: Vec::new(),
    };
    println!("{}", report::conditions());
    if bench.wants(Particle::NAME) {
        let exact: Vec<f64> = grid(Particle::END)
            .into_iter()
            .map(|t| Called(Particle).system().exact([0.0, 0.0], [1.0, 1.0], t).0[0])
            .collect();
        let reference = Reference {
            independent: exact.clone(),
            ours: exact,
        };
        let mut chosen = bench.chosen(Particle, &reference);
        chosen.extend(bench.called(Called(Particle), &reference));
        bench.measure(Particle::NAME, &chosen);
    }
    if bench.wants(ParticleField::NAME) {
        let reference = references(ParticleField);
        let mut chosen = bench.chosen(ParticleField, &reference);
        chosen.extend(bench.called(Called(ParticleField), &reference));
        bench.measure(ParticleField::NAME, &chosen);
    }
    bench.compare(Pendulum::default());
    bench.compare(Chain);
    bench.compare(Sphere);
    bench.compare(Contact);
    bench.compare(Top);
    bench.bodies();

    let points = bench.points;
    for problem in report::problems(&points) {
        println!("{}", report::table(problem, &points));
    }
    println!("{}", report::ratios(&points));
    println!("{}", report::spread(&points));
    let directory = target().join("report");
    report::write(&directory, &points)?;
    println!("{} points in {}", points.len(), directory.display());
    Ok(())
}

/// The measurements.
struct Bench {
    /// The limits of the measuring time.
    effort: Effort,
    /// The names of the problems that were asked for; empty for all.
    wanted: Vec<String>,
    /// Whether heyoka is measured.
    with_heyoka: bool,
    /// Whether `MuJoCo` is measured.
    with_mujoco: bool,
    /// The measurements so far.
    points: Vec<Point>,
}

impl Bench {
    /// Whether a problem was asked for.
    fn wants(&self, problem: &str) -> bool {
        self.wanted.is_empty() || self.wanted.iter().any(|wanted| wanted == problem)
    }

    /// Measures all solvers on a problem, if it was asked for.
    fn compare<P, const N: usize, const D: usize>(&mut self, problem: P)
    where
        P: Equations<D> + Declared<N>,
        P::System: System<N> + 'static,
    {
        if self.wants(P::NAME) {
            let chosen = self.chosen(problem, &references(problem));
            self.measure(P::NAME, &chosen);
        }
    }

    /// Measures this library on the chain of rigid bodies, and `MuJoCo`.
    fn bodies(&mut self) {
        if !self.wants(Bodies::NAME) {
            return;
        }
        // no other code is as accurate; the extrapolated step shares no code with the series
        let reference = Reference {
            independent: dsocs::extrapolated(Bodies, &[400, 800, 1600]),
            ours: by_series(Bodies),
        };
        println!(
            "{}: the references differ by {:.1e}",
            Bodies::NAME,
            reference.difference()
        );
        let mut chosen = choose(self.effort, &reference, dsocs::taylor(dsocs::TAYLOR, Bodies));
        chosen.extend(choose(
            self.effort,
            &reference,
            dsocs::order2(Bodies, &dsocs::PARTS[3..]),
        ));
        if self.with_mujoco {
            for method in mujoco::all() {
                chosen.extend(choose(self.effort, &reference, method.into_iter()));
            }
        }
        self.measure(Bodies::NAME, &chosen);
    }

    /// Measures candidates in turn.
    fn measure(&mut self, problem: &'static str, chosen: &[Chosen]) {
        eprintln!("{problem}: {} settings of solvers in turn", chosen.len());
        self.points.extend(measure(self.effort, problem, chosen));
    }

    /// All solvers on one problem.
    fn chosen<P, const N: usize, const D: usize>(&self, problem: P, reference: &Reference) -> Vec<Chosen>
    where
        P: Equations<D> + Declared<N>,
        P::System: System<N> + 'static,
    {
        println!(
            "{}: the references differ by {:.1e}",
            P::NAME,
            reference.difference()
        );
        let mut chosen = Vec::new();
        let mut take = |candidates: Box<dyn Iterator<Item = Candidate>>| {
            chosen.extend(choose(self.effort, reference, candidates));
        };
        take(Box::new(dsocs::taylor(dsocs::TAYLOR, problem)));
        take(Box::new(dsocs::order2(problem, &dsocs::PARTS)));
        for method in dsocs::composed(problem) {
            take(method);
        }
        take(Box::new(ode_solvers_peer::dop853(problem)));
        take(Box::new(ode_solvers_peer::dopri5(problem)));
        #[cfg(feature = "peers")]
        {
            take(Box::new(differential_equations_peer::dop853(problem)));
            take(Box::new(differential_equations_peer::rkv98(problem)));
            take(Box::new(diffsol_peer::tsit45(problem)));
            take(Box::new(diffsol_peer::bdf(problem)));
        }
        if self.with_heyoka {
            take(Box::new(heyoka::taylor(problem).into_iter()));
        }
        take(Box::new(runge_kutta::rk4(problem)));
        chosen
    }

    /// The Taylor flow where the generated code calls a user's function.
    fn called<P, const N: usize, const D: usize>(&self, problem: P, reference: &Reference) -> Vec<Chosen>
    where
        P: Equations<D> + Declared<N>,
        P::System: System<N> + 'static,
    {
        choose(
            self.effort,
            reference,
            dsocs::taylor(dsocs::TAYLOR_CALLED, problem),
        )
    }
}

/// The solution by Taylor series, and by the method of Dormand and Prince at its smallest tolerance.
fn references<P, const N: usize, const D: usize>(problem: P) -> Reference
where
    P: Equations<D> + Declared<N>,
    P::System: System<N> + 'static,
{
    Reference {
        independent: ode_solvers_peer::reference(problem).unwrap_or_default(),
        ours: by_series(problem),
    }
}

/// The solution by this library's Taylor series.
fn by_series<P, const N: usize>(problem: P) -> Vec<f64>
where
    P: Problem + Declared<N>,
    P::System: System<N> + 'static,
{
    let system = problem.system();
    let (q, v) = problem.begin();
    let mut ours = Vec::new();
    // a low order has less rounding
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
    ours
}

/// The directory for what is built.
fn target() -> PathBuf {
    match std::env::var_os("CARGO_TARGET_DIR") {
        Some(target) => PathBuf::from(target),
        None => PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../target"),
    }
}
