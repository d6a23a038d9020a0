//! The unknowns and rows that make the Jacobian of the equations singular, in the words of the declaration.
//!
//! The rows are taken as declared, with all their unknowns: second differences (or accelerations) and
//! multipliers. The null vectors of the Jacobian name the unknowns that are not determined; those of its
//! transpose name the rows that depend on each other.

use core::fmt;
use std::borrow::Cow;

use crate::number::bounded::Bounded;
use crate::number::point::{AnyLeg, AnyPoint, map};
use crate::number::scalar::Scalar as _;
use crate::number::tangent::Tangent;
use crate::regularity::multipliers;
use crate::solve::dense::{Matrix, ZERO, equilibrate, null_vectors};
use crate::solve::failure::{NewtonFailure, StepFailure};
use crate::tape::declaration::Declaration;

/// Singular values below this part of the largest count as zero where near-singularity is asked for.
const NEARLY_ZERO: f64 = 1e-5;

/// An unknown or a row with at most this component in all null vectors is not part of the deficiency.
const NO_PART: f64 = 1e-6;

/// A combination of rows with a value below this part of its terms holds.
const UNMET: f64 = 1e-9;

/// A singularity that no motion passes.
#[derive(Clone, Debug)]
pub(crate) struct Singularity {
    /// The approximate time.
    pub time: f64,
    /// The unknowns that are not determined there, if they can be named.
    pub deficiency: Option<Deficiency>,
}

/// The unknowns that the equations do not determine at a point: why there is no solution, or more than one.
///
/// Its text is a part of a sentence: ``coordinate `y` has no mass and no row determines it``.
#[expect(
    clippy::struct_excessive_bools,
    reason = "facts that do not depend on each other"
)]
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Deficiency {
    /// The coordinates that are not determined.
    pub coordinates: Vec<Cow<'static, str>>,
    /// Whether combinations of these coordinates are not determined, rather than the coordinates themselves.
    pub combined: bool,
    /// Whether the undetermined directions have no mass: `∂²L/∂v²` is zero along these coordinates, or along
    /// their combination.
    pub massless: bool,
    /// The rows that depend on each other, constraints first. If there is only one, it does not contain the unknowns at all.
    pub rows: Vec<DependentRow>,
    /// Whether the equations are deficient only where the search began. Close to that point the rows determine the unknowns, so there may
    /// be a solution on either side.
    pub at_guess_alone: bool,
    /// Whether no acceleration meets the rows, a kinematic constraint among them, at this state: the part of them that contains no unknown is not zero.
    pub unmet: bool,
}

/// A row of the equations, as it was declared.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DependentRow {
    /// A holonomic constraint, by its index from 0.
    Holonomic(usize),
    /// A nonholonomic constraint, by its index from 0.
    Nonholonomic(usize),
    /// A kinematic constraint, by its index from 0.
    Kinematic(usize),
    /// The work of the constraint force along a virtual displacement, by the index of the displacement from 0.
    Displacement(usize),
    /// The work along a direction on which the declared constraint forces do no work, by its index from 0:
    /// [`DependentRow::Displacement`] for a declaration of constraint forces instead of virtual
    /// displacements.
    Free(usize),
    /// The equation of motion of a coordinate.
    Motion(Cow<'static, str>),
}

impl fmt::Display for DependentRow {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&named(core::slice::from_ref(self)))
    }
}

impl DependentRow {
    /// Whether it is the work of a constraint force.
    pub(crate) fn is_work(&self) -> bool {
        matches!(self, Self::Displacement(_) | Self::Free(_))
    }

    /// Whether it is a constraint.
    pub(crate) fn is_constraint(&self) -> bool {
        !matches!(self, Self::Displacement(_) | Self::Free(_) | Self::Motion(_))
    }

