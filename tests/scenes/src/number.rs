//! The numbers of the second formulation: plain ones, and ones with a derivative.

use core::ops::{Add, Div, Mul, Neg, Sub};

/// A number.
pub trait Number:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// A number of double precision.
    #[must_use]
    fn of(value: f64) -> Self;

    /// The square root; zero at zero.
    #[must_use]
    fn root(self) -> Self;

    /// The sine and the cosine: whoever needs one of them needs the other one, too, for its derivative.
    #[must_use]
    fn sine_cosine(self) -> (Self, Self);
}

/// A number with its derivative.
#[derive(Clone, Copy, Debug)]
pub struct Dual<T> {
    /// The number.
    pub value: T,
    /// Its derivative.
    pub slope: T,
}

impl<T: Number> Dual<T> {
    /// Numbers with their derivatives along a direction.
    pub fn along(values: &[T], slopes: &[T]) -> Vec<Self> {
        let pairs = values.iter().zip(slopes);
        pairs.map(|(&value, &slope)| Self { value, slope }).collect()
    }

    /// Constants, except for the variable at `place`.
    pub fn at(values: &[T], place: usize) -> Vec<Self> {
        let numbers = values.iter().enumerate();
        numbers
            .map(|(i, &value)| Self {
                value,
                slope: T::of(f64::from(u8::from(i == place))),
            })
            .collect()
    }

    /// Constants.
    pub fn fixed(values: &[T]) -> Vec<Self> {
        Self::at(values, values.len())
    }
}

impl<T: Number> Add for Dual<T> {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            value: self.value + other.value,
            slope: self.slope + other.slope,
        }
    }
}

impl<T: Number> Sub for Dual<T> {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self {
            value: self.value - other.value,
            slope: self.slope - other.slope,
        }
    }
}

impl<T: Number> Mul for Dual<T> {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        Self {
            value: self.value * other.value,
            slope: self.value * other.slope + self.slope * other.value,
        }
    }
}

impl<T: Number> Div for Dual<T> {
    type Output = Self;

    fn div(self, other: Self) -> Self {
        let value = self.value / other.value;
        Self {
            value,
            slope: (self.slope - value * other.slope) / other.value,
        }
    }
}

impl<T: Number> Neg for Dual<T> {
    type Output = Self;

    fn neg(self) -> Self {
        Self {
            value: -self.value,
            slope: -self.slope,
        }
    }
}

impl<T: Number> Number for Dual<T> {
    fn of(value: f64) -> Self {
        Self {
            value: T::of(value),
            slope: T::of(0.0),
        }
    }

    fn root(self) -> Self {
        let value = self.value.root();
        Self {
            value,
            slope: self.slope / (value + value),
        }
    }

    fn sine_cosine(self) -> (Self, Self) {
        let (sine, cosine) = self.value.sine_cosine();
        (
            Self {
                value: sine,
                slope: cosine * self.slope,
            },
            Self {
                value: cosine,
                slope: -(sine * self.slope),
            },
        )
    }
}
