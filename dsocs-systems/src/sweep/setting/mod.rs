//! A plan after its names were looked up: the settings that all points of a sweep share.

mod manifest;

use std::borrow::Cow;
use std::ops::Range;

use serde_json::Value;

use super::error::SweepError;
use super::folder::TableKind;
use super::plan::{Plan, PlannedStart};
use super::points::Points;
use super::table::Kind;
use crate::entry::{self, Beginning, Column, Entry, EventQuantity, HeldInput, UnknownName, WatchedEvent};

/// The largest number of points in a part, unless the plan gives one.
const LARGEST_PART: u64 = 1 << 16;
/// The number of parts, unless the plan gives the points of a part.
const PARTS: u64 = 256;

/// The settings that all points of a sweep share, except the system.
#[derive(Clone, Debug)]
pub struct Setting {
    /// The points.
    pub points: Points,
    /// The destination of each value of a point.
    pub targets: Vec<Target>,
    /// The run, with the inputs as far as they do not vary.
    pub run: entry::Plan,
    /// Position and velocity at the start, as far as they do not vary.
    pub base: [Vec<f64>; 2],
    /// The start of a run, according to the plan.
    start: PlannedStart,
    /// The events that are watched.
    pub watched: Vec<WatchedEvent>,
    /// The names of the events.
    pub events: Vec<String>,
    /// The columns of the end that are kept.
    pub end: Vec<usize>,
    /// The columns whose extremes are kept.
    pub extremes: Vec<usize>,
    /// The distance between two kept nodes, in nodes, and the columns that are kept.
    pub nodes: Option<(u64, Vec<usize>)>,
    /// The columns of the tables: of points, and of nodes if they are kept.
    pub columns: [Vec<(String, Kind)>; 2],
    /// The number of points in a part.
    pub part: u64,
    /// Whether points are run side by side in lanes.
    pub in_lanes: bool,
}

/// The destination of a value of a point.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Target {
    /// A component of the first position.
    Position(usize),
    /// A component of the first velocity.
    Velocity(usize),
    /// A parameter.
    Parameter(Cow<'static, str>),
    /// An input, at one of its times.
    Input(usize, usize),
}

impl Setting {
    /// Looks up the names of a plan. Also returns the manifest: everything that the content of the sweep depends on.
    ///
    /// # Errors
    ///
    /// [`SweepError::Unknown`] for an unknown name, [`SweepError::Plan`] if something is missing or makes no
    /// sense.
    pub fn new(plan: &Plan, entry: &mut Entry) -> Result<(Self, Value), SweepError> {
        for (name, value) in &plan.set {
            let set = entry.set(name, *value);
            set.map_err(|unknown| SweepError::unknown(&format!("set.{name}"), unknown))?;
        }
        let h = plan.step.unwrap_or(entry.default_step());
        if h == 0.0 {
            return Err(SweepError::plan("step", "a step is not zero"));
        }
        let until = plan.until.unwrap_or(plan.start.t0 + entry.until_with(h));
        if (until - plan.start.t0) * h < 0.0 {
            return Err(SweepError::plan(
                "until",
                "the end lies behind the start; a negative step runs back in time",
            ));
        }
        let mut targets = Vec::new();
        let mut inputs = inputs(plan, entry)?;
        for (name, _) in &plan.vary {
            targets.push(target(name, entry, &mut inputs)?);
        }
        let base = start_state(plan, entry, &targets)?;
        let run = entry::Plan {
            h,
            until,
            method: plan.method,
            certify: false,
            estimate: false,
            inputs,
        };
        let all = entry::columns(entry.description(), &run);
        let coordinates = entry.description().coordinates.len();
        let end = match &plan.keep.end {
            Some(names) => places("keep.end", names, &all)?,
            None => (0..=2 * coordinates).collect(),
        };
        let extremes = places("keep.extremes", &plan.keep.extremes, &all)?;
        let nodes = match &plan.keep.nodes {
            Some(nodes) => Some((
                nodes.every,
                match &nodes.columns {
                    Some(names) => places("keep.nodes.columns", names, &all)?,
                    None => (0..=coordinates).collect(),
                },
            )),
            None => None,
        };
        let watched = watched_events(plan, entry)?;
        let points = Points::new(plan)?;
        let part = plan
            .part
            .unwrap_or(points.count().div_ceil(PARTS).clamp(1, LARGEST_PART));
        if plan.lanes && !(entry.has_lanes() && entry::can_share_lanes(&run)) {
            return Err(SweepError::plan(
                "lanes",
                if entry.has_lanes() {
                    "lanes take no inputs that change: leave out `lanes`, or the inputs"
                } else {
                    "this system's steps are not compiled for lanes: leave out `lanes`, make the entry with Entry::in_lanes, or sweep its text (`dsocs text`)"
                },
            ));
        }
        let mut setting = Self {
            points,
            targets,
            run,
            base,
            start: PlannedStart {
                project: plan.start.project || entry.projects(),
                ..plan.start.clone()
            },
            watched,
            events: plan.events.iter().map(|event| event.name.clone()).collect(),
            end,
            extremes,
            nodes,
            columns: [Vec::new(), Vec::new()],
            part,
            in_lanes: plan.lanes,
        };
        setting.columns = setting.columns(plan, &all)?;
        let manifest = setting.manifest(plan, entry, &all);
        Ok((setting, manifest))
    }

