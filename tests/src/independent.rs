//! An independent formulation of a declaration: its equations, written by hand over dual numbers, straight
//! from the paper.
//!
//! Nothing is simplified, hoisted or eliminated here. `D₁L_d` and `D₂L_d` are derivatives of `L∘φ⁻¹` by dual
//! numbers, so rows over dual numbers are nested.

use num_dual::{Dual, DualNum};

/// A declaration with `N` coordinates, as a user would write it down, but as functions over dual numbers.
pub trait Declaration<const N: usize> {
    /// The Lagrangian.
    fn lagrangian<R: Number>(&self, q: [R; N], v: [R; N]) -> R;

    /// The kinematic rows.
    fn kinematic<R: Number>(&self, q: [R; N], v: [R; N], a: [R; N]) -> Vec<R>;

    /// The factor by which each kinematic row is divided; none by default.
    fn divide<R: Number>(&self, _q: [R; N], _v: [R; N]) -> Vec<Option<R>> {
        Vec::new()
    }

    /// The fields that span the virtual displacements.
    fn variational<R: Number>(&self, q: [R; N], v: [R; N], a: [R; N]) -> Vec<[R; N]>;

    /// `φ_{L_d}⁻¹`, the paper's by default.
    fn phi_lagrangian<R: Number>(&self, h: R, q0: [R; N], q1: [R; N]) -> ([R; N], [R; N]) {
        (q0, map2(q1, q0, |x1, x0| (x1 - x0) / h))
    }

    /// `φ_{D_K}⁻¹`, the paper's by default.
    fn phi_kinematic<R: Number>(&self, h: R, q: [[R; N]; 3]) -> [[R; N]; 3] {
        let [q0, q1, q2] = q;
        let v = map2(q2, q0, |x2, x0| (x2 - x0) / (h * 2.0));
        let a = core::array::from_fn(|i| (q2[i] - q1[i] * 2.0 + q0[i]) / (h * h));
        [q1, v, a]
    }

    /// `φ_{D_V}⁻¹`, by default the same as `φ_{D_K}⁻¹`.
    fn phi_variational<R: Number>(&self, h: R, q: [[R; N]; 3]) -> [[R; N]; 3] {
        self.phi_kinematic(h, q)
    }
}

/// A function of the components of two vectors.
pub fn map2<R: Number, const N: usize>(x: [R; N], y: [R; N], function: impl Fn(R, R) -> R) -> [R; N] {
    core::array::from_fn(|i| function(x[i], y[i]))
}

/// The numbers of `num-dual`, which nest.
pub trait Number: DualNum<Primitive = f64> + Copy {}

impl<R: DualNum<Primitive = f64> + Copy> Number for R {}

/// A vector as dual numbers that move along `direction`.
pub fn along<R: Number, const N: usize>(x: [R; N], direction: [R; N]) -> [Dual<R>; N] {
    core::array::from_fn(|i| Dual::new(x[i], direction[i]))
}

/// A vector as dual numbers of which component `i` is the variable.
pub fn variable<R: Number, const N: usize>(x: [R; N], i: usize) -> [Dual<R>; N] {
    core::array::from_fn(|j| Dual::new(x[j], R::from(f64::from(u8::from(i == j)))))
}

/// A vector as constant dual numbers.
pub fn fixed<R: Number, const N: usize>(x: [R; N]) -> [Dual<R>; N] {
    x.map(Dual::from_re)
}

/// The total time derivative of a function of position and velocity: `d/dt f(q, v)` along `(v, a)`.
pub fn rate<R: Number, const N: usize>(
    q: [R; N],
    v: [R; N],
    a: [R; N],
    function: impl Fn([Dual<R>; N], [Dual<R>; N]) -> Dual<R>,
) -> R {
    function(along(q, v), along(v, a)).eps
}

