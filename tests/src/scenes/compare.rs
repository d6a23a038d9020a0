//! Compares a declared system with its scene.

use dsocs_core::__private::Declaration;
use dsocs_core::{Flow, Leg as DeclaredLeg, Start, Stepper as _, System};

use super::discrete::{Leg, Step};
use super::double::{Double, PRECISION};
use super::elimination::Decomposed;
use super::exact::{Exact, PERTURBATION, PERTURBED_MOTIONS, UNIT, keep_larger};
use super::random::{Case, Random};
use crate::tape;

/// The end of a comparison whose run was refused because two solutions were found and neither was chosen.
const AMBIGUOUS: &str = "ambiguous";

/// A node this many roundings away belongs to another motion.
const ANOTHER_MOTION: f64 = 1e8;

/// The number of legs at which the equations are compared.
const COMPARED_LEGS: usize = 3;

/// The result of a comparison. Distances are in units of rounding (see [`compare`]).
#[derive(Clone, Debug, Default)]
pub struct Comparison {
    /// The largest distance of the constraint force and of the constraints, at random triples.
    pub rows: f64,
    /// The largest distance of the root of the declared rows, in twice the precision, from that of the second
    /// formulation, relative to the natural sizes of the unknowns.
    pub root: f64,
    /// The largest distance of the Jacobian from central differences of the rows in twice the precision.
    pub jacobian: f64,
    /// The largest distance of a node after one step from a random leg.
    pub node: f64,
    /// The largest distance of the nodes of a run.
    pub path: f64,
    /// The number of steps of the run that were compared.
    pub steps: usize,
    /// The largest number of evaluations in a step.
    pub evaluations: u32,
    /// Defects, in words: refusals where the second formulation has a solution, and other differences.
    pub defects: Vec<String>,
    /// The reason why the comparison ended early without a defect.
    pub ended: Option<String>,
}

/// The largest distance of rows, nodes and runs, in units of rounding. A row is a sum of some dozen terms,
/// each of some rounded products.
const ROUNDINGS: f64 = 32.0;

/// The largest distance of the declared root, relative to the natural sizes: combinations of parameters are
/// computed in single precision, all else in twice the precision.
const ROOT_DISTANCE: f64 = 1e-14;

/// The largest distance of the Jacobian, in units of its row's rounding. It decides how fast the iteration
/// converges, not to which root. An entry that is a difference of distant positions (a short rod far from the
/// origin) has fewer digits than its row.
const JACOBIAN_DISTANCE: f64 = 1e6;

impl Comparison {
    /// Refusals, and figures beyond their limits.
    #[must_use]
    pub fn wrong(&self) -> Vec<String> {
        let mut wrong = self.defects.clone();
        for (name, figure, bar) in [
            ("rows", self.rows, ROUNDINGS),
            ("root", self.root, ROOT_DISTANCE),
            ("Jacobian", self.jacobian, JACOBIAN_DISTANCE),
            ("node", self.node, ROUNDINGS),
            ("path", self.path, ROUNDINGS),
        ] {
            if figure > bar || figure.is_nan() {
                wrong.push(format!("{name}: {figure:.1e}, at most {bar:.0e}"));
            }
        }
        wrong
    }

    /// Whether the run was refused for two solutions where the second formulation has one nearby.
    #[must_use]
    pub fn is_ambiguous(&self) -> bool {
        self.ended
            .as_ref()
            .is_some_and(|words| words.starts_with(AMBIGUOUS))
    }

    /// Takes the larger of each figure of two scenes, and the sum of their steps.
    pub fn join(&mut self, other: &Self) {
        keep_larger(&mut self.rows, other.rows);
        keep_larger(&mut self.root, other.root);
        keep_larger(&mut self.jacobian, other.jacobian);
        keep_larger(&mut self.node, other.node);
        keep_larger(&mut self.path, other.path);
        self.steps += other.steps;
        self.evaluations = self.evaluations.max(other.evaluations);
    }
}

