//! Inputs and outputs of a linear model, by their names.

use std::borrow::Cow;

use super::error::LinearizationError;
use super::slopes::{At, Direction, Slopes};
use crate::solve::rotation;
use crate::tape::declaration::Declaration;
use crate::tape::quantity::Quantity;
use crate::tape::{Part, Segment, Shape};

/// A measured quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Output {
    Position(usize),
    Velocity(usize),
    Acceleration(usize),
    Force(usize),
    Energy,
    Observed(usize),
}

/// The inputs and the outputs.
#[derive(Clone, Debug)]
pub(super) struct InputsOutputs {
    /// The places of the parameters that are inputs.
    inputs: Vec<usize>,
    outputs: Vec<Output>,
}

/// A quantity of a coordinate.
type OfCoordinate = fn(usize) -> Output;

/// The name prefixes of the quantities of a coordinate.
const PREFIXES: [(&str, OfCoordinate); 3] = [
    ("v_", Output::Velocity),
    ("a_", Output::Acceleration),
    ("force_", Output::Force),
];

impl Output {
    /// The quantity with a name: a coordinate, an observed expression, the energy, or a quantity of a
    /// coordinate, searched in this order.
    fn find(shape: &Shape, name: &str) -> Option<Self> {
        let place = |among: &[Quantity], name: &str| among.iter().position(|known| known.name == name);
        if let Some(i) = place(&shape.coordinates, name) {
            return Some(Self::Position(i));
        }
        if let Some(i) = place(&shape.observables, name) {
            return Some(Self::Observed(i));
        }
        if name == "energy" {
            return Some(Self::Energy);
        }
        PREFIXES.iter().find_map(|(prefix, output)| {
            let coordinate = name.strip_prefix(prefix)?;
            let place = place(&shape.coordinates, coordinate)?;
            shape.moves(place).then(|| output(place))
        })
    }

    /// Name, meaning and unit.
    fn quantity(self, shape: &Shape) -> Quantity {
        let of = |i: usize, prefix: &str, what: &str, unit: fn(&str) -> String| -> Quantity {
            let Some(own) = shape.coordinates.get(i) else {
                return Quantity::new("?", "");
            };
            if let Some((body, axis)) = shape.axis_of(i) {
                let (what, unit) = match prefix {
                    "v_" => ("angular velocity", "rad/s"),
                    "a_" => ("angular acceleration", "rad/s²"),
                    _ => ("torque of constraints on", "N m"),
                };
                let of = if prefix == "force_" { "" } else { " of" };
                return Quantity {
                    name: format!("{prefix}{}", own.name).into(),
                    doc: format!("The {what}{of} `{body}` about the {axis} axis of its body [{unit}].")
                        .into(),
                };
            }
            let unit = own
                .unit()
                .map_or_else(String::new, |own| format!(" [{}]", unit(own)));
            Quantity {
                name: format!("{prefix}{}", own.name).into(),
                doc: format!("The {what} of `{}`{unit}.", own.name).into(),
            }
        };
        match self {
            Self::Position(i) => shape
                .coordinates
                .get(i)
                .cloned()
                .unwrap_or(Quantity::new("?", "")),
            Self::Observed(i) => shape
                .observables
                .get(i)
                .cloned()
                .unwrap_or(Quantity::new("?", "")),
            Self::Velocity(i) => of(i, "v_", "velocity", |unit| format!("{unit}/s")),
            Self::Acceleration(i) => of(i, "a_", "acceleration", |unit| format!("{unit}/s²")),
            Self::Force(i) => of(
                i,
                "force_",
                "generalized constraint force along",
                |unit| match unit {
                    "rad" => "N m".to_owned(),
                    "m" => "N".to_owned(),
                    "1" => "J".to_owned(),
                    unit => format!("J/{unit}"),
                },
            ),
            Self::Energy => Quantity::new("energy", r"The energy \[J\]."),
        }
    }
}

/// An error if a name occurs twice.
fn twice(names: &[String]) -> Result<(), LinearizationError> {
    let mut places = names.iter().enumerate();
    match places.find(|(place, name)| names[..*place].contains(name)) {
        Some((_, name)) => Err(LinearizationError::Twice { name: name.clone() }),
        None => Ok(()),
    }
}

/// The place of a parameter.
fn input(shape: &Shape, name: &str) -> Result<usize, LinearizationError> {
    let place = shape.parameters.iter().position(|known| known.name == name);
    place.ok_or_else(|| LinearizationError::Input {
        name: name.to_owned(),
        known: names(&shape.parameters),
    })
}

/// The names of some quantities.
pub(super) fn names(of: &[Quantity]) -> Vec<Cow<'static, str>> {
    of.iter().map(|of| of.name.clone()).collect()
}

