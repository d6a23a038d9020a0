//! A run as JSON, for the head of its table and for its page.

use serde_json::{Map, Value, json};

use crate::cli::page::motion::{MotionPage, titles};
use crate::entry::{Beginning, Column, Entry, Method, Plan, columns};

/// The page of a finished run, as `run --report` writes it. `rows` has the values of all [`columns`] at each
/// node, in their order, and after them those of the parameters that changed on the way, whose names are
/// `changed`; `notes` are the messages of the run.
///
/// ```
/// use dsocs_core::text::Text;
/// use dsocs_systems::entry::{Beginning, Method, Plan};
/// use dsocs_systems::{Entry, cli};
/// use std::ops::ControlFlow;
///
/// let text = Text::parse("spring", "coordinates(x); lagrangian = dot(x).powi(2) / 2 - 2 * x.powi(2);")?;
/// let mut entry = Entry::of_text("spring", &text, None);
/// let plan = Plan { h: 0.01, until: 1.0, method: Method::Step, certify: false, estimate: false, inputs: Vec::new() };
/// let beginning = Beginning::SecondOrder { q0: vec![1.0], v0: vec![0.0] };
/// let mut rows = Vec::new();
/// entry.run(&plan, &beginning, &mut |row| {
///     let mut values = Vec::new();
///     row.write(&mut values);
///     rows.push(values);
///     ControlFlow::Continue(())
/// })?;
/// assert!(cli::run_page(&mut entry, &plan, &beginning, &[], rows, &[]).starts_with("<!DOCTYPE html>"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[must_use]
pub fn run_page(
    entry: &mut Entry,
    plan: &Plan,
    beginning: &Beginning,
    changed: &[String],
    rows: impl IntoIterator<Item = Vec<f64>>,
    notes: &[String],
) -> String {
    let draw = entry.drawing();
    let mut all = columns(entry.description(), plan);
    let parameters = entry.parameters();
    all.extend(changed.iter().map(|name| {
        let known = parameters.iter().find(|(parameter, _)| parameter.name == **name);
        Column {
            name: name.clone(),
            unit: known.and_then(|(parameter, _)| parameter.unit().map(str::to_owned)),
        }
    }));
    let mut page = MotionPage::new(&all, entry.description(), draw);
    for (index, values) in (0..).zip(rows) {
        page.push(index, &values);
    }
    let mut about = run_description(entry, plan, beginning);
    if let Some(Value::Object(values)) = about.get_mut("parameters") {
        for name in changed {
            if let Some(value) = values.get_mut(name) {
                *value = format!("{value} at the start, then as shown").into();
            }
        }
    }
    page.finish(titles(entry).each_ref().map(String::as_str), &about, notes)
}

/// The start as JSON.
fn start_as_json(beginning: &Beginning) -> Value {
    match beginning {
        Beginning::Paper { q0, v0 } => json!({"rule": "paper", "q0": q0, "v0": v0}),
        Beginning::SecondOrder { q0, v0 } => json!({"rule": "second_order", "q0": q0, "v0": v0}),
        Beginning::ThirdOrder { q0, v0, a0 } => {
            json!({"rule": "third_order", "q0": q0, "v0": v0, "a0": a0})
        }
        Beginning::ThirdOrderByForce { q0, v0, force } => {
            json!({"rule": "third_order_by_force", "q0": q0, "v0": v0, "f0": force})
        }
        Beginning::Nodes { q0, q1 } => json!({"rule": "nodes", "q0": q0, "q1": q1}),
        Beginning::ThreeNodes { q0, q1, q2 } => {
            json!({"rule": "three_nodes", "q0": q0, "q1": q1, "q2": q2})
        }
        Beginning::Near(a0, beginning) => {
            let mut start = start_as_json(beginning);
            start["near_a0"] = a0.clone().into();
            start
        }
        Beginning::At(t0, beginning) => {
            let mut start = start_as_json(beginning);
            start["t0"] = (*t0).into();
            start
        }
        Beginning::Projected(beginning) => {
            let mut start = start_as_json(beginning);
            start["projected"] = true.into();
            start
        }
    }
}

/// The description of a run that precedes its rows in JSON.
pub(super) fn run_description(entry: &mut Entry, plan: &Plan, beginning: &Beginning) -> Map<String, Value> {
    let start = start_as_json(beginning);
    let accuracy = match plan.method {
        Method::Step => json!({"order": 2}),
        Method::Composed(method) => json!({"order": method.order()}),
        Method::Tolerance(tolerance) => json!({"tolerance": tolerance}),
    };
    let parameters: Map<String, Value> = entry
        .parameters()
        .into_iter()
        .map(|(parameter, value)| (parameter.name.into_owned(), value.into()))
        .collect();
    [
        ("system", entry.name().into()),
        ("step", plan.h.into()),
        ("until", plan.until.into()),
        ("accuracy", accuracy),
        ("start", start),
        ("parameters", parameters.into()),
    ]
    .into_iter()
    .map(|(key, value)| (key.to_owned(), value))
    .collect()
}
