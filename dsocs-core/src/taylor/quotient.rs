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
use crate::number::{inner_product, largest, remove_part};
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

/// Number of changes of the velocity that are tried, each smaller than the last by the factor [`WIDER`].
const CHANGES: usize = 4;

/// Where differences of motions vanish, those at the beginning of a step may be larger at its end by this factor, and
/// the other way round.
const AMPLIFIES: f64 = 1e4;

/// Number of corrections of the velocity to that of the motion which passes.
const CORRECTIONS: u32 = 4;

/// A velocity below this part of the largest counts as that part.
const LEAST: f64 = 1e-3;

/// Multiples of the golden ratio, whose fractions make a direction that has no special place in any system.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

impl Integrator {
    /// [`Integrator::past`] for a divisor, or the determinant, with another sign at the end: the first place within
    /// the trial step of the length `h`, to the time `t`, where the acceleration has no limit. If the acceleration at
    /// the end is missed, it has no limit known.
    #[cold]
    pub(super) fn past_quotient(
        &mut self,
        equations: &mut dyn SeriesKernel,
        (h, t): (f64, f64),
        is_missed: bool,
    ) -> Option<Past> {
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
            found = probe.past(place, before);
            if found.is_none() && is_missed {
                found = Some(probe.unbounded(place));
            }
            from = place + BESIDE * h;
            before = probe.signs(from, &[]);
            if found.is_some() || before == end || before.is_nan() {
                break;
            }
        }
        // the expansions above have changed the state of the recurrences
        self.arrive(equations, h, t);
        found
    }
}

/// The velocities near a place.
struct Near {
    /// The sizes of the components.
    scale: Vector,
    /// The forms of the constraints of lower order, orthonormal, in units of these.
    forms: Vec<Vector>,
}

impl Near {
    fn len(&self) -> usize {
        self.scale.len()
    }

