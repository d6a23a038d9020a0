//! The paper's theorems, one by one.

pub mod contact;
mod continuous;
pub mod equations;
pub mod flow;
pub mod momentum;
pub mod power;
pub mod roots;
pub mod symplectic;
