//! Initial data of a run.

mod any;
mod begin;
mod consistency;
mod determined;
mod elsewhere;
pub(crate) mod half_leg;
mod impulse;
pub(crate) mod place;
mod rest;
mod sized;
pub(crate) mod third;
mod underflow;

pub use any::AnyStart;
pub(crate) use begin::{
    ComputedStart, InitialAcceleration, Phase, Rule, StartData, StartOrder, acceleration,
    arriving_on_constraints, check_parameters, momentum, name_of_rotation, state, state_acceleration,
    velocity_of,
};
pub(crate) use consistency::{inverse_mass, mass_matrix};
pub(crate) use determined::{Determined, check as check_determined, determinant_at, determined};
pub(crate) use impulse::velocity_after;
pub use sized::Start;
pub(crate) use underflow::check as check_underflow;
