//! A plan together with its system, and the computation of all of its parts.

use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::thread;

use dsocs_core::Samples;
use serde_json::{Value, json};
use twox_hash::XxHash3_128;

use super::error::SweepError;
use super::folder::Folder;
use super::plan::Plan;
use super::setting::Setting;
use super::shard::Shard;
use super::worker::{Worker, add};
use crate::entry::{Entry, UnknownName};

/// The version of the format of folder and manifest.
const FORMAT: u64 = 1;

/// A plan together with its system.
#[derive(Debug)]
pub struct Sweep {
    /// The system.
    entry: Entry,
    /// The settings that all points share.
    setting: Setting,
    /// Everything that the content depends on.
    manifest: Value,
    /// The system as a text, which stands in every table.
    text: Option<String>,
}

/// The options of a computation. They do not change the results.
#[derive(Debug)]
pub struct Options<'o> {
    /// The share of the parts that is computed.
    pub shard: Shard,
    /// The number of threads, at least one.
    pub threads: usize,
    /// A counter to which each finished point is added.
    pub done: Option<&'o AtomicU64>,
    /// A flag that stops the sweep when it is true. Parts that are not finished are given up.
    pub stop: Option<&'o AtomicBool>,
}

impl Default for Options<'_> {
    /// All parts, on one thread.
    fn default() -> Self {
        Self {
            shard: Shard::WHOLE,
            threads: 1,
            done: None,
            stop: None,
        }
    }
}

/// The result of a computation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Report {
    /// The parts of the sweep.
    pub parts: u64,
    /// Parts that were computed.
    pub computed: u64,
    /// Parts of the sweep that are still missing; other processes may be computing them.
    pub missing: u64,
    /// Points that were computed.
    pub points: u64,
    /// The number of these points whose run failed.
    pub failed: u64,
    /// Whether it was stopped before its end.
    pub stopped: bool,
}

