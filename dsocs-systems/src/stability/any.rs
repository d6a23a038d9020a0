//! Hard cases for any system: those that need no exact solution.

use std::error::Error;
use std::ops::ControlFlow;

use super::{Bar, Measured, Report, Row, distance, larger};
use crate::check::Settings;
use crate::entry::{self, Beginning, Entry, Method, Plan, RunFailure};

/// The largest number of steps in a long run, and in its quick form.
const STEPS: [f64; 2] = [1e6, 1e4];

/// The number of steps in comparisons of two motions.
const COMPARED_STEPS: u32 = 40;

/// The duration of runs with small steps, in steps of the given size.
const WINDOW: u32 = 8;

/// The divisors of the given step at which errors are compared with the order; quick cases leave out the
/// last.
const STEP_DIVISORS: [u32; 3] = [10, 100, 1000];

/// The largest error, relative to that at the first of [`STEP_DIVISORS`] scaled by the order.
const LARGEST_EXCESS: f64 = 3.0;

/// The rounding of the errors of small steps, relative to the motion's extent.
const ROUNDING: f64 = 1e-12;

/// The largest distance from the motion of a run that is begun anew at its nodes, or that runs back, relative
/// to the motion's extent.
const LARGEST_DISTANCE: f64 = 1e-6;

/// A hard case.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// Its number.
    pub number: u8,
    /// Its name.
    pub name: &'static str,
    /// Measures the figures.
    run: fn(&MeasuredMotion<'_>, &mut Report<'_>),
}

impl Case {
    /// Measures all figures of the case on a motion of a system, and calls `done` with each. Quick cases take seconds.
    pub fn run(
        &self,
        entry: &Entry,
        settings: &Settings<'_>,
        quick: bool,
        done: &mut dyn FnMut(&Row),
    ) -> Vec<Row> {
        let mut report = Report {
            number: self.number,
            case: self.name,
            quick,
            rows: Vec::new(),
            done,
        };
        (self.run)(&MeasuredMotion { entry, settings }, &mut report);
        report.rows
    }
}

/// All cases.
pub const CASES: &[Case] = &[
    Case {
        number: 1,
        name: "long runs",
        run: long_run,
    },
    Case {
        number: 2,
        name: "large steps",
        run: large_steps,
    },
    Case {
        number: 3,
        name: "small steps",
        run: small_steps,
    },
    Case {
        number: 4,
        name: "cold starts",
        run: cold_start,
    },
    Case {
        number: 5,
        name: "backward",
        run: backward,
    },
    Case {
        number: 6,
        name: "garbage",
        run: garbage,
    },
];

/// A system with the motion that is measured.
struct MeasuredMotion<'a> {
    /// The system.
    entry: &'a Entry,
    /// The motion.
    settings: &'a Settings<'a>,
}

impl MeasuredMotion<'_> {
    /// The start.
    fn start(&self) -> Beginning {
        let Settings { q0, v0, a0, .. } = *self.settings;
        self.start_from([q0, v0].map(<[f64]>::to_vec), a0.map(<[f64]>::to_vec))
    }

    /// A start with another position, velocity and acceleration.
    fn start_from(&self, [q0, v0]: [Vec<f64>; 2], a0: Option<Vec<f64>>) -> Beginning {
        let start = match a0 {
            Some(a0) => Beginning::ThirdOrder { q0, v0, a0 },
            None => Beginning::SecondOrder { q0, v0 },
        };
        Beginning::At(self.settings.t0, Box::new(start))
    }

    /// A start at two nodes, or at three where a constraint is of third order.
    fn start_at_nodes(&self, nodes: [&Vec<f64>; 3]) -> Beginning {
        let [q0, q1, q2] = nodes.map(Clone::clone);
        if self.settings.a0.is_some() {
            Beginning::ThreeNodes { q0, q1, q2 }
        } else {
            Beginning::Nodes { q0, q1 }
        }
    }

    /// Makes steps and passes each node to `node`.
    fn steps(
        &self,
        h: f64,
        steps: f64,
        beginning: &Beginning,
        mut node: impl FnMut(&entry::Row<'_>),
    ) -> Result<(), RunFailure> {
        let plan = Plan {
            h,
            until: time(beginning) + steps * h,
            method: Method::Step,
            certify: false,
            estimate: false,
            inputs: Vec::new(),
        };
        self.entry.run(&plan, beginning, &mut |row| {
            node(row);
            ControlFlow::Continue(())
        })
    }

    /// The positions at the nodes of a run.
    fn positions(&self, h: f64, steps: u32, beginning: &Beginning) -> Result<Vec<Vec<f64>>, RunFailure> {
        let mut positions = Vec::new();
        self.steps(h, f64::from(steps), beginning, |row| {
            positions.push(row.node.q.to_vec());
        })?;
        Ok(positions)
    }

    /// The largest error against the continuous motion over the window, with the step divided by `part`.
    fn error(&self, part: u32) -> Measured {
        if self.settings.a0.is_some() {
            return self.change(part);
        }
        let h = self.settings.h / f64::from(part);
        let plan = Plan {
            h,
            until: self.settings.t0 + f64::from(WINDOW * part) * h,
            method: Method::Step,
            certify: false,
            estimate: true,
            inputs: Vec::new(),
        };
        let mut largest = 0.0;
        self.entry.run(&plan, &self.start(), &mut |row| {
            largest = row.errors.iter().copied().fold(largest, larger);
            ControlFlow::Continue(())
        })?;
        Ok(largest)
    }
}

