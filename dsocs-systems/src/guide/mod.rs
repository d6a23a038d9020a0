//! The book: from a first system to how everything works. `cargo test` compiles and runs every listing in Rust, and runs the text files.
//! In each chapter the text file comes first, Python second, Rust third.
//!
//! | chapter | questions that it answers |
//! |---|---|
//! | [A system in a text file](text_files) | How do I write a system down, run it, plot it, without a compiler? |
//! | [In Python](python) | How do I do the same in Python? |
//! | [Your own system in ten minutes](your_own_system) | How do I do the same in Rust, with a command line of my own? |
//! | [The declaration](declaration) | Which statements are there? |
//! | [The paper in code](the_paper) | Which formula is which statement? Where do our results differ from the paper's? |
//! | [Constraints of every order and their forces](constraints) | Which statement do I use for my constraint? Which force does it have? |
//! | [Rotations and rigid bodies](rotations) | How do I write a body that turns in space: a satellite, a quadrotor, a ball that rolls? |
//! | [Symmetry](symmetry) | Which momenta are kept, and how do I see it? |
//! | [Control](control) | How does a Lyapunov function become a torque? |
//! | [Linear models and equilibria](linear_models) | Is a state of rest stable? What is `A`, `B`, `C` for my controller? |
//! | [Choosing maps](maps) | Which discretization, and what does it cost? |
//! | [Time, forces, inputs](time_forces_inputs) | How do I write friction, a motor, a digital controller? |
//! | [Which method when](methods) | Step, composition or Taylor series? Which function does what on the command line, in Python, in Rust? |
//! | [Many runs and clusters](many_runs) | How do I make ten thousand runs, on one machine or on a cluster? |
//! | [Derivatives and optimisation](derivatives) | How do I fit parameters, or plan torques? |
//! | [Two roots](two_roots) | What can I do if a step has two solutions? |
//! | [When it fails](errors) | What does this error mean, and what helps? |
//! | [The orders of the parts](orders) | How closely do `L_d`, `D_K`, `D_V` touch the exact ones, and which order follows? |
//! | [Checks and hard cases](checks) | How do I know that a run is right? |
//! | [Performance](performance) | How fast does it run, and how long does it build? |
//! | [How it works](how_it_works) | What happens between the declaration and a step? |
//!
//! Terms of the book:
//!
//! | word | meaning |
//! |---|---|
//! | node | a position `q_k` at its time `t_k` |
//! | leg | two consecutive nodes, or the motion between them |
//! | triple | three consecutive nodes; the equations of a step of the paper's method are about one triple |
//! | row | one scalar equation of a step; in a table, one line |
//! | form | a one-form: the direction of a constraint force, with one component for each coordinate |
//! | multiplier | the size `λ_j` of the constraint force along the form of one constraint |
//! | map | the rule that gives a position, a velocity and an acceleration from the nodes of a leg or a triple |
//! | discrete motion; continuous (or true) motion | the nodes that the equations of the steps determine; the solution of the differential equations |
//! | root | a solution of the equations of a step |
//! | jump, corner | a point where a function, or its derivative, is discontinuous |
//! | projection | the change that moves a start onto the constraints on positions and velocities |
//! | attitude | the rotation that turns vectors of a body into vectors of space |
//! | bar | the limit that a measured value has to meet |
//! | tape | the declaration as a list of operations, evaluated at run time where speed does not matter |
//! | lane | one of the eight runs, or steps, that are computed side by side with SIMD instructions |
//! | entry | a system with its start, its step and its drawing, as the command line lists it |
//! | held input | a parameter that a run changes at nodes and keeps on the legs between |
//! | certificate | two singular values that tell whether the equations of a step determine the next node and the previous one |
//!
//! Notation: `n` is the number of coordinates, `q` the position, `v = q̇` the velocity, `a = q̈` the acceleration, `h` the step, `L` the Lagrangian.
//! In a checkout of the project, write `cargo run --release --` in place of `dsocs`.

#[doc = include_str!("checks.md")]
pub mod checks {}
#[doc = include_str!("constraints.md")]
pub mod constraints {}
#[doc = include_str!("control.md")]
pub mod control {}
#[doc = include_str!("declaration.md")]
pub mod declaration {}
#[doc = include_str!("derivatives.md")]
pub mod derivatives {}
#[doc = include_str!("errors.md")]
pub mod errors {}
#[doc = include_str!("how_it_works.md")]
pub mod how_it_works {}
#[doc = include_str!("linear_models.md")]
pub mod linear_models {}
#[doc = include_str!("many_runs.md")]
pub mod many_runs {}
#[doc = include_str!("maps.md")]
pub mod maps {}
#[doc = include_str!("methods.md")]
pub mod methods {}
#[doc = include_str!("orders.md")]
pub mod orders {}
#[doc = include_str!("performance.md")]
pub mod performance {}
#[doc = include_str!("python.md")]
pub mod python {}
#[doc = include_str!("rotations.md")]
pub mod rotations {}
#[doc = include_str!("symmetry.md")]
pub mod symmetry {}
#[cfg_attr(feature = "cli", doc = include_str!("text_files.md"))]
pub mod text_files {}
#[doc = include_str!("the_paper.md")]
pub mod the_paper {}
#[doc = include_str!("time_forces_inputs.md")]
pub mod time_forces_inputs {}
#[doc = include_str!("two_roots.md")]
pub mod two_roots {}
#[doc = include_str!("your_own_system.md")]
pub mod your_own_system {}