impl Sweep {
    /// Prepares the sweep of a plan: finds its system among the entries, and checks all names.
    ///
    /// # Errors
    ///
    /// [`SweepError`] that says what is wrong in the plan. For an unknown name it proposes the nearest known one.
    pub fn new<'e>(plan: &Plan, entries: impl IntoIterator<Item = &'e Entry>) -> Result<Self, SweepError> {
        let entries: Vec<&Entry> = entries.into_iter().collect();
        let known = || entries.iter().map(|entry| entry.name().to_owned());
        let mut entry = match (&plan.system, &entries[..]) {
            (Some(name), _) => match entries.iter().find(|entry| entry.name() == name) {
                Some(entry) => entry.copy(),
                None => {
                    return Err(SweepError::unknown(
                        "system",
                        UnknownName::new("system", name, known()),
                    ));
                }
            },
            (None, [entry]) => entry.copy(),
            (None, _) => {
                return Err(SweepError::TableKind {
                    known: known().collect(),
                });
            }
        };
        // the text before the plan sets parameters; `None` if the system cannot be written as a text
        let text = entry.text().ok();
        let samples: Value = entry
            .samples()
            .map(|(name, samples)| (name.to_owned(), Value::from(digest(samples))))
            .collect();
        let (setting, manifest_of_plan) = Setting::new(plan, &mut entry)?;
        let columns = |place: usize| -> Vec<&str> {
            let columns = setting.columns[place].iter();
            columns.map(|(name, _)| name.as_str()).collect()
        };
        let mut manifest = json!({
            "format": FORMAT,
            "version": env!("CARGO_PKG_VERSION"),
            "numeric_mode": numeric_mode(),
            "points": setting.points.count(),
            "parts": setting.parts(),
            "tables": setting.tables().iter().map(|which| which.name()).collect::<Vec<_>>(),
            "columns": columns(0),
            "node_columns": if setting.nodes.is_some() { columns(1) } else { Vec::new() },
            "plan": manifest_of_plan,
            "text": text,
            "samples": samples,
        });
        let hash = XxHash3_128::oneshot(manifest.to_string().as_bytes());
        manifest["hash"] = format!("{hash:032x}").into();
        Ok(Self {
            entry,
            setting,
            manifest,
            text,
        })
    }

    /// The number of points.
    #[must_use]
    pub fn points(&self) -> u64 {
        self.setting.points.count()
    }

    /// The number of parts.
    #[must_use]
    pub fn parts(&self) -> u64 {
        self.setting.parts()
    }

    /// The system's name.
    #[must_use]
    pub fn system(&self) -> &str {
        self.entry.name()
    }

    /// The number of points of a shard that are missing in the folder.
    #[must_use]
    pub fn open_points(&self, folder: &Path, shard: &Shard) -> u64 {
        let open = self.open(&Folder::new(folder), shard);
        let setting = &self.setting;
        open.iter()
            .map(|&part| setting.points_of(part).count() as u64)
            .sum()
    }

    /// Computes the parts of a shard that are missing in the folder. A folder that does not exist is created.
    ///
    /// # Errors
    ///
    /// [`SweepError::Another`] if the folder holds another sweep, [`SweepError::Write`] if a part cannot be written. Parts that were
    /// finished before stay complete.
    pub fn run(&self, folder: &Path, options: &Options<'_>) -> Result<Report, SweepError> {
        let folder = Folder::new(folder);
        self.claim(&folder)?;
        let setting = &self.setting;
        let tables = setting.tables();
        let open = self.open(&folder, &options.shard);
        let (next, failed) = (AtomicUsize::new(0), Mutex::new(None));
        let stopped = || options.stop.is_some_and(|stop| stop.load(Ordering::Relaxed));
        let broken = AtomicBool::new(false);
        let end = || stopped() || broken.load(Ordering::Relaxed);
        let work = |mut worker: Worker<'_>| {
            let mut report = Report::default();
            while let Some(&part) = open.get(next.fetch_add(1, Ordering::Relaxed)) {
                if end() {
                    break;
                }
                // another process may have been faster
                if folder.has(tables, part) {
                    add(options.done, setting.points_of(part).count() as u64);
                    continue;
                }
                match worker.part(&folder, part, setting.points_of(part), &end, options.done) {
                    Ok(Some(count)) => {
                        report.computed += 1;
                        report.points += setting.points_of(part).count() as u64;
                        report.failed += count;
                    }
                    Ok(None) => break,
                    Err(error) => {
                        broken.store(true, Ordering::Relaxed);
                        // the first error is reported
                        if let Ok(mut failed) = failed.lock() {
                            failed.get_or_insert(error);
                        }
                        break;
                    }
                }
            }
            report
        };
        let threads = options.threads.clamp(1, open.len().max(1));
        let workers: Vec<_> = (0..threads)
            .map(|_| Worker::new(self.entry.copy(), setting, self.text.as_deref()))
            .collect();
        let mut report = Report::default();
        thread::scope(|scope| {
            let work = &work;
            let handles: Vec<_> = workers
                .into_iter()
                .map(|worker| scope.spawn(move || work(worker)))
                .collect();
            for handle in handles {
                match handle.join() {
                    Ok(own) => {
                        report.computed += own.computed;
                        report.points += own.points;
                        report.failed += own.failed;
                    }
                    Err(panic) => {
                        let message = panic.downcast_ref::<&str>().map(ToString::to_string);
                        let message = message.or_else(|| panic.downcast_ref::<String>().cloned());
                        let error = SweepError::Panicked(message.unwrap_or_default());
                        if let Ok(mut failed) = failed.lock() {
                            failed.get_or_insert(error);
                        }
                    }
                }
            }
        });
        if let Ok(Some(error)) = failed.into_inner() {
            return Err(error);
        }
        report.parts = self.parts();
        report.missing = (0..self.parts())
            .filter(|&part| !folder.has(tables, part))
            .count() as u64;
        report.stopped = stopped();
        if report.missing == 0 {
            folder.tidy(tables);
        }
        Ok(report)
    }

    /// Writes the manifest of this sweep into the folder, or checks that it is there already.
    fn claim(&self, folder: &Folder) -> Result<(), SweepError> {
        if folder.manifest()?.is_none() {
            folder.create(&self.manifest, self.setting.tables())?;
        }
        match folder.manifest()? {
            Some(there) if there == self.manifest => Ok(()),
            Some(there) => Err(SweepError::Another {
                folder: folder.path().to_owned(),
                difference: difference("", &there, &self.manifest)
                    .unwrap_or_else(|| "its manifest is written otherwise".to_owned()),
            }),
            None => Err(SweepError::NoSweep(folder.path().to_owned())),
        }
    }

    /// The parts of a shard that are missing.
    fn open(&self, folder: &Folder, shard: &Shard) -> Vec<u64> {
        (0..self.parts())
            .filter(|&part| shard.has(part) && !folder.has(self.setting.tables(), part))
            .collect()
    }
}

