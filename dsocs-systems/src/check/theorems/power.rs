//! The energy balance: `dE/dt = ⟨Q + f, v⟩ − ∂L/∂t`, with the constraint force `Q` and the external forces
//! `f`.
//!
//! Along the continuous motion this is an identity, which tests the code of the energy against that of the
//! forces. Along the discrete one the energy at the nodes and the sum of `h` times the power differ by an
//! error of the step, whose order is fitted.

use dsocs_core::geometry::{Triple, discrete_power, mean_over, power};
use dsocs_core::{AnyPoint, Declaration, OwnedLeg};

use crate::check::motion::motions::{State, expansion, follow, less};
use crate::check::order::{
    CORNER_LOSS, DIVISORS, SCATTER, above_plateau, excuse, fitted_slope, with_finer_steps,
};
use crate::check::{CheckedMotion, Measured, Report, larger, largest};
use crate::entry::Motions;
use crate::stability::Bar;

/// The largest defect of the identity, relative to the energy's terms: the error of the series and the
/// quadrature.
const IDENTITY_DEFECT: f64 = 1e-11;

/// The number of steps, each half of the one before.
const HALVINGS: u32 = 6;

/// A defect below this part of the energy's terms may be rounding.
const PLATEAU: f64 = 1e-10;

/// The largest duration of the balance, in steps of the system.
const LONGEST_BALANCE: f64 = 2000.0;

/// Two jumps of the energy, with successive steps, are the same if they differ by less than this part.
const SAME_JUMP: f64 = 0.1;

/// The largest deficit of the order against the declared one.
const ORDER_DEFICIT: f64 = 0.1;

/// The continuous identity and the discrete balance.
pub fn balance(motion: &CheckedMotion<'_>, report: &mut Report) {
    let identity = largest(&motion.states, |state| {
        defect(motion.system, state, motion.h, &|point| {
            power(motion.kernel, point)
        })
    });
    report.push(
        "E − ∫(⟨Q + f, v⟩ − ∂L/∂t) dt along the continuous motion, relative to the terms",
        Bar::AtMost(IDENTITY_DEFECT),
        identity,
    );
    let of = (motion.h, motion.excuse().is_some());
    let is_too_long = || motion.followed_until().is_some();
    with_finer_steps(of, report, &is_too_long, &|parts, report| {
        discrete(motion, parts, report);
    });
}

/// The order of the discrete balance, with parts of the motion's step.
fn discrete(motion: &CheckedMotion<'_>, parts: u32, report: &mut Report) {
    let steps: Vec<f64> = (0..HALVINGS).map(|k| motion.h / f64::from(parts << k)).collect();
    let mut span = (motion.until - motion.start.t)
        .abs()
        .min(LONGEST_BALANCE * motion.h.abs());
    if motion.ended.is_some() {
        // just before the end of a motion, errors need not fall as a power of the step yet, and a smaller
        // step may end earlier
        span *= 0.75;
    }
    if let (true, Some(until)) = (parts > DIVISORS[1], motion.followed_until()) {
        span = span.min((until - motion.start.t).abs());
    }
    let measured: Measured<Vec<[f64; 2]>> = steps.iter().map(|&h| discrete_defect(motion, h, span)).collect();
    let defects = match measured {
        Ok(defects) => defects,
        Err(error) => {
            report.push("order of the discrete balance", Bar::Reported, Err(error));
            return;
        }
    };
    let points = steps
        .iter()
        .zip(&defects)
        .map(|(h, [missed, _])| [h.abs(), *missed]);
    let points: Vec<[f64; 2]> = points.collect();
    let fit = above_plateau(PLATEAU, points);
    let Some(points @ [[first, _], .., [least, _]]) = fit.as_deref() else {
        report.note("the discrete balance is met to rounding: no order is fitted");
        return;
    };
    let slope = fitted_slope(points);
    report.push(
        format!("slope of E − Σh(⟨Q + f, v⟩ − ∂L/∂t) between nodes, h = {first:.1e} to {least:.1e}"),
        Bar::AtLeast(motion.expected.order - ORDER_DEFICIT),
        Ok(slope),
    );
    // the order at a corner is lowered as that of the velocity
    excuse(
        motion,
        motion.expected.order - slope,
        SCATTER + CORNER_LOSS[1],
        report,
    );
    if let Some(last) = report.findings.last_mut().filter(|last| !last.holds())
        && let Some(jump) = jump(&defects)
    {
        last.excuse = Some(format!(
            "not required here: the energy jumps by {jump:.1e} of its terms within one step, however short it is, as that of an angle `y.atan2(x)` does on its \
             cut: the Lagrangian is not smooth along the motion. Where no force jumps there, the motion is right: its order tells"
        ));
    }
}

/// The jump of the energy in one step, relative to its terms, if it is the same with the two finest steps and
/// is most of the defect.
fn jump(defects: &[[f64; 2]]) -> Option<f64> {
    let [.., [_, before], [missed, jump]] = defects else {
        return None;
    };
    let is_one = *jump > 0.5 * missed && (jump - before).abs() < SAME_JUMP * jump;
    is_one.then_some(*jump)
}

