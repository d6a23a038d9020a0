//! The table of the bench, on the screen and as a file; and the same table from another crate.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::{Value, json};

use crate::measure::Line;

/// The bars of the table: system, residual and Jacobian, step.
const BARS: [(&str, f64, f64); 4] = [
    ("particle", 1.05, 1.05),
    ("particle_field", 1.10, 1.05),
    ("pendulum", 1.10, 1.05),
    ("chain8", 1.2, 1.1),
];

/// The folder of the workspace's build.
fn target() -> PathBuf {
    std::env::var_os("CARGO_TARGET_DIR").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../target"),
        PathBuf::from,
    )
}

/// The same table under cargo's default release profile, from a crate that has only `dsocs-core` for a dependency;
/// empty, with a word on why, if it cannot be built.
pub fn default_release(batches: usize) -> Vec<Line> {
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/default_release/Cargo.toml");
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    eprintln!("building the same for cargo's default release profile");
    let output = Command::new(cargo)
        .args(["run", "--quiet", "--release", "--manifest-path"])
        .arg(manifest)
        .arg("--target-dir")
        .arg(target().join("default-release"))
        .arg("--")
        .arg(batches.to_string())
        .stderr(Stdio::inherit())
        .output();
    let text = match output {
        Ok(output) if output.status.success() => String::from_utf8_lossy(&output.stdout).into_owned(),
        Ok(output) => {
            eprintln!("no table under the default release profile: {}", output.status);
            return Vec::new();
        }
        Err(error) => {
            eprintln!("no table under the default release profile: {error}");
            return Vec::new();
        }
    };
    text.lines().filter_map(line).collect()
}

/// A line of the other crate's output.
fn line(text: &str) -> Option<Line> {
    let mut words = text.split_whitespace();
    let (system, what) = (words.next()?.to_owned(), words.next()?.to_owned());
    let mut number = || words.next()?.parse().ok();
    Some(Line {
        system,
        what,
        generated: number()?,
        by_hand: number()?,
        ratio: number()?,
    })
}

/// Prints the table.
pub fn show(here: &[Line], elsewhere: &[Line]) {
    println!("\nsystem           what   profile          generated ns  by hand ns  ratio  bar");
    for (profile, lines, room) in [("release", here, 1.0), ("default release", elsewhere, 1.1)] {
        for line in lines {
            let bars = BARS.iter().find(|(system, ..)| *system == line.system);
            let bar = bars.map_or(
                f64::NAN,
                |&(_, eval, step)| if line.what == "eval" { eval } else { step },
            );
            println!(
                "{:<16} {:<6} {profile:<16} {:>12.1} {:>11.1} {:>6.3} {:>5.3}",
                line.system,
                line.what,
                line.generated,
                line.by_hand,
                line.ratio,
                bar * room
            );
        }
    }
}

/// Writes `target/report/step.json`.
pub fn write(here: &[Line], elsewhere: &[Line]) {
    let rows: Vec<Value> = [("release", here), ("default_release", elsewhere)]
        .into_iter()
        .flat_map(|(profile, lines)| {
            lines.iter().map(move |line| {
                json!({
                    "system": line.system,
                    "what": line.what,
                    "profile": profile,
                    "generated_ns": line.generated,
                    "handwritten_ns": line.by_hand,
                    "ratio": line.ratio,
                })
            })
        })
        .collect();
    let folder = target().join("report");
    let path = folder.join("step.json");
    let text = format!("{:#}\n", json!({ "rows": rows }));
    match std::fs::create_dir_all(&folder).and_then(|()| std::fs::write(&path, text)) {
        Ok(()) => println!("\nwritten: {}", path.display()),
        Err(error) => eprintln!("{} could not be written: {error}", path.display()),
    }
}
