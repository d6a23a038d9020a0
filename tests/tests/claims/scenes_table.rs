//! The scenes in the table of hard cases are those of the generator.

use std::fs;
use std::path::PathBuf;

use dsocs_tests::scenes::table::source;

/// The file of the table.
fn path() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("../dsocs-systems/src/stability/library/scenes/declared.rs")
}

/// Whether two words are equal, or numbers that agree but for rounding of elementary functions.
fn same(one: &str, other: &str) -> bool {
    let number = |word: &str| word.trim_matches(|c: char| "[](),;".contains(c)).parse::<f64>();
    match (number(one), number(other)) {
        (Ok(x), Ok(y)) => {
            let tolerance = if x.abs() < 1e-9 { 0.3 } else { 1e-7 };
            (x - y).abs() <= tolerance * x.abs()
        }
        _ => one == other,
    }
}

#[test]
fn the_table_has_the_generators_scenes() {
    let (written, expected) = (fs::read_to_string(path()).unwrap(), source());
    let (written, expected): (Vec<_>, Vec<_>) = (
        written.split_whitespace().collect(),
        expected.split_whitespace().collect(),
    );
    assert_eq!(
        written.len(),
        expected.len(),
        "write it again: `scenes_table:: -- --ignored`"
    );
    for (one, other) in written.iter().zip(&expected) {
        assert!(same(one, other), "{one} is there, {other} would be written");
    }
}

#[test]
#[ignore = "writes the file"]
fn write_the_table() {
    fs::write(path(), source()).unwrap();
}
