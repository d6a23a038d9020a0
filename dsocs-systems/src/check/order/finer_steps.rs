//! Parts of the step, where errors do not fall as a power of the step itself yet.

use crate::check::{Finding, Report};
use crate::stability::Bar;

/// Divisors of the step that are tried where a fit misses its bar.
pub const DIVISORS: [u32; 2] = [4, 16];

/// Further divisors, for a step that follows the motion for a small part of the window only; the window is
/// then as long as that part.
const FURTHER_DIVISORS: [u32; 5] = [64, 256, 1024, 4096, 16384];

/// Slopes of finer steps that differ by more show no power.
const SLOPE_SPREAD: f64 = 0.1;

/// One of them has to come this near to the required slope.
const NEAR_SLOPE: f64 = 0.5;

/// Measures with the step and, where a bar is missed on a motion without jumps, with parts of it: errors fall
/// as a power of the step only where it is short enough. A figure that misses its bar with all parts is
/// reported as first measured. Still smaller parts are tried where the step is too long to follow the motion.
pub fn with_finer_steps(
    (h, is_excused): (f64, bool),
    report: &mut Report,
    is_too_long: &dyn Fn() -> bool,
    measure: &dyn Fn(u32, &mut Report),
) {
    let attempt = |parts: u32| {
        let mut attempt = Report {
            check: report.check,
            findings: Vec::new(),
        };
        measure(parts, &mut attempt);
        attempt
    };
    let mut first = attempt(1);
    let holds = |attempt: &Report| attempt.findings.iter().all(Finding::holds);
    let is_open = is_excused || first.findings.iter().any(|finding| finding.failure.is_some());
    if holds(&first) || is_open {
        report.findings.extend(first.findings);
        return;
    }
    let fitted_from = |mut finer: Report, parts: u32| {
        finer.note(&format!(
            "fitted from h = {:.1e} on: with larger steps the errors do not fall as a power of the step yet",
            h.abs() / f64::from(parts)
        ));
        finer.findings
    };
    for parts in DIVISORS {
        let finer = attempt(parts);
        if holds(&finer) {
            report.findings.extend(fitted_from(finer, parts));
            return;
        }
    }
    // the slopes, and the least distance of each from its bar
    let figures = |attempt: &Report| {
        attempt
            .findings
            .iter()
            .map(|finding| finding.figure)
            .collect::<Vec<f64>>()
    };
    let missed = |finding: &Finding, figure: f64| match finding.bar {
        Bar::AtMost(bar) => figure - bar,
        Bar::AtLeast(bar) => bar - figure,
        Bar::Reported => f64::NEG_INFINITY,
    };
    let (mut before, mut range) = (figures(&first), [f64::INFINITY, f64::NEG_INFINITY]);
    let mut best: Vec<f64> = first
        .findings
        .iter()
        .map(|finding| missed(finding, finding.figure))
        .collect();
    let mut rounding = None;
    for parts in FURTHER_DIVISORS.into_iter().take_while(|_| is_too_long()) {
        let finer = attempt(parts);
        let now = figures(&finer);
        // errors at rounding have no slope, or that of the same steps as before
        let is_rounding = now.len() < first.findings.len() || now == before;
        if holds(&finer) && !is_rounding {
            report.findings.extend(fitted_from(finer, parts));
            return;
        }
        if let Some(slope) = now.first() {
            range = [range[0].min(*slope), range[1].max(*slope)];
        }
        for ((best, finding), figure) in best.iter_mut().zip(&first.findings).zip(&now) {
            *best = best.min(missed(finding, *figure));
        }
        if is_rounding && rounding.is_none() {
            rounding = Some(h.abs() / f64::from(parts));
        }
        if now.is_empty() || now == before {
            break;
        }
        before = now;
    }
    if let Some(rounding) = rounding.filter(|_| range[1] - range[0] > SLOPE_SPREAD) {
        let open = first.findings.iter_mut().zip(&best);
        for (finding, _) in open.filter(|(finding, best)| !finding.holds() && **best < NEAR_SLOPE) {
            finding.excuse = Some(format!(
                "not required here: errors fall as a power of the step where it is short enough, and the motion changes so quickly somewhere that they are rounding before: the step h = {:.1e} \
                 follows it for a small part of the window only, the slopes of finer ones lie between {:.1} and {:.1}, and with h = {rounding:.0e} errors are rounding; to see it required, start \
                 beside the place, as one where a mass nearly vanishes",
                h.abs(),
                range[0],
                range[1],
            ));
        }
    }
    report.findings.extend(first.findings);
}
