//! Symmetries of a Lagrangian.

use std::fmt;

/// Writes the generator, a velocity of the configuration, at a position.
type Generator = dyn Fn(&[f64], &mut [f64]) + Send + Sync;

/// A symmetry of a system's Lagrangian, by its infinitesimal generator.
pub struct Symmetry {
    /// The name, such as `rotation about the pivot`.
    name: String,
    /// The number of coordinates.
    components: usize,
    /// The generator `ξ_Q(q)`.
    generator: Box<Generator>,
}

impl fmt::Debug for Symmetry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Symmetry")
            .field("name", &self.name)
            .field("components", &self.components)
            .finish_non_exhaustive()
    }
}

impl Symmetry {
    /// A symmetry by its generator `ξ_Q(q)`, a velocity of the configuration.
    pub fn new<const N: usize>(
        name: impl Into<String>,
        generator: impl Fn(&[f64; N]) -> [f64; N] + Send + Sync + 'static,
    ) -> Self {
        Self {
            name: name.into(),
            components: N,
            generator: Box::new(move |q, out| {
                if let Ok(q) = q.try_into() {
                    out.copy_from_slice(&generator(q));
                }
            }),
        }
    }

    /// A symmetry for any number of coordinates: the generator takes a position and writes its vector.
    pub(crate) fn of(
        name: String,
        components: usize,
        generator: impl Fn(&[f64], &mut [f64]) + Send + Sync + 'static,
    ) -> Self {
        Self {
            name,
            components,
            generator: Box::new(generator),
        }
    }

    /// The name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The number of coordinates.
    #[must_use]
    pub fn components(&self) -> usize {
        self.components
    }

    /// The generator at a position; NaN if the position has another number of coordinates.
    #[must_use]
    pub fn at(&self, q: &[f64]) -> Vec<f64> {
        let mut velocity = vec![f64::NAN; q.len()];
        if q.len() == self.components {
            (self.generator)(q, &mut velocity);
        }
        velocity
    }
}
