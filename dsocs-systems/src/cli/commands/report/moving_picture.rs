//! Pictures of bodies in space on the page, at some moments of the default motion.

use std::ops::ControlFlow;

use crate::check::Begin;
use crate::cli::CliError;
use crate::cli::page::Page;
use crate::cli::page::motion::MotionPage;
use crate::entry::{Beginning, Entry, Method, Plan, columns};

/// The start of a system in the checks: projected onto the constraints where the system asks for it.
pub fn checked_start(entry: &Entry) -> Begin {
    Begin {
        projected: entry.projects(),
        ..Begin::default()
    }
}

/// Shows a system whose bodies turn in space; others have no picture.
///
/// # Errors
///
/// [`CliError`] if the motion cannot be computed.
pub fn picture(page: &mut Page, entry: &mut Entry) -> Result<(), CliError> {
    let Some([q0, v0]) = entry.default_start().cloned() else {
        return Ok(());
    };
    if entry.description().rotations.is_empty() {
        return Ok(());
    }
    let mut beginning = Beginning::SecondOrder { q0, v0 };
    if entry.projects() {
        beginning = Beginning::Projected(Box::new(beginning));
    }
    let h = entry.default_step();
    let plan = Plan {
        h,
        until: entry.until_with(h),
        method: Method::Step,
        certify: false,
        estimate: false,
        inputs: Vec::new(),
    };
    let draw = entry.drawing();
    let mut motion = MotionPage::new(&columns(entry.description(), &plan), entry.description(), draw);
    let mut values = Vec::new();
    entry.run(&plan, &beginning, &mut |row| {
        row.write(&mut values);
        motion.push(row.node.index, &values);
        ControlFlow::Continue(())
    })?;
    let title = format!("{}: {}", entry.name(), entry.summary());
    if let Some(svg) = motion.picture(&title) {
        // at most as wide as a narrow page
        let svg = svg.replacen("<svg ", "<svg style=\"max-width:100%;height:auto\" ", 1);
        page.add(format!(
            "<figure>{svg}<figcaption>{} at some moments of its run to t = {} s</figcaption></figure>",
            entry.name(),
            plan.until
        ));
    }
    Ok(())
}
