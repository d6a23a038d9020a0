//! The evolution of the symplectic form, discrete and continuous.

use dsocs_core::geometry::{
    DiscreteFlow, Displacement, Evolution, GeometryError, Triple, moved, pair_displacements, pieces,
    state_displacements,
};
use dsocs_core::{AnyLeg, AnyPoint, Declaration, Regularity};

use super::continuous;
use crate::check::{CheckedMotion, Measured, Report, larger, largest};
use crate::entry::Kind;
use crate::stability::Bar;

/// The largest defect of `F*Ω = Ω + dξ`, relative to its terms.
const LARGEST_DEFECT: f64 = 1e-13;

/// A defect of this many roundings, times the condition number of `D₃`, is rounding: the tangent map solves
/// linear equations with this matrix, and has no smaller error (N. J. Higham, *Accuracy and Stability of
/// Numerical Algorithms*, 2nd ed., section 7.1).
const ROUNDINGS: f64 = 8.0;

/// The largest `dξ`, relative to the terms of the law, where it has to be zero.
const LARGEST_ZERO: f64 = 1e-11;

/// The largest distance of the tangent map from its difference quotients.
const QUOTIENT_DISTANCE: f64 = 1e-7;

/// The largest defect of the continuous law, relative to its terms: the error of the quadrature.
const QUADRATURE_ERROR: f64 = 1e-9;

/// The smallest `dξ`, relative to the terms, that counts as nonzero: rounding is far below.
const SMALLEST_NONZERO: f64 = 1e-8;

/// A force whose work along a displacement is below this part of its terms does no work.
const NO_WORK: f64 = 1e-9;

/// `dξ` has to be nonzero where `dν` is larger than this part of the terms.
const CHANGED_FORM: f64 = 1e-5;

/// The duration of the continuous law from a state, in steps.
const LAW_STEPS: f64 = 10.0;

/// The shifts of nodes in difference quotients, in legs; the best one counts. Where the motion crosses a
/// switch it is a small one, else a larger one, and where the motion begins at rest, with legs that are
/// hardly more than the rounding of positions, the largest.
const NODE_SHIFTS: [f64; 6] = [1e-2, 1e-3, 1e-4, LEAST_SHIFT, 1e-1, 1.0];
const LEAST_SHIFT: f64 = 1e-5;

/// Difference quotients have nodes at up to this many shifts.
const SHIFTS: f64 = 3.0;

/// A leg below this part of the position is rounding.
const RESTING_LEG: f64 = 1e4 * f64::EPSILON;

/// A coordinate stands still if its leg is shorter than this part of the norm of both legs.
const STANDING_STILL: f64 = 1e-3;

/// `F*Ω = Ω + dξ`, each term by itself: an identity, whatever the map.
pub fn identity(motion: &CheckedMotion<'_>, report: &mut Report) {
    let (mut count, mut rounding) = (0, 0.0);
    let (mut fast, mut known) = (0, 0.0);
    let defect = largest(&motion.triples, |triple| {
        let law = Evolution::of(&motion.flow, triple)?;
        let defect = law.defect();
        if defect <= LARGEST_DEFECT {
            return Ok(defect);
        }
        let condition = Regularity::of(motion.kernel, motion.h, triple.leg.any(), &triple.e).condition();
        if defect <= ROUNDINGS * f64::EPSILON * condition {
            (count, rounding) = (count + 1, larger(rounding, defect));
            return Ok(0.0);
        }
        let of_terms = ROUNDINGS * law.rounding(&motion.flow, triple);
        if defect <= of_terms {
            (fast, known) = (fast + 1, larger(known, of_terms));
            return Ok(0.0);
        }
        Ok(defect)
    });
    report.push(
        "F*Ω − Ω − dξ, relative to the terms",
        Bar::AtMost(LARGEST_DEFECT),
        defect,
    );
    if count > 0 {
        report.note(&format!(
            "{count} of these triples are left out: there D₃ is so nearly singular that what is missed, up to {rounding:.0e}, is rounding"
        ));
    }
    if fast > 0 {
        report.note(&format!(
            "{fast} of these triples are left out: there the terms themselves change by up to {known:.0e} with the last digits of the time, the positions and the velocities, and what \
             is missed is no more"
        ));
    }
}

