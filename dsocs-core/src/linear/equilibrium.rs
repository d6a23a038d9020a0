//! States of rest.

mod error;
mod rest;
mod rows;

use crate::number::inner_product;
use core::fmt;

use super::continuous;
use super::error::LinearizationError;
use super::inputs_outputs::InputsOutputs;
use super::model::LinearModel;
use super::slopes::At;
use crate::error::SetupError;
use crate::flow::discrete::values_of;
use crate::kernel::Kernel;
use crate::number::message::Numbers;
use crate::number::point::AnyPoint;
use crate::solve::rotation;
use crate::start;
use crate::tape::declaration::Declaration;
use crate::tape::quantity::Quantity;

pub use error::EquilibriumError;
use rest::{RestEquations, Unknowns};

/// Two equilibria are the same if their coordinates and free parameters differ by less than this, relative to
/// themselves or absolute where they are below 1.
const SAME: f64 = 1e-7;

/// A real part below this part of the largest eigenvalue is zero: a double eigenvalue is accurate to half of
/// the digits only.
const CENTRE: f64 = 1e-7;

/// A search for states of rest: positions `q` at which a motion with the velocity zero stays, with constant parameters.
///
/// Such a position solves the rows of the continuous system with `v = 0` and `a = 0`, and the constraints on
/// positions. The unknowns are the coordinates, except those that are [held](EquilibriumSearch::held), the
/// parameters that are [free](EquilibriumSearch::free), and the multipliers. They are found from a guess by
/// Newton's iteration with a line search; if the rows do not determine all unknowns, by the shortest updates,
/// so that the equilibrium near the guess is found. A function that jumps at rest, such as dry friction, may have any value
/// between its two sides there, and has their mean: the equilibrium is the one that needs no friction, and
/// [`Equilibrium::is_held_by_friction`] tells that positions around it rest as well. A function that jumps at another velocity, as with
/// a belt, has the value of its side.
///
/// ```
/// use dsocs_core::dsocs;
/// use dsocs_core::linear::EquilibriumSearch;
///
/// /// A pendulum.
/// #[dsocs {
///     coordinates(theta);
///     lagrangian = dot(theta).powi(2) / 2 + gravity * theta.cos();
/// }]
/// struct Pendulum { gravity: f64 }
///
/// let found = EquilibriumSearch::new(&Pendulum { gravity: 4.0 }).near_all([[0.3], [3.0], [-0.1]])?;
/// // two of the guesses lead to the same one, below; ±2i are its eigenvalues, ±2 those of the upper one
/// assert_eq!(found.equilibria.len(), 2);
/// assert!(found.equilibria[0].q[0].abs() < 1e-12 && (found.equilibria[1].q[0] - std::f64::consts::PI).abs() < 1e-12);
/// assert_eq!(found.equilibria[0].eigenvalues()?, [[0.0, 2.0], [0.0, -2.0]]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
#[must_use]
pub struct EquilibriumSearch<'s> {
    system: &'s dyn Kernel,
    t: f64,
    free: Vec<String>,
    held: Vec<String>,
}

impl fmt::Debug for EquilibriumSearch<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("EquilibriumSearch")
            .field("t", &self.t)
            .field("free", &self.free)
            .field("held", &self.held)
            .finish_non_exhaustive()
    }
}

