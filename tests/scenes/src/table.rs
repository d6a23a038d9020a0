//! Writes scenes with their last nodes for the table of hard cases: a source file of the systems' crate,
//! which cannot depend on the second formulation.

use core::fmt::Write as _;

use dsocs_core::__private::Source as _;
use dsocs_core::text::Text;

use super::exact::exact;
use super::random::{Case, Random, linkage, robot, train, tree};
use super::scene::Map;
use super::text::Written;

/// The number of steps of each scene.
pub const STEPS: usize = 100;

/// The number of seeds that are tried for one scene.
const SEEDS: u64 = 200;

/// A random scene of a kind.
fn drawn(kind: usize, random: &mut Random) -> Option<Case> {
    let map = [Map::Midpoint, Map::Trapezoid][random.below(2)];
    match kind {
        0 => {
            let (scene, place) = linkage(2, 1, Map::Paper, random);
            Case::new(&scene, Some(&place), random)
        }
        1 => {
            let (scene, place) = linkage(3, 2, map, random);
            Case::new(&scene, Some(&place), random)
        }
        2 => Case::new(&train(2, false, Map::Midpoint, random), None, random),
        3 | 4 => {
            let scene = tree(3, map, random);
            let scene = robot(scene, (1, Some(0)), kind == 4, random);
            Case::new(&scene, None, random)
        }
        _ => Case::new(&tree(kind - 2, map, random), None, random),
    }
}

/// The names of the kinds.
const KINDS: [&str; 7] = [
    "a rod and a spring",
    "two rods",
    "a train",
    "a servo in a tree",
    "a brake in a tree",
    "a tree of three",
    "a tree of four",
];

/// The source file: the runs, each with the declaration of its scene.
#[must_use]
pub fn source() -> String {
    let mut text = String::from(
        "//! Written by `dsocs_tests::scenes::table`: scenes that were drawn at random, and where the second formulation\n\
         //! of the tests comes to in double the precision.\n\n\
         #![allow(clippy::all, clippy::pedantic)] // as the generator writes\n\n\
         use super::Run;\n",
    );
    for (kind, name) in KINDS.iter().enumerate() {
        // the first one whose steps are all short enough
        let found = (0..SEEDS).find_map(|seed| {
            let case = drawn(kind, &mut Random::new(7_000_000 + 1000 * kind as u64 + seed))?;
            let end = exact(&case, STEPS)?;
            Some((case, end))
        });
        let Some((case, [last, units])) = found else {
            continue;
        };
        let (body, n) = (Written::new(&case.scene, true).text, case.q0.len());
        let Ok(Text { system, .. }) = Text::parse(name, &body) else {
            continue;
        };
        let unknowns = system.shape().unknowns;
        // writing to a string does not fail
        let _ = write!(
            text,
            "\n/// {name}.\npub const RUN{kind}: Run<{n}, {unknowns}> = Run {{\n    name: {name:?},\n    \
             text: \"\n{body}\",\n    h: {:?},\n    \
             q0: {:?},\n    q1: {:?},\n    last: {last:?},\n    units: [{}],\n}};\n",
            case.h,
            case.q0,
            case.q1,
            units
                .iter()
                .map(|unit| format!("{unit:.1e}"))
                .collect::<Vec<_>>()
                .join(", "),
        );
    }
    text
}
