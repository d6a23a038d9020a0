//! Distribution of work over threads.

use std::sync::{Mutex, PoisonError};

/// The threads of an ensemble: by default, rayon's global pool.
#[derive(Clone, Debug, Default)]
pub(crate) struct Threads {
    /// Whether all work is done in the calling thread.
    #[cfg(feature = "rayon")]
    here: bool,
    /// A separate pool.
    #[cfg(feature = "rayon")]
    pool: Option<std::sync::Arc<Pool>>,
}

/// A pool, and the process that started its threads. A forked process has a copy of the pool, but not the
/// threads.
#[cfg(feature = "rayon")]
#[derive(Debug)]
struct Pool {
    /// The pool.
    pool: rayon::ThreadPool,
    /// The identifier of the process.
    process: u32,
}

impl Threads {
    /// The calling thread only.
    pub fn here() -> Self {
        Self {
            #[cfg(feature = "rayon")]
            here: true,
            #[cfg(feature = "rayon")]
            pool: None,
        }
    }

    /// A separate pool of `count` threads; 0 means the number of cores.
    #[cfg(feature = "rayon")]
    pub fn new(count: usize) -> Result<Self, rayon::ThreadPoolBuildError> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build()?;
        let process = std::process::id();
        Ok(Self {
            here: false,
            pool: Some(std::sync::Arc::new(Pool { pool, process })),
        })
    }

    /// The number of threads.
    #[cfg(feature = "rayon")]
    pub fn count(&self) -> usize {
        match &self.pool {
            _ if self.here => 1,
            Some(own) => own.pool.current_num_threads(),
            None => rayon::current_num_threads(),
        }
    }

    /// The number of threads.
    #[cfg(not(feature = "rayon"))]
    #[allow(clippy::unused_self)] // as with threads
    pub fn count(&self) -> usize {
        1
    }

    /// Splits a list into chunks of `size`, calls a function for each chunk with the index of its first
    /// entry, and concatenates the results in order.
    pub fn gather<T: Sync, R: Send>(
        &self,
        list: &[T],
        size: usize,
        work: &(dyn Fn(usize, &[T]) -> Vec<R> + Sync),
    ) -> Vec<R> {
        let parts: Vec<&[T]> = list.chunks(size).collect();
        let done: Vec<Mutex<Vec<R>>> = parts.iter().map(|_| Mutex::default()).collect();
        self.each(parts.len(), &|number| {
            let results = work(number * size, parts[number]);
            *done[number].lock().unwrap_or_else(PoisonError::into_inner) = results;
        });
        let results = done.into_iter();
        results
            .flat_map(|part| part.into_inner().unwrap_or_else(PoisonError::into_inner))
            .collect()
    }

    /// Calls a function for each number below `count`. It takes a trait object, so rayon's code is compiled
    /// once, not for every system.
    #[cfg(feature = "rayon")]
    fn each(&self, count: usize, work: &(dyn Fn(usize) + Sync)) {
        use rayon::prelude::*;

        let all = || (0..count).into_par_iter().for_each(work);
        match &self.pool {
            _ if self.here => (0..count).for_each(work),
            Some(own) if own.process == std::process::id() => own.pool.install(all),
            None if has_threads() => all(),
            // a forked process lacks the threads of these pools and would wait for ever, so it starts its own
            _ => match rayon::ThreadPoolBuilder::new().num_threads(self.count()).build() {
                Ok(pool) => pool.install(all),
                Err(_) => (0..count).for_each(work),
            },
        }
    }

    /// Calls a function for each number below `count`.
    #[cfg(not(feature = "rayon"))]
    #[allow(clippy::unused_self)] // as with threads
    fn each(&self, count: usize, work: &(dyn Fn(usize) + Sync)) {
        (0..count).for_each(work);
    }
}

/// Whether this process has the threads of rayon's global pool: not if it was forked from the process in
/// which they run.
#[cfg(feature = "rayon")]
fn has_threads() -> bool {
    use std::sync::atomic::{AtomicU32, Ordering};

    /// The process that used the pool first.
    static OWNER: AtomicU32 = AtomicU32::new(0);

    let process = std::process::id();
    let first = OWNER.compare_exchange(0, process, Ordering::Relaxed, Ordering::Relaxed);
    // a worker thread of a pool exists in this process
    first.map_or_else(|owner| owner == process, |_| true) || rayon::current_thread_index().is_some()
}
