//! Steps past a place where the equations do not determine the acceleration: constraints depend on each other
//! there, or the determinant of the equations changes its sign.
//!
//! There are three cases. A factor of a constraint may vanish: the motion goes on undisturbed. The
//! acceleration may be unbounded there, which the tolerance does not notice from afar: the motion ends. Or
//! two solutions may come close to each other: a step that is too long for that arrives at the wrong one.

use super::integrator::{Integrator, Outcome};
use super::projection::size;
use super::recurrences::SeriesKernel;
use crate::regularity::dependence;
use crate::solve::Vector;
use crate::start::place::Place;
use crate::start::{Determined, determinant_at};
use crate::step::singular::{self, DEPENDENT, are_opposite};
use crate::tape::declaration::Declaration;

/// A step that would lead past such a place is shortened to half the distance, unless that place is nearer
/// than this part of the step.
pub(super) const PAST: f64 = 0.01;

/// Number of bisections towards such a place.
const HALVINGS: u32 = 24;

/// Bisections end where the positions at both ends differ by so many roundings: there the determinant itself
/// is rounding, and its sign means nothing.
const RESOLVED: f64 = 64.0;

/// With fewer bisections than this a step is hardly longer than rounding.
const FEW: u32 = 5;

/// The acceleration is unbounded at the place if its values on both sides differ by this many times more than on a part of the way to it.
/// Differences below the part [`ROUNDING`] of the acceleration are rounding.
const GROWS: f64 = 16.0;
const ROUNDING: f64 = 1e-7;

/// If the determinant at the place, with the acceleration of the beginning, is more than this part of its
/// former value, it vanishes only because the acceleration changes.
const REMAINS: f64 = 1e-3;

/// Two solutions that stay farther apart than this part of their largest distance on the way do not meet: the
/// motion keeps to its own. If they meet, they cross, and the motion goes straight on.
const MEETS: f64 = 1e-6;

/// Where a step has passed a pole of the acceleration, the acceleration at its end differs from that of its
/// series by this part of itself or more.
const MISSED: f64 = 0.5;

/// A place that a step leads past.
pub(super) enum Past {
    /// A place at this distance, up to which the motion is accurate; a shorter step will examine it.
    Unseen(f64),
    /// A place just ahead at which the motion ends.
    End(Outcome),
}

impl Integrator {
    /// Whether the determinant, or a divisor, has another sign at the end of the trial step.
    #[inline(always)]
    pub(super) fn changes_sign(&self) -> bool {
        (self.series.signs() - self.next.signs()).abs() > 0.0
    }

    /// Position, velocity and acceleration of the last series after a time.
    pub(super) fn place_after(&self, s: f64) -> (Place, Vector) {
        let (q, v) = self.series.start();
        let [mut dq, mut dv, mut a] = [(); 3].map(|()| Vector::zero(q.len()));
        self.series.increments(s, [&mut dq, &mut dv, &mut a]);
        let after = |from: &[f64], by: &Vector| Vector::of(from).zip(by, |from, by| from + by);
        let place = Place::of_phase(self.t.hi[0] + s, after(q, &dq), after(v, &dv));
        (place, a)
    }

    /// Whether the trial step may have passed a zero of the determinant, from the sizes of the acceleration at
    /// its end and of the difference from that of its series. If the acceleration is an explicit quotient, the
    /// sign of the determinant is not computed with it, and only the difference shows the zero. With a large
    /// tolerance such a step may be short enough to be accepted.
    #[inline(always)]
    pub(super) fn may_pass_zero(&self, end: [f64; 2]) -> bool {
        is_missed(end) || self.changes_sign()
    }

    /// The time in which the position changes, on the way of a step of the length `h`, by so many roundings that the determinant is more
    /// than rounding.
    pub(super) fn resolution(&self, h: f64) -> f64 {
        let (q, _) = self.series.start();
        let (end, _) = self.place_after(h);
        let moved = end.q.zip(&Vector::of(q), |end, q| end - q);
        RESOLVED * f64::EPSILON * (size(q) * h.abs() / size(&moved)).max(self.t.hi[0].abs())
    }

    /// The place that the trial step of the length `h`, to the time `t`, must not pass; `end` has the sizes of
    /// the acceleration there. At switches and knots the determinant may jump: then it is not used.
    #[inline(always)]
    pub(super) fn past(
        &mut self,
        equations: &mut dyn SeriesKernel,
        (h, smallest): (f64, f64),
        (t, end): (f64, Option<[f64; 2]>),
    ) -> Option<Past> {
        if let Some(end) = end
            && self.may_pass_zero(end)
        {
            let mut past = self.past_zero(equations, (h, smallest), t);
            if past.is_none() && self.changes_sign() {
                past = self.past_quotient(equations, (h, t), is_missed(end));
            }
            if past.is_some() {
                return past;
            }
        }
        let projection = self.projection.as_ref()?;
        (projection.has_turned() || projection.is_lost())
            .then(|| self.past_dependence(equations, h, projection.has_turned()))
            .flatten()
    }

