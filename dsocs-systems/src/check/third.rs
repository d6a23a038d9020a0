//! The checks of a system with constraints of third order: those that need neither a map of pairs of nodes
//! nor a Taylor series.

use dsocs_core::geometry::{Triple, discrete_power, rows_of_four_written, rows_of_written};
use dsocs_core::{AnyPoint, Declaration, Kernel, OwnedLeg, Regularity};

use super::order::{above, fitted};
use super::probe::{Passed, State, certified, less, passed_nodes};
use super::{Expected, Finding, Found, Measured, Report, Settings, excuse, larger, reached, smallest};
use crate::entry::CheckFailure;
use crate::stability::Bar;

/// The largest residual of a row at the written nodes, relative to the rounding of its terms.
const WRITTEN: f64 = 2.0;

/// The largest distance of nodes on the way back, in legs.
const REVERSED: f64 = 1e-9;

/// The number of steps, each half of the one before.
const HALVINGS: usize = 6;

/// A change below this part of the motion's extent may be rounding.
const PLATEAU: f64 = 1e-10;

/// The largest deficit of the fitted order against the declared one.
const APART: f64 = 0.1;

/// A motion of third order, with its expected properties.
struct Subject<'a> {
    system: &'a dyn Kernel,
    h: f64,
    until: f64,
    start: State,
    expected: Expected,
}

/// Checks a system on the motion from a position, a velocity and an acceleration, to the end `own` unless the
/// settings give another.
///
/// # Errors
///
/// [`CheckFailure`] if the motion cannot be computed.
pub fn check_to(
    system: &dyn Kernel,
    expected: Expected,
    settings: &Settings<'_>,
    own: f64,
) -> Result<Vec<Finding>, CheckFailure> {
    let start = State::of(settings);
    let subject = Subject {
        system,
        h: settings.h,
        until: settings.until.unwrap_or(start.t + own),
        start,
        expected,
    };
    let (nodes, regularity, hard) =
        certified(system, subject.h, &subject.start.third_order()?, subject.until)?;
    let mut found = Found::new(excuse(hard, 0, nodes.len().saturating_sub(1)));
    found.of("window", |report| window(&subject, &nodes, report));
    found.of("regularity", |report| {
        certificates(["D₄", "D₁"], &regularity, report);
    });
    found.of("equations", |report| equations(&subject, &nodes, report));
    found.of("power balance", |report| balance(&subject, report));
    found.of("reversibility", |report| reversibility(&subject, &nodes, report));
    found.of("order", |report| order(&subject, report));
    Ok(found.findings)
}

/// The time that the motion reaches.
fn window(subject: &Subject<'_>, nodes: &[Passed], report: &mut Report) {
    let left_out = "with a constraint of third order the flow is one of triples of nodes: what needs a map of pairs (the symplectic and the momentum law) \
         or a Taylor series (contact) is not looked at, and the order is fitted to the changes from one step to the half";
    reached(
        [subject.start.t, subject.until, subject.h],
        nodes,
        left_out,
        report,
    );
}

/// The conditions of the flow along the motion, with the names of the derivatives by the last and by the first node.
pub(super) fn certificates([last, first]: [&str; 2], regularity: &[Regularity], report: &mut Report) {
    let count = |lost: fn(&Regularity) -> bool| Ok(regularity.iter().filter(|at| lost(at)).count() as f64);
    let smallest = |value: fn(&Regularity) -> f64| smallest(regularity.iter().map(value));
    report.push(
        format!(
            "of {} steps, those where {last} is not injective",
            regularity.len()
        ),
        Bar::AtMost(0.0),
        count(|at| !at.grants_forward()),
    );
    report.push(
        format!("steps where {first} is not injective"),
        Bar::AtMost(0.0),
        count(|at| !at.grants_backward()),
    );
    report.push(
        format!("smallest singular value of {last}"),
        Bar::Reported,
        smallest(|at| at.forward),
    );
    report.push(
        format!("smallest singular value of {first}"),
        Bar::Reported,
        smallest(|at| at.backward),
    );
}

/// The equations at the nodes as they are written: all of them from the fourth on, and those of lower order at the first three.
fn equations(subject: &Subject<'_>, nodes: &[Passed], report: &mut Report) {
    let kernel = subject.system;
    let most = |rows: Vec<[f64; 2]>| {
        rows.iter().fold(0.0, |most, &[row, explained]| {
            larger(most, if row == 0.0 { 0.0 } else { row.abs() / explained })
        })
    };
    let worst = nodes.windows(4).fold(0.0, |worst, nodes| {
        let [first, second, third, fourth] = nodes else {
            return worst;
        };
        let four = [&first.q[..], &second.q, &third.q, &fourth.q];
        larger(
            worst,
            most(rows_of_four_written(kernel, third.t, subject.h, four)),
        )
    });
    report.push(
        "rows at four nodes as written, in 32 digits, over what their rounding explains",
        Bar::AtMost(WRITTEN),
        Ok(worst),
    );
    if let [first, second, third, ..] = nodes {
        let rows = rows_of_written(kernel, second.t, subject.h, [&first.q, &second.q, &third.q]);
        let rows = rows.into_iter().enumerate();
        let below = rows.filter(|(place, _)| !kernel.shape().third_order.contains(place));
        report.push(
            "the same of the rows without jerks at the first three",
            Bar::AtMost(WRITTEN),
            Ok(most(below.map(|(_, row)| row).collect())),
        );
    }
}

