//! Points of a sweep side by side, in SIMD lanes.

use std::borrow::Cow;

use dsocs_core::{Declaration, Ensemble, RunError, Start, System};

use super::columns::Row;
use super::plan::{Method, Plan};

/// A parameter that varies, by its name, and its value at each point.
pub type Varied = (Cow<'static, str>, Vec<f64>);

/// What runs points of a system side by side.
pub(super) type Ends<S, const N: usize> =
    fn(&S, &Plan, Vec<Start<N>>, &[Varied], &mut dyn FnMut(usize, &Row<'_>)) -> bool;

/// Whether a run can share lanes: with the paper's step, and if parameters do not change during the run.
#[must_use]
pub fn shares(plan: &Plan) -> bool {
    plan.method == Method::Step && plan.inputs.is_empty()
}

/// Runs points to their ends, and hands the last node of each to `sink`. A point that fails is left out: a run of its own says why. Returns
/// whether the points could be run.
pub(super) fn ends<S: System<N> + Clone + Sync, const N: usize>(
    system: &S,
    plan: &Plan,
    starts: Vec<Start<N>>,
    parameters: &[Varied],
    sink: &mut dyn FnMut(usize, &Row<'_>),
) -> bool {
    if !shares(plan) {
        return false;
    }
    let ended = || -> Result<_, RunError> {
        let mut ensemble = Ensemble::new(system, plan.h)?.starts(starts);
        for (name, values) in parameters {
            ensemble = ensemble.varied(name, values.iter().copied())?;
        }
        Ok(ensemble.here().to(plan.until))
    };
    let Ok(ended) = ended() else {
        return false;
    };
    let shape = system.kernel().shape();
    let count = shape.parameters.len();
    let mut own: Vec<f64> = (0..count).map(|place| system.kernel().value(place)).collect();
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
        let declaration = Declaration::of(system.kernel()).with(&own);
        sink(point, &Row::of(node.any(), declaration));
    }
    true
}
