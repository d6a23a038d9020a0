//! The contact of the discrete system with the exact one: the errors of its parts at nodes of the continuous
//! motion.

use super::array::{along, moving, moving_leg};
use super::continuous::legendre;
use super::expansion::Expansion;
use super::legendre::{legendre_minus, legendre_plus};
use super::map::Triple;
use super::nodes::{extent, moves, moving_position};
use super::quadrature::mean_over;
use crate::error::SetupError;
use crate::kernel::Kernel;
use crate::number::bounded::Bounded;
use crate::number::inner_product;
use crate::number::point::{AnyPoint, OwnedLeg};
use crate::number::scalar::Scalar as _;
use crate::number::tangent::Tangent;
use crate::regularity::multipliers::multipliers;
use crate::tape::declaration::Declaration;

/// Factor for bounds of rounding errors, because the inputs are rounded, too.
const INPUTS: f64 = 4.0;

/// Rounding error of a momentum, computed as a derivative of `L_d`, relative to its terms.
const DERIVATIVE: f64 = 64.0 * f64::EPSILON;

/// The error of a quantity of the discrete system.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PartError {
    /// The discrete value minus the exact one.
    pub difference: f64,
    /// The size of the terms that make up the quantity, in the same units.
    pub size: f64,
    /// A bound of the rounding error in `difference`, in the same units.
    pub rounding: f64,
}

/// The errors of the parts of the discrete system at three nodes `q(t − h)`, `q(t)`, `q(t + h)` of the
/// continuous motion.
///
/// The exact discrete system has the nodes of the continuous motion for its trajectories: its `L_d` of two of them is the mean of `L` along the
/// motion between them, its derivatives are the momenta there, its `D_K` holds at them, and its `D_V` is `C_V` at the point `(q, v, a)` of the
/// motion at the middle node (Marsden and West 2001, part 2, for systems without constraints).
///
/// Quantities with one number for each coordinate have three for a rotation: those of turns in the frame of
/// its body.
///
/// ```
/// use dsocs_core::dsocs;
/// use dsocs_core::geometry::{PartErrors, Expansion};
///
/// /// An oscillator, with the paper's map.
/// #[dsocs { coordinates(x); lagrangian = (dot(x).powi(2) - x.powi(2)) / 2; }]
/// struct Oscillator;
///
/// // the motion cos t about t = 0
/// let cosine = [1.0, 0.0, -1.0 / 2.0, 0.0, 1.0 / 24.0, 0.0, -1.0 / 720.0, 0.0, 1.0 / 40320.0];
/// let motion = Expansion { t: 0.0, coefficients: cosine.map(|c| vec![c]).to_vec(), rotations: vec![], reach: 0.5 };
/// let h = 0.1_f64;
/// let part_errors = PartErrors::of(&Oscillator, &motion, h)?;
/// // the force at the node is missed by about h²/12
/// let by_hand = 2.0 * (h.cos() - 1.0) / h.powi(2) + 1.0;
/// assert!((part_errors.forces[0].difference - by_hand).abs() < 1e-12);
/// // L_d by about h times a half, since V is taken at the first node; the action is half of the change of q q̇
/// let by_hand = ((h.cos() - 1.0) / h).powi(2) / 2.0 - 0.5 - (-h.sin() * h.cos() / 2.0 / h);
/// assert!((part_errors.lagrangian[0].difference - by_hand).abs() < 1e-12);
/// # Ok::<(), dsocs_core::SetupError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct PartErrors {
    /// `L_d` minus the mean of `L`, on the leg after the middle node. One number, in units of `L`.
    pub lagrangian: Vec<PartError>,
    /// The discrete momenta at the middle node minus `∂L/∂v`: first that of the leg that ends there, then
    /// that of the leg that begins there, with one number for each coordinate. Half of the impulse of the
    /// constraint force belongs to each leg. In units of `∂L/∂v`.
    pub momenta: Vec<PartError>,
    /// `−(D₁L_d + D₂L_d)` at the middle node minus `d/dt ∂L/∂v − ∂L/∂q`, one number for each coordinate, in
    /// units of `L` per unit of the coordinate. Terms of `L_d` that telescope have no effect here, as they
    /// have none on any motion.
    pub forces: Vec<PartError>,
    /// The discrete external forces minus `f`; empty if there are none.
    pub external_forces: Vec<PartError>,
    /// The rows of `D_K` that are constraints on positions, as declared.
    pub positions: Vec<PartError>,
    /// The rows of `D_K` that are constraints on velocities, on the leg after the middle node.
    pub velocities: Vec<PartError>,
    /// The rows of `D_K` that are constraints on accelerations.
    pub accelerations: Vec<PartError>,
    /// The works of the true constraint force along the fields that span `D_V`; if no fields are known, the
    /// true force minus its fit by the constraint forms, one number for each coordinate. Empty without
    /// constraints.
    pub displacements: Vec<PartError>,
    /// The equations that `L_d`, the external forces and `D_V` make together: the works of the discrete
    /// constraint force along `D_V`, or its residual from the fit by the forms. Without constraints the force
    /// itself, one number for each coordinate.
    pub equations: Vec<PartError>,
}