    /// The name of its kind, singular and plural; its number or name; and a suffix.
    fn words(&self) -> ([&'static str; 2], String, &'static str) {
        let (kind, which) = match self {
            Self::Holonomic(i) => (["holonomic constraint", "holonomic constraints"], i),
            Self::Nonholonomic(i) => (["nonholonomic constraint", "nonholonomic constraints"], i),
            Self::Kinematic(i) => (["kinematic constraint", "kinematic constraints"], i),
            Self::Displacement(i) => (["virtual displacement", "virtual displacements"], i),
            Self::Free(i) => {
                let kinds = ["equation of motion", "equations of motion"];
                return (kinds, (i + 1).to_string(), " without constraint forces");
            }
            Self::Motion(name) => {
                let kinds = ["the equation of motion of", "the equations of motion of"];
                return (kinds, format!("`{name}`"), "");
            }
        };
        (kind, (which + 1).to_string(), "")
    }
}

/// A list in words: `a, b and c`.
fn listed(things: &[String]) -> String {
    match things {
        [] => String::new(),
        [one] => one.clone(),
        [before @ .., last] => format!("{} and {last}", before.join(", ")),
    }
}

/// Rows in words: `holonomic constraints 1 and 2 and virtual displacement 1`.
fn named(rows: &[DependentRow]) -> String {
    let words: Vec<_> = rows.iter().map(DependentRow::words).collect();
    let kinds = words.chunk_by(|(kind, ..), (next, ..)| kind == next);
    let kinds: Vec<String> = kinds
        .map(|rows| {
            let which: Vec<String> = rows.iter().map(|(_, which, _)| which.clone()).collect();
            let ([one, several], _, after) = rows[0];
            let kind = if rows.len() > 1 { several } else { one };
            format!("{kind} {}{after}", listed(&which))
        })
        .collect();
    listed(&kinds)
}

impl Deficiency {
    /// Whether constraints alone depend on each other.
    pub(crate) fn is_of_constraints(&self) -> bool {
        !self.rows.is_empty() && self.rows.iter().all(DependentRow::is_constraint)
    }

    /// Whether several constraints say the same.
    pub(crate) fn is_redundancy(&self) -> bool {
        self.rows.len() > 1 && self.is_of_constraints()
    }

    /// The undetermined coordinates in words, with the verb and the pronoun of the following clause.
    fn what(&self) -> Option<(String, [&'static str; 2])> {
        let names: Vec<String> = self.coordinates.iter().map(|name| format!("`{name}`")).collect();
        let one = ["has", "it"];
        match names.as_slice() {
            [] => None,
            [name] => Some((format!("coordinate {name}"), one)),
            names if self.combined => {
                Some((format!("a combination of the coordinates {}", listed(names)), one))
            }
            names => Some((format!("the coordinates {}", listed(names)), ["have", "them"])),
        }
    }

    /// Advice for users; `None` if only the guess is deficient.
    pub(crate) fn advice(&self) -> Option<&'static str> {
        if self.at_guess_alone {
            return None;
        }
        if self.unmet {
            return Some(
                "start with another velocity, at which the constraint contains the acceleration; or change it so that it holds here: a Lyapunov \
                 constraint `dot(V) + F` by a rate `F` that vanishes with the power of the force, such as `k * dot(x).powi(2)`",
            );
        }
        Some(match (self.is_of_constraints(), self.rows.len()) {
            (true, 1) if matches!(self.rows[0], DependentRow::Kinematic(_)) => {
                "a factor of the constraint is zero here, as a velocity is at rest: divide it out (`branch = divide(factor)`, for example \
                 `divide(dot(x))`), or begin elsewhere"
            }
            (true, 1) => {
                "the constraint's derivatives are zero here: write it so that they are not (`x - y` instead of its square), or \
                 begin elsewhere"
            }
            (true, _) => "leave out the one that repeats the others, or begin where they are independent",
            (false, _) if self.massless => {
                "give it a mass or an inertia in the Lagrangian, or a constraint that determines its acceleration"
            }
            (false, _) => {
                "look for a row that repeats another one, or for a coordinate whose acceleration nothing determines"
            }
        })
    }
}

impl fmt::Display for Deficiency {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let undetermined = self.what();
        if self.is_of_constraints() {
            let rows = named(&self.rows);
            if self.rows.len() == 1 {
                write!(f, "{rows} says nothing about the acceleration here")?;
                if self.unmet {
                    f.write_str(" and does not hold: no acceleration meets it at this state")?;
                }
            } else {
                write!(f, "{rows} depend on each other here")?;
            }
            return match undetermined {
                Some((what, _)) => write!(f, ", and no row determines {what}"),
                None => Ok(()),
            };
        }
        match undetermined {
            Some((what, [has, it])) if self.massless => {
                write!(f, "{what} {has} no mass and no row determines {it}")
            }
            Some((what, _)) if self.rows.len() > 1 => {
                write!(
                    f,
                    "no row determines {what}: {} depend on each other here",
                    named(&self.rows)
                )?;
                if self.unmet {
                    f.write_str(", and no acceleration meets them all at this state")?;
                }
                Ok(())
            }
            Some((what, _)) => write!(f, "no row determines {what}"),
            None => write!(f, "{} depend on each other here", named(&self.rows)),
        }
    }
}

