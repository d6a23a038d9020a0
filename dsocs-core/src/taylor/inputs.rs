//! Inputs of a continuous motion: it begins anew at the node, with its position and momentum there.

use super::flow::{AnyTaylorFlow, TaylorFlow};
use super::integrator::Arrived;
use crate::error::SetupError;
use crate::error::series::SeriesFailure;
use crate::run::{Inputs, RunError};
use crate::start;
use crate::tape::declaration::Declaration;

impl<const N: usize> Inputs<N> for TaylorFlow<'_, N> {}

impl AnyTaylorFlow<'_> {
    /// Restarts at the current node with other values of the parameters.
    pub(super) fn go_on_with(&mut self, values: &[f64]) -> Result<(), RunError> {
        let Self { equations, motion } = self;
        let equations = &mut **equations;
        let node = motion.clock.time();
        let behind = motion.polynomial().filter(|_| node != motion.time());
        let since = behind.map(|polynomial| polynomial.since(node));
        if let Some(since) = since {
            // nodes of a grid lie within steps
            motion.stop_at(equations, since);
        }
        let before = motion.now.clone();
        let old = equations.values().to_vec();
        let (t, place) = (motion.time(), (motion.steps, motion.time()));
        let known = motion.arrived.take().filter(|known| known.place == place);
        let arrived = known.unwrap_or_else(|| {
            Box::new(Arrived {
                place,
                values: old.clone(),
                now: before.clone(),
            })
        });
        let sides =
            [&arrived.values[..], values].map(|values| Declaration::of(equations.kernel()).with(values));
        let after = start::velocity_after(&sides, (t, arrived.now.q(), arrived.now.v()));
        let after = match after {
            Ok(after) => after,
            Err(error) => {
                motion.arrived = Some(arrived);
                return Err(error.into());
            }
        };
        equations.set_values(values);
        if let Some(projection) = &mut motion.projection {
            projection.forget();
        }
        motion.now = arrived.now.clone();
        if after != arrived.now.v() {
            motion.now.set_velocity(&after);
        }
        motion.arrived = Some(arrived);
        motion.begin(equations);
        if !motion.acceleration().iter().all(|a| a.is_finite()) {
            let error = motion.failed(equations, SeriesFailure::NotFinite);
            equations.set_values(&old);
            motion.now = before;
            motion.begin(equations);
            return Err(SetupError::Series(error).into());
        }
        motion.shown = motion.time();
        if motion.on_grid.is_some() {
            motion.stand_here();
        }
        Ok(())
    }
}
