//! What the checks ask of a system, whatever its type: this is made anew for every system, and the checks are not.

use dsocs_core::geometry::{
    self, DiscreteFlow, Displacement, Evolution, FlowTheorem, GeometryError, Triple, TwoForm, Variation,
};
use dsocs_core::{Flow, Leg, Point, SetupError, Start, Stepper, System, TaylorFlow, Tolerance};

use super::Measured;
use crate::entry::CheckFailure;

/// An infinitesimal generator of a symmetry.
pub type Generator<'a, const N: usize> = &'a dyn Fn(&[f64; N]) -> [f64; N];

/// A system with a step, on which the paper's theorems can be checked.
///
/// Methods are as the functions of [`dsocs_core::geometry`] that have their names.
pub trait Probe<const N: usize> {
    /// The step.
    fn h(&self) -> f64;

    /// The legs of the motion from `(q0, v0)` up to the time `until`, at least three.
    fn legs(&self, start: &[[f64; N]; 2], until: f64) -> Result<Vec<Leg<f64, N>>, CheckFailure>;

    /// The positions of the motion from `(q0, v0)` with a part of the step, at `count` multiples of the whole step.
    fn positions(&self, start: &[[f64; N]; 2], part: u32, count: usize) -> Measured<Vec<[f64; N]>>;

    /// The positions of the continuous motion at some times, to a tolerance.
    fn exact(&self, start: &[[f64; N]; 2], times: &[f64], tolerance: f64) -> Measured<Vec<[f64; N]>>;

    /// See [`DiscreteFlow::forward_near`].
    fn forward_near(&self, leg: &Leg<f64, N>, e: &[f64; N]) -> Result<Triple<N>, GeometryError>;

    /// See [`DiscreteFlow::backward`].
    fn backward(&self, last: &Leg<f64, N>) -> Result<Triple<N>, GeometryError>;

    /// See [`DiscreteFlow::irreversibility`].
    fn irreversibility(&self, triple: &Triple<N>) -> Result<f64, GeometryError>;

    /// See [`FlowTheorem::at`].
    fn theorem(&self, triple: &Triple<N>) -> FlowTheorem;

    /// See [`Evolution::of`].
    fn evolution(&self, triple: &Triple<N>) -> Result<Evolution<N>, GeometryError>;

    /// See [`geometry::pair_displacements`].
    fn pair_displacements(&self, leg: &Leg<f64, N>) -> Vec<Displacement<N>>;

    /// See [`geometry::state_displacements`].
    fn state_displacements(&self, q: &[f64; N], v: &[f64; N]) -> Vec<Displacement<N>>;

    /// See [`geometry::canonical_form`].
    fn canonical_form(&self, q: &[f64; N], v: &[f64; N]) -> TwoForm<N>;

    /// See [`geometry::motion`].
    fn motion(&self, q: [f64; N], v: [f64; N]) -> Result<Point<f64, N>, GeometryError>;

    /// See [`geometry::variation`].
    fn variation(&self, point: &Point<f64, N>, moved: &Displacement<N>) -> Option<Variation<N>>;

    /// See [`geometry::momentum_map`].
    fn momentum_map(&self, leg: &Leg<f64, N>, generator: Generator<'_, N>) -> f64;

    /// See [`geometry::asymmetry`].
    fn asymmetry(&self, leg: &Leg<f64, N>, generator: Generator<'_, N>) -> f64;

    /// See [`geometry::momentum_equation`].
    fn momentum_equation(&self, triple: &Triple<N>, generator: Generator<'_, N>) -> [f64; 2];

    /// See [`geometry::constraint_forms`].
    fn forms(&self, triple: &Triple<N>) -> Vec<[f64; N]>;
}

/// The probe of a system.
pub struct Typed<'a, S: System<N>, const N: usize> {
    /// The system.
    system: &'a S,
    /// The step as a map.
    flow: DiscreteFlow<'a, S, N>,
}

impl<'a, S: System<N>, const N: usize> Typed<'a, S, N> {
    /// The probe of a system and a step.
    pub fn new(system: &'a S, h: f64) -> Result<Self, GeometryError> {
        let flow = DiscreteFlow::new(system, h)?;
        Ok(Self { system, flow })
    }

    /// The motion from `(q0, v0)` with a step.
    fn flow(&self, [q0, v0]: &[[f64; N]; 2], h: f64) -> Result<Flow<'a, S, N>, SetupError> {
        Flow::new(self.system, h, Start::second_order(*q0, *v0))
    }
}

impl<S: System<N>, const N: usize> Probe<N> for Typed<'_, S, N> {
    fn h(&self) -> f64 {
        self.flow.h()
    }

