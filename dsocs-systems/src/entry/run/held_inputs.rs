//! Held inputs: their values during a run, and the errors against the continuous motion under the same
//! inputs.

use dsocs_core::taylor::{AnyGlobalError, rounding};
use dsocs_core::{OwnedNode, Run, RunError, SetupError};

use super::any_system::AnySystem;
use super::beginning::Beginning;
use super::plan::HeldInput;
use super::reference::Errors;

/// Sets the inputs to their values at a time.
pub(super) fn set(run: &mut dyn Run, inputs: &[HeldInput], (t, h): (f64, f64)) -> Result<(), RunError> {
    for input in inputs {
        if let Some(value) = input.at(t, h) {
            run.set_input(&input.parameter, value)?;
        }
    }
    Ok(())
}

/// The errors of a motion against the continuous one under the same inputs. The inputs change at the nodes,
/// which lie `h` apart.
pub(super) struct ErrorsUnderInputs<'s> {
    /// Two continuous motions, the reference first; their distance is the uncertainty.
    motions: [Box<dyn Run + 's>; 2],
    /// Their current nodes.
    nodes: [OwnedNode; 2],
    /// The inputs.
    inputs: &'s [HeldInput],
    /// The step.
    h: f64,
    /// The largest distance of the two motions so far.
    uncertainty: f64,
}

impl<'s> ErrorsUnderInputs<'s> {
    /// The errors of motions from a start with the step `h`.
    pub(super) fn new(
        system: &'s dyn AnySystem,
        h: f64,
        beginning: &Beginning,
        inputs: &'s [HeldInput],
    ) -> Result<Self, SetupError> {
        // the tolerances of the two reference motions
        let [first, second] = AnyGlobalError::REFERENCES;
        let node = || OwnedNode::new(system.kernel().shape().dimension());
        Ok(Self {
            motions: [
                system.continuous(beginning, first, Some(h))?,
                system.continuous(beginning, second, Some(h))?,
            ],
            nodes: [node(), node()],
            inputs,
            h,
            uncertainty: 0.0,
        })
    }
}

impl Errors for ErrorsUnderInputs<'_> {
    fn at(&mut self, t: f64, q: &[f64]) -> Result<Vec<f64>, RunError> {
        for (node, run) in self.nodes.iter_mut().zip(&mut self.motions) {
            node.take(&**run);
            // nodes lie a step apart, so times that differ by less than half of one are the same
            while (t - node.any().t) * self.h.signum() > 0.5 * self.h.abs() {
                let now = node.any().t;
                set(&mut **run, self.inputs, (now, self.h))?;
                run.step(t)?;
                node.take(&**run);
            }
        }
        let [truth, other] = self.nodes.each_ref().map(|node| node.any().q);
        let v = self.nodes[0].any().v;
        for ((truth, other), v) in truth.iter().zip(other).zip(v) {
            self.uncertainty = (self.uncertainty)
                .max((truth - other).abs())
                .max(rounding(t, *truth, *v));
        }
        Ok(q.iter().zip(truth).map(|(q, truth)| (q - truth).abs()).collect())
    }

    fn uncertainty(&self) -> f64 {
        self.uncertainty
    }
}
