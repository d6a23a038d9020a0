//! Nodes at which a table of samples has a corner.
//!
//! Where a table of the time is differentiated, or stands in the Lagrangian, the acceleration or the velocity may jump at a sample. At the
//! last sample one of them does, since the table is constant beyond. The mean velocity of the two legs beside such a node is that of neither
//! side: it differs from both by a quarter of the step times the jump of the acceleration. So the node has the velocity with which the motion
//! arrives there, from the leg before it and the acceleration on that side, `v = d/h + h/2 a`, which is of second order. The step itself is
//! not changed.

use super::discrete::Discrete;
use crate::kernel::report::NodeMut;
use crate::number::point::{AnyPoint, copy};
use crate::samples::BENDS;
use crate::solve::Vector;
use crate::start;
use crate::tape::declaration::{Declaration, TableAt};

/// Both sides of a node are evaluated this many units of rounding before and after its time. A sample between them lies at the node.
const ROUNDINGS: f64 = 16.0;

/// Samples closer to each other than this many steps approximate a smooth curve, without corners.
const COARSE: f64 = 4.0;

/// A jump of the acceleration below this part of the acceleration itself is rounding.
const JUMPS: f64 = 1e-6;

/// Number of iterations for the arriving velocity and acceleration, each of which may depend on the other.
const TIMES: usize = 3;

impl Discrete<'_> {
    /// Replaces velocity, acceleration, constraint force and energy of a solved node at which a table has a
    /// corner by those with which the motion arrives.
    #[cold]
    pub(super) fn write_arrival(&self, mut node: NodeMut<'_>) {
        let shape = self.shape();
        if shape.is_of_third_order() {
            return;
        }
        let (declaration, t, h) = (self.declaration(), node.scalars.t, self.run_state.h);
        let [q, v, a, force] = node.split();
        let apart = (ROUNDINGS * f64::EPSILON * t.abs().max(h.abs())).copysign(h);
        let sides = [t - apart, t + apart];
        let [came, goes] = sides.map(|t| declaration.tables(t, &*q, &*v, &*a));
        let corners = came
            .iter()
            .zip(&goes)
            .filter(|(came, goes)| is_corner([came, goes], h));
        let (mut any, mut is_differentiated) = (false, false);
        for (came, _) in corners {
            any = true;
            is_differentiated |= came.is_differentiated;
        }
        if !any {
            return;
        }
        let leg = self.run_state.solved_leg();
        let arrives = |t: f64| arrival(&declaration, (t, h), (&*q, leg.d));
        let [Some([arriving, own]), Some([_, other])] = sides.map(arrives) else {
            return;
        };
        let size = own
            .iter()
            .chain(other.iter())
            .fold(0.0_f64, |most, a| most.max(a.abs()));
        let mut both = own.iter().zip(other.iter());
        if !is_differentiated && !both.any(|(own, other)| (own - other).abs() > JUMPS * size) {
            return;
        }
        copy(v, &arriving);
        copy(a, &own);
        let [t, _] = sides;
        let point = AnyPoint {
            t,
            q: &*q,
            v: &*v,
            a: &*a,
        };
        declaration.continuous_force_into(point, force);
        node.scalars.energy = declaration.energy(t, &*q, &*v);
    }
}

/// Whether a table has a corner between its arguments just before and just after a node: at its first or last
/// sample, or at one that is far from the next ones.
fn is_corner([before, after]: [&TableAt<'_>; 2], h: f64) -> bool {
    let (samples, [from, to]) = (before.samples, [before.argument, after.argument]);
    let [least, most] = [from.min(to), from.max(to)];
    let places = samples.places();
    let k = places.partition_point(|&place| place <= least);
    let Some(&place) = places.get(k).filter(|place| **place <= most) else {
        return false;
    };
    let far = |other: Option<usize>| {
        let other = other.and_then(|k| places.get(k));
        other.is_none_or(|other| (other - place).abs() >= COARSE * h.abs())
    };
    let is_end = k == 0 || k + 1 == places.len();
    samples.bend(k) > BENDS && (is_end || far(k.checked_sub(1)) && far(Some(k + 1)))
}

/// Velocity and acceleration with which the motion arrives at the end of a leg. The equations are those at the time `t`, just before it.
fn arrival(
    declaration: &Declaration<'_>,
    (t, h): (f64, f64),
    (q, d): (&[f64], &[f64]),
) -> Option<[Vector; 2]> {
    let mut v = Vector::of(d).map(|d| d / h);
    let mut a: Option<Vector> = None;
    for _ in 0..TIMES {
        let (found, _) = start::acceleration(declaration, (t, q, &v), a.as_deref()).ok()?;
        v = Vector::of(d).zip(&found, |d, a| d / h + 0.5 * h * a);
        a = Some(found);
    }
    let (a, _) = start::acceleration(declaration, (t, q, &v), a.as_deref()).ok()?;
    Some([v, a])
}