/// The defect of a power against the change of the energy along a piece of the continuous motion from a
/// state, relative to the terms. The piece is a step, or shorter where the series does not reach.
fn defect(system: &dyn Motions, state: &State, h: f64, power: &dyn Fn(AnyPoint<'_, f64>) -> f64) -> Measured {
    let expansion = expansion(system, state)?;
    // a series knows its second derivative to fewer digits at its end
    let span = h.signum() * (0.5 * expansion.reach).min(h.abs());
    let sum = span * mean_over([0.0, span], &mut |s| power(expansion.point(s).any()));
    let declaration = Declaration::of(system.kernel());
    let [from, to] = [0.0, span].map(|s| {
        let point = expansion.point(s);
        let AnyPoint { t, q, v, .. } = point.any();
        let energy = declaration.energy(t, q, v);
        // E + L is the other term of the energy
        [energy, energy.abs() + 2.0 * declaration.lagrangian(t, q, v).abs()]
    });
    let terms = from[1] + to[1] + sum.abs();
    let missed = (to[0] - from[0] - sum).abs();
    Ok(if missed == 0.0 { 0.0 } else { missed / terms })
}

/// The largest difference between the change of the energy since the first node and the work of the power, by
/// the trapezoidal rule, relative to the energy's terms, over the discrete motion with the step `h` up to the
/// time `span`; and the largest change in one step.
fn discrete_defect(motion: &CheckedMotion<'_>, h: f64, span: f64) -> Measured<[f64; 2]> {
    let system = motion.kernel;
    let declaration = Declaration::of(system);
    let (mut before, mut last): (Option<OwnedLeg<f64>>, Option<[f64; 2]>) = (None, None);
    let (mut change, mut missed, mut terms) = (0.0, 0.0, 0.0);
    let (mut defect, mut jump): (f64, f64) = (0.0, 0.0);
    let mut first = 0.0;
    let (_, outcome) = follow(
        system,
        h,
        (&motion.start, motion.first),
        &mut |_, time, leg, _| {
            if let Some(middle) = before.take() {
                let e = less(leg.d, &middle.d);
                let triple = Triple { leg: middle, e };
                let point = declaration.point(h, triple.leg.any(), &triple.e);
                let AnyPoint { t, q, v, .. } = point.any();
                let energy = declaration.energy(t, q, v);
                let power = discrete_power(system, h, &triple);
                if let Some([_, earlier]) = last {
                    change += h * (earlier + power) / 2.0;
                    let now = energy - first - change;
                    missed = larger(missed, now.abs());
                    jump = larger(jump, (now - defect).abs());
                    defect = now;
                } else {
                    first = energy;
                }
                terms = larger(terms, energy.abs() + 2.0 * declaration.lagrangian(t, q, v).abs());
                last = Some([energy, power]);
            }
            before = Some(leg.to_owned());
            (time - motion.start.t).abs() < span
        },
    );
    outcome?;
    Ok([missed, jump].map(|missed| if missed == 0.0 { 0.0 } else { missed / terms }))
}

#[cfg(test)]
mod tests {
    use crate::entry::TypedSystem;
    use dsocs_core::{System, dsocs};

    use super::*;

    /// A system in which everything changes the energy: a drive in the Lagrangian, friction, and a moving
    /// constraint.
    #[dsocs {
        coordinates(x, y);
        lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - (1 + t.sin() / 2) * (x.powi(2) + y.powi(2)) / 2;
        holonomic = y - x * t.sin() / 2;
        external_forces = (-drag * dot(x), -drag * dot(y));
    }]
    struct Everything {
        drag: f64,
    }

    #[test]
    fn a_wrong_power_is_found() {
        let system = Everything { drag: 0.3 };
        let t = 0.7_f64;
        let (x, u) = (1.0, 0.4);
        let state = State {
            t,
            q: vec![x, x * t.sin() / 2.0],
            v: vec![u, u * t.sin() / 2.0 + x * t.cos() / 2.0],
            near: None,
            expansion: None,
        };
        let of = TypedSystem::new(&system);
        let motions: &dyn Motions = &of;
        let found = |power: &dyn Fn(AnyPoint<'_, f64>) -> f64| defect(motions, &state, 0.1, power).unwrap();
        let right = found(&|point| power(&system, point));
        assert!(right < 1e-14, "{right:e}");
        // each power lacks one term: the drive, the friction, the constraint's force
        let square = |x: &[f64]| x[0] * x[0] + x[1] * x[1];
        let drive = |point: AnyPoint<'_, f64>| point.t.cos() / 4.0 * square(point.q);
        let friction = |point: AnyPoint<'_, f64>| -0.3 * square(point.v);
        let constraint = |point: AnyPoint<'_, f64>| power(&system, point) - drive(point) - friction(point);
        let wrong = [
            found(&|point| power(&system, point) - drive(point)),
            found(&|point| power(&system, point) - friction(point)),
            found(&|point| power(&system, point) - constraint(point)),
        ];
        for wrong in wrong {
            assert!(wrong > 1e6 * IDENTITY_DEFECT, "{wrong:e}");
        }
        assert!((system.lagrangian(0.0, &[1.0, 0.0], &[0.0, 0.0]) + 0.5).abs() < 1e-15);
    }
}
