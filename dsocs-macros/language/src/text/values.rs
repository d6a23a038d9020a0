//! The numbers of a text: the values of parameters, and the settings of its runs.

use std::collections::HashSet;

use proc_macro2::{Group, Ident};
use syn::{Expr, Lit};

use super::items::{self, Item};
use super::parameters::{Parameter, Value};
use crate::check::names::SETTINGS_OF_RUN;
use crate::graph::{NodeId, Param};
use crate::lower::{Lowering, circle_constant};
use crate::mistakes::errors::{Errors, Reported};
use crate::mistakes::nearest::did_you_mean;
use crate::model::Model;
use crate::parse::entries;
use crate::syntax::ast::{Declaration, Entry};
use crate::syntax::bare;
use crate::syntax::input::Fields;
use crate::syntax::input::ParameterField;

/// A `run { … }` block.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Run {
    /// Its name, if it has one.
    pub name: Option<String>,
    /// Position and velocity at the start.
    pub start: Option<[Vec<f64>; 2]>,
    /// The acceleration at the start, where a constraint is of third order.
    pub acceleration: Option<Vec<f64>>,
    /// The initial acceleration near which one is searched for, if there are several.
    pub near_acceleration: Option<Vec<f64>>,
    /// The step.
    pub step: Option<f64>,
    /// The time at which it ends.
    pub until: Option<f64>,
    /// Whether the start is projected onto the constraints on positions and velocities.
    pub project: bool,
}

/// Names of the settings in other languages, and what to write instead.
const ELSEWHERE: [(&str, &str); 18] = [
    ("q0", "`start = ([…], […])`, position and velocity"),
    ("x0", "`start = ([…], […])`, position and velocity"),
    ("v0", "`start = ([…], […])`, position and velocity"),
    ("initial", "`start = ([…], […])`, position and velocity"),
    ("position", "`start = ([…], […])`, position and velocity"),
    ("velocity", "`start = ([…], […])`, position and velocity"),
    ("a0", "`acceleration = […]`"),
    ("h", "`step = …`"),
    ("dt", "`step = …`"),
    ("timestep", "`step = …`"),
    ("time_step", "`step = …`"),
    ("tend", "`until = …`"),
    ("t_end", "`until = …`"),
    ("tmax", "`until = …`"),
    ("end", "`until = …`"),
    ("time", "`until = …`"),
    ("duration", "`until = …`"),
    ("stop", "`until = …`"),
];

/// The evaluation of expressions of parameters.
struct Evaluation<'d> {
    lowering: Lowering<'d>,
    errors: &'d Errors,
    /// The values of the parameters known so far.
    values: Vec<f64>,
}

impl<'d> Evaluation<'d> {
    fn new(nothing: &Declaration, fields: &'d Fields, values: Vec<f64>, errors: &'d Errors) -> Self {
        let mut lowering = Lowering::new(nothing, &[], &[], fields, errors);
        let numbers = fields.parameters();
        lowering
            .graph
            .set_numbers(numbers.iter().map(ParameterField::read));
        Self {
            lowering,
            errors,
            values,
        }
    }

    /// The values of the nodes of some expressions.
    fn evaluate(&mut self, exprs: &[&Expr], nodes: &[NodeId]) -> Vec<f64> {
        let mut numbers = self.numbers(nodes);
        for (number, expr) in numbers.iter_mut().zip(exprs) {
            // the graph has no negative zero, but a literal `-0` asks for one
            if *number == 0.0
                && matches!(bare(expr), Expr::Unary(unary) if matches!(bare(&unary.expr), Expr::Lit(_)))
            {
                *number = -0.0;
            }
        }
        numbers
    }

    /// The values of nodes.
    fn numbers(&self, nodes: &[NodeId]) -> Vec<f64> {
        let graph = &self.lowering.graph;
        let param = |which| match graph.read_param(which) {
            Param::Number(place) => self.values.get(place).copied().unwrap_or(f64::NAN),
            Param::Expression(tokens) => circle_constant(&tokens.to_string()).unwrap_or(f64::NAN),
        };
        graph
            .values(nodes, &|_| f64::NAN, &param)
            .unwrap_or_else(|| vec![f64::NAN; nodes.len()])
    }

    /// The value of an expression that has to be a finite number.
    fn number(&mut self, expr: &Expr) -> Result<f64, Reported> {
        let node = self.lowering.expr(expr)?;
        let [value] = self.evaluate(&[expr], &[node])[..] else {
            return Ok(f64::NAN);
        };
        self.check_finite(expr, value)
    }

    /// A number, refused if it is not finite.
    fn check_finite(&self, expr: &Expr, value: f64) -> Result<f64, Reported> {
        if value.is_finite() {
            return Ok(value);
        }
        let message =
            "this has no finite value; expected numbers, and parameters whose values are given before";
        Err(self.errors.at(expr, message))
    }

