//! A declaration on its tape, evaluated in any type of number.

use crate::number::bounded::Bounded;
use crate::number::point::{AnyLeg, AnyPoint, OwnedPoint};
use crate::number::scalar::Scalar as _;
use crate::samples::Samples;
use crate::solve::rotation;
use crate::tape::Shape;
use crate::tape::origin::{Origin, large, origin, result, turning, without_derivative};
use crate::tape::quantity::Quantity;
use crate::tape::{CallData, Leaf, Number, Part, Segment, Source};

/// The numbers of a table of samples among the results of [`Segment::Tables`]: its place, whether it is differentiated, its argument.
const TABLE: usize = 3;

/// The numbers of a function among the results of [`Segment::Steep`]: its exponent, its argument.
const STEEP: usize = 2;

/// A table of samples, evaluated at a point of a motion.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TableAt<'d> {
    /// The table.
    pub samples: &'d Samples,
    /// Whether it is differentiated anywhere in the declaration.
    pub is_differentiated: bool,
    /// Its argument.
    pub argument: f64,
}

/// A function that may be flat but for a narrow feature, at a point of a motion: an exponential function, or a power. Or a periodic one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Steep {
    /// The exponent of the power; 0 for an exponential function, infinite for a periodic one.
    pub exponent: f64,
    /// The base of the power, or the argument of the exponential or periodic function.
    pub argument: f64,
}

impl Steep {
    /// Whether the function is a sine, a cosine or a tangent.
    pub fn is_periodic(self) -> bool {
        self.exponent == f64::INFINITY
    }

    /// The logarithm of the power, or the argument of the exponential function: the function is flat where this is far below its largest
    /// value nearby.
    pub fn logarithm(self) -> f64 {
        if self.exponent == 0.0 || self.is_periodic() {
            self.argument
        } else {
            self.exponent * self.argument.abs().ln()
        }
    }
}

/// Relative difference of two values that are equal but for rounding.
const EQUAL: f64 = 1e-9;

/// The declaration of a system: its tape, and the values of its parameters.
///
/// Everything that is not part of every step is evaluated here, with one evaluator for all systems (module
/// `tape`). Methods of a step take its first two nodes as a [`Leg`](crate::Leg) and first evaluate the
/// constants of the parameters; nothing is kept between two calls.
#[derive(Clone, Copy)]
pub struct Declaration<'s> {
    source: &'s dyn Source,
    /// The values of the parameters; empty for the system's own.
    values: &'s [f64],
    /// In third order, the second difference that ends with a step's middle node; empty for zero.
    past: &'s [f64],
    /// The rates of the parameters, for numbers that carry a derivative; parameters beyond the last are
    /// constant.
    rates: &'s [f64],
}

/// The arguments of expressions; missing ones are empty, and read as NaN.
#[derive(Clone, Copy, Debug)]
struct At<'a, T> {
    h: Option<T>,
    /// The time at a point.
    t: Option<T>,
    /// The time of a step's middle node.
    clock: Option<T>,
    q: &'a [T],
    v: &'a [T],
    a: &'a [T],
    j: &'a [T],
    node: &'a [T],
    increment: &'a [T],
    /// The last second difference; empty for that of the declaration.
    past: &'a [T],
    e: &'a [T],
    z: &'a [T],
    multipliers: &'a [T],
    sides: &'a [T],
}

impl<'a, T> At<'a, T> {
    /// No arguments.
    const NOWHERE: Self = Self {
        h: None,
        t: None,
        clock: None,
        q: &[],
        v: &[],
        a: &[],
        j: &[],
        node: &[],
        increment: &[],
        past: &[],
        e: &[],
        z: &[],
        multipliers: &[],
        sides: &[],
    };

    /// The first two nodes of a step.
    fn leg(h: T, leg: AnyLeg<'a, T>) -> Self {
        Self {
            h: Some(h),
            clock: Some(leg.t),
            node: leg.q,
            increment: leg.d,
            ..Self::NOWHERE
        }
    }

    /// A point of the continuous system.
    fn point(point: AnyPoint<'a, T>) -> Self {
        Self {
            t: Some(point.t),
            q: point.q,
            v: point.v,
            a: point.a,
            ..Self::NOWHERE
        }
    }
}

/// Evaluates a part of a segment.
fn evaluate<T: Number>(
    declaration: &Declaration<'_>,
    segment: Segment,
    part: Part,
    at: &At<'_, T>,
    result: &mut dyn FnMut(usize, T),
) {
    let (source, leaf) = (declaration.source, leaves(declaration, at));
    T::walk(source.tape().program(segment, part), source, &leaf, result);
}

