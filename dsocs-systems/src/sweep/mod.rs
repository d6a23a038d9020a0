//! Sweeps: many runs of one system, on one machine or on a cluster.
//!
//! A *plan* says what varies, what is kept and when a run ends. A *point* is one run. The points are computed in *parts*; each part becomes one
//! file of a folder. The content of the folder depends only on the plan. It does not depend on the number of threads, processes or
//! machines, or on how often they were stopped. So processes need not talk to each other: each one gets the plan and the folder, and
//! computes parts that are missing. The book's chapter *Many runs and clusters* ([`crate::guide::many_runs`]) has examples.
//!
//! # The plan
//!
//! ```toml
//! system = "pendulum"          # may be left out where there is one; or a text file beside the plan, "swing.dsocs"
//! step = 0.1                   # the entry's own, unless given; so are `until`, the start and the parameters
//! until = 100
//! order = 4                    # 2 (unless given), 4, 6 or 8; or `tolerance = 1e-9`: the continuous motion
//! part = 1000                  # points in a part; the 256th of all unless given
//! lanes = true                 # eight runs at once; only ends can be kept, and the last digits are not those of `dsocs run`
//!
//! [start]                      # as far as it does not vary
//! q0 = [0.5, 0]
//! v0 = [0, "pi/2"]             # wherever a number is asked for, an expression in quotes is one, too
//! t0 = 0
//! rule = "second-order"        # or "paper"
//! project = true               # move starts onto the constraints
//!
//! [set]                        # parameters
//! rho = 3
//!
//! [input]                      # parameters that are held from some times on
//! m = [[0, 38], [50, 40]]
//!
//! [vary]                       # the first varies slowest
//! theta = { from = "-pi", to = "pi", count = 101 }                          # a coordinate at the start
//! v_psi = { from = 0.01, to = 100, count = 5, scale = "logarithmic" }       # a velocity at the start
//! chi = [50, 100]                                                           # a parameter
//! "m@50" = [40, 45]                                                         # what a parameter is from a time on
//!
//! [keep]
//! end = ["t", "theta", "lyapunov"]       # columns of `dsocs run`, at the end; time, coordinates and velocities unless given
//! extremes = ["theta"]                   # the least and the greatest over all nodes
//! nodes = { every = 100, columns = ["t", "theta"] }      # nodes on the way, in a table of their own
//!
//! [[event]]                    # a change of sign that is counted: first and last time are kept
//! name = "upright"
//! quantity = "theta"           # `t`, a coordinate, a velocity, an observed expression
//! value = 0                    # what it passes
//! direction = "rising"         # or "falling", or "both"
//! ends = true                  # the run ends there
//! ```
//!
//! For random points instead of a grid, add a section `[sample]`. The ranges then have no `count`.
//!
//! ```toml
//! [sample]
//! kind = "latin-hypercube"     # or "sobol" (at most 65536 points), or "random"
//! count = 10000
//! seed = 1
//! ```
//!
//! # The folder
//!
//! | file | what |
//! |---|---|
//! | `manifest.json` | the plan with all defaults of the system filled in, the system as a text, a hash of all this, the version of this crate, the numeric mode, the columns |
//! | `points/part-000000.parquet` | a row for each point: `point`, what varies by its name, `end_…`, `least_…`, `greatest_…`, `count_…`, `first_…`, `last_…` of events, `ended_by`, `error`, `message` |
//! | `nodes/part-000000.parquet` | a row for each node that is kept: `point`, `node`, columns |
//!
//! The system as a text also stands in the metadata of every Parquet file, under the key `dsocs.text`. `dsocs text sweep/`, or [`text`], writes it. A
//! system with functions of Rust is more than a text can say, and has none.
//!
//! A run that fails has a row, too. In it, `error` is a word that says why, `message` is a sentence, and the values at the end are those of the
//! last node that was computed.
//!
//! A part is first written under a temporary name. It gets its final name when all of it is on the disk. So a part that exists is
//! complete, and is not computed again. If a process is killed, the next process computes the part that was not finished.
//!
//! A folder that holds the sweep of another plan is refused. So is a folder that was begun by another version of the program, or in another
//! *numeric mode*: the last digits of the C library's `sin`, `cos` and `exp` depend on the instructions that the processor has. A program
//! that is statically linked with musl has the same mode on all processors of the same architecture. So is a folder of
//! a system with another text, or with other samples. Where a system has no text, a sweep does not notice that it has changed if the version is the
//! same: use a new folder after such a change.
//!
//! # From a program
//!
//! ```
//! use dsocs_systems::sweep::{Options, Plan, Sweep};
//! use dsocs_systems::{Entry, PlanarPendulum};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let plan = Plan::read("until = 1\n[start]\nproject = true\n[vary]\nlength = { from = 0.5, to = 2, count = 4 }")?;
//! let entries = [Entry::new(PlanarPendulum::default()).start([0.6, -0.8], [0.0, 0.0])];
//! let sweep = Sweep::new(&plan, &entries)?;
//! let folder = tempfile::tempdir()?;
//! let report = sweep.run(folder.path(), &Options::default())?;
//! assert_eq!((report.points, report.missing, report.failed), (4, 0, 0));
//! # Ok(())
//! # }
//! ```

mod error;
mod folder;
mod plan;
mod points;
mod random;
mod read;
mod run;
mod setting;
mod shard;
mod table;
mod worker;

pub use error::SweepError;
pub use plan::{
    Keep, KeptNodes, MOST_SOBOL_POINTS, Plan, PlannedEvent, PlannedStart, Sample, SampleKind, Values,
};
pub use read::{Axis, Content, Status, status, text};
pub use run::{Options, Report, Sweep};
pub use shard::Shard;
