//! Steps past a place where the acceleration is 0/0: a divisor vanishes, or the determinant of the equations.
//!
//! At a time `τ` after such a place the acceleration is `r(v) / τ` and a bounded part. On the motion that passes, at
//! the velocity `v`, the residue `r` vanishes. Of motions close by, which come there with the velocity `v + δ`, it is
//! `r' δ`, so that `δ` changes as `|τ|` to the power `p`, for each eigenvalue `p` of the matrix `r'`:
//!
//! - If all are zero, the quotient has a limit, as `sin(x) / x`.
//! - If one is positive, all motions close by come to this place with the same velocity, and nothing says which of
//!   them goes on: the motion ends. If it is a whole number, these motions are smooth, and each goes on as itself, as
//!   far as a step beyond the place keeps the difference, which nearly vanishes there.
//! - If one is negative, the other motions do not come through.
//!
//! No size of the divisor is needed for that, but its sign, which each expansion gives: so this finds the zeros of
//! all divisors that the recurrences have, and adds nothing to a step that passes none.

use super::integrator::{Integrator, Outcome};
use super::recurrences::SeriesKernel;
use super::singular::{PAST, Past};
use crate::number::point::AnyPoint;
use crate::regularity::undefined;
use crate::series::rows::Series;
use crate::solve::Vector;
use crate::solve::eigenvalues::eigenvalues;

/// The acceleration is compared this part of the step before a place and after it, and velocities are changed by
/// this part of themselves: the errors are its square, and rounding divided by it.
const BESIDE: f64 = 1e-4;

/// A power of the time below this is zero, up to those errors.
const ZERO: f64 = 1e-5;

/// A residue below this part of the velocity is rounding.
const ROUNDING: f64 = 1e-11;

/// The velocity at the place has an error of this many tolerances. The residue there may be that of the error, and
/// a power differs from a whole number by it.
const ERRORS: f64 = 100.0;

/// Largest number of bisections towards a place, and of places that are looked at in a step.
const HALVINGS: u32 = 60;
const PLACES: u32 = 8;

/// The place for another velocity is searched in an interval that begins with this part of the step and grows by
/// the next factor up to [`WIDEST`].
const NARROWEST: f64 = 1e-13;
const WIDER: f64 = 16.0;
const WIDEST: f64 = 0.05;

/// A step to the other side of a place, where differences of motions vanish, may make those at its beginning larger by
/// this factor.
const AMPLIFIES: f64 = 1e4;

/// Number of corrections of the velocity to that of the motion which passes.
const CORRECTIONS: u32 = 4;

/// A velocity below this part of the largest counts as that part.
const LEAST: f64 = 1e-3;

/// Multiples of the golden ratio, whose fractions make a direction that has no special place in any system.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

impl Integrator {
    /// [`Integrator::past`] for a divisor, or the determinant, with another sign at the end: the first place within
    /// the trial step of the length `h`, to the time `t`, where the acceleration has no limit.
    #[cold]
    pub(super) fn past_quotient(&mut self, equations: &mut dyn SeriesKernel, (h, t): (f64, f64)) -> Option<Past> {
        let [mut before, end] = [self.series.signs(), self.next.signs()];
        let mut probe = Probe {
            motion: self,
            scratch: Series::new(self.now.q().len(), 2),
            equations: &mut *equations,
            h,
        };
        let (mut from, mut found) = (0.0, None);
        for _ in 0..PLACES {
            let place = probe.change(&[], before, [from, h]);
            found = probe.ends(place, before).map(|outcome| (place, outcome));
            from = place + BESIDE * h;
            before = probe.signs(from, &[]);
            if found.is_some() || before == end || before.is_nan() {
                break;
            }
        }
        // the expansions above have changed the state of the recurrences
        self.arrive(equations, h, t);
        let (ahead, outcome) = found?;
        // an unbounded acceleration is looked at again from nearer, where the motion may turn away
        let is_near = ahead.abs() <= PAST * h.abs() || BESIDE * h.abs() <= self.resolution();
        Some(if is_near || matches!(outcome, Outcome::NotUnique(..)) {
            Past::End(outcome)
        } else {
            Past::Unseen(ahead.abs())
        })
    }
}

