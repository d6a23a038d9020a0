//! The exact motion of a scene, and the effect of rounding on it.

use super::discrete::{Leg, Solution, Step};
use super::double::Double;
use super::random::{Case, Random};
use super::scene::Scene;

/// The unit roundoff of `f64`.
pub const UNIT: f64 = f64::EPSILON / 2.0;

/// The relative size of the perturbations that measure the condition of a motion.
pub const PERTURBATION: f64 = 1e-11;

/// The number of perturbed motions.
pub const PERTURBED_MOTIONS: u64 = 2;

/// Replaces a figure by a larger value or by NaN.
pub fn keep_larger(figure: &mut f64, value: f64) {
    // a figure that is NaN stays NaN
    if value > *figure || value.is_nan() {
        *figure = value;
    }
}

/// A perturbed motion: its scene and its last leg.
struct PerturbedMotion {
    scene: Scene,
    leg: Leg,
}

/// The exact motion, step by step, with perturbed motions that measure its condition.
pub struct Exact<'a> {
    case: &'a Case,
    /// The last leg.
    pub leg: Leg,
    past: Vec<Vec<Double>>,
    twins: Vec<PerturbedMotion>,
    /// The largest change of each coordinate by the perturbations, relative to their size.
    pub condition: Vec<f64>,
}

impl<'a> Exact<'a> {
    /// The motion that begins with a leg.
    pub fn new(case: &'a Case, leg: Leg, random: &mut Random) -> Self {
        let twin = |_| PerturbedMotion {
            scene: case.scene.perturbed(PERTURBATION, random),
            leg: leg.clone(),
        };
        Self {
            case,
            twins: (0..PERTURBED_MOTIONS).map(twin).collect(),
            condition: vec![0.0; leg.q.len()],
            leg,
            past: Vec::new(),
        }
    }

    /// The next step.
    fn step(&self) -> Step<'_> {
        Step {
            scene: &self.case.scene,
            h: self.case.h,
            leg: &self.leg,
        }
    }

    /// The solution of the next step, and whether the step is short enough for it to be the only one nearby.
    #[must_use]
    pub fn solution(&self) -> (Option<Solution>, bool) {
        let step = self.step();
        let continuous = step.continuous();
        let resolved = continuous.as_ref().is_some_and(|guess| step.is_resolved(guess));
        // where the equations are nearly linear there is one solution nearby; elsewhere past solutions are
        // extrapolated
        let solution = match continuous.filter(|_| resolved || self.past.len() < 3) {
            Some(continuous) => step.solve(&continuous),
            None if self.past.len() < 3 => None,
            None => step.solve(&predicted(&self.past)),
        };
        (solution, resolved)
    }

    /// Makes the step with a solution; `false` where perturbations have grown so much that nothing can be
    /// compared any more.
    pub fn advance(&mut self, solution: Solution, random: &mut Random) -> bool {
        let n = self.leg.q.len();
        let terms = self.step().terms(&solution.z, &solution.jacobian);
        for twin in &mut self.twins {
            let step = Step {
                scene: &twin.scene,
                h: self.case.h,
                leg: &twin.leg,
            };
            let noise: Vec<Double> = terms
                .iter()
                .map(|term| Double::exact(PERTURBATION * term * random.between(-1.0, 1.0)))
                .collect();
            let mut z = solution.z.clone();
            for _ in 0..6 {
                let rows: Vec<Double> = step
                    .rows(&z)
                    .iter()
                    .zip(&noise)
                    .map(|(row, noise)| *row - *noise)
                    .collect();
                for (z, update) in z.iter_mut().zip(solution.decomposed.solve(&rows)) {
                    *z = *z - update;
                }
            }
            twin.leg = twin.leg.next(&z[..n]);
        }
        self.leg = self.leg.next(&solution.z[..n]);
        self.past.insert(0, solution.z);
        self.past.truncate(3);
        let legs = self.leg.d.iter();
        let longest = legs.fold(0.0_f64, |longest, d| longest.max(d.high.abs()));
        for (i, condition) in self.condition.iter_mut().enumerate() {
            for twin in &self.twins {
                let distance = (twin.leg.q[i] - self.leg.q[i]).high.abs();
                keep_larger(condition, distance / PERTURBATION);
            }
        }
        let grown = |condition: &f64| *condition * PERTURBATION > 0.01 * longest || condition.is_nan();
        !self.condition.iter().any(grown)
    }

    /// The effect of a unit roundoff on each coordinate of the last node.
    #[must_use]
    pub fn units(&self) -> Vec<f64> {
        let pairs = self.condition.iter().zip(&self.leg.q);
        pairs
            .map(|(condition, q)| UNIT * (condition + q.high.abs()))
            .collect()
    }
}

/// The last node of the exact motion after this many steps, and the effect of rounding on it; `None` where it
/// cannot be computed.
#[must_use]
pub fn exact(case: &Case, steps: usize) -> Option<[Vec<f64>; 2]> {
    let mut random = Random::new(0);
    let mut exact = Exact::new(case, Leg::between(&case.q0, &case.q1), &mut random);
    for _ in 0..steps {
        let (solution, resolved) = exact.solution();
        if !resolved || !exact.advance(solution?, &mut random) {
            return None;
        }
    }
    Some([exact.leg.q.iter().map(|q| q.high).collect(), exact.units()])
}

/// The extrapolation of the last three solutions by a quadratic polynomial.
fn predicted(past: &[Vec<Double>]) -> Vec<Double> {
    let three = Double::exact(3.0);
    let places = past[0].iter().zip(&past[1]).zip(&past[2]);
    places.map(|((a, b), c)| three * (*a - *b) + *c).collect()
}