/// The values of the leaves of expressions.
fn leaves<'a, T: Number>(declaration: &'a Declaration<'a>, at: &'a At<'a, T>) -> impl Fn(Leaf) -> T + 'a {
    let Declaration { past, rates, .. } = *declaration;
    move |leaf: Leaf| {
        let (vector, i) = match leaf {
            Leaf::H => return at.h.unwrap_or(T::splat(f64::NAN)),
            Leaf::T => return at.t.unwrap_or(T::splat(f64::NAN)),
            Leaf::Clock => return at.clock.unwrap_or(T::splat(f64::NAN)),
            Leaf::Parameter(i) => {
                let rate = rates.get(i).copied().unwrap_or(0.0);
                return T::changing(declaration.value(i), rate);
            }
            Leaf::Q(i) => (at.q, i),
            Leaf::V(i) => (at.v, i),
            Leaf::A(i) => (at.a, i),
            Leaf::N(i) => (at.node, i),
            Leaf::D(i) => (at.increment, i),
            Leaf::J(i) => (at.j, i),
            Leaf::P(i) if at.past.is_empty() => {
                return T::splat(past.get(i).copied().unwrap_or(0.0));
            }
            // a declaration's programs compute these themselves
            Leaf::Constant(_) | Leaf::Known(_) => return T::splat(f64::NAN),
            Leaf::P(i) => (at.past, i),
            Leaf::E(i) => (at.e, i),
            Leaf::Z(i) => (at.z, i),
            Leaf::Side(i) => (at.sides, i),
            // missing ones are zero
            Leaf::Lambda(i) => return at.multipliers.get(i).copied().unwrap_or(T::splat(0.0)),
        };
        vector.get(i).copied().unwrap_or(T::splat(f64::NAN))
    }
}

impl<'s> Declaration<'s> {
    /// The declaration of a system.
    pub fn of(system: &'s dyn Source) -> Self {
        Self {
            source: system,
            values: &[],
            past: &[],
            rates: &[],
        }
    }

