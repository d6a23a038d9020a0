//! The report of `dsocs paper` on the terminal.

use std::path::Path;
use std::time::Duration;

use comfy_table::{Cell, CellAlignment, Table, presets};

use super::{CliError, Results};
use crate::cli::output::terminal;
use crate::experiment::{ErrorRow, StartRule, slope, slope_between};
use crate::figure::Format;
use crate::pendulum::InertiaWheelPendulum;

/// Prints the tables of errors and the places of the files.
///
/// # Errors
///
/// [`CliError::Stdout`] if standard output cannot be written.
pub fn print(
    results: &Results,
    folder: &Path,
    figures: &[&str],
    [computed, total]: [Duration; 2],
) -> Result<(), CliError> {
    let reference = &results.reference;
    let end = reference.states.len() - 1;
    let value = reference
        .lyapunov(&InertiaWheelPendulum::default(), end)
        .unwrap_or(f64::NAN);
    let files = format!(
        "Figures ({}) in {}: {}.\nEvery number behind them: {}.\n{:.2} s for the numbers, {:.2} s in all.\n",
        if Format::WRITTEN.contains(&Format::Png) {
            "SVG and PNG"
        } else {
            "SVG; with `--features png` also PNG"
        },
        folder.display(),
        figures.join(", "),
        folder.join("summary.json").display(),
        computed.as_secs_f64(),
        total.as_secs_f64(),
    );
    let text = format!("{}\n{files}", tables(results, value));
    terminal::print(text.as_bytes())
}

/// The tables of errors, and the Lyapunov function at the end of the continuous and the discrete motion.
fn tables(results: &Results, reference: f64) -> String {
    let discrete = results.pendulum.last().map_or(f64::NAN, |moment| moment.lyapunov);
    format!(
        "Particle with curvature 1 over [0, 500], against the exact solution\n{}\n\n\
         Inertia wheel pendulum over [0, 2000], against the continuous motion\n{}\n{}\n\n\
         V(2000) of the continuous pendulum: {reference:.9} J\n\
         V(2000) of the discrete pendulum (h = 0.1, paper start): {discrete:.9} J\n",
        errors(&results.particle_errors, &[], "max |x error| [m]"),
        errors(
            &results.pendulum_errors,
            &results.pendulum_further,
            "max |θ error| [rad]"
        ),
        slope_explanation(&[&results.pendulum_errors[..], &results.pendulum_further].concat()),
    )
}

/// An explanation of the slope that the paper found for the pendulum.
fn slope_explanation(rows: &[ErrorRow]) -> String {
    let over = |most: f64, least: f64| slope_between(rows, StartRule::Paper, [least, most]);
    let last = rows.iter().fold(f64::INFINITY, |last, row| last.min(row.h));
    format!(
        "The paper's slope of 1.3 is that of its start, q1 = q0 + h v0, whose error is of first order. Large steps do not show\n\
         it yet, so the slope depends on the steps: {:.2} over h = 0.1 … 0.00625, {:.2} over 0.1 … 0.0016, {:.2} over 0.05 … 0.003,\n\
         and {:.2} over the last halving. The scheme itself is of second order, as the other start shows.",
        over(0.1, 0.00625),
        over(0.1, 0.0015),
        over(0.05, 0.003),
        over(2.0 * last, last),
    )
}

/// A table of errors with the local slopes, and the slopes of the lines in the figure, which shows the first rows alone.
fn errors(figured: &[ErrorRow], further: &[ErrorRow], quantity: &str) -> Table {
    let rows = [figured, further].concat();

    let mut table = terminal::table(presets::UTF8_FULL_CONDENSED);
    let head = |start: StartRule| [format!("{}\n{quantity}", start.name()), "local\nslope".to_owned()];
    table.set_header(std::iter::once("h [s]".to_owned()).chain(StartRule::ALL.into_iter().flat_map(head)));
    let of = |start| rows.iter().filter(move |row| row.start == start);
    let mut steps: Vec<f64> = of(StartRule::Paper).map(|row| row.h).collect();
    steps.dedup();
    for (index, h) in steps.iter().enumerate() {
        let mut cells = vec![right_aligned(h.to_string())];
        for start in StartRule::ALL {
            let Some(row) = of(start).nth(index) else { continue };
            let before = index.checked_sub(1).and_then(|before| of(start).nth(before));
            let local =
                before.map(|before| (before.max_error / row.max_error).ln() / (before.h / row.h).ln());
            cells.push(right_aligned(format!("{:.7e}", row.max_error)));
            cells.push(right_aligned(
                local.map_or_else(String::new, |slope| format!("{slope:.3}")),
            ));
        }
        table.add_row(cells);
    }
    let fit = match (further.is_empty(), figured.last()) {
        (false, Some(last)) => format!("fit to {}", last.h),
        _ => "fit".to_owned(),
    };
    let mut cells = vec![right_aligned(fit)];
    for start in StartRule::ALL {
        cells.extend([
            right_aligned(String::new()),
            right_aligned(format!("{:.3}", slope(figured, start))),
        ]);
    }
    table.add_row(cells);
    table
}

/// A cell whose content stands at its right.
fn right_aligned(content: String) -> Cell {
    Cell::new(content).set_alignment(CellAlignment::Right)
}