    /// The size of a change of the velocity.
    fn size(&self, change: &Vector) -> f64 {
        largest(&change.zip(&self.scale, |x, scale| x / scale))
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

    /// The place at the time `s` of the step, a zero of a divisor, if the step must not pass it.
    fn past(&mut self, s: f64, before: f64) -> Option<Past> {
        let near = self.near(s)?;
        let residue = self.residue(s, &[], before)?;
        let tolerance = ERRORS * self.motion.control.relative();
        let any = Vector::from_fn(near.len(), |i| 0.5 + (GOLDEN * (i + 1) as f64).fract());
        let mut centre = Vector::zero(near.len());
        let slope = self.slope((s, before), &centre, &near, &any);
        if slope.is_none_or(|slope| largest(&slope) < ZERO) {
            return (near.size(&residue) > ROUNDING).then(|| self.unbounded(s));
        }
        let (mut left, mut powers) = (near.size(&residue), Vec::new());
        for correction in 0..CORRECTIONS {
            let columns: Vec<Vector> = (0..near.len())
                .map(|j| {
                    let unit = Vector::from_fn(near.len(), |i| f64::from(u8::from(i == j)));
                    let slope = self.slope((s, before), &centre, &near, &unit);
                    slope.unwrap_or_else(|| Vector::zero(near.len()))
                })
                .collect();
            let grows = columns.iter().map(|column| largest(column)).fold(0.0, f64::max);
            if correction == 0 && left > ROUNDING + tolerance * grows {
                return Some(self.unbounded(s));
            }
            let row = |i: usize| columns.iter().map(|column| column[i]).collect();
            powers = eigenvalues(&(0..near.len()).map(row).collect::<Vec<_>>())?;
            // to the velocity of the motion that passes, if there is one such direction
            let main = powers
                .iter()
                .map(|power| power[0])
                .max_by(|x, y| x.abs().total_cmp(&y.abs()))?;
            if left <= ROUNDING || main.abs() < ZERO {
                break;
            }
            let residue = self.residue(s, &centre, before)?;
            let corrected = centre.zip(&residue, |v, r| v - r / main);
            match self.residue(s, &corrected, before).map(|next| near.size(&next)) {
                Some(next) if next < left => (centre, left) = (corrected, next),
                _ => break,
            }
        }
        self.past_powers(s, &powers, tolerance * left.min(1.0))
    }

    /// [`Probe::past`] for the powers of the time with which motions differ near the place, known to an error.
    fn past_powers(&self, s: f64, powers: &[[f64; 2]], error: f64) -> Option<Past> {
        let is_whole = |&[p, other]: &[f64; 2]| {
            let near = ZERO * p.max(1.0) + error;
            other.abs() <= near && (p - p.round()).abs() <= near
        };
        let mut powers = powers.iter().filter(|power| power[0] > ZERO).peekable();
        powers.peek()?;
        let most = powers.try_fold(0.0_f64, |most, power| is_whole(power).then(|| most.max(power[0])));
        let beyond = self.h / s - 1.0;
        match most {
            Some(most) if beyond.powf(most) > AMPLIFIES => Some(self.not_unique(s)),
            None => Some(self.not_unique(s)),
            // the next step would begin too near
            Some(most) => (beyond.powf(-most) > AMPLIFIES).then_some(Past::Unseen(s.abs())),
        }
    }

    /// The end of the motion at the time `s`, where more than one motion goes on.
    fn not_unique(&self, s: f64) -> Past {
        Past::End(Outcome::NotUnique(self.motion.t.hi[0] + s, self.divisor(s)))
    }

    /// The end of a motion whose acceleration is unbounded at the time `s`. It is looked at again from nearer, where
    /// the motion may turn away.
    fn unbounded(&self, s: f64) -> Past {
        let is_near =
            s.abs() <= PAST * self.h.abs() || BESIDE * self.h.abs() <= self.motion.resolution(self.h);
        if is_near {
            Past::End(Outcome::Unbounded(self.motion.t.hi[0] + s))
        } else {
            Past::Unseen(s.abs())
        }
    }

    /// The derivative of the residue by the velocity along a direction, which is made admissible, both in units of
    /// the velocity.
    fn slope(
        &mut self,
        (s, before): (f64, f64),
        centre: &Vector,
        near: &Near,
        direction: &Vector,
    ) -> Option<Vector> {
        let mut direction = direction.clone();
        for form in &near.forms {
            remove_part(&mut direction, form);
        }
        let by = direction.zip(&near.scale, |y, scale| y * scale);
        // a change that is large for a short step moves the place out of sight
        core::iter::successors(Some(BESIDE), |part| Some(part / WIDER))
            .take(CHANGES)
            .find_map(|part| {
                let [back, on] = [-part, part].map(|step| {
                    let by = centre.zip(&by, |v, by| v + step * by);
                    self.residue(s, &by, before)
                });
                let slope = on?.zip(&back?, |on, back| 0.5 * (on - back) / part);
                Some(slope.zip(&near.scale, |x, scale| x / scale))
            })
    }

    /// The sizes and the admissible changes of velocities at the time `s`; `None` at rest.
    fn near(&self, s: f64) -> Option<Near> {
        let (place, a) = self.motion.place_after(s);
        let moves = place.v.zip(&a, |v, a| v.abs() + (a * self.h).abs());
        let most = largest(&moves);
        let scale = moves.map(|x| x.max(LEAST * most));
        let declaration = self.equations.declaration();
        let (lower, n) = (declaration.lower(), scale.len());
        let mut rows = vec![0.0; lower * (1 + n)];
        if lower > 0 {
            self.equations
                .phase_slopes(true, (place.t, &place.q, &place.v), &mut rows);
        }
        let mut forms: Vec<Vector> = Vec::new();
        for row in rows[lower..].chunks_exact(n.max(1)) {
            let mut form = Vector::of(row).zip(&scale, |row, scale| row * scale);
            let whole = inner_product(&form, &form);
            // a second time for what rounding has left
            for _ in 0..2 {
                for known in &forms {
                    remove_part(&mut form, known);
                }
            }
            let square = inner_product(&form, &form);
            if square > f64::EPSILON * whole {
                forms.push(form.map(|x| x / square.sqrt()));
            }
        }
        (most > 0.0 && most.is_finite()).then_some(Near { scale, forms })
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