    /// The declaration for a step of third order, after the second difference that ends with its middle node.
    #[must_use]
    pub(crate) fn after<'p>(self, past: &'p [f64]) -> Declaration<'p>
    where
        's: 'p,
    {
        Declaration { past, ..self }
    }

    /// The declaration with other values of all parameters.
    #[must_use]
    pub fn with<'p>(self, values: &'p [f64]) -> Declaration<'p>
    where
        's: 'p,
    {
        Declaration { values, ..self }
    }

    /// The value of a parameter; NaN beyond the last.
    #[must_use]
    pub fn value(&self, parameter: usize) -> f64 {
        if self.values.is_empty() {
            self.source.value(parameter)
        } else {
            self.values.get(parameter).copied().unwrap_or(f64::NAN)
        }
    }

    /// The names, counts and kinds of the declaration.
    #[must_use]
    pub fn shape(&self) -> &'s Shape {
        self.source.shape()
    }

    /// The number of coordinates.
    #[must_use]
    pub fn dimension(&self) -> usize {
        self.shape().dimension()
    }

    /// The coordinates.
    pub(crate) fn coordinates(&self) -> &'s [Quantity] {
        &self.shape().coordinates
    }

    /// The parameters.
    pub(crate) fn parameters(&self) -> &'s [Quantity] {
        &self.shape().parameters
    }

    /// The numbers of holonomic, nonholonomic and kinematic constraints.
    pub(crate) fn constraints(&self) -> [usize; 3] {
        let shape = self.shape();
        [shape.holonomic, shape.nonholonomic, shape.kinematic]
    }

    /// The declaration with parameters that change at the given rates, in numbers that carry a derivative
    /// ([`crate::number::tangent::Tangent`]).
    pub(crate) fn moving<'r>(&self, rates: &'r [f64]) -> Declaration<'r>
    where
        's: 'r,
    {
        Declaration { rates, ..*self }
    }

    /// The source of parameters and calls.
    pub(crate) fn source(&self) -> &'s dyn Source {
        self.source
    }

    /// Allocates the memory of this thread for the steps and nodes of a run.
    pub(crate) fn prepare(&self) {
        let tape = self.source.tape();
        Bounded::prepare(tape.program(Segment::Residual, Part::Head));
        Bounded::prepare(tape.program(Segment::Continuous, Part::Head));
        for segment in [
            Segment::Continuous,
            Segment::ContinuousForce,
            Segment::Energy,
            Segment::Observe,
        ] {
            f64::prepare(tape.program(segment, Part::All));
        }
        for part in [Part::Head, Part::Tail] {
            f64::prepare(tape.program(Segment::PhaseSlopes, part));
        }
        if self.has_external_forces() {
            for segment in [Segment::ExternalForces, Segment::Arriving] {
                f64::prepare(tape.program(segment, Part::All));
            }
        }
    }

    fn all<T: Number>(&self, segment: Segment, part: Part, at: &At<'_, T>) -> Vec<T> {
        let mut results = Vec::with_capacity(self.source.tape().count(segment, part));
        evaluate(self, segment, part, at, &mut |_, value| {
            results.push(value);
        });
        results
    }

    fn into<T: Number>(&self, segment: Segment, part: Part, at: &At<'_, T>, out: &mut [T]) {
        evaluate(self, segment, part, at, &mut |place, value| {
            if let Some(out) = out.get_mut(place) {
                *out = value;
            }
        });
    }

    fn vector<T: Number>(&self, segment: Segment, part: Part, at: &At<'_, T>) -> Vec<T> {
        let mut vector = vec![T::splat(f64::NAN); self.dimension()];
        self.into(segment, part, at, &mut vector);
        vector
    }

    fn scalar<T: Number>(&self, segment: Segment, at: &At<'_, T>) -> T {
        let mut scalar = [T::splat(f64::NAN)];
        self.into(segment, Part::All, at, &mut scalar);
        scalar[0]
    }

    /// The results of a segment, as vectors of as many components as there are coordinates.
    fn vectors<T: Number>(&self, segment: Segment, at: &At<'_, T>) -> Vec<Vec<T>> {
        let n = self.dimension().max(1);
        let mut vectors: Vec<Vec<T>> = Vec::with_capacity(self.count(segment, Part::All) / n);
        evaluate(self, segment, Part::All, at, &mut |place, value| {
            if place % n == 0 {
                vectors.push(Vec::with_capacity(n));
            }
            if let Some(vector) = vectors.last_mut() {
                vector.push(value);
            }
        });
        vectors
    }

    /// The number of results of a part of a segment.
    fn count(&self, segment: Segment, part: Part) -> usize {
        self.source.tape().count(segment, part)
    }

    /// The number of unknowns of a step.
    #[must_use]
    pub fn unknowns(&self) -> usize {
        self.count(Segment::Unknown, Part::All)
    }

    /// The number of holonomic constraints.
    #[must_use]
    pub fn holonomic(&self) -> usize {
        self.count(Segment::Phase, Part::Head)
    }

    /// The number of constraints on positions and on velocities.
    #[must_use]
    pub fn lower(&self) -> usize {
        self.count(Segment::Pair, Part::All)
    }

    /// The number of declared constraint forms.
    #[must_use]
    pub fn forms_count(&self) -> usize {
        self.count(Segment::Forms, Part::All) / self.dimension().max(1)
    }

    /// Whether multipliers are among the unknowns.
    #[must_use]
    pub fn has_multipliers(&self) -> bool {
        self.count(Segment::Continuous, Part::Head) > self.dimension()
    }

    /// The constants of a run with the step `h`, in the order of
    /// [`Compiled::constants`](crate::kernel::generated::Compiled::constants).
    pub fn constants<T: Number>(&self, h: T) -> Vec<T> {
        let at = At {
            h: Some(h),
            ..At::NOWHERE
        };
        self.all(Segment::Constants, Part::All, &at)
    }

    /// The known values of a step, in the order of
    /// [`Compiled::known`](crate::kernel::generated::Compiled::known).
    pub fn known<T: Number>(&self, h: T, leg: AnyLeg<'_, T>) -> Vec<T> {
        self.all(Segment::Known, Part::All, &At::leg(h, leg))
    }

    /// The rows of the step at the unknowns `z`.
    pub fn rows<T: Number>(&self, h: T, leg: AnyLeg<'_, T>, z: &[T]) -> Vec<T> {
        let at = At { z, ..At::leg(h, leg) };
        self.all(Segment::Residual, Part::Head, &at)
    }

    /// A bound of the rounding error of each row, as many as `out` has room for. Nothing is allocated.
    pub fn bounds(&self, h: f64, leg: AnyLeg<'_, f64>, z: &[f64], out: &mut [f64]) {
        let leaf = |leaf: Leaf| {
            let value = match leaf {
                Leaf::H => Some(&h),
                Leaf::Clock => Some(&leg.t),
                Leaf::Parameter(i) => return Bounded::splat(self.value(i)),
                Leaf::N(i) => leg.q.get(i),
                Leaf::D(i) => leg.d.get(i),
                Leaf::P(i) => self.past.get(i),
                Leaf::Z(i) => z.get(i),
                _ => None,
            };
            Bounded::splat(value.copied().unwrap_or(f64::NAN))
        };
        let program = self.source.tape().program(Segment::Residual, Part::Head);
        Bounded::walk(program, self.source, &leaf, &mut |place, row| {
            if let Some(out) = out.get_mut(place) {
                *out = row.error();
            }
        });
    }

    /// A bound of the rounding error of each row of the continuous system, as many as `out` has room for.
    /// Nothing is allocated.
    pub(crate) fn continuous_bounds(&self, point: AnyPoint<'_, f64>, multipliers: &[f64], out: &mut [f64]) {
        let leaf = |leaf: Leaf| {
            let value = match leaf {
                Leaf::Parameter(i) => return Bounded::splat(self.value(i)),
                Leaf::T => Some(&point.t),
                Leaf::Q(i) => point.q.get(i),
                Leaf::V(i) => point.v.get(i),
                Leaf::A(i) => point.a.get(i),
                Leaf::Lambda(i) => multipliers.get(i),
                _ => None,
            };
            Bounded::splat(value.copied().unwrap_or(f64::NAN))
        };
        let program = self.source.tape().program(Segment::Continuous, Part::Head);
        Bounded::walk(program, self.source, &leaf, &mut |place, row| {
            if let Some(out) = out.get_mut(place) {
                *out = row.error();
            }
        });
    }

    /// The Jacobian `∂row/∂z` of the rows, row by row.
    pub fn jacobian<T: Number>(&self, h: T, leg: AnyLeg<'_, T>, z: &[T]) -> Vec<T> {
        let at = At { z, ..At::leg(h, leg) };
        self.all(Segment::Residual, Part::Tail, &at)
    }

    /// The factor of each row, the row over the declared one: denominators that were multiplied out, and
    /// dropped factors of the parameters and of `h`.
    pub fn scales<T: Number>(&self, h: T, leg: AnyLeg<'_, T>, z: &[T]) -> Vec<T> {
        let at = At { z, ..At::leg(h, leg) };
        self.all(Segment::Scales, Part::All, &at)
    }

    /// The unknowns of a second difference and of multipliers. Missing multipliers are zero, surplus ones are
    /// ignored.
    pub fn unknown<T: Number>(&self, e: &[T], multipliers: &[T]) -> Vec<T> {
        let at = At {
            e,
            multipliers,
            ..At::NOWHERE
        };
        self.all(Segment::Unknown, Part::All, &at)
    }

    /// The second difference of the unknowns.
    pub fn second_difference<T: Number>(&self, h: T, leg: AnyLeg<'_, T>, z: &[T]) -> Vec<T> {
        let at = At { z, ..At::leg(h, leg) };
        self.vector(Segment::SecondDifference, Part::All, &at)
    }

    /// `φ_{D_K}⁻¹(q0, q1, q2)`, the point at which the kinematic constraints are imposed.
    pub fn point<T: Number>(&self, h: T, leg: AnyLeg<'_, T>, e: &[T]) -> OwnedPoint<T> {
        let at = At { e, ..At::leg(h, leg) };
        let n = self.dimension();
        let mut values = vec![T::splat(f64::NAN); 3 * n + 1];
        self.into(Segment::Node, Part::Head, &at, &mut values);
        OwnedPoint::new(n, values)
    }

    /// The generalized constraint force at `q1`, `Q = -(D₁L_d(q1,q2) + D₂L_d(q0,q1))`, in units of `L` per unit of the coordinate.
    pub fn force<T: Number>(&self, h: T, leg: AnyLeg<'_, T>, e: &[T]) -> Vec<T> {
        let at = At { e, ..At::leg(h, leg) };
        self.vector(Segment::Node, Part::Tail, &at)
    }

    /// The forms `α_j` in whose directions the constraint forces of a step act, `Q = Σ λ_j α_j`.
    pub fn forms<T: Number>(&self, h: T, leg: AnyLeg<'_, T>, e: &[T]) -> Vec<Vec<T>> {
        let at = At { e, ..At::leg(h, leg) };
        self.vectors(Segment::Forms, &at)
    }

    /// The rows of the continuous system at a point: the constraints, those of lower order differentiated
    /// until accelerations occur, then the works `⟨u, Q⟩` along the fields; if no fields are known,
    /// `Q - Σ λ_j α_j` instead.
    pub fn continuous<T: Number>(&self, point: AnyPoint<'_, T>, multipliers: &[T]) -> Vec<T> {
        let at = At {
            multipliers,
            ..At::point(point)
        };
        self.all(Segment::Continuous, Part::Head, &at)
    }

    /// [`Declaration::continuous`] with the third derivative `j`, for constraints of third order, whose rows
    /// are the constraints themselves.
    pub(crate) fn continuous_of_third<T: Number>(
        &self,
        point: AnyPoint<'_, T>,
        j: &[T],
        multipliers: &[T],
    ) -> Vec<T> {
        let at = At {
            j,
            multipliers,
            ..At::point(point)
        };
        self.all(Segment::Continuous, Part::Head, &at)
    }

    /// The rows of the continuous system, then their Jacobian by accelerations and multipliers, row by row.
    pub fn continuous_with_jacobian<T: Number>(&self, point: AnyPoint<'_, T>, multipliers: &[T]) -> Vec<T> {
        let at = At {
            multipliers,
            ..At::point(point)
        };
        self.all(Segment::Continuous, Part::All, &at)
    }

    /// [`Declaration::continuous_with_jacobian`] into slices. Nothing is allocated.
    pub(crate) fn linearize_continuous(
        &self,
        point: AnyPoint<'_, f64>,
        multipliers: &[f64],
        rows: &mut [f64],
        jacobian: &mut [f64],
    ) {
        let at = At {
            multipliers,
            ..At::point(point)
        };
        let count = rows.len();
        evaluate(self, Segment::Continuous, Part::All, &at, &mut |place, value| {
            let entry = match place.checked_sub(count) {
                None => rows.get_mut(place),
                Some(place) => jacobian.get_mut(place),
            };
            if let Some(entry) = entry {
                *entry = value;
            }
        });
    }

    /// The first expression without a finite value in the rows of the continuous system or in their Jacobian.
    #[cold]
    pub(crate) fn origin_of_point(
        &self,
        point: AnyPoint<'_, f64>,
        name: &dyn Fn(Leaf) -> String,
    ) -> Option<Origin> {
        let at = At::point(point);
        origin(self.source, Segment::Continuous, &leaves(self, &at), name)
    }

    /// The first exponential in the rows of the continuous system above a size.
    #[cold]
    pub(crate) fn large(
        &self,
        point: AnyPoint<'_, f64>,
        size: f64,
        name: &dyn Fn(Leaf) -> String,
    ) -> Option<Origin> {
        let at = At::point(point);
        large(self.source, Segment::Continuous, size, &leaves(self, &at), name)
    }

    /// The argument of a sine, a cosine or a tangent that differs most between two points, as it is written in the declaration, and the
    /// difference, in rad: of those that differ by more than `least`, and on which the equations of the continuous system depend. Arguments with
    /// the time are left out: steps look at these themselves.
    #[cold]
    #[must_use]
    pub fn largest_turn(
        &self,
        from: AnyPoint<'_, f64>,
        to: AnyPoint<'_, f64>,
        least: f64,
    ) -> Option<(String, f64)> {
        let at = [At::point(from), At::point(to)];
        let [before, after] = [leaves(self, &at[0]), leaves(self, &at[1])];
        let name = |leaf| crate::regularity::undefined::named(self, leaf);
        let turning = turning(self.source, Segment::Continuous, least, [&before, &after], &name);
        let matters = |argument: &Origin| {
            let mut beside = to.q.to_vec();
            for (leaf, _) in &argument.leaves {
                if let &Leaf::Q(i) = leaf {
                    beside[i] -= (to.q[i] - from.q[i]) / argument.value;
                }
            }
            self.depends_on_position(to, &beside)
        };
        turning
            .into_iter()
            .filter(matters)
            .max_by(|a, b| a.value.total_cmp(&b.value))
            .map(|argument| (argument.text, argument.value))
    }

    /// Whether the equations of the continuous system differ between a point and another position, by more than rounding.
    fn depends_on_position(&self, point: AnyPoint<'_, f64>, position: &[f64]) -> bool {
        // at rest nothing shows that a mass depends on the position, and in equilibrium rows are zero
        let moved = |x: &[f64]| -> Vec<f64> { x.iter().map(|x| x + 1.0).collect() };
        let (v, a) = (moved(point.v), moved(point.a));
        let multipliers = vec![1.0; self.forms_count()];
        let [here, there] = [point.q, position].map(|q| {
            let point = AnyPoint {
                t: point.t,
                q,
                v: &v,
                a: &a,
            };
            self.continuous(point, &multipliers)
        });
        (here.iter().zip(&there)).any(|(x, y)| (x - y).abs() > EQUAL * x.abs().max(y.abs()))
    }

    /// The first expression in the rows of the continuous system that has a value and no derivative.
    #[cold]
    pub(crate) fn without_derivative(
        &self,
        point: AnyPoint<'_, f64>,
        name: &dyn Fn(Leaf) -> String,
    ) -> Option<Origin> {
        let at = At::point(point);
        without_derivative(self.source, Segment::Continuous, &leaves(self, &at), name)
    }

    /// The continuous system's generalized constraint force, `Q = -D_{EL}L = d/dt ∂L/∂v - ∂L/∂q`, at a point.
    pub fn continuous_force<T: Number>(&self, point: AnyPoint<'_, T>) -> Vec<T> {
        self.vector(Segment::ContinuousForce, Part::All, &At::point(point))
    }

    /// [`Declaration::continuous_force`], into `out`. Nothing is allocated.
    pub fn continuous_force_into<T: Number>(&self, point: AnyPoint<'_, T>, out: &mut [T]) {
        out.fill(T::splat(f64::NAN));
        self.into(Segment::ContinuousForce, Part::All, &At::point(point), out);
    }

    /// The forms of the continuous system's constraint forces at a point.
    pub fn continuous_forms<T: Number>(&self, point: AnyPoint<'_, T>) -> Vec<Vec<T>> {
        self.vectors(Segment::ContinuousForms, &At::point(point))
    }

    /// The rows of the holonomic and nonholonomic constraints at a position and a velocity: `g(t, q)`, then
    /// `c(t, q, v)`, then `dg/dt`.
    pub fn phase<T: Number>(&self, t: T, q: &[T], v: &[T]) -> Vec<T> {
        let at = At {
            t: Some(t),
            q,
            v,
            ..At::NOWHERE
        };
        self.all(Segment::Phase, Part::All, &at)
    }

    /// The rows of these constraints on a leg of the discrete path: `g(q1)`, then `c(φ⁻¹(q0, q1))`.
    pub fn pair<T: Number>(&self, h: T, leg: AnyLeg<'_, T>) -> Vec<T> {
        self.all(Segment::Pair, Part::All, &At::leg(h, leg))
    }

    /// The Lagrangian `L(t, q, v)`.
    pub fn lagrangian<T: Number>(&self, t: T, q: &[T], v: &[T]) -> T {
        let at = At {
            t: Some(t),
            q,
            v,
            ..At::NOWHERE
        };
        self.scalar(Segment::Lagrangian, &at)
    }

    /// The discrete Lagrangian `L_d(q0, q1)` on a leg.
    pub fn discrete_lagrangian<T: Number>(&self, h: T, leg: AnyLeg<'_, T>) -> T {
        self.scalar(Segment::DiscreteLagrangian, &At::leg(h, leg))
    }

    /// The energy `⟨∂L/∂v, v⟩ - L`.
    pub fn energy<T: Number>(&self, t: T, q: &[T], v: &[T]) -> T {
        let at = At {
            t: Some(t),
            q,
            v,
            ..At::NOWHERE
        };
        self.scalar(Segment::Energy, &at)
    }

    /// The rows of a step as declared: the constraints, then the works `⟨u, Q⟩` or `Q - Σ λ_j α_j`. A
    /// holonomic constraint has the row `g(q2) − (1 − 2⁻¹⁰) g(q1)`. At nodes on the constraint this is
    /// `g(q2)` up to rounding. The rounding error at the middle node is removed little by little, since its
    /// removal in one step would show in the second difference.
    pub fn declared<T: Number>(&self, h: T, leg: AnyLeg<'_, T>, e: &[T], multipliers: &[T]) -> Vec<T> {
        let at = At {
            e,
            multipliers,
            ..At::leg(h, leg)
        };
        self.all(Segment::Declared, Part::All, &at)
    }

    /// [`Declaration::declared`] for a step of third order, with the last second difference `past` and the
    /// third difference `e`.
    pub(crate) fn declared_after<T: Number>(
        &self,
        h: T,
        leg: AnyLeg<'_, T>,
        past: &[T],
        e: &[T],
        multipliers: &[T],
    ) -> Vec<T> {
        let at = At {
            past,
            e,
            multipliers,
            ..At::leg(h, leg)
        };
        self.all(Segment::Declared, Part::All, &at)
    }

    /// The rows of the holonomic constraints at a position, or of all constraints of lower order at a
    /// velocity, and their derivatives by its components, row by row, as many as `out` has room for. Nothing
    /// is allocated.
    pub(crate) fn phase_slopes(&self, of_velocity: bool, t: f64, q: &[f64], v: &[f64], out: &mut [f64]) {
        let at = At {
            t: Some(t),
            q,
            v,
            ..At::NOWHERE
        };
        let part = if of_velocity { Part::Tail } else { Part::Head };
        self.into(Segment::PhaseSlopes, part, &at, out);
    }

    /// Whether external forces act.
    #[must_use]
    pub fn has_external_forces(&self) -> bool {
        self.count(Segment::ExternalForces, Part::All) > 0
    }

    /// The external forces `f(t, q, v)`, in units of `L` per unit of the coordinate; zero if none are
    /// declared. Nothing is allocated.
    pub fn external_forces<T: Number>(&self, t: T, q: &[T], v: &[T], out: &mut [T]) {
        let at = At {
            t: Some(t),
            q,
            v,
            ..At::NOWHERE
        };
        out.fill(T::splat(0.0));
        self.into(Segment::ExternalForces, Part::All, &at, out);
    }

    /// The external forces on a leg, `[f⁻_d, f⁺_d]`: on its first node and on its second; zero if none are
    /// declared.
    pub fn discrete_external_forces<T: Number>(&self, h: T, leg: AnyLeg<'_, T>) -> [Vec<T>; 2] {
        let mut forces = vec![T::splat(0.0); 2 * self.dimension()];
        self.into(
            Segment::DiscreteExternalForces,
            Part::All,
            &At::leg(h, leg),
            &mut forces,
        );
        let arriving = forces.split_off(self.dimension());
        [forces, arriving]
    }

    /// The discrete external force at the second of three nodes, `f⁻_d(q1, q2) + f⁺_d(q0, q1)`, for the
    /// second difference `e`.
    pub(crate) fn external_force<T: Number>(&self, h: T, leg: AnyLeg<'_, T>, e: &[T]) -> Vec<T> {
        let d: Vec<T> = leg.d.iter().zip(e).map(|(&d, &e)| d + e).collect();
        let q = rotation::moved(&self.shape().rotations, leg.q, &d);
        let last = AnyLeg {
            t: leg.t + h,
            q: &q,
            d: &d,
        };
        let [_, mut sum] = self.discrete_external_forces(h, leg);
        let [minus, _] = self.discrete_external_forces(h, last);
        for (sum, minus) in sum.iter_mut().zip(minus) {
            *sum = *sum + minus;
        }
        sum
    }

    /// The number of arguments of functions that jump with the velocity.
    pub(crate) fn sides(&self) -> usize {
        self.count(Segment::Sides, Part::All)
    }

    /// The arguments of functions that jump with the velocity.
    pub(crate) fn side_arguments<T: Number>(&self, t: T, q: &[T], v: &[T]) -> Vec<T> {
        let at = At {
            t: Some(t),
            q,
            v,
            ..At::NOWHERE
        };
        self.all(Segment::Sides, Part::All, &at)
    }

    /// The number of arguments of all piecewise functions, and of divisors that may vanish; the first ones
    /// are those of [`Declaration::sides`].
    pub(crate) fn switches(&self) -> usize {
        self.count(Segment::Switches, Part::All)
    }

    /// The arguments of [`Declaration::switches`]; in third order they may depend on the acceleration.
    pub(crate) fn switch_arguments(&self, t: f64, q: &[f64], v: &[f64], a: &[f64]) -> Vec<f64> {
        let at = At {
            t: Some(t),
            q,
            v,
            a,
            ..At::NOWHERE
        };
        self.all(Segment::Switches, Part::All, &at)
    }

    /// The expression of an argument with its leaves: that of a piecewise function, or after all of these that of a table of samples.
    #[cold]
    pub(crate) fn argument(&self, number: usize, name: &dyn Fn(Leaf) -> String) -> Option<Origin> {
        let of = match number.checked_sub(self.switches()) {
            None => (Segment::Switches, number),
            Some(table) => (Segment::Tables, TABLE * table + TABLE - 1),
        };
        result(self.source, of, &leaves(self, &At::NOWHERE), name)
    }

    /// Whether the path of a step has to be looked at beside its nodes.
    pub(crate) fn is_switching(&self) -> bool {
        self.switches() > 0 || self.has_tables() || self.has_steep()
    }

    /// Whether there are functions that may be flat but for a narrow feature.
    pub(crate) fn has_steep(&self) -> bool {
        self.count(Segment::Steep, Part::All) > 0
    }

    /// These functions; in third order they may depend on the acceleration.
    pub(crate) fn steep(&self, t: f64, q: &[f64], v: &[f64], a: &[f64]) -> Vec<Steep> {
        let at = At {
            t: Some(t),
            q,
            v,
            a,
            ..At::NOWHERE
        };
        let all = self.all(Segment::Steep, Part::All, &at);
        let steep = all.chunks_exact(STEEP).map(|pair| Steep {
            exponent: pair[0],
            argument: pair[1],
        });
        steep.collect()
    }

    /// Whether there are tables of samples.
    pub(crate) fn has_tables(&self) -> bool {
        self.count(Segment::Tables, Part::All) > 0
    }

    /// The tables of samples that are data, each with its argument.
    pub(crate) fn tables(&self, t: f64, q: &[f64], v: &[f64], a: &[f64]) -> Vec<TableAt<'s>> {
        let at = At {
            t: Some(t),
            q,
            v,
            a,
            ..At::NOWHERE
        };
        let all = self.all(Segment::Tables, Part::All, &at);
        let tables = all.chunks_exact(TABLE).filter_map(|table| {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "the number of a call"
            )]
            let which = table[0] as usize;
            match self.source.data(which)? {
                CallData::Samples { samples, .. } => Some(TableAt {
                    samples,
                    is_differentiated: table[1] != 0.0,
                    argument: table[2],
                }),
                CallData::Number(_) => None,
            }
        });
        tables.collect()
    }

    /// The rows of [`Declaration::declared`] with given values `sides` in place of signs.
    pub(crate) fn sided<T: Number>(
        &self,
        h: T,
        leg: AnyLeg<'_, T>,
        e: &[T],
        multipliers: &[T],
        sides: &[T],
    ) -> Vec<T> {
        let at = At {
            e,
            multipliers,
            sides,
            ..At::leg(h, leg)
        };
        self.all(Segment::Sided, Part::Head, &at)
    }

    /// The constraint force of [`Declaration::force`] with given values `sides` in place of signs.
    pub(crate) fn sided_force<T: Number>(&self, h: T, leg: AnyLeg<'_, T>, e: &[T], sides: &[T]) -> Vec<T> {
        let at = At {
            e,
            sides,
            ..At::leg(h, leg)
        };
        self.all(Segment::Sided, Part::Tail, &at)
    }

    /// The rows of [`Declaration::continuous`] with given values `sides` in place of signs.
    pub(crate) fn sided_continuous<T: Number>(
        &self,
        point: AnyPoint<'_, T>,
        multipliers: &[T],
        sides: &[T],
    ) -> Vec<T> {
        let at = At {
            multipliers,
            sides,
            ..At::point(point)
        };
        self.all(Segment::SidedContinuous, Part::Head, &at)
    }

    /// The continuous system's constraint force with given values `sides` in place of signs.
    pub(crate) fn sided_continuous_force<T: Number>(&self, point: AnyPoint<'_, T>, sides: &[T]) -> Vec<T> {
        let at = At {
            sides,
            ..At::point(point)
        };
        self.vector(Segment::SidedContinuous, Part::Tail, &at)
    }

    /// The continuous system's forms with given values `sides` in place of signs.
    pub(crate) fn sided_continuous_forms<T: Number>(
        &self,
        point: AnyPoint<'_, T>,
        sides: &[T],
    ) -> Vec<Vec<T>> {
        let at = At {
            sides,
            ..At::point(point)
        };
        let mut force_and_forms = self.all(Segment::SidedContinuous, Part::Tail, &at);
        let n = self.dimension();
        let forms = force_and_forms.split_off(n.min(force_and_forms.len()));
        forms.chunks_exact(n.max(1)).map(<[T]>::to_vec).collect()
    }

    /// The momentum of a leg at its second node, `D₂L_d + f⁺_d`; for the paper's map, that of the trapezoidal
    /// rule.
    pub(crate) fn arriving<T: Number>(&self, h: T, leg: AnyLeg<'_, T>) -> Vec<T> {
        self.vector(Segment::Arriving, Part::All, &At::leg(h, leg))
    }

    /// The fields that span the virtual displacements of a step; empty if multipliers are unknowns instead.
    pub(crate) fn fields<T: Number>(&self, h: T, leg: AnyLeg<'_, T>, e: &[T]) -> Vec<Vec<T>> {
        let at = At { e, ..At::leg(h, leg) };
        self.vectors(Segment::Fields, &at)
    }

    /// The factor to be divided out of each kinematic row of a step; 1 if there is none.
    pub(crate) fn factors<T: Number>(&self, h: T, leg: AnyLeg<'_, T>, e: &[T]) -> Vec<T> {
        let at = At { e, ..At::leg(h, leg) };
        self.all(Segment::Factors, Part::All, &at)
    }

    /// The observed expressions at a point, as many as `out` has room for.
    pub fn observe<T: Number>(&self, point: AnyPoint<'_, T>, out: &mut [T]) {
        self.into(Segment::Observe, Part::All, &At::point(point), out);
    }
}
