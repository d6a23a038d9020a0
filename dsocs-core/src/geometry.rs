//! The geometry of the discrete flow: Legendre transforms, forms, the tangent map, and the paper's laws in numbers.
//!
//! Conventions. A pair of nodes `(q0, q1)` is a [`Leg`]: the node `q1` and the increment `q1 − q0`. As in the paper, the discrete
//! Lagrangian is not multiplied by the step, `L_d = L ∘ φ_{L_d}⁻¹`. So its derivatives, the discrete [Legendre
//! transforms](legendre_plus), are momenta divided by the time `h`. The same holds for the one-forms and `Ω_{L_d}`. Here the
//! [momentum](momentum_plus) is `h` times the Legendre transform, and has the units of a momentum.
//!
//! Derivatives are exact, by dual numbers through the generated code ([`Tangent`]); only your own Rust functions
//! are differentiated by finite differences. The tangent map of a step follows from the generated rows by the implicit function
//! theorem ([`DiscreteFlow::tangent`]).
//!
//! Systems are passed by reference, `&Pendulum`, as a [`Kernel`]: every declared system is one. Vectors are slices with one
//! component for each coordinate, so all of this is compiled once, for systems of any number of coordinates. [`Leg::any`] and
//! [`Point::any`](crate::Point::any) make a leg and a point of arrays into slices. In code that is generic over its [`System`],
//! [`System::kernel`] is the reference to pass.
//!
//! ```
//! use dsocs_core::geometry::{DiscreteFlow, Evolution};
//! use dsocs_core::{Leg, dsocs};
//!
//! /// A pendulum.
//! #[dsocs {
//!     coordinates(theta);
//!     lagrangian = dot(theta).powi(2) / 2 + theta.cos();
//! }]
//! struct Pendulum;
//!
//! let flow = DiscreteFlow::new(&Pendulum, 0.1)?;
//! let triple = flow.forward(Leg { t: 0.0, q: [1.0], d: [0.05] }.any())?;
//! let law = Evolution::of(&flow, &triple)?;
//! // F*Ω = Ω + dξ, and nothing constrains: dξ = 0
//! assert!(law.defect() < 1e-14 && law.change() < 1e-14);
//! // and back again
//! let first = flow.backward(triple.last(flow.h()).any())?;
//! assert!((first.leg.d[0] - 0.05).abs() < 1e-15);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod admissible;
mod array;
mod continuous;
mod error;
mod evolution;
mod expansion;
mod external;
mod form;
mod given_nodes;
mod inverse;
mod legendre;
mod map;
mod momentum;
mod nodes;
mod pairs;
mod part_errors;
mod pieces;
mod quadrature;
mod reduction;
pub(crate) mod solvable;
mod split;
mod theorem;

use crate::number::largest;
#[allow(unused_imports)] // named in the documentation
use crate::{number::point::Leg, system::System};

pub use admissible::admissible_variations;
pub use continuous::{
    Variation, canonical_form, constraint_force, legendre, legendre_with, motion, motion_near,
    position_changes, variations, velocity_after,
};
pub use error::GeometryError;
pub use evolution::Evolution;
pub use expansion::Expansion;
pub use external::{discrete_power, external_forces, force_roundings, power, power_with, work_between};
pub use form::{Displacement, TwoForm};
pub use given_nodes::{rows_at_four_given_nodes, rows_at_given_nodes};
pub use legendre::{
    discrete_form, discrete_lagrangian, legendre_minus, legendre_plus, momentum_minus, momentum_plus,
    theta_minus, theta_plus,
};
pub use map::{DiscreteFlow, TangentMap, Triple};
pub use momentum::{asymmetry, momentum_equation, momentum_map};
pub use pairs::{constraint_forms, pair_displacements, state_displacements};
pub use part_errors::{PartError, PartErrors};
pub use pieces::{corners, pieces};
pub use quadrature::mean_over;
pub use reduction::{arriving_momentum, momentum_along, momentum_balance, reduced};
#[doc(hidden)] // for the checks of order in `dsocs-systems`
pub use split::{constraint_multipliers, continuous_multipliers, multipliers_of};
pub use theorem::FlowTheorem;

use crate::kernel::Kernel;
use crate::number::point::{AnyLeg, map};
use crate::number::scalar::Scalar as _;
use crate::number::tangent::Tangent;
use crate::regularity::lengths;
use crate::regularity::multipliers::of_step;
use crate::solve::rotation;
use crate::tape::declaration::Declaration;

/// The position `q` moved by the increment `d`: their sum; for a rotation, the product of the rotations.
#[must_use]
pub fn moved(system: &dyn Kernel, q: &[f64], d: &[f64]) -> Vec<f64> {
    rotation::moved(&system.shape().rotations, q, d)
}

/// Bounds on the error of the second difference that the rounding of forces and momenta causes at a triple of
/// nodes, by coordinate; zero for a coordinate without mass.
#[must_use]
pub fn roundings(system: &dyn Kernel, h: f64, triple: &Triple) -> Vec<f64> {
    lengths::roundings(&Declaration::of(system), h, triple.leg.any(), &triple.e)
}

/// Whether the rows of a step depend on time explicitly.
#[must_use]
pub fn depends_on_time(system: &dyn Kernel, h: f64, triple: &Triple) -> bool {
    let declaration = Declaration::of(system);
    let (leg, e) = (triple.leg.any(), &triple.e);
    let multipliers = of_step(&declaration, h, leg, e);
    let fixed = |x: &[f64]| map(x, Tangent::splat);
    let [q, d, e, multipliers] = [leg.q, leg.d, e, &multipliers].map(fixed);
    let moved = AnyLeg {
        t: Tangent::new(leg.t, 1.0),
        q: &q,
        d: &d,
    };
    let rows = declaration.declared(Tangent::splat(h), moved, &e, &multipliers);
    rows.iter().any(|row| row.derivative() != 0.0)
}

/// A coordinate is at rest if its increment is shorter than this fraction of the longest.
const STILL: f64 = 1e-3;

/// Units for the derivatives by the coordinates: powers of two, which do not round, of about the magnitude of
/// a leg. Only finite differences of users' functions depend on them.
fn units(leg: AnyLeg<'_, f64>) -> Vec<f64> {
    let longest = largest(leg.d);
    let unit = |d: &f64| {
        let unit = d.abs().max(STILL * longest).log2().floor().exp2();
        if unit.is_normal() { unit } else { 1.0 }
    };
    leg.d.iter().map(unit).collect()
}
