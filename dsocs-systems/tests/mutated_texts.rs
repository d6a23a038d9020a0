//! Mutated texts: whatever is changed in a text, reading it gives an error or a system that takes steps, in
//! bounded time.
//!
//! `DSOCS_MUTATED_SECONDS` is the duration (4 s unless given), `DSOCS_MUTATED_SEED` the seed of the random
//! numbers. The current text is in `mutated.dsocs` in the temporary folder of the target, in case the process
//! hangs. See `tests/fuzz/README.md`.

use std::fmt::Debug;
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::str::FromStr;
use std::time::{Duration, Instant};

use dsocs_core::text::{Text, TextError};
use dsocs_core::{AnyFlow, AnyStart, Kernel};
use dsocs_scenes::random::Random;

/// The largest time to read a text and to take ten steps, however slow the machine is.
const LONGEST: Duration = Duration::from_secs(60);

/// Unusual pieces that a mutation may insert.
const UNUSUAL: [&str; 34] = [
    "1e308",
    "1e-320",
    "0",
    "-",
    "1000000000",
    "9007199254740993",
    "18446744073709551616",
    "4294967295",
    "0.1e400",
    "1/0",
    "sum(0..1000000000, |i| i)",
    "sum(0..1000, |i| sum(0..1000, |j| i * j))",
    "product(0..40, |i| 1 + i)",
    "each(0..100000, |i| i)",
    "[0.0; 100000]",
    ".powi(2147483647)",
    ".powi(-2147483648)",
    ".powf(0.5)",
    ".sqrt()",
    "ddot(x)",
    "dot(dot(dot(t)))",
    "dddot(x)",
    "let f = |u| f(u);",
    "let a = a;",
    "const n = 1e9;",
    "parameters { a = a }",
    "run { until = inf; }",
    "((((((((((((((((((((",
    "\u{0}",
    "\u{202e}",
    "é",
    "r#\"",
    "/*",
    "samples(\"/dev/zero\")",
];

/// The declarations in the sources below a folder, as texts: the bodies of the attributes, with the numeric
/// fields of the structs as parameters.
fn declared(folder: &Path, texts: &mut Vec<String>) {
    for entry in fs::read_dir(folder).into_iter().flatten() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            declared(&path, texts);
        }
        if path
            .extension()
            .is_none_or(|ending| ending != "rs" && ending != "md")
        {
            continue;
        }
        let source = fs::read_to_string(&path).unwrap();
        // declarations in documentation, too
        let source = source.lines().map(|line| {
            let line = line.trim_start();
            line.strip_prefix("//! ")
                .or(line.strip_prefix("/// "))
                .unwrap_or(line)
        });
        let source: Vec<&str> = source.collect();
        for part in source.join("\n").split("#[dsocs {").skip(1) {
            let Some((body, item)) = part.split_once("\n}]") else {
                continue;
            };
            let item = item.split_once("struct ").map_or("", |(_, item)| item);
            let fields = item
                .split_once('{')
                .and_then(|(_, fields)| fields.split_once('}'));
            let mut parameters = String::new();
            for field in fields.map_or("", |(fields, _)| fields).split(',') {
                let field = field
                    .lines()
                    .last()
                    .unwrap_or("")
                    .trim()
                    .trim_start_matches("pub ");
                match field.split_once(": ") {
                    Some((name, "f64")) => parameters.extend([name, " = 1.0,\n"]),
                    Some((name, ty)) if ty.starts_with("[f64; ") => {
                        let length = ty.trim_start_matches("[f64; ").trim_end_matches(']');
                        parameters.extend([name, ": [", length, "] = [1.0; ", length, "],\n"]);
                    }
                    _ => {}
                }
            }
            texts.push(format!(
                "parameters {{\n{parameters}}}\n{body}\nrun {{ step = 0.01; }}\n"
            ));
        }
    }
}

/// One of several strings.
fn one<'a>(random: &mut Random, all: &[&'a str]) -> &'a str {
    all.get(random.below(all.len())).copied().unwrap_or("")
}

/// The tokens of a text: words, numbers, spaces, and every other character alone.
fn pieces(text: &str) -> Vec<&str> {
    let mut pieces = Vec::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let kind = |c: char| (c.is_alphanumeric() || c == '_', c.is_whitespace());
        let is_alone = kind(first) == (false, false);
        let end = rest.find(|c| kind(c) != kind(first)).unwrap_or(rest.len());
        let end = if is_alone { first.len_utf8() } else { end };
        let (piece, after) = rest.split_at(end);
        pieces.push(piece);
        rest = after;
    }
    pieces
}

