//! A plan as it is written down. Its names are not looked up yet.

mod section;

use dsocs_core::Composition;
use toml::{Table, Value};

use super::error::SweepError;
use crate::entry::Method;

use section::{Section, fail, number, wrong};

/// The plan of a sweep. It is read from TOML ([`Plan::read`]). The documentation of the module shows all
/// keys.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// The name of the system. It may be left out if there is only one.
    pub system: Option<String>,
    /// The step `h`, in s. By default it is the entry's.
    pub step: Option<f64>,
    /// The end of each run, in s. By default it is the entry's.
    pub until: Option<f64>,
    /// The method.
    pub method: Method,
    /// The start of the runs.
    pub start: PlannedStart,
    /// Parameters with values other than the entry's.
    pub set: Vec<(String, f64)>,
    /// Parameters whose value changes at given times: pairs of a time and the value from then on. The times ascend.
    pub inputs: Vec<(String, Vec<[f64; 2]>)>,
    /// The quantities that vary. For example, `x` is the value of a coordinate at the start, `v_x` that of its velocity, and `mass` is a
    /// parameter. `push@2` is the value that the parameter `push` has from the time 2 on.
    pub vary: Vec<(String, Values)>,
    /// Random points instead of a grid.
    pub sample: Option<Sample>,
    /// The results that are kept of each run.
    pub keep: Keep,
    /// The events that are counted.
    pub events: Vec<PlannedEvent>,
    /// The number of points in a part. By default it is 1/256 of all points, at most 65536.
    pub part: Option<u64>,
    /// Whether eight runs share the lanes of the processor; see [`Entry::in_lanes`](crate::Entry::in_lanes).
    pub lanes: bool,
}

/// The start of the runs, as far as it does not vary.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlannedStart {
    /// The position. By default it is the entry's.
    pub q0: Option<Vec<f64>>,
    /// The velocity. By default it is the entry's.
    pub v0: Option<Vec<f64>>,
    /// The time, in s.
    pub t0: f64,
    /// Whether the second node is the paper's, `q0 + h v0`, of first order.
    pub paper: bool,
    /// Whether starts are projected onto the constraints.
    pub project: bool,
}

/// The values of a quantity that varies.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// A list of values.
    List(Vec<f64>),
    /// A range with both ends: `count` values on a grid, or any values in it for random points.
    Range {
        /// The first.
        from: f64,
        /// The last.
        to: f64,
        /// The number of values; `None` for random points.
        count: Option<u64>,
        /// Whether the values are a geometric progression instead of an arithmetic one.
        logarithmic: bool,
    },
}

/// Random points. Each is computed from the seed and its number only.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sample {
    /// The rule.
    pub kind: SampleKind,
    /// The number of points.
    pub count: u64,
    /// The seed: another seed gives other points.
    pub seed: u64,
}

/// Rules for random points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SampleKind {
    /// A Latin hypercube: the range of each quantity is divided into `count` equal parts, and each part contains one value. Each quantity has
    /// its own random order (`McKay`, Beckman and Conover 1979).
    LatinHypercube,
    /// Sobol's sequence with Owen's scrambling; at most [`MOST_SOBOL_POINTS`] points.
    Sobol,
    /// Independent points.
    Random,
}

/// The largest number of points of [`SampleKind::Sobol`].
pub const MOST_SOBOL_POINTS: u64 = 1 << 16;

/// The results that are kept of each run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Keep {
    /// The columns that are kept at the end. By default: the time, all coordinates and all velocities.
    pub end: Option<Vec<String>>,
    /// The columns whose least and greatest value over all nodes are kept.
    pub extremes: Vec<String>,
    /// The nodes that are kept, in a table of their own.
    pub nodes: Option<KeptNodes>,
}

/// Nodes that are kept.
#[derive(Clone, Debug, PartialEq)]
pub struct KeptNodes {
    /// The distance between two kept nodes, in nodes.
    pub every: u64,
    /// The columns. By default: the time and all coordinates.
    pub columns: Option<Vec<String>>,
}