/// The deficiency of a step's declared rows at the second difference `e`; `None` if the Jacobian is regular
/// or not finite.
#[cold]
pub(crate) fn of_step(
    declaration: &Declaration<'_>,
    h: f64,
    leg: AnyLeg<'_, f64>,
    e: &[f64],
) -> Option<Deficiency> {
    let n = declaration.dimension();
    let legs = leg.map(Tangent::splat);
    let columns = |e: &[f64]| -> Vec<Vec<Tangent>> {
        let known = multipliers::of_step(declaration, h, leg, e);
        let columns = (0..n + known.len()).map(|j| {
            let e: Vec<_> = (0..n).map(|i| moved(e[i], i == j)).collect();
            let multipliers: Vec<_> = (0..known.len()).map(|i| moved(known[i], n + i == j)).collect();
            declaration.declared(Tangent::splat(h), legs.any(), &e, &multipliers)
        });
        columns.collect()
    };
    let middle = declaration.point(h, leg, e);
    let longest = leg.d.iter().fold(0.0_f64, |longest, d| longest.max(d.abs()));
    let found = examine(declaration, &columns(e), middle.any(), ZERO)?;
    let other = || examine(declaration, &columns(&beside(e, longest)), middle.any(), ZERO);
    Some(found.judged(other, || {
        let multipliers = multipliers::of_step(declaration, h, leg, e);
        declaration.declared(
            Bounded::splat(h),
            leg.map(Bounded::splat).any(),
            &map(e, Bounded::splat),
            &map(&multipliers, Bounded::splat),
        )
    }))
}

/// The deficiency of the continuous system at a point; `None` if the Jacobian is regular or not finite.
#[cold]
pub(crate) fn of_point(declaration: &Declaration<'_>, point: AnyPoint<'_, f64>) -> Option<Deficiency> {
    at_point(declaration, point, ZERO)
}

/// The deficiency or near-deficiency of the continuous system at a point.
#[cold]
pub(crate) fn near_point(declaration: &Declaration<'_>, point: AnyPoint<'_, f64>) -> Option<Deficiency> {
    at_point(declaration, point, NEARLY_ZERO)
}

/// The deficiency of the continuous system at a point, with singular values up to the part `zero` of the
/// largest counted as zero.
fn at_point(declaration: &Declaration<'_>, point: AnyPoint<'_, f64>, zero: f64) -> Option<Deficiency> {
    let n = declaration.dimension();
    let known = |point: AnyPoint<'_, f64>| {
        if declaration.has_multipliers() {
            multipliers::of_point(declaration, point)
        } else {
            Vec::new()
        }
    };
    let columns = |point: AnyPoint<'_, f64>| -> Vec<Vec<Tangent>> {
        let known = known(point);
        let columns = (0..n + known.len()).map(|j| {
            let at = AnyPoint {
                t: Tangent::splat(point.t),
                q: &map(point.q, Tangent::splat),
                v: &map(point.v, Tangent::splat),
                a: &(0..n).map(|i| moved(point.a[i], i == j)).collect::<Vec<_>>(),
            };
            let multipliers: Vec<_> = (0..known.len()).map(|i| moved(known[i], n + i == j)).collect();
            declaration.continuous(at, &multipliers)
        });
        columns.collect()
    };
    let found = examine(declaration, &columns(point), point, zero)?;
    let other = AnyPoint {
        a: &beside(point.a, 1.0),
        ..point
    };
    let beside = || examine(declaration, &columns(other), other, zero);
    Some(found.judged(beside, || {
        let at = AnyPoint {
            t: Bounded::splat(point.t),
            q: &map(point.q, Bounded::splat),
            v: &map(point.v, Bounded::splat),
            a: &map(point.a, Bounded::splat),
        };
        declaration.continuous(at, &map(&known(point), Bounded::splat))
    }))
}

