//! Small systems, and commands that are carried out on them.

use std::path::Path;

use clap::Parser;
use dsocs_core::dsocs;
use dsocs_core::text::Text;

use crate::cli::{Arguments, CliError, Program};
use crate::entry::Entry;

/// A weight on a spring; the mass may be zero.
pub(super) const WEIGHT: &str = "
    parameters { mass = 1 }
    coordinates(x);
    lagrangian = mass * dot(x).powi(2) / 2 - x.powi(2) / 2;
";

/// A servo; the gain may be zero.
const SERVO: &str = "
    parameters { gain = 1 }
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    kinematic = gain * (ddot(x) + x);
    constraint_forces = [(1,)];
";

/// A particle with a prescribed curvature, which is undefined at rest.
const TURN: &str = "
    parameters { curvature = 1 }
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2;
    let speed = (dot(x).powi(2) + dot(y).powi(2)).sqrt();
    kinematic = (dot(x) * ddot(y) - ddot(x) * dot(y)) / speed.powi(3) - curvature;
    variational = [(dot(x), dot(y))];
";

/// A curvature that grows at a prescribed rate, a constraint of third order.
const BEND: &str = "
    parameters { rate = 0.1 }
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2;
    let speed = (dot(x).powi(2) + dot(y).powi(2)).sqrt();
    kinematic = dot((dot(x) * ddot(y) - ddot(x) * dot(y)) / speed.powi(3)) - rate * speed;
    constraint_forces = [(-dot(y), dot(x))];
";

/// A product of two constraints, of which one holds at the velocity `drift`: there the acceleration is not
/// determined.
const EITHER: &str = "
    parameters { drift = 0.3 }
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    kinematic = (dot(x) - drift) * (ddot(x) + x);
    constraint_forces = [(1,)];
";

/// A mass on a rod.
const ROD: &str = "
    parameters { length = 1 }
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - 9.81 * y;
    holonomic = x.powi(2) + y.powi(2) - length.powi(2);
";

/// A potential whose domain ends at the origin.
const EDGE: &str = "
    parameters { strength = 1e-3 }
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2 + strength * x.ln();
";

/// A potential in the form of a cone, whose tip may be rounded.
const CONE: &str = "
    parameters { tip = 0 }
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - (x.powi(2) + y.powi(2) + tip.powi(2)).sqrt();
";

/// A servo's law, squared: a double root.
const SQUARED: &str = "
    parameters { rate = 1 }
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    kinematic = (ddot(x) + rate * x).powi(2);
    constraint_forces = [(1,)];
";

/// A constraint that gives only the size of an acceleration.
const UNSIGNED: &str = "
    parameters { rate = 1 }
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    kinematic = ddot(x).powi(2) - rate;
    constraint_forces = [(1,)];
";

/// Dry friction, under which the mass comes to rest.
const DRY: &str = "
    parameters { dry = 0.5 }
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2 - 20 * x.powi(2);
    external_forces = -dry * dot(x).signum();
";

/// Smoothed friction; a parameter is the width of the smoothing.
pub(super) const RUBBED: &str = "
    parameters { smoothing = 0.1 }
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2;
    external_forces = -(dot(x) / smoothing).tanh();
";

/// A Lyapunov law that holds at rest for any acceleration.
pub(super) const LAW: &str = "
    parameters { gain = 1 }
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2;
    kinematic = dot(dot(x).powi(2) / 2 + x.powi(2) / 2) + gain * dot(x).powi(2);
    constraint_forces = [(1,)];
";

/// A Lyapunov constraint for two carts on springs that leaves out the friction of the first one.
const FORGOTTEN: &str = "
    parameters { friction = 0.3 }
    coordinates(x, y);
    let kinetic = (dot(x).powi(2) + dot(y).powi(2)) / 2;
    let potential = 2 * (x.powi(2) + (y - x).powi(2));
    lagrangian = kinetic - potential;
    kinematic = dot(kinetic + potential) + 0.8 * dot(y).powi(2);
    constraint_forces = [(0, 1)];
    external_forces = (-friction * dot(x), 0);
";

/// A constraint on one coordinate whose force acts on the other one only, if the gain is zero.
const IDLE: &str = "
    parameters { gain = 1 }
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2;
    kinematic = ddot(x) + x;
    constraint_forces = [(gain, 1)];
";

/// A particle at rest that a force begins to push.
const PUSHED: &str = "
    parameters { strength = 1 }
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2;
    external_forces = (strength * t.sin(), 0);
";

/// A mass on springs; their number is a field that is not `f64`.
#[dsocs {
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2 - springs * stiffness * x.powi(2) / 2;
}]
#[derive(Clone)]
struct Springs {
    stiffness: f64,
    springs: u32,
}

/// An entry from a text.
pub(super) fn entry(name: &str, text: &str) -> Entry {
    Entry::of_text(name, &Text::parse(name, text).unwrap(), None)
}

/// The systems.
pub(super) fn entries() -> Vec<Entry> {
    let [one, two] = [1.0, 2.0];
    vec![
        entry("weight", WEIGHT).start([one], [0.0]),
        entry("servo", SERVO).start([one], [0.0]),
        entry("turn", TURN).start([0.0, 0.0], [one, 0.0]),
        entry("bend", BEND).start([0.0, 0.0], [one, 0.0]),
        entry("either", EITHER).start([one], [0.0]),
        entry("rod", ROD).start([0.6, -0.8], [0.0, 0.0]),
        entry("edge", EDGE).start([0.05], [two]),
        entry("cone", CONE).start([0.0, 0.0], [0.0, 0.0]),
        entry("squared", SQUARED).start([one], [0.0]),
        entry("unsigned", UNSIGNED).start([one], [0.0]),
        entry("dry", DRY).start([0.2], [0.0]).until(4.0),
        entry("rubbed", RUBBED).start([one], [0.0]),
        entry("law", LAW).start([one], [one]),
        entry("forgotten", FORGOTTEN).start([0.3, -0.2], [0.0, 0.5]),
        entry("idle", IDLE).start([one, 0.0], [0.0, 0.0]),
        entry("pushed", PUSHED).start([0.0, 0.0], [0.0, 0.0]),
        Entry::new(Springs {
            stiffness: one,
            springs: 2,
        })
        .start([one], [0.0]),
    ]
    .into_iter()
    .map(|entry| {
        if entry.name() == "dry" {
            entry
        } else {
            entry.until(0.5)
        }
        .step(0.01)
    })
    .collect()
}

/// Carries out a command whose rows go to a file.
pub(super) fn execute(folder: &Path, words: &str) -> Result<(), CliError> {
    let out = folder.join(if words.starts_with("check") {
        "a.json"
    } else {
        "a.csv"
    });
    let out = out.display().to_string();
    let words = words.split(' ').chain(["--out", &out]);
    let Arguments { command, .. } =
        Arguments::try_parse_from(core::iter::once("dsocs").chain(words)).unwrap();
    command.execute(&mut Program::new(entries(), &[]).verified()?)
}
