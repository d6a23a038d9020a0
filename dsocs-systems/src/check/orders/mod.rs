//! The orders of the parts of a discrete system: how closely `L_d`, `D_K` and `D_V` touch the exact ones, and what follows for the flow.
//!
//! The error analysis in one sentence: at nodes of the continuous motion the discrete equations are missed by a power of the step, which is the least
//! of the powers of their parts; and as the step determines an acceleration from smooth equations, the flow is of this order, too. `dsocs check
//! --orders` measures both sides.

mod fit;
mod flow;
mod maps;
mod parts;

pub use fit::Order;
pub(crate) use maps::statement_of;
pub use maps::{MAPS, Map, Variant};
pub(super) use parts::{NoSmoothState, contacts, expansions};
pub use parts::{Part, PartOrder};

use dsocs_core::{Shape, System};

use crate::check::motion::motions::SecondNode;
use crate::check::{CheckedMotion, Expected, Settings, states_at};
use crate::entry::{CheckFailure, Kind, Motions, TypedSystem};

/// The number of states of the motion at which contact is measured.
const STATES: usize = 8;

/// The states are shifted by this part of the time between two, the golden section: at equal parts of the
/// time the motion may be at rest or at its start, or a table may have a sample.
const STATE_SHIFT: f64 = 0.381_966;

/// The number of steps over which errors of the flow are taken, unless an end is given.
const STEPS: f64 = 200.0;

/// The largest deficit of the measured order against the one that follows.
const ORDER_DEFICIT: f64 = 0.1;

/// The order of the usual maps, which lower nothing.
const USUAL_ORDER: f64 = 2.0;

/// The orders of the parts of a discrete system on one of its motions.
#[derive(Clone, Debug, PartialEq)]
pub struct Orders {
    /// The parts, those of `L_d` first. Only those that the system has.
    pub parts: Vec<PartOrder>,
    /// The order that follows for the flow: the least of those of its equations.
    pub follows: Order,
    /// The order of the errors of the flow's positions against the Taylor series, as fitted.
    pub seen: Order,
    /// The time up to which errors were compared, in s.
    pub until: f64,
    /// The number of states of the motion at which contact was measured.
    pub states: usize,
    /// The parts whose maps lower the order of the flow below 2.
    pub lowering: Vec<Part>,
    /// Remarks on the figures.
    pub remarks: Vec<String>,
    /// The reason why the measured order need not be the one that follows: an assumption does not hold on
    /// this motion.
    pub excuse: Option<String>,
}

impl Orders {
    /// The order of a part; `None` if the system has no such part.
    #[must_use]
    pub fn of(&self, part: Part) -> Option<&Order> {
        let found = self.parts.iter().find(|of| of.part == part);
        found.map(|of| &of.order)
    }

    /// Whether the measured order of the flow is the one that follows, or higher.
    #[must_use]
    pub fn holds(&self) -> bool {
        match (self.follows.number(), self.seen.number()) {
            (Some(follows), Some(seen)) => seen >= follows - ORDER_DEFICIT,
            _ => false,
        }
    }

    /// Whether it is, or is excused.
    #[must_use]
    pub fn ok(&self) -> bool {
        self.holds() || self.excuse.is_some()
    }
}

/// Measures the orders of the parts of a system, from a position and a velocity. The motion ends at the end of the settings or, if they have none,
/// after 200 steps.
///
/// ```
/// use dsocs_core::dsocs;
/// use dsocs_systems::check::orders::{Part, orders};
/// use dsocs_systems::check::{Begin, Settings};
///
/// /// A bead on a parabola.
/// #[dsocs {
///     coordinates(x);
///     lagrangian = (1 + x.powi(2)) / 2 * dot(x).powi(2) - x.powi(2) / 2;
///     phi_lagrangian = paper;
/// }]
/// struct Bead;
///
/// let settings = Settings { h: 0.05, until: None, t0: 0.0, q0: &[], v0: &[], a0: None, begin: Begin::default() };
/// let found = orders(&Bead, &settings, ([1.0], [0.0]))?;
/// // the mass varies: the paper's map lowers the order
/// assert_eq!(found.follows.number(), Some(1.0));
/// assert_eq!(found.seen.number(), Some(1.0));
/// assert_eq!(found.lowering, [Part::Forces]);
/// # Ok::<(), dsocs_systems::entry::CheckFailure>(())
/// ```
///
/// # Errors
///
/// [`CheckFailure`] if the motion cannot be computed, and for systems with constraints of third order.
pub fn orders<S: System<N>, const N: usize>(
    system: &S,
    settings: &Settings<'_>,
    (q, v): ([f64; N], [f64; N]),
) -> Result<Orders, CheckFailure> {
    let settings = Settings {
        q0: &q,
        v0: &v,
        ..*settings
    };
    orders_to(&TypedSystem::new(system), &settings, f64::INFINITY)
}

