//! The options for the start of a motion and for the parameters.

use clap::{Args, ValueEnum};
use dsocs_core::{AnyFlow, OwnedNode};

use crate::check::Begin;
use crate::cli::CliError;
use crate::cli::arguments::expression;
use crate::entry::{Beginning, Entry, RunFailure, UnknownName};

/// Where a motion begins, and the parameters.
#[derive(Args, Clone, Debug)]
pub struct StartArguments {
    /// The first node, a number for each coordinate (of a rotation four, a unit quaternion w,x,y,z), or those by name that differ from the system's own start (`theta=30deg`); numbers may be written like `pi/2`, `sqrt(2)` or `30deg`, as in all options
    #[arg(long, value_name = "A,B", allow_hyphen_values = true, value_delimiter = ',', value_parser = component)]
    q0: Option<Vec<Component>>,
    /// The initial velocity, a number for each coordinate (of a rotation three, in the frame of its body)
    #[arg(long, value_name = "C,D", allow_hyphen_values = true, value_delimiter = ',', value_parser = component)]
    v0: Option<Vec<Component>>,
    /// The initial acceleration, a number for each coordinate, if a constraint is of third order
    #[arg(long, value_name = "E,F", allow_hyphen_values = true, value_delimiter = ',', value_parser = component)]
    a0: Option<Vec<Component>>,
    /// The initial constraint force, a number for each coordinate, in place of the initial acceleration
    #[arg(
        long,
        value_name = "G,H",
        allow_hyphen_values = true,
        value_delimiter = ',',
        value_parser = component,
        conflicts_with = "a0"
    )]
    f0: Option<Vec<Component>>,
    /// The initial acceleration where the equations have several solutions: the one nearest to this, a number for each coordinate
    #[arg(
        long,
        value_name = "E,F",
        allow_hyphen_values = true,
        value_delimiter = ',',
        value_parser = component,
        conflicts_with_all = ["a0", "f0"]
    )]
    near_a0: Option<Vec<Component>>,
    /// The time at which the motion begins, in s
    #[arg(long, value_name = "T", allow_hyphen_values = true, default_value = "0", value_parser = expression::number)]
    t0: f64,
    /// A parameter's value; may be given several times
    #[arg(long, value_name = "NAME=VALUE", allow_hyphen_values = true, value_parser = assignment)]
    set: Vec<(String, f64)>,
}

/// A component of a vector: a number in the order of the coordinates, or one by the name of its coordinate.
#[derive(Clone, Debug)]
pub struct Component {
    /// The name, if it is given.
    name: Option<String>,
    /// The value.
    value: f64,
}

/// Reads `value` or `name=value`.
pub fn component(text: &str) -> Result<Component, String> {
    let (name, value) = match text.split_once('=') {
        Some((name, value)) => (Some(name.trim().to_owned()), value),
        None => (None, text),
    };
    let value = expression::number(value)?;
    Ok(Component { name, value })
}