/// An event: a quantity passes a value.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedEvent {
    /// Its name.
    pub name: String,
    /// The quantity: `t`, a coordinate, a velocity or an observed expression.
    pub quantity: String,
    /// The value that it passes.
    pub value: f64,
    /// `Some(true)` if only upwards, `Some(false)` if only downwards.
    pub rising: Option<bool>,
    /// Whether a run ends there.
    pub ends: bool,
}

impl Plan {
    /// Reads a plan.
    ///
    /// # Errors
    ///
    /// [`SweepError::Syntax`] if it is not TOML. [`SweepError::Plan`] names the place of a mistake, and for an unknown word the nearest known
    /// one.
    pub fn read(text: &str) -> Result<Self, SweepError> {
        let table: Table = text
            .parse()
            .map_err(|error: toml::de::Error| SweepError::Syntax(error.to_string()))?;
        let mut plan = Section::new("", table);
        let mut start = plan.section("start")?;
        let mut keep = plan.section("keep")?;
        let read = Self {
            system: plan.text("system")?,
            step: plan.number("step")?,
            until: plan.number("until")?,
            method: method(&mut plan)?,
            start: PlannedStart {
                q0: start.numbers("q0")?,
                v0: start.numbers("v0")?,
                t0: start.number("t0")?.unwrap_or(0.0),
                paper: start.choice("rule", &[("second-order", false), ("paper", true)])? == Some(true),
                project: start.flag("project")?,
            },
            set: plan
                .section("set")?
                .entries()
                .map(|(at, name, value)| Ok((name, number(&at, &value)?)))
                .collect::<Result<_, SweepError>>()?,
            inputs: plan
                .section("input")?
                .entries()
                .map(|(at, name, value)| Ok((name, held(&at, value)?)))
                .collect::<Result<_, SweepError>>()?,
            sample: sample(&mut plan)?,
            vary: plan
                .section("vary")?
                .entries()
                .map(|(at, name, value)| Ok((name, values(&at, value)?)))
                .collect::<Result<_, SweepError>>()?,
            keep: Keep {
                end: keep.texts("end")?,
                extremes: keep.texts("extremes")?.unwrap_or_default(),
                nodes: match keep.optional_section("nodes")? {
                    Some(mut nodes) => {
                        let kept = KeptNodes {
                            every: nodes.count("every")?.unwrap_or(1),
                            columns: nodes.texts("columns")?,
                        };
                        nodes.finish()?;
                        Some(kept)
                    }
                    None => None,
                },
            },
            events: events(&mut plan)?,
            part: plan.count("part")?,
            lanes: plan.flag("lanes")?,
        };
        start.finish()?;
        keep.finish()?;
        plan.finish()?;
        read.check()?;
        Ok(read)
    }

    /// Checks everything that does not depend on the system.
    fn check(&self) -> Result<(), SweepError> {
        if self.vary.is_empty() {
            return fail("vary", "nothing varies; one run is `dsocs run`");
        }
        for (name, values) in &self.vary {
            let at = &format!("vary.{name}");
            match values {
                Values::List(values) if values.is_empty() => return fail(at, "the list is empty"),
                Values::Range { count: None, .. } if self.sample.is_none() => {
                    return fail(at, "a grid needs a `count`; points by chance a table [sample]");
                }
                Values::Range { count: Some(_), .. } if self.sample.is_some() => {
                    return fail(at, "`count` is of a grid; with [sample] the count stands there");
                }
                Values::Range {
                    from,
                    to,
                    logarithmic: true,
                    ..
                } if *from == 0.0 || *to == 0.0 || (*from < 0.0) != (*to < 0.0) => {
                    return fail(
                        at,
                        "on a logarithmic scale both ends have one sign and none is zero",
                    );
                }
                Values::List(_) | Values::Range { .. } => {}
            }
        }
        let to_ends = self.events.is_empty() && self.keep.extremes.is_empty() && self.keep.nodes.is_none();
        if self.lanes && !(to_ends && self.method == Method::Step && self.inputs.is_empty()) {
            return fail(
                "lanes",
                "lanes take runs of order 2 of which only the end is kept, without inputs: leave out `lanes`, or events, extremes, nodes, inputs and the method",
            );
        }
        for (place, event) in self.events.iter().enumerate() {
            if self.events[..place].iter().any(|other| other.name == event.name) {
                return fail("event", &format!("two events are called `{}`", event.name));
            }
        }
        if let Some(Sample { kind, count, .. }) = self.sample
            && kind == SampleKind::Sobol
            && (count > MOST_SOBOL_POINTS || self.vary.len() > 256)
        {
            return fail(
                "sample",
                &format!(
                    "Sobol's sequence has at most {MOST_SOBOL_POINTS} points of 256 quantities here; a latin-hypercube may have more"
                ),
            );
        }
        Ok(())
    }
}

