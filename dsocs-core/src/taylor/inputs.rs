//! Inputs of a continuous motion: it begins anew at the node, with the position and the momentum that it has there.

use super::error::SeriesFailure;
use super::flow::TaylorFlow;
use super::jets::{Equations as _, Recurrences};
use crate::any::sized;
use crate::compensated::Compensated;
use crate::declaration::Declaration;
use crate::error::SetupError;
use crate::held::Held;
use crate::run::{Inputs, RunError, Stepper as _, inputs};
use crate::start;
use crate::system::System;

impl<S: System<N> + Clone, const N: usize> Inputs<N> for TaylorFlow<'_, S, N> {
    fn set_input(&mut self, parameter: &str, value: f64) -> Result<(), RunError> {
        let place = inputs::place(self.equations.system.shape(), parameter, value)?;
        if self.equations.system.parameter(place) == Some(value) {
            return Ok(());
        }
        let mut system = self.equations.system.clone();
        if let Some(parameter) = system.own().parameter_mut(place) {
            *parameter = value;
        }
        self.go_on_with(system)
    }

    fn input(&self, parameter: &str) -> Option<f64> {
        self.run().input(parameter)
    }
}

impl<'s, S: System<N>, const N: usize> TaylorFlow<'s, S, N> {
    /// Begins anew at the current node with other parameters.
    fn go_on_with(&mut self, system: Held<'s, S>) -> Result<(), RunError> {
        let node = self.motion.clock.time();
        let behind = self.motion.polynomial().filter(|_| node != self.motion.time());
        let since = behind.map(|polynomial| polynomial.since(node));
        if let Some(since) = since {
            // the nodes of a grid lie within steps
            self.motion.stop_at(&mut self.equations, since);
        }
        let (t, q, v) = (self.motion.time(), self.motion.q.hi, self.motion.v.hi);
        let sides = [self.equations.declaration(), Declaration::of(&*system)];
        let after = sized(&start::velocity_after(&sides, (t, &q, &v))?);
        let old = core::mem::replace(&mut self.equations, Recurrences::held(system));
        let before = self.motion.v;
        if let Some(projection) = &mut self.motion.projection {
            projection.forget();
        }
        if after != v {
            self.motion.v = Compensated::exact(after);
        }
        self.motion.begin(&mut self.equations);
        if !self.motion.acceleration().iter().all(|a| a.is_finite()) {
            let error = self.motion.failed(&self.equations, SeriesFailure::NotFinite);
            self.equations = old;
            self.motion.v = before;
            self.motion.begin(&mut self.equations);
            return Err(SetupError::Series(error).into());
        }
        self.motion.shown = self.motion.time();
        if self.motion.on_grid.is_some() {
            self.motion.on_grid = Some(self.motion.point());
        }
        Ok(())
    }
}