/// A hash of the places and values of samples.
fn digest(samples: &Samples) -> String {
    let places = samples.places().iter();
    let bits = places
        .flat_map(|&place| [place, samples.at(place)])
        .flat_map(f64::to_le_bytes);
    format!("{:032x}", XxHash3_128::oneshot(&bits.collect::<Vec<u8>>()))
}

/// The parts of the environment that the last digits of the results depend on: the kind of processor and the
/// C library, since glibc chooses its functions by the instructions that the processor has.
fn numeric_mode() -> String {
    let library = if cfg!(target_env = "musl") {
        "musl"
    } else if cfg!(target_env = "gnu") {
        "gnu"
    } else if cfg!(target_env = "msvc") {
        "msvc"
    } else {
        "system"
    };
    let mode = format!("{}-{}-{library}", std::env::consts::ARCH, std::env::consts::OS);
    #[cfg(all(target_arch = "x86_64", target_env = "gnu"))]
    let mode = {
        let has = |has: bool, name: &'static str| if has { name } else { "" };
        mode + has(std::arch::is_x86_feature_detected!("avx2"), "+avx2")
            + has(std::arch::is_x86_feature_detected!("fma"), "+fma")
    };
    mode
}

/// The first place where two manifests differ. Their hashes always differ and are left out.
fn difference(at: &str, there: &Value, here: &Value) -> Option<String> {
    match (there, here) {
        (Value::Object(there), Value::Object(here)) => {
            let keys = there
                .keys()
                .chain(here.keys().filter(|key| !there.contains_key(*key)));
            // differences of the plan come before those that follow from it
            let last = |key: &&String| !["plan", "version", "numeric_mode"].contains(&key.as_str());
            let (first, rest): (Vec<_>, Vec<_>) = keys
                .filter(|key| *key != "hash")
                .partition(|key| !at.is_empty() || !last(key));
            first.into_iter().chain(rest).find_map(|key| {
                let at = if at.is_empty() {
                    key.clone()
                } else {
                    format!("{at}.{key}")
                };
                let none = Value::Null;
                difference(
                    &at,
                    there.get(key).unwrap_or(&none),
                    here.get(key).unwrap_or(&none),
                )
            })
        }
        (there, here) if there == here => None,
        // the text of a system: its first line that differs
        (Value::String(there), Value::String(here)) if there.contains('\n') && here.contains('\n') => {
            let (mut there, mut here) = (there.lines(), here.lines());
            (1..).find_map(|line| {
                let (there, here) = (there.next(), here.next());
                (there != here || there.is_none()).then(|| {
                    let [there, here] = [there, here]
                        .map(|line| line.map_or("missing".to_owned(), |line| format!("`{line}`")));
                    format!("line {line} of {at} is {there} there and {here} here")
                })
            })
        }
        (there, here) => Some(format!("{at} is {there} there and {here} here")),
    }
}
