//! Detects values of inputs that hold at no node.

use crate::entry::{HeldInput, Plan};

/// A warning for a run from the time `t0` with an input one of whose values never holds: no node lies between
/// its time and that of the next value.
#[must_use]
pub fn passed_inputs(plan: &Plan, t0: f64) -> Option<String> {
    plan.inputs.iter().find_map(|input| passed(input, plan, t0))
}

/// The warning for one input.
#[allow(clippy::float_cmp)] // a value that is given again is the same number
fn passed(input: &HeldInput, plan: &Plan, t0: f64) -> Option<String> {
    let steps = |t: f64| (t - t0) / plan.h;
    let end = steps(plan.until);
    let is_passed = |place: usize| {
        let [[from, value], [to, next]] = [input.values[place], input.values[place + 1]];
        let before = place.checked_sub(1).map(|before| input.values[before][1]);
        // back in time a value is reached from its end
        let first = steps(from).min(steps(to));
        let is_of_run = (0.0..end).contains(&first);
        // a value that holds at any node holds at one of the first nodes there
        let holds = || {
            [0.0, 1.0, 2.0]
                .map(|k| input.at(t0 + (first.floor() + k) * plan.h, plan.h))
                .contains(&Some(value))
        };
        is_of_run && value != next && Some(value) != before && !holds()
    };
    let passed: Vec<usize> = (0..input.values.len().saturating_sub(1))
        .filter(|&place| is_passed(place))
        .collect();
    let shortest = passed
        .iter()
        .map(|&place| input.values[place + 1][0] - input.values[place][0])
        .fold(f64::INFINITY, f64::min);
    let &first = passed.first()?;
    let [t, value] = input.values[first];
    let (count, rest) = match passed.len() {
        1 => ("a value".to_owned(), "it"),
        count => (format!("{count} values"), "the first of them"),
    };
    Some(format!(
        "warning: {count} of the input `{name}` never held: a value holds from the next node on, and between {rest}, {value} at t = {t}, and the next \
         there is none (a `--step` of {step:.1e} has nodes for all; or declare `{name}` as samples in the text, which are looked at between nodes, too)",
        name = input.parameter,
        step = 0.9 * shortest,
    ))
}
