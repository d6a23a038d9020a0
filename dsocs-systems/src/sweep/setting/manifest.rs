//! The manifest of a sweep: everything that its content depends on.

use serde_json::{Value, json};

use super::{Setting, Target};
use crate::entry::{Column, Entry, Method};
use crate::sweep::plan::{Plan, Values};

impl Setting {
    /// The manifest.
    pub(super) fn manifest(&self, plan: &Plan, entry: &mut Entry, all: &[Column]) -> Value {
        let method = match plan.method {
            Method::Step => json!({"order": 2}),
            Method::Composed(composition) => json!({"order": composition.order()}),
            Method::Tolerance(tolerance) => json!({"tolerance": tolerance}),
        };
        let vary = |(name, values): &(String, Values)| {
            let values = match values {
                Values::List(list) => json!({"list": list}),
                Values::Range {
                    from,
                    to,
                    count,
                    logarithmic,
                } => {
                    json!({"from": from, "to": to, "count": count, "scale": if *logarithmic { "logarithmic" } else { "linear" }})
                }
            };
            json!({"name": name, "unit": unit(name, entry, all), "values": values})
        };
        let vary: Vec<Value> = plan.vary.iter().map(vary).collect();
        let units = |places: &[usize]| -> Value {
            places
                .iter()
                .map(|&place| (all[place].name.clone(), json!(all[place].unit)))
                .collect()
        };
        let varies = |of: fn(usize) -> Target, place: usize| self.targets.contains(&of(place));
        let shown = |of: fn(usize) -> Target, numbers: &[f64]| -> Vec<Value> {
            let number = |(place, &number): (usize, &f64)| {
                if varies(of, place) {
                    json!("varies")
                } else {
                    json!(number)
                }
            };
            numbers.iter().enumerate().map(number).collect()
        };
        let inputs = self.run.inputs.iter();
        let inputs: Vec<Value> = inputs
            .map(|input| json!({"parameter": input.parameter, "values": input.values.iter().map(|pair| pair.map(|x| if x.is_nan() { json!("varies") } else { json!(x) })).collect::<Vec<_>>()}))
            .collect();
        let parameters: Value = entry
            .parameters()
            .into_iter()
            .filter(|(parameter, _)| !self.targets.contains(&Target::Parameter(parameter.name.clone())))
            .map(|(parameter, value)| (parameter.name.into_owned(), json!(value)))
            .collect();
        json!({
            "system": entry.name(),
            "method": method,
            "step": self.run.h,
            "until": self.run.until,
            "start": {
                "q0": shown(Target::Position, &self.base[0]),
                "v0": shown(Target::Velocity, &self.base[1]),
                "t0": self.start.t0,
                "rule": if self.start.paper { "paper" } else { "second-order" },
                "project": self.start.project,
            },
            "parameters": parameters,
            "inputs": inputs,
            "vary": vary,
            "sample": plan.sample.map(|sample| json!({"kind": format!("{:?}", sample.kind), "count": sample.count, "seed": sample.seed})),
            "keep": {
                "end": units(&self.end),
                "extremes": units(&self.extremes),
                "nodes": self.nodes.as_ref().map(|(every, places)| json!({"every": every, "columns": units(places)})),
            },
            "events": plan.events.iter().map(|event| json!({
                "name": event.name, "quantity": event.quantity, "value": event.value,
                "direction": match event.rising { None => "both", Some(true) => "rising", Some(false) => "falling" },
                "ends": event.ends,
            })).collect::<Vec<_>>(),
            "part": self.part,
            "lanes": self.in_lanes,
        })
    }
}

/// The unit of a quantity that varies, if the declaration gives it.
fn unit(name: &str, entry: &Entry, all: &[Column]) -> Option<String> {
    let column = all.iter().find(|column| column.name == name);
    let parameter = name.split_once('@').map_or(name, |(parameter, _)| parameter);
    let mut parameters = entry.description().parameters.iter();
    match column {
        Some(column) => column.unit.clone(),
        None => parameters
            .find(|known| known.name == parameter)?
            .unit()
            .map(str::to_owned),
    }
}
