//! The options that say where a motion begins and what the parameters are.

use clap::{Args, ValueEnum};

use super::CliError;
use super::expression;
use crate::check::Begin;
use crate::entry::{Beginning, Entry};

/// Where a motion begins, and the parameters.
#[derive(Args, Debug)]
pub struct StartArguments {
    /// The first node, a number for each coordinate; numbers may be written like `pi/2` or `sqrt(2)`, as in all options
    #[arg(long, value_name = "A,B", allow_hyphen_values = true, value_delimiter = ',', value_parser = expression::number)]
    q0: Option<Vec<f64>>,
    /// The initial velocity, a number for each coordinate
    #[arg(long, value_name = "C,D", allow_hyphen_values = true, value_delimiter = ',', value_parser = expression::number)]
    v0: Option<Vec<f64>>,
    /// The initial acceleration, a number for each coordinate, if a constraint is of third order
    #[arg(long, value_name = "E,F", allow_hyphen_values = true, value_delimiter = ',', value_parser = expression::number)]
    a0: Option<Vec<f64>>,
    /// The initial constraint force, a number for each coordinate, in place of the initial acceleration
    #[arg(
        long,
        value_name = "G,H",
        allow_hyphen_values = true,
        value_delimiter = ',',
        value_parser = expression::number,
        conflicts_with = "a0"
    )]
    f0: Option<Vec<f64>>,
    /// Which initial acceleration is meant where the equations allow several: the solution nearest to this one, a number for each coordinate
    #[arg(
        long,
        value_name = "E,F",
        allow_hyphen_values = true,
        value_delimiter = ',',
        value_parser = expression::number,
        conflicts_with_all = ["a0", "f0"]
    )]
    near_a0: Option<Vec<f64>>,
    /// The time at which the motion begins, in s
    #[arg(long, value_name = "T", allow_hyphen_values = true, default_value = "0", value_parser = expression::number)]
    t0: f64,
    /// A parameter's value; may be given several times
    #[arg(long, value_name = "NAME=VALUE", allow_hyphen_values = true, value_parser = assignment)]
    set: Vec<(String, f64)>,
}

/// How a motion begins with its position and velocity.
#[derive(Args, Debug)]
pub struct BeginArguments {
    /// How the second node follows from position and velocity [default: second-order]
    #[arg(long, value_enum)]
    pub start: Option<StartOption>,
    /// Move the start onto the constraints on positions and velocities, by the smallest change. Without this option a start that violates
    /// them is refused
    #[arg(long)]
    pub project: bool,
}

/// How the second node follows from position and velocity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum StartOption {
    /// q1 = q0 + h v0
    Paper,
    /// q1 = q0 + h v0 + h²/2 a0
    SecondOrder,
}

impl BeginArguments {
    /// As a check takes it.
    pub fn begin(&self) -> Begin {
        Begin {
            paper: self.start == Some(StartOption::Paper),
            projected: self.project,
        }
    }
}

/// Reads `name=value`.
fn assignment(text: &str) -> Result<(String, f64), String> {
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
    /// [`CliError::NoStart`] if neither the options nor the entry have one.
    pub fn q0(&self, entry: &Entry) -> Result<Vec<f64>, CliError> {
        let given = self.q0.as_ref().or(entry.default_start().map(|[q0, _]| q0));
        given.cloned().ok_or_else(|| self.missing(entry))
    }

    /// The initial velocity.
    ///
    /// # Errors
    ///
    /// [`CliError::NoStart`] if neither the options nor the entry have one.
    pub fn v0(&self, entry: &Entry) -> Result<Vec<f64>, CliError> {
        let given = self.v0.as_ref().or(entry.default_start().map(|[_, v0]| v0));
        given.cloned().ok_or_else(|| self.missing(entry))
    }

    /// The initial acceleration, if the options or the entry have one.
    pub fn a0(&self, entry: &Entry) -> Option<Vec<f64>> {
        let given = self.a0.as_deref().or(entry.default_acceleration());
        given.map(<[f64]>::to_vec)
    }

    /// The acceleration that is meant where there are several, if the options or the entry say it.
    pub fn near(&self, entry: &Entry) -> Option<Vec<f64>> {
        let given = self.near_a0.as_deref().or(entry.default_near());
        given.map(<[f64]>::to_vec)
    }

    /// The beginning at `q0` with an acceleration or a force, if the options or the entry have one.
    ///
    /// # Errors
    ///
    /// [`CliError::NoStart`] if there is no velocity.
    pub fn third_order(&self, entry: &Entry, q0: &[f64]) -> Result<Option<Beginning>, CliError> {
        let q0 = q0.to_vec();
        if let Some(force) = self.f0.clone() {
            let v0 = self.v0(entry)?;
            return Ok(Some(Beginning::ThirdOrderByForce { q0, v0, force }));
        }
        let Some(a0) = self.a0(entry) else {
            return Ok(None);
        };
        let v0 = self.v0(entry)?;
        Ok(Some(Beginning::ThirdOrder { q0, v0, a0 }))
    }

    /// The time at which the motion begins.
    pub fn t0(&self) -> f64 {
        self.t0
    }

    /// Refuses options that can be meant for one system alone.
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

    /// What is to be said where there is no start.
    fn missing(&self, entry: &Entry) -> CliError {
        let options = [("--q0", self.q0.is_none()), ("--v0", self.v0.is_none())];
        let options = options.into_iter().filter(|&(_, missing)| missing);
        CliError::NoStart {
            system: entry.name().to_owned(),
            options: options.map(|(option, _)| option).collect(),
            coordinates: entry.description().names().map(str::to_owned).collect(),
        }
    }
}