    /// The tables that the sweep writes, in the order in which the files of a part are finished.
    pub fn tables(&self) -> &'static [TableKind] {
        if self.nodes.is_some() {
            &[TableKind::Nodes, TableKind::Points]
        } else {
            &[TableKind::Points]
        }
    }

    /// The number of parts.
    pub fn parts(&self) -> u64 {
        self.points.count().div_ceil(self.part)
    }

    /// The points of a part.
    pub fn points_of(&self, part: u64) -> Range<u64> {
        part * self.part..((part + 1) * self.part).min(self.points.count())
    }

    /// The start of a run.
    pub fn beginning(&self, q0: &[f64], v0: &[f64]) -> Beginning {
        let (q0, v0) = (q0.to_vec(), v0.to_vec());
        let mut beginning = if self.start.paper {
            Beginning::Paper { q0, v0 }
        } else {
            Beginning::SecondOrder { q0, v0 }
        };
        if self.start.t0 != 0.0 {
            beginning = Beginning::At(self.start.t0, Box::new(beginning));
        }
        if self.start.project {
            beginning = Beginning::Projected(Box::new(beginning));
        }
        beginning
    }

    /// The columns of the tables.
    fn columns(&self, plan: &Plan, all: &[Column]) -> Result<[Vec<(String, Kind)>; 2], SweepError> {
        let mut points = vec![("point".to_owned(), Kind::Whole)];
        points.extend(plan.vary.iter().map(|(name, _)| (name.clone(), Kind::Number)));
        let mut add = |prefix: &str, places: &[usize]| {
            points.extend(
                places
                    .iter()
                    .map(|&place| (format!("{prefix}_{}", all[place].name), Kind::Number)),
            );
        };
        add("end", &self.end);
        add("least", &self.extremes);
        add("greatest", &self.extremes);
        for name in &self.events {
            points.push((format!("count_{name}"), Kind::Whole));
            points.push((format!("first_{name}"), Kind::Number));
            points.push((format!("last_{name}"), Kind::Number));
        }
        if self.watched.iter().any(|event| event.ends) {
            points.push(("ended_by".to_owned(), Kind::Text));
        }
        points.push(("error".to_owned(), Kind::Text));
        points.push(("message".to_owned(), Kind::Text));
        for (place, (name, _)) in points.iter().enumerate() {
            if points[..place].iter().any(|(other, _)| other == name) {
                return Err(SweepError::plan(
                    "keep",
                    &format!("two columns would be called `{name}`"),
                ));
            }
        }
        let mut nodes = vec![
            ("point".to_owned(), Kind::Whole),
            ("node".to_owned(), Kind::Whole),
        ];
        if let Some((_, places)) = &self.nodes {
            nodes.extend(
                places
                    .iter()
                    .map(|&place| (all[place].name.clone(), Kind::Number)),
            );
        }
        Ok([points, nodes])
    }
}

/// The indices of some columns.
fn places(at: &str, names: &[String], all: &[Column]) -> Result<Vec<usize>, SweepError> {
    let place = |name: &String| {
        all.iter().position(|column| column.name == *name).ok_or_else(|| {
            let known = all.iter().map(|column| column.name.clone());
            SweepError::unknown(at, UnknownName::new("column", name, known))
        })
    };
    names.iter().map(place).collect()
}

/// The inputs of a plan; a value that varies is NaN here.
fn inputs(plan: &Plan, entry: &Entry) -> Result<Vec<HeldInput>, SweepError> {
    let mut inputs = Vec::new();
    for (name, values) in &plan.inputs {
        inputs.push(HeldInput {
            parameter: parameter(name, entry, &format!("input.{name}"))?,
            values: values.clone(),
        });
    }
    for (name, _) in &plan.vary {
        let Some((of, time)) = name.split_once('@') else {
            continue;
        };
        let at = format!("vary.{name}");
        let of = parameter(of, entry, &at)?;
        let Ok(time) = time.parse::<f64>() else {
            return Err(SweepError::plan(
                &at,
                "after `@` stands the time from which the value holds, as in \"push@2.5\"",
            ));
        };
        if !inputs.iter().any(|input| input.parameter == of) {
            inputs.push(HeldInput {
                parameter: of.clone(),
                values: Vec::new(),
            });
        }
        for input in inputs.iter_mut().filter(|input| input.parameter == of) {
            let place = input.values.partition_point(|&[before, _]| before < time);
            match input.values.get_mut(place) {
                Some(pair) if pair[0].to_bits() == time.to_bits() => pair[1] = f64::NAN,
                _ => input.values.insert(place, [time, f64::NAN]),
            }
        }
    }
    Ok(inputs)
}

