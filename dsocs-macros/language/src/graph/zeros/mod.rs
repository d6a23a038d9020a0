//! Where expressions vanish: everywhere, nowhere, or with the step.

pub(crate) mod identity;
pub(crate) mod nonzero;
pub(crate) mod power;