impl PartErrors {
    /// The errors at three nodes about the centre of an expansion, `h` apart.
    ///
    /// # Errors
    ///
    /// [`SetupError::ThirdOrder`] if a constraint is of third order, where the exact motion has no series in this library.
    pub fn of(system: &dyn Kernel, motion: &Expansion, h: f64) -> Result<Self, SetupError> {
        let method = "the errors of the parts (geometry::PartErrors)";
        if system.shape().is_of_third_order() {
            return Err(SetupError::ThirdOrder { method });
        }
        let place = ExactNodes::new(system, motion, h);
        let [forces, external_forces] = place.forces();
        let [positions, velocities, accelerations] = place.rows();
        let [displacements, equations] = place.works();
        Ok(Self {
            lagrangian: vec![place.lagrangian(motion)],
            momenta: place.momenta(),
            forces,
            external_forces,
            positions,
            velocities,
            accelerations,
            displacements,
            equations,
        })
    }
}

/// Three nodes of the motion, and the exact quantities at the middle one.
struct ExactNodes<'s> {
    system: &'s dyn Kernel,
    declaration: Declaration<'s>,
    h: f64,
    triple: Triple,
    /// `∂L/∂v` there.
    momentum: Vec<f64>,
    /// The true constraint force there.
    force: Vec<Bounded>,
    /// The true external force.
    external: Vec<Bounded>,
    /// The discrete constraint force.
    discrete: Vec<Bounded>,
    /// The sizes of the forces: their terms, and the momentum over the time scale of the motion.
    sizes: Vec<f64>,
    /// The time about the middle node within which the motion is known.
    reach: f64,
}

/// Numbers with rounding bounds zero.
fn bounded(x: &[f64]) -> Vec<Bounded> {
    x.iter().copied().map(Bounded::splat).collect()
}

/// A component of a force's residual, with its rounding bound.
struct ResidualComponent {
    value: f64,
    error: f64,
}

impl<'s> ExactNodes<'s> {
    fn new(system: &'s dyn Kernel, motion: &Expansion, h: f64) -> Self {
        let declaration = Declaration::of(system);
        let (triple, point) = (motion.triple(h), motion.point(0.0));
        let AnyPoint { t, q, v, a } = point.any();
        let momentum = legendre(system, t, q, v);
        let [t_bounded, h_bounded] = [t, h].map(Bounded::splat);
        let [q_bounded, v_bounded, a_bounded] = [q, v, a].map(bounded);
        let force = declaration.continuous_force(AnyPoint {
            t: t_bounded,
            q: &q_bounded,
            v: &v_bounded,
            a: &a_bounded,
        });
        let mut external = bounded(&vec![0.0; q.len()]);
        declaration.external_forces(t_bounded, &q_bounded, &v_bounded, &mut external);
        let leg = triple.first().map(Bounded::splat);
        let discrete = declaration.force(h_bounded, leg.any(), &bounded(&triple.e));
        let n = q.len();
        let rotations = &declaration.shape().rotations;
        let slope = |i: usize| {
            let q = moving_position(rotations, q, i);
            declaration
                .lagrangian(Tangent::splat(t), &q, &super::array::fixed(v))
                .derivative()
        };
        let size = |i: usize| {
            if !moves(rotations, i) {
                return 0.0;
            }
            let turning = momentum[i].abs() / motion.reach;
            slope(i).abs() + force[i].lane(0).abs() + external[i].lane(0).abs() + turning
        };
        let sizes = (0..n).map(size).collect();
        Self {
            system,
            declaration,
            h,
            triple,
            momentum,
            force,
            external,
            discrete,
            sizes,
            reach: motion.reach,
        }
    }