/// A text with a few random changes.
fn mutated(random: &mut Random, texts: &[String]) -> Vec<u8> {
    let text = &texts[random.below(texts.len())];
    let other = pieces(&texts[random.below(texts.len())]);
    let mut own = pieces(text);
    // a single change often leaves a system, many seldom do
    for _ in 0..[1, 1, 1, 1, 2, 2, 3, 6][random.below(8)] {
        let (at, to) = (random.below(own.len()), random.below(own.len()));
        let few = |random: &mut Random, length: usize| (at, (at + 1 + random.below(12)).min(length));
        match random.below(9) {
            0 if !own.is_empty() => drop(own.remove(at)),
            1 if !own.is_empty() => own.swap(at, to),
            2 if !own.is_empty() => own[at] = one(random, &other),
            3 if !own.is_empty() => own[at] = one(random, &UNUSUAL),
            4 => own.insert(at, one(random, &UNUSUAL)),
            5 => own.insert(at, one(random, &other)),
            6 => {
                let (from, end) = few(random, own.len());
                let again: Vec<&str> = own[from..end].to_vec();
                own.splice(to..to, again);
            }
            7 => {
                let (from, end) = few(random, own.len());
                own.drain(from..end);
            }
            _ => {
                let from = random.below(other.len());
                let end = (from + 1 + random.below(30)).min(other.len());
                own.splice(at..at, other[from..end].iter().copied());
            }
        }
    }
    let mut bytes = own.concat().into_bytes();
    if random.below(8) == 0 && !bytes.is_empty() {
        let at = random.below(bytes.len());
        bytes[at] = u8::try_from(random.below(256)).unwrap();
    }
    if random.below(40) == 0 {
        bytes.truncate(random.below(bytes.len()));
    }
    bytes
}

/// Reads bytes as the program reads a file, and takes ten steps. Returns whether they are a system.
fn ten_steps(bytes: &[u8]) -> bool {
    let Ok(text) = std::str::from_utf8(bytes) else {
        return false;
    };
    let text = match Text::parse("mutated", text) {
        Ok(text) => text,
        Err(error) => {
            assert!(
                !matches!(error, TextError::Panic | TextError::Tape(_)) && !error.to_string().is_empty(),
                "{error}"
            );
            return false;
        }
    };
    let kernel: &dyn Kernel = &text.system;
    let zeros = vec![0.0; kernel.shape().coordinates.len()];
    let run = text.runs.first();
    let start = run
        .and_then(|run| run.start.clone())
        .unwrap_or([zeros.clone(), zeros]);
    let h = run.and_then(|run| run.step).unwrap_or(0.01);
    // a start or step that cannot be used is an error
    if let Ok(mut flow) = AnyFlow::new(&text.system, h, &AnyStart::second_order(&start[0], &start[1])) {
        for _ in 0..10 {
            if flow.run_mut().advance().is_err() {
                break;
            }
        }
    }
    true
}

/// A value of an environment variable, or the default.
fn given<T: FromStr<Err: Debug>>(name: &str, otherwise: T) -> T {
    std::env::var(name).map_or(otherwise, |text| text.parse().unwrap())
}

#[test]
fn whatever_is_done_to_a_text_ends_in_a_message_or_a_system() {
    let seconds = given("DSOCS_MUTATED_SECONDS", 4.0);
    let mut random = Random::new(given("DSOCS_MUTATED_SEED", 1));
    let mut texts: Vec<String> = dsocs_systems::systems::all()
        .iter()
        .filter_map(|entry| entry.text().ok())
        .collect();
    assert!(texts.len() > 5);
    // the declarations in the sources of the workspace
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    for folder in ["tests", "dsocs-systems", "dsocs-core/src"] {
        declared(&workspace.join(folder), &mut texts);
    }
    let place = Path::new(env!("CARGO_TARGET_TMPDIR")).join("mutated.dsocs");
    let begun = Instant::now();
    let (mut count, mut systems, mut slowest) = (0_u64, 0_u64, Duration::ZERO);
    while begun.elapsed().as_secs_f64() < seconds {
        // a long test begins with the unchanged texts
        let bytes = match usize::try_from(count).ok().and_then(|count| texts.get(count)) {
            Some(text) if seconds > 60.0 => text.clone().into_bytes(),
            _ => mutated(&mut random, &texts),
        };
        fs::write(&place, &bytes).unwrap();
        let one = Instant::now();
        let is_system = catch_unwind(AssertUnwindSafe(|| ten_steps(&bytes)));
        let took = one.elapsed();
        let shown = || {
            format!(
                "after {took:?}, text {count}:\n{}",
                String::from_utf8_lossy(&bytes)
            )
        };
        let Ok(is_system) = is_system else {
            panic!("{}", shown());
        };
        assert!(took < LONGEST, "{}", shown());
        if took > slowest {
            slowest = took;
            if took > LONGEST / 20 {
                eprintln!("slow, {}", shown());
            }
        }
        (count, systems) = (count + 1, systems + u64::from(is_system));
        if count == texts.len() as u64 {
            eprintln!("{count} texts, {systems} of them systems");
        }
    }
    eprintln!("{count} texts, {systems} of them systems, the slowest in {slowest:?}");
    assert!(systems > 0 && systems < count);
}
