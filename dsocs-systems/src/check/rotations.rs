//! The checks of a system with rotations: those that need no forms on pairs of nodes.

use dsocs_core::geometry;
use dsocs_core::{AnyStart, Declaration, Kernel, OwnedLeg, Tolerance};

use crate::check::motion::motions;
use crate::check::motion::motions::{MotionNode, SecondNode, State, certified_nodes, less, nodes_between};
use crate::check::order::between_steps::{ORDER_DEFICIT, Step, balance, push_slope};
use crate::check::order::with_finer_steps;
use crate::check::theorems::contact::contact;
use crate::check::theorems::flow;
use crate::check::theorems::momentum::{LARGEST_CHANGE, LARGEST_DRIFT, relative_variation, terms};
use crate::check::third::certificates;
use crate::check::{
    CheckFindings, Expected, Finding, Measured, Report, Settings, excuse, larger, report_reached_time,
};
use crate::entry::{CheckFailure, Motions, Symmetry};
use crate::stability::Bar;

/// The distance along a symmetry at which the Lagrangian is compared, and the relative change that counts as
/// rounding.
const SYMMETRY_SHIFT: f64 = 1e-3;
const INVARIANT_CHANGE: f64 = 1e-9;

/// The largest deviation of a norm from one, in roundings.
const ROUNDINGS: f64 = 4.0;

/// A force whose work is below this part of the terms does no work.
const NO_WORK: f64 = 1e-14;

/// The number of steps, each half of the one before.
const HALVINGS: usize = 5;

/// The tolerance of the continuous motion.
const TOLERANCE: f64 = 1e-14;

/// A motion, with its expected properties.
struct MotionWithRotations<'a> {
    system: &'a dyn Motions,
    kernel: &'a dyn Kernel,
    h: f64,
    until: f64,
    start: State,
    first: SecondNode,
    expected: Expected,
}

impl MotionWithRotations<'_> {
    /// The start of a run, by the rule for the second node.
    fn run_start(&self) -> AnyStart {
        self.start.beginning(self.first).start()
    }
}

/// Checks a system on the motion from a position and a velocity, for the time `default_duration` unless the
/// settings give an end.
///
/// # Errors
///
/// [`CheckFailure`] if the motion cannot be computed.
pub fn check_to(
    system: &dyn Motions,
    symmetries: &[Symmetry],
    expected: Expected,
    settings: &Settings<'_>,
    default_duration: f64,
) -> Result<Vec<Finding>, CheckFailure> {
    let (kernel, start) = (system.kernel(), State::of(settings));
    let motion = MotionWithRotations {
        system,
        kernel,
        h: settings.h,
        until: settings.until.unwrap_or(start.t + default_duration),
        start: if settings.begin.projected {
            motions::projected(kernel, settings.h, &start)?
        } else {
            start
        },
        first: if settings.begin.paper {
            SecondNode::Paper
        } else {
            SecondNode::SecondOrder
        },
        expected,
    };
    let (nodes, regularity, doubtful) = certified_nodes(kernel, motion.h, &motion.run_start(), motion.until)?;
    let legs_of_motion = motions::legs(kernel, motion.h, (&motion.start, motion.first), motion.until)?;
    let held = legs_of_motion.held.iter().filter(|held| **held).count();
    let excuse = excuse(doubtful, held, nodes.len().saturating_sub(1));
    let is_excused = excuse.is_some();
    let mut findings = CheckFindings::new(excuse);
    findings.carry_out("window", |report| window(&motion, &nodes, report));
    findings.carry_out("regularity", |report| {
        certificates(["D₃", "D₁"], &regularity, report);
    });
    findings.carry_out("rotations", |report| norms(&motion, &nodes, report));
    findings.carry_out("momentum law", |report| {
        momenta(&motion, symmetries, &legs_of_motion.legs, report);
    });
    findings.carry_out("power balance", |report| {
        with_finer_steps((motion.h, is_excused), report, &|| false, &|parts, report| {
            let lengths = (0..HALVINGS).map(|halving| motion.h / f64::from(parts << halving));
            let steps = |h| steps(&motion, h);
            balance(motion.kernel, (lengths, motion.expected.order), steps, report);
        });
    });
    let whole =
        crate::check::CheckedMotion::new(system, symmetries, motion.expected, settings, default_duration)?;
    findings.carry_out("reversibility", |report| flow::step_back(&whole, report));
    findings.carry_out("contact", |report| contact(&whole, report));
    findings.carry_out("order", |report| {
        with_finer_steps((motion.h, is_excused), report, &|| false, &|parts, report| {
            order(&motion, parts, report);
        });
    });
    Ok(findings.findings)
}

