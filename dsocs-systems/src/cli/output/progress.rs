//! Progress on standard error: a bar if it is a terminal, nothing if not.

use std::io::IsTerminal;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// A bar for `length` units of work.
pub fn bar(length: u64, message: &str) -> ProgressBar {
    with_template("{msg:24} {wide_bar} {percent:>3} % {eta:>4}", length, message)
}

/// A bar for `length` units of work that shows the rate per second.
#[cfg(feature = "sweep")]
pub fn counted(length: u64, message: &str) -> ProgressBar {
    with_template(
        "{msg:24} {wide_bar} {pos}/{len} {per_sec} {eta:>4}",
        length,
        message,
    )
}

/// A bar with this template.
fn with_template(template: &str, length: u64, message: &str) -> ProgressBar {
    let target = if std::io::stderr().is_terminal() {
        ProgressDrawTarget::stderr()
    } else {
        ProgressDrawTarget::hidden()
    };
    let bar = ProgressBar::with_draw_target(Some(length), target).with_message(message.to_owned());
    // the template is fixed; if a later version of the crate rejects it, the crate's own is used
    match ProgressStyle::with_template(template) {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}
