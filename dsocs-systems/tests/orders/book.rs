//! `check --orders`, and the table and listings of the book's chapter on orders.

use std::path::Path;

use super::{BEAD, program};

/// Standard output and standard error of the command, and whether it succeeds.
fn dsocs(folder: &Path, arguments: &[&str]) -> (String, String, bool) {
    let run = program::dsocs(folder, arguments).output().unwrap();
    let [out, stderr] = [run.stdout, run.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
    (out, stderr, run.status.success())
}

#[test]
fn the_command_writes_values_and_says_what_it_cannot_measure() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let text =
        format!("{BEAD} phi_lagrangian = paper; run {{ start = ([1], [0.3]); step = 0.05; until = 5.0; }}");
    std::fs::write(folder.join("bead.dsocs"), text).unwrap();
    let (out, stderr, good) = dsocs(folder, &["check", "bead.dsocs", "--orders", "--out", "bead.json"]);
    assert!(good, "{stderr}");
    assert!(
        out.contains("phi_lagrangian = paper lowers the order of the flow"),
        "{out}"
    );
    let values: serde_json::Value =
        serde_json::from_slice(&std::fs::read(folder.join("bead.json")).unwrap()).unwrap();
    let map = &values["systems"][0]["maps"][0];
    assert!(
        (map["follows"]["power"].as_f64().unwrap() - 1.0).abs() < 0.05,
        "{map:#}"
    );
    assert_eq!(map["parts"][0]["part"], "L_d");
    assert_eq!(map["lowering"][0], "D₁L_d + D₂L_d");
    assert_eq!(map["holds"], true);
    // a motion up to a given time
    let (out, _, good) = dsocs(folder, &["check", "bead.dsocs", "--orders", "--until", "2"]);
    assert!(good && out.contains("errors to t = 1.9"), "{out}");

    let (_, stderr, good) = dsocs(folder, &["check", "crane", "--orders"]);
    assert!(
        !good && stderr.contains("a constraint is of third order"),
        "{stderr}"
    );
    let (out, stderr, good) = dsocs(folder, &["check", "crane", "bead.dsocs", "--orders"]);
    assert!(
        good && out.contains("crane: not measured") && out.contains("bead"),
        "{out}{stderr}"
    );
    for wrong in [
        ["check", "bead.dsocs", "--every-map"].as_slice(),
        &["check", "bead.dsocs", "--orders", "--out", "bead.txt"],
        &["check", "bead.dsocs", "--out", "bead.md"],
    ] {
        assert!(!dsocs(folder, wrong).2, "{wrong:?}");
    }
}

/// The table of the chapter is the output of its command.
#[test]
fn the_table_of_the_book_is_true() {
    let folder = tempfile::tempdir().unwrap();
    let table = ["check", "--orders", "--every-map", "--out", "orders.md"];
    let (_, stderr, good) = dsocs(folder.path(), &table);
    assert!(good, "{stderr}");
    let found = std::fs::read_to_string(folder.path().join("orders.md")).unwrap();
    let book = include_str!("../../src/guide/orders.md");
    assert!(book.contains(&found), "the table is now\n{found}");
}

/// The listings of the chapter are systems, and the text below each of them is the output of its check.
#[test]
fn the_listings_of_the_chapter_run() {
    let folder = tempfile::tempdir().unwrap();
    let book = include_str!("../../src/guide/orders.md");
    let blocks: Vec<&str> = book
        .split("```text\n")
        .skip(1)
        .filter_map(|block| block.split("```").next())
        .collect();
    let [listing, shown] = blocks[..] else {
        panic!("{blocks:?}")
    };
    std::fs::write(folder.path().join("turn.dsocs"), listing).unwrap();
    let (found, ..) = dsocs(folder.path(), &["check", "turn.dsocs", "--orders"]);
    // distances may differ in their last digits on another machine, so words with exponents are left out
    let words = |text: &str| -> Vec<String> {
        let words = text.split_whitespace();
        words
            .filter(|word| !word.contains("e-"))
            .map(str::to_owned)
            .collect()
    };
    assert_eq!(words(&found), words(shown), "{found}");
}
