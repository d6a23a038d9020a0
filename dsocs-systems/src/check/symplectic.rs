//! How the symplectic form evolves, discretely and continuously.

use dsocs_core::geometry::{
    DiscreteFlow, Displacement, Evolution, GeometryError, Triple, pair_displacements, state_displacements,
};
use dsocs_core::{AnyLeg, AnyPoint, Declaration, Regularity};

use super::{Measured, Report, Subject, continuous, larger, largest};
use crate::entry::Kind;
use crate::stability::Bar;

/// `F*Ω = Ω + dξ` may be missed by this much, relative to its terms.
const LAW: f64 = 1e-13;

/// A defect of so many roundings, times the condition of `D₃`, is rounding: the tangent map is the solution of linear equations with this matrix, and is known
/// to no more (N. J. Higham, *Accuracy and Stability of Numerical Algorithms*, 2nd ed., section 7.1).
const ROUNDINGS: f64 = 8.0;

/// `dξ` may be this large, relative to the terms of the law, where it has to be zero.
const ZERO: f64 = 1e-11;

/// The tangent map may be off its difference quotients by this much.
const QUOTIENT: f64 = 1e-7;

/// The continuous law may be missed by this much, relative to its terms: what the quadrature leaves.
const QUADRATURE: f64 = 1e-9;

/// `dξ` is seen if it is larger than this part of the terms: rounding is far below.
const SEEN: f64 = 1e-8;

/// A force that works less than this part of its terms along a displacement does no work.
const IDEAL: f64 = 1e-9;

/// It has to be seen where `dν` is larger than this part of them.
const CHANGED: f64 = 1e-5;

/// The continuous law is integrated over so many steps from a state.
const PIECE: f64 = 10.0;

/// How far nodes are moved for difference quotients, in legs. Where the motion crosses a switch the smaller ones are right, else
/// the larger ones, and where it begins at rest, with legs that are hardly more than the rounding of positions, the largest: the best of them counts.
const MOVED: [f64; 6] = [1e-2, 1e-3, 1e-4, 1e-5, 1e-1, 1.0];

/// A leg that is this part of the position is rounding.
const RESTS: f64 = 1e4 * f64::EPSILON;

/// A coordinate whose leg is shorter than this part of all stands still.
const STILL: f64 = 1e-3;

