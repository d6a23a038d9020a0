//! The Rust side of the Python package's bench of overheads, `dsocs-systems/python/bench/overheads.py`, which
//! calls it. It answers questions on standard input, each with two times in seconds: the wall-clock time, and
//! the processor time. The two differ on Linux only.
//!
//! ```text
//! kept FILE STEPS            a run of so many steps whose nodes are kept in columns
//! end FILE STEPS             a run of so many steps of which the last node is kept
//! controlled FILE STEPS      a run whose nodes are kept, with `torque = -2 v` set at each of them
//! ensemble FILE RUNS T N     so many runs in lanes up to the time T on N threads, with starts and lengths of their own
//! ```
//!
//! The file is the text of a system whose first run has a start and a step.

use std::error::Error;
use std::hint::black_box;
use std::io::{BufRead, Write, stdin, stdout};
use std::ops::ControlFlow;
use std::time::Instant;

use dsocs_core::text::{Run, Text};
use dsocs_core::{AnyEnsemble, AnyFlow, AnyNode, AnyStart, OwnedNode};

type Answer<T> = Result<T, Box<dyn Error>>;

/// The start and the step of a text's first run.
fn begin(text: &Text) -> Answer<(&[f64], &[f64], f64)> {
    let run: &Run = text.runs.first().ok_or("the text has no run")?;
    let [q0, v0] = run.start.as_ref().ok_or("the run has no start")?;
    Ok((q0, v0, run.step.ok_or("the run has no step")?))
}

/// The times at which something began.
struct Begun {
    /// The wall-clock time.
    time: Instant,
    /// The processor time of this thread, and of all threads of the process, in s.
    worked: [Option<f64>; 2],
}

impl Begun {
    /// The times now.
    fn now() -> Self {
        Self {
            worked: Self::worked(),
            time: Instant::now(),
        }
    }

    /// The processor time of this thread, to nanoseconds, and of the process, to hundredths of a second.
    fn worked() -> [Option<f64>; 2] {
        // the kernel brings the time of a thread that is running up to date where that of its process is read; without it the
        // time of the last tick is found, which is up to some milliseconds old
        let process = std::fs::read_to_string("/proc/self/stat").ok().and_then(|text| {
            let numbers = text.rsplit(')').next()?.split_whitespace().skip(11).take(2);
            let ticks: Vec<f64> = numbers.filter_map(|word| word.parse().ok()).collect();
            Some(ticks.iter().sum::<f64>() / 100.0)
        });
        let thread = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
        let thread =
            thread.and_then(|text| Some(1e-9 * text.split_whitespace().next()?.parse::<f64>().ok()?));
        [thread, process]
    }

    /// The wall-clock time since then, and the processor time of this thread, or of all threads if there are
    /// several.
    fn took(&self, threads: usize) -> [f64; 2] {
        let took = self.time.elapsed().as_secs_f64();
        let place = usize::from(threads > 1);
        let worked = Self::worked()[place].zip(self.worked[place]);
        [took, worked.map_or(took, |(now, then)| now - then)]
    }
}

/// The times of a run of this many steps.
fn steps(text: &Text, steps: f64, kept: bool, controlled: bool) -> Answer<[f64; 2]> {
    let (q0, v0, h) = begin(text)?;
    let begun = Begun::now();
    let mut flow = AnyFlow::new(&text.system, h, &AnyStart::second_order(q0, v0))?;
    if kept {
        let mut columns: [Vec<f64>; 6] = Default::default();
        for (column, width) in columns
            .iter_mut()
            .zip([1, q0.len(), q0.len(), q0.len(), q0.len(), 1])
        {
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a number of steps
            column.reserve((steps as usize + 1) * width);
        }
        let mut owned = OwnedNode::new(q0.len());
        flow.run_mut().walk(steps * h, &mut |run| {
            owned.take(run);
            let AnyNode {
                t,
                q,
                v,
                a,
                force,
                energy,
                ..
            } = owned.any();
            for (column, row) in columns.iter_mut().zip([&[t], q, v, a, force, &[energy]]) {
                column.extend_from_slice(row);
            }
            if controlled {
                run.set_input("torque", -2.0 * v[0])?;
            }
            Ok(ControlFlow::Continue(()))
        })?;
        black_box(&columns);
    } else {
        flow.run_mut().to(steps * h)?;
        let mut owned = OwnedNode::new(q0.len());
        owned.take(flow.run());
        black_box(&owned);
    }
    Ok(begun.took(1))
}

/// The times of many runs with different first coordinates and values of the parameter `length`.
fn ensemble(text: &Text, runs: u32, until: f64, threads: usize) -> Answer<[f64; 2]> {
    let (q0, v0, h) = begin(text)?;
    let part = |k: u32| f64::from(k) / f64::from(runs - 1);
    let begun = Begun::now();
    let ends = AnyEnsemble::of_tape(&text.system, h)?
        .starts((0..runs).map(|k| {
            let mut q = q0.to_vec();
            q[0] = 3.0 * part(k);
            AnyStart::second_order(&q, v0)
        }))
        .varied("length", (0..runs).map(|k| 1.0 + part(k)))?
        .threads(threads)?
        .to(until);
    let (mut q, mut v) = (Vec::new(), Vec::new());
    for end in &ends {
        let node = end.as_ref().map_err(ToString::to_string)?.any();
        q.extend_from_slice(node.q);
        v.extend_from_slice(node.v);
    }
    black_box((q, v));
    Ok(begun.took(threads))
}

/// The answer to a question.
fn answer(question: &str) -> Answer<[f64; 2]> {
    let words: Vec<&str> = question.split_whitespace().collect();
    let text = |file: &str| Text::read(file);
    Ok(match words[..] {
        ["kept", file, count] => steps(&text(file)?, count.parse()?, true, false)?,
        ["controlled", file, count] => steps(&text(file)?, count.parse()?, true, true)?,
        ["end", file, count] => steps(&text(file)?, count.parse()?, false, false)?,
        ["ensemble", file, runs, until, threads] => {
            ensemble(&text(file)?, runs.parse()?, until.parse()?, threads.parse()?)?
        }
        _ => return Err(format!("`{question}` is no question").into()),
    })
}

fn main() -> Answer<()> {
    for question in stdin().lock().lines() {
        let [took, worked] = answer(&question?)?;
        println!("{took} {worked}");
        stdout().flush()?;
    }
    Ok(())
}
