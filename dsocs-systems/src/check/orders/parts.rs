//! The contact of each part with the exact one, at states of the continuous motion.

use dsocs_core::Kernel;
use dsocs_core::geometry::{Expansion, PartError, PartErrors, pieces};
use dsocs_core::{AnyPoint, SetupError};
use thiserror::Error;

use super::fit::{Order, Sample, order};
use crate::check::motion::motions::{State, expansion};
use crate::check::{CheckedMotion, Measured, larger};

/// The number of steps, each half of the one before.
pub const HALVINGS: i32 = 20;

/// The largest step, relative to the reach of the expansion of the motion.
pub const LARGEST_STEP: f64 = 0.25;

/// The largest reach, in steps of the system: that of a polynomial motion is infinite.
const LARGEST_REACH: f64 = 64.0;

/// States whose expansion reaches less than this part of the longest are left out: the step has to be as
/// short as the shortest reach.
const SHORTEST_REACH: f64 = 1.0 / 32.0;

/// The largest number of halvings of a reach within which a function changes its piece.
const MOST_REACH_HALVINGS: u32 = 12;

/// The number of points of each half of the reach at which the pieces are compared.
const COMPARED_POINTS: u32 = 8;

/// A part of the discrete system, or a combination of several.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Part {
    /// The discrete Lagrangian `L_d` on a leg, against the mean of `L`.
    Lagrangian,
    /// `D₁L_d` and `D₂L_d`, against the momenta at the ends of a leg.
    Momenta,
    /// Their sum at a node, `D₁L_d + D₂L_d`, against the force: the part of `L_d` in the equations.
    Forces,
    /// The discrete external forces.
    ExternalForces,
    /// `D_K`: constraints on positions.
    Positions,
    /// `D_K`: constraints on velocities.
    Velocities,
    /// `D_K`: constraints on accelerations.
    Accelerations,
    /// `D_V`: the work of the true constraint force along the virtual displacements.
    Displacements,
    /// The variational equations that `L_d`, the external forces and `D_V` make together: the paper's `β`.
    Equations,
    /// The second node, where the rule of the start is not exact on the motion.
    Start,
}

/// All parts, in the order in which they are reported.
pub(super) const PARTS: [Part; 9] = [
    Part::Lagrangian,
    Part::Momenta,
    Part::Forces,
    Part::ExternalForces,
    Part::Positions,
    Part::Velocities,
    Part::Accelerations,
    Part::Displacements,
    Part::Equations,
];

impl Part {
    /// Its symbols.
    #[must_use]
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Lagrangian => "L_d",
            Self::Momenta => "D₁L_d, D₂L_d",
            Self::Forces => "D₁L_d + D₂L_d",
            Self::ExternalForces => "f_d",
            Self::Positions | Self::Velocities | Self::Accelerations => "D_K",
            Self::Displacements => "D_V",
            Self::Equations => "β",
            Self::Start => "q1",
        }
    }

    /// The quantity that is compared, in words.
    #[must_use]
    pub fn meaning(self) -> &'static str {
        match self {
            Self::Lagrangian => "the mean of L on a leg",
            Self::Momenta => "the momenta at its ends",
            Self::Forces => "the force at a node",
            Self::ExternalForces => "the external force at a node",
            Self::Positions => "constraints on positions",
            Self::Velocities => "constraints on velocities",
            Self::Accelerations => "constraints on accelerations",
            Self::Displacements => "the work of the constraint force",
            Self::Equations => "the variational equations",
            Self::Start => "the second node of the start",
        }
    }

    /// Whether the order of the flow follows from it directly.
    pub(super) fn is_decisive(self) -> bool {
        matches!(
            self,
            Self::Positions | Self::Velocities | Self::Accelerations | Self::Equations | Self::Start
        )
    }

    /// The statement of a declaration that chooses its map.
    #[must_use]
    pub fn statement(self) -> Option<&'static str> {
        match self {
            Self::Lagrangian | Self::Momenta | Self::Forces | Self::ExternalForces | Self::Velocities => {
                Some("phi_lagrangian")
            }
            Self::Accelerations => Some("phi_kinematic"),
            Self::Displacements => Some("phi_variational"),
            Self::Positions | Self::Equations | Self::Start => None,
        }
    }

    /// The errors of this part.
    fn of(self, part_errors: &PartErrors) -> &[PartError] {
        match self {
            Self::Lagrangian => &part_errors.lagrangian,
            Self::Momenta => &part_errors.momenta,
            Self::Forces => &part_errors.forces,
            Self::ExternalForces => &part_errors.external_forces,
            Self::Positions => &part_errors.positions,
            Self::Velocities => &part_errors.velocities,
            Self::Accelerations => &part_errors.accelerations,
            Self::Displacements => &part_errors.displacements,
            Self::Equations => &part_errors.equations,
            Self::Start => &[],
        }
    }
}

/// A part with its order of contact.
#[derive(Clone, Debug, PartialEq)]
pub struct PartOrder {
    /// The part.
    pub part: Part,
    /// Its order of contact: that of its worst component.
    pub order: Order,
    /// The distance from the exact part with the step that was asked for, relative to its terms, over the
    /// states whose expansion reaches one step; NaN if there are none.
    pub distance: f64,
}

