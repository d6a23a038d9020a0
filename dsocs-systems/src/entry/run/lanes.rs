//! Points of a sweep side by side, in SIMD lanes.

use std::borrow::Cow;

use dsocs_core::{AnyEnsemble, Declaration, Ensemble, Kernel, RunError, SetupError, System};

use super::beginning::Beginning;
use super::plan::{Method, Plan};
use crate::entry::{Entry, Row};

impl Entry {
    /// Whether sweeps run in lanes ([`Entry::in_lanes`]).
    #[must_use]
    pub fn has_lanes(&self) -> bool {
        self.system.has_lanes()
    }

    /// Runs several points to their ends side by side, each from its beginning and with its values of the
    /// parameters that vary, and passes the last node of each to `sink`, with its index. Points that fail are
    /// left out: [`Entry::run_point`] gives the reason. Returns whether this could be done.
    pub fn run_in_lanes(
        &self,
        plan: &Plan,
        beginnings: &[Beginning],
        parameters: &[VariedParameter],
        sink: &mut dyn FnMut(usize, &Row<'_>),
    ) -> bool {
        let shape = self.kernel().shape();
        let all_fit = beginnings.iter().all(|beginning| beginning.fits(shape).is_ok());
        all_fit && self.system.run_in_lanes(plan, beginnings, parameters, sink)
    }
}

/// A parameter that varies, by its name, and its value at each point.
pub type VariedParameter = (Cow<'static, str>, Vec<f64>);

/// The constructor of an ensemble of a system, with the step.
pub(crate) type InLanes<S> = for<'s> fn(&'s S, f64) -> Result<AnyEnsemble<'s>, SetupError>;

/// An ensemble of a declared system: the only code of lanes that is compiled for each system.
pub(super) fn ensemble<S: System<N>, const N: usize>(
    system: &S,
    h: f64,
) -> Result<AnyEnsemble<'_>, SetupError> {
    Ensemble::new(system, h).map(Ensemble::into_any)
}

/// Whether a run can share lanes: with the paper's step, and if parameters do not change during the run.
#[must_use]
pub fn can_share_lanes(plan: &Plan) -> bool {
    plan.method == Method::Step && plan.inputs.is_empty()
}

/// Runs points to their ends, and passes the last node of each to `sink`. A point that fails is left out: a
/// run of its own gives the reason. Returns whether the points could be run.
pub(super) fn run_in_lanes(
    kernel: &dyn Kernel,
    ensemble: Result<AnyEnsemble<'_>, SetupError>,
    plan: &Plan,
    beginnings: &[Beginning],
    parameters: &[VariedParameter],
    sink: &mut dyn FnMut(usize, &Row<'_>),
) -> bool {
    if !can_share_lanes(plan) {
        return false;
    }
    let ended = || -> Result<_, RunError> {
        let mut ensemble = ensemble?.starts(beginnings.iter().map(Beginning::start));
        for (name, values) in parameters {
            ensemble = ensemble.varied(name, values.iter().copied())?;
        }
        Ok(ensemble.here().to(plan.until))
    };
    let Ok(ended) = ended() else {
        return false;
    };
    let shape = kernel.shape();
    let count = shape.parameters.len();
    let mut own: Vec<f64> = (0..count).map(|place| kernel.value(place)).collect();
    let varied: Vec<(usize, &[f64])> = parameters
        .iter()
        .filter_map(|(name, values)| {
            let place = shape.parameters.iter().position(|known| known.name == *name)?;
            Some((place, &values[..]))
        })
        .collect();
    for (point, node) in ended.iter().enumerate() {
        let Ok(node) = node else { continue };
        for (place, values) in &varied {
            own[*place] = values[point];
        }
        let declaration = Declaration::of(kernel).with(&own);
        sink(point, &Row::of(node.any(), declaration));
    }
    true
}
