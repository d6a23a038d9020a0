//! A run in progress, which owns its system.

use std::time::{Duration, Instant};

use dsocs_core::taylor::AnyTaylorFlow;
use dsocs_core::text::TapeKernel;
use dsocs_core::{
    AnyComposedFlow, AnyFlow, AnyStart, Clock, End, Kernel, Run, RunError, SetupError, Tolerance,
};
use dsocs_systems::entry::{Beginning, Method};
use self_cell::self_cell;

use crate::record::Record;

/// The time after which a run pauses for a check for signals.
pub const CHECK_INTERVAL: Duration = Duration::from_millis(30);

/// The largest number of nodes between two readings of the clock.
const MOST_NODES_PER_READING: u64 = 4096;

/// The approximate time between two readings of the clock.
const READING_INTERVAL: Duration = Duration::from_millis(1);

/// A run by one of the methods.
pub enum AnyRun<'s> {
    /// By the paper's step.
    Step(Box<AnyFlow<'s>>),
    /// By a composition of it.
    Composed(Box<AnyComposedFlow<'s>>),
    /// By Taylor series.
    Continuous(Box<AnyTaylorFlow<'s>>),
}

impl<'s> AnyRun<'s> {
    /// Sets up a run, as the command line does.
    pub fn begin(
        system: &'s TapeKernel,
        h: f64,
        method: Method,
        start: &AnyStart,
    ) -> Result<Self, SetupError> {
        // every method refuses the steps, parameters and starts that the paper's step refuses
        let step = AnyFlow::new(system, h, start)?;
        Ok(match method {
            Method::Step => Self::Step(Box::new(step)),
            Method::Composed(composition) => {
                Self::Composed(Box::new(AnyComposedFlow::new(system, h, composition, start)?))
            }
            Method::Tolerance(tolerance) => {
                let flow = AnyTaylorFlow::of_tape(system, start, Tolerance::relative(tolerance))?;
                Self::Continuous(Box::new(flow.every(h)?))
            }
        })
    }

    /// The run.
    fn run(&self) -> &(dyn Run + 's) {
        match self {
            Self::Step(flow) => flow.run(),
            Self::Composed(flow) => flow.run(),
            Self::Continuous(flow) => &**flow,
        }
    }

    /// The run, mutable.
    pub fn run_mut(&mut self) -> &mut (dyn Run + 's) {
        match self {
            Self::Step(flow) => flow.run_mut(),
            Self::Composed(flow) => flow.run_mut(),
            Self::Continuous(flow) => &mut **flow,
        }
    }
}

self_cell!(
    /// A run and its system.
    struct Owned {
        owner: Box<TapeKernel>,
        #[not_covariant]
        dependent: AnyRun,
    }
);

/// A run in progress, with the system that it borrows.
pub struct Motion(Owned);

/// Whether one end of a run lies beyond another, in the direction of the run.
fn is_beyond(clock: &Clock, one: &End, other: &End) -> bool {
    if clock.is_forward() {
        one.time() > other.time()
    } else {
        one.time() < other.time()
    }
}

/// The result of some steps towards an end.
pub enum Reached {
    /// The end was reached.
    End,
    /// The time for this call was over before.
    OnTheWay,
}

impl Motion {
    /// Sets up a run, as the command line does.
    pub fn begin(
        system: TapeKernel,
        h: f64,
        method: Method,
        from: &Beginning,
    ) -> Result<Self, Box<SetupError>> {
        let owned = Owned::try_new(Box::new(system), |system| {
            AnyRun::begin(system, h, method, &from.start())
        });
        Ok(Self(owned.map_err(Box::new)?))
    }

    /// The system with the initial values of its parameters, as a `TapeKernel`.
    pub fn kernel(&self) -> &TapeKernel {
        self.0.borrow_owner()
    }

    /// The system, with the values that its parameters began with.
    pub fn system(&self) -> &dyn Kernel {
        &**self.0.borrow_owner()
    }

    /// Calls a function with a run by the paper's step; `None` for a run by another method.
    pub fn with_step<R>(&mut self, work: impl FnOnce(&mut AnyFlow<'_>) -> R) -> Option<R> {
        self.0.with_dependent_mut(|_, run| match run {
            AnyRun::Step(flow) => Some(work(flow)),
            _ => None,
        })
    }

    /// Whether the run knows one position more than its node, so that an input holds from there on.
    pub fn is_ahead(&self) -> bool {
        self.0.with_dependent(|_, run| matches!(run, AnyRun::Step(_)))
    }

    /// The number of coordinates.
    pub fn dimension(&self) -> usize {
        self.system().shape().dimension()
    }

    /// Calls a function that reads the run.
    pub fn look<R>(&self, look: impl FnOnce(&dyn Run) -> R) -> R {
        self.0.with_dependent(|_, run| look(run.run()))
    }

    /// Calls a function that may change the run.
    pub fn with<R>(&mut self, work: impl FnOnce(&mut dyn Run) -> R) -> R {
        self.0.with_dependent_mut(|_, run| work(run.run_mut()))
    }

    /// Makes the step to the next node, or begins with the first node. `false` at the end.
    pub fn next(&mut self, end: &End, record: &mut Record) -> Result<bool, RunError> {
        self.with(|run| {
            let goes = run.go_on(end)?;
            if goes {
                record.take(run);
            }
            Ok(goes)
        })
    }

    /// Makes steps towards an end, and pauses after [`CHECK_INTERVAL`].
    pub fn go(&mut self, end: &End, record: &mut Record) -> Result<Reached, RunError> {
        // a method with variable steps may choose them by the end of the run
        let on_a_grid = self
            .0
            .with_dependent(|_, run| !matches!(run, AnyRun::Continuous(_)));
        let leaves_out = on_a_grid && record.every() > 1;
        self.with(|run| {
            let (begun, mut looked) = (Instant::now(), Instant::now());
            let mut some: u64 = 1;
            loop {
                let mut left = some;
                while left > 0 {
                    if leaves_out {
                        left -= pass(run, end, record, left)?;
                    }
                    if !run.go_on(end)? {
                        return Ok(Reached::End);
                    }
                    record.take(run);
                    left -= 1;
                }
                let now = Instant::now();
                if now - begun > CHECK_INTERVAL {
                    return Ok(Reached::OnTheWay);
                }
                if now - looked < READING_INTERVAL {
                    some = (2 * some).min(MOST_NODES_PER_READING);
                } else {
                    some = (some / 2).max(1);
                }
                looked = now;
            }
        })
    }
}

/// Makes the steps to the node before the next one that is kept, at most `left` with the one to that node: nodes that are not kept are not stopped at.
/// Returns their number.
fn pass(run: &mut dyn Run, end: &End, record: &Record, left: u64) -> Result<u64, RunError> {
    let clock = run.clock();
    let passed = record.ahead(clock.index()).min(left) - 1;
    if passed == 0 || !clock.is_handed_out() {
        return Ok(0);
    }
    let stop = clock.until(clock.time_of(clock.index() + passed))?;
    let is_last = is_beyond(clock, &stop, end);
    run.reach(if is_last { end } else { &stop })?;
    Ok(passed)
}

/// Whether a run whose nodes lie on a grid stands at the end.
pub fn has_reached(run: &dyn Run, end: &End) -> bool {
    let clock = run.clock();
    let left = end.time() - clock.time();
    let half = 0.5 * clock.step().unwrap_or(0.0).abs();
    if clock.is_forward() {
        left < half
    } else {
        -left < half
    }
}