/// The time that the motion reaches.
fn window(motion: &MotionWithRotations<'_>, nodes: &[MotionNode], report: &mut Report) {
    let left_out = "beside a rotation what needs forms on pairs of nodes (the identities, the symplectic law) is not looked at, so far";
    report_reached_time([motion.start.t, motion.until, motion.h], nodes, left_out, report);
}

/// The norms of the quaternions.
fn norms(motion: &MotionWithRotations<'_>, nodes: &[MotionNode], report: &mut Report) {
    let rotations = &motion.kernel.shape().rotations;
    let of_node = |node: &MotionNode| {
        let quaternions = rotations.iter().filter_map(|&first| node.q.get(first..first + 4));
        let norms = quaternions.map(|q| q.iter().map(|q| q * q).sum::<f64>().sqrt());
        norms.fold(0.0, |most, norm| larger(most, (norm - 1.0).abs() / f64::EPSILON))
    };
    report.push(
        "distance of the quaternions' norms from 1, in roundings",
        Bar::AtMost(ROUNDINGS),
        Ok(nodes.iter().map(of_node).fold(0.0, larger)),
    );
}

/// The momentum equation along the declared symmetries, and along those of cyclic coordinates: translations,
/// and rotations about the axes of space. Where no force does work along a symmetry, its momentum is
/// conserved.
fn momenta(
    motion: &MotionWithRotations<'_>,
    symmetries: &[Symmetry],
    legs: &[OwnedLeg<f64>],
    report: &mut Report,
) {
    let mut cyclic = cyclic_symmetries(motion.kernel);
    cyclic.retain(|symmetry| {
        legs.iter()
            .all(|leg| keeps_lagrangian(motion.kernel, leg, symmetry))
    });
    if symmetries.is_empty() && cyclic.is_empty() {
        report.push(
            "symmetries that are declared, and positions that are in no equation",
            Bar::Reported,
            Ok(0.0),
        );
    }
    for symmetry in symmetries.iter().chain(&cyclic) {
        let generator = |q: &[f64]| symmetry.at(q);
        let (mut missed, mut works) = (0.0, 0.0);
        for pair in legs.windows(2) {
            let e = less(&pair[1].d, &pair[0].d);
            let both = [pair[0].any(), pair[1].any()];
            let [apart, work, all] =
                geometry::momentum_balance(motion.kernel, motion.h, both, &e, &generator);
            missed = larger(missed, if apart == 0.0 { 0.0 } else { apart.abs() / all });
            works = larger(works, if work == 0.0 { 0.0 } else { work.abs() / all });
        }
        let name = symmetry.name();
        report.push(
            format!("{name}: ΔJ − h⟨Q + f, ξ⟩, relative to the terms"),
            Bar::AtMost(LARGEST_CHANGE),
            Ok(missed),
        );
        let momenta = legs.iter().map(|leg| {
            let arriving = geometry::arriving_momentum(motion.kernel, motion.h, leg.any());
            let along = generator(&leg.q);
            let momentum = arriving.iter().zip(&along).map(|(p, along)| p * along).sum();
            [momentum, terms(motion.kernel, &arriving, &along)]
        });
        report.push(
            format!("{name}: variation of J along the motion, relative to its terms"),
            if works <= NO_WORK {
                Bar::AtMost(LARGEST_DRIFT)
            } else {
                Bar::Reported
            },
            Ok(relative_variation(momenta)),
        );
    }
}

/// Whether the Lagrangian is invariant along a symmetry: a height may be in no equation while its weight is
/// in the Lagrangian.
fn keeps_lagrangian(kernel: &dyn Kernel, leg: &OwnedLeg<f64>, symmetry: &Symmetry) -> bool {
    let generator = symmetry.at(&leg.q);
    let still = vec![0.0; generator.len()];
    let [ahead, behind] = [SYMMETRY_SHIFT, -SYMMETRY_SHIFT].map(|part| {
        let pairs = leg.q.iter().zip(&generator);
        let q: Vec<f64> = pairs.map(|(q, along)| q + part * along).collect();
        Declaration::of(kernel).lagrangian::<f64>(leg.t, &q, &still)
    });
    (ahead - behind).abs() <= INVARIANT_CHANGE * (ahead.abs() + behind.abs())
}