/// Whether forces of holonomic constraints do no work along allowed displacements, at the states of the
/// motion: friction in proportion to them does.
fn are_ideal(motion: &CheckedMotion<'_>) -> bool {
    if motion.constraints()[1..] != [0, 0] {
        return true;
    }
    let declaration = Declaration::of(motion.kernel);
    motion.states.iter().all(|state| {
        let a = vec![0.0; state.q.len()];
        let forms = declaration.continuous_forms::<f64>(AnyPoint {
            t: state.t,
            q: &state.q,
            v: &state.v,
            a: &a,
        });
        let allowed = state_displacements(motion.kernel, state.t, &state.q, &state.v);
        allowed.iter().all(|displacement| {
            forms.iter().all(|form| {
                let works = form.iter().zip(&displacement.first).map(|(form, by)| form * by);
                let (work, size) = works.fold((0.0, 0.0), |(work, size): (f64, f64), x| {
                    (work + x, size + x.abs())
                });
                work.abs() <= NO_WORK * size
            })
        })
    })
}

/// The change of the symplectic form by the constraints, discrete and continuous, and the tangent map.
pub fn law(motion: &CheckedMotion<'_>, report: &mut Report) {
    let change = largest(&motion.triples, |triple| {
        let law = Evolution::of(&motion.flow, triple)?;
        let allowed = pair_displacements(motion.kernel, motion.h, triple.leg.any());
        Ok(law.change_on(&allowed))
    });
    // where steps are ill-conditioned, as on a switch, a difference quotient does not show the derivative
    let (mut rounding_of_positions, has_large_numbers) =
        (0.0, motion.large_numbers.relative_error().is_some());
    let mut at_an_edge = 0;
    let tangent = largest(&motion.early, |triple| {
        let law = Evolution::of(&motion.flow, triple)?;
        let [apart, rounding] = quotient(&motion.flow, triple, &law, has_large_numbers)?;
        rounding_of_positions = larger(rounding_of_positions, rounding);
        if apart > QUOTIENT_DISTANCE && meets_an_edge(motion, triple) {
            at_an_edge += 1;
            return Ok(0.0);
        }
        Ok(apart)
    });
    let window = LAW_STEPS * motion.h;
    let laws: Vec<Measured<[f64; 2]>> = motion
        .states
        .iter()
        .map(|state| continuous::law(motion.system.kernel(), state, window))
        .collect();
    let stiff = laws.iter().skip(1).filter(|law| law.is_err()).count();
    // an error at the start counts; at later states the law may be too stiff for the quadrature
    let mut continuous: Measured<[f64; 2]> = Ok([0.0; 2]);
    for (k, law) in laws.into_iter().enumerate() {
        match (law, &mut continuous) {
            (Ok([missed, change]), Ok(laws)) => *laws = [larger(laws[0], missed), larger(laws[1], change)],
            (Err(error), continuous) if k == 0 => *continuous = Err(error),
            _ => {}
        }
    }
    let d_nu = continuous.as_ref().map_or(0.0, |laws| laws[1]);
    let is_symplectic = matches!(motion.expected.kind, Kind::Unconstrained | Kind::Holonomic)
        && !motion.kernel.shape().external_forces
        && are_ideal(motion);
    let discrete = match (is_symplectic, d_nu) {
        (true, _) => Bar::AtMost(LARGEST_ZERO),
        // where the constraints change the form of the continuous motion they change the discrete one, too
        (false, change) if change > CHANGED_FORM => Bar::AtLeast(SMALLEST_NONZERO),
        _ => Bar::Reported,
    };
    report.push(
        "dξ along the pairs of nodes that are allowed, relative to the terms",
        discrete,
        change,
    );
    // with all steps left out nothing was compared
    let none_is_left = at_an_edge > 0 && at_an_edge == motion.early.len();
    report.push(
        "TF against differences of the first steps",
        Bar::AtMost(QUOTIENT_DISTANCE),
        if none_is_left { Ok(f64::NAN) } else { tangent },
    );
    if at_an_edge > 0 {
        report.note(&format!(
            "{at_an_edge} of {} steps are left out, at which a piecewise function, such as `max`, changes its piece: a step has no derivative there",
            motion.early.len()
        ));
    }
    if rounding_of_positions > 0.0 {
        report.note(&format!(
            "columns are left out in which nodes that are moved as far as a leg tell a slope to {rounding_of_positions:.0e} only, by the rounding of the positions"
        ));
    }
    let whats = [
        (
            "continuous: (Fᵗ)*Ω_L − Ω_L − dν, relative to the terms",
            Bar::AtMost(QUADRATURE_ERROR),
        ),
        (
            "continuous: dν on the states that are allowed, relative to the terms",
            if is_symplectic {
                Bar::AtMost(LARGEST_ZERO)
            } else {
                Bar::Reported
            },
        ),
    ];
    report.push_all(whats, &continuous);
    let states = motion.states.len();
    report.note(&format!(
        "the continuous law is integrated over {LAW_STEPS} steps each from {} of {states} states of the motion{}",
        states - stiff,
        if stiff > 0 {
            ": elsewhere it is too stiff for the quadrature"
        } else {
            ""
        }
    ));
}