/// The vector that an option gives. Coordinates that it does not name have the values of `own`.
///
/// # Errors
///
/// [`CliError`] if there is no such coordinate, one is named twice or not at all, or some have names and others have not.
pub fn vector(
    option: &'static str,
    given: Option<&[Component]>,
    own: Option<&[f64]>,
    entry: &Entry,
) -> Result<Option<Vec<f64>>, CliError> {
    let Some(given) = given else {
        return Ok(own.map(<[f64]>::to_vec));
    };
    let refused = |reason: String| CliError::Components { option, reason };
    let named = given.iter().filter(|component| component.name.is_some()).count();
    if named == 0 {
        let mut numbers: Vec<f64> = given.iter().map(|component| component.value).collect();
        let shape = entry.kernel().shape();
        // a rotation has three numbers, in the frame of its body
        if !is_position(option) && numbers.len() + shape.rotations.len() == shape.dimension() {
            for &first in shape.rotations.iter() {
                numbers.insert(first, 0.0);
            }
        }
        return Ok(Some(numbers));
    }
    if named < given.len() {
        return Err(refused(
            "some numbers have the names of coordinates and others have not".to_owned(),
        ));
    }
    let names: Vec<&str> = entry.description().names().collect();
    let mut values: Vec<Option<f64>> = vec![None; names.len()];
    for Component { name, value } in given {
        let name = name.as_deref().unwrap_or_default();
        let Some(place) = names.iter().position(|known| *known == name) else {
            return Err(UnknownName::new("coordinate", name, names).into());
        };
        if values[place].replace(*value).is_some() {
            return Err(refused(format!("the coordinate `{name}` is given twice")));
        }
    }
    for &first in &entry.description().rotations {
        let given = values.get(first..first + 4).unwrap_or(&[]);
        if !is_position(option) {
            values[first] = values[first].or(Some(0.0));
        } else if given.iter().any(Option::is_some) && !given.iter().all(Option::is_some) {
            let of = &names[first..first + 4];
            return Err(refused(format!(
                "{} are one unit quaternion, the scalar first, and {} alone would leave another norm than 1: give all four, such as `{option} \
                 {}=0.8,{}=0,{}=0.6,{}=0`",
                of.join(", "),
                named_of(of, given),
                of[0],
                of[1],
                of[2],
                of[3],
            )));
        }
    }
    let own = own.filter(|own| own.len() == names.len());
    let parts = values
        .iter()
        .zip(&names)
        .enumerate()
        .map(|(place, (value, name))| {
            value.or_else(|| own.map(|own| own[place])).ok_or_else(|| {
                refused(format!(
                    "the coordinate `{name}` has no value, and the system has none of its own for it"
                ))
            })
        });
    parts.collect::<Result<_, _>>().map(Some)
}

/// Whether an option gives a position, in which a rotation has four numbers; elsewhere it has three.
fn is_position(option: &str) -> bool {
    matches!(option, "--q0" | "--q1" | "--guess")
}

/// The names of the components that are given.
fn named_of(names: &[&str], given: &[Option<f64>]) -> String {
    let named = names.iter().zip(given).filter(|(_, given)| given.is_some());
    let named: Vec<_> = named.map(|(name, _)| *name).collect();
    named.join(" and ")
}

/// The rule for the second node, and the projection of the start onto constraints.
#[derive(Args, Clone, Debug)]
pub struct BeginArguments {
    /// The rule that gives the second node from position and velocity [default: second-order]
    #[arg(long, value_enum)]
    pub start: Option<StartOption>,
    /// Move the start onto the constraints on positions and velocities, by the smallest change to first order. Without this option a start that violates
    /// them is refused
    #[arg(long)]
    pub project: bool,
}

/// The rule that gives the second node from position and velocity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum StartOption {
    /// q1 = q0 + h v0
    Paper,
    /// q1 = q0 + h v0 + h²/2 a0
    SecondOrder,
}

impl BeginArguments {
    /// The start in the form that a check takes.
    pub fn begin(&self, entry: &Entry) -> Begin {
        Begin {
            paper: self.start == Some(StartOption::Paper),
            projected: self.project || entry.projects(),
        }
    }
}

/// Reads `name=value`.
pub fn assignment(text: &str) -> Result<(String, f64), String> {
    let (name, value) = text.split_once('=').ok_or("expected NAME=VALUE")?;
    Ok((name.trim().to_owned(), expression::number(value)?))
}

impl StartArguments {
    /// Gives the parameters their values.
    ///
    /// # Errors
    ///
    /// [`CliError`] if there is no such parameter or a value is not finite.
    pub fn set(&self, entry: &mut Entry) -> Result<(), CliError> {
        for (name, value) in &self.set {
            entry.set(name, *value)?;
            if !value.is_finite() {
                return Err(CliError::Parameter {
                    name: name.clone(),
                    value: *value,
                });
            }
        }
        Ok(())
    }

    /// The first node.
    ///
    /// # Errors
    ///
    /// [`CliError::NoStart`] if neither the options nor the entry have one, and the errors of [`vector`].
    pub fn q0(&self, entry: &Entry) -> Result<Vec<f64>, CliError> {
        let own = entry.default_start().map(|[q0, _]| q0.as_slice());
        vector("--q0", self.q0.as_deref(), own, entry)?.ok_or_else(|| self.missing(entry))
    }

    /// Whether the options give a position and no velocity.
    pub fn gives_only_position(&self) -> bool {
        self.q0.is_some() && self.v0.is_none()
    }

