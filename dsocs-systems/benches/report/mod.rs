//! The table of the bench, on the screen and as a file.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use crate::measure::Line;

/// The limits of the table: system, ratio of rows with Jacobian, ratio of steps.
const BARS: [(&str, f64, f64); 4] = [
    ("particle", 1.0, 1.0),
    ("particle_field", 1.0, 1.0),
    ("pendulum", 1.0, 0.9),
    ("chain8", 1.0, 1.0),
];

/// The folder of the workspace's build.
fn target() -> PathBuf {
    std::env::var_os("CARGO_TARGET_DIR").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../target"),
        PathBuf::from,
    )
}

/// Prints the table.
pub fn show(lines: &[Line]) {
    println!("\nsystem           what             generated ns  by hand ns  ratio  bar");
    for line in lines {
        // steps against lean ones have their own limit
        let bars = BARS
            .iter()
            .find(|(system, ..)| *system == line.system && !line.what.contains('÷'));
        let bar = bars.map_or(
            if line.what.starts_with("nodes") {
                f64::NAN
            } else {
                1.1
            },
            |&(_, eval, step)| if line.what == "eval" { eval } else { step },
        );
        println!(
            "{:<16} {:<16} {:>12.1} {:>11.1} {:>6.3} {bar:>5.2}",
            line.system, line.what, line.generated, line.by_hand, line.ratio
        );
    }
}

/// Writes `target/report/step.json`.
pub fn write(lines: &[Line]) {
    let rows: Vec<Value> = lines
        .iter()
        .map(|line| {
            json!({
                "system": line.system,
                "what": line.what,
                "generated_ns": line.generated,
                "handwritten_ns": line.by_hand,
                "ratio": line.ratio,
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
