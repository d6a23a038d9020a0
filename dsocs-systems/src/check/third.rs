//! The checks of a system with constraints of third order: those that need neither a map of pairs of nodes
//! nor a Taylor series.

use dsocs_core::geometry::{rows_at_four_given_nodes, rows_at_given_nodes};
use dsocs_core::{Kernel, OwnedLeg, Regularity};

use crate::check::motion::motions::{MotionNode, State, certified_nodes, less, nodes_between};
use crate::check::order::between_steps::{ORDER_DEFICIT, Step, balance, push_slope};
use crate::check::{
    CheckFindings, Expected, Finding, Measured, Report, Settings, excuse, larger, report_reached_time,
    smallest,
};
use crate::entry::CheckFailure;
use crate::stability::Bar;

/// The largest residual of a row at the written nodes, relative to the rounding of its terms.
const LARGEST_RESIDUAL: f64 = 2.0;

/// The largest distance of nodes on the way back, in legs.
const DISTANCE_BACK: f64 = 1e-9;

/// The number of steps, each half of the one before.
const HALVINGS: usize = 6;

/// A motion of third order, with its expected properties.
struct MotionOfThirdOrder<'a> {
    system: &'a dyn Kernel,
    h: f64,
    until: f64,
    start: State,
    expected: Expected,
}

/// Checks a system on the motion from a position, a velocity and an acceleration, for the time `default_duration`
/// unless the settings give an end.
///
/// # Errors
///
/// [`CheckFailure`] if the motion cannot be computed.
pub fn check_to(
    system: &dyn Kernel,
    expected: Expected,
    settings: &Settings<'_>,
    default_duration: f64,
) -> Result<Vec<Finding>, CheckFailure> {
    let start = State::of(settings);
    let motion = MotionOfThirdOrder {
        system,
        h: settings.h,
        until: settings.until.unwrap_or(start.t + default_duration),
        start,
        expected,
    };
    let (nodes, regularity, doubtful) =
        certified_nodes(system, motion.h, &motion.start.third_order()?, motion.until)?;
    let mut findings = CheckFindings::new(excuse(doubtful, 0, nodes.len().saturating_sub(1)));
    findings.carry_out("window", |report| window(&motion, &nodes, report));
    findings.carry_out("regularity", |report| {
        certificates(["D₄", "D₁"], &regularity, report);
    });
    findings.carry_out("equations", |report| equations(&motion, &nodes, report));
    findings.carry_out("power balance", |report| {
        let lengths = (0..HALVINGS).map(|halving| motion.h / f64::from(1_u32 << halving));
        let steps = |h| Ok(steps(&nodes_with_step(&motion, h)?));
        balance(motion.system, (lengths, motion.expected.order), steps, report);
    });
    findings.carry_out("reversibility", |report| reversibility(&motion, &nodes, report));
    findings.carry_out("order", |report| order(&motion, report));
    Ok(findings.findings)
}

/// The time that the motion reaches.
fn window(motion: &MotionOfThirdOrder<'_>, nodes: &[MotionNode], report: &mut Report) {
    let left_out = "with a constraint of third order the flow is one of triples of nodes: what needs a map of pairs (the symplectic and the momentum law) \
         or a Taylor series (contact) is not looked at, and the order is fitted to the changes from one step to the half";
    report_reached_time([motion.start.t, motion.until, motion.h], nodes, left_out, report);
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
fn equations(motion: &MotionOfThirdOrder<'_>, nodes: &[MotionNode], report: &mut Report) {
    let kernel = motion.system;
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
            most(rows_at_four_given_nodes(kernel, third.t, motion.h, four)),
        )
    });
    report.push(
        "rows at four nodes as written, in 32 digits, over what their rounding explains",
        Bar::AtMost(LARGEST_RESIDUAL),
        Ok(worst),
    );
    if let [first, second, third, ..] = nodes {
        let rows = rows_at_given_nodes(kernel, second.t, motion.h, [&first.q, &second.q, &third.q]);
        let rows = rows.into_iter().enumerate();
        let below = rows.filter(|(place, _)| !kernel.shape().third_order.contains(place));
        report.push(
            "the same of the rows without jerks at the first three",
            Bar::AtMost(LARGEST_RESIDUAL),
            Ok(most(below.map(|(_, row)| row).collect())),
        );
    }
}

/// The run back from the last node.
fn reversibility(motion: &MotionOfThirdOrder<'_>, nodes: &[MotionNode], report: &mut Report) {
    let measured = || -> Measured {
        let start = motion.start.third_order()?;
        let times = (motion.start.t, motion.until);
        let back = nodes_between(motion.system, motion.h, &start, times, true)?;
        let mut worst = 0.0;
        for (found, known) in back.iter().zip(nodes.iter().rev().skip(1)) {
            let leg = known.v.iter().fold(0.0_f64, |sum, v| sum.hypot(v * motion.h));
            let apart = less(&found.q, &known.q).into_iter().fold(0.0_f64, f64::hypot);
            let extent = nodes
                .iter()
                .fold(leg, |most, node| most.max((node.v[0] * motion.h).abs()));
            worst = larger(worst, apart / extent.max(f64::MIN_POSITIVE));
        }
        Ok(worst)
    };
    let bar = if motion.expected.reversible {
        Bar::AtMost(DISTANCE_BACK)
    } else {
        Bar::Reported
    };
    report.push("distance of the nodes on the way back, in legs", bar, measured());
}

/// The order, by the changes of the nodes from each step to its half.
fn order(motion: &MotionOfThirdOrder<'_>, report: &mut Report) {
    let declared = motion.expected.order;
    let measured = || -> Measured<Vec<[f64; 2]>> {
        let runs: Vec<Vec<MotionNode>> = (0..=HALVINGS)
            .map(|halving| nodes_with_step(motion, motion.h / f64::from(1_u32 << halving)))
            .collect::<Measured<_>>()?;
        let extent = |i: usize| {
            let first = runs[0].first().map_or(0.0, |node| node.q[i]);
            runs[0]
                .iter()
                .fold(0.0, |most, node| larger(most, (node.q[i] - first).abs()))
        };
        let extents: Vec<f64> = (0..motion.start.q.len()).map(extent).collect();
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
                debug_assert!((one.t - coarse.t).abs() <= motion.h.abs());
            }
            [(motion.h / parts as f64).abs(), change]
        });
        Ok(pairs.collect())
    };
    let bar = Bar::AtLeast(declared - ORDER_DEFICIT);
    push_slope(
        "slope of the changes of position from step to step",
        measured(),
        bar,
        report,
    );
}

/// The legs between some nodes, with their second differences.
fn steps(nodes: &[MotionNode]) -> Vec<Step> {
    let triples = nodes.windows(3).map(|three| {
        let leg = OwnedLeg {
            t: three[1].t,
            q: three[1].q.clone(),
            d: less(&three[1].q, &three[0].q),
        };
        let e = less(&less(&three[2].q, &three[1].q), &leg.d);
        (leg, e)
    });
    triples.collect()
}

/// The nodes of the motion with a step.
fn nodes_with_step(motion: &MotionOfThirdOrder<'_>, h: f64) -> Measured<Vec<MotionNode>> {
    let times = (motion.start.t, motion.until);
    nodes_between(motion.system, h, &motion.start.third_order()?, times, false)
}
