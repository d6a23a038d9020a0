//! `MuJoCo` (Todorov, Erez and Tassa) on a chain of rigid bodies, through its Python package: `with_mujoco.py`.

use std::cell::RefCell;
use std::rc::Rc;

use crate::bodies::{Bodies, HALF, MOMENTS};
use crate::candidate::Candidate;
use crate::problem::{INTERVAL, Problem as _, intervals};
use crate::process::Process;

/// Its integrators, with their names in the report. The implicit one takes five times as long as Euler's and
/// is no more accurate.
const METHODS: [(&str, &str); 2] = [("RK4", "MuJoCo RK4"), ("Euler", "MuJoCo Euler")];

/// Numbers of steps in an interval of the grid.
const PARTS: [u32; 12] = [1, 2, 3, 5, 10, 20, 50, 100, 200, 500, 1000, 2000];

/// The process, or the reason why there is none.
fn begin() -> Result<Process, String> {
    let mut arguments = vec![
        INTERVAL.to_string(),
        intervals(Bodies::END).to_string(),
        HALF.to_string(),
    ];
    arguments.extend(MOMENTS.map(|moment| moment.to_string()));
    arguments.extend(
        Bodies::attitudes()
            .as_flattened()
            .iter()
            .map(|q| format!("{q:e}")),
    );
    Process::begin("with_mujoco.py", "mujoco", &arguments)
}

/// Its integrators, for several numbers of steps.
pub fn all() -> Vec<Vec<Candidate>> {
    let process = match begin() {
        Ok(process) => Rc::new(RefCell::new(process)),
        Err(reason) => {
            println!("{}: without MuJoCo: {reason}", Bodies::NAME);
            return Vec::new();
        }
    };
    let of = |(method, solver): (&'static str, &'static str)| {
        let with = |parts: u32| {
            let (solve, clock) = (Rc::clone(&process), Rc::clone(&process));
            Candidate {
                solver,
                setting: format!("h {:e}", INTERVAL / f64::from(parts)),
                run: Box::new(move |out| {
                    let values = solve.borrow_mut().ask(&format!("values {method} {parts}"));
                    values.is_some_and(|values| {
                        out.extend(values);
                        true
                    })
                }),
                clock: Some(Box::new(move |solutions| {
                    let question = format!("time {method} {parts} {solutions}");
                    match clock.borrow_mut().ask(&question).as_deref() {
                        Some([seconds]) => *seconds,
                        _ => f64::NAN,
                    }
                })),
            }
        };
        PARTS.into_iter().map(with).collect()
    };
    METHODS.into_iter().map(of).collect()
}