/// Compares a system with its scene: the start, the equations at random legs, and a run of `steps` steps.
///
/// A row is known to `u T` with the unit roundoff `u` and the sizes `T` of its terms ([`Step::terms`]), so an
/// unknown is known to `u S`, `S = |J⁻¹| T`. After several steps the effect is measured: perturbed motions
/// are computed whose rows are wrong by `σ T` and whose parameters by `σ`, at random, with `σ` = 1e-11. The
/// unit for a node is the largest distance of these motions times `u/σ`, plus its own last place.
pub fn compare<S: System<N>, const N: usize>(system: &S, case: &Case, steps: usize, seed: u64) -> Comparison {
    let mut found = Comparison::default();
    let mut random = Random::new(seed);
    let array = |x: &[f64]| -> [f64; N] { core::array::from_fn(|i| x.get(i).copied().unwrap_or(f64::NAN)) };
    let (q0, v0, q1) = (array(&case.q0), array(&case.v0), array(&case.q1));
    if let Err(error) = Flow::new(system, case.h, Start::second_order(q0, v0)) {
        found.defects.push(format!("start: {error}"));
    }
    let start = Leg::between(&case.q0, &case.q1);
    equations(system, case, &start, &mut random, &mut found);
    let flow = match Flow::new(system, case.h, Start::nodes(q0, q1)) {
        Ok(flow) => flow,
        Err(error) => {
            found.defects.push(format!("nodes: {error}"));
            return found;
        }
    };
    run(flow, case, start, steps, &mut random, &mut found);
    found
}

/// The numbers, rounded to `f64`.
fn rounded<const N: usize>(x: &[Double]) -> [f64; N] {
    core::array::from_fn(|i| x.get(i).map_or(f64::NAN, |x| x.high))
}

/// Compares the equations, at the leg of the start and along the exact motion.
fn equations<S: System<N>, const N: usize>(
    system: &S,
    case: &Case,
    start: &Leg,
    random: &mut Random,
    found: &mut Comparison,
) {
    let mut leg = start.clone();
    for place in 0..COMPARED_LEGS {
        let step = Step {
            scene: &case.scene,
            h: case.h,
            leg: &leg,
        };
        let Some(solution) = step.continuous().and_then(|guess| step.solve(&guess)) else {
            return;
        };
        let terms = step.terms(&solution.z, &solution.jacobian);
        let spread = solution.decomposed.spread(&terms);
        // a triple that is no solution
        let aside: Vec<Double> = (0..N)
            .map(|i| {
                solution.z[i]
                    + Double::exact(random.between(-0.1, 0.1) * (spread[i] + solution.z[i].high.abs()))
            })
            .collect();
        triple(system, &step, &aside, random, found);
        root(system, &step, &solution.z, &spread, found);
        derivatives(system, &step, &solution.z, &spread, random, found);
        if place + 1 < COMPARED_LEGS {
            leg = leg.next(&solution.z[..N]);
            leg = Leg::between(&rounded::<N>(&back(&leg)), &rounded::<N>(&leg.q));
        }
    }
}

/// The node before a leg.
fn back(leg: &Leg) -> Vec<Double> {
    leg.q.iter().zip(&leg.d).map(|(q, d)| *q - *d).collect()
}

/// Compares forces and constraints at a triple.
fn triple<S: System<N>, const N: usize>(
    system: &S,
    step: &Step<'_>,
    e: &[Double],
    random: &mut Random,
    found: &mut Comparison,
) {
    let (e, leg) = (rounded::<N>(e), declared_leg(step));
    if let Err(differs) = tape::same_bits(system, step.h, &leg, &e, &[]) {
        found.defects.push(format!("tape: {differs}"));
    }
    let exact: Vec<Double> = e.iter().copied().map(Double::exact).collect();
    let mut z = exact.clone();
    z.resize(step.unknowns(), Double::ZERO);
    let rows = step.rows(&z);
    let mut terms = step.terms(&z, &step.jacobian(&z, &rows));
    // the precision of the third node in this formulation, which the increments are differences of
    let reached = step.jacobian(&z, &rows);
    for (term, row) in terms.iter_mut().zip(&reached) {
        let nodes = row.iter().zip(&step.leg.q);
        *term += nodes.map(|(x, q)| (x.high * q.high).abs()).sum::<f64>() * (PRECISION / UNIT);
    }
    // and the rounding of combinations of parameters
    for _ in 0..PERTURBED_MOTIONS {
        let scene = step.scene.perturbed(PERTURBATION, random);
        let changed = Step {
            scene: &scene,
            ..*step
        }
        .rows(&z);
        for (term, (changed, row)) in terms.iter_mut().zip(changed.iter().zip(&rows)) {
            *term += ((*changed - *row).high / PERTURBATION).abs();
        }
    }
    let tape = Declaration::of(system);
    let force = tape.force(step.h, leg.any(), &e);
    let constraints = tape.declared(step.h, leg.any(), &e, &[]);
    let expected = step
        .action(&exact)
        .into_iter()
        .map(|x| -x)
        .chain(step.constraints(&exact));
    let rows = force.iter().chain(&constraints).zip(expected).zip(&terms);
    for (place, ((value, expected), term)) in rows.enumerate() {
        let distance = (Double::exact(*value) - expected).high.abs();
        let roundings = if distance == 0.0 {
            0.0
        } else {
            distance / (UNIT * term)
        };
        if roundings > ROUNDINGS {
            println!(
                "row {place}: {value:e} instead of {:e}, terms {term:e}",
                expected.high
            );
        }
        keep_larger(&mut found.rows, roundings);
    }
}

