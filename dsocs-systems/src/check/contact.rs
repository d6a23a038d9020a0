//! How closely the discrete system touches the continuous one: its equations at nodes of the true motion.
//!
//! Three nodes `q(t − h), q(t), q(t + h)` of the continuous motion do not solve the discrete equations, and what is left falls with a
//! power of `h`: the order of contact. Of `L_d` it is that of the force `Q`, which does not see total derivatives (the literal
//! difference of `h L_d` from the action does). Nodes come from the Taylor series at `t`, so that their differences have all digits.

use dsocs_core::geometry::{Triple, constraint_force, constraint_multipliers, legendre_plus};
use dsocs_core::{AnyPoint, Declaration, OwnedLeg};

use super::order::{fitted, with_finer_steps};
use super::probe::series;
use super::{Measured, Report, Subject, larger};
use crate::stability::Bar;

/// Each of so many steps is half of the one before.
const HALVINGS: u32 = 6;

/// A row below this part of what it changes by with its last node is zero.
const ZERO: f64 = 1e-9;

/// A force below so many units of rounding of the momenta that it is a difference of is rounding.
const ROUNDING: f64 = 200.0 * f64::EPSILON;

/// A row that does not fall by this much is rounding.
const FALLS: f64 = 1.5;

/// What is left of a row at one state is faint below this part of what is left at another.
const FAINT: f64 = 1e-4;

/// At least so many steps tell an order, and the smallest so many at most: larger ones may be too large for a power law.
const TELLING: [usize; 2] = [3, 4];

/// How far the order may be below the declared one.
const BELOW: f64 = 0.1;

/// What is left of the equations, one figure for each step.
type Left = Vec<Vec<f64>>;

/// The orders of contact.
pub fn contact(subject: &Subject<'_>, report: &mut Report) {
    with_finer_steps(subject, report, fit);
}

/// The orders, by steps that are parts of the subject's.
fn fit(subject: &Subject<'_>, parts: u32, report: &mut Report) {
    let groups = match measure(subject, parts) {
        Ok(groups) => groups,
        Err(error) => {
            report.push("of L_d, on the true motion", Bar::Reported, Err(error));
            return;
        }
    };
    let names = [
        "of L_d: Q at nodes of the true motion against the true Q",
        "of D_K: constraints at nodes of the true motion",
        "of D_V: works of Q along virtual displacements there",
    ];
    let bar = Bar::AtLeast(subject.expected.order - BELOW);
    for (name, rows) in names.into_iter().zip(groups) {
        // rows that hold exactly have no order
        let slopes = rows
            .iter()
            .filter_map(|errors| slope(&subject.steps(parts), errors));
        let least = slopes.reduce(|least, slope| if slope < least { slope } else { least });
        if let Some(least) = least {
            report.push(name, bar, Ok(least));
        }
    }
}

impl Subject<'_> {
    /// The steps at which contact is measured.
    fn steps(&self, parts: u32) -> Vec<f64> {
        (0..HALVINGS)
            .map(|k| 0.5 * self.h.abs() / f64::from(parts << k))
            .collect()
    }
}

/// The slope of what is left of a row, where it falls longest: with larger steps two powers may cancel, with smaller ones it is rounding. `None` if it is
/// rounding too soon.
fn slope(steps: &[f64], errors: &[f64]) -> Option<f64> {
    let [least, most] = TELLING;
    let known = errors.iter().take_while(|error| **error != 0.0).count();
    if known < least {
        return None;
    }
    let falls = |place: usize| errors[place] > FALLS * errors[place + 1];
    let mut longest = 0..least;
    let mut from = 0;
    for place in 0..known - 1 {
        if !falls(place) {
            from = place + 1;
        } else if place + 2 - from >= longest.len() {
            longest = from..place + 2;
        }
    }
    let points: Vec<[f64; 2]> = steps.iter().zip(errors).map(|(h, error)| [*h, *error]).collect();
    Some(fitted(
        &points[longest.end.saturating_sub(most).max(longest.start)..longest.end],
    ))
}

/// The rows that tell an order: what a row leaves at one state counts if it is not far below what it leaves at another.
fn telling(states: &[Left]) -> Left {
    let largest = |row: usize| {
        let first = states.iter().filter_map(|rows| rows.get(row)?.first().copied());
        first.fold(0.0, larger)
    };
    let rows = states.iter().flat_map(|rows| rows.iter().enumerate());
    rows.filter(|(row, errors)| errors[0] > FAINT * largest(*row))
        .map(|(_, errors)| errors.clone())
        .collect()
}

