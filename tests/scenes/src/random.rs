//! Random scenes and states, the same in every run.

use core::f64::consts::PI;

use super::discrete::{Leg, Step};
use super::double::Double;
use super::elimination::Decomposed;
use super::scene::{Base, Body, Law, Map, Motor, Rod, Scene, Spring, Wheel};

/// Random numbers (`SplitMix64`: G. L. Steele, D. Lea, C. H. Flood, OOPSLA 2014).
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// The sequence of a seed.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x2545_f491_4f6c_dd1d))
    }

    /// The next 64 bits.
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        bits ^ (bits >> 31)
    }

    /// A number between two others, uniformly distributed.
    pub fn between(&mut self, least: f64, most: f64) -> f64 {
        let part = (self.bits() >> 11) as f64 / (1_u64 << 53) as f64;
        least + (most - least) * part
    }

    /// A number between two others, with uniformly distributed logarithm.
    pub fn decades(&mut self, least: f64, most: f64) -> f64 {
        self.between(least.ln(), most.ln()).exp()
    }

    /// A whole number below `count`.
    pub fn below(&mut self, count: usize) -> usize {
        usize::try_from(self.bits() % count.max(1) as u64).unwrap_or(0)
    }

    /// Whether an event of this probability happens.
    pub fn chance(&mut self, probability: f64) -> bool {
        self.between(0.0, 1.0) < probability
    }
}

/// A scene with a state and a step.
#[derive(Clone, Debug)]
pub struct Case {
    /// The scene.
    pub scene: Scene,
    /// The step.
    pub h: f64,
    /// The first node.
    pub q0: Vec<f64>,
    /// The velocity there.
    pub v0: Vec<f64>,
    /// The second node.
    pub q1: Vec<f64>,
}

/// The largest number of times that a step is shortened.
const SHORTER: usize = 12;

/// Masses [kg] and lengths \[m\] span four decades.
const SPAN: (f64, f64) = (0.01, 100.0);

/// The gravity of most scenes [m/s²].
const GRAVITY: f64 = 9.81;

/// An empty scene.
fn empty(coordinates: usize, map: Map, random: &mut Random) -> Scene {
    Scene {
        coordinates,
        map,
        gravity: if random.chance(0.8) { GRAVITY } else { 0.0 },
        bodies: Vec::new(),
        inertias: Vec::new(),
        springs: Vec::new(),
        rods: Vec::new(),
        wheels: Vec::new(),
        motor: None,
    }
}

/// A mass or a length.
fn size(random: &mut Random) -> f64 {
    random.decades(SPAN.0, SPAN.1)
}

/// Masses or lengths; in a quarter of the cases they are all equal, as in systems that people write.
fn sizes(count: usize, random: &mut Random) -> Vec<f64> {
    if random.chance(0.25) {
        return vec![size(random); count];
    }
    (0..count).map(|_| size(random)).collect()
}

/// A tree of rods with coordinates that are angles, hanging from the origin.
#[must_use]
pub fn tree(count: usize, map: Map, random: &mut Random) -> Scene {
    let mut scene = empty(count, map, random);
    let (masses, lengths) = (sizes(count, random), sizes(count, random));
    let is_chain = random.chance(0.4);
    for (i, (mass, length)) in masses.into_iter().zip(lengths).enumerate() {
        let base = if i == 0 || (!is_chain && random.chance(0.1)) {
            Base::Ground
        } else if is_chain {
            Base::Body(i - 1)
        } else {
            Base::Body(random.below(i))
        };
        scene.bodies.push(Body {
            base,
            rod: Some((i, length)),
            mass,
        });
        if random.chance(0.3) {
            let inertia = mass * length * length * random.decades(1e-3, 1.0);
            scene.inertias.push((i, inertia));
        }
        if random.chance(0.4) {
            let other = (i > 0 && random.chance(0.8)).then(|| random.below(i));
            scene.springs.push(Spring::Twist {
                ends: (i, other),
                stiffness: mass * length * GRAVITY * random.decades(0.01, 100.0),
                rest: random.between(-1.0, 1.0),
            });
        }
    }
    scene
}

/// A joint of a tree: an angle, and that of the rod on which its rod hangs.
#[must_use]
pub fn joint(scene: &Scene, random: &mut Random) -> (usize, Option<usize>) {
    let one = random.below(scene.bodies.len());
    match scene.bodies[one].base {
        Base::Body(base) => (one, Some(base)),
        _ => (one, None),
    }
}

/// A tree with a motor in one joint, or between two angles.
#[must_use]
pub fn robot(mut scene: Scene, joint: (usize, Option<usize>), lyapunov: bool, random: &mut Random) -> Scene {
    let rate = 1.0 / time(&scene);
    let weight: f64 = scene
        .bodies
        .iter()
        .map(|body| body.mass * length(body).powi(2))
        .sum();
    let law = if lyapunov {
        Law::Lyapunov {
            rho: weight * rate * random.decades(1e-3, 1.0),
        }
    } else {
        Law::Servo {
            rate: rate * random.decades(0.1, 3.0),
            damping: random.between(0.0, 1.5),
            target: random.between(-2.0, 2.0),
        }
    };
    scene.motor = Some(Motor { joint, law });
    scene
}