/// A point near `x`, displaced by about a tenth of `size` in a direction along no axis and no simple diagonal.
pub(crate) fn beside(x: &[f64], size: f64) -> Vec<f64> {
    const ASIDE: [f64; 3] = [0.083, -0.117, 0.059];
    let moved = x.iter().zip(ASIDE.iter().cycle());
    moved.map(|(x, aside)| x + aside * size).collect()
}

/// The deficiency of the equations for the acceleration at a start, if it may be why they have no solution.
#[cold]
pub(crate) fn of_start(
    declaration: &Declaration<'_>,
    (t, q0, v0): (f64, &[f64], &[f64]),
    near: Option<&[f64]>,
    cause: &NewtonFailure,
) -> Option<Deficiency> {
    if !matches!(cause.reason, StepFailure::Singular | StepFailure::NotConverged) {
        return None;
    }
    let at_rest = vec![0.0; declaration.dimension()];
    let a = near.unwrap_or(&at_rest);
    of_point(declaration, AnyPoint { t, q: q0, v: v0, a })
}

/// An unknown, as a variable or as a constant; 0 if it is not finite.
fn moved(x: f64, moves: bool) -> Tangent {
    Tangent::new(if x.is_finite() { x } else { 0.0 }, if moves { 1.0 } else { 0.0 })
}

/// The deficiency of equations from the derivatives of all rows by each unknown: third derivatives, then
/// rates of multipliers.
#[cold]
pub(crate) fn of_columns(
    declaration: &Declaration<'_>,
    columns: &[Vec<Tangent>],
    point: AnyPoint<'_, f64>,
) -> Option<Deficiency> {
    examine(declaration, columns, point, ZERO).map(|found| found.deficiency)
}

/// [`of_columns`] for near-deficiency.
#[cold]
pub(crate) fn near_columns(
    declaration: &Declaration<'_>,
    columns: &[Vec<Tangent>],
    point: AnyPoint<'_, f64>,
) -> Option<Deficiency> {
    examine(declaration, columns, point, NEARLY_ZERO).map(|found| found.deficiency)
}

/// A deficiency, with the combinations of all rows that do not contain the unknowns.
struct Found {
    deficiency: Deficiency,
    combinations: Vec<Vec<f64>>,
}

impl Found {
    /// The deficiency, once it is known whether there is one at a nearby point, `other`; `values` are those of all rows with their rounding errors.
    fn judged(
        self,
        other: impl FnOnce() -> Option<Self>,
        values: impl FnOnce() -> Vec<Bounded>,
    ) -> Deficiency {
        let Self {
            deficiency,
            combinations,
        } = self;
        let at_guess_alone = other().is_none();
        let may_be_unmet = !at_guess_alone
            && !deficiency.is_redundancy()
            && deficiency
                .rows
                .iter()
                .any(|row| matches!(row, DependentRow::Kinematic(_)));
        let unmet = may_be_unmet && {
            let values = values();
            combinations.iter().any(|parts| {
                let (mut sum, mut size) = (0.0, 0.0);
                for (part, value) in parts.iter().zip(&values) {
                    sum += part * value.lane(0);
                    size += part.abs() * value.error() / (f64::EPSILON / 2.0);
                }
                sum.abs() > UNMET * size
            })
        };
        Deficiency {
            at_guess_alone,
            unmet,
            ..deficiency
        }
    }
}