    /// [`Integrator::past`] for constraints that may depend on each other: within the step, if a direction
    /// has reversed, or at its end, to rounding.
    #[cold]
    fn past_dependence(&self, equations: &dyn SeriesKernel, h: f64, has_turned: bool) -> Option<Past> {
        let declaration = equations.declaration();
        let (time, row) = if has_turned {
            let way = |part: f64| self.place_after(part * h).0;
            singular::dependence(&declaration, &way, DEPENDENT)?
        } else {
            let time = self.t.hi[0] + h;
            let place = Place::of_phase(time, Vector::of(self.tried.q()), Vector::of(self.tried.v()));
            (time, dependence::dependent_at(&declaration, &place)?)
        };
        let ahead = (time - self.t.hi[0]).abs();
        Some(if ahead > PAST * h.abs() && ahead < h.abs() {
            Past::Unseen(ahead)
        } else {
            Past::End(Outcome::Dependent(time, row))
        })
    }

    /// [`Integrator::past`] for a determinant with another sign at the end.
    #[cold]
    fn past_zero(
        &mut self,
        equations: &mut dyn SeriesKernel,
        (h, smallest): (f64, f64),
        t: f64,
    ) -> Option<Past> {
        let declaration = equations.declaration();
        let n = self.now.q().len();
        let at = |s: f64, found: Option<&[f64]>| {
            let (place, a) = self.place_after(s);
            let solved = place.solve(&declaration, found.unwrap_or(&a))?;
            Some((s, place, solved))
        };
        // at both ends the accelerations that were found there
        let first = at(0.0, Some(self.series.velocity_of(1)))?;
        let (mut from, mut to) = (first.clone(), at(h, Some(self.next.velocity_of(1)))?);
        if !are_opposite(&from.2, &to.2) {
            return None;
        }
        let (mut least, mut apart, mut largest) = (f64::INFINITY, f64::INFINITY, 0.0_f64);
        let mut halvings = 0;
        let rounding = self.resolution(h);
        for _ in 0..HALVINGS {
            if (to.0 - from.0).abs() <= rounding {
                break;
            }
            // not at the place itself, where there may be no acceleration
            let middle = [0.5, 0.4]
                .into_iter()
                .find_map(|part| at(from.0 + part * (to.0 - from.0), None));
            // the place is known to rounding
            let Some(middle) = middle else {
                break;
            };
            if are_opposite(&middle.2, &from.2) {
                to = middle;
            } else {
                from = middle;
            }
            let accelerations = from.2.motion.iter().zip(&*to.2.motion).take(n);
            let (size, distance) = accelerations.fold((0.0_f64, 0.0_f64), |(size, distance), (x, y)| {
                (size.max(x.abs()).max(y.abs()), distance.max((x - y).abs()))
            });
            apart = distance;
            least = least.min(distance.max(ROUNDING * size));
            largest = largest.max(distance).max(size);
            halvings += 1;
        }
        let ahead = to.0.abs();
        if halvings < FEW {
            // so short are steps only where the acceleration grows without bound
            return Some(Past::End(Outcome::Unbounded(to.1.t)));
        }
        if is_of_another(&declaration, &to.1, &first.2) {
            return (apart > MEETS * largest && ahead > smallest).then_some(Past::Unseen(ahead));
        }
        if apart <= GROWS * least {
            return None;
        }
        // where all motions close by come to the same place, the error of this one gives it a pole. Only from afar is the velocity of that place
        // known: next to it all differences are rounding
        if self.changes_sign()
            && let Some(Past::End(end @ Outcome::NotUnique(..))) =
                self.past_quotient(equations, (h, t), false)
        {
            return Some(Past::End(end));
        }
        Some(if ahead > PAST * h.abs() {
            Past::Unseen(ahead)
        } else {
            Past::End(Outcome::Unbounded(to.1.t))
        })
    }
}

/// Whether the acceleration at the end of a step differs from that of its series as much as beyond a pole, from the sizes of both.
#[inline(always)]
fn is_missed([acceleration, defect]: [f64; 2]) -> bool {
    defect >= MISSED * acceleration && defect > 0.0
}

/// Whether the determinant vanishes at a place only because the acceleration changes, and not for every
/// acceleration.
fn is_of_another(declaration: &Declaration<'_>, place: &Place, first: &Determined) -> bool {
    let (point, multipliers) = place.with(&first.motion);
    let unit = first.determinant.exponent;
    let [there, here] = [determinant_at(declaration, point, multipliers), first.determinant]
        .map(|determinant| determinant.in_units_of(unit).abs());
    there > REMAINS * here
}