/// The method.
fn method(plan: &mut Section) -> Result<Method, SweepError> {
    let (order, tolerance) = (plan.count("order")?, plan.number("tolerance")?);
    match (order, tolerance) {
        (Some(_), Some(_)) => fail("order", "`order` and `tolerance` are two methods: give one"),
        (None, Some(tolerance)) if tolerance > 0.0 => Ok(Method::Tolerance(tolerance)),
        (None, Some(_)) => fail("tolerance", "a tolerance is positive"),
        (None | Some(2), None) => Ok(Method::Step),
        (Some(order), None) => match u32::try_from(order).ok().and_then(Composition::of_order) {
            Some(composition) => Ok(Method::Composed(composition)),
            None => fail("order", "the step has order 2, its compositions 4, 6 and 8"),
        },
    }
}

/// The values of a quantity that varies.
fn values(at: &str, value: Value) -> Result<Values, SweepError> {
    match value {
        Value::Array(list) => Ok(Values::List(
            list.iter()
                .map(|value| number(at, value))
                .collect::<Result<_, _>>()?,
        )),
        Value::Table(table) => {
            let mut range = Section::new(at, table);
            let end = |value: Option<f64>, name: &str| match value {
                Some(value) => Ok(value),
                None => fail(at, &format!("`{name}` is missing")),
            };
            let values = Values::Range {
                from: end(range.number("from")?, "from")?,
                to: end(range.number("to")?, "to")?,
                count: range.count("count")?,
                logarithmic: range.choice("scale", &[("linear", false), ("logarithmic", true)])?
                    == Some(true),
            };
            range.finish()?;
            Ok(values)
        }
        other => wrong(
            at,
            "a list, or a table as in { from = 0, to = 1, count = 11 }",
            &other,
        ),
    }
}

/// The random points.
fn sample(plan: &mut Section) -> Result<Option<Sample>, SweepError> {
    let Some(mut section) = plan.optional_section("sample")? else {
        return Ok(None);
    };
    let kinds = [
        ("latin-hypercube", SampleKind::LatinHypercube),
        ("sobol", SampleKind::Sobol),
        ("random", SampleKind::Random),
    ];
    let Some(kind) = section.choice("kind", &kinds)? else {
        return fail("sample", "`kind` is missing: latin-hypercube, sobol or random");
    };
    let Some(count) = section.count("count")? else {
        return fail("sample", "`count` is missing");
    };
    let seed = section.whole("seed", 0)?.unwrap_or(0);
    section.finish()?;
    Ok(Some(Sample { kind, count, seed }))
}

/// The times and values of an input.
fn held(at: &str, value: Value) -> Result<Vec<[f64; 2]>, SweepError> {
    let Value::Array(rows) = value else {
        return wrong(
            at,
            "pairs of a time and a value, as in [[0, 1.0], [2, -1.0]]",
            &value,
        );
    };
    let mut held: Vec<[f64; 2]> = Vec::new();
    for row in &rows {
        let pair = match row {
            Value::Array(pair) => match &pair[..] {
                [time, value] => [number(at, time)?, number(at, value)?],
                _ => return wrong(at, "a time and a value", row),
            },
            _ => return wrong(at, "a time and a value", row),
        };
        if held.last().is_some_and(|before| before[0] >= pair[0]) {
            return fail(at, "times ascend");
        }
        held.push(pair);
    }
    Ok(held)
}

