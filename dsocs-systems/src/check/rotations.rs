//! The checks of a system with rotations: those that need no forms on pairs of nodes.

use dsocs_core::geometry::{self, Triple, discrete_power};
use dsocs_core::{AnyPoint, AnyStart, Declaration, Kernel, OwnedLeg, Tolerance};

use super::contact::contact;
use super::momentum::{DRIFT, ROUNDING, relative_variation, terms};
use super::order::with_finer_steps;
use super::probe::{First, Passed, State, certified, less, passed_nodes};
use super::third::{certificates, push_slope};
use super::{Expected, Finding, Found, Measured, Report, Settings, excuse, flow, larger, probe, reached};
use crate::entry::{CheckFailure, Motions, Symmetry};
use crate::stability::Bar;

/// The distance along a symmetry at which the Lagrangian is compared, and the relative change that counts as
/// rounding.
const MOVED: f64 = 1e-3;
const SAME: f64 = 1e-9;

/// The largest deviation of a norm from one, in roundings.
const ROUNDINGS: f64 = 4.0;

/// A force whose work is below this part of the terms does no work.
const NO_WORK: f64 = 1e-14;

/// The number of steps, each half of the one before.
const HALVINGS: usize = 5;

/// The largest deficit of the fitted order against the declared one.
const APART: f64 = 0.1;

/// The tolerance of the continuous motion.
const TOLERANCE: f64 = 1e-14;

/// A motion, with its expected properties.
struct Subject<'a> {
    system: &'a dyn Motions,
    kernel: &'a dyn Kernel,
    h: f64,
    until: f64,
    start: State,
    first: First,
    expected: Expected,
}

impl Subject<'_> {
    /// The start of a run, by the rule for the second node.
    fn begins(&self) -> AnyStart {
        self.start.beginning(self.first).start()
    }
}

/// Checks a system on the motion from a position and a velocity, to the end `own` unless the settings give
/// another.
///
/// # Errors
///
/// [`CheckFailure`] if the motion cannot be computed.
pub fn check_to(
    system: &dyn Motions,
    symmetries: &[Symmetry],
    expected: Expected,
    settings: &Settings<'_>,
    own: f64,
) -> Result<Vec<Finding>, CheckFailure> {
    let (kernel, start) = (system.kernel(), State::of(settings));
    let subject = Subject {
        system,
        kernel,
        h: settings.h,
        until: settings.until.unwrap_or(start.t + own),
        start: if settings.begin.projected {
            probe::projected(kernel, settings.h, &start)?
        } else {
            start
        },
        first: if settings.begin.paper {
            First::Paper
        } else {
            First::SecondOrder
        },
        expected,
    };
    let (nodes, regularity, hard) = certified(kernel, subject.h, &subject.begins(), subject.until)?;
    let walked = probe::legs(kernel, subject.h, (&subject.start, subject.first), subject.until)?;
    let held = walked.held.iter().filter(|held| **held).count();
    let excuse = excuse(hard, held, nodes.len().saturating_sub(1));
    let is_excused = excuse.is_some();
    let mut found = Found::new(excuse);
    found.of("window", |report| window(&subject, &nodes, report));
    found.of("regularity", |report| {
        certificates(["D₃", "D₁"], &regularity, report);
    });
    found.of("rotations", |report| norms(&subject, &nodes, report));
    found.of("momentum law", |report| {
        momenta(&subject, symmetries, &walked.legs, report);
    });
    found.of("power balance", |report| {
        with_finer_steps((subject.h, is_excused), report, &|| false, &|parts, report| {
            balance(&subject, parts, report);
        });
    });
    let whole = super::Subject::new(system, symmetries, subject.expected, settings, own)?;
    found.of("reversibility", |report| flow::step_back(&whole, report));
    found.of("contact", |report| contact(&whole, report));
    found.of("order", |report| {
        with_finer_steps((subject.h, is_excused), report, &|| false, &|parts, report| {
            order(&subject, parts, report);
        });
    });
    Ok(found.findings)
}

/// The time that the motion reaches.
fn window(subject: &Subject<'_>, nodes: &[Passed], report: &mut Report) {
    let left_out = "beside a rotation what needs forms on pairs of nodes (the identities, the symplectic law) is not looked at, so far";
    reached(
        [subject.start.t, subject.until, subject.h],
        nodes,
        left_out,
        report,
    );
}

