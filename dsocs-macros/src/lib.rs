//! The attribute `#[dsocs]`: from the declaration of a discrete second order constrained Lagrangian system to its
//! generated integrator.
//!
//! This crate only calls the library `dsocs-language`, which does all the work and can be used without a
//! compiler. Users depend on `dsocs-core`, which re-exports the attribute.

use proc_macro::TokenStream;

/// Declares a mechanical system on a struct whose fields are its parameters, and implements
/// `dsocs_core::System` for it.
///
/// ```ignore
/// /// A particle in the plane that turns with a prescribed signed curvature.
/// #[dsocs {
///     coordinates(x, y);
///     lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
///
///     let speed = (dot(x).powi(2) + dot(y).powi(2)).sqrt();
///     kinematic = (dot(x) * ddot(y) - ddot(x) * dot(y)) / speed.powi(3) - curvature.at(x, y);
///     variational = [(dot(x), dot(y))];
/// }]
/// pub struct CurvedParticle<K: Curvature> {
///     /// Mass [kg].
///     pub mass: f64,
///     /// Signed curvature of the path.
///     pub curvature: K,
/// }
/// ```
///
/// # Statements
///
/// Each statement ends with `;`. Only `let` and `use` may occur more than once. The order is free, but a `let` has to come before its use.
///
/// | statement | meaning |
/// |---|---|
/// | `coordinates(x, y);` | the coordinates, `n` of them; `theta: [8]` among them is an array (see below) |
/// | `lagrangian = L;` | the Lagrangian `L(t, q, v)`; `t` is the time, here and in every expression |
/// | `external_forces = (f1, …, fn);` | generalized forces `f(t, q, v)` that are not constraint forces: friction, wind, a motor; in units of `L` per unit of the coordinate |
/// | `let name = e;` | a name for an expression |
/// | `let name = \|i\| e;` | a function of the declaration, used as `name(2)` (see below) |
/// | `holonomic = g;` or `holonomic = [g1, g2];` | constraints on positions, `g(t, q) = 0`, imposed at every node |
/// | `nonholonomic = c;` or a list | constraints on velocities, `c(t, q, v) = 0`, linear or nonlinear, imposed on every pair of nodes, at `φ_{L_d}⁻¹` |
/// | `kinematic = c;` or a list | constraints on accelerations, `c(t, q, v, a) = 0`, imposed on every triple of nodes, at `φ_{D_K}⁻¹`; or on third derivatives (see below). A row without accelerations and third derivatives is refused |
/// | `variational = [(u1, …, un), …];` | fields that span the virtual displacements (`C_V`) |
/// | `variational = chetaev;` | instead: the displacements of the kinematic constraints by Chetaev's rule, `ker ∂c/∂a` |
/// | `constraint_forces = [(α1, …, αn), …];` | instead: forms that span the constraint forces (`F_V = (C_V)°`) |
/// | `each(0..16, \|i\| e)` in a list, or in place of a list | one entry for every index, in any list of constraints, fields, forms or factors |
/// | `phi_lagrangian = \|q0, q1\| (q, v);` | the map `φ_{L_d}⁻¹`, by a formula or by name: `paper`, `midpoint` or `trapezoid`; for the default see below |
/// | `phi_kinematic = \|q0, q1, q2\| (q, v, a);` | the map `φ_{D_K}⁻¹`; by default `(q1, (q2 - q0) / (2 * h), (q2 - 2 * q1 + q0) / h.powi(2))` |
/// | `phi_variational = \|q0, q1, q2\| (q, v, a);` | the map `φ_{D_V}⁻¹`; by default that of the kinematic constraints |
/// | `discrete_lagrangian = L_d;` | in place of `L(φ_{L_d}⁻¹)`: a function of two nodes (see below) |
/// | `discrete_kinematic = c;` or a list | in place of the kinematic constraints in a step: functions of three nodes |
/// | `branch = divide(w);` or `branch = [divide(w), _];` | divides a kinematic constraint by `w(q, v)`, so that `w = 0` is not a root of the step; a `w` that is not a factor of the constraint is refused |
/// | `observe = [name, …];` | `let`s whose values are reported at every node |
/// | `use name;` or `use path::name;` | inserts the statements of [`statements!`] `{ name { … } }` in this place |
/// | `crate = path;` | the path of `dsocs-core`, for a crate that does not depend on it directly, for example `prelude::dsocs_core` (`$crate::dsocs_core` in a `macro_rules!`) |
///
/// # Names and units
///
/// The doc comments of the struct, of its fields, of coordinates and of observed `let`s are kept; a command line lists them. By
/// convention a comment ends with the unit in brackets.
///
/// ```ignore
/// coordinates(
///     /// The angle of the rod from the vertical [rad].
///     theta,
///     /// The elongation of each spring [m].
///     x: [3],
/// );
/// /// The torque of the motor [N m].
/// let torque = gain * dot(theta);
/// observe = [torque];
/// ```
///
/// # Virtual displacements
///
/// Each constraint has a force. The virtual displacements are those along which no constraint force does work. The forces of
/// holonomic and nonholonomic constraints act along `dg` and `∂c/∂v` (d'Alembert's rule) unless you write others. The forces of
/// kinematic constraints have to be declared, in one of three ways. `constraint_forces` gives one form for each kinematic constraint, or
/// one for each constraint of any kind. `variational = chetaev` takes the forms `∂c/∂a`. The fields of `variational = […]` span all of
/// `C_V`: the number of fields plus the number of constraints is `n`. Without constraints every displacement is virtual. The components
/// of a field are written as a tuple; with one coordinate the parentheses may be omitted.
///
/// If forms are given, the attribute computes the fields from them by elimination. It can do so if enough components are nonzero constants,
/// or if there are `n - 1` forms. Otherwise the multipliers of the forms are unknowns of the step. Fields that you write yourself, as a basis
/// of the same `C_V`, give the same motion.
///
/// ```ignore
/// // a pendulum with a rod (d'Alembert) and a motor on its wheel (a Lyapunov constraint)
/// holonomic = x.powi(2) + y.powi(2) - length.powi(2);
/// kinematic = dot(lyapunov) + dissipation;
/// constraint_forces = [(0, 0, 1)];
/// ```
///
/// # Expressions
///
/// - `t` is the time. Constraints, maps, fields and forces may depend on it. It adds no cost to a declaration that does not use it.
/// - `dot(e)` is the total time derivative of any expression, `ddot(e)` the second one, `dddot(e)` the third. Only kinematic constraints may
///   contain third derivatives of coordinates. All other expressions may contain at most accelerations. Higher derivatives are refused.
/// - Numbers, also integers, are `f64`. Operators are `+`, `-`, `*`, `/`. Blocks `{ let a = …; e }` and
///   `if a < b { e1 } else { e2 }` are expressions. Both branches of an `if` are computed and one is selected, so
///   neither may panic. The condition compares by `<`, `<=`, `>`, `>=`, joined by `&&`, `||`, `!`; or it is a `bool` that depends only on
///   the parameters.
/// - The functions of `f64` are methods or paths (`x.sin()`, `f64::sin(x)`): `sqrt`, `cbrt`, `exp`, `exp_m1`,
///   `exp2`, `ln`, `ln_1p`, `log10`, `log2`, `log`, `sin`, `cos`, `tan`, `asin`, `acos`, `atan`, `sinh`, `cosh`,
///   `tanh`, `asinh`, `acosh`, `atanh`, `abs`, `signum`, `recip`, `powi` (a literal exponent), `powf`, `atan2`,
///   `hypot`, `min`, `max`, `mul_add`, `to_radians`, `to_degrees`. `a.min(b)` and `a.max(b)` compare by
///   `<`: if one of the numbers is NaN, `min` gives `b` and `max` gives `a`.
/// - A parameter is a field of the struct, by its name alone. Fields of type `f32` and of the integer types that
///   `f64` can represent exactly are converted. A `bool` can be used in conditions. `masses[2]`, `geometry.length`,
///   `table.value(3)`, `std::f64::consts::LN_2` and constants in capitals (`PI` and `TAU` without an import) are parameters too: any expression without
///   coordinates.
/// - Any other function or method of coordinates is your own: `curvature.at(x, y)`, `friction(dot(x))`. If its derivative is
///   needed, it is called with dual numbers, so it has to be generic over its number type. Its arguments are
///   numbers.
/// - Coordinates, fields, `let`s, `t`, `h`, `dot`, `ddot`, `dddot`, `sum`, `product` and `each` share one namespace.
///
/// # Arrays, sums and functions
///
/// ```ignore
/// /// Masses on a line, each tied to the next one by a spring.
/// #[dsocs {
///     coordinates(x: [8]);
///     let stretch = |i| x[i + 1] - x[i];
///     lagrangian = sum(0..8, |i| masses[i] / 2 * dot(x[i]).powi(2))
///         - sum(0..7, |i| stiffness / 2 * stretch(i).powi(2));
/// }]
/// pub struct Row {
///     pub masses: [f64; 8],
///     pub stiffness: f64,
/// }
/// ```
///
/// - `coordinates(x, theta: [8]);` declares the eight coordinates `theta[0]` to `theta[7]`. The length is a literal, which
///   may come from a `macro_rules!`. Lists show them as `theta_0` to `theta_7`, and expressions may use these names, too. The numbers in a
///   field of type `[f64; 8]` are listed as parameters in the same way. In expressions they are written `masses[2]`.
/// - An array by its name alone is a vector. So are `[a, b, c]`, `[a; 3]` and the fields of type `[f64; 3]`; `[[f64; 3]; 3]` is a matrix, and so is
///   `[u, v, w]` of vectors, its rows. Vectors are added, multiplied by numbers and divided by them. `a.inner(b)`, `a.cross(b)` (of three
///   components), `a.norm()` and `a.norm_squared()` are their products and lengths, `m * v`, `m * n` and `m.transpose()` those of matrices, `v[i]` and
///   `m[i][j]` their components. `dot(v)` is the vector of derivatives. A `let`, an argument of a function, the terms of a `sum` and both cases of an
///   `if` may be vectors.
/// - `coordinates(r: rotation, x: [3]);` declares a rotation: a unit quaternion with three degrees of
///   freedom. `r * c` turns a vector from the frame of the body into that of space, `r.inverse() * c` turns
///   it back. Other operations are `r * s`, the product of two rotations, `r.matrix()`, and
///   `r.angular_velocity()` in the frame of the body. The entry of a rotation in a field, a form or a force
///   is a vector in the frame of its body, or 0. In a run's numbers a rotation takes four places: the
///   quaternion, scalar first, in positions; a zero and three numbers in velocities, accelerations and
///   forces.
/// - A row that is a vector stands for one row per component: `holonomic = x - y;`. `branch` and
///   `discrete_kinematic` have one entry for all of them. A vector that is observed has a column for each
///   component, `force_0`, `force_1`.
/// - `sum(range, |i| e)` and `product(range, |i| e)` are written out when the declaration is read. The range has both
///   ends, `0..8` or `0..=i`.
/// - An index is an integer expression: literals, indices of enclosing sums and `let`s of whole numbers, joined by `+`, `-`, `*`,
///   `/`, `%` as in Rust. Outside of an index, `i` is an `f64` like any other number (there `i / 2` for `i = 1` is one half).
///   In `powi(i)` it is an exponent, and in an expression of the parameters alone, like `table.value(i)`, an integer literal.
/// - If the condition of an `if` depends only on indices, only the branch that is taken is read:
///   `if i > 0 { theta[i - 1] } else { 0 }`. Such conditions may also use `==` and `!=`.
/// - `let f = |i, a| e;` is a function: `f(2, dot(x))` is `e` with its parameters replaced. An argument is an index or any
///   expression. The function can use the names that are defined before it, so it cannot call itself.
/// - The components of a field are written in the shape of the coordinates: for `coordinates(x, theta: [3]);` a field is
///   `(1, [a, b, c])`, `(1, u)` with a vector `u`, `(1, |i| e)`, or all of them in one tuple, `(1, a, b, c)`.
///
/// # External forces
///
/// A force does the work `⟨f, δq⟩`. On a leg it is evaluated at the points of `phi_lagrangian`, and acts along the displacements of these
/// points. With `midpoint`, the force is evaluated at the middle of the leg, and half of it acts on each of the two nodes. With `trapezoid`,
/// the force is evaluated at both nodes, and half of each value acts on its node. With the map `paper`, forces are treated as with
/// `trapezoid`, because a force at only one end of the leg would be of first order. So the step is of second order with each of the three
/// maps. The reported constraint force does not contain the external forces:
/// `Q = -(D₁L_d(q1,q2) + D₂L_d(q0,q1) + f⁻_d(q1,q2) + f⁺_d(q0,q1))`.
///
/// ```ignore
/// external_forces = (-damping * dot(x), torque.at(t));    // torque: dsocs_core::Samples
/// ```
///
/// A force that jumps within a step (dry friction, `if`) lowers the order to 1, for every method with fixed steps: after the jump, the
/// velocity has an error of up to `h` times half the jump of the acceleration. A corner leaves an error of the order `h²`. A Taylor flow
/// ends a step at each jump and each corner, and begins the next step behind it.
///
/// # Maps
///
/// A map computes a point of the continuous system from the nodes. Nodes and values are vectors, and
/// arithmetic acts on each component. `q0.x` or `q0.0` is one component, and `q0.theta[2]`
/// is a component of an array. A value may also be a tuple of `n` components (in the shape of the coordinates, as for fields). In
/// each component of the tuple, `q0` is the same component of the node. Maps may use the parameters, the
/// step `h`, `let`s in a block of their own, and functions. They may not use coordinates, `dot`, or the
/// `let`s of the declaration.
///
/// ```ignore
/// phi_lagrangian = |q0, q1| ((q0 + q1) / 2, (q1 - q0) / h);
/// ```
///
/// If a map names the times of its nodes, its value begins with the time of the point: `|t0, q0, t1, q1| (t, q, v)` and
/// `|t0, q0, t1, q1, t2, q2| (t, q, v, a)`. A map of two nodes without
/// times takes the time of a node if its position is that of the node, and otherwise the middle of the leg. A map of three nodes takes the
/// time of the middle node.
///
/// `paper`, `midpoint` (`((q0 + q1) / 2, (q1 - q0) / h)`) and `trapezoid` (the mean of the Lagrangian over `(q0, v)` and `(q1, v)`,
/// only for `phi_lagrangian`) are maps by name. `midpoint` and `trapezoid` are of second order for every Lagrangian and every
/// constraint; `paper`, `(q0, (q1 - q0) / h)`, is of second order if `L = T(v) - V(q)`. As `phi_kinematic`, `midpoint` is
/// `((q0 + 2 * q1 + q2) / 4, …)`.
///
/// The default map always gives a step of second order. It is `paper` if the momentum `∂L/∂v` does not
/// depend on the position or on time (as with a constant mass matrix) and nothing is imposed on a leg. Otherwise, for example with
/// nonholonomic constraints or with `leg(e, 0)`, it is `midpoint`. `phi_lagrangian = paper` asks for the paper's map everywhere.
///
/// # Discrete systems
///
/// `discrete_lagrangian` and `discrete_kinematic` are functions of the nodes. `x[0]`, `x[1]`, `x[2]` are the values of the coordinate `x`
/// at the nodes (`theta[3][1]` is one of an array), `t[0]`, `t[1]`, `t[2]` are the times, and `h` is the step. `leg(e, 0)` and `leg(e, 1)` are
/// the values of an expression of positions and velocities on the first and the second leg, by `phi_lagrangian`. `node(e)` is the value of any
/// expression at the triple, by `phi_kinematic`. The continuous statements are still needed, for starts, energies, error estimates and
/// reference solutions.
///
/// ```ignore
/// // V decreases by exactly h F from leg to leg
/// discrete_kinematic = leg(lyapunov, 1) - leg(lyapunov, 0) + h * node(dissipation);
/// ```
///
/// # Third order
///
/// The paper remarks that constraints of order `k` become constraints on `k + 1` nodes. A kinematic constraint may contain third
/// derivatives: `dddot(x)`, `dot(ddot(x))`, or the derivative of any expression with accelerations. It is then imposed on four nodes, at the
/// middle of the leg from `q1` to `q2`. Position, velocity, acceleration and jerk there are
/// `((q1 + q2)/2, (q2 - q1)/h, (q3 - q2 - q1 + q0)/2h², (q3 - 3q2 + 3q1 - q0)/h³)`. This map is of second order and symmetric in time. If the
/// constraint depends on the time, the time is that of this point. All other rows are imposed on the last three nodes, as in a system without
/// such a constraint: the works `⟨u, Q⟩` of the constraint force at `q2`, constraints of lower order, and other kinematic constraints.
///
/// ```ignore
/// /// Enters a bend: the curvature of its path changes with the way.
/// #[dsocs {
///     coordinates(x, y);
///     lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
///     let speed = (dot(x).powi(2) + dot(y).powi(2)).sqrt();
///     let curvature = (dot(x) * ddot(y) - ddot(x) * dot(y)) / speed.powi(3);
///     kinematic = dot(curvature) - rate * speed;
///     constraint_forces = [(-dot(y), dot(x))];
/// }]
/// pub struct Clothoid {
///     pub mass: f64,
///     pub rate: f64,
/// }
/// // the acceleration at the start is free: Start::third_order(q0, v0, a0), or Start::third_order_by_force(q0, v0, force)
/// ```
///
/// With `variational = chetaev` the force of such a constraint acts along `∂c/∂j`, where `j` is the jerk. `phi_kinematic` applies only to
/// constraints of second order. `discrete_kinematic` and a factor to divide out are refused.
///
/// The only method for such systems is the discrete flow (`Flow`). Compositions, Taylor series, ensembles, inputs that change at nodes, and the
/// flow as a map of pairs of nodes are refused with an error. A stiff constraint limits the step, because the rows are explicit in the lower derivatives:
/// `T x''' + x'' + k x' = 0` needs `h` well below `2√(T/k)`.
///
/// # Errors
///
/// All mistakes are reported at once. Each message points at the tokens in question and says what was expected there. If a function of yours
/// is not generic, the compiler reports this once, at the function's name.
///
/// There are warnings for a `let` that nothing uses (begin its name with `_` to avoid the warning), and for a coordinate whose acceleration
/// no equation determines.
#[proc_macro_attribute]
pub fn dsocs(declaration: TokenStream, item: TokenStream) -> TokenStream {
    dsocs_language::expand(declaration.into(), &item.into()).into()
}

/// Gives a name to statements that several declarations share: `use name;` inserts them into a declaration, in that place.
///
/// ```ignore
/// statements! {
///     /// A pendulum.
///     pub(crate) pendulum {
///         coordinates(theta);
///         lagrangian = mass * length.powi(2) / 2 * dot(theta).powi(2) + mass * 9.81 * length * theta.cos();
///     }
/// }
///
/// /// With friction in its bearing.
/// #[dsocs {
///     use pendulum;
///     external_forces = -friction * dot(theta);
/// }]
/// struct Damped { mass: f64, length: f64, friction: f64 }
/// ```
///
/// The statements are read as if they were written in place of `use`. The parameters in them are fields of each struct. Shared statements may
/// `use` other shared statements, and a declaration may `use` several. A shared `let` that a declaration does not use gives no
/// warning.
///
/// The visibility is written before the name; without one the name is private to its module. The name is found by its path:
/// `use other::pendulum;` from another module, or from another crate if it is `pub`. A mistake in shared statements is reported where
/// they are written, with the declaration that uses them.
#[proc_macro]
pub fn statements(tokens: TokenStream) -> TokenStream {
    dsocs_language::statements(tokens.into()).into()
}