    /// The initial velocity.
    ///
    /// # Errors
    ///
    /// As [`StartArguments::q0`].
    pub fn v0(&self, entry: &Entry) -> Result<Vec<f64>, CliError> {
        let own = entry.default_start().map(|[_, v0]| v0.as_slice());
        vector("--v0", self.v0.as_deref(), own, entry)?.ok_or_else(|| self.missing(entry))
    }

    /// The initial acceleration, if the options or the entry have one.
    ///
    /// # Errors
    ///
    /// Those of [`vector`].
    pub fn a0(&self, entry: &Entry) -> Result<Option<Vec<f64>>, CliError> {
        vector("--a0", self.a0.as_deref(), entry.default_acceleration(), entry)
    }

    /// The acceleration near which a solution is looked for, where there are several, if the options or the
    /// entry have one.
    ///
    /// # Errors
    ///
    /// Those of [`vector`].
    pub fn near(&self, entry: &Entry) -> Result<Option<Vec<f64>>, CliError> {
        vector("--near-a0", self.near_a0.as_deref(), entry.default_near(), entry)
    }

    /// The beginning at `q0` with an acceleration or a force, if the options or the entry have one.
    ///
    /// # Errors
    ///
    /// [`CliError::NoStart`] if there is no velocity, and the errors of [`vector`].
    pub fn third_order(&self, entry: &Entry, q0: &[f64]) -> Result<Option<Beginning>, CliError> {
        let q0 = q0.to_vec();
        if let Some(force) = vector("--f0", self.f0.as_deref(), None, entry)? {
            let v0 = self.v0(entry)?;
            return Ok(Some(Beginning::ThirdOrderByForce { q0, v0, force }));
        }
        let Some(a0) = self.a0(entry)? else {
            return Ok(None);
        };
        let v0 = self.v0(entry)?;
        Ok(Some(Beginning::ThirdOrder { q0, v0, a0 }))
    }

    /// The initial acceleration: the one given, the one that belongs to a given constraint force, or the one
    /// near which a solution is looked for.
    ///
    /// # Errors
    ///
    /// Those of [`StartArguments::third_order`]; [`CliError`] if no acceleration belongs to the force.
    pub fn acceleration(&self, entry: &Entry, h: f64) -> Result<Option<Vec<f64>>, CliError> {
        match self.third_order(entry, &self.q0(entry)?)? {
            Some(Beginning::ThirdOrder { a0, .. }) => Ok(Some(a0)),
            Some(by_force) => {
                let start = Beginning::At(self.t0, Box::new(by_force)).start();
                let flow = AnyFlow::new(entry.kernel(), h, &start).map_err(RunFailure::Setup)?;
                let mut node = OwnedNode::new(entry.kernel().shape().dimension());
                flow.run().write_node(node.as_node_mut());
                Ok(Some(node.any().a.to_vec()))
            }
            None => self.near(entry),
        }
    }

    /// The time at which the motion begins.
    pub fn t0(&self) -> f64 {
        self.t0
    }

    /// Refuses options that apply to one system only.
    ///
    /// # Errors
    ///
    /// [`CliError::OneSystem`].
    pub fn for_systems(&self, count: usize) -> Result<(), CliError> {
        let given = [
            ("--q0", self.q0.is_some()),
            ("--v0", self.v0.is_some()),
            ("--a0", self.a0.is_some()),
            ("--f0", self.f0.is_some()),
            ("--near-a0", self.near_a0.is_some()),
            ("--set", !self.set.is_empty()),
        ];
        match given.into_iter().find(|&(_, given)| given) {
            Some((option, _)) if count > 1 => Err(CliError::OneSystem { option }),
            _ => Ok(()),
        }
    }

    /// The error for a missing start.
    fn missing(&self, entry: &Entry) -> CliError {
        let options = [("--q0", self.q0.is_none()), ("--v0", self.v0.is_none())];
        let options = options.into_iter().filter(|&(_, missing)| missing);
        CliError::NoStart {
            system: entry.name().to_owned(),
            options: options.map(|(option, _)| option).collect(),
            coordinates: entry.description().names().map(str::to_owned).collect(),
            rotations: entry.description().rotations.len(),
            in_text: match entry.source_text() {
                Some(_) => "; or in the text, `run { start = ([…], […]); }`, position and velocity",
                None => "",
            },
        }
    }
}