/// The norms of the quaternions.
fn norms(subject: &Subject<'_>, nodes: &[Passed], report: &mut Report) {
    let rotations = &subject.kernel.shape().rotations;
    let of_node = |node: &Passed| {
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
fn momenta(subject: &Subject<'_>, symmetries: &[Symmetry], legs: &[OwnedLeg<f64>], report: &mut Report) {
    let mut own = reduced(subject.kernel);
    own.retain(|symmetry| {
        legs.iter()
            .all(|leg| keeps_lagrangian(subject.kernel, leg, symmetry))
    });
    if symmetries.is_empty() && own.is_empty() {
        report.push(
            "symmetries that are declared, and positions that are in no equation",
            Bar::Reported,
            Ok(0.0),
        );
    }
    for symmetry in symmetries.iter().chain(&own) {
        let generator = |q: &[f64]| symmetry.at(q);
        let (mut missed, mut works) = (0.0, 0.0);
        for pair in legs.windows(2) {
            let e = less(&pair[1].d, &pair[0].d);
            let both = [pair[0].any(), pair[1].any()];
            let [apart, work, all] =
                geometry::momentum_balance(subject.kernel, subject.h, both, &e, &generator);
            missed = larger(missed, if apart == 0.0 { 0.0 } else { apart.abs() / all });
            works = larger(works, if work == 0.0 { 0.0 } else { work.abs() / all });
        }
        let name = symmetry.name();
        report.push(
            format!("{name}: ΔJ − h⟨Q + f, ξ⟩, relative to the terms"),
            Bar::AtMost(ROUNDING),
            Ok(missed),
        );
        let momenta = legs.iter().map(|leg| {
            let arriving = geometry::arriving_momentum(subject.kernel, subject.h, leg.any());
            let along = generator(&leg.q);
            let momentum = arriving.iter().zip(&along).map(|(p, along)| p * along).sum();
            [momentum, terms(subject.kernel, &arriving, &along)]
        });
        report.push(
            format!("{name}: variation of J along the motion, relative to its terms"),
            if works <= NO_WORK {
                Bar::AtMost(DRIFT)
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
    let [ahead, behind] = [MOVED, -MOVED].map(|part| {
        let pairs = leg.q.iter().zip(&generator);
        let q: Vec<f64> = pairs.map(|(q, along)| q + part * along).collect();
        Declaration::of(kernel).lagrangian::<f64>(leg.t, &q, &still)
    });
    (ahead - behind).abs() <= SAME * (ahead.abs() + behind.abs())
}

/// The symmetries of cyclic coordinates, whose positions are in no equation.
fn reduced(kernel: &dyn Kernel) -> Vec<Symmetry> {
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

/// The energy at nodes against the sum of the power of the forces: the order of the defect, with parts of the
/// subject's step.
fn balance(subject: &Subject<'_>, parts: u32, report: &mut Report) {
    let measured: Measured<Vec<[f64; 2]>> = (0..HALVINGS)
        .map(|halving| {
            let h = subject.h / f64::from(parts << halving);
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
    let kernel = subject.kernel;
    let declaration = Declaration::of(kernel);
    let walked = probe::legs(kernel, h, (&subject.start, subject.first), subject.until)?;
    let (mut change, mut missed, mut terms) = (0.0, 0.0, 0.0);
    let mut last: Option<(f64, f64)> = None;
    for pair in walked.legs.windows(2) {
        let (leg, e) = (pair[0].clone(), less(&pair[1].d, &pair[0].d));
        let point = declaration.point(h, leg.any(), &e);
        let AnyPoint { t, q, v, .. } = point.any();
        let energy = declaration.energy(t, q, v);
        terms = larger(terms, energy.abs() + 2.0 * declaration.lagrangian(t, q, v).abs());
        let power = discrete_power(kernel, h, &Triple { leg, e });
        last = Some(match last {
            Some((first, before)) => {
                change += h * (before + power) / 2.0;
                missed = larger(missed, (energy - first - change).abs());
                (first, power)
            }
            None => (energy, power),
        });
    }
    Ok(if missed == 0.0 { 0.0 } else { missed / terms })
}

/// The order with parts of the subject's step: by the errors against the continuous motion or, where there is
/// no series, by the changes from each step to its half.
fn order(subject: &Subject<'_>, parts: u32, report: &mut Report) {
    let bar = Bar::AtLeast(subject.expected.order - APART);
    let part = |halving: usize| f64::from(parts << halving);
    let runs: Measured<Vec<Vec<Passed>>> = (0..=HALVINGS)
        .map(|halving| {
            let times = (subject.start.t, subject.until);
            let h = subject.h / part(halving);
            passed_nodes(subject.kernel, h, &subject.begins(), times, false)
        })
        .collect();
    let largest = subject.h / part(0);
    let known = continuous(subject, largest);
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
fn distance((one, by): (&[Passed], usize), (other, by_other): (&[Passed], usize)) -> f64 {
    let pairs = one.iter().step_by(by).zip(other.iter().step_by(by_other));
    let apart = pairs.flat_map(|(one, other)| less(&one.q, &other.q));
    apart.fold(0.0, |most, apart| larger(most, apart.abs()))
}

/// The continuous motion at the nodes of a step.
fn continuous(subject: &Subject<'_>, h: f64) -> Measured<Vec<Passed>> {
    let beginning = subject.start.beginning(subject.first);
    let mut run = subject
        .system
        .continuous(&beginning, Tolerance::relative(TOLERANCE), Some(h))?;
    let mut nodes = Vec::new();
    run.walk_to(subject.until, &mut |run| {
        nodes.push(probe::passed(run));
        Ok(core::ops::ControlFlow::Continue(()))
    })?;
    Ok(nodes)
}