    /// The coordinates with a velocity, that is, without the first places of rotations.
    fn coordinates(&self) -> impl Iterator<Item = usize> + use<'_> {
        let rotations = &self.declaration.shape().rotations;
        (0..self.sizes.len()).filter(move |&i| moves(rotations, i))
    }

    /// The leg that begins at the middle node.
    fn last(&self) -> OwnedLeg<f64> {
        self.triple.last_of(&self.declaration.shape().rotations, self.h)
    }

    /// The error of `L_d` on the second leg, compared with the mean of `L` along the motion.
    fn lagrangian(&self, motion: &Expansion) -> PartError {
        let leg = self.last();
        let found = self
            .declaration
            .discrete_lagrangian(Bounded::splat(self.h), leg.any().map(Bounded::splat).any());
        let (mut error, mut size) = (0.0, 0.0_f64);
        let exact = mean_over([0.0, self.h], &mut |s| {
            let point = motion.point(s);
            let AnyPoint { t, q, v, .. } = point.any();
            let value = self
                .declaration
                .lagrangian(Bounded::splat(t), &bounded(q), &bounded(v));
            let kinetic = inner_product(&self.momentum, v) / 2.0;
            error = value.error().max(error);
            size = (kinetic.abs() + (kinetic - value.lane(0)).abs()).max(size);
            value.lane(0)
        });
        PartError {
            difference: found.lane(0) - exact,
            size,
            rounding: INPUTS * (found.error() + error),
        }
    }

    /// The errors of both legs' momenta at the middle node.
    fn momenta(&self) -> Vec<PartError> {
        let (system, h, first, last) = (self.system, self.h, self.triple.first(), self.last());
        let arriving = legendre_plus(system, h, first);
        let departing = legendre_minus(system, h, last.any());
        let [_, plus] = self.declaration.discrete_external_forces(h, first);
        let [minus, _] = self.declaration.discrete_external_forces(h, last.any());
        let gap = |i: usize, found: f64| {
            // at rest the momentum is zero, but its change within the time of the series is not
            let size = self.reach * self.sizes[i];
            PartError {
                difference: found - self.momentum[i],
                size,
                rounding: DERIVATIVE * size,
            }
        };
        let half = |i: usize| self.force[i].lane(0) / 2.0;
        let arriving = self
            .coordinates()
            .map(|i| gap(i, h * (arriving[i] + plus[i] + half(i))));
        let departing = self
            .coordinates()
            .map(|i| gap(i, h * (departing[i] - minus[i] - half(i))));
        arriving.chain(departing).collect()
    }

    /// The errors of the forces of `L_d`, and of the external ones.
    fn forces(&self) -> [Vec<PartError>; 2] {
        let leg = self.triple.first().map(Bounded::splat);
        let found =
            self.declaration
                .external_force(Bounded::splat(self.h), leg.any(), &bounded(&self.triple.e));
        let gap = |i: usize, x: Bounded, y: Bounded| PartError {
            difference: x.lane(0) - y.lane(0),
            size: self.sizes[i],
            rounding: INPUTS * (x.error() + y.error()),
        };
        let of_lagrangian = |i: usize| gap(i, self.discrete[i] + found[i], self.force[i] + self.external[i]);
        let of_external = |i: usize| gap(i, found[i], self.external[i]);
        let external = if self.declaration.has_external_forces() {
            self.coordinates().map(of_external).collect()
        } else {
            Vec::new()
        };
        [self.coordinates().map(of_lagrangian).collect(), external]
    }

    /// The errors of the constraints on positions, velocities and accelerations.
    fn rows(&self) -> [Vec<PartError>; 3] {
        let [holonomic, nonholonomic, kinematic] = self.declaration.constraints();
        let count = holonomic + nonholonomic + kinematic;
        if count == 0 {
            return [Vec::new(), Vec::new(), Vec::new()];
        }
        let (first, e) = (self.triple.first(), &self.triple.e);
        let leg = first.map(Bounded::splat);
        let rows = self
            .declaration
            .declared(Bounded::splat(self.h), leg.any(), &bounded(e), &[]);
        // the derivatives of the rows by the components of the increments
        let n = e.len();
        let mut sizes = vec![0.0; rows.len()];
        for i in 0..n {
            let rotations = &self.declaration.shape().rotations;
            for [by_d, by_e] in [
                [extent(rotations, first.d, i), 0.0],
                [0.0, extent(rotations, e, i)],
            ] {
                let leg = moving_leg(first, &along(n, i, 0.0), &along(n, i, by_d));
                let e = moving(e, &along(n, i, by_e));
                let h = Tangent::splat(self.h);
                let rows = self.declaration.declared(h, leg.any(), &e, &[]);
                for (size, row) in sizes.iter_mut().zip(rows) {
                    *size += row.derivative().abs();
                }
            }
        }
        let gaps = rows.iter().zip(sizes).take(count);
        let mut positions: Vec<PartError> = gaps
            .map(|(row, size)| PartError {
                difference: row.lane(0),
                size,
                rounding: INPUTS * row.error(),
            })
            .collect();
        let mut velocities = positions.split_off(holonomic.min(positions.len()));
        let accelerations = velocities.split_off(nonholonomic.min(velocities.len()));
        [positions, velocities, accelerations]
    }

    /// The works along `D_V` of the true constraint force, and of the discrete one.
    fn works(&self) -> [Vec<PartError>; 2] {
        let force = &self.force;
        let constraints: usize = self.declaration.constraints().iter().sum();
        if constraints == 0 {
            let alone = self.coordinates().map(|i| PartError {
                difference: self.discrete[i].lane(0),
                size: self.sizes[i],
                rounding: INPUTS * self.discrete[i].error(),
            });
            return [Vec::new(), alone.collect()];
        }
        let (leg, e) = (self.triple.first().map(Bounded::splat), bounded(&self.triple.e));
        let h = Bounded::splat(self.h);
        if self.declaration.has_multipliers() {
            let forms = self.declaration.forms(h, leg.any(), &e);
            return [force, &self.discrete].map(|force| {
                let rest = left(force, &forms);
                let gap = |i: usize| PartError {
                    difference: rest[i].value,
                    size: self.sizes[i],
                    rounding: INPUTS * rest[i].error,
                };
                self.coordinates().map(gap).collect()
            });
        }
        let fields = self.declaration.fields(h, leg.any(), &e);
        [force, &self.discrete].map(|force| {
            let work = |field: &Vec<Bounded>| {
                let terms = field.iter().zip(force);
                let work = terms.fold(Bounded::splat(0.0), |sum, (&u, &force)| sum + u * force);
                let terms = field.iter().zip(&self.sizes);
                PartError {
                    difference: work.lane(0),
                    size: terms.map(|(u, size)| u.lane(0).abs() * size).sum(),
                    rounding: INPUTS * work.error(),
                }
            };
            fields.iter().map(work).collect()
        })
    }
}

/// The residual `Q − Σ λ_j α_j` of a force with the best-fitting multipliers.
fn left(force: &[Bounded], forms: &[Vec<Bounded>]) -> Vec<ResidualComponent> {
    let value = |x: &[Bounded]| -> Vec<f64> { x.iter().map(|x| x.lane(0)).collect() };
    let values: Vec<Vec<f64>> = forms.iter().map(|form| value(form)).collect();
    let multipliers = multipliers(&value(force), &values);
    let rest = |(i, force): (usize, &Bounded)| {
        let mut rest = *force;
        for (form, &multiplier) in forms.iter().zip(&multipliers) {
            rest = rest - form[i] * Bounded::splat(multiplier);
        }
        ResidualComponent {
            value: rest.lane(0),
            error: rest.error(),
        }
    };
    force.iter().enumerate().map(rest).collect()
}
