//! Extreme numbers in states, parameters and steps: NaN, infinities, subnormal and huge ones.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Instant;

use dsocs_core::{Flow, SetupError, Start, Stepper, System};

use super::roots::Undivided;
use super::{Bar, Report};
use crate::chain::PlanarChain2;
use crate::particle::CurvedParticle;
use crate::pendulum::InertiaWheelPendulum;

/// Steps in each run.
const STEPS: u32 = 20;

/// A generator of 64-bit numbers (G. Marsaglia's xorshift with multiplication), always from the same seed.
pub struct Random(u64);

impl Random {
    /// The generator of a seed, any but zero.
    pub fn new(seed: u64) -> Self {
        let mut random = Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1);
        // the first numbers after a small seed are hardly random
        for _ in 0..8 {
            random.next();
        }
        random
    }

    /// A number from 0 to 1.
    pub fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn next(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_f491_4f6c_dd1d)
    }

    /// A number of any kind: one in eight has random bits, one in eight is a special value, one in four has
    /// any order of magnitude up to 10^±`range`, the others are ordinary.
    fn number(&mut self, range: f64) -> f64 {
        let bits = self.next();
        let unit = self.unit();
        let sign = if bits & 8 == 0 { 1.0 } else { -1.0 };
        match bits & 7 {
            0 => f64::from_bits(self.next()),
            1 => [
                0.0,
                -0.0,
                f64::NAN,
                f64::INFINITY,
                f64::MAX,
                f64::MIN_POSITIVE,
                5e-324,
                1e-320,
            ][usize::try_from(bits >> 61).unwrap_or(0)],
            2 | 3 => sign * 10.0_f64.powf(range * (2.0 * unit - 1.0)),
            _ => sign * 2.0 * unit,
        }
    }
}

/// The results of many runs.
#[derive(Default)]
struct Outcome {
    /// Runs that panicked.
    panics: f64,
    /// Steps that were accepted although the node is not finite.
    infinite: f64,
    /// The longest time that one run took, in s.
    longest: f64,
    /// Steps that were accepted.
    accepted: f64,
    /// Runs that were refused, or ended with a typed error.
    refused: f64,
}

/// Runs a system from random starts with random parameters.
fn shoot<S: System<N> + Clone, const N: usize>(
    system: &S,
    runs: u32,
    random: &mut Random,
    outcome: &mut Outcome,
) {
    for run in 0..runs {
        let mut system = system.clone();
        // every other run has the system's own parameters
        if run % 2 == 1 {
            let mut index = 0;
            while let Some(parameter) = system.parameter_mut(index) {
                *parameter *= random.number(100.0);
                index += 1;
            }
        }
        let h = if run % 4 < 2 { 0.1 } else { random.number(150.0) };
        let mut vector = || -> [f64; N] { std::array::from_fn(|_| random.number(300.0)) };
        let (q, v) = (vector(), vector());
        let start = match run % 3 {
            0 => Start::paper(q, v),
            1 => Start::second_order(q, v),
            _ => Start::nodes(q, v),
        };
        let begun = Instant::now();
        let result = catch_unwind(AssertUnwindSafe(|| {
            let Ok(mut flow) = Flow::new(&system, h, start) else {
                return (0.0, 0.0, true);
            };
            let (mut accepted, mut infinite) = (0.0, 0.0);
            for _ in 0..STEPS {
                match flow.advance() {
                    Ok(_) => {
                        accepted += 1.0;
                        let _ = (flow.node(), flow.regularity());
                        if !flow.position().iter().all(|q| q.is_finite()) {
                            infinite += 1.0;
                        }
                    }
                    Err(error) => {
                        let _ = error.to_string();
                        return (accepted, infinite, true);
                    }
                }
            }
            (accepted, infinite, false)
        }));
        outcome.longest = outcome.longest.max(begun.elapsed().as_secs_f64());
        match result {
            Ok((accepted, infinite, refused)) => {
                outcome.accepted += accepted;
                outcome.infinite += infinite;
                outcome.refused += f64::from(u8::from(refused));
            }
            Err(_) => outcome.panics += 1.0,
        }
    }
}

/// Measures the figures of the case.
pub fn run(report: &mut Report<'_>) {
    let runs = if report.quick { 500 } else { 20_000 };
    let names = [
        (
            format!("{runs} random starts, parameters and steps on each of 4 systems: panics"),
            Bar::AtMost(0.0),
        ),
        (
            "the same: nodes that are not finite, accepted".to_owned(),
            Bar::AtMost(0.0),
        ),
        (
            "the same: longest run of 20 steps [s]".to_owned(),
            Bar::AtMost(1.0),
        ),
        ("the same: steps accepted".to_owned(), Bar::Reported),
        (
            "the same: runs refused with a typed error".to_owned(),
            Bar::Reported,
        ),
    ];
    report.measure_all(names, || {
        let (mut random, mut outcome) = (Random(0x9e37_79b9_7f4a_7c15), Outcome::default());
        let pendulum = InertiaWheelPendulum::default();
        shoot(&CurvedParticle::default(), runs, &mut random, &mut outcome);
        shoot(&pendulum, runs, &mut random, &mut outcome);
        shoot(&Undivided::of(&pendulum), runs, &mut random, &mut outcome);
        shoot(&PlanarChain2::default(), runs, &mut random, &mut outcome);
        Ok([
            outcome.panics,
            outcome.infinite,
            outcome.longest,
            outcome.accepted,
            outcome.refused,
        ])
    });
    report.measure(
        "h = 0, NaN, ∞, 1e-320, 1e300: set up without a typed error",
        Bar::AtMost(0.0),
        || {
            let particle = CurvedParticle::default();
            let mut silent = 0.0;
            for h in [
                0.0,
                -0.0,
                f64::NAN,
                f64::INFINITY,
                f64::NEG_INFINITY,
                1e-320,
                1e300,
                -1e300,
            ] {
                let flow = Flow::new(&particle, h, Start::second_order([0.0; 2], [1.0; 2]));
                if !matches!(flow, Err(SetupError::Step { .. } | SetupError::StepRange { .. })) {
                    silent += 1.0;
                }
            }
            Ok(silent)
        },
    );
}
