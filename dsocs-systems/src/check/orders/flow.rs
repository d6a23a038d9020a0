//! The order of the flow, by its errors.

use core::slice;

use super::fit::{Order, Sample, order, order_and_unsteadiness};
use super::parts::{HALVINGS, LARGEST_STEP, Part, PartOrder, expansions};
use crate::check::order::{FOLLOWING_HALVINGS, errors, followed_nodes};
use crate::check::{CheckedMotion, larger};
use crate::stability::number;

/// The divisors of the step, tried in turn: with larger steps errors may not fall as a power yet.
const DIVISORS: [u32; 3] = [1, 4, 16];

/// The rounding of an error of position, relative to the motion's extent: a tenth of the smallest one that
/// counts.
const ROUNDING: f64 = 1e-12;

/// A power that changes by less than this from step to step needs no finer steps.
const STEADY_POWER: f64 = 0.05;

/// The order of the errors of position, and the time up to which they were compared.
pub fn measured_order(motion: &CheckedMotion<'_>, remarks: &mut Vec<String>) -> (Order, f64) {
    let mut best = (Order::Unknown("no errors could be compared".to_owned()), f64::NAN);
    let mut steadiest = f64::INFINITY;
    let mut why = None;
    for parts in DIVISORS {
        let compared = match errors(motion, parts) {
            Ok(compared) => compared,
            Err(error) => {
                // with a shorter step the motion may be computed
                if best.1.is_nan() {
                    best.0 = Order::Unknown(error.to_string());
                }
                continue;
            }
        };
        let (times, [positions, ..], ended) = &*compared;
        let count = followed_nodes(&positions[FOLLOWING_HALVINGS]);
        let samples: Vec<Sample> = positions
            .iter()
            .enumerate()
            .map(|(halving, errors)| Sample {
                h: motion.h.abs() / f64::from(parts << halving),
                value: errors[..count]
                    .iter()
                    .fold(0.0, |most, &error| larger(most, error)),
                rounding: ROUNDING,
            })
            .collect();
        let (order, unsteadiness) = order_and_unsteadiness(&samples);
        if unsteadiness < steadiest || best.1.is_nan() {
            best = (order, times[count - 1]);
            steadiest = unsteadiness;
            why = ended.as_ref().map(ToString::to_string);
        }
        if steadiest < STEADY_POWER {
            break;
        }
    }
    if let Some(why) = why {
        remarks.push(format!(
            "errors are compared up to t = {}, since the continuous motion ends: {why}",
            number(best.1)
        ));
    }
    best
}

/// The second node by the paper's rule, `q1 = q0 + h v0`, against the motion: the order of its initial
/// velocity.
pub fn start(motion: &CheckedMotion<'_>) -> PartOrder {
    let found = expansions(motion, slice::from_ref(&motion.start));
    let expansion = match found.as_deref() {
        Ok([expansion, ..]) => expansion,
        other => {
            let reason = other.err().map_or_else(String::new, ToString::to_string);
            return PartOrder {
                part: Part::Start,
                order: Order::Unknown(reason),
                distance: f64::NAN,
            };
        }
    };
    let sample = |h: f64| {
        let increment = expansion.increment(h);
        let parts = increment.iter().zip(&motion.start.v);
        let [apart, size] = parts.fold([0.0_f64; 2], |[apart, size], (d, v)| {
            [apart.hypot(h * v - d), size.hypot(h * v).hypot(*d)]
        });
        Sample {
            h: h.abs(),
            value: if apart == 0.0 { 0.0 } else { apart / size },
            rounding: f64::EPSILON,
        }
    };
    let steps = (0..HALVINGS).map(|halving| LARGEST_STEP * expansion.reach * 0.5_f64.powi(halving));
    let samples: Vec<Sample> = steps.map(|h| sample(h.copysign(motion.h))).collect();
    PartOrder {
        part: Part::Start,
        order: order(&samples),
        distance: if motion.h.abs() <= expansion.reach {
            sample(motion.h).value
        } else {
            f64::NAN
        },
    }
}