impl MeasuredMotion<'_> {
    /// The error where there is no continuous motion to compare with: the largest change when the step is
    /// halved, which is three quarters of the error.
    fn change(&self, part: u32) -> Measured {
        let of = |part: u32| {
            let h = self.settings.h / f64::from(part);
            self.positions(h, WINDOW * part, &self.start())
        };
        let (whole, half) = (of(part)?, of(2 * part)?);
        let pairs = whole.iter().zip(half.iter().step_by(2));
        let largest = pairs.map(|(x, y)| distance(x, y)).fold(0.0, larger);
        Ok(largest / 0.75)
    }
}

/// The time at which a run begins.
fn time(beginning: &Beginning) -> f64 {
    match beginning {
        Beginning::At(t0, _) => *t0,
        Beginning::Projected(beginning) => time(beginning),
        _ => 0.0,
    }
}

/// A beginning at a time, projected onto the constraints.
fn at(t: f64, beginning: Beginning) -> Beginning {
    Beginning::Projected(Box::new(Beginning::At(t, Box::new(beginning))))
}

/// The largest change of a coordinate from the start.
fn extent(positions: &[Vec<f64>]) -> f64 {
    let first = positions.first().map_or(&[][..], Vec::as_slice);
    positions.iter().map(|q| distance(q, first)).fold(0.0, larger)
}

/// A run to the end that the entry gives.
fn long_run(motion: &MeasuredMotion<'_>, report: &mut Report<'_>) {
    let h = motion.settings.h;
    let until = motion
        .settings
        .until
        .unwrap_or_else(|| motion.entry.default_until());
    let asked = (until / h).abs().floor().max(1.0);
    let steps = asked.min(STEPS[usize::from(report.quick)]);
    let (mut made, mut first, mut change) = (-1.0, f64::NAN, 0.0);
    let mut failure = None;
    report.measure(
        format!("{steps} steps of h = {h}: steps that are not made"),
        Bar::AtMost(0.0),
        || {
            let result = motion.steps(h, steps, &motion.start(), |row| {
                if made < 0.0 {
                    first = row.node.energy;
                }
                made += 1.0;
                change = larger(change, (row.node.energy - first).abs());
            });
            failure = result.err().map(|failure| failure.to_string());
            match &failure {
                Some(failure) => Err(failure.clone().into()),
                None => Ok(steps - made),
            }
        },
    );
    report.measure(
        "the same: largest change of the energy [J]",
        Bar::Reported,
        || Ok(change),
    );
    report.measure(
        "the same: relative to the energy at the start",
        Bar::Reported,
        || Ok(if change == 0.0 { 0.0 } else { change / first.abs() }),
    );
}

/// Steps that are too large are refused, and accepted nodes are finite.
fn large_steps(motion: &MeasuredMotion<'_>, report: &mut Report<'_>) {
    let h = motion.settings.h;
    let mut made = 1.0;
    report.measure(
        "h × 2, 4, … 2^20: nodes that are not numbers, without an error",
        Bar::AtMost(0.0),
        || {
            let (mut silent, mut all) = (0.0, true);
            for power in 1..=20 {
                let factor = f64::powi(2.0, power);
                let ended = motion.steps(factor * h, f64::from(COMPARED_STEPS), &motion.start(), |row| {
                    silent += f64::from(u8::from(!is_finite(row)));
                });
                all = all && ended.is_ok();
                if all {
                    made = factor;
                }
            }
            Ok(silent)
        },
    );
    report.measure(
        format!("largest of these factors up to which {COMPARED_STEPS} steps are made"),
        Bar::Reported,
        || Ok(made),
    );
}

/// With small steps the error is no larger than the order and rounding allow.
fn small_steps(motion: &MeasuredMotion<'_>, report: &mut Report<'_>) {
    let parts = if report.quick {
        &STEP_DIVISORS[..2]
    } else {
        &STEP_DIVISORS[..]
    };
    let [coarse, finer @ ..] = parts else { return };
    let mut errors = Err("no run".into());
    report.measure(
        format!("h/{coarse} over {WINDOW} h: largest error against the continuous motion"),
        Bar::Reported,
        || {
            let positions = motion.positions(motion.settings.h, WINDOW, &motion.start())?;
            let error = motion.error(*coarse)?;
            errors = Ok::<_, Box<dyn Error>>([error, extent(&positions)]);
            Ok(error)
        },
    );
    for part in finer {
        let bar = Bar::AtMost(LARGEST_EXCESS);
        let what = format!("h/{part}: the same, over what the order and rounding leave of it");
        report.measure(what, bar, || {
            let [error, extent] = *errors.as_ref().map_err(ToString::to_string)?;
            let left = error * (f64::from(*coarse) / f64::from(*part)).powf(motion.entry.expected().order);
            Ok(motion.error(*part)? / (left + ROUNDING * extent))
        });
    }
}

