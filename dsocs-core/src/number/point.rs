//! Legs and points at which equations are evaluated, as arrays and as slices.

use crate::number::scalar::Scalar;
use crate::number::tangent::Tangent;

/// A leg of the discrete path, that is, the first two nodes of a step: the second one and the increment that led to it.
///
/// The increment is stored separately, because a difference `q1 - q0` of rounded nodes loses the digits that the
/// second difference needs (see the crate's documentation, "How a declaration becomes a trajectory").
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leg<T, const N: usize> {
    /// The time of the middle node.
    pub t: T,
    /// The middle node `q1` of the step.
    pub q: [T; N],
    /// The increment `q1 - q0`.
    pub d: [T; N],
}

/// A point of the second order tangent bundle: `φ_D⁻¹(q0, q1, q2)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point<T, const N: usize> {
    /// Time.
    pub t: T,
    /// Position.
    pub q: [T; N],
    /// Velocity.
    pub v: [T; N],
    /// Acceleration.
    pub a: [T; N],
}

/// A leg of the discrete path ([`Leg`]) with any number of coordinates, by reference.
///
/// Code that takes vectors in this form is compiled once, in this crate, and not again for every number of coordinates in the crates
/// that use it.
#[derive(Clone, Copy, Debug)]
pub struct AnyLeg<'a, T> {
    /// The time of the middle node.
    pub t: T,
    /// The middle node `q1` of the step.
    pub q: &'a [T],
    /// The increment `q1 - q0`.
    pub d: &'a [T],
}

impl<T, const N: usize> Leg<T, N> {
    /// The leg on slices, for code that is compiled once for any number of coordinates.
    #[must_use]
    pub fn any(&self) -> AnyLeg<'_, T>
    where
        T: Copy,
    {
        AnyLeg {
            t: self.t,
            q: &self.q,
            d: &self.d,
        }
    }
}

impl<T: Copy> AnyLeg<'_, T> {
    /// A copy.
    #[must_use]
    pub fn to_owned(&self) -> OwnedLeg<T> {
        OwnedLeg {
            t: self.t,
            q: self.q.to_vec(),
            d: self.d.to_vec(),
        }
    }

    /// The leg in another type of number.
    pub(crate) fn map<U>(&self, mut number: impl FnMut(T) -> U) -> OwnedLeg<U> {
        OwnedLeg {
            t: number(self.t),
            q: map(self.q, &mut number),
            d: map(self.d, &mut number),
        }
    }
}

/// A leg of the discrete path ([`Leg`]) with any number of coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct OwnedLeg<T> {
    /// The time of the middle node.
    pub t: T,
    /// The middle node.
    pub q: Vec<T>,
    /// The increment.
    pub d: Vec<T>,
}

impl<T: Copy> OwnedLeg<T> {
    /// A reference to the leg.
    #[must_use]
    pub fn any(&self) -> AnyLeg<'_, T> {
        AnyLeg {
            t: self.t,
            q: &self.q,
            d: &self.d,
        }
    }
}

/// A [`Point`] with any number of coordinates, by reference.
#[derive(Clone, Copy, Debug)]
pub struct AnyPoint<'a, T> {
    /// Time.
    pub t: T,
    /// Position.
    pub q: &'a [T],
    /// Velocity.
    pub v: &'a [T],
    /// Acceleration.
    pub a: &'a [T],
}

impl<T: Scalar, const N: usize> Point<T, N> {
    /// The point as arrays; missing numbers are NaN.
    #[inline]
    pub(crate) fn of(point: AnyPoint<'_, T>) -> Self {
        Self {
            t: point.t,
            q: sized(point.q),
            v: sized(point.v),
            a: sized(point.a),
        }
    }
}

impl<T: Copy> AnyPoint<'_, T> {
    /// A copy.
    #[must_use]
    pub fn to_owned(&self) -> OwnedPoint<T> {
        OwnedPoint::new(self.q.len(), [self.q, self.v, self.a, &[self.t]].concat())
    }
}

impl<T, const N: usize> Point<T, N> {
    /// The point on slices, for code that is compiled once for any number of coordinates.
    #[must_use]
    pub fn any(&self) -> AnyPoint<'_, T>
    where
        T: Copy,
    {
        AnyPoint {
            t: self.t,
            q: &self.q,
            v: &self.v,
            a: &self.a,
        }
    }
}

/// A point with any number of coordinates.
#[derive(Clone, Debug)]
pub struct OwnedPoint<T> {
    /// The number of coordinates.
    coordinates: usize,
    /// Position, velocity and acceleration, then the time.
    values: Vec<T>,
}

impl OwnedPoint<f64> {
    /// A point of `n` coordinates, all zero.
    pub(crate) fn zero(n: usize) -> Self {
        Self::new(n, vec![0.0; 3 * n + 1])
    }

    /// The point in another type of number.
    pub(crate) fn map<T: Copy>(&self, number: impl Fn(f64) -> T) -> OwnedPoint<T> {
        OwnedPoint::new(self.coordinates, self.values.iter().map(|x| number(*x)).collect())
    }

    /// Position, velocity and acceleration, one after the other.
    pub(crate) fn vectors(&self) -> &[f64] {
        &self.values[..3 * self.coordinates]
    }

    /// Position, velocity and acceleration, and the time, mutable.
    pub(crate) fn parts(&mut self) -> ([&mut [f64]; 3], &mut f64) {
        let (q, rest) = self.values.split_at_mut(self.coordinates);
        let (v, rest) = rest.split_at_mut(self.coordinates);
        let (a, t) = rest.split_at_mut(self.coordinates);
        ([q, v, a], &mut t[0])
    }
}

impl<T: Copy> OwnedPoint<T> {
    /// The point of `n` coordinates with position, velocity and acceleration, then the time, `3n + 1` numbers.
    pub(crate) fn new(coordinates: usize, values: Vec<T>) -> Self {
        Self { coordinates, values }
    }

    /// A reference to the point.
    #[must_use]
    pub fn any(&self) -> AnyPoint<'_, T> {
        let (q, rest) = self.values.split_at(self.coordinates);
        let (v, rest) = rest.split_at(self.coordinates);
        let (a, t) = rest.split_at(self.coordinates);
        AnyPoint { t: t[0], q, v, a }
    }

    /// The point as arrays.
    #[must_use]
    pub fn sized<const N: usize>(&self) -> Point<T, N>
    where
        T: Scalar,
    {
        Point::of(self.any())
    }
}

/// Numbers in another type.
pub(crate) fn map<T: Copy, U>(numbers: &[T], number: impl FnMut(T) -> U) -> Vec<U> {
    numbers.iter().copied().map(number).collect()
}

/// The vector `x` as tangents in the direction of its component `j`.
pub(crate) fn moved(x: &[f64], j: usize) -> Vec<Tangent> {
    let numbers = x.iter().enumerate();
    numbers
        .map(|(i, &x)| Tangent::new(x, if i == j { 1.0 } else { 0.0 }))
        .collect()
}

/// Copies numbers, as many as both slices have.
#[inline]
pub(crate) fn copy(to: &mut [f64], from: &[f64]) {
    for (to, from) in to.iter_mut().zip(from) {
        *to = *from;
    }
}

/// A slice as an array; missing numbers are NaN.
pub(crate) fn sized<T: Scalar, const N: usize>(numbers: &[T]) -> [T; N] {
    if let Some(vector) = numbers.first_chunk() {
        return *vector;
    }
    let mut vector = [T::splat(f64::NAN); N];
    for (entry, number) in vector.iter_mut().zip(numbers) {
        *entry = *number;
    }
    vector
}
