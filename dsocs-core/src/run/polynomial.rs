//! The motion between two nodes, as a polynomial.

use super::{AnyNode, Node};
use crate::number::compensated::Compensated;
use crate::number::point::OwnedPoint;
use crate::number::point::Point;
use crate::series::rows::Series;
use crate::solve::rotation;

/// The motion during one step, valid from [`Polynomial::start`] to [`Polynomial::end`]: the dense output of every method.
///
/// In a [`crate::TaylorFlow`] it is the Taylor series of the step, as exact as the tolerance. In the discrete methods it is
/// the polynomial between two nodes, see [`Polynomial::between`].
#[derive(Clone, Copy, Debug)]
pub struct Polynomial<'f, const N: usize>(AnyPolynomial<'f>);

/// A [`Polynomial`] with any number of coordinates.
#[derive(Clone, Copy, Debug)]
pub struct AnyPolynomial<'f> {
    /// The coefficients.
    pub(crate) series: &'f Series,
    /// The time of expansion, as a compensated sum.
    pub(crate) t: Compensated<1>,
    /// The beginning of the polynomial, after the time of expansion.
    pub(crate) from: f64,
    /// The end of the polynomial, after the time of expansion.
    pub(crate) to: f64,
    /// The resolution of its search for events.
    pub(crate) search: Search,
    /// Whether each argument of a function that jumps with the velocity rests from the beginning on, and from the end on; see
    /// [`super::Run::resting`].
    pub(crate) resting: [&'f [bool]; 2],
}

/// The resolution of the search of a polynomial for events.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Search {
    /// Largest last term of an event's series, relative to the largest term: above, the interval is halved.
    pub tail: f64,
    /// The largest number of halvings.
    pub depth: u32,
    /// Whether a step ends where a body comes to rest.
    pub joins: bool,
}

impl Search {
    /// The resolution for a Taylor series.
    pub const SERIES: Self = Self {
        tail: 1e-9,
        depth: 12,
        joins: true,
    };

    /// The resolution for a polynomial between two nodes, which is itself less accurate.
    pub const NODES: Self = Self {
        tail: 1e-9,
        depth: 4,
        joins: false,
    };
}

impl<'f> AnyPolynomial<'f> {
    /// The order of the series in [`AnyPolynomial::between`]: higher than the polynomial's own, for functions
    /// of it.
    pub(crate) const ORDER: usize = 12;

    /// The polynomial between two nodes; see [`Polynomial::between`]. Nothing is allocated if the number of
    /// coordinates agrees. No coordinate may be a rotation.
    pub fn between(before: &AnyNode<'_>, after: &AnyNode<'_>, series: &'f mut Series) -> Self {
        Self::through(&[], false, [before, after], series)
    }

    /// [`AnyPolynomial::between`] for systems with rotations: the polynomial of a quaternion matches the
    /// rates of its components, and that of the angular velocity, of degree 3, matches value and rate at both
    /// nodes. If the velocities and accelerations of nodes are differences of positions ([`super::Run::has_differences`]), so is that of every
    /// velocity: the rate of a polynomial through positions and differences of them has errors of the first order in its own rate.
    pub(crate) fn through(
        rotations: &[usize],
        differences: bool,
        [before, after]: [&AnyNode<'_>; 2],
        series: &'f mut Series,
    ) -> Self {
        let h = after.t - before.t;
        let known = before.a.iter().chain(after.a).all(|a| a.is_finite());
        series.resize(before.q.len());
        for i in 0..before.q.len() {
            let end = |node: &AnyNode<'_>| [node.q[i], node.v[i], node.a[i]];
            series.fill(i, &column([end(before), end(after)], h, known));
            if differences && known {
                let moving = |node: &AnyNode<'_>| [node.v[i], node.a[i], f64::NAN];
                series.fill_velocity(i, &column([moving(before), moving(after)], h, false));
            }
        }
        for &first in rotations {
            let ends = [before, after].map(|node| rotation::rates(first, [node.q, node.v, node.a]));
            for k in 0..rotation::SLOTS {
                let [start, end] = ends.map(|rates| rates.map(|component| component[k]));
                series.fill(first + k, &column([start, end], h, known));
                let turning = |node: &AnyNode<'_>| [node.v[first + k], node.a[first + k], f64::NAN];
                series.fill_velocity(first + k, &column([turning(before), turning(after)], h, false));
            }
        }
        Self {
            series,
            t: Compensated::exact([before.t]),
            from: 0.0,
            to: h,
            search: Search::NODES,
            resting: [&[]; 2],
        }
    }

    /// The time where the polynomial begins.
    #[must_use]
    pub fn start(&self) -> f64 {
        self.time(self.from)
    }

    /// The time where the polynomial ends.
    #[must_use]
    pub fn end(&self) -> f64 {
        self.time(self.to)
    }

    /// The length of its time interval, negative back in time.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.to - self.from
    }