/// `F*Ω = Ω + dξ`, each term by itself: an identity, whatever the map.
pub fn identity(subject: &Subject<'_>, report: &mut Report) {
    let (mut count, mut rounding) = (0, 0.0);
    let (mut fast, mut known) = (0, 0.0);
    let defect = largest(&subject.triples, |triple| {
        let law = Evolution::of(&subject.flow, triple)?;
        let defect = law.defect();
        if defect <= LAW {
            return Ok(defect);
        }
        let condition = Regularity::of(subject.kernel, subject.h, triple.leg.any(), &triple.e).condition();
        if defect <= ROUNDINGS * f64::EPSILON * condition {
            (count, rounding) = (count + 1, larger(rounding, defect));
            return Ok(0.0);
        }
        let of_terms = ROUNDINGS * law.rounding(&subject.flow, triple);
        if defect <= of_terms {
            (fast, known) = (fast + 1, larger(known, of_terms));
            return Ok(0.0);
        }
        Ok(defect)
    });
    report.push("F*Ω − Ω − dξ, relative to the terms", Bar::AtMost(LAW), defect);
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

/// Whether the forces of constraints on positions do no work along displacements that these allow, at the states of the motion: friction in proportion to them
/// does.
fn are_ideal(subject: &Subject<'_>) -> bool {
    if subject.constraints()[1..] != [0, 0] {
        return true;
    }
    let declaration = Declaration::of(subject.kernel);
    subject.states.iter().all(|state| {
        let a = vec![0.0; state.q.len()];
        let forms = declaration.continuous_forms::<f64>(AnyPoint {
            t: state.t,
            q: &state.q,
            v: &state.v,
            a: &a,
        });
        let allowed = state_displacements(subject.kernel, state.t, &state.q, &state.v);
        allowed.iter().all(|displacement| {
            forms.iter().all(|form| {
                let works = form.iter().zip(&displacement.first).map(|(form, by)| form * by);
                let (work, size) = works.fold((0.0, 0.0), |(work, size): (f64, f64), x| {
                    (work + x, size + x.abs())
                });
                work.abs() <= IDEAL * size
            })
        })
    })
}

/// What the constraints leave of symplecticity, discretely and continuously, and the tangent map.
pub fn law(subject: &Subject<'_>, report: &mut Report) {
    let change = largest(&subject.triples, |triple| {
        let law = Evolution::of(&subject.flow, triple)?;
        let allowed = pair_displacements(subject.kernel, subject.h, triple.leg.any());
        Ok(law.change_on(&allowed))
    });
    // where steps are ill-conditioned, as on a switch, no difference quotient tells a derivative
    let (mut blurred, is_coarse) = (0.0, subject.coarse.known().is_some());
    let tangent = largest(&subject.early, |triple| {
        let law = Evolution::of(&subject.flow, triple)?;
        let [apart, rounding] = quotient(&subject.flow, triple, &law, is_coarse)?;
        blurred = larger(blurred, rounding);
        Ok(apart)
    });
    let window = PIECE * subject.h;
    let laws: Vec<Measured<[f64; 2]>> = subject
        .states
        .iter()
        .map(|state| continuous::law(subject.system.kernel(), state, window))
        .collect();
    let stiff = laws.iter().skip(1).filter(|law| law.is_err()).count();
    // the start has to be possible
    let mut continuous: Measured<[f64; 2]> = Ok([0.0; 2]);
    for (k, law) in laws.into_iter().enumerate() {
        match (law, &mut continuous) {
            (Ok([missed, change]), Ok(laws)) => *laws = [larger(laws[0], missed), larger(laws[1], change)],
            (Err(error), continuous) if k == 0 => *continuous = Err(error),
            _ => {}
        }
    }
    let d_nu = continuous.as_ref().map_or(0.0, |laws| laws[1]);
    let is_symplectic = matches!(subject.expected.kind, Kind::Unconstrained | Kind::Holonomic)
        && !subject.kernel.shape().external_forces
        && are_ideal(subject);
    let discrete = match (is_symplectic, d_nu) {
        (true, _) => Bar::AtMost(ZERO),
        // where the constraints change the form of the continuous motion they change the discrete one
        (false, change) if change > CHANGED => Bar::AtLeast(SEEN),
        _ => Bar::Reported,
    };
    report.push(
        "dξ along the pairs of nodes that are allowed, relative to the terms",
        discrete,
        change,
    );
    report.push(
        "TF against differences of the first steps",
        Bar::AtMost(QUOTIENT),
        tangent,
    );
    if blurred > 0.0 {
        report.note(&format!(
            "columns are left out in which nodes that are moved as far as a leg tell a slope to {blurred:.0e} only, by the rounding of the positions"
        ));
    }
    let whats = [
        (
            "continuous: (Fᵗ)*Ω_L − Ω_L − dν, relative to the terms",
            Bar::AtMost(QUADRATURE),
        ),
        (
            "continuous: dν on the states that are allowed, relative to the terms",
            if is_symplectic {
                Bar::AtMost(ZERO)
            } else {
                Bar::Reported
            },
        ),
    ];
    report.push_all(whats, &continuous);
    let states = subject.states.len();
    report.note(&format!(
        "the continuous law is integrated over {PIECE} steps each from {} of {states} states of the motion{}",
        states - stiff,
        if stiff > 0 {
            ": elsewhere it is too stiff for the quadrature"
        } else {
            ""
        }
    ));
}

/// How far the tangent map is from difference quotients of the step, of sixth order, relative to the slopes of a coordinate; and how far it is in columns in
/// which that is rounding, because positions are large beside what nodes are moved by.
///
/// # Errors
///
/// [`GeometryError`] if none of the moved steps along a coordinate has a solution.
fn quotient(
    flow: &DiscreteFlow<'_>,
    triple: &Triple,
    law: &Evolution,
    is_coarse: bool,
) -> Result<[f64; 2], GeometryError> {
    let last = triple.last(flow.h()).d;
    // both legs: the first is zero where a force begins to act on what is at rest
    let legs = triple.leg.d.iter().chain(&last);
    let size = match legs.fold(0.0_f64, |size, d| size.hypot(*d)) {
        // as what rests but for rounding, on an unstable equilibrium
        size if size <= RESTS * triple.leg.q.iter().fold(0.0, |most, q| larger(most, q.abs())) => {
            flow.h().abs()
        }
        size => size,
    };
    let (mut apart, mut blurred) = (0.0, 0.0);
    let place = triple.leg.q.iter().fold(0.0, |most, q| larger(most, q.abs()));
    let n = last.len();
    for k in 0..2 * n {
        let unit = Displacement::unit(n, k);
        let own = triple.leg.d[k % n].abs().max(last[k % n].abs());
        let length = if own > STILL * size { own } else { STILL * size };
        let exact = law.tangent.apply(&unit).second;
        let (mut best, mut without) = (f64::INFINITY, None);
        for moved in MOVED {
            // where a moved step has no solution, as on the way past rest, other shifts tell
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
            _ if is_coarse && best > QUOTIENT && best <= ROUNDINGS * f64::EPSILON * place / length => {
                blurred = larger(blurred, best);
            }
            _ => apart = larger(apart, best),
        }
    }
    Ok([apart, blurred])
}

/// The difference quotients of `q2` along a displacement, by nodes moved as far as `shift` and its multiples.
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
            // a guess leads to the solution nearby, which is then exact whatever the guess
            let e = by(&triple.e, &|i| exact[i] - 2.0 * unit.second[i] + unit.first[i]);
            let found = flow.forward_near(moved, &e)?.last(flow.h()).q;
            for (slope, (found, q2)) in slopes.iter_mut().zip(found.iter().zip(&q2)) {
                *slope += sign * weight * (found - q2);
            }
        }
    }
    Ok(slopes.iter().map(|slope| slope / shift).collect())
}
