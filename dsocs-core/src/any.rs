//! A system of any type, for what is done seldom.

use crate::error::NewtonFailure;
use crate::geometry::Declared;
use crate::start;
use crate::start::third::OfThirdOrder;
use crate::system::{Quantity, System};

/// An acceleration and multipliers.
pub(crate) type Accelerated<const N: usize> = ([f64; N], Vec<f64>);

/// What every [`System`] is where its type does not matter. Code that takes a system in this form is compiled once for each number of
/// coordinates, not for every system.
pub(crate) trait AnySystem<const N: usize>: Declared<N> {
    /// The coordinates.
    fn coordinates(&self) -> &'static [Quantity; N];

    /// The parameters, with their values.
    fn parameters(&self) -> Vec<(&'static Quantity, f64)>;

    /// How many constraints there are: holonomic, nonholonomic and kinematic ones.
    fn constraints(&self) -> [usize; 3];

    /// The places of the constraints of third order among all constraints.
    fn third_order(&self) -> &'static [usize];

    /// What only constraints of third order need; `None` where there are none, and then it is not compiled.
    fn of_third_order(&self) -> Option<&dyn OfThirdOrder<N>>;

    /// Whether time comes in anywhere.
    fn depends_on_time(&self) -> bool;

    /// Whether a factor could be declared to be divided out of a constraint, and is not.
    fn may_divide(&self) -> bool;

    /// The acceleration and the multipliers of the continuous system at `(t, q, v)`, looked for near an acceleration, or near none.
    fn acceleration(
        &self,
        at: (f64, &[f64; N], &[f64; N]),
        near: Option<&[f64; N]>,
    ) -> Result<Accelerated<N>, NewtonFailure>;
}

impl<S: System<N>, const N: usize> AnySystem<N> for S {
    fn coordinates(&self) -> &'static [Quantity; N] {
        const { &S::COORDINATES }
    }

    fn parameters(&self) -> Vec<(&'static Quantity, f64)> {
        let mut parameters = Vec::new();
        for (index, parameter) in S::PARAMETERS.iter().enumerate() {
            if let Some(value) = self.parameter(index) {
                parameters.push((parameter, value));
            }
        }
        parameters
    }

    fn constraints(&self) -> [usize; 3] {
        [S::HOLONOMIC, S::NONHOLONOMIC, S::KINEMATIC]
    }

    fn third_order(&self) -> &'static [usize] {
        S::THIRD_ORDER
    }

    fn of_third_order(&self) -> Option<&dyn OfThirdOrder<N>> {
        if const { S::ORDER > 2 } { Some(self) } else { None }
    }

    fn depends_on_time(&self) -> bool {
        S::DEPENDS_ON_TIME
    }

    fn may_divide(&self) -> bool {
        S::KINEMATIC > 0 && !S::DIVIDED
    }

    fn acceleration(
        &self,
        at: (f64, &[f64; N], &[f64; N]),
        near: Option<&[f64; N]>,
    ) -> Result<Accelerated<N>, NewtonFailure> {
        start::acceleration(self, at, near)
    }
}
