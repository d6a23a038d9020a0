//! heyoka, the Taylor integrator that is compiled when it runs (F. Biscani and D. Izzo), through its Python package: `with_heyoka.py`.

use std::cell::RefCell;
use std::rc::Rc;

use crate::candidate::{Candidate, tolerances};
use crate::problem::{Equations, INTERVAL, intervals};
use crate::process::Process;

/// The name in the report.
const NAME: &str = "heyoka";

/// The process for a problem, or the reason why there is none.
fn begin<P: Equations<D>, const D: usize>(problem: &P) -> Result<Process, String> {
    let equations = problem
        .equations()
        .ok_or_else(|| format!("{} is not written for it", P::NAME))?;
    let mut arguments = vec![
        INTERVAL.to_string(),
        intervals(P::END).to_string(),
        P::MEASURED.to_string(),
    ];
    arguments.extend(problem.start().map(|y| format!("{y:e}")));
    arguments.extend(equations);
    Process::begin("with_heyoka.py", "heyoka", &arguments)
}

/// Its integrator, over a range of tolerances. The time to compile it is not counted.
pub fn taylor<P: Equations<D>, const D: usize>(problem: P) -> Vec<Candidate> {
    let process = match begin(&problem) {
        Ok(process) => Rc::new(RefCell::new(process)),
        Err(reason) => {
            println!("{}: without heyoka: {reason}", P::NAME);
            return Vec::new();
        }
    };
    tolerances(1, 15)
        .map(|tolerance| {
            let (solve, clock) = (Rc::clone(&process), Rc::clone(&process));
            // the first question compiles
            process.borrow_mut().ask(&format!("values {tolerance:e}"));
            Candidate {
                clock: Some(Box::new(move |solutions| {
                    let question = format!("time {tolerance:e} {solutions}");
                    match clock.borrow_mut().ask(&question).as_deref() {
                        Some([seconds]) => *seconds,
                        _ => f64::NAN,
                    }
                })),
                ..Candidate::tolerance(NAME, tolerance, move |out| {
                    let values = solve.borrow_mut().ask(&format!("values {tolerance:e}"));
                    values.is_some_and(|values| {
                        out.extend(values);
                        true
                    })
                })
            }
        })
        .collect()
}