/// Evaluates the equations near the path of a step.
struct Probe<'a> {
    motion: &'a Integrator,
    equations: &'a mut dyn SeriesKernel,
    scratch: Series,
    /// The length of the step.
    h: f64,
}

impl Probe<'_> {
    /// The signs of the divisors at the time `s` of the step, with the velocity changed by `by`.
    fn signs(&mut self, s: f64, by: &[f64]) -> f64 {
        self.apart(s, by);
        self.scratch.signs()
    }

    /// The difference of the acceleration at the time `s` of the step, with the velocity changed by `by`, from that
    /// of the step's series.
    fn apart(&mut self, s: f64, by: &[f64]) -> Vector {
        let (place, a) = self.motion.place_after(s);
        let v = place.v.zip(by, |v, by| v + by);
        self.scratch.begin(place.t, &place.q, &v);
        self.scratch.expect(&a);
        self.equations.expand(&mut self.scratch);
        Vector::of(self.scratch.velocity_of(1)).zip(&a, |own, a| own - a)
    }

    /// The time in an interval at which the signs are no longer those `before`.
    fn change(&mut self, by: &[f64], before: f64, [mut from, mut to]: [f64; 2]) -> f64 {
        for _ in 0..HALVINGS {
            if (to - from).abs() <= f64::EPSILON * self.h.abs() {
                break;
            }
            let middle = 0.5 * (from + to);
            if self.signs(middle, by) == before {
                from = middle;
            } else {
                to = middle;
            }
        }
        0.5 * (from + to)
    }

    /// The residue of the acceleration at a zero of a divisor near the time `s`, with the velocity changed by `by`;
    /// `None` if there is no such zero.
    fn residue(&mut self, s: f64, by: &[f64], before: f64) -> Option<Vector> {
        let mut width = NARROWEST * self.h;
        while self.signs(s - width, by) != before || self.signs(s + width, by) == before {
            width *= WIDER;
            if width.abs() > WIDEST * self.h.abs() {
                return None;
            }
        }
        let place = self.change(by, before, [s - width, s + width]);
        let beside = BESIDE * self.h;
        let [back, on] = [place - beside, place + beside].map(|s| self.apart(s, by));
        let residue = on.zip(&back, |on, back| 0.5 * beside * (on - back));
        residue.is_finite().then_some(residue)
    }

    /// The end of the motion at a zero of a divisor at the time `s`, if it ends there.
    fn ends(&mut self, s: f64, before: f64) -> Option<Outcome> {
        let (place, a) = self.motion.place_after(s);
        let n = place.v.len();
        let moves = place.v.zip(&a, |v, a| v.abs() + (a * self.h).abs());
        let largest = moves.iter().fold(0.0_f64, |largest, x| largest.max(*x));
        let scale = moves.map(|x| x.max(LEAST * largest));
        let residue = self.residue(s, &[], before)?;
        let size = |x: &Vector| x.zip(&scale, |x, scale| x / scale).iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let tolerance = ERRORS * self.motion.control.relative();
        let tangent = self.tangent(s, &scale);
        // the derivative of the residue by the velocity along a direction, both in units of the velocity
        let slope = |probe: &mut Self, centre: &Vector, direction: &Vector| {
            let along = |step: f64| {
                let by = direction.zip(&scale, |y, scale| y * scale);
                centre.zip(&by, |v, by| v + step * by)
            };
            let [back, on] = [-BESIDE, BESIDE].map(|step| probe.residue(s, &along(step), before));
            let slope = on?.zip(&back?, |on, back| 0.5 * (on - back) / BESIDE);
            Some(slope.zip(&scale, |x, scale| x / scale))
        };
        let largest_of = |x: &Vector| x.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let any = tangent(&Vector::from_fn(n, |i| 0.5 + (GOLDEN * (i + 1) as f64).fract()));
        let mut centre = Vector::zero(n);
        let grows = slope(self, &centre, &any).map_or(0.0, |slope| largest_of(&slope));
        let unbounded = Some(Outcome::Unbounded(place.t));
        if grows < ZERO {
            return unbounded.filter(|_| size(&residue) > ROUNDING);
        }
        let mut left = residue.clone();
        for _ in 0..CORRECTIONS {
            let columns: Vec<Vector> = (0..n)
                .map(|j| {
                    let unit = tangent(&Vector::from_fn(n, |i| f64::from(u8::from(i == j))));
                    slope(self, &centre, &unit).unwrap_or_else(|| Vector::zero(n))
                })
                .collect();
            let rows: Vec<Vec<f64>> = (0..n).map(|i| columns.iter().map(|column| column[i]).collect()).collect();
            let powers = eigenvalues(&rows)?;
            let main = powers.iter().copied().max_by(|x, y| x[0].abs().total_cmp(&y[0].abs()))?[0];
            let grows = columns.iter().map(largest_of).fold(0.0, f64::max);
            if size(&residue) > ROUNDING + tolerance * grows {
                return unbounded;
            }
            let (h, left_size) = (self.h, size(&left));
            let is_open = |&[p, other]: &[f64; 2]| {
                let near = ZERO * p.max(1.0) + tolerance * left_size.min(1.0);
                p > ZERO && (other.abs() > near || (p - p.round()).abs() > near || (h / s - 1.0).powf(p) > AMPLIFIES)
            };
            if size(&left) <= ROUNDING || main.abs() < ZERO {
                return powers.iter().any(is_open).then(|| Outcome::NotUnique(place.t, self.divisor(s)));
            }
            // to the velocity of the motion that passes, if there is one such direction
            let corrected = centre.zip(&left, |v, r| v - r / main);
            let Some(next) = self.residue(s, &corrected, before).filter(|next| size(next) < size(&left)) else {
                return powers.iter().any(is_open).then(|| Outcome::NotUnique(place.t, self.divisor(s)));
            };
            (centre, left) = (corrected, next);
        }
        None
    }

    /// The part of a direction, in units of the velocity's components, that constraints of lower order admit.
    fn tangent(&self, s: f64, scale: &Vector) -> impl Fn(&Vector) -> Vector + use<> {
        let declaration = self.equations.declaration();
        let (lower, n) = (declaration.lower(), scale.len());
        let (place, _) = self.motion.place_after(s);
        let mut rows = vec![0.0; lower * (1 + n)];
        if lower > 0 {
            self.equations.phase_slopes(true, (place.t, &place.q, &place.v), &mut rows);
        }
        let mut forms: Vec<Vector> = Vec::new();
        for row in rows[lower..].chunks_exact(n.max(1)) {
            let mut form = Vector::of(row).zip(scale, |row, scale| row * scale);
            let whole = product(&form, &form);
            for _ in 0..2 {
                remove(&forms, &mut form);
            }
            let square = product(&form, &form);
            if square > f64::EPSILON * whole {
                forms.push(form.map(|x| x / square.sqrt()));
            }
        }
        move |direction| {
            let mut direction = direction.clone();
            remove(&forms, &mut direction);
            direction
        }
    }

    /// The divisor that is zero at the time `s`, as declared; `None` if it is not a coordinate or velocity, or is
    /// none of the declaration.
    fn divisor(&self, s: f64) -> Option<String> {
        let (mut place, a) = self.motion.place_after(s);
        let (q, v) = self.motion.series.start();
        for (there, here) in [(&mut place.q, q), (&mut place.v, v)] {
            for (x, before) in there.iter_mut().zip(here) {
                if x.abs() <= ROUNDING * before.abs() {
                    *x = 0.0;
                }
            }
        }
        let point = AnyPoint {
            t: place.t,
            q: &place.q,
            v: &place.v,
            a: &a,
        };
        let undefined = undefined::of_point(&self.equations.declaration(), point)?;
        (undefined.value == 0.0).then_some(undefined.expression)
    }
}

/// The inner product.
fn product(x: &[f64], y: &[f64]) -> f64 {
    x.iter().zip(y).map(|(x, y)| x * y).sum()
}

/// Removes the parts along orthonormal vectors.
fn remove(forms: &[Vector], x: &mut Vector) {
    for form in forms {
        let part = product(form, x);
        for (x, form) in x.iter_mut().zip(form.iter()) {
            *x -= part * form;
        }
    }
}