    /// The series itself; see [`Polynomial::series`].
    #[must_use]
    pub fn series(&self) -> &'f Series {
        self.series
    }

    /// The time `s` after the point of expansion.
    pub(crate) fn time(&self, s: f64) -> f64 {
        let mut t = self.t;
        t.add(&[s]);
        t.hi[0]
    }

    /// The time since the point of expansion.
    pub(crate) fn since(&self, t: f64) -> f64 {
        (t - self.t.hi[0]) - self.t.lo[0]
    }

    /// Position, velocity and acceleration a time `s` after the point of expansion.
    pub(crate) fn point(&self, s: f64, point: &mut OwnedPoint<f64>) {
        let (vectors, t) = point.parts();
        self.series.point(s, vectors);
        *t = self.time(s);
    }

    /// Position, velocity and acceleration at the time `t`, written to a point of as many coordinates.
    pub(crate) fn at(&self, t: f64, point: &mut OwnedPoint<f64>) {
        self.point(self.since(t), point);
    }
}

/// The coefficients of the polynomial of degree 5 with given value and two derivatives at both ends, a
/// distance `h` apart; of degree 3 with the first derivatives alone if the second ones are not `known`.
fn column([[q, v, a], [next_q, next_v, next_a]]: [[f64; 3]; 2], h: f64, known: bool) -> [f64; 6] {
    let [v, next_v, a, next_a] = [h * v, h * next_v, h * h * a, h * h * next_a];
    // remainder of the motion after its second-order Taylor polynomial, in units of the step
    let mut column = if known {
        let (d, v_left, a_left) = ((next_q - q) - (v + 0.5 * a), next_v - (v + a), next_a - a);
        [
            q,
            v,
            0.5 * a,
            10.0 * d - 4.0 * v_left + 0.5 * a_left,
            -15.0 * d + 7.0 * v_left - a_left,
            6.0 * d - 3.0 * v_left + 0.5 * a_left,
        ]
    } else {
        let (d, v_left) = ((next_q - q) - v, next_v - v);
        [q, v, 3.0 * d - v_left, v_left - 2.0 * d, 0.0, 0.0]
    };
    let mut power = 1.0;
    for c in &mut column {
        *c /= power;
        power *= h;
    }
    column
}

impl<'f, const N: usize> Polynomial<'f, N> {
    /// The polynomial with its number of coordinates.
    pub(crate) fn of(any: AnyPolynomial<'f>) -> Self {
        Self(any)
    }

    /// The polynomial of degree 5 through position, velocity and acceleration at both nodes, for coordinates
    /// that are numbers. If an acceleration is not known, it has degree 3 and goes through positions and
    /// velocities. Its coefficients are written to `series`.
    ///
    /// # Error
    ///
    /// If the nodes are exact, the error is of order `h⁶` in the position, `h⁵` in the velocity and `h⁴` in the acceleration. So
    /// with a [`crate::ComposedFlow`] of order `p`, positions between the nodes, and events of positions, are of order `min(p, 6)`. The
    /// velocities and accelerations of a [`crate::Flow`] are differences of positions, of second order like these. The polynomial through them
    /// is of second order in the position and the velocity, but only of first order in the acceleration. So in the polynomials of
    /// [`crate::Stepper::trace`] and in [`crate::Trajectory::at`] the velocity of a `Flow` is a polynomial of its own, of degree 3 through
    /// velocities and accelerations: there everything between the nodes is of second order. An exception is the acceleration in a step that
    /// begins with a velocity that is no difference: the first one, and one where an input has changed.
    pub fn between(before: &Node<N>, after: &Node<N>, series: &'f mut Series) -> Self {
        Self(AnyPolynomial::between(&before.any(), &after.any(), series))
    }

