//! `sweep`: many runs by a plan, here or as a task of a scheduler.

pub mod map;

use std::fs;
use std::io::Write;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use clap::Args;

use crate::cli::arguments::file;
use crate::cli::output::{interrupt, progress};
use crate::cli::{CliError, Program};
use crate::sweep::{Options, Plan, Shard, Status, Sweep, SweepError, status};

/// The arguments of `sweep`.
#[derive(Args, Debug)]
pub struct SweepArguments {
    /// The plan, a .toml file; not needed with `--status`
    #[arg(required_unless_present = "status")]
    plan: Option<PathBuf>,
    /// The folder of the sweep; finished parts in it are not computed again
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Report what is missing, and compute nothing; the exit status is 1 if something is missing
    #[arg(long)]
    status: bool,
    /// Compute the I-th of N shares of the parts, 1/N to N/N [default: from the environment of the scheduler (SLURM, PBS, LSF, Grid Engine,
    /// AWS Batch, Kubernetes, Open MPI, PMI), else all parts]
    #[arg(long, value_name = "I/N", conflicts_with = "shards")]
    shard: Option<String>,
    /// The number of tasks, if the scheduler does not give it to its tasks (PBS, Kubernetes)
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    shards: Option<u64>,
    /// The number of threads [default: one for each core; in a shard `SLURM_CPUS_PER_TASK`, or 1]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    threads: Option<u16>,
}

/// Computes a sweep, or reports its missing parts.
///
/// # Errors
///
/// [`CliError`] if the plan is none, the folder holds another sweep, or a part cannot be written.
pub fn sweep(arguments: &SweepArguments, program: &Program) -> Result<(), CliError> {
    let out = &arguments.out;
    if arguments.status {
        return tell(&status(out)?);
    }
    let path = arguments.plan.clone().unwrap_or_default();
    let text = fs::read_to_string(&path).map_err(|cause| CliError::Read {
        path: path.clone(),
        cause: cause.to_string(),
    })?;
    let plan = Plan::read(&text)?;
    let sweep = match file::system_of_plan(plan.system.as_deref(), &path, out, &program.constants)? {
        Some(entry) => Sweep::new(&Plan { system: None, ..plan }, [&entry])?,
        None => Sweep::new(&plan, &program.entries)?,
    };
    let shard = shard(arguments)?;
    let threads = arguments.threads.map_or_else(|| threads(&shard), usize::from);

    let done = AtomicU64::new(0);
    let bar = progress::counted(sweep.open_points(out, &shard), sweep.system());
    let begun = Instant::now();
    let over = AtomicBool::new(false);
    let stop = interrupt::stop_flag();
    let report = thread::scope(|scope| {
        if !bar.is_hidden() {
            scope.spawn(|| {
                while !over.load(Ordering::Relaxed) {
                    bar.set_position(done.load(Ordering::Relaxed));
                    thread::sleep(Duration::from_millis(100));
                }
            });
        }
        let options = Options {
            shard: shard.clone(),
            threads,
            done: Some(&done),
            stop: Some(stop),
        };
        let report = sweep.run(out, &options);
        over.store(true, Ordering::Relaxed);
        report
    });
    bar.finish_and_clear();
    let report = report?;
    crate::cli::output::terminal::tell(format_args!(
        "{} point{} of {}, {} failed, in {:.1} s on {threads} thread{}; {} of {} parts missing{}",
        report.points,
        plural(report.points),
        sweep.points(),
        report.failed,
        begun.elapsed().as_secs_f64(),
        plural(threads as u64),
        report.missing,
        report.parts,
        if shard.count() > 1 {
            format!(" (this was shard {shard})")
        } else {
            String::new()
        },
    ));
    if report.stopped && report.missing > 0 {
        return Err(CliError::Stopped {
            missing: report.missing,
            parts: report.parts,
        });
    }
    Ok(())
}

/// The share of this process.
fn shard(arguments: &SweepArguments) -> Result<Shard, CliError> {
    if let Some(given) = &arguments.shard {
        return Ok(given.parse::<Shard>()?);
    }
    let found = Shard::of_environment(&|name| std::env::var(name).ok(), arguments.shards)?;
    match found {
        Some(shard) => {
            crate::cli::output::terminal::tell(format_args!("note: shard {shard}, by {}", shard.origin().join(" and ")));
            Ok(shard)
        }
        None if arguments.shards.is_some_and(|count| count > 1) => Err(SweepError::Shard(
            "`--shards` says how many tasks a scheduler's array has, and no scheduler says which one this is: give `--shard i/n`".to_owned(),
        )
        .into()),
        None => Ok(Shard::WHOLE),
    }
}

/// The number of threads for a share.
fn threads(shard: &Shard) -> usize {
    if shard.count() == 1 && shard.origin().is_empty() {
        return thread::available_parallelism().map_or(1, usize::from);
    }
    let own = std::env::var("SLURM_CPUS_PER_TASK");
    own.ok().and_then(|text| text.parse().ok()).unwrap_or(1)
}

/// Reports the missing parts.
fn tell(status: &Status) -> Result<(), CliError> {
    let missing = &status.missing;
    let shown: Vec<String> = missing.iter().take(SHOWN).map(u64::to_string).collect();
    let which = match (missing.len(), shown.join(", ")) {
        (0, _) => String::new(),
        (1, one) => format!(" (part {one})"),
        (2..=SHOWN, all) => format!(" (parts {all})"),
        (_, first) => format!(" (parts {first}, …)"),
    };
    let mut lines = vec![
        format!("{} points in {} parts", status.points, status.parts),
        format!("missing: {}{which}", missing.len()),
    ];
    let failed = status.failed.iter();
    lines.extend(failed.map(|(error, count)| format!("failed: {count} point{} ({error})", plural(*count))));
    writeln!(std::io::stdout(), "{}", lines.join("\n")).map_err(CliError::stdout)?;
    if missing.is_empty() {
        Ok(())
    } else {
        Err(CliError::Missing {
            missing: missing.len() as u64,
            parts: status.parts,
        })
    }
}

/// The largest number of missing parts that are named.
const SHOWN: usize = 20;

/// The ending of a plural.
fn plural(count: u64) -> &'static str {
    if count == 1 { "" } else { "s" }
}
