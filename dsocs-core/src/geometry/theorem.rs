//! The conditions of the paper's theorem on the discrete flow, at a triple.

use crate::kernel::Kernel;
use crate::number::point::AnyLeg;
use crate::regularity::lengths::lengths;
use crate::regularity::multipliers::count_unknown;
use crate::regularity::{self, Regularity};
use crate::step::NEARLY_THE_SAME;
use crate::tape::declaration::Declaration;

/// A singular value below this part of the largest counts as zero.
const RANK: f64 = 64.0 * f64::EPSILON;

/// The distance of a nearby point, relative to the legs.
const NEARBY: f64 = 1e-9;

/// The conditions of the discrete-flow theorem (paper, section 6) at a triple of nodes.
///
/// The theorem requires that `φ∘β` restricted to `D_K` has constant rank near the triple, and that its `D₁`
/// and `D₃` are injective on the tangent space of `D_K`. The equations of a step consist of the constraints
/// that define `D_K` and of the components of `β`. So the rank of their derivative is the codimension of
/// `D_K` plus the rank of `φ∘β` on `D_K`. If this rank is full, `D_K` is a submanifold there, and the rank of
/// `φ∘β` on it is full and therefore constant nearby. `D₁` and `D₃` of the equations are square, and
/// injective where they are regular ([`Regularity`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlowTheorem {
    /// The rank of the derivative of the equations with respect to all three nodes: that of the constraints plus that of `φ∘β` on `D_K`.
    pub rank: usize,
    /// The full rank: the number of coordinates plus the number of unknown multipliers.
    pub full: usize,
    /// The smallest singular value that counts for the rank, over the largest; in the units of [`Regularity`].
    pub margin: f64,
    /// `D₃` and `D₁`.
    pub regularity: Regularity,
    /// Whether the declared equations are defined here: no denominator vanishes, and no factor that was divided out of a row.
    pub declared: bool,
    /// Whether the equations have derivatives here, if they have values: a root of zero has none.
    pub differentiable: bool,
}

impl FlowTheorem {
    /// The conditions at the triple of a leg and the second difference `e`, with the step `h`.
    #[must_use]
    pub fn at(system: &dyn Kernel, h: f64, leg: AnyLeg<'_, f64>, e: &[f64]) -> Self {
        let declaration = Declaration::of(system);
        let fits = regularity::fit(&declaration, &[leg.q, leg.d, e]);
        let regularity = Regularity::of(system, h, leg, e);
        let mut values = if fits {
            regularity::all_singular_values(&declaration, h, leg, e)
        } else {
            Vec::new()
        };
        values.sort_by(|x, y| y.total_cmp(x));
        let largest = values.first().copied().unwrap_or(f64::NAN);
        let full = declaration.dimension() + count_unknown(&declaration);
        let rank = values.iter().take(full).filter(|value| **value > RANK * largest);
        Self {
            rank: rank.count(),
            full,
            margin: values.get(full - 1).map_or(f64::NAN, |value| value / largest),
            regularity,
            declared: fits && is_declared(&declaration, h, leg, e),
            differentiable: !values.is_empty() || !fits || !has_value(&declaration, h, leg, e),
        }
    }

    /// Whether the rank of `φ∘β` on `D_K` is constant near the triple: the theorem's first condition.
    #[must_use]
    pub fn has_constant_rank(&self) -> bool {
        self.rank == self.full
    }

    /// Whether the theorem grants a discrete flow here.
    #[must_use]
    pub fn grants_flow(&self) -> bool {
        self.declared && self.has_constant_rank() && self.regularity.grants_flow()
    }
}

/// Whether the rows have values.
fn has_value(declaration: &Declaration<'_>, h: f64, leg: AnyLeg<'_, f64>, e: &[f64]) -> bool {
    let multipliers = vec![0.0; declaration.shape().multipliers()];
    let rows = declaration.declared(h, leg, e, &multipliers);
    rows.iter().all(|row| row.is_finite())
}

/// Whether no factor of a row vanishes. A factor that vanishes differs at a nearby point by as much as its own size. The distance of that
/// point is relative to the legs.
fn is_declared(declaration: &Declaration<'_>, h: f64, leg: AnyLeg<'_, f64>, e: &[f64]) -> bool {
    let lengths = lengths(declaration, h, leg, e);
    let near: Vec<f64> = e
        .iter()
        .zip(&lengths)
        .map(|(e, length)| e + NEARBY * length)
        .collect();
    let scales = |e: &[f64]| declaration.scales(h, leg, &declaration.unknown(e, &[]));
    // false also for a NaN
    scales(e)
        .iter()
        .zip(&scales(&near))
        .all(|(here, there)| (here - there).abs() < NEARLY_THE_SAME * here.abs())
}