    /// The numbers of a vector, `[1.0, 0.5]`, `[0.0; 3]` or `[each(0..3, |i| 1 + 0.01 * i)]`.
    fn vector(&mut self, expr: &Expr) -> Result<Vec<f64>, Reported> {
        let entries: Vec<Entry> = match bare(expr) {
            Expr::Array(array) => entries(array.elems.iter().cloned(), self.errors)?,
            Expr::Repeat(repeat) => {
                let count = match bare(&repeat.len) {
                    Expr::Lit(literal) => match &literal.lit {
                        Lit::Int(count) => count.base10_parse::<usize>().ok(),
                        _ => None,
                    },
                    _ => None,
                };
                let count = count.filter(|&count| count <= 10_000).ok_or_else(|| {
                    let message = "expected a whole number of at most 10000";
                    self.errors.at(&repeat.len, message)
                })?;
                entries(std::iter::repeat_n((*repeat.expr).clone(), count), self.errors)?
            }
            other => {
                let message = "expected numbers in brackets, one for each coordinate, such as `[1.0, 0.0]`";
                return Err(self.errors.at(other, message));
            }
        };
        let nodes = self.lowering.each_entry(&entries, Lowering::expr)?;
        let exprs: Vec<&Expr> = entries.iter().map(|entry| &entry.value).collect();
        let numbers = self.evaluate(&exprs, &nodes);
        for (entry, value) in entries.iter().zip(&numbers) {
            self.check_finite(&entry.value, *value)?;
        }
        Ok(numbers)
    }
}

/// The values of all numbers among the parameters.
pub(super) fn parameters(
    parameters: &[Parameter],
    fields: &Fields,
    errors: &Errors,
) -> Result<Vec<f64>, Reported> {
    let all = fields.parameters();
    let nothing = Declaration::default();
    let mut evaluation = Evaluation::new(&nothing, fields, Vec::new(), errors);
    let mut wrong = Ok(());
    for parameter in parameters {
        let expressions: Vec<&Expr> = match &parameter.value {
            Value::Number(value) => vec![value],
            Value::Array(values) => values.iter().collect(),
            Value::Matrix(rows) => rows.iter().flatten().collect(),
            Value::Table(..) => continue,
            Value::Malformed(reported) => {
                wrong = Err(*reported);
                continue;
            }
        };
        for expr in expressions {
            let known = &all[..evaluation.values.len().min(all.len())];
            let value =
                refuse_later_parameters(known, &all, expr, errors).and_then(|()| evaluation.number(expr));
            if let Err(reported) = value {
                wrong = Err(reported);
            }
            evaluation.values.push(value.unwrap_or(f64::NAN));
        }
    }
    wrong.map(|()| evaluation.values)
}

/// Refuses a value that uses parameters whose values are given later.
fn refuse_later_parameters(
    known: &[ParameterField],
    all: &[ParameterField],
    expr: &Expr,
    errors: &Errors,
) -> Result<(), Reported> {
    struct Names(Vec<Ident>);
    impl<'ast> syn::visit::Visit<'ast> for Names {
        fn visit_expr_path(&mut self, path: &'ast syn::ExprPath) {
            self.0.extend(path.path.get_ident().cloned());
        }
    }
    let mut names = Names(Vec::new());
    syn::visit::Visit::visit_expr(&mut names, expr);
    let is_of = |fields: &[ParameterField], name: &Ident| fields.iter().any(|field| field.ident == *name);
    for name in names.0 {
        if is_of(all, &name) && !is_of(known, &name) {
            let message =
                format!("the value of `{name}` is given here or further down; expected it before this use");
            return Err(errors.at(&name, message));
        }
    }
    Ok(())
}

/// Reads the runs.
pub(super) fn runs(
    runs: Vec<(Ident, Option<Ident>, Group)>,
    model: &Model,
    fields: &Fields,
    values: &[f64],
    errors: &Errors,
) -> Result<Vec<Run>, Reported> {
    let nothing = Declaration::default();
    let mut evaluation = Evaluation::new(&nothing, fields, values.to_vec(), errors);
    let mut names = HashSet::new();
    let mut all = Vec::new();
    let mut wrong = Ok(());
    for (word, name, group) in runs {
        let text = name.as_ref().map(ToString::to_string);
        if !names.insert(text.clone()) {
            let reported = match &name {
                Some(name) => errors.at(name, format!("a run is called `{name}` already")),
                None => errors.at(&word, "a second run needs a name, `run fast { … }`"),
            };
            wrong = Err(reported);
        }
        match run(text, &group, model, &mut evaluation) {
            Ok(run) => all.push(run),
            Err(reported) => wrong = Err(reported),
        }
    }
    wrong.map(|()| all)
}

