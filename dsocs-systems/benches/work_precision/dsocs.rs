//! The methods of this library: the paper's step, its compositions, and the Taylor flow.

use dsocs_core::taylor::{TaylorFlow, Tolerance};
use dsocs_core::{ComposedFlow, Composition, Flow, Start, Stepper, Symmetry, System};

use crate::candidate::{Candidate, tolerances};
use crate::problem::{Declared, INTERVAL, Problem, grid, intervals};

/// The Taylor flow.
pub const TAYLOR: &str = "dsocs taylor";
/// The Taylor flow where the curvature is a user's function.
pub const TAYLOR_CALLED: &str = "dsocs taylor (user's function)";

/// The Taylor flow, over a range of tolerances.
pub fn taylor<P, const N: usize>(solver: &'static str, problem: P) -> impl Iterator<Item = Candidate>
where
    P: Problem + Declared<N>,
    P::System: System<N> + 'static,
{
    tolerances(1, 16).map(move |tolerance| {
        Candidate::tolerance(solver, tolerance, move |out| {
            let system = problem.system();
            let (q, v) = problem.begin();
            let Ok(mut flow) =
                TaylorFlow::new(&system, Start::second_order(q, v), Tolerance::relative(tolerance))
            else {
                return false;
            };
            let times = grid(P::END);
            flow.sample(&times, &mut |_, point| {
                out.extend_from_slice(&point.q[..P::MEASURED]);
            })
            .is_ok()
        })
    })
}

/// Numbers of steps in an interval of the grid.
pub static PARTS: [u32; 15] = [1, 2, 4, 7, 10, 20, 50, 70, 100, 200, 500, 700, 1000, 2000, 5000];

/// The paper's step with the second-order start, for these numbers of steps in an interval.
pub fn order2<P, const N: usize>(problem: P, parts: &'static [u32]) -> impl Iterator<Item = Candidate>
where
    P: Problem + Declared<N>,
    P::System: System<N> + 'static,
{
    parts.iter().map(move |&parts| {
        let h = INTERVAL / f64::from(parts);
        Candidate {
            solver: "dsocs order 2",
            setting: format!("h {h:e}"),
            run: Box::new(move |out| {
                let system = problem.system();
                let (q, v) = problem.begin();
                let Ok(mut flow) = Flow::new(&system, h, Start::second_order(q, v)) else {
                    return false;
                };
                out.extend_from_slice(&q[..P::MEASURED]);
                for k in 0..intervals(P::END) {
                    // the start has made the first step
                    for _ in u32::from(k == 0)..parts {
                        if flow.advance().is_err() {
                            return false;
                        }
                    }
                    out.extend_from_slice(&flow.position()[..P::MEASURED]);
                }
                true
            }),
            clock: None,
        }
    })
}

/// The compositions of the step, with their names.
const COMPOSITIONS: [(Composition, &str); 3] = [
    (Composition::SUZUKI_4, "dsocs order 4"),
    (Composition::KAHAN_LI_6, "dsocs order 6"),
    (Composition::KAHAN_LI_8, "dsocs order 8"),
];

/// The compositions of the step, where it can be composed.
pub fn composed<P, const N: usize>(problem: P) -> impl Iterator<Item = Box<dyn Iterator<Item = Candidate>>>
where
    P: Problem + Declared<N>,
    P::System: System<N> + 'static,
{
    let possible = <P::System as System<N>>::SYMMETRY == Symmetry::AnyLegs;
    let methods = COMPOSITIONS.into_iter().filter(move |_| possible);
    methods.map(move |method| Box::new(steps_of(problem, method)) as Box<dyn Iterator<Item = Candidate>>)
}

/// One composition, for several numbers of steps.
fn steps_of<P, const N: usize>(
    problem: P,
    (method, solver): (Composition, &'static str),
) -> impl Iterator<Item = Candidate>
where
    P: Problem + Declared<N>,
    P::System: System<N> + 'static,
{
    [1_u32, 2, 3, 4, 6, 8, 12, 16, 24, 32, 64, 128, 256]
        .into_iter()
        .map(move |parts| {
            let h = INTERVAL / f64::from(parts);
            Candidate {
                solver,
                setting: format!("h {h:e}"),
                run: Box::new(move |out| {
                    let system = problem.system();
                    let (q, v) = problem.begin();
                    let Ok(mut flow) = ComposedFlow::new(&system, h, method, Start::second_order(q, v))
                    else {
                        return false;
                    };
                    out.extend_from_slice(&q[..P::MEASURED]);
                    for _ in 0..intervals(P::END) {
                        for _ in 0..parts {
                            if flow.advance().is_err() {
                                return false;
                            }
                        }
                        out.extend_from_slice(&flow.position()[..P::MEASURED]);
                    }
                    true
                }),
                clock: None,
            }
        })
}

/// The solution by the paper's step with three numbers of steps in an interval, each twice the one before,
/// extrapolated: in even powers of the step, the second and the fourth error cancel.
pub fn extrapolated<P, const N: usize>(problem: P, parts: &'static [u32; 3]) -> Vec<f64>
where
    P: Problem + Declared<N>,
    P::System: System<N> + 'static,
{
    let mut solutions = order2(problem, parts).map(|candidate| {
        let mut out = Vec::new();
        (candidate.run)(&mut out);
        out
    });
    let [Some(coarse), Some(half), Some(quarter)] = [(); 3].map(|()| solutions.next()) else {
        return Vec::new();
    };
    let better = |x: f64, y: f64, power: f64| y + (y - x) / (power - 1.0);
    let all = coarse.iter().zip(&half).zip(&quarter);
    all.map(|((x, y), z)| better(better(*x, *y, 4.0), better(*y, *z, 4.0), 16.0))
        .collect()
}
