//! Scenes written out as declarations, as a person would write them.

use core::fmt::Write as _;

use super::random::{Case, Random, joint, linkage, robot, train, tree};
use super::scene::{Base, Law, Map, Scene, Spring};

/// A declaration: its text, and the values of its parameters.
#[derive(Clone, Debug, Default)]
pub struct Written {
    /// The body of the attribute.
    pub text: String,
    /// The parameters, the elements of the field `p`.
    pub parameters: Vec<f64>,
    /// Whether numbers are literals in the text.
    literal: bool,
}

impl Written {
    /// Writes a scene, with its numbers as parameters or as literals.
    #[must_use]
    pub fn new(scene: &Scene, literal: bool) -> Self {
        let mut written = Self {
            literal,
            ..Self::default()
        };
        // writing to a string does not fail
        let _ = written.scene(scene);
        written
    }

    /// A number.
    fn number(&mut self, value: f64) -> String {
        if self.literal {
            return format!("{value:?}");
        }
        self.parameters.push(value);
        format!("p[{}]", self.parameters.len() - 1)
    }

    #[allow(clippy::too_many_lines)] // statement by statement, as a declaration is read
    fn scene(&mut self, scene: &Scene) -> core::fmt::Result {
        let names: Vec<String> = (0..scene.coordinates).map(|i| format!("q{i}")).collect();
        writeln!(self.text, "coordinates({});", names.join(", "))?;
        let gravity = self.number(scene.gravity);
        let (mut kinetic, mut potential) = (Vec::new(), Vec::new());
        for (i, body) in scene.bodies.iter().enumerate() {
            let base = match body.base {
                Base::Ground => ["0.0".to_owned(), "0.0".to_owned()],
                Base::Body(base) => [format!("x{base}"), format!("y{base}")],
                Base::Free(x, y) => [format!("q{x}"), format!("q{y}")],
            };
            if let Some((angle, length)) = body.rod {
                let length = self.number(length);
                writeln!(self.text, "let x{i} = {} + {length} * q{angle}.sin();", base[0])?;
                writeln!(self.text, "let y{i} = {} - {length} * q{angle}.cos();", base[1])?;
            } else {
                writeln!(self.text, "let x{i} = {};\nlet y{i} = {};", base[0], base[1])?;
            }
            let mass = self.number(body.mass);
            kinetic.push(format!("{mass} / 2 * (dot(x{i}).powi(2) + dot(y{i}).powi(2))"));
            potential.push(format!("{mass} * {gravity} * y{i}"));
        }
        for &(coordinate, inertia) in &scene.inertias {
            let inertia = self.number(inertia);
            kinetic.push(format!("{inertia} / 2 * dot(q{coordinate}).powi(2)"));
        }
        for spring in &scene.springs {
            let (length, stiffness, rest) = match *spring {
                Spring::Twist {
                    ends,
                    stiffness,
                    rest,
                } => (difference('q', ends), stiffness, rest),
                Spring::Line {
                    ends,
                    stiffness,
                    rest,
                } => (
                    format!("({}).hypot({})", difference('x', ends), difference('y', ends)),
                    stiffness,
                    rest,
                ),
            };
            let (stiffness, rest) = (self.number(stiffness), self.number(rest));
            potential.push(format!("{stiffness} / 2 * ({length} - {rest}).powi(2)"));
        }
        writeln!(self.text, "let kinetic = {};", kinetic.join(" + "))?;
        writeln!(self.text, "let potential = {};", potential.join(" + "))?;
        writeln!(self.text, "lagrangian = kinetic - potential;")?;
        let mut rows = Vec::new();
        for rod in &scene.rods {
            let length = self.number(rod.length);
            let (x, y) = (difference('x', rod.ends), difference('y', rod.ends));
            rows.push(format!(
                "(({x}).powi(2) + ({y}).powi(2) - {length} * {length}) / 2"
            ));
        }
        if !rows.is_empty() {
            writeln!(self.text, "holonomic = [{}];", rows.join(", "))?;
        }
        rows.clear();
        for wheel in &scene.wheels {
            let (body, angle) = (wheel.body, wheel.angle);
            rows.push(format!(
                "q{angle}.cos() * dot(x{body}) + q{angle}.sin() * dot(y{body})"
            ));
            if let Some((roll, radius)) = wheel.rolls {
                let radius = self.number(radius);
                rows.push(format!(
                    "q{angle}.sin() * dot(x{body}) - q{angle}.cos() * dot(y{body}) - {radius} * dot(q{roll})"
                ));
            }
        }
        if !rows.is_empty() {
            writeln!(self.text, "nonholonomic = [{}];", rows.join(", "))?;
        }
        if let Some(motor) = scene.motor {
            writeln!(self.text, "let angle = {};", difference('q', motor.joint))?;
            let row = match motor.law {
                Law::Servo {
                    rate,
                    damping,
                    target,
                } => {
                    let [rate, damping, target] = [rate, damping, target].map(|x| self.number(x));
                    format!(
                        "ddot(angle) + 2 * {damping} * {rate} * dot(angle) + {rate} * {rate} * (angle - {target})"
                    )
                }
                Law::Lyapunov { rho } => {
                    format!(
                        "dot(kinetic + potential) + {} * dot(angle).powi(2)",
                        self.number(rho)
                    )
                }
            };
            let mut form = vec!["0"; scene.coordinates];
            form[motor.joint.0] = "1";
            if let Some(against) = motor.joint.1 {
                form[against] = "-1";
            }
            writeln!(
                self.text,
                "kinematic = {row};\nconstraint_forces = [({},)];",
                form.join(", ")
            )?;
        }
        let map = match scene.map {
            Map::Paper => "paper",
            Map::Midpoint => "midpoint",
            Map::Trapezoid => "trapezoid",
        };
        writeln!(self.text, "phi_lagrangian = {map};")
    }
}

