//! heyoka, the Taylor integrator that is compiled when it runs (F. Biscani and D. Izzo), through its Python package: `with_heyoka.py`.

use std::cell::RefCell;
use std::io::{BufRead as _, BufReader, Write as _};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::rc::Rc;

use crate::candidate::{Candidate, tolerances};
use crate::problem::{INTERVAL, Problem, intervals};

/// The name in the report.
const NAME: &str = "heyoka";

/// The process that integrates.
struct Process {
    child: Child,
    questions: ChildStdin,
    answers: BufReader<ChildStdout>,
}

impl Process {
    /// Begins with a problem, or says why not.
    fn begin<P: Problem<D>, const D: usize>(problem: &P) -> Result<Self, String> {
        let equations = problem
            .equations()
            .ok_or_else(|| format!("{} is not written for it", P::NAME))?;
        let path = concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/benches/work_precision/with_heyoka.py"
        );
        let mut child = Command::new("python3")
            .arg(path)
            .args([
                INTERVAL.to_string(),
                intervals(P::END).to_string(),
                P::MEASURED.to_string(),
            ])
            .args(problem.start().map(|y| format!("{y:e}")))
            .args(equations)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(|error| format!("python3: {error}"))?;
        let (Some(questions), Some(answers)) = (child.stdin.take(), child.stdout.take()) else {
            return Err("no pipes to python3".to_owned());
        };
        let mut process = Self {
            child,
            questions,
            answers: BufReader::new(answers),
        };
        match process.ask("version").as_deref() {
            Some([_]) => Ok(process),
            _ => Err("`pip install heyoka` is needed".to_owned()),
        }
    }

    /// The numbers of an answer.
    fn ask(&mut self, question: &str) -> Option<Vec<f64>> {
        writeln!(self.questions, "{question}").ok()?;
        self.questions.flush().ok()?;
        let mut answer = String::new();
        self.answers.read_line(&mut answer).ok()?;
        answer.split_whitespace().map(|word| word.parse().ok()).collect()
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        // it has nothing to lose
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Its integrator to tolerances. The time to compile it is not counted.
pub fn taylor<P: Problem<D>, const D: usize>(problem: P) -> Vec<Candidate> {
    let process = match Process::begin(&problem) {
        Ok(process) => Rc::new(RefCell::new(process)),
        Err(reason) => {
            println!("{}: without heyoka: {reason}", P::NAME);
            return Vec::new();
        }
    };
    tolerances(1, 15)
        .map(|tolerance| {
            let (solve, clock) = (Rc::clone(&process), Rc::clone(&process));
            // the first one compiles
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