/// Points in Cartesian coordinates, `x` of all and then `y` of all, with rods and springs between them; and
/// their positions.
#[must_use]
pub fn linkage(count: usize, rods: usize, map: Map, random: &mut Random) -> (Scene, Vec<f64>) {
    let mut scene = empty(2 * count, map, random);
    let mut q = vec![0.0; 2 * count];
    let (masses, lengths) = (sizes(count, random), sizes(count, random));
    let hangs = random.chance(0.7);
    for (i, mass) in masses.into_iter().enumerate() {
        scene.bodies.push(Body {
            base: Base::Free(i, count + i),
            rod: None,
            mass,
        });
        let other = match i {
            0 if hangs => None,
            0 => {
                // it is free, so it is placed away from the origin
                (q[0], q[count]) = (lengths[0], -lengths[0]);
                continue;
            }
            _ if hangs && random.chance(0.2) => None,
            _ => Some(random.below(i)),
        };
        let (x, y) = other.map_or((0.0, 0.0), |other| (q[other], q[count + other]));
        let angle = random.between(-PI, PI);
        (q[i], q[count + i]) = (x + lengths[i] * angle.sin(), y - lengths[i] * angle.cos());
        if scene.rods.len() < rods {
            scene.rods.push(Rod {
                ends: (i, other),
                length: lengths[i],
            });
        } else {
            scene.springs.push(Spring::Line {
                ends: (i, other),
                stiffness: mass * GRAVITY / lengths[i] * random.decades(0.1, 100.0),
                rest: lengths[i] * random.between(0.5, 1.5),
            });
        }
    }
    // remaining rods close loops: from a point to another one
    while scene.rods.len() < rods {
        let one = random.below(count);
        let other = (one > 0).then(|| random.below(one));
        let ends = (one, other);
        if scene.rods.iter().any(|rod| rod.ends == ends) {
            continue;
        }
        let (x, y) = other.map_or((0.0, 0.0), |other| (q[other], q[count + other]));
        scene.rods.push(Rod {
            ends,
            length: (q[one] - x).hypot(q[count + one] - y),
        });
    }
    (scene, q)
}

/// A train: a lead with a rolling wheel, and trailers with wheels. The coordinates are the lead's position,
/// the angles of all, and the rotation of its wheel.
#[must_use]
pub fn train(count: usize, is_chain: bool, map: Map, random: &mut Random) -> Scene {
    let mut scene = empty(count + 3, map, random);
    if random.chance(0.7) {
        scene.gravity = 0.0; // it drives on a plane; else on a wall
    }
    let (masses, lengths) = (sizes(count, random), sizes(count, random));
    for (i, mass) in masses.into_iter().enumerate() {
        let length = lengths[i];
        scene.bodies.push(if i == 0 {
            Body {
                base: Base::Free(0, 1),
                rod: None,
                mass,
            }
        } else {
            Body {
                base: Base::Body(if is_chain { i - 1 } else { random.below(i) }),
                rod: Some((2 + i, length)),
                mass,
            }
        });
        scene
            .inertias
            .push((2 + i, mass * length * length * random.decades(1e-2, 1.0)));
        if i > 0 && random.chance(0.6) {
            scene.springs.push(Spring::Twist {
                ends: (2 + i, Some(2 + random.below(i))),
                stiffness: mass * length * GRAVITY * random.decades(0.01, 10.0),
                rest: random.between(-0.5, 0.5),
            });
        }
        let radius = length * random.between(0.05, 0.5);
        if i == 0 {
            scene.inertias.push((2 + count, mass * radius * radius / 2.0));
        }
        scene.wheels.push(Wheel {
            body: i,
            angle: 2 + i,
            rolls: (i == 0).then_some((2 + count, radius)),
        });
    }
    scene
}

/// The length of a body's rod; 1 without a rod.
fn length(body: &Body) -> f64 {
    body.rod.map_or(1.0, |(_, length)| length)
}

/// The time in which a pendulum of the mean length moves by a radian.
#[must_use]
pub fn time(scene: &Scene) -> f64 {
    let lengths = scene.bodies.iter().map(|body| length(body).ln());
    let rods = scene.rods.iter().map(|rod| rod.length.ln());
    let count = scene.bodies.len() + scene.rods.len();
    let mean = (lengths.sum::<f64>() + rods.sum::<f64>()) / count as f64;
    (mean.exp() / GRAVITY).sqrt()
}

