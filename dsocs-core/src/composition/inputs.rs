//! Inputs of a composed step: it begins anew at the node, with the position and the momentum that it has there.

#![allow(clippy::float_cmp)] // a velocity that has not changed

use super::flow::{ComposedFlow, State};
use super::momenta::Momenta;
use crate::any::sized;
use crate::compensated::Compensated;
use crate::declaration::Declaration;
use crate::run::{Inputs, RunError, Stepper as _, inputs};
use crate::start;
use crate::system::System;

impl<S: System<N> + Clone, const N: usize> Inputs<N> for ComposedFlow<'_, S, N> {
    fn set_input(&mut self, parameter: &str, value: f64) -> Result<(), RunError> {
        let place = inputs::place(self.system.shape(), parameter, value)?;
        if self.system.parameter(place) == Some(value) {
            return Ok(());
        }
        let mut system = self.system.clone();
        if let Some(parameter) = system.own().parameter_mut(place) {
            *parameter = value;
        }
        let (t, q, v, a) = (self.time(), self.now.q.hi, self.now.v.hi, self.now.a);
        let sides = [Declaration::of(&*self.system), Declaration::of(&*system)];
        let after = sized(&start::velocity_after(&sides, (t, &q, &v))?);
        if let Some(joined) = &mut self.joined {
            // the momentum stays
            let now = (joined.now.q, joined.now.p, after);
            joined.now = Momenta::of(&*system).node(t, now, Some(&a))?;
            self.now = State::of(&joined.now);
        } else {
            self.now.a = start::state_acceleration(&*system, (t, &q, &after), Some(&a))?;
            if after != v {
                self.now.v = Compensated::exact(after);
            }
        }
        self.system = system;
        self.values = self.system.parameters();
        self.since = self.clock.index();
        self.prepare();
        Ok(())
    }

    fn input(&self, parameter: &str) -> Option<f64> {
        self.run().input(parameter)
    }
}