/// Measures the orders for any system, over at most the time `default_duration` unless the settings give an end.
pub(crate) fn orders_to(
    system: &dyn Motions,
    settings: &Settings<'_>,
    default_duration: f64,
) -> Result<Orders, CheckFailure> {
    let shape = system.kernel().shape();
    if let Some(reason) = reason_against_orders(shape) {
        return Err(CheckFailure::Orders { reason });
    }
    let expected = Expected {
        // of the motion only positions are compared
        kind: Kind::Unconstrained,
        order: USUAL_ORDER,
        reversible: true,
    };
    let default_duration = default_duration
        .abs()
        .min(STEPS * settings.h.abs())
        .copysign(settings.h);
    let mut motion = CheckedMotion::new(system, &[], expected, settings, default_duration)?;
    if !settings.begin.paper {
        motion.start_on_the_motion();
    }
    let places = (0..STATES, STATES, STATE_SHIFT);
    let states = states_at(system, motion.h, &motion.start, motion.until, places);
    let mut remarks: Vec<String> = motion.ended.iter().cloned().collect();
    let (mut parts, count) = match expansions(&motion, &states) {
        Ok(expansions) => (contacts(motion.kernel, &expansions, motion.h)?, expansions.len()),
        Err(error) => {
            remarks.push(format!("contact cannot be measured: {error}"));
            (Vec::new(), 0)
        }
    };
    if count > 0 && count < states.len() {
        remarks.push(format!(
            "contact is measured at {count} of {} states: at the others the motion has no Taylor series, or one for a short time alone, or a function changes its piece",
            states.len()
        ));
    }
    if motion.first == SecondNode::Paper {
        parts.push(flow::start(&motion));
    }
    let follows = follows(&parts);
    let (seen, until) = flow::measured_order(&motion, &mut remarks);
    let lowering = lowering(&parts, &follows);
    remarks.extend(remarks_on_orders(&parts, &follows, &seen));
    Ok(Orders {
        excuse: motion.excuse().or_else(|| at_corners(motion.corners())),
        parts,
        follows,
        seen,
        until,
        states: count,
        lowering,
        remarks,
    })
}

/// The reason why the order of a motion with corners is not required; `None` without corners.
fn at_corners(corners: usize) -> Option<String> {
    (corners > 0).then(|| {
        format!(
            "not required here: the order follows for functions that are smooth along the motion, and it passes a corner {corners} times, as of `abs`, `max` or a \
             comparison, where the error of a step depends on where its nodes lie; to see it required, end before (`--until`), or declare a smooth \
             function in the place of the corner"
        )
    })
}

/// The reason why the orders of a system cannot be measured, if they cannot.
fn reason_against_orders(shape: &Shape) -> Option<&'static str> {
    if shape.is_of_third_order() {
        Some(
            "a constraint is of third order, and the exact motion with which the parts are compared has no Taylor series in this library; `check` without \
             `--orders` fits the order of its nodes from step to step",
        )
    } else {
        None
    }
}

/// The order that follows for the flow from those of its equations.
fn follows(parts: &[PartOrder]) -> Order {
    let decisive = parts.iter().filter(|of| of.part.is_decisive());
    let orders = decisive.map(|of| of.order.clone());
    orders
        .reduce(|least, order| least.least(&order))
        .unwrap_or_else(|| Order::Unknown("no part could be measured".to_owned()))
}

/// The parts that lower the order of the flow below that of the usual maps.
fn lowering(parts: &[PartOrder], follows: &Order) -> Vec<Part> {
    let Some(follows) = follows.number().filter(|follows| *follows < USUAL_ORDER) else {
        return Vec::new();
    };
    let is_low = |of: &&PartOrder| {
        let made_of_others = matches!(of.part, Part::Equations | Part::Lagrangian | Part::Momenta);
        !made_of_others && of.order.number().is_some_and(|order| order <= follows)
    };
    parts.iter().filter(is_low).map(|of| of.part).collect()
}

/// Remarks that compare the orders of the parts with that of the flow.
fn remarks_on_orders(parts: &[PartOrder], follows: &Order, seen: &Order) -> Vec<String> {
    let mut remarks = Vec::new();
    let number = |part: Part| {
        let found = parts.iter().find(|of| of.part == part);
        found.and_then(|of| of.order.number())
    };
    if let (Some(alone), Some(forces)) = (number(Part::Lagrangian), number(Part::Forces))
        && alone < forces
    {
        remarks.push(
            "L_d by itself is of a lower order than D₁L_d + D₂L_d: what it lacks telescopes along the motion, so that no trajectory sees it".to_owned(),
        );
    }
    let of_equations = [Part::Forces, Part::ExternalForces, Part::Displacements];
    let least = of_equations.into_iter().filter_map(number).reduce(f64::min);
    if let (Some(least), Some(equations)) = (least, number(Part::Equations))
        && least < equations
    {
        remarks.push(
            "a part is of a lower order than the equations that it makes: what it lacks does no work along D_V, so that the constraint force takes it up and \
             the motion does not see it"
                .to_owned(),
        );
    }
    if let (Some(follows), Some(seen)) = (follows.number(), seen.number())
        && seen > follows + ORDER_DEFICIT
    {
        remarks.push(
            "the flow is of a higher order than follows from its parts: along this motion what they lack cancels".to_owned(),
        );
    }
    remarks
}