impl Case {
    /// A state and a step for a scene. `place` are Cartesian coordinates; angles are drawn. `None` if no
    /// consistent state was found nearby.
    #[must_use]
    pub fn new(scene: &Scene, place: Option<&[f64]>, random: &mut Random) -> Option<Self> {
        let n = scene.coordinates;
        let time = time(scene);
        let mut h = time * random.decades(1e-3, 0.1);
        let swing = if random.chance(0.2) { 0.1 } else { 2.0 };
        let brakes = matches!(scene.motor.map(|motor| motor.law), Some(Law::Lyapunov { .. }));
        // at rest a Lyapunov constraint is degenerate
        let at_rest = random.chance(0.25) && !brakes;
        let alike = random.chance(0.2).then(|| random.between(-swing, swing));
        let mut draw = |i: usize| match place {
            Some(place) => place[i],
            None => alike.unwrap_or_else(|| random.between(-swing, swing)),
        };
        let q0: Vec<f64> = (0..n).map(&mut draw).collect();
        let reach = scene
            .rods
            .iter()
            .fold(0.0_f64, |reach, rod| reach.max(rod.length));
        let fast = random.decades(0.1, 3.0) / time * if reach > 0.0 { reach } else { 1.0 };
        let v0: Vec<f64> = (0..n)
            .map(|_| if at_rest { 0.0 } else { random.between(-fast, fast) })
            .collect();
        for _ in 0..SHORTER {
            let case = Self::consistent(scene, h, &q0, &v0)?;
            if case.is_resolved() {
                return Some(case);
            }
            h /= 3.0;
        }
        None
    }

    /// Whether the first step is short enough for its equations to be nearly linear: it then has one solution
    /// nearby.
    fn is_resolved(&self) -> bool {
        let leg = Leg::between(&self.q0, &self.q1);
        let step = Step {
            scene: &self.scene,
            h: self.h,
            leg: &leg,
        };
        step.continuous().is_some_and(|guess| step.is_resolved(&guess))
    }

    /// The nearest state on the constraints, and the node after it.
    fn consistent(scene: &Scene, h: f64, q0: &[f64], v0: &[f64]) -> Option<Self> {
        let (n, lower) = (scene.coordinates, scene.lower());
        let exact = |x: &[f64]| x.iter().copied().map(Double::exact).collect::<Vec<_>>();
        let rounded = |x: &[Double]| x.iter().map(|x| x.high).collect::<Vec<_>>();
        let (q, v) = (exact(q0), exact(v0));
        let forms = scene.forms(&q, &v);
        let forms = &forms[..lower];
        let along = |multipliers: &[Double]| -> Vec<Double> {
            let pairs = forms.iter().zip(multipliers);
            pairs.fold(vec![Double::ZERO; n], |mut sum, (form, by)| {
                for (sum, form) in sum.iter_mut().zip(form) {
                    *sum = *sum + *form * *by;
                }
                sum
            })
        };
        // the constraints are linear in the velocity
        let product =
            |x: &[Double], y: &[Double]| x.iter().zip(y).fold(Double::ZERO, |sum, (x, y)| sum + *x * *y);
        let v = if lower == 0 {
            v
        } else {
            let gram = forms
                .iter()
                .map(|x| forms.iter().map(|y| product(x, y)).collect());
            let violated: Vec<Double> = forms.iter().map(|form| product(form, &v)).collect();
            let multipliers = Decomposed::new(gram.collect())?.solve(&violated);
            v.iter()
                .zip(along(&multipliers))
                .map(|(v, away)| *v - away)
                .collect()
        };
        let straight: Vec<Double> = q
            .iter()
            .zip(&v)
            .map(|(q, v)| *q + *v * Double::exact(h))
            .collect();
        let leg = Leg {
            q: q.clone(),
            d: vec![Double::ZERO; n],
        };
        let step = Step { scene, h, leg: &leg };
        let moved = |multipliers: &[Double]| -> Vec<Double> {
            let away = along(multipliers);
            straight.iter().zip(away).map(|(q, away)| *q - away).collect()
        };
        let mut multipliers = vec![Double::ZERO; lower];
        for _ in 0..20 {
            if lower == 0 {
                break;
            }
            let rows = step.pair(&q, &moved(&multipliers));
            let mut jacobian = vec![vec![Double::ZERO; lower]; lower];
            for j in 0..lower {
                // the nudge of a multiplier is scaled by the distance that it moves a node from the start
                let reach = product(&forms[j], &forms[j]).high.sqrt();
                let nudge = Double::exact(1e-14 * h / reach);
                let mut nudged = multipliers.clone();
                nudged[j] = nudged[j] + nudge;
                for (i, row) in step.pair(&q, &moved(&nudged)).into_iter().enumerate() {
                    jacobian[i][j] = (row - rows[i]) / nudge;
                }
            }
            let update = Decomposed::new(jacobian)?.solve(&rows);
            for (multiplier, update) in multipliers.iter_mut().zip(update) {
                *multiplier = *multiplier - update;
            }
        }
        let q1 = moved(&multipliers);
        let worst = step
            .pair(&q, &q1)
            .iter()
            .fold(0.0_f64, |worst, row| worst.max(row.high.abs()));
        let size = q1.iter().fold(0.0_f64, |size, q| size.max(q.high.abs()));
        // refuses NaN, too
        (worst <= 1e-20 * (1.0 + size * size) / h).then(|| Self {
            h,
            q0: q0.to_vec(),
            v0: rounded(&v),
            q1: rounded(&q1),
            scene: scene.clone(),
        })
    }
}