/// What is left of `Q`, of the constraints and of the works, each as rows with a figure for each step.
fn measure(subject: &Subject<'_>, parts: u32) -> Measured<[Left; 3]> {
    let mut groups: [Vec<Left>; 3] = Default::default();
    for state in &subject.states {
        let (series, reach) = series(subject.system, state)?;
        let (Some(q), Some(v), Some(half)) = (series.first(), series.get(1), series.get(2)) else {
            continue;
        };
        let a: Vec<f64> = half.iter().map(|half| 2.0 * half).collect();
        let (t, a) = (state.t, a.as_slice());
        let force = constraint_force(subject.kernel, AnyPoint { t, q, v, a });
        let factor = (reach / (0.5 * subject.h.abs() / f64::from(parts))).min(1.0);
        let mut rows: [Left; 3] = Default::default();
        for (k, step) in subject.steps(parts).iter().enumerate() {
            let h = subject.h.signum() * step * factor;
            let triple = about(state.t, &series, h);
            let (found, sizes) = left(subject, h, &triple, &force);
            let momenta = legendre_plus(subject.kernel, h, triple.leg.any());
            let rounding = ROUNDING * momenta.iter().fold(0.0, |most, x| larger(most, x.abs()));
            // constraints are no differences of momenta
            let noise = [rounding, 0.0, rounding];
            for (group, rows) in rows.iter_mut().enumerate() {
                rows.resize(found[group].len(), Vec::new());
                let size = sizes[group].iter().fold(0.0, |size, &x| larger(size, x));
                for (row, found) in rows.iter_mut().zip(&found[group]) {
                    let is_zero = (k == 0 && found.abs() <= ZERO * size) || found.abs() <= noise[group];
                    row.push(if is_zero { 0.0 } else { found.abs() });
                }
            }
        }
        for (group, rows) in groups.iter_mut().zip(rows) {
            group.push(rows);
        }
    }
    Ok(groups.map(|states| telling(&states)))
}

/// The triple of three nodes of a motion about a point, at the time `t`, from its series there.
pub fn about(t: f64, series: &[Vec<f64>], h: f64) -> Triple {
    let at = |power: &dyn Fn(usize) -> f64| -> Vec<f64> {
        let mut sum = vec![0.0; series.first().map_or(0, Vec::len)];
        for (k, coefficient) in series.iter().enumerate().skip(1).rev() {
            let power = power(k);
            for (sum, c) in sum.iter_mut().zip(coefficient) {
                *sum += c * power;
            }
        }
        sum
    };
    let power = |k: usize| h.powi(i32::try_from(k).unwrap_or(i32::MAX));
    let leg = OwnedLeg {
        t,
        q: series.first().cloned().unwrap_or_default(),
        d: at(&|k| if k % 2 == 0 { -power(k) } else { power(k) }),
    };
    let e = at(&|k| if k % 2 == 0 { 2.0 * power(k) } else { 0.0 });
    Triple { leg, e }
}

/// What is left at a triple of the true motion, and how large it would be at another one.
fn left(subject: &Subject<'_>, h: f64, triple: &Triple, force: &[f64]) -> ([Vec<f64>; 3], [Vec<f64>; 3]) {
    let declaration = Declaration::of(subject.kernel);
    let [holonomic, nonholonomic, kinematic] = subject.constraints();
    let constraints = holonomic + nonholonomic + kinematic;
    let rows = |triple: &Triple| {
        let multipliers = constraint_multipliers(subject.kernel, h, triple);
        let forces = declaration.force(h, triple.leg.any(), &triple.e);
        let forces = forces.iter().zip(force).map(|(q, force)| q - force).collect();
        let mut constraint = declaration.declared(h, triple.leg.any(), &triple.e, &multipliers);
        let works = constraint.split_off(constraints.min(constraint.len()));
        constraint.drain(..holonomic.min(constraint.len()));
        let works = if constraints == 0 { Vec::new() } else { works };
        [forces, constraint, works]
    };
    let found: [Vec<f64>; 3] = rows(triple);
    let mut sizes = found.clone().map(|rows| vec![0.0; rows.len()]);
    // component by component: along the second difference itself the constraints of a straight motion need not change
    for i in 0..triple.e.len() {
        let mut e = triple.e.clone();
        e[i] *= 1.001;
        let moved = rows(&Triple {
            leg: triple.leg.clone(),
            e,
        });
        for ((sizes, moved), found) in sizes.iter_mut().zip(&moved).zip(&found) {
            for ((size, moved), found) in sizes.iter_mut().zip(moved).zip(found) {
                *size = larger(*size, 1e3 * (moved - found).abs());
            }
        }
    }
    (found, sizes)
}
