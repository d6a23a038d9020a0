//! Inputs that are held: their values over time, and the continuous motion under them that errors are measured against.

use std::borrow::Cow;

use dsocs_core::__private::held_value;
use dsocs_core::taylor::GlobalError;
use dsocs_core::{Inputs, RunError, SetupError, Start, System, TaylorFlow};

use super::run::Errors;

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
    /// The value at a time. A time that is one of the plan's to within rounding is that time.
    pub(super) fn at(&self, t: f64, h: f64) -> Option<f64> {
        held_value(&self.values, t, h)
    }
}

/// Gives inputs the values that they have at a time.
pub(super) fn set<const N: usize>(
    run: &mut dyn Inputs<N>,
    inputs: &[HeldInput],
    (t, h): (f64, f64),
) -> Result<(), RunError> {
    for input in inputs {
        if let Some(value) = input.at(t, h) {
            run.set_input(&input.parameter, value)?;
        }
    }
    Ok(())
}

/// How far a motion is from the continuous one under the same inputs. Both change at the nodes, which lie `h` apart.
pub(super) struct HeldErrors<'s, S: System<N> + Clone, const N: usize> {
    /// The continuous motions, the one that counts first.
    motions: [TaylorFlow<'s, S, N>; 2],
    /// The inputs.
    inputs: &'s [HeldInput],
    /// The step.
    h: f64,
    /// The largest distance of the two motions so far.
    uncertainty: f64,
}

impl<'s, S: System<N> + Clone, const N: usize> HeldErrors<'s, S, N> {
    /// The errors of motions from a start with the step `h`.
    pub(super) fn new(
        system: &'s S,
        h: f64,
        start: Start<N>,
        inputs: &'s [HeldInput],
    ) -> Result<Self, SetupError> {
        let [first, second] = GlobalError::<S, N>::REFERENCES;
        let motion = |tolerance| TaylorFlow::new(system, start, tolerance)?.every(h);
        Ok(Self {
            motions: [motion(first)?, motion(second)?],
            inputs,
            h,
            uncertainty: 0.0,
        })
    }
}

impl<S: System<N> + Clone, const N: usize> Errors<N> for HeldErrors<'_, S, N> {
    fn at(&mut self, t: f64, q: &[f64; N]) -> Result<[f64; N], RunError> {
        let mut positions = [[0.0; N]; 2];
        for (position, motion) in positions.iter_mut().zip(&mut self.motions) {
            let run: &mut dyn Inputs<N> = motion;
            // nodes lie a step apart: half of one is no time to be told from the next
            while (t - run.node().t) * self.h.signum() > 0.5 * self.h.abs() {
                let now = run.node().t;
                set(run, self.inputs, (now, self.h))?;
                run.step(t)?;
            }
            *position = run.node().q;
        }
        let [truth, other] = &positions;
        for (truth, other) in truth.iter().zip(other) {
            // over short legs both may agree to the last digit, which still is a rounded one
            let rounding = f64::EPSILON * truth.abs();
            self.uncertainty = self.uncertainty.max((truth - other).abs()).max(rounding);
        }
        Ok(core::array::from_fn(|i| (q[i] - truth[i]).abs()))
    }

    fn uncertainty(&self) -> f64 {
        self.uncertainty
    }
}