impl InputsOutputs {
    /// The inputs and outputs of some names; by default all parameters, and all coordinates and velocities.
    pub(super) fn of(
        shape: &Shape,
        inputs: Option<&[String]>,
        outputs: Option<&[String]>,
    ) -> Result<Self, LinearizationError> {
        let inputs = match inputs {
            None => (0..shape.parameters.len()).collect(),
            Some(names) => {
                twice(names)?;
                let places = names.iter().map(|name| input(shape, name));
                places.collect::<Result<_, _>>()?
            }
        };
        let outputs = match outputs {
            None => {
                let places = || 0..shape.dimension();
                let moving = places().filter(|place| shape.moves(*place));
                places()
                    .map(Output::Position)
                    .chain(moving.map(Output::Velocity))
                    .collect()
            }
            Some(given) => {
                twice(given)?;
                let found = given.iter().map(|name| {
                    Output::find(shape, name).ok_or_else(|| {
                        let mut known = names(&shape.coordinates);
                        known.extend(names(&shape.observables));
                        known.push("energy".into());
                        LinearizationError::Output {
                            name: name.clone(),
                            known,
                        }
                    })
                });
                found.collect::<Result<_, _>>()?
            }
        };
        Ok(Self { inputs, outputs })
    }

    /// The places of the parameters that are inputs.
    pub(super) fn inputs(&self) -> &[usize] {
        &self.inputs
    }

    /// The inputs.
    pub(super) fn input_quantities(&self, shape: &Shape) -> Vec<Quantity> {
        let found = self
            .inputs
            .iter()
            .filter_map(|&place| shape.parameters.get(place));
        found.cloned().collect()
    }

    /// The outputs.
    pub(super) fn output_quantities(&self, shape: &Shape) -> Vec<Quantity> {
        self.outputs.iter().map(|output| output.quantity(shape)).collect()
    }
}

/// The measured quantities at a point, with their derivatives.
pub(super) struct Measured<'p> {
    inputs_outputs: &'p InputsOutputs,
    observed: Slopes,
    energy: Slopes,
    point: [Vec<f64>; 3],
    rotations: Vec<usize>,
}

/// A constraint force, or its change.
pub(super) type Force<'f> = &'f dyn Fn() -> Vec<f64>;

impl<'p> Measured<'p> {
    /// The measured quantities at a point; `reported` is the measured position.
    pub(super) fn of(
        declaration: &Declaration<'_>,
        inputs_outputs: &'p InputsOutputs,
        at: &At<'_>,
        reported: &[f64],
    ) -> Self {
        let only = |wanted: bool, segment: Segment| {
            let all = [(segment, Part::All)];
            at.slopes(declaration, if wanted { &all } else { &[] })
        };
        let observes = inputs_outputs
            .outputs
            .iter()
            .any(|output| matches!(output, Output::Observed(_)));
        Self {
            observed: only(observes, Segment::Observe),
            energy: only(inputs_outputs.outputs.contains(&Output::Energy), Segment::Energy),
            point: [reported.to_vec(), at.v.to_vec(), at.a.to_vec()],
            rotations: declaration.shape().rotations.to_vec(),
            inputs_outputs,
        }
    }

    /// The outputs, one after the other, from the values of all quantities.
    fn pick(&self, [q, v, a]: [&[f64]; 3], force: Force<'_>, observed: &[f64], energy: &[f64]) -> Vec<f64> {
        let of = |vector: &[f64], i: usize| vector.get(i).copied().unwrap_or(f64::NAN);
        let forces = self
            .inputs_outputs
            .outputs
            .iter()
            .any(|output| matches!(output, Output::Force(_)));
        let force = if forces { force() } else { Vec::new() };
        let outputs = self.inputs_outputs.outputs.iter().map(|output| match *output {
            Output::Position(i) => of(q, i),
            Output::Velocity(i) => of(v, i),
            Output::Acceleration(i) => of(a, i),
            Output::Force(i) => of(&force, i),
            Output::Energy => of(energy, 0),
            Output::Observed(i) => of(observed, i),
        });
        outputs.collect()
    }

    /// The outputs at the point.
    pub(super) fn values(&self, force: Force<'_>) -> Vec<f64> {
        let [q, v, a] = &self.point;
        self.pick([q, v, a], force, &self.observed.values, &self.energy.values)
    }

    /// The changes of the outputs for a change of the point, in which the reported position changes by
    /// `reported`, and the acceleration by `a`.
    pub(super) fn change(&self, reported: &[f64], at: &Direction, a: &[f64], force: Force<'_>) -> Vec<f64> {
        let rate = |leaf| at.rate(leaf, a);
        let observed = self.observed.along(&rate);
        let energy = self.energy.along(&rate);
        // turns as changes of quaternions
        let reported = rotation::rate(&self.rotations, &self.point[0], reported);
        self.pick([&reported, &at.v, a], force, &observed, &energy)
    }
}
