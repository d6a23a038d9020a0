//! Work that is shared out to threads.

use std::sync::{Mutex, PoisonError};

/// The threads of an ensemble: unless said otherwise, rayon's own.
#[derive(Clone, Debug, Default)]
pub(crate) struct Threads {
    /// Whether only the thread that asks works.
    #[cfg(feature = "rayon")]
    here: bool,
    /// A pool of its own.
    #[cfg(feature = "rayon")]
    pool: Option<std::sync::Arc<Pool>>,
}

/// A pool, and the process that has its threads: a process that is forked has a copy of the pool, and none of the threads.
#[cfg(feature = "rayon")]
#[derive(Debug)]
struct Pool {
    /// The pool.
    pool: rayon::ThreadPool,
    /// The number of the process.
    process: u32,
}

impl Threads {
    /// The thread that asks, and no other.
    pub fn here() -> Self {
        Self {
            #[cfg(feature = "rayon")]
            here: true,
            #[cfg(feature = "rayon")]
            pool: None,
        }
    }

    /// So many threads; 0 are as many as there are cores.
    #[cfg(feature = "rayon")]
    pub fn new(count: usize) -> Result<Self, rayon::ThreadPoolBuildError> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build()?;
        let process = std::process::id();
        Ok(Self {
            here: false,
            pool: Some(std::sync::Arc::new(Pool { pool, process })),
        })
    }

    /// How many there are.
    #[cfg(feature = "rayon")]
    pub fn count(&self) -> usize {
        match &self.pool {
            _ if self.here => 1,
            Some(own) => own.pool.current_num_threads(),
            None => rayon::current_num_threads(),
        }
    }

    /// How many there are.
    #[cfg(not(feature = "rayon"))]
    #[allow(clippy::unused_self)] // as with threads
    pub fn count(&self) -> usize {
        1
    }

    /// Cuts a list into parts of `size`, calls a function for every part with the place of its first entry, and puts the results one after the
    /// other.
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

    /// Calls a function for each number below `count`. What rayon makes of it is compiled once, not for every system.
    #[cfg(feature = "rayon")]
    fn each(&self, count: usize, work: &(dyn Fn(usize) + Sync)) {
        use rayon::prelude::*;

        let all = || (0..count).into_par_iter().for_each(work);
        match &self.pool {
            _ if self.here => (0..count).for_each(work),
            Some(own) if own.process == std::process::id() => own.pool.install(all),
            None if has_threads() => all(),
            // a process that was forked waits for ever for the threads that it has not: it gets others
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

/// Whether this process has the threads of the pool that all share: it has not where they worked for the process that it was forked from.
#[cfg(feature = "rayon")]
fn has_threads() -> bool {
    use std::sync::atomic::{AtomicU32, Ordering};

    /// The process in which the pool was first asked.
    static OWNER: AtomicU32 = AtomicU32::new(0);

    let process = std::process::id();
    let first = OWNER.compare_exchange(0, process, Ordering::Relaxed, Ordering::Relaxed);
    // a thread that works for a pool is there
    first.map_or_else(|owner| owner == process, |_| true) || rayon::current_thread_index().is_some()
}