/// The null vectors of a matrix, given by its columns: first those of coordinates, then those of multipliers.
fn examine(
    declaration: &Declaration<'_>,
    columns: &[Vec<Tangent>],
    point: AnyPoint<'_, f64>,
    zero: f64,
) -> Option<Found> {
    let size = columns.len();
    if columns.iter().any(|column| column.len() != size) {
        return None;
    }
    let mut matrix = Matrix::from_fn(size, size, |i, j| columns[j][i].derivative());
    if !matrix.is_finite() {
        return None;
    }
    let declared = matrix.clone();
    let scales = equilibrate(&mut matrix, size);
    let right = null_vectors(&matrix, zero);
    let left = null_vectors(&matrix.transposed(), zero);
    if right.is_empty() || left.is_empty() {
        return None;
    }
    let n = declaration.dimension();
    let names = declaration.coordinates();
    let coordinates: Vec<usize> = (0..n).filter(|&i| has_part(&right, i)).collect();
    let massless = right.iter().all(|vector| {
        let along: Vec<f64> = (0..n).map(|i| vector[i] * scales[i]).collect();
        is_massless(declaration, point, &along)
    });
    // dependent constraints come first: their displacements are dependent in consequence
    let constraints = declaration.constraints().into_iter().sum::<usize>().min(size);
    let bound = Matrix::from_fn(size, constraints, |i, j| matrix[(j, i)]);
    let of_constraints = null_vectors(&bound, zero);
    let left = if of_constraints.is_empty() {
        left
    } else {
        of_constraints
    };
    let count = left[0].len();
    let rows = (0..count).filter(|&i| has_part(&left, i));
    // of the rows as they were declared, not as they were scaled
    let factor = |i: usize| {
        let largest = (0..size).max_by(|&j, &k| matrix[(i, j)].abs().total_cmp(&matrix[(i, k)].abs()));
        let factor = largest.map_or(1.0, |j| matrix[(i, j)] / (declared[(i, j)] * scales[j]));
        if factor.is_finite() { factor } else { 1.0 }
    };
    let combinations = left.iter().map(|parts| {
        let parts = parts.iter().enumerate();
        parts.map(|(i, part)| part * factor(i)).collect()
    });
    let combinations = combinations.collect();
    let deficiency = Deficiency {
        combined: right.len() < coordinates.len(),
        coordinates: coordinates.into_iter().map(|i| names[i].name.clone()).collect(),
        massless,
        rows: rows.map(|i| row(declaration, i)).collect(),
        at_guess_alone: false,
        unmet: false,
    };
    Some(Found {
        deficiency,
        combinations,
    })
}

/// Whether a component is nonzero in a vector.
fn has_part(vectors: &[Vec<f64>], place: usize) -> bool {
    vectors.iter().any(|vector| vector[place].abs() > NO_PART)
}

/// Whether `∂²L/∂v²` is zero along a nonzero direction.
fn is_massless(declaration: &Declaration<'_>, point: AnyPoint<'_, f64>, along: &[f64]) -> bool {
    let mass = |along: &[f64]| {
        let point = AnyPoint {
            t: Tangent::splat(point.t),
            q: &map(point.q, Tangent::splat),
            v: &map(point.v, Tangent::splat),
            a: &map(along, |along| Tangent::new(0.0, along)),
        };
        let forces = declaration.continuous_force(point);
        forces
            .iter()
            .fold(0.0_f64, |largest, x| largest.max(x.derivative().abs()))
    };
    // compared with the masses of the single coordinates
    let alone = |j: usize| -> Vec<f64> {
        let parts = along.iter().enumerate();
        parts
            .map(|(i, &along)| if i == j { along } else { 0.0 })
            .collect()
    };
    let parts = (0..along.len()).map(|j| mass(&alone(j)));
    let own = parts.fold(0.0_f64, f64::max);
    along.iter().any(|&x| x != 0.0) && mass(along) <= ZERO * own
}

/// The declared row with a given index.
pub(crate) fn row(declaration: &Declaration<'_>, place: usize) -> DependentRow {
    let [holonomic, nonholonomic, kinematic] = declaration.constraints();
    let lower = holonomic + nonholonomic;
    let constraints = lower + kinematic;
    if place < holonomic {
        DependentRow::Holonomic(place)
    } else if place < lower {
        DependentRow::Nonholonomic(place - holonomic)
    } else if place < constraints {
        DependentRow::Kinematic(place - lower)
    } else if constraints == 0 || declaration.has_multipliers() {
        let coordinate = declaration.coordinates().get(place - constraints);
        DependentRow::Motion(coordinate.map_or(Cow::Borrowed("?"), |coordinate| coordinate.name.clone()))
    } else if declaration.forms_count() > 0 {
        DependentRow::Free(place - constraints)
    } else {
        DependentRow::Displacement(place - constraints)
    }
}