    /// [`Polynomial::between`] for systems with rotations.
    pub(crate) fn through(
        rotations: &[usize],
        differences: bool,
        [before, after]: [&Node<N>; 2],
        series: &'f mut Series,
    ) -> Self {
        let nodes = [&before.any(), &after.any()];
        Self(AnyPolynomial::through(rotations, differences, nodes, series))
    }

    /// The time where the polynomial begins.
    #[must_use]
    pub fn start(&self) -> f64 {
        self.0.start()
    }

    /// The time where the polynomial ends.
    #[must_use]
    pub fn end(&self) -> f64 {
        self.0.end()
    }

    /// The length of its time interval, negative back in time.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.0.length()
    }

    /// The series itself, about [`Polynomial::start`]. If a step of a [`crate::TaylorFlow`] is shown in parts, all parts have the
    /// series about the start of the first.
    #[must_use]
    pub fn series(&self) -> &'f Series {
        self.0.series
    }

    /// Position, velocity and acceleration at the time `t`.
    #[must_use]
    pub fn at(&self, t: f64) -> Point<f64, N> {
        let s = self.0.since(t);
        let [mut q, mut v, mut a] = [[0.0; N]; 3];
        self.0.series.point(s, [&mut q, &mut v, &mut a]);
        Point {
            t: self.0.time(s),
            q,
            v,
            a,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solve::newton::Stop;

    /// A node of `x = t⁵ - 2 t³ + t`.
    fn node(t: f64, a: f64) -> Node<1> {
        Node {
            index: 0,
            t,
            q: [t.powi(5) - 2.0 * t.powi(3) + t],
            v: [5.0 * t.powi(4) - 6.0 * t.powi(2) + 1.0],
            a: [a * (20.0 * t.powi(3) - 12.0 * t)],
            force: [0.0],
            energy: 0.0,
            iterations: 0,
            stop: Stop::Start,
        }
    }

    #[test]
    fn a_polynomial_of_degree_5_is_its_own() {
        for (from, to) in [(0.5, 1.75), (1.75, 0.5)] {
            let mut series = Series::new(1, AnyPolynomial::ORDER);
            let polynomial: Polynomial<'_, 1> =
                Polynomial::between(&node(from, 1.0), &node(to, 1.0), &mut series);
            assert_eq!((polynomial.start(), polynomial.end()), (from, to));
            for t in [0.5, 0.9, 1.3, 1.75] {
                let (found, exact) = (polynomial.at(t), node(t, 1.0));
                for (x, y) in [(found.q, exact.q), (found.v, exact.v), (found.a, exact.a)] {
                    assert!((x[0] - y[0]).abs() < 1e-12, "{t}: {x:?} {y:?}");
                }
            }
        }
    }

    #[test]
    fn without_accelerations_it_is_a_cubic() {
        let mut series = Series::new(1, AnyPolynomial::ORDER);
        let polynomial: Polynomial<'_, 1> =
            Polynomial::between(&node(0.5, f64::NAN), &node(0.75, 1.0), &mut series);
        for t in [0.5, 0.75] {
            assert!((polynomial.at(t).q[0] - node(t, 1.0).q[0]).abs() < 1e-15);
            assert!((polynomial.at(t).v[0] - node(t, 1.0).v[0]).abs() < 1e-14);
        }
        assert!((polynomial.at(0.6).q[0] - node(0.6, 1.0).q[0]).abs() < 1e-3);
    }
}