/// The events.
fn events(plan: &mut Section) -> Result<Vec<PlannedEvent>, SweepError> {
    let list = match plan.take("event") {
        None => return Ok(Vec::new()),
        Some(Value::Array(list)) => list,
        Some(other) => return wrong("event", "tables [[event]]", &other),
    };
    let mut events = Vec::new();
    for value in list {
        let Value::Table(table) = value else {
            return wrong("event", "a table [[event]]", &value);
        };
        let mut section = Section::new("event", table);
        let Some(quantity) = section.text("quantity")? else {
            return fail("event", "`quantity` is missing");
        };
        events.push(PlannedEvent {
            name: section.text("name")?.unwrap_or_else(|| quantity.clone()),
            quantity,
            value: section.number("value")?.unwrap_or(0.0),
            rising: section
                .choice(
                    "direction",
                    &[("rising", Some(true)), ("falling", Some(false)), ("both", None)],
                )?
                .flatten(),
            ends: section.flag("ends")?,
        });
        section.finish()?;
    }
    Ok(events)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plan_says_what_it_says() {
        let plan = Plan::read(
            r#"
            system = "pendulum"
            until = 50
            order = 4
            [start]
            v0 = [0, "pi/2"]
            [vary]
            theta = { from = "-pi", to = "pi", count = 5 }
            rho = [1, 2.5]
            [keep]
            end = ["theta"]
            nodes = { every = 10 }
            [[event]]
            quantity = "theta"
            direction = "falling"
            "#,
        )
        .unwrap();
        assert_eq!(plan.method, Method::Composed(Composition::of_order(4).unwrap()));
        assert_eq!(plan.start.v0, Some(vec![0.0, std::f64::consts::FRAC_PI_2]));
        // in the order of the plan: the first varies slowest
        assert_eq!(plan.vary[0].0, "theta");
        assert_eq!(plan.vary[1], ("rho".to_owned(), Values::List(vec![1.0, 2.5])));
        assert_eq!(plan.events[0].rising, Some(false));
        assert_eq!(plan.events[0].name, "theta");
    }

    #[test]
    fn what_is_wrong_is_told_with_its_place() {
        let vary = "[vary]\nx = [1]\n";
        for (text, expected) in [
            ("until = 1", "vary: nothing varies"),
            (
                "untill = 1\n[vary]\nx = [1]",
                "no key `untill` (did you mean `until`?)",
            ),
            (
                "[vary]\nx = { from = 0, to = 1 }",
                "vary.x: a grid needs a `count`",
            ),
            (
                "[vary]\nx = { from = 0, too = 1, count = 2 }",
                "vary.x: `to` is missing",
            ),
            (
                "[vary]\nx = { from = 0, to = 1, count = 2, scale = \"log\" }",
                "did you mean `logarithmic`?",
            ),
            (
                "[vary]\nx = { from = 0, to = 1, count = 2, scale = \"logarithmic\" }",
                "none is zero",
            ),
            (
                "[vary]\nx = { from = \"1/0\", to = 1, count = 2 }",
                "inf is not finite",
            ),
            (
                "[vary]\nx = { from = 0, to = 1, count = 0 }",
                "vary.x.count: expected a whole number, at least 1, found 0",
            ),
            ("order = 3\n[vary]\nx = [1]", "order: the step has order 2"),
            ("order = 4\ntolerance = 1e-9\n[vary]\nx = [1]", "are two methods"),
            (
                "[input]\nx = [[1, 0], [1, 2]]\n[vary]\nx = [1]",
                "input.x: times ascend",
            ),
            (
                "[sample]\nkind = \"sobel\"\ncount = 3\n[vary]\nx = [1]",
                "did you mean `sobol`?",
            ),
            (
                "[sample]\nkind = \"sobol\"\ncount = 70000\n[vary]\nx = [1]",
                "at most 65536 points",
            ),
            ("[vary\nx = [1]", "TOML parse error at line 1"),
        ] {
            let error = Plan::read(text).unwrap_err().to_string();
            assert!(error.contains(expected), "{text}: {error}");
        }
        assert!(Plan::read(vary).is_ok());
    }
}