/// The leg of a step in the form of the generated code.
fn declared_leg<const N: usize>(step: &Step<'_>) -> DeclaredLeg<f64, N> {
    DeclaredLeg {
        t: 0.0,
        q: rounded(&step.leg.q),
        d: rounded(&step.leg.d),
    }
}

/// The generated rows and their Jacobian at some unknowns, in twice the precision.
fn linearize<S: System<N>, const N: usize>(
    system: &S,
    step: &Step<'_>,
    z: &[Double],
) -> (Vec<Double>, Vec<Vec<Double>>) {
    let array = |x: &[Double]| core::array::from_fn(|i| x.get(i).copied().unwrap_or(Double::ZERO));
    let leg = DeclaredLeg {
        t: Double::ZERO,
        q: array(&step.leg.q),
        d: array(&step.leg.d),
    };
    let constants = system.constants(&system.parameters(), Double::exact(step.h));
    let known = system.known(&constants, &leg);
    let mut unknown = system.unknown::<Double>(&[Double::ZERO; N], &[]);
    unknown.as_mut().copy_from_slice(z);
    let at = system.linearize(&constants, &known, &unknown);
    let jacobian = at.jacobian.as_ref().iter().map(|row| row.as_ref().to_vec());
    (at.rows.as_ref().to_vec(), jacobian.collect())
}

/// The unknowns of the generated code for those of the second formulation.
fn unknowns<S: System<N>, const N: usize>(system: &S, z: &[Double]) -> Vec<Double> {
    let e: [Double; N] = core::array::from_fn(|i| z[i]);
    system.unknown(&e, &z[N..]).as_ref().to_vec()
}

/// Compares the roots of the generated rows and of the second formulation.
fn root<S: System<N>, const N: usize>(
    system: &S,
    step: &Step<'_>,
    z: &[Double],
    spread: &[f64],
    found: &mut Comparison,
) {
    let own = unknowns(system, z);
    let sizes = unknowns(
        system,
        &spread.iter().copied().map(Double::exact).collect::<Vec<_>>(),
    );
    let (rows, jacobian) = linearize(system, step, &own);
    let Some(decomposed) = Decomposed::new(jacobian) else {
        found
            .defects
            .push("singular where the second formulation is not".into());
        return;
    };
    for (update, size) in decomposed.solve(&rows).iter().zip(&sizes) {
        let distance = update.high.abs();
        keep_larger(
            &mut found.root,
            if distance == 0.0 {
                0.0
            } else {
                distance / size.high.abs()
            },
        );
    }
}

