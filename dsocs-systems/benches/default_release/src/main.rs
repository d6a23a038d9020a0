//! The table of the bench `step`, under cargo's default release profile: one line of numbers for each of its lines.
//!
//! The argument is the number of batches.

#![allow(missing_docs, dead_code)] // no library, and not all of what the bench `step` shares is used
#![allow(clippy::inline_always)] // the rivals are to be as fast as they can be

#[path = "../../handwritten/mod.rs"]
mod handwritten;
#[path = "../../measure/mod.rs"]
mod measure;

use dsocs_systems as systems;

fn main() {
    let batches = std::env::args().nth(1).and_then(|argument| argument.parse().ok());
    for line in measure::lines(batches.unwrap_or(400)) {
        println!("{} {} {} {} {}", line.system, line.what, line.generated, line.by_hand, line.ratio);
    }
}
