//! Properties of a declaration: its jumps and poles, coordinates without positions, its symmetry in time.

pub(crate) mod factor;
pub(crate) mod reduction;
pub(crate) mod sides;
pub(crate) mod switches;
pub(crate) mod symmetry;
