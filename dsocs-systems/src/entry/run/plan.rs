//! The plan of a run: the step, the method, the end, and held inputs.

use std::borrow::Cow;

use dsocs_core::__private::held_value;
use dsocs_core::Composition;

use super::any_system::AnySystem;

/// The method of a motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    /// By the paper's step, of order 2.
    Step,
    /// By a composition of it.
    Composed(Composition),
    /// The continuous motion, to a tolerance relative to the size of the velocities.
    Tolerance(f64),
}

/// A run that is asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// The step, and the interval of the output.
    pub h: f64,
    /// The time of the end.
    pub until: f64,
    /// The method.
    pub method: Method,
    /// Whether the regularity at each node is recorded; possible with the paper's step only.
    pub certify: bool,
    /// Whether the error at each node is estimated; see [`dsocs_core::taylor::GlobalError`].
    pub estimate: bool,
    /// Parameters that change during the run.
    pub inputs: Vec<HeldInput>,
}

impl Plan {
    /// The plan of a run back in time: before its first time an input has the parameter's own value again.
    pub(super) fn with_own_values(&self, system: &dyn AnySystem) -> Cow<'_, Self> {
        if self.inputs.is_empty() || self.h > 0.0 {
            return Cow::Borrowed(self);
        }
        let (mut plan, kernel) = (self.clone(), system.kernel());
        for input in &mut plan.inputs {
            let parameters = &kernel.shape().parameters;
            let place = parameters.iter().position(|known| known.name == input.parameter);
            if let Some(place) = place {
                input.values.insert(0, [f64::NEG_INFINITY, kernel.value(place)]);
            }
        }
        Cow::Owned(plan)
    }
}

/// A parameter whose value changes at given times and is held in between.
#[derive(Clone, Debug, PartialEq)]
pub struct HeldInput {
    /// The name of the parameter.
    pub parameter: Cow<'static, str>,
    /// Increasing times in s, each with the value that holds from this time on. Before the first time the parameter has the value that it has
    /// in the system.
    pub values: Vec<[f64; 2]>,
}

impl HeldInput {
    /// The value at a time. A time that differs from one of the plan's by rounding only is that time.
    pub(crate) fn at(&self, t: f64, h: f64) -> Option<f64> {
        held_value(&self.values, t, h)
    }
}