/// The difference of two quantities, or the quantity alone.
fn difference(name: char, (one, other): (usize, Option<usize>)) -> String {
    match other {
        Some(other) => format!("({name}{one} - {name}{other})"),
        None => format!("{name}{one}"),
    }
}

/// The number of bodies in scene `number`: mostly few, since code grows with the square.
fn bodies(number: u64) -> usize {
    match number % 12 {
        3 => 8,
        7 => 6,
        11 if number == 23 => 16,
        other => 2 + (other % 4) as usize,
    }
}

/// Scene `number`; the kinds take turns.
#[must_use]
pub fn scene(number: u64) -> Scene {
    let mut random = Random::new(1000 + number);
    let random = &mut random;
    let count = bodies(number);
    let map = [Map::Midpoint, Map::Trapezoid][random.below(2)];
    match number % 4 {
        0 => {
            let rods = 1 + random.below(count);
            let map = [Map::Paper, map][random.below(2)];
            linkage(count, rods.min(count - 1), map, random).0
        }
        1 => train(count, false, map, random),
        2 => {
            let scene = tree(count, map, random);
            let joint = joint(&scene, random);
            let lyapunov = random.chance(0.5);
            robot(scene, joint, lyapunov, random)
        }
        _ => tree(count, map, random),
    }
}

/// Whether the numbers of scene `number` are literals in its text.
#[must_use]
pub fn is_literal(number: u64) -> bool {
    number % 3 == 2
}

/// A state of scene `number`; where its numbers are parameters, they vary with `variation`.
#[must_use]
pub fn case(number: u64, variation: u64) -> Option<Case> {
    let mut random = Random::new(100_000 + 1000 * number + variation);
    let scene = scene(number);
    let scene = if is_literal(number) {
        scene
    } else {
        scene.perturbed(0.5, &mut random)
    };
    let place = scene.rods.first().map(|_| scattered(&scene, &mut random));
    Case::new(&scene, place.as_deref(), &mut random)
}

/// Random positions of the points of a linkage whose rods form a tree: each point at its rod's end.
fn scattered(scene: &Scene, random: &mut Random) -> Vec<f64> {
    let count = scene.bodies.len();
    let mut q: Vec<f64> = (0..2 * count).map(|_| random.between(-1.0, 1.0)).collect();
    for rod in &scene.rods {
        let (one, other) = rod.ends;
        let (x, y) = other.map_or((0.0, 0.0), |other| (q[other], q[count + other]));
        let angle = random.between(-3.0, 3.0);
        (q[one], q[count + one]) = (x + rod.length * angle.sin(), y - rod.length * angle.cos());
    }
    q
}

/// A program that declares scenes and compares each with the second formulation, in some variations.
#[must_use]
pub fn program(numbers: core::ops::Range<u64>, variations: u64, steps: usize) -> String {
    let mut text = String::from(
        "//! Random scenes.\n\nuse dsocs_core::dsocs;\nuse dsocs_tests::scenes::{compare::compare, text};\n\n",
    );
    let mut main = String::from(
        "fn main() -> std::process::ExitCode {\n    let mut wrong = 0;\n    let mut all = dsocs_tests::scenes::compare::Comparison::default();\n",
    );
    for number in numbers {
        let scene = scene(number);
        let written = Written::new(&scene, is_literal(number));
        let count = written.parameters.len();
        let _ = writeln!(
            text,
            "#[dsocs {{\n{}}}]\nstruct Scene{number} {{\n    p: [f64; {count}],\n}}\n",
            written.text
        );
        let _ = writeln!(
            main,
            "    for variation in 0..{variations} {{\n        let Some(case) = text::case({number}, variation) else {{ continue }};\n        \
             let p = text::Written::new(&case.scene, text::is_literal({number})).parameters;\n        \
             let system = Scene{number} {{ p: core::array::from_fn(|i| p[i]) }};\n        \
             let found = compare(&system, &case, {steps}, variation);\n        \
             println!(\"scene {number}.{{variation}}: {{found:?}}\");\n        all.join(&found);\n        \
             for words in found.wrong() {{\n            wrong += 1;\n            println!(\"wrong: scene {number}.{{variation}}: {{words}}\");\n        }}\n    }}"
        );
    }
    main.push_str("    println!(\"{wrong} wrong, {all:?}\");\n    std::process::ExitCode::from(u8::from(wrong > 0))\n}\n");
    text + &main
}
