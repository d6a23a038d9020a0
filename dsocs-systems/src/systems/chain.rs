//! Planar chains of point masses on massless rods, of any number of links.

/// A chain of eight links.
#[cfg(feature = "dsocs")]
#[must_use]
pub fn entry() -> crate::Entry {
    crate::Entry::new(PlanarChain8::default())
        .named("chain")
        .described("a planar chain of eight links, hanging from a pivot")
        .source("textbooks, with two links as the double pendulum")
        .start([1.0; 8], [0.0; 8])
        .step(0.005)
        .until(20.0)
        .drawn(super::rods::<8>)
}

/// Declares a planar chain of a literal number of links: point masses on massless rods, hanging from a fixed pivot.
///
/// The coordinates are the angles `theta_0`, `theta_1`, … of the rods against the downward vertical \[rad\], from the pivot
/// outwards. Rod `i` moves its own point and all points beyond, so with `μ_i = Σ_{k≥i} m_k` the Lagrangian is
///
/// `L = Σ_ij μ_max(i,j) l_i l_j cos(θ_i − θ_j) θ̇_i θ̇_j / 2 + g Σ_i μ_i l_i cos θ_i`.
///
/// Its mass matrix depends on the angles, where the paper's map `φ_{L_d}⁻¹ = (q0, (q1 − q0)/h)` is of order 1; the chain is
/// declared with the midpoint `((q0 + q1)/2, (q1 − q0)/h)`, which is of order 2.
///
/// The crate that uses the macro depends on `dsocs-core`.
///
/// ```
/// use dsocs_core::prelude::*;
///
/// dsocs_systems::planar_chain! {
///     /// Three links.
///     #[derive(Clone, Debug)]
///     pub struct Triple; 3
/// }
///
/// let chain = Triple { masses: [1.0, 2.0, 1.0], lengths: [1.0; 3], gravity: 9.81 };
/// let mut flow = Flow::new(&chain, 0.01, Start::second_order([1.0, 0.5, 0.0], [0.0; 3]))?;
/// let trajectory = flow.until(1.0)?;
/// assert_eq!(trajectory.len(), 101);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[macro_export]
macro_rules! planar_chain {
    ($(#[$meta:meta])* $visibility:vis struct $name:ident; $n:literal) => {
        #[::dsocs_core::dsocs {
            coordinates(
                /// The angle of each rod against the downward vertical, from the pivot outwards [rad].
                theta: [$n],
            );

            // the mass that rod i moves
            let beyond = |i| sum(i..$n, |k| masses[k]);
            let cosine = |i, j| theta[i].cos() * theta[j].cos() + theta[i].sin() * theta[j].sin();
            let speed = |i| lengths[i] * dot(theta[i]);

            let kinetic = sum(0..$n, |i| {
                beyond(i) * (speed(i).powi(2) / 2 + sum(0..i, |j| cosine(i, j) * speed(i) * speed(j)))
            });
            let potential = -gravity * sum(0..$n, |i| beyond(i) * lengths[i] * theta[i].cos());
            lagrangian = kinetic - potential;
            phi_lagrangian = |q0, q1| ((q0 + q1) / 2, (q1 - q0) / h);
        }]
        $(#[$meta])*
        $visibility struct $name {
            /// The mass of each point, from the pivot outwards \[kg\].
            pub masses: [f64; $n],
            /// The length of each rod, from the pivot outwards \[m\].
            pub lengths: [f64; $n],
            /// The acceleration of gravity [m/s²].
            pub gravity: f64,
        }

        impl ::core::default::Default for $name {
            /// Equal links, of the total mass 1 kg and the total length 1 m.
            fn default() -> Self {
                let part = 1.0 / ::core::primitive::f64::from($n);
                Self {
                    masses: [part; $n],
                    lengths: [part; $n],
                    gravity: 9.81,
                }
            }
        }
    };
}

planar_chain! {
    /// A chain of two links: the planar double pendulum.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct PlanarChain2; 2
}

planar_chain! {
    /// A chain of eight links.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct PlanarChain8; 8
}