/// The size of both legs, of which the first is zero where a force begins to act on a body at rest, and the size below which they are at rest.
fn sizes(triple: &Triple, last: &[f64]) -> [f64; 2] {
    let legs = triple.leg.d.iter().chain(last);
    let farthest = triple.leg.q.iter().fold(0.0, |most, q| larger(most, q.abs()));
    [
        legs.fold(0.0, |size: f64, d| size.hypot(*d)),
        RESTING_LEG * farthest,
    ]
}

/// Whether two pieces of a function meet at the nodes of a triple or in the middle between them, or so close by that the smallest shifts of
/// nodes in difference quotients reach beyond.
fn meets_an_edge(motion: &CheckedMotion<'_>, triple: &Triple) -> bool {
    let (kernel, h) = (motion.kernel, motion.h);
    let last = triple.last(h);
    let legs = [
        (triple.leg.t, &triple.leg.q, &triple.leg.d),
        (last.t, &last.q, &last.d),
    ];
    let [size, resting] = sizes(triple, &last.d);
    let shift = SHIFTS * LEAST_SHIFT * larger(size, resting);
    legs.into_iter().any(|(t, q, d)| {
        [0.0, 0.5, 1.0].into_iter().any(|back| {
            let back_by: Vec<f64> = d.iter().map(|d| -back * d).collect();
            let q = moved(kernel, q, &back_by);
            let v: Vec<f64> = d.iter().map(|d| d / h).collect();
            let t = t - back * h;
            let here = pieces(kernel, (t, &q, &v, &vec![0.0; d.len()]));
            let beside = |i: usize, by: f64| {
                let mut unit = vec![0.0; d.len()];
                unit[i] = by;
                let faster: Vec<f64> = v.iter().zip(&unit).map(|(v, by)| v + 2.0 * by / h).collect();
                let places = [(moved(kernel, &q, &unit), v.clone()), (q.clone(), faster)];
                places.map(|(q, v)| pieces(kernel, (t, &q, &v, &vec![0.0; d.len()])))
            };
            let mut all = (0..d.len()).flat_map(|i| [(i, shift), (i, -shift)]);
            here.is_none() || all.any(|(i, by)| beside(i, by).iter().any(|pieces| *pieces != here))
        })
    })
}

