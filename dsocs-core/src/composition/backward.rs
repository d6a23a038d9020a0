//! Legs that go back in time: whether their solutions belong to the motion.
//!
//! A damped motion grows back in time. A leg of the length `-h` has the equations `F(q, v_r - h/2 a, a) = 0`,
//! with the derivative `F_a - h/2 F_v` by the acceleration. As `h` grows from zero this may become singular
//! (at `h k = 2` for a damping `a = -k v`): beyond that there still are solutions, but none that the motion
//! back in time leads to. The determinant then has the other sign, unless a second direction is singular as
//! well.
//!
//! Of several backward legs the longest is examined: it is the first to become singular.
//!
//! If the damping jumps, there may also be a solution on the other side of the jump, with the same orientation. A solution that takes many
//! iterations is therefore compared with the one that continuation from the node, with backward legs of growing length, leads to.

use crate::flow::discrete::constants_of;
use crate::kernel::Kernel;
use crate::kernel::report::{Guess, StepReport};
use crate::kernel::run_state::MAX_ITERATIONS;
use crate::number::point::{AnyLeg, AnyPoint};
use crate::solve::{Square, Vector};
use crate::step::Step;

/// Length of the leg by which the orientation of a node is judged, as a part of the full leg: too short to contain a singularity.
const SHORT: f64 = 1.0 / (1 << 20) as f64;

/// Number of evaluations after which a solution is compared with the one that continuation leads to.
pub(super) const MANY: u32 = 6;

/// With at most this many evaluations, an iteration of the continuation has stayed on its branch of solutions.
const FEW: u32 = 4;

/// The smallest increase of the length in that continuation, as a part of the leg.
const SMALLEST_PART: f64 = 1.0 / (1 << 12) as f64;

/// Two vectors that differ by less, relative to the larger, are the same solution.
const SAME: f64 = 1e-6;

/// Relative change of an increment by which its derivatives are formed as differences.
const MOVED: f64 = 1e-4;

/// A system, and the values of its parameters.
pub(super) type System<'a> = (&'a dyn Kernel, &'a [f64]);

/// Whether a solution is doubtful: it took many iterations, or did not come from the predicted guess.
#[inline]
pub(super) fn is_doubtful(report: StepReport) -> bool {
    report.iterations >= MANY || report.guess != Guess::Predicted
}

/// Whether the acceleration `found` at the end of a leg is the one to which continuation leads: legs from the node, of increasing length.
#[cold]
pub(super) fn continues(system: System<'_>, h: f64, from: AnyPoint<'_, f64>, found: &[f64]) -> bool {
    let mut a = Vector::of(from.a);
    let is_passable = little_by_little(|_, part| {
        let h = part * h;
        let v = Vector::of(from.v).zip(from.a, |v, a| v + 0.5 * h * a);
        let leg = AnyLeg {
            t: from.t + h,
            q: &Vector::of(from.q).zip(&v, |q, v| q + h * v),
            d: &v.map(|v| h * v),
        };
        match solved(system, h, leg, &a, FEW) {
            Some((e, report)) if report.iterations <= FEW => {
                a = e.map(|e| e / (h * h));
                true
            }
            _ => false,
        }
    });
    is_passable && is_same(&a, found)
}

/// Continuation in the length of a leg: `make(reached, next)` makes the leg of the part `next`, from the solution at the part `reached`,
/// until the leg is whole. If it fails, the next part is smaller. `false` if the smallest part fails.
pub(super) fn little_by_little(mut make: impl FnMut(f64, f64) -> bool) -> bool {
    let (mut reached, mut part) = (0.0, 0.125);
    while reached < 1.0 {
        let next = f64::min(1.0, reached + part);
        if make(reached, next) {
            (reached, part) = (next, 2.0 * part);
        } else if part <= SMALLEST_PART {
            return false;
        } else {
            part *= 0.5;
        }
    }
    true
}

/// Whether two vectors are the same solution.
pub(super) fn is_same(x: &[f64], y: &[f64]) -> bool {
    let size = |x: &[f64]| x.iter().fold(0.0_f64, |size, x| size.max(x.abs()));
    let apart = Vector::of(x).zip(y, |x, y| x - y);
    size(&apart) <= SAME * size(x).max(size(y))
}

/// The second difference of the step after a leg, with an acceleration as the guess.
fn solved(
    (kernel, values): System<'_>,
    h: f64,
    leg: AnyLeg<'_, f64>,
    a: &[f64],
    max_iterations: u32,
) -> Option<(Vector, StepReport)> {
    let constants = constants_of(kernel, values, h);
    let step = Step::new((kernel, values), &constants, leg, h);
    let guess = step.unknown(&Vector::of(a).map(|a| h * h * a), &[]);
    let (z, report) = step.solve_from(&guess, max_iterations).ok()?;
    Some((step.second_difference(&z), report))
}

/// The sign of the determinant at a node for a short leg.
#[cold]
pub(super) fn short_orientation((kernel, values): System<'_>, h: f64, node: AnyPoint<'_, f64>) -> f64 {
    let h = SHORT * h;
    let (constants, d) = (constants_of(kernel, values, h), arriving(h, node));
    let step = Step::new((kernel, values), &constants, leg(node, &d), h);
    step.orientation(&step.unknown(&Vector::of(node.a).map(|a| h * h * a), &[]))
}

/// Whether equations without a Jacobian of their own, because all unknowns were eliminated in advance, have passed a singularity: then the
/// derivative of the velocity after a leg by the velocity before it has a negative determinant. `false` if it cannot be computed.
#[cold]
pub(super) fn passes_singularity(system: System<'_>, h: f64, node: AnyPoint<'_, f64>) -> bool {
    let (d, a) = (arriving(h, node), node.a);
    let n = a.len();
    let solve = |d: &Vector| Some(solved(system, h, leg(node, d), a, MAX_ITERATIONS)?.0);
    let Some(e) = solve(&d) else {
        return false;
    };
    let mut slopes = Square::zero(n);
    for (i, slopes) in slopes.entries_mut().chunks_exact_mut(n.max(1)).enumerate() {
        let size = d[i].abs().max((h * h * a[i]).abs());
        let by = MOVED * if size > 0.0 { size } else { h.abs() };
        let mut moved = d.clone();
        moved[i] += by;
        let Some(changed) = solve(&moved) else {
            return false;
        };
        for (j, slope) in slopes.iter_mut().enumerate() {
            *slope = f64::from(u8::from(i == j)) + (changed[j] - e[j]) / (2.0 * by);
        }
    }
    slopes.determinant().value < 0.0
}

/// The leg with a given increment that ends at a node.
fn leg<'a>(node: AnyPoint<'a, f64>, d: &'a [f64]) -> AnyLeg<'a, f64> {
    AnyLeg {
        t: node.t,
        q: node.q,
        d,
    }
}

/// The increment of the leg of the length `h` that ends at a node.
fn arriving(h: f64, AnyPoint { v, a, .. }: AnyPoint<'_, f64>) -> Vector {
    Vector::of(v).zip(a, |v, a| h * (v - 0.5 * h * a))
}