/// Compares the generated Jacobian with differences of the generated rows, at a point near the root.
fn derivatives<S: System<N>, const N: usize>(
    system: &S,
    step: &Step<'_>,
    z: &[Double],
    spread: &[f64],
    random: &mut Random,
    found: &mut Comparison,
) {
    let sizes = unknowns(
        system,
        &spread.iter().copied().map(Double::exact).collect::<Vec<_>>(),
    );
    let sizes: Vec<f64> = sizes.iter().map(|size| size.high.abs()).collect();
    let aside: Vec<Double> = unknowns(system, z)
        .iter()
        .zip(&sizes)
        .map(|(z, size)| Double::exact(z.high + random.between(-0.01, 0.01) * size))
        .collect();
    let constants = system.constants(&system.parameters(), step.h);
    let known = system.known(&constants, &declared_leg(step));
    let mut unknown = system.unknown::<f64>(&[0.0; N], &[]);
    for (unknown, z) in unknown.as_mut().iter_mut().zip(&aside) {
        *unknown = z.high;
    }
    let own = system.linearize(&constants, &known, &unknown).jacobian;
    let columns: Vec<Vec<f64>> = (0..aside.len())
        .map(|j| {
            let nudge = Double::exact(1e-10 * if sizes[j] > 0.0 { sizes[j] } else { 1.0 });
            let mut ends = [aside.clone(), aside.clone()];
            ends[0][j] = aside[j] - nudge;
            ends[1][j] = aside[j] + nudge;
            let [before, after] = ends.map(|z| linearize(system, step, &z).0);
            let pairs = after.iter().zip(&before);
            pairs
                .map(|(after, before)| ((*after - *before) / (nudge + nudge)).high)
                .collect()
        })
        .collect();
    for (i, row) in own.as_ref().iter().enumerate() {
        let row = row.as_ref();
        let size: f64 = (0..sizes.len()).map(|j| columns[j][i].abs() * sizes[j]).sum();
        for (j, entry) in row.iter().enumerate() {
            let distance = (entry - columns[j][i]).abs() * sizes[j];
            keep_larger(
                &mut found.jacobian,
                if distance == 0.0 {
                    0.0
                } else {
                    distance / (UNIT * size)
                },
            );
        }
    }
}

/// Compares a run with the exact motion.
fn run<const N: usize>(
    mut flow: Flow<'_, N>,
    case: &Case,
    start: Leg,
    steps: usize,
    random: &mut Random,
    found: &mut Comparison,
) {
    let mut exact = Exact::new(case, start, random);
    for k in 0..steps {
        let (solution, resolved) = exact.solution();
        let ours = flow.advance();
        let ambiguous = |words: &str| words.contains("no unique solution");
        let solution = match (solution, ours) {
            (Some(solution), Ok(report)) if resolved => {
                found.evaluations = found.evaluations.max(report.iterations);
                solution
            }
            (Some(_), Err(error)) => {
                let words = error.to_string();
                // two roots of a Lyapunov constraint may be too close for any method
                if resolved && !(ambiguous(&words) && case.scene.motor.is_some()) {
                    found.defects.push(format!("refused at step {k}: {words}"));
                } else {
                    let kind = if resolved { AMBIGUOUS } else { "strained" };
                    found.ended = Some(format!("{kind}: refused at step {k}: {words}"));
                }
                return;
            }
            (solution, ours) => {
                let [plain, own] = [solution.is_some(), ours.is_ok()];
                found.ended = Some(format!("step {k} is too long: plain solution {plain}, own {own}"));
                return;
            }
        };
        if !exact.advance(solution, random) {
            found.ended = Some(format!(
                "step {k}: perturbations grow to {:.1e}",
                largest(&exact.condition)
            ));
            return;
        }
        let leg = &exact.leg;
        let mut worst = 0.0;
        for (i, (q, unit)) in flow.position().iter().zip(exact.units()).enumerate() {
            let distance = (Double::exact(*q) - leg.q[i]).high.abs();
            keep_larger(&mut worst, if distance == 0.0 { 0.0 } else { distance / unit });
        }
        keep_larger(&mut found.path, worst);
        found.steps = k + 1;
        if k == 0 {
            keep_larger(&mut found.node, worst);
        }
        if worst > ANOTHER_MOTION {
            let (ours, last) = (flow.leg(), rounded::<N>(&leg.q));
            let words = format!(
                "step {k}: another root, {:?} after {:?}; expected {last:?}",
                ours.q, ours.d
            );
            found.defects.push(words);
            return;
        }
    }
}

/// The largest number; NaN if one is.
fn largest(x: &[f64]) -> f64 {
    let mut largest = 0.0;
    for &x in x {
        keep_larger(&mut largest, x);
    }
    largest
}