/// A state of rest.
#[derive(Clone, Debug)]
pub struct Equilibrium {
    /// The position. Angles are as they were found, not reduced to a turn. Of a rotation, the quaternion.
    pub q: Vec<f64>,
    /// The values of all parameters; free ones as they were found.
    pub parameters: Vec<f64>,
    /// The generalized constraint force, in units of `L` per unit of the coordinate.
    pub force: Vec<f64>,
    /// The directions in which other equilibria lie, if this is one of a continuum: for each, the change of the position, then of the free
    /// parameters in their order. Empty if it is isolated. The change of a rotation is a zero and a turn in the frame of its body.
    pub directions: Vec<Vec<f64>>,
    /// The linear model of the continuous motion there, with all parameters as inputs and all coordinates and
    /// velocities as outputs; or the reason why there is none, for example because dry friction holds the
    /// system.
    pub model: Result<LinearModel, LinearizationError>,
    /// The time for which the equations are solved, if the declaration depends on it: the position, and its
    /// stability, are those of the equations as they are at this time.
    pub frozen_at: Option<f64>,
    /// Whether friction acts at rest.
    held: bool,
    /// The places of the parameters that were free.
    free: Vec<usize>,
    /// The first places of rotations.
    rotations: Vec<usize>,
}

/// The stability of an equilibrium by its eigenvalues.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stability {
    /// All real parts are negative: small changes die away.
    Stable,
    /// A real part is positive: some small change grows.
    Unstable,
    /// The largest real part is zero to rounding: the linear model does not decide.
    Undecided,
}

impl fmt::Display for Stability {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Stable => "stable",
            Self::Unstable => "unstable",
            Self::Undecided => "undecided by the linear model",
        })
    }
}

impl Equilibrium {
    /// Whether there is no other equilibrium nearby with the same values of the parameters that are not free.
    #[must_use]
    pub fn is_isolated(&self) -> bool {
        self.directions.is_empty()
    }

    /// Whether a function that jumps at rest, such as dry friction, holds a range of positions around this one,
    /// which needs none.
    #[must_use]
    pub fn is_held_by_friction(&self) -> bool {
        self.held
    }

    /// The eigenvalues of the linear model, in 1/s, real and imaginary part of each, from the largest real part to the least.
    ///
    /// # Errors
    ///
    /// [`LinearizationError`] if there is no linear model, or the iteration for its eigenvalues does not converge.
    pub fn eigenvalues(&self) -> Result<Vec<[f64; 2]>, LinearizationError> {
        let model = self.model.clone()?;
        model.eigenvalues().ok_or(LinearizationError::Eigenvalues)
    }

    /// The stability by the eigenvalues.
    ///
    /// # Errors
    ///
    /// The errors of [`Equilibrium::eigenvalues`].
    pub fn stability(&self) -> Result<Stability, LinearizationError> {
        let eigenvalues = self.eigenvalues()?;
        let size = eigenvalues
            .iter()
            .fold(0.0_f64, |most, [re, im]| most.max(re.hypot(*im)));
        let largest = eigenvalues.first().map_or(f64::NEG_INFINITY, |[re, _]| *re);
        Ok(if largest > CENTRE * size {
            Stability::Unstable
        } else if largest < -CENTRE * size {
            Stability::Stable
        } else {
            Stability::Undecided
        })
    }

    /// Position and free parameters.
    fn place(&self) -> Vec<f64> {
        let free = self.free.iter().map(|&place| self.parameters[place]);
        self.q.iter().copied().chain(free).collect()
    }

    /// Whether another equilibrium is the same, or lies on the same line or plane of a continuum.
    fn is(&self, other: &Self) -> bool {
        let (here, there) = (self.place(), other.place());
        let mut apart: Vec<f64> = there
            .iter()
            .zip(&here)
            .map(|(there, here)| there - here)
            .collect();
        rotation::difference(&self.rotations, [&here, &there], &mut apart);
        if !other.is_isolated() {
            for direction in &self.directions {
                let part = inner_product(&apart, direction);
                apart
                    .iter_mut()
                    .zip(direction)
                    .for_each(|(x, own)| *x -= part * own);
            }
        }
        let mut each = apart.iter().zip(&here);
        each.all(|(apart, here)| apart.abs() <= SAME * here.abs().max(1.0))
    }
}

/// The equilibria from several guesses.
#[derive(Clone, Debug)]
pub struct Equilibria {
    /// The equilibria, each once, in the order in which they were found. Of those on a line or plane of equilibria one is kept.
    pub equilibria: Vec<Equilibrium>,
    /// For each guess, the index of its equilibrium, or the error.
    pub of_guess: Vec<Result<usize, EquilibriumError>>,
}

