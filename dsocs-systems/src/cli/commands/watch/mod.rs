//! `watch`: runs a text file at every save, and shows the page in a browser that reloads it.

mod server;

use std::fs;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::thread;
use std::time::{Duration, Instant, SystemTime};

use clap::Args;
use dsocs_core::text::TextError;

use self::server::Server;
use crate::cli::arguments::file;
use crate::cli::commands::run::{RunArguments, run};
use crate::cli::output::interrupt;
use crate::cli::page::{self, Page};
use crate::cli::{CliError, Program};

/// The arguments of `watch`.
#[derive(Args, Debug)]
pub struct WatchArguments {
    /// The run, with the options of `run`
    #[command(flatten)]
    run: RunArguments,
    /// The port of this machine at which the page is shown [default: one that is free]
    #[arg(long, default_value_t = 0, hide_default_value = true)]
    port: u16,
}

/// The interval at which the files are checked.
const CHECK_INTERVAL: Duration = Duration::from_millis(50);

/// The time of the last change of a file, and its length; `None` if there is no file.
type Stamp = Option<(SystemTime, u64)>;

/// Runs a text file at every save.
///
/// # Errors
///
/// [`CliError`] if there is no text file to watch or no port to show it at, or if a run is interrupted. Mistakes in the text are shown.
pub fn watch(arguments: &WatchArguments, program: &mut Program) -> Result<(), CliError> {
    let name = arguments.run.system().unwrap_or_default();
    let Some(text) = file::path(name) else {
        return Err(CliError::NoFile(name.to_owned()));
    };
    let folder = tempfile::tempdir().map_err(|cause| CliError::Write {
        path: std::env::temp_dir(),
        cause,
    })?;
    let (run_arguments, page) = arguments.run.clone().with_page(folder.path().join("page.html"));
    let waiting = Page::new(name, "The first run is on its way.").finish();
    let server = Server::start(arguments.port, &waiting).map_err(CliError::Port)?;
    let mut out = io::stdout();
    writeln!(out, "http://{}", server.address())
        .and_then(|()| out.flush())
        .map_err(CliError::stdout)?;

    let entries = program.entries.len();
    let interrupted = interrupt::stop_flag();
    let mut files = vec![text.clone()];
    let (mut shown, mut last) = (None, None);
    let mut good = None;
    while !interrupted.load(Ordering::Relaxed) {
        let now = Some(stamps(&files));
        // a file is read when two checks in a row see the same stamp: it may still be being written
        if now == shown || now != last {
            last = now;
            thread::sleep(CHECK_INTERVAL);
            continue;
        }
        let begun = Instant::now();
        program.drop_entries_from(entries);
        let found = program.find(name).map(|entry| {
            let named = entry.files().map(|named| path_of_file(&text, named));
            core::iter::once(text.clone()).chain(named).collect()
        });
        let needed = match &found {
            Ok(needed) => needed,
            Err(error) => &with_missing(&files, &text, error),
        };
        // files that are newly needed may have changed since they were read
        if *needed != files {
            files.clone_from(needed);
            last = None;
            continue;
        }
        shown = now;
        let result = found.and_then(|_| run(&run_arguments, program));
        let html = match &result {
            Ok(()) | Err(CliError::Partial { .. }) => fs::read_to_string(&page).ok(),
            Err(_) => None,
        };
        match result {
            Ok(()) => {
                crate::cli::output::terminal::tell(format_args!(
                    "{name}: {:.2} s",
                    begun.elapsed().as_secs_f64()
                ));
                server.show(html.as_deref().unwrap_or_default());
            }
            Err(error @ CliError::Interrupted { .. }) => return Err(error),
            Err(error) => {
                crate::cli::output::terminal::tell(format_args!("error: {}", error.plain()));
                let (below, remark) = match (&html, &good) {
                    (Some(partial), _) => (Some(partial), "Below is what was computed before."),
                    (None, Some(good)) => (Some(good), "Below is the last page before this error."),
                    (None, None) => (None, ""),
                };
                server.show(&page_with_error(name, &error.plain(), below, remark));
            }
        }
        good = html.or(good);
    }
    Ok(())
}

/// The path of a file that the text names.
fn path_of_file(text: &Path, named: impl AsRef<Path>) -> PathBuf {
    text.parent().unwrap_or(Path::new("")).join(named)
}

/// The files, with one whose absence keeps the text from being read.
fn with_missing(files: &[PathBuf], text: &Path, error: &CliError) -> Vec<PathBuf> {
    let missing = match error {
        CliError::Text(TextError::Mistakes { files, .. }) => files.as_slice(),
        _ => &[],
    };
    let missing = missing.iter().map(|file| path_of_file(text, file));
    let missing = missing.filter(|missing| !files.contains(missing));
    files.iter().cloned().chain(missing).collect()
}

/// The stamps of the files.
fn stamps(files: &[PathBuf]) -> Vec<Stamp> {
    let stamp = |file: &PathBuf| {
        let metadata = fs::metadata(file).ok()?;
        Some((metadata.modified().ok()?, metadata.len()))
    };
    files.iter().map(stamp).collect()
}

/// A page that begins with an error, above the page `below` if there is one.
fn page_with_error(name: &str, error: &str, below: Option<&String>, remark: &str) -> String {
    let error = format!("error: {error}");
    if let Some(below) = below {
        return page::with_error(below, &error, remark);
    }
    let mut page = Page::new(name, "No run yet: the next save is run again.");
    page.preformatted(&error);
    page.finish()
}
