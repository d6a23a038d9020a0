//! Interruption by a signal: a run that is interrupted completes its files with the rows it has.

use std::sync::Once;
use std::sync::atomic::{AtomicBool, Ordering};

/// Whether a signal came.
static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// The handler is set once in a process.
static HANDLER_SET: Once = Once::new();

/// Watches for SIGINT, SIGTERM and SIGHUP (Ctrl-C elsewhere) from now on. The first one sets the flag that is
/// returned; a second one ends the process.
///
/// Where no handler can be set, signals end the process at once, and the flag is never set.
pub fn stop_flag() -> &'static AtomicBool {
    HANDLER_SET.call_once(|| {
        let handler = || {
            if INTERRUPTED.swap(true, Ordering::Relaxed) {
                std::process::exit(130);
            }
        };
        if let Err(error) = ctrlc::set_handler(handler) {
            crate::cli::output::terminal::tell(format_args!(
                "note: an interrupted run will leave no file: {error}"
            ));
        }
    });
    &INTERRUPTED
}