/// A run that begins at two nodes of the motion continues the motion: the root of a step does not depend on
/// earlier nodes.
fn cold_start(motion: &MeasuredMotion<'_>, report: &mut Report<'_>) {
    report.measure(
        format!(
            "begun anew at each of {COMPARED_STEPS} nodes: distance of the next node, in parts of the extent"
        ),
        Bar::AtMost(LARGEST_DISTANCE),
        || {
            let positions = motion.positions(motion.settings.h, COMPARED_STEPS + 2, &motion.start())?;
            let mut apart = 0.0;
            // a step is from three nodes to the fourth where a constraint is of third order
            let (known, steps) = if motion.settings.a0.is_some() {
                (3, 3)
            } else {
                (2, 2)
            };
            for (place, nodes) in positions.windows(known + 1).enumerate() {
                let t = motion.settings.t0 + place as f64 * motion.settings.h;
                let beginning = motion.start_at_nodes([&nodes[0], &nodes[1], &nodes[2]]);
                let next = motion.positions(motion.settings.h, steps, &at(t, beginning))?;
                let next = next.last().ok_or("no nodes")?;
                apart = larger(apart, distance(next, &nodes[known]));
            }
            Ok(apart / extent(&positions))
        },
    );
}

/// Runs forward and back.
fn backward(motion: &MeasuredMotion<'_>, report: &mut Report<'_>) {
    let h = motion.settings.h;
    let back = |steps: u32| {
        let positions = motion.positions(h, steps + 1, &motion.start())?;
        let [.., first, before, last] = positions.as_slice() else {
            return Err("no nodes".into());
        };
        let nodes = motion.start_at_nodes([last, before, first]);
        let beginning = at(motion.settings.t0 + f64::from(steps + 1) * h, nodes);
        let returned = motion.positions(-h, steps + 1, &beginning)?;
        let (first, end) = (
            positions.first().ok_or("no nodes")?,
            returned.last().ok_or("no nodes")?,
        );
        Ok::<f64, Box<dyn Error>>(distance(first, end) / extent(&positions))
    };
    let bar = if motion.entry.expected().reversible {
        Bar::AtMost(LARGEST_DISTANCE)
    } else {
        Bar::Reported
    };
    report.measure(
        format!("{COMPARED_STEPS} steps and back: distance from the start, in parts of the extent"),
        bar,
        || back(COMPARED_STEPS),
    );
    let most = if report.quick { 10 } else { 14 };
    report.measure(
        format!(
            "steps and back after which the start is still met to 1e-3 of the extent (of {})",
            1 << most
        ),
        Bar::Reported,
        || {
            let met = (0..=most).map(|power| 1_u32 << power);
            let met = met.take_while(|&steps| back(steps).is_ok_and(|apart| apart <= 1e-3));
            Ok(met.last().map_or(0.0, f64::from))
        },
    );
}

/// Whether position and velocity of a node are finite. The energy may overflow before they do.
fn is_finite(row: &entry::Row<'_>) -> bool {
    row.node
        .q
        .iter()
        .chain(row.node.v)
        .all(|number| number.is_finite())
}

/// Starts and steps with extreme values: they are refused with an error, or give finite nodes.
fn garbage(motion: &MeasuredMotion<'_>, report: &mut Report<'_>) {
    const VALUES: [f64; 12] = [
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
        f64::MAX,
        -f64::MAX,
        1e200,
        -1e100,
        1e-100,
        -1e-300,
        f64::MIN_POSITIVE,
        5e-324,
        -0.0,
    ];
    let h = motion.settings.h;
    let mut refused = 0.0;
    let mut silent = |h: f64, beginning: &Beginning| {
        let mut silent = 0.0;
        let ended = motion.steps(h, 3.0, beginning, |row| {
            silent += f64::from(u8::from(!is_finite(row)));
        });
        refused += f64::from(u8::from(ended.is_err()));
        silent
    };
    let count = motion.settings.q0.len();
    let vectors = if motion.settings.a0.is_some() { 3 } else { 2 };
    report.measure(
        "each component of the start, and the step, set to NaN, ±∞, 1e±300, …: nodes that are not numbers, without an error",
        Bar::AtMost(0.0),
        || {
            let mut sum = 0.0;
            for value in VALUES {
                for place in 0..vectors * count {
                    let Settings { q0, v0, a0, .. } = *motion.settings;
                    let mut start = [q0, v0].map(<[f64]>::to_vec);
                    let mut a0 = a0.map(<[f64]>::to_vec);
                    match (start.get_mut(place / count), &mut a0) {
                        (Some(vector), _) | (None, Some(vector)) => vector[place % count] = value,
                        (None, None) => {}
                    }
                    sum += silent(h, &motion.start_from(start, a0));
                }
                sum += silent(value, &motion.start());
            }
            Ok(sum)
        },
    );
    let tries = VALUES.len() * (vectors * count + 1);
    report.measure(format!("refused, of these {tries}"), Bar::Reported, || {
        Ok(refused)
    });
}