/// The places of some names.
fn places(what: &'static str, names: &[String], known: &[Quantity]) -> Result<Vec<usize>, EquilibriumError> {
    let place = |name: &String| {
        let place = known.iter().position(|known| known.name == name.as_str());
        place.ok_or_else(|| EquilibriumError::Name {
            what,
            name: name.clone(),
            known: super::inputs_outputs::names(known),
        })
    };
    let mut places = names.iter().map(place).collect::<Result<Vec<_>, _>>()?;
    places.sort_unstable();
    places.dedup();
    Ok(places)
}

impl<'s> EquilibriumSearch<'s> {
    /// A search for equilibria of a system at the time 0, with the current values of its parameters.
    pub fn new(system: &'s dyn Kernel) -> Self {
        Self {
            system,
            t: 0.0,
            free: Vec::new(),
            held: Vec::new(),
        }
    }

    /// Sets the time, for a system that depends on it. A position at which the equations change in time is no
    /// equilibrium.
    pub fn at(mut self, t: f64) -> Self {
        self.t = t;
        self
    }

    /// Makes parameters unknown as well, starting from their current values: for instance the torques that
    /// hold a position.
    pub fn free<I: IntoIterator>(mut self, parameters: I) -> Self
    where
        I::Item: Into<String>,
    {
        self.free.extend(parameters.into_iter().map(Into::into));
        self
    }

    /// Holds coordinates at their guesses. A rotation is held as a whole, by its name.
    pub fn held<I: IntoIterator>(mut self, coordinates: I) -> Self
    where
        I::Item: Into<String>,
    {
        self.held.extend(coordinates.into_iter().map(Into::into));
        self
    }

    /// The unknowns.
    fn unknowns(&self) -> Result<Unknowns, EquilibriumError> {
        let shape = self.system.shape();
        // a rotation has one name, at its first place
        let mut named: Vec<Quantity> = shape.coordinates.to_vec();
        for &first in shape.rotations.iter() {
            named[first].name = start::name_of_rotation(shape, first).into();
        }
        let is_part = |i: usize| shape.rotation_of(i).is_some_and(|first| first != i);
        let whole: Vec<usize> = (0..named.len()).filter(|i| !is_part(*i)).collect();
        let named: Vec<Quantity> = whole.iter().map(|i| named[*i].clone()).collect();
        let held: Vec<usize> = places("coordinate", &self.held, &named)?
            .into_iter()
            .filter_map(|place| whole.get(place).copied())
            .collect();
        let is_held = |i: &usize| held.contains(&shape.rotation_of(*i).unwrap_or(*i));
        let moving = (0..shape.dimension()).filter(|i| shape.moves(*i));
        Ok(Unknowns {
            coordinates: moving.filter(|i| !is_held(i)).collect(),
            rotations: shape.rotations.to_vec(),
            parameters: places("parameter", &self.free, &shape.parameters)?,
            multipliers: shape.multipliers(),
        })
    }

