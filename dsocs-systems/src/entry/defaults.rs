//! The values and texts that an entry adds to its declaration.

use super::drawing::DrawingFunction;
use super::{Drawing, Entry, Parameters, Symmetry};

impl Entry {
    /// Gives another name than the type's.
    #[must_use]
    pub fn named(mut self, name: impl Into<String>) -> Self {
        self.name = name.into();
        self
    }

    /// Gives another summary than the first sentence of the type's documentation.
    #[must_use]
    pub fn described(mut self, summary: impl Into<String>) -> Self {
        self.summary = summary.into();
        self
    }

    /// Sets the literature source of the system.
    #[must_use]
    pub fn source(mut self, source: impl Into<String>) -> Self {
        self.source = Some(source.into());
        self
    }

    /// Sets the default start of a run: the position `q0` and the velocity `v0`, with one number for each coordinate.
    #[must_use]
    pub fn start<const N: usize>(mut self, q0: [f64; N], v0: [f64; N]) -> Self {
        self.start = Some([q0.to_vec(), v0.to_vec()]);
        self
    }

    /// Sets the default start of a run of a system with a constraint of third order: position `q0`, velocity `v0` and acceleration `a0`.
    #[must_use]
    pub fn start_with_acceleration<const N: usize>(self, q0: [f64; N], v0: [f64; N], a0: [f64; N]) -> Self {
        Self {
            acceleration: Some(a0.to_vec()),
            ..self.start(q0, v0)
        }
    }

    /// Sets the acceleration near which the initial one is looked for by default, where the equations have
    /// several solutions.
    #[must_use]
    pub fn near_acceleration<const N: usize>(mut self, a0: [f64; N]) -> Self {
        self.near = Some(a0.to_vec());
        self
    }

    /// Moves the start onto the constraints on positions and velocities by default, by the smallest change to first order. Without it a start that violates them is
    /// refused.
    #[must_use]
    pub fn projected(mut self) -> Self {
        self.project = true;
        self
    }

    /// Sets the default step of a run, in s; negative to run back in time.
    #[must_use]
    pub fn step(mut self, h: f64) -> Self {
        self.step = h;
        self
    }

    /// Sets the default end of a run, in s.
    #[must_use]
    pub fn until(mut self, until: f64) -> Self {
        self.until = until;
        self
    }

    /// Sets the default end of the motion that `check` follows, in s. Unless set, it is that of a run.
    #[must_use]
    pub fn checked_until(mut self, until: f64) -> Self {
        self.checked = Some(until);
        self
    }

    /// Adds a symmetry of the Lagrangian, given by its infinitesimal generator `ξ_Q(q)`, a velocity of the configuration. `check`
    /// tests its momentum law on the motion.
    #[must_use]
    pub fn symmetry<const N: usize>(
        mut self,
        name: impl Into<String>,
        generator: impl Fn(&[f64; N]) -> [f64; N] + Send + Sync + 'static,
    ) -> Self {
        self.symmetries.push(Symmetry::new(name, generator));
        self
    }

    /// Sets how the mechanism is drawn at a position, with its parameters. The page of a run (`run --report`) shows it moving. The function has
    /// to return the same shapes in the same order for every position. Without a drawing the page draws a path.
    ///
    /// ```
    /// use dsocs_core::dsocs;
    /// use dsocs_systems::Entry;
    /// use dsocs_systems::entry::{Drawing, Parameters};
    ///
    /// /// A pendulum.
    /// #[dsocs {
    ///     coordinates(theta);
    ///     lagrangian = (length * dot(theta)).powi(2) / 2 + 9.81 * length * theta.cos();
    /// }]
    /// #[derive(Clone)]
    /// struct Pendulum { length: f64 }
    ///
    /// let entry = Entry::new(Pendulum { length: 1.0 })
    ///     .start([1.0], [0.0])
    ///     .drawn(|[theta]: &[f64; 1], parameters: &Parameters| {
    ///         let length = parameters.get("length");
    ///         let bob = [length * theta.sin(), -length * theta.cos()];
    ///         Drawing::new().trail(bob).rod([0.0, 0.0], bob).point(bob)
    ///     });
    /// assert!(entry.verify().is_ok());
    /// ```
    #[must_use]
    pub fn drawn<const N: usize>(
        mut self,
        draw: impl Fn(&[f64; N], &Parameters) -> Drawing + Send + Sync + 'static,
    ) -> Self {
        self.drawn = Some(DrawingFunction::new(draw));
        self
    }

    /// Sets the order of the scheme that `check` expects (2 by default).
    #[must_use]
    pub fn order(mut self, order: f64) -> Self {
        self.order = order;
        self
    }

    /// States that the step with `−h` is not the inverse of the step with `h`. Then `check` reports the difference, and does not fail.
    #[must_use]
    pub fn irreversible(mut self) -> Self {
        self.reversible = false;
        self
    }
}