/// No state can be used, as where a motion rests at the corner of a function.
#[derive(Error)]
#[error("a function changes its piece at every state that was looked at")]
pub struct NoSmoothState;

dsocs_core::debug_is_message!(NoSmoothState);

/// The expansions of the motion about some states, each up to the first change of a piece; [`NoSmoothState`] if
/// none is left.
pub fn expansions(motion: &CheckedMotion<'_>, states: &[State]) -> Measured<Vec<Expansion>> {
    let mut failure = None;
    let mut found = Vec::new();
    for state in states {
        match expansion(motion.system, state) {
            Ok(mut expansion) => {
                expansion.reach = expansion.reach.min(LARGEST_REACH * motion.h.abs());
                found.extend(smooth(motion.kernel, expansion));
            }
            Err(error) => failure = Some(error),
        }
    }
    let longest = found
        .iter()
        .fold(0.0_f64, |most, expansion: &Expansion| most.max(expansion.reach));
    found.retain(|expansion| expansion.reach >= SHORTEST_REACH * longest);
    match (found.is_empty(), failure) {
        (false, _) => Ok(found),
        (true, Some(error)) => Err(error),
        (true, None) => Err(NoSmoothState.into()),
    }
}

/// An expansion with its reach shortened to one piece of every function; `None` where the piece changes at
/// the state itself.
fn smooth(kernel: &dyn Kernel, mut expansion: Expansion) -> Option<Expansion> {
    let at = |s: f64| {
        let point = expansion.point(s);
        let AnyPoint { t, q, v, a } = point.any();
        pieces(kernel, (t, q, v, a))
    };
    let here = at(0.0)?;
    let same = |s: f64| at(s).is_some_and(|there| there == here);
    let reach = (0..MOST_REACH_HALVINGS)
        .map(|halving| expansion.reach * 0.5_f64.powi(halving.cast_signed()))
        .find(|reach| {
            (1..=COMPARED_POINTS).all(|k| {
                let s = reach * f64::from(k) / f64::from(COMPARED_POINTS);
                same(s) && same(-s)
            })
        });
    expansion.reach = reach?;
    Some(expansion)
}

/// Sums over states for one component: of the squares of the error, of its size, and of its rounding.
#[derive(Clone, Copy, Default)]
struct Sums {
    difference: f64,
    size: f64,
    rounding: f64,
}

impl Sums {
    /// Adds the error at one more state.
    fn add(&mut self, error: &PartError) {
        self.difference += error.difference * error.difference;
        self.size += error.size * error.size;
        self.rounding += error.rounding * error.rounding;
    }

    /// The error relative to the terms, as a sample.
    fn sample(&self, h: f64) -> Sample {
        let relative = |x: f64| if x == 0.0 { 0.0 } else { (x / self.size).sqrt() };
        Sample {
            h: h.abs(),
            value: relative(self.difference),
            rounding: relative(self.rounding),
        }
    }
}

/// The components of every part with a step, over all states.
fn components(kernel: &dyn Kernel, expansions: &[Expansion], h: f64) -> Result<[Vec<Sample>; 9], SetupError> {
    let mut all: [Vec<Sums>; 9] = Default::default();
    for expansion in expansions {
        let part_errors = PartErrors::of(kernel, expansion, h)?;
        for (part, sums) in PARTS.into_iter().zip(&mut all) {
            let errors = part.of(&part_errors);
            sums.resize(errors.len(), Sums::default());
            for (sums, error) in sums.iter_mut().zip(errors) {
                sums.add(error);
            }
        }
    }
    Ok(all.map(|sums| sums.iter().map(|sums| sums.sample(h)).collect()))
}

/// The orders of contact of all parts of the system, and their distances with the step `h`.
pub fn contacts(kernel: &dyn Kernel, expansions: &[Expansion], h: f64) -> Result<Vec<PartOrder>, SetupError> {
    let reach = expansions
        .iter()
        .fold(f64::INFINITY, |least, expansion| least.min(expansion.reach));
    let steps = (0..HALVINGS).map(|halving| (LARGEST_STEP * reach * 0.5_f64.powi(halving)).copysign(h));
    let measured: Vec<[Vec<Sample>; 9]> = steps
        .map(|h| components(kernel, expansions, h))
        .collect::<Result<_, _>>()?;
    let near: Vec<Expansion> = expansions
        .iter()
        .filter(|expansion| h.abs() <= expansion.reach)
        .cloned()
        .collect();
    let own = if near.is_empty() {
        None
    } else {
        Some(components(kernel, &near, h)?)
    };
    let mut found = Vec::new();
    for (place, part) in PARTS.into_iter().enumerate() {
        let count = measured.first().map_or(0, |first| first[place].len());
        let orders = (0..count).map(|component| {
            let samples: Vec<Sample> = measured.iter().map(|parts| parts[place][component]).collect();
            order(&samples)
        });
        let Some(order) = orders.reduce(|least, order| least.least(&order)) else {
            continue;
        };
        let distance = own.as_ref().map_or(f64::NAN, |own| {
            let values = own[place].iter().map(|sample| sample.value);
            values.fold(0.0, larger)
        });
        found.push(PartOrder {
            part,
            order,
            distance,
        });
    }
    Ok(found)
}