/// `L_d(q0, q1)`.
pub fn discrete_lagrangian<P: Declaration<N>, R: Number, const N: usize>(
    declaration: &P,
    h: R,
    q0: [R; N],
    q1: [R; N],
) -> R {
    let (q, v) = declaration.phi_lagrangian(h, q0, q1);
    declaration.lagrangian(q, v)
}

/// `−(D₁L_d(q1, q2) + D₂L_d(q0, q1))`.
pub fn force<P: Declaration<N>, R: Number, const N: usize>(declaration: &P, h: R, q: [[R; N]; 3]) -> [R; N] {
    let [q0, q1, q2] = q;
    let h = Dual::from_re(h);
    core::array::from_fn(|i| {
        let first = discrete_lagrangian(declaration, h, variable(q1, i), fixed(q2)).eps;
        let second = discrete_lagrangian(declaration, h, fixed(q0), variable(q1, i)).eps;
        -(first + second)
    })
}

/// All rows of a step, none eliminated: kinematic rows, then `⟨u, Q⟩` with the constraint force `Q = −(D₁L_d(q1,q2) + D₂L_d(q0,q1))`.
pub fn rows<P: Declaration<N>, R: Number, const N: usize>(
    declaration: &P,
    h: R,
    nodes: [[R; N]; 3],
) -> Vec<R> {
    let [q, v, a] = declaration.phi_kinematic(h, nodes);
    let mut rows = divided(declaration, q, v, a);
    let [q, v, a] = declaration.phi_variational(h, nodes);
    let force = force(declaration, h, nodes);
    for u in declaration.variational(q, v, a) {
        rows.push(pairing(u, force));
    }
    rows
}

/// All rows of the continuous system: kinematic rows, then `⟨u, Q⟩` with `Q = −D_EL L`.
pub fn continuous_rows<P: Declaration<N>, R: Number, const N: usize>(
    declaration: &P,
    q: [R; N],
    v: [R; N],
    a: [R; N],
) -> Vec<R> {
    let mut rows = divided(declaration, q, v, a);
    let force = continuous_force(declaration, q, v, a);
    for u in declaration.variational(q, v, a) {
        rows.push(pairing(u, force));
    }
    rows
}

/// `d/dt ∂L/∂v − ∂L/∂q`.
pub fn continuous_force<P: Declaration<N>, R: Number, const N: usize>(
    declaration: &P,
    q: [R; N],
    v: [R; N],
    a: [R; N],
) -> [R; N] {
    core::array::from_fn(|i| {
        let momentum_rate = rate(q, v, a, |q, v| momentum(declaration, q, v, i));
        momentum_rate - declaration.lagrangian(variable(q, i), fixed(v)).eps
    })
}

/// `⟨∂L/∂v, v⟩ − L`.
pub fn energy<P: Declaration<N>, const N: usize>(declaration: &P, q: [f64; N], v: [f64; N]) -> f64 {
    let action: f64 = (0..N).map(|i| momentum(declaration, q, v, i) * v[i]).sum();
    action - declaration.lagrangian(q, v)
}

/// `∂L/∂vᵢ`.
fn momentum<P: Declaration<N>, R: Number, const N: usize>(
    declaration: &P,
    q: [R; N],
    v: [R; N],
    i: usize,
) -> R {
    declaration.lagrangian(fixed(q), variable(v, i)).eps
}

/// The kinematic rows, divided by their factors.
fn divided<P: Declaration<N>, R: Number, const N: usize>(
    declaration: &P,
    q: [R; N],
    v: [R; N],
    a: [R; N],
) -> Vec<R> {
    let mut rows = declaration.kinematic(q, v, a);
    for (row, factor) in rows.iter_mut().zip(declaration.divide(q, v)) {
        if let Some(factor) = factor {
            *row /= factor;
        }
    }
    rows
}

/// `⟨u, f⟩`.
fn pairing<R: Number, const N: usize>(u: [R; N], f: [R; N]) -> R {
    let terms = u.into_iter().zip(f).map(|(u, f)| u * f);
    terms.fold(R::from(0.0), |sum, term| sum + term)
}