    /// The equilibrium to which a guess of the position leads.
    ///
    /// # Errors
    ///
    /// [`EquilibriumError`] if the guess or a name cannot be used, no equilibrium is found, or the system depends on time there.
    pub fn near(&self, guess: impl AsRef<[f64]>) -> Result<Equilibrium, EquilibriumError> {
        let (unknowns, guess) = (self.unknowns()?, guess.as_ref());
        self.check(guess)?;
        let mut guess = guess.to_vec();
        rotation::normalize(&unknowns.rotations, &mut guess).map_err(|(first, norm)| {
            SetupError::Quaternion {
                rotation: start::name_of_rotation(self.system.shape(), first),
                norm,
            }
        })?;
        let values = values_of(self.system);
        let rest = RestEquations {
            declaration: Declaration::of(self.system),
            t: self.t,
            guess: &guess,
            values: &values,
            unknowns: &unknowns,
        };
        let found = rest.found()?;
        let directions = rest.continuum(&found);
        let (q, parameters) = (rest.position(&found.x), rest.parameters(&found.x));
        let declaration = Declaration::of(self.system).with(&parameters);
        let still = vec![0.0; q.len()];
        let at = At {
            t: self.t,
            q: &q,
            v: &still,
            a: &still,
            multipliers: unknowns.multipliers_of(&found.x),
        };
        let point = AnyPoint {
            t: self.t,
            q: &q,
            v: &still,
            a: &still,
        };
        let sides = rest.sides(&declaration, &q);
        let force = if sides.is_empty() {
            declaration.continuous_force(point)
        } else {
            declaration.sided_continuous_force(point, &sides)
        };
        let model = self.model(&declaration, &at);
        Ok(Equilibrium {
            free: unknowns.parameters.clone(),
            rotations: unknowns.rotations.clone(),
            frozen_at: self.system.shape().depends_on_time.then_some(self.t),
            held: rest.is_held(&found),
            force,
            directions,
            model,
            q,
            parameters,
        })
    }

    /// The equilibria to which some guesses lead, each once.
    ///
    /// # Errors
    ///
    /// [`EquilibriumError`] if a name or a guess cannot be used. If a guess leads to no equilibrium,
    /// [`Equilibria::of_guess`] has its error.
    pub fn near_all<G: AsRef<[f64]>>(
        &self,
        guesses: impl IntoIterator<Item = G>,
    ) -> Result<Equilibria, EquilibriumError> {
        self.unknowns()?;
        let mut all = Equilibria {
            equilibria: Vec::new(),
            of_guess: Vec::new(),
        };
        for guess in guesses {
            let guess = guess.as_ref();
            self.check(guess)?;
            let place = self.near(guess).map(|found| {
                let known = all.equilibria.iter().position(|known| known.is(&found));
                known.unwrap_or_else(|| {
                    all.equilibria.push(found);
                    all.equilibria.len() - 1
                })
            });
            all.of_guess.push(place);
        }
        Ok(all)
    }

    /// Checks that a guess and the parameters can be used.
    fn check(&self, guess: &[f64]) -> Result<(), EquilibriumError> {
        let shape = self.system.shape();
        if guess.len() != shape.dimension() {
            return Err(EquilibriumError::Length {
                found: guess.len(),
                coordinates: super::inputs_outputs::names(&shape.coordinates),
            });
        }
        if !self.t.is_finite() {
            return Err(SetupError::StartTime { t0: self.t }.into());
        }
        let mut named = shape.coordinates.iter().zip(guess);
        if let Some((own, &value)) = named.find(|(_, value)| !value.is_finite()) {
            return Err(EquilibriumError::Guess {
                coordinate: own.name.clone(),
                value,
            });
        }
        Ok(start::check_parameters(&Declaration::of(self.system))?)
    }

    /// The linear model at the equilibrium.
    fn model(&self, declaration: &Declaration<'_>, at: &At<'_>) -> Result<LinearModel, LinearizationError> {
        let shape = self.system.shape();
        if shape.is_of_third_order() {
            return Err(LinearizationError::Setup(SetupError::ThirdOrder {
                method: "a linear model (linear::OperatingPoint)",
            }));
        }
        start::check_determined(declaration, (at.t, at.q, at.v), at.a)?;
        continuous::linearized(declaration, at, &InputsOutputs::of(shape, None, None)?)
    }
}

impl fmt::Display for Equilibrium {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "q = {}", Numbers(&self.q))?;
        if !self.is_isolated() {
            write!(f, ", one of a continuum")?;
        }
        if self.held {
            write!(f, ", in a range that friction holds")?;
        }
        if let Some(t) = self.frozen_at {
            write!(f, ", for the time frozen at t = {t}")?;
        }
        Ok(())
    }
}
