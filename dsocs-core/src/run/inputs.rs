//! Inputs: parameters that change at nodes, while the past is kept.

use super::{InputError, Node, RunError, Stepper};
use crate::tape::Shape;

/// Times of a plan that differ by less than this part of a step are the same.
const SAME_TIME: f64 = 1e-6;

/// The value of a held input after the time `t` of a run with the step `h`, negative back in time; `plan` has
/// increasing times, each with the value that holds from it on. `None` before the first.
#[must_use]
pub fn held_value(plan: &[[f64; 2]], t: f64, h: f64) -> Option<f64> {
    // back in time, a value ends at the time from which it holds
    let later = plan.partition_point(|&[time, _]| {
        if h < 0.0 {
            time < t + SAME_TIME * h
        } else {
            time <= t + SAME_TIME * h
        }
    });
    Some(plan.get(later.checked_sub(1)?)?[1])
}

/// Runs whose parameters can be changed at nodes: the output of a digital controller, planned torques, a held
/// steering angle.
///
/// Every run implements this trait: it has its own values of the parameters. A new value holds from the last
/// known position on. In a [`crate::TaylorFlow`] and a [`crate::ComposedFlow`] this is the current node. A
/// [`crate::Flow`] is one position ahead of its node, because the velocity of a node depends on the next
/// position. So a value that is set at the node `k` holds from the node `k + 1` on, like the output of a
/// controller that needs one step to compute.
///
/// # The step at a change
///
/// A leg has one value of each input: the discrete Lagrangian, the external forces and the nonholonomic constraints of the leg use it.
/// The momentum that arrives from the leg before is computed with the value of that leg. At a node between two values, the second
/// difference is the mean of the two that the kinematic constraints give with each value. So a change does not lower the order: compared
/// with the continuous motion under the same held inputs it stays 2. (Compared with a control law in continuous time, sampling has an error of
/// first order.) With the paper's map of the Lagrangian, half of a change acts on each side of the node. This is the equation of the map
/// `trapezoid`, which is the same as that of the paper's map where no input changes. Nodes without a change have no additional cost.
///
/// If a nonholonomic constraint changes, the velocity jumps onto it, by an impulse of the constraint force.
///
/// A parameter of a holonomic constraint cannot be an input: the position would have to jump. Neither can a
/// parameter inside a `dot(…)` of the declaration: the derivative does not contain the parameter's own rate,
/// and the differentiated expression would have to jump. Declare these as [`crate::Samples`] or as a function
/// of `t`, whose rates are known.
///
/// ```
/// use dsocs_core::prelude::*;
///
/// /// A mass that a force pushes.
/// #[dsocs {
///     coordinates(x);
///     lagrangian = dot(x).powi(2) / 2;
///     external_forces = push;
/// }]
/// #[derive(Clone)]
/// struct Mass {
///     push: f64,
/// }
///
/// let mass = Mass { push: 1.0 };
/// let mut run = Flow::new(&mass, 0.01, Start::second_order([0.0], [0.0]))?;
/// // a brake that sees the node and sets the force on the next leg
/// run.drive(2.0, &mut |node, run| run.set_input("push", if node.t < 1.0 { 1.0 } else { -1.0 }))?;
/// assert!(run.node().v[0].abs() < 0.021 && (run.node().q[0] - 1.0).abs() < 0.021);
/// # Ok::<(), RunError>(())
/// ```
pub trait Inputs<const N: usize>: Stepper<N> {
    /// Sets a parameter, from the last known position on. Nothing happens if it already has this value.
    ///
    /// # Errors
    ///
    /// [`RunError::Input`] if there is no such parameter, if the value is not finite, or if the parameter stands in a holonomic constraint or
    /// inside a `dot(…)`; [`RunError::Setup`] if the motion cannot go on with the value, for example because no acceleration is found. The
    /// run then stays as it was.
    fn set_input(&mut self, parameter: &str, value: f64) -> Result<(), RunError> {
        self.run_mut().set_input(parameter, value)
    }

    /// The value of a parameter that holds from the last known position on; `None` if there is no such parameter.
    fn input(&self, parameter: &str) -> Option<f64> {
        self.run().input(parameter)
    }

    /// Runs up to the last node at or before `t` and shows each node to a controller, which may set inputs.
    ///
    /// # Errors
    ///
    /// The errors of [`Stepper::stream`] and of the controller.
    fn drive(
        &mut self,
        t: f64,
        controller: &mut dyn FnMut(&Node<N>, &mut dyn Inputs<N>) -> Result<(), RunError>,
    ) -> Result<(), RunError>
    where
        Self: Sized,
    {
        if t.is_infinite() {
            return Err(RunError::Until { until: t });
        }
        let end = self.clock().until(t)?;
        while self.run_mut().go_on(&end)? {
            controller(&self.node(), self)?;
        }
        Ok(())
    }
}

/// The place of a parameter.
pub(crate) fn known(shape: &Shape, parameter: &str) -> Result<usize, InputError> {
    let place = shape.parameters.iter().position(|known| known.name == parameter);
    place.ok_or_else(|| match shape.type_of_other(parameter) {
        Some(ty) => InputError::Type {
            field: parameter.to_owned(),
            ty: ty.to_owned(),
        },
        None => InputError::Unknown {
            parameter: parameter.to_owned(),
            parameters: shape.parameters.iter().map(|known| known.name.clone()).collect(),
        },
    })
}

/// The place of a parameter that is to be set to a value.
pub(crate) fn place(shape: &Shape, parameter: &str, value: f64) -> Result<usize, RunError> {
    let refused = |error| RunError::Input(Box::new(error));
    let place = known(shape, parameter).map_err(refused)?;
    let parameter = shape.parameters[place].name.clone();
    if !value.is_finite() {
        return Err(refused(InputError::NotFinite { parameter, value }));
    }
    if shape.of_positions.contains(&place) {
        return Err(refused(InputError::Position { parameter }));
    }
    if shape.of_rates.contains(&place) {
        return Err(refused(InputError::Rate { parameter }));
    }
    Ok(place)
}