/// The distance of the tangent map from difference quotients of the step, of sixth order, relative to the
/// slopes of a coordinate; and that in columns where it is rounding, because positions are large beside the
/// shifts of the nodes.
///
/// # Errors
///
/// [`GeometryError`] if none of the moved steps along a coordinate has a solution.
fn quotient(
    flow: &DiscreteFlow<'_>,
    triple: &Triple,
    law: &Evolution,
    has_large_numbers: bool,
) -> Result<[f64; 2], GeometryError> {
    let last = triple.last(flow.h()).d;
    let [size, resting] = sizes(triple, &last);
    // at rest to rounding, as on an unstable equilibrium
    let size = if size <= resting { flow.h().abs() } else { size };
    let (mut apart, mut rounding_of_positions) = (0.0, 0.0);
    let place = triple.leg.q.iter().fold(0.0, |most, q| larger(most, q.abs()));
    let n = last.len();
    for k in 0..2 * n {
        let unit = Displacement::unit(n, k);
        let own = triple.leg.d[k % n].abs().max(last[k % n].abs());
        let length = if own > STANDING_STILL * size {
            own
        } else {
            STANDING_STILL * size
        };
        let exact = law.tangent.apply(&unit).second;
        let (mut best, mut without) = (f64::INFINITY, None);
        for moved in NODE_SHIFTS {
            // a shifted step may have no solution, as near a turning point; other shifts are tried
            let found = match slopes(flow, triple, &unit, &exact, moved * length) {
                Ok(found) => found,
                Err(error) => {
                    without = Some(error);
                    continue;
                }
            };
            let relative = (0..n).map(|i| {
                let row = law.tangent.by_first[i].iter().chain(&law.tangent.by_second[i]);
                let scale = row.fold(0.0_f64, |scale, x| scale.max(x.abs()));
                (found[i] - exact[i]).abs() / scale
            });
            let worst = relative.fold(0.0, larger);
            best = if worst < best { worst } else { best };
        }
        match without {
            Some(error) if best.is_infinite() => return Err(error),
            _ if has_large_numbers
                && best > QUOTIENT_DISTANCE
                && best <= ROUNDINGS * f64::EPSILON * place / length =>
            {
                rounding_of_positions = larger(rounding_of_positions, best);
            }
            _ => apart = larger(apart, best),
        }
    }
    Ok([apart, rounding_of_positions])
}

/// The difference quotients of `q2` along a displacement, with nodes shifted by `shift` and its multiples.
fn slopes(
    flow: &DiscreteFlow<'_>,
    triple: &Triple,
    unit: &Displacement,
    exact: &[f64],
    shift: f64,
) -> Result<Vec<f64>, GeometryError> {
    let (leg, q2) = (&triple.leg, triple.last(flow.h()).q);
    let mut slopes = vec![0.0; q2.len()];
    for (times, weight) in [(1.0, 0.75), (2.0, -0.15), (3.0, 1.0 / 60.0)] {
        for sign in [1.0, -1.0] {
            let shift = sign * times * shift;
            let by = |x: &[f64], part: &dyn Fn(usize) -> f64| -> Vec<f64> {
                x.iter().enumerate().map(|(i, x)| x + shift * part(i)).collect()
            };
            let moved = AnyLeg {
                t: leg.t,
                q: &by(&leg.q, &|i| unit.second[i]),
                d: &by(&leg.d, &|i| unit.second[i] - unit.first[i]),
            };
            // the guess selects the solution nearby, which does not depend on the guess
            let e = by(&triple.e, &|i| exact[i] - 2.0 * unit.second[i] + unit.first[i]);
            let found = flow.forward_near(moved, &e)?.last(flow.h()).q;
            for (slope, (found, q2)) in slopes.iter_mut().zip(found.iter().zip(&q2)) {
                *slope += sign * weight * (found - q2);
            }
        }
    }
    Ok(slopes.iter().map(|slope| slope / shift).collect())
}