/// A parameter by its name.
fn parameter(name: &str, entry: &Entry, at: &str) -> Result<Cow<'static, str>, SweepError> {
    let known = || {
        entry
            .description()
            .parameters
            .iter()
            .map(|known| known.name.clone())
    };
    known()
        .find(|known| *known == name)
        .ok_or_else(|| SweepError::unknown(at, entry.unknown_parameter(name)))
}

/// The destination of the values of a quantity.
fn target(name: &str, entry: &Entry, inputs: &mut [HeldInput]) -> Result<Target, SweepError> {
    let description = entry.description();
    if let Some((of, time)) = name.split_once('@') {
        let time: Option<f64> = time.parse().ok();
        let place = inputs.iter().enumerate().find_map(|(place, input)| {
            let row = input.values.iter().position(|pair| Some(pair[0]) == time)?;
            (input.parameter == of).then_some(Target::Input(place, row))
        });
        return place.ok_or_else(|| SweepError::plan(&format!("vary.{name}"), "there is no such time"));
    }
    let position = description
        .names()
        .position(|known| known == name)
        .map(Target::Position);
    let velocity = description
        .names()
        .position(|known| name.strip_prefix("v_") == Some(known))
        .map(Target::Velocity);
    let parameters = || description.parameters.iter().map(|known| known.name.clone());
    let parameter = parameters().find(|known| *known == name).map(Target::Parameter);
    match [position, velocity, parameter]
        .into_iter()
        .flatten()
        .collect::<Vec<_>>()
        .as_slice()
    {
        [target] => Ok(target.clone()),
        [] => {
            let starts = description.names().map(str::to_owned);
            let rates = description.names().map(|name| format!("v_{name}"));
            let known = starts.chain(rates).chain(parameters().map(Cow::into_owned));
            Err(SweepError::unknown(
                "vary",
                UnknownName::new("start or parameter", name, known),
            ))
        }
        _ => Err(SweepError::plan(
            &format!("vary.{name}"),
            "the name means both a start and a parameter; rename the parameter",
        )),
    }
}

/// Position and velocity at the start, as far as they do not vary.
fn start_state(plan: &Plan, entry: &Entry, targets: &[Target]) -> Result<[Vec<f64>; 2], SweepError> {
    let names: Vec<_> = entry.description().names().collect();
    let own = entry.default_start();
    let given = [
        ("q0", &plan.start.q0, Target::Position as fn(usize) -> Target),
        ("v0", &plan.start.v0, Target::Velocity),
    ];
    let mut base = [Vec::new(), Vec::new()];
    for (place, (key, given, of)) in given.into_iter().enumerate() {
        let at = format!("start.{key}");
        let own = || own.map(|start| start[place].clone());
        let mut numbers = given
            .clone()
            .or_else(own)
            .unwrap_or_else(|| vec![f64::NAN; names.len()]);
        // a rotation has three numbers of velocity, in the frame of its body
        let rotations = &entry.description().rotations;
        if key == "v0" && numbers.len() + rotations.len() == names.len() {
            for &first in rotations {
                numbers.insert(first, 0.0);
            }
        }
        if numbers.len() != names.len() {
            return Err(SweepError::plan(
                &at,
                &format!(
                    "{} numbers, but there are {} coordinates: {}",
                    numbers.len(),
                    names.len(),
                    names.join(", ")
                ),
            ));
        }
        let missing =
            (0..names.len()).find(|&of_name| numbers[of_name].is_nan() && !targets.contains(&of(of_name)));
        if let Some(missing) = missing {
            return Err(SweepError::plan(
                &at,
                &format!(
                    "`{}` has no start of its own: give `{key}`, or let `{}` vary",
                    entry.name(),
                    names[missing]
                ),
            ));
        }
        base[place] = numbers;
    }
    Ok(base)
}

/// The events that are watched.
fn watched_events(plan: &Plan, entry: &Entry) -> Result<Vec<WatchedEvent>, SweepError> {
    let description = entry.description();
    let find = |name: &str| {
        if name == "t" {
            return Some(EventQuantity::Time);
        }
        let position = |name: &str| description.names().position(|known| known == name);
        let rate = || {
            name.strip_prefix("v_")
                .and_then(position)
                .map(EventQuantity::Velocity)
        };
        let observed = || {
            description
                .observables
                .iter()
                .position(|known| known.name == name)
        };
        position(name)
            .map(EventQuantity::Position)
            .or_else(rate)
            .or_else(|| observed().map(EventQuantity::Observed))
    };
    let mut watched = Vec::new();
    for event in &plan.events {
        let Some(of) = find(&event.quantity) else {
            let starts = description.names().map(str::to_owned);
            let rates = description.names().map(|name| format!("v_{name}"));
            let observed = description
                .observables
                .iter()
                .map(|known| known.name.clone().into_owned());
            let known = ["t".to_owned()]
                .into_iter()
                .chain(starts)
                .chain(rates)
                .chain(observed);
            return Err(SweepError::unknown(
                "event.quantity",
                UnknownName::new("quantity", &event.quantity, known),
            ));
        };
        watched.push(WatchedEvent {
            quantity: of,
            value: event.value,
            rising: event.rising,
            ends: event.ends,
        });
    }
    Ok(watched)
}