/// The energy at nodes against the sum of the power of the constraint force: the order of the defect.
fn balance(subject: &Subject<'_>, report: &mut Report) {
    let measured: Measured<Vec<[f64; 2]>> = (0..HALVINGS)
        .map(|halving| {
            let h = subject.h / f64::from(1_u32 << halving);
            Ok([h.abs(), missed_power(subject, h)?])
        })
        .collect();
    push_slope(
        "slope of E − Σh(⟨Q + f, v⟩ − ∂L/∂t) between nodes",
        measured,
        Bar::AtLeast(subject.expected.order - APART),
        report,
    );
}

/// The largest defect of the energy balance since the first node, relative to the energy's terms.
fn missed_power(subject: &Subject<'_>, h: f64) -> Measured {
    let kernel = subject.system;
    let declaration = Declaration::of(kernel);
    let nodes = walked(subject, h)?;
    let (mut change, mut missed, mut terms) = (0.0, 0.0, 0.0);
    let mut last: Option<(f64, f64)> = None;
    for three in nodes.windows(3) {
        let leg = OwnedLeg {
            t: three[1].t,
            q: three[1].q.clone(),
            d: less(&three[1].q, &three[0].q),
        };
        let e = less(&less(&three[2].q, &three[1].q), &leg.d);
        let point = declaration.point(h, leg.any(), &e);
        let AnyPoint { t, q, v, .. } = point.any();
        let energy = declaration.energy(t, q, v);
        let power = discrete_power(kernel, h, &Triple { leg, e });
        match last {
            Some((first, before)) => {
                change += h * (before + power) / 2.0;
                missed = larger(missed, (energy - first - change).abs());
                last = Some((first, power));
            }
            None => last = Some((energy, power)),
        }
        terms = larger(terms, energy.abs() + 2.0 * declaration.lagrangian(t, q, v).abs());
    }
    Ok(if missed == 0.0 { 0.0 } else { missed / terms })
}

/// The run back from the last node.
fn reversibility(subject: &Subject<'_>, nodes: &[Passed], report: &mut Report) {
    let measured = || -> Measured {
        let start = subject.start.third_order()?;
        let times = (subject.start.t, subject.until);
        let back = passed_nodes(subject.system, subject.h, &start, times, true)?;
        let mut worst = 0.0;
        for (found, known) in back.iter().zip(nodes.iter().rev().skip(1)) {
            let leg = known.v.iter().fold(0.0_f64, |sum, v| sum.hypot(v * subject.h));
            let apart = less(&found.q, &known.q).into_iter().fold(0.0_f64, f64::hypot);
            let extent = nodes
                .iter()
                .fold(leg, |most, node| most.max((node.v[0] * subject.h).abs()));
            worst = larger(worst, apart / extent.max(f64::MIN_POSITIVE));
        }
        Ok(worst)
    };
    let bar = if subject.expected.reversible {
        Bar::AtMost(REVERSED)
    } else {
        Bar::Reported
    };
    report.push("distance of the nodes on the way back, in legs", bar, measured());
}

/// The order, by the changes of the nodes from each step to its half.
fn order(subject: &Subject<'_>, report: &mut Report) {
    let declared = subject.expected.order;
    let measured = || -> Measured<Vec<[f64; 2]>> {
        let runs: Vec<Vec<Passed>> = (0..=HALVINGS)
            .map(|halving| walked(subject, subject.h / f64::from(1_u32 << halving)))
            .collect::<Measured<_>>()?;
        let extent = |i: usize| {
            let first = runs[0].first().map_or(0.0, |node| node.q[i]);
            runs[0]
                .iter()
                .fold(0.0, |most, node| larger(most, (node.q[i] - first).abs()))
        };
        let extents: Vec<f64> = (0..subject.start.q.len()).map(extent).collect();
        let pairs = runs.windows(2).enumerate().map(|(halving, pair)| {
            let parts = 1_usize << halving;
            let mut change = 0.0;
            for (k, coarse) in runs[0].iter().enumerate() {
                let (Some(one), Some(half)) = (pair[0].get(k * parts), pair[1].get(2 * k * parts)) else {
                    continue;
                };
                let apart = (0..extents.len()).filter(|&i| extents[i] > 0.0);
                let apart = apart.map(|i| (one.q[i] - half.q[i]).abs() / extents[i]);
                change = apart.fold(change, larger);
                debug_assert!((one.t - coarse.t).abs() <= subject.h.abs());
            }
            [(subject.h / parts as f64).abs(), change]
        });
        Ok(pairs.collect())
    };
    let bar = Bar::AtLeast(declared - APART);
    push_slope(
        "slope of the changes of position from step to step",
        measured(),
        bar,
        report,
    );
}

/// The nodes of the motion with a step.
fn walked(subject: &Subject<'_>, h: f64) -> Measured<Vec<Passed>> {
    let times = (subject.start.t, subject.until);
    passed_nodes(subject.system, h, &subject.start.third_order()?, times, false)
}

/// Fits a slope to the values above rounding.
pub(super) fn push_slope(what: &str, measured: Measured<Vec<[f64; 2]>>, bar: Bar, report: &mut Report) {
    let points = match measured {
        Ok(points) => points,
        Err(error) => {
            report.push(what, Bar::Reported, Err(error));
            return;
        }
    };
    let fit = above(PLATEAU, points);
    let Some(points @ [[first, _], .., [least, _]]) = fit.as_deref() else {
        report.push(what, Bar::Reported, Ok(0.0));
        report.note("what is measured is rounding: no order is fitted");
        return;
    };
    report.push(
        format!("{what}, h = {first:.1e} to {least:.1e}"),
        bar,
        Ok(fitted(points)),
    );
}