/// The symmetries of cyclic coordinates, whose positions are in no equation.
fn cyclic_symmetries(kernel: &dyn Kernel) -> Vec<Symmetry> {
    let shape = kernel.shape();
    let n = shape.dimension();
    let mut all = Vec::new();
    for place in geometry::reduced(kernel) {
        let name = shape.coordinates.get(place).map_or("", |own| &*own.name);
        if shape.rotation_of(place).is_none() {
            all.push(Symmetry::of(format!("`{name}` moved"), n, move |_, out| {
                out.fill(0.0);
                out[place] = 1.0;
            }));
            continue;
        }
        let name = name.strip_suffix("_w").unwrap_or(name);
        for (axis, which) in ["first", "second", "third"].into_iter().enumerate() {
            let name = format!("`{name}` turned about the {which} axis of space");
            all.push(Symmetry::of(name, n, move |q, out| {
                out.fill(0.0);
                let [w, x, y, z] = [0, 1, 2, 3].map(|k| q[place + k]);
                // a row of the matrix of the attitude: an axis of space in the frame of the body
                let seen = match axis {
                    0 => [
                        w * w + x * x - y * y - z * z,
                        2.0 * (x * y - w * z),
                        2.0 * (x * z + w * y),
                    ],
                    1 => [
                        2.0 * (x * y + w * z),
                        w * w - x * x + y * y - z * z,
                        2.0 * (y * z - w * x),
                    ],
                    _ => [
                        2.0 * (x * z - w * y),
                        2.0 * (y * z + w * x),
                        w * w - x * x - y * y + z * z,
                    ],
                };
                out[place + 1..place + 4].copy_from_slice(&seen);
            }));
        }
    }
    all
}

/// The legs of the motion with a step, with their second differences.
fn steps(motion: &MotionWithRotations<'_>, h: f64) -> Measured<Vec<Step>> {
    let found = motions::legs(motion.kernel, h, (&motion.start, motion.first), motion.until)?;
    let pairs = found.legs.windows(2);
    let steps = pairs.map(|pair| (pair[0].clone(), less(&pair[1].d, &pair[0].d)));
    Ok(steps.collect())
}

/// The order with parts of the motion's step: by the errors against the continuous motion or, where there is
/// no series, by the changes from each step to its half.
fn order(motion: &MotionWithRotations<'_>, parts: u32, report: &mut Report) {
    let bar = Bar::AtLeast(motion.expected.order - ORDER_DEFICIT);
    let part = |halving: usize| f64::from(parts << halving);
    let runs: Measured<Vec<Vec<MotionNode>>> = (0..=HALVINGS)
        .map(|halving| {
            let times = (motion.start.t, motion.until);
            let h = motion.h / part(halving);
            nodes_between(motion.kernel, h, &motion.run_start(), times, false)
        })
        .collect();
    let largest = motion.h / part(0);
    let known = continuous_nodes(motion, largest);
    let what = match known {
        Ok(_) => "slope of the errors of position",
        Err(_) => "slope of the changes of position from step to step",
    };
    let measured = runs.map(|runs| {
        let pairs = runs.windows(2).enumerate();
        let pairs = pairs.map(|(halving, pair)| {
            let parts = 1_usize << halving;
            let apart = match &known {
                Ok(known) => distance((&pair[0], parts), (known, 1)),
                Err(_) => distance((&pair[0], parts), (&pair[1], 2 * parts)),
            };
            [(largest / parts as f64).abs(), apart]
        });
        pairs.collect()
    });
    push_slope(what, measured, bar, report);
    if let Err(error) = known {
        report.note(&error.to_string());
    }
}

/// The largest distance of two motions, at every `by`-th node of each, which are at the same times.
fn distance((one, by): (&[MotionNode], usize), (other, by_other): (&[MotionNode], usize)) -> f64 {
    let pairs = one.iter().step_by(by).zip(other.iter().step_by(by_other));
    let apart = pairs.flat_map(|(one, other)| less(&one.q, &other.q));
    apart.fold(0.0, |most, apart| larger(most, apart.abs()))
}

/// The continuous motion at the nodes of a step.
fn continuous_nodes(motion: &MotionWithRotations<'_>, h: f64) -> Measured<Vec<MotionNode>> {
    let beginning = motion.start.beginning(motion.first);
    let mut run = motion
        .system
        .continuous(&beginning, Tolerance::relative(TOLERANCE), Some(h))?;
    let mut nodes = Vec::new();
    run.walk_to(motion.until, &mut |run| {
        nodes.push(motions::node_of(run));
        Ok(core::ops::ControlFlow::Continue(()))
    })?;
    Ok(nodes)
}
