//! Starts at rest at which a step of first order would stay for ever.

use crate::number::bounded::Bounded;
use crate::number::point::{AnyLeg, AnyPoint, map};
use crate::number::scalar::Scalar as _;
use crate::number::tangent::Tangent;
use crate::regularity::deficiency::{self, Deficiency, DependentRow};
use crate::regularity::multipliers;
use crate::tape::declaration::Declaration;

/// A derivative below this part of its terms is zero.
const ZERO: f64 = 1e-12;

/// The deficiency of a kinematic constraint at rest, if a step would have rest as a solution for this reason
/// alone.
///
/// A Lyapunov constraint `dV/dt + F = 0` has a velocity as a factor: at rest it holds for every acceleration,
/// and so a step from two equal nodes is solved by a third equal one. If the other factor is zero at rest,
/// too, the system is in equilibrium and rest is correct.
#[cold]
pub(super) fn left_open(
    declaration: &Declaration<'_>,
    (t0, h): (f64, f64),
    q0: &[f64],
) -> Option<Deficiency> {
    if declaration.constraints()[2] == 0 {
        return None;
    }
    let rest = vec![0.0; q0.len()];
    let point = AnyPoint {
        t: t0,
        q: q0,
        v: &rest,
        a: &rest,
    };
    let open = deficiency::of_point(declaration, point)?;
    let [DependentRow::Kinematic(row)] = open.rows[..] else {
        return None;
    };
    let stays = !open.at_guess_alone
        && is_solution(declaration, (t0 + h, h), q0)
        && !is_equilibrium(declaration, point, row);
    stays.then_some(open)
}

/// Whether three equal nodes solve a step.
fn is_solution(declaration: &Declaration<'_>, (t, h): (f64, f64), q: &[f64]) -> bool {
    let rest = vec![0.0; q.len()];
    let leg = AnyLeg { t, q, d: &rest };
    let multipliers = multipliers::of_step(declaration, h, leg, &rest);
    let rows = declaration.declared(
        Bounded::splat(h),
        leg.map(Bounded::splat).any(),
        &map(&rest, Bounded::splat),
        &map(&multipliers, Bounded::splat),
    );
    rows.iter().all(|row| row.lane(0).abs() <= row.error())
}

/// Whether the other factor of a kinematic constraint with a velocity as a factor vanishes at rest: then the
/// constraint does not depend on the velocity there either.
fn is_equilibrium(declaration: &Declaration<'_>, rest: AnyPoint<'_, f64>, row: usize) -> bool {
    let [holonomic, nonholonomic, _] = declaration.constraints();
    let place = holonomic + nonholonomic + row;
    let count = rest.q.len();
    let moving = |i: usize| -> (f64, f64) {
        let unit = |j: usize| if i == j { 1.0 } else { 0.0 };
        let slope = declaration.continuous(
            AnyPoint {
                t: Tangent::splat(rest.t),
                q: &map(rest.q, Tangent::splat),
                v: &(0..count).map(|j| Tangent::new(0.0, unit(j))).collect::<Vec<_>>(),
                a: &map(rest.a, Tangent::splat),
            },
            &[],
        );
        let terms = declaration.continuous(
            AnyPoint {
                t: Bounded::splat(rest.t),
                q: &map(rest.q, Bounded::splat),
                v: &(0..count).map(|j| Bounded::splat(unit(j))).collect::<Vec<_>>(),
                a: &map(rest.a, Bounded::splat),
            },
            &[],
        );
        (
            slope[place].derivative().abs(),
            terms[place].error() / (f64::EPSILON / 2.0),
        )
    };
    (0..count).map(moving).all(|(slope, terms)| slope <= ZERO * terms)
}
