//! Many runs by methods without lanes: one after the other on each core.

use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use dsocs_core::text::TapeKernel;
use dsocs_core::{AnyStart, Kernel, OwnedNode, RunError};
use dsocs_systems::entry::Method;

use crate::motion::AnyRun;

/// The number of nodes between two checks whether to stop.
const NODES_PER_CHECK: u32 = 256;

/// The last node of a run, or its error.
pub type End = Result<OwnedNode, RunError>;

/// Many runs.
pub struct ManyRuns<'m> {
    /// The system.
    pub kernel: &'m TapeKernel,
    /// The step, or the distance of the nodes.
    pub h: f64,
    /// The method.
    pub method: Method,
    /// The starts.
    pub starts: &'m [AnyStart],
    /// The parameters that vary.
    pub varied: &'m [(&'m str, &'m [f64])],
    /// The end.
    pub t: f64,
    /// Set to stop early.
    pub stop: &'m AtomicBool,
    /// The number of runs that have ended.
    pub finished: &'m AtomicUsize,
}

impl ManyRuns<'_> {
    /// Runs all of them on this many threads, by default one for each core.
    pub fn ends(&self, threads: Option<usize>) -> Vec<End> {
        let cores = || std::thread::available_parallelism().map_or(1, NonZeroUsize::get);
        let threads = threads.unwrap_or_else(cores).clamp(1, self.starts.len().max(1));
        let next = AtomicUsize::new(0);
        let ends: Vec<Mutex<Option<End>>> = self.starts.iter().map(|_| Mutex::default()).collect();
        let work = || {
            let mut kernel = self.kernel.clone();
            loop {
                let place = next.fetch_add(1, Ordering::Relaxed);
                let Some(end) = ends.get(place) else { return };
                let found = self.end(&mut kernel, place);
                *end.lock().unwrap_or_else(PoisonError::into_inner) = Some(found);
                self.finished.fetch_add(1, Ordering::Relaxed);
            }
        };
        std::thread::scope(|scope| {
            for _ in 1..threads {
                scope.spawn(work);
            }
            work();
        });
        let ends = ends.into_iter();
        ends.filter_map(|end| end.into_inner().unwrap_or_else(PoisonError::into_inner))
            .collect()
    }

    /// The end of one run.
    fn end(&self, kernel: &mut TapeKernel, place: usize) -> End {
        for (name, values) in self.varied {
            let known: &dyn Kernel = kernel;
            let parameters = &known.shape().parameters;
            let parameter = parameters.iter().position(|known| known.name == **name);
            if let (Some(parameter), Some(value)) = (parameter, values.get(place))
                && let Some(parameter) = kernel.parameter_mut(parameter)
            {
                *parameter = *value;
            }
        }
        let mut run = AnyRun::begin(kernel, self.h, self.method, &self.starts[place])?;
        let run = run.run_mut();
        let end = run.clock().until(self.t)?;
        let mut goes = true;
        while goes && !self.stop.load(Ordering::Relaxed) {
            for _ in 0..NODES_PER_CHECK {
                goes = goes && run.go_on(&end)?;
            }
        }
        let mut node = OwnedNode::new(0);
        node.take(run);
        Ok(node)
    }
}
