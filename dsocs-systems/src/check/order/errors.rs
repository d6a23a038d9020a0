//! The errors of a motion against the Taylor flow, without what is rounding.

use core::fmt;
use std::error::Error;
use std::rc::Rc;

use dsocs_core::geometry::{
    Triple, constraint_force, constraint_multipliers, continuous_multipliers, legendre_plus, multipliers_of,
    roundings,
};
use dsocs_core::{Declaration, Kernel, RunError};

use super::finer_steps::DIVISORS;
use crate::check::motion::motions;
use crate::check::{CheckedMotion, Measured, larger};
use crate::entry::Kind;

/// The rounding of a force, in roundings of the momentum of a leg over its step.
const ROUNDINGS: f64 = 8.0;

/// An error of velocities, forces or multipliers below this part of their scale may be rounding, and is left
/// out of the fit: they are quotients of differences of nodes.
pub const PLATEAU_OF_QUOTIENTS: f64 = 1e-8;

/// The number of steps, each half of the one before.
pub const HALVINGS: u32 = 6;

/// The largest number of steps over which errors are taken: more add nothing to the order, and the finest
/// steps are 32 times as many.
pub const MOST_STEPS: usize = 20_000;

/// The largest number of nodes at which errors are taken.
const MOST_NODES: usize = 2000;

/// The tolerance of the continuous motion.
pub const TOLERANCE: f64 = 1e-15;

/// The largest error of the largest step, relative to the motion's extent, up to which the motion is
/// followed.
pub const FOLLOWED_ERROR: f64 = 0.02;

/// A small part of the window is less than one over this number.
const SMALL_PART: usize = 8;

/// The number of halvings of the step that has to follow the motion: the largest one in the fit, if all
/// errors are above rounding.
pub const FOLLOWING_HALVINGS: usize = 2;

/// Errors by quantity, step and node, each relative to the component's scale.
pub type Errors = [Vec<Vec<f64>>; 4];

/// Times, the errors there of every quantity with every step, and why the continuous motion ended, if it did.
pub type Compared = (Vec<f64>, Errors, Option<RunError>);

/// The errors of every quantity with each of the halved steps, of which the first is the motion's step
/// divided by `finest`. With `finest = 1` they are computed once and kept, since several checks need them.
pub fn errors(motion: &CheckedMotion<'_>, finest: u32) -> Measured<Rc<Compared>> {
    if finest != 1 {
        return compare(motion, finest).map(Rc::new);
    }
    let own = || {
        compare(motion, 1)
            .map(Rc::new)
            .map_err(|error| Shared(error.into()))
    };
    Ok(motion.errors.get_or_init(own).clone()?)
}

/// An error that several figures have in common.
#[derive(Clone)]
pub struct Shared(Rc<dyn Error>);

dsocs_core::debug_is_message!(Shared);