    fn legs(&self, start: &[[f64; N]; 2], until: f64) -> Result<Vec<Leg<f64, N>>, CheckFailure> {
        let h = self.h();
        let mut flow = self.flow(start, h)?;
        let mut legs = vec![flow.leg()];
        while (flow.time() - until) * h.signum() < 0.0 || legs.len() < 3 {
            flow.advance()?;
            legs.push(flow.leg());
        }
        Ok(legs)
    }

    fn positions(&self, start: &[[f64; N]; 2], part: u32, count: usize) -> Measured<Vec<[f64; N]>> {
        let mut flow = self.flow(start, self.h() / f64::from(part))?;
        let mut positions = Vec::with_capacity(count);
        for node in 1..=count as u64 {
            while flow.index() < node * u64::from(part) {
                flow.advance()?;
            }
            positions.push(*flow.position());
        }
        Ok(positions)
    }

    fn exact(&self, [q0, v0]: &[[f64; N]; 2], times: &[f64], tolerance: f64) -> Measured<Vec<[f64; N]>> {
        let tolerance = Tolerance::relative(tolerance);
        let mut flow = TaylorFlow::new(self.system, Start::second_order(*q0, *v0), tolerance)?;
        if self.h() < 0.0 {
            flow.reverse()?;
        }
        let mut motion = Vec::with_capacity(times.len());
        flow.sample(times, &mut |_, point| motion.push(point.q))?;
        Ok(motion)
    }

    fn forward_near(&self, leg: &Leg<f64, N>, e: &[f64; N]) -> Result<Triple<N>, GeometryError> {
        self.flow.forward_near(leg, e)
    }

    fn backward(&self, last: &Leg<f64, N>) -> Result<Triple<N>, GeometryError> {
        self.flow.backward(last)
    }

    fn irreversibility(&self, triple: &Triple<N>) -> Result<f64, GeometryError> {
        self.flow.irreversibility(triple)
    }

    fn theorem(&self, triple: &Triple<N>) -> FlowTheorem {
        FlowTheorem::at(self.system, self.h(), &triple.leg, &triple.e)
    }

    fn evolution(&self, triple: &Triple<N>) -> Result<Evolution<N>, GeometryError> {
        Evolution::of(&self.flow, triple)
    }

    fn pair_displacements(&self, leg: &Leg<f64, N>) -> Vec<Displacement<N>> {
        geometry::pair_displacements(self.system, self.h(), leg)
    }

    fn state_displacements(&self, q: &[f64; N], v: &[f64; N]) -> Vec<Displacement<N>> {
        geometry::state_displacements(self.system, q, v)
    }

    fn canonical_form(&self, q: &[f64; N], v: &[f64; N]) -> TwoForm<N> {
        geometry::canonical_form(self.system, q, v)
    }

    fn motion(&self, q: [f64; N], v: [f64; N]) -> Result<Point<f64, N>, GeometryError> {
        geometry::motion(self.system, q, v)
    }

    fn variation(&self, point: &Point<f64, N>, moved: &Displacement<N>) -> Option<Variation<N>> {
        geometry::variation(self.system, point, moved)
    }

    fn momentum_map(&self, leg: &Leg<f64, N>, generator: Generator<'_, N>) -> f64 {
        geometry::momentum_map(&self.flow, leg, generator)
    }

    fn asymmetry(&self, leg: &Leg<f64, N>, generator: Generator<'_, N>) -> f64 {
        geometry::asymmetry(&self.flow, leg, generator)
    }

    fn momentum_equation(&self, triple: &Triple<N>, generator: Generator<'_, N>) -> [f64; 2] {
        geometry::momentum_equation(&self.flow, triple, generator)
    }

    fn forms(&self, triple: &Triple<N>) -> Vec<[f64; N]> {
        geometry::constraint_forms(self.system, self.h(), triple)
    }
}