/// Reads one run.
fn run(
    name: Option<String>,
    group: &Group,
    model: &Model,
    evaluation: &mut Evaluation<'_>,
) -> Result<Run, Reported> {
    let errors = evaluation.errors;
    let settings = items::read(group, [';', ','], errors);
    let n = model.coordinates.len();
    let mut run = Run {
        name,
        start: None,
        acceleration: None,
        near_acceleration: None,
        step: None,
        until: None,
        project: false,
    };
    let mut seen = HashSet::new();
    let mut wrong = Ok(());
    for Item {
        name: key,
        length,
        value,
        ..
    } in settings
    {
        let text = key.to_string();
        let result = if let Some(length) = length {
            length.and_then(|length| Err(errors.at(length, format!("expected `{text} = …`, without `:`"))))
        } else if seen.insert(text.clone()) {
            value.and_then(|value| {
                apply_setting(
                    &mut run,
                    (&text, &key),
                    &value,
                    (n, model.graph.rotations()),
                    evaluation,
                )
            })
        } else {
            Err(errors.at(&key, format!("`{text}` is given a second time here")))
        };
        wrong = wrong.and(result);
    }
    wrong?;
    // without a step of its own the run goes forward in time
    if run
        .until
        .is_some_and(|until| until * run.step.unwrap_or(1.0) < 0.0)
    {
        let message = "this run ends before it begins, at t = 0; expected an `until` of the sign of the `step`, which is negative to run back in time";
        return Err(errors.at(group.stream(), message));
    }
    Ok(run)
}

/// Whether an array has two whole numbers with a comma and no blank between them, as in `1,5`.
fn has_decimal_comma(expr: &Expr) -> bool {
    let Expr::Array(array) = bare(expr) else {
        return false;
    };
    let place = |expr: &Expr| match bare(expr) {
        Expr::Lit(literal) => Some((literal.lit.span().start(), literal.lit.span().end())),
        _ => None,
    };
    let numbers: Vec<_> = array.elems.iter().map(place).collect();
    numbers.windows(2).any(|pair| match pair {
        [Some((_, end)), Some((start, _))] => end.line == start.line && end.column + 1 == start.column,
        _ => false,
    })
}

/// Sets one setting of a run.
fn apply_setting(
    run: &mut Run,
    (text, key): (&str, &Ident),
    value: &Expr,
    (n, rotations): (usize, &[usize]),
    evaluation: &mut Evaluation<'_>,
) -> Result<(), Reported> {
    let errors = evaluation.errors;
    let mut vector = |expr: &Expr, is_position: bool| {
        let mut numbers = evaluation.vector(expr)?;
        if numbers.len() == n {
            return Ok(numbers);
        }
        // a rotation has three numbers, in the frame of the body; its first slot is zero
        if !is_position && numbers.len() + rotations.len() == n {
            for &first in rotations {
                numbers.insert(first, 0.0);
            }
            return Ok(numbers);
        }
        let commas = if has_decimal_comma(expr) {
            "; a decimal has a point"
        } else {
            ""
        };
        let found = numbers.len();
        let message = match (rotations, is_position) {
            ([], _) => format!("expected a number for each coordinate, {n}, found {found}{commas}"),
            (_, true) => format!(
                "expected a number for each coordinate, four for a rotation, `w, x, y, z`: {n}, found {found}{commas}"
            ),
            (_, false) => format!(
                "expected a number for each coordinate, three for a rotation, in the frame of its body: {}, found {found}{commas}",
                n - rotations.len()
            ),
        };
        Err(errors.at(expr, message))
    };
    match text {
        "start" => {
            let parts: Vec<&Expr> = match bare(value) {
                Expr::Tuple(tuple) => tuple.elems.iter().collect(),
                _ => Vec::new(),
            };
            let [q0, v0] = parts[..] else {
                let message = "expected position and velocity, `start = ([1.0, 0.0], [0.0, 0.5]);`";
                return Err(errors.at(value, message));
            };
            let (q0, v0) = (vector(q0, true), vector(v0, false));
            run.start = Some([q0?, v0?]);
        }
        "acceleration" => run.acceleration = Some(vector(value, false)?),
        "near_acceleration" => run.near_acceleration = Some(vector(value, false)?),
        "step" => {
            let step = evaluation.number(value)?;
            if step == 0.0 {
                return Err(errors.at(value, "expected a step that is not zero"));
            }
            run.step = Some(step);
        }
        "project" => match bare(value) {
            Expr::Lit(literal) if matches!(literal.lit, Lit::Bool(_)) => {
                run.project = matches!(&literal.lit, Lit::Bool(yes) if yes.value);
            }
            other => return Err(errors.at(other, "expected `true` or `false`")),
        },
        "until" => run.until = Some(evaluation.number(value)?),
        _ => {
            let meant = ELSEWHERE.iter().find(|(word, _)| *word == text);
            let hint = match meant {
                Some((_, meant)) => format!("; expected {meant}"),
                None => did_you_mean(text, SETTINGS_OF_RUN),
            };
            let message = format!(
                "a run has no `{text}`{hint}; it has {}",
                SETTINGS_OF_RUN.map(|key| format!("`{key}`")).join(", ")
            );
            return Err(errors.at(key, message));
        }
    }
    Ok(())
}