impl fmt::Display for Shared {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl Error for Shared {
    fn source(&self) -> Option<&(dyn Error + 'static)> {
        Some(&*self.0)
    }
}

fn compare(motion: &CheckedMotion<'_>, finest: u32) -> Measured<Compared> {
    let h = motion.h;
    let steps = match motion.followed_until.get() {
        Some(Some(until)) if finest > DIVISORS[1] => steps_to(motion, *until),
        _ => motion.legs.len().saturating_sub(1).clamp(2, MOST_STEPS),
    };
    let part = u32::try_from(steps.div_ceil(MOST_NODES))?;
    let count = steps / part as usize;
    let mut times: Vec<f64> = (1..=count)
        .map(|k| motion.start.t + (k as f64 * f64::from(part)) * h)
        .collect();
    let (exact, ended) = motions::continuous_to_its_end(motion.system, h, &motion.start, &times, TOLERANCE)?;
    // just before the end of a motion, errors need not fall as a power of the step yet
    let count = match &ended {
        Some(_) => exact.len() * 3 / 4,
        None => exact.len(),
    };
    times.truncate(count);
    if let (0, Some(ended)) = (count, &ended) {
        return Err(ended.clone().into());
    }
    let system = motion.kernel;
    let constrained = motion.expected.kind != Kind::Unconstrained;
    let truth: Vec<[Vec<f64>; 4]> = exact
        .iter()
        .take(count)
        .map(|point| {
            let point = point.any();
            let [mut force, mut multipliers] = [Vec::new(), Vec::new()];
            if constrained {
                force = constraint_force(system, point);
                multipliers = continuous_multipliers(system, point);
            }
            [point.q.to_vec(), point.v.to_vec(), force, multipliers]
        })
        .collect();
    let scales: [Vec<f64>; 4] = core::array::from_fn(|k| scales(k, &truth, &motion.start.q));
    let has_large_numbers = motion.large_numbers.relative_error().is_some();
    let mut errors: Errors = Default::default();
    for halving in 0..HALVINGS {
        let parts = finest << halving;
        let h = h / f64::from(parts);
        let nodes = motions::nodes(
            motion.kernel,
            h,
            (&motion.start, motion.first),
            (part * parts, count),
        )?;
        let mut found: [Vec<f64>; 4] = Default::default();
        for (node, truth) in nodes.iter().zip(&truth) {
            let declaration = Declaration::of(system);
            let values = [
                node.leg.q.clone(),
                declaration.point(h, node.leg.any(), &node.e).any().v.to_vec(),
                if truth[2].is_empty() {
                    Vec::new()
                } else {
                    declaration.force(h, node.leg.any(), &node.e)
                },
                if truth[3].is_empty() {
                    Vec::new()
                } else {
                    constraint_multipliers(system, h, node)
                },
            ];
            // a force is the difference of two momenta over a step
            let momenta = legendre_plus(system, h, node.leg.any());
            // the rounding of the forces changes velocities and positions as a force does
            let moves = roundings(system, h, node);
            let steps = ((node.leg.t - motion.start.t) / h).abs();
            for (k, (values, truth)) in values.iter().zip(truth).enumerate() {
                if values.is_empty() {
                    continue;
                }
                // a bound that adds all roundings with one sign would leave no error where the time is large:
                // there the fit finds the rounding
                let worst = if has_large_numbers { 0.0 } else { ROUNDINGS };
                let moved = |i: usize| worst * moves.get(i).copied().unwrap_or(0.0);
                let rounding = |i: usize| match k {
                    0 => moved(i) * steps * steps / 2.0,
                    1 => moved(i) * steps / h.abs(),
                    2 => ROUNDINGS * f64::EPSILON * momenta.get(i).map_or(0.0, |momentum| momentum.abs()),
                    _ => 0.0,
                };
                let apart = values.iter().zip(truth).zip(&scales[k]).enumerate();
                let relative = apart.map(|(i, ((value, truth), scale))| {
                    let apart = (value - truth).abs();
                    if apart <= rounding(i) { 0.0 } else { apart / scale }
                });
                found[k].push(relative.fold(0.0, larger));
            }
        }
        zero_rounding((system, h, has_large_numbers), &nodes, &mut found, &scales);
        for (errors, found) in errors.iter_mut().zip(found) {
            errors.push(found);
        }
    }
    Ok((times, errors, ended))
}

/// Sets errors that are rounding to zero: of forces, where positions or times are large, and of multipliers.
fn zero_rounding(
    (system, h, has_large_numbers): (&dyn Kernel, f64, bool),
    nodes: &[Triple],
    found: &mut [Vec<f64>; 4],
    scales: &[Vec<f64>; 4],
) {
    let [.., forces, of_multipliers] = found;
    let mut of_forces = 0.0;
    for node in nodes.iter().filter(|_| has_large_numbers) {
        let momenta = legendre_plus(system, h, node.leg.any());
        for (i, (momentum, scale)) in momenta.iter().zip(&scales[2]).enumerate() {
            let rounding = ROUNDINGS * f64::EPSILON * momentum.abs();
            of_forces = larger(of_forces, rounding_factor(node, h, i) * rounding / scale);
        }
    }
    for error in forces.iter_mut().filter(|error| **error <= of_forces) {
        *error = 0.0;
    }
    let largest = of_multipliers.iter().enumerate();
    if let Some((place, largest)) = largest.max_by(|(_, one), (_, other)| one.total_cmp(other))
        && *largest > PLATEAU_OF_QUOTIENTS
    {
        let rounding = multiplier_rounding(system, h, &nodes[place], &scales[3], has_large_numbers);
        for error in of_multipliers.iter_mut().filter(|error| **error <= rounding) {
            *error = 0.0;
        }
    }
}

/// The number of steps up to a time, at least two.
fn steps_to(motion: &CheckedMotion<'_>, until: f64) -> usize {
    let times = motion.legs.iter().map(|leg| (leg.t - motion.start.t).abs());
    times
        .take_while(|t| *t <= (until - motion.start.t).abs())
        .count()
        .clamp(2, MOST_STEPS)
}

/// The rounding of multipliers at a triple of nodes, in units of their scales: it comes from that of the
/// force, which is that of momenta over a step.
fn multiplier_rounding(
    system: &dyn Kernel,
    h: f64,
    node: &Triple,
    scales: &[f64],
    has_large_numbers: bool,
) -> f64 {
    let momenta = legendre_plus(system, h, node.leg.any());
    let mut all = vec![0.0; scales.len()];
    for (i, momentum) in momenta.iter().enumerate() {
        let mut force = vec![0.0; momenta.len()];
        let known = if has_large_numbers {
            rounding_factor(node, h, i)
        } else {
            1.0
        };
        force[i] = ROUNDINGS * f64::EPSILON * known * momentum.abs();
        let multipliers = multipliers_of(system, h, node, &force);
        for (all, multiplier) in all.iter_mut().zip(multipliers) {
            *all += multiplier.abs();
        }
    }
    let relative = all.iter().zip(scales).map(|(all, scale)| all / scale);
    relative.fold(0.0, larger)
}

/// The factor by which the rounding of a momentum is larger than that of its own digits, where constraints
/// hold positions: that of the position relative to a leg, and of the time relative to a step.
fn rounding_factor(node: &Triple, h: f64, i: usize) -> f64 {
    let component = |x: &[f64]| x.get(i).map_or(0.0, |x| x.abs());
    let (q, d) = (component(&node.leg.q), component(&node.leg.d));
    if d > 0.0 {
        1.0 + q / d + (node.leg.t / h).abs()
    } else {
        1.0
    }
}

/// The scale of each component of a quantity: its largest value, and for positions the largest distance from
/// the start.
fn scales(k: usize, truth: &[[Vec<f64>; 4]], q0: &[f64]) -> Vec<f64> {
    let components = truth.first().map_or(0, |truth| truth[k].len());
    let extent = |i: usize| {
        let from = if k == 0 { q0[i] } else { 0.0 };
        truth
            .iter()
            .map(|truth| (truth[k][i] - from).abs())
            .fold(0.0, larger)
    };
    moving_extents((0..components).map(extent).collect())
}

/// The extents of components; one that stands still has that of the component that moves most.
pub fn moving_extents(extents: Vec<f64>) -> Vec<f64> {
    let most = extents.iter().fold(0.0, |most, &x| larger(most, x));
    let own = extents.into_iter();
    own.map(|extent| if extent > 1e-3 * most { extent } else { most })
        .collect()
}

/// The number of nodes over which the largest step follows the motion, at least two.
pub fn followed_nodes(errors: &[f64]) -> usize {
    let lost = errors
        .iter()
        .position(|error| error.is_nan() || *error > FOLLOWED_ERROR);
    lost.unwrap_or(errors.len()).max(2).min(errors.len())
}

/// The time up to which the step follows the motion, if it is a small part of the window.
pub fn followed_until(motion: &CheckedMotion<'_>) -> Option<f64> {
    let compared = errors(motion, 1).ok()?;
    let (times, errors, _) = &*compared;
    let last = followed_nodes(&errors[0][FOLLOWING_HALVINGS]);
    (last * SMALL_PART <= times.len()).then(|| times[last - 1])
}
