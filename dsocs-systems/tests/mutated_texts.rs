//! Texts that are no systems, or other ones: whatever is done to a text, it ends in a message or in a system that takes steps, in bounded time.
//!
//! `DSOCS_MUTATED_SECONDS` says for how long (4 s unless given), `DSOCS_MUTATED_SEED` where chance begins. The text that is being read stands in
//! `mutated.dsocs` in the temporary folder of the target, should the process not come back. See `tests/fuzz/README.md`.

use std::fmt::Debug;
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::str::FromStr;
use std::time::{Duration, Instant};

use dsocs_core::text::{Text, TextError};
use dsocs_core::{AnyFlow, AnyStart, Kernel};

/// No text may take longer than this, to be read and to take ten steps, however slow the machine is.
const LONGEST: Duration = Duration::from_secs(60);

/// What is put in where chance wants something unusual.
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

/// Numbers by chance (xorshift64*).
struct Chance(u64);

impl Chance {
    /// A number below another.
    fn below(&mut self, count: usize) -> usize {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        let high = self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 33;
        usize::try_from(high).unwrap() % count.max(1)
    }

    /// One of several.
    fn one<'a>(&mut self, all: &[&'a str]) -> &'a str {
        all.get(self.below(all.len())).copied().unwrap_or("")
    }
}

/// The pieces of a text: words, numbers, spaces, and every other character alone.
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

/// A text to which something was done, a few times.
fn mutated(chance: &mut Chance, texts: &[String]) -> Vec<u8> {
    let text = &texts[chance.below(texts.len())];
    let other = pieces(&texts[chance.below(texts.len())]);
    let mut own = pieces(text);
    for _ in 0..=chance.below(4) {
        let (at, to) = (chance.below(own.len()), chance.below(own.len()));
        let few = |chance: &mut Chance, length: usize| (at, (at + 1 + chance.below(12)).min(length));
        match chance.below(9) {
            0 if !own.is_empty() => drop(own.remove(at)),
            1 if !own.is_empty() => own.swap(at, to),
            2 if !own.is_empty() => own[at] = chance.one(&other),
            3 if !own.is_empty() => own[at] = chance.one(&UNUSUAL),
            4 => own.insert(at, chance.one(&UNUSUAL)),
            5 => own.insert(at, chance.one(&other)),
            6 => {
                let (from, end) = few(chance, own.len());
                let again: Vec<&str> = own[from..end].to_vec();
                own.splice(to..to, again);
            }
            7 => {
                let (from, end) = few(chance, own.len());
                own.drain(from..end);
            }
            _ => {
                let from = chance.below(other.len());
                let end = (from + 1 + chance.below(30)).min(other.len());
                own.splice(at..at, other[from..end].iter().copied());
            }
        }
    }
    let mut bytes = own.concat().into_bytes();
    if chance.below(8) == 0 && !bytes.is_empty() {
        let at = chance.below(bytes.len());
        bytes[at] = u8::try_from(chance.below(256)).unwrap();
    }
    if chance.below(40) == 0 {
        bytes.truncate(chance.below(bytes.len()));
    }
    bytes
}

/// Reads bytes as the program reads a file, and takes ten steps. Whether they are a system.
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
    // whatever is no start or no step is an error
    if let Ok(mut flow) = AnyFlow::new(&text.system, h, &AnyStart::second_order(&start[0], &start[1])) {
        for _ in 0..10 {
            if flow.run_mut().advance().is_err() {
                break;
            }
        }
    }
    true
}

/// A number from the environment.
fn given<T: FromStr<Err: Debug>>(name: &str, otherwise: T) -> T {
    std::env::var(name).map_or(otherwise, |text| text.parse().unwrap())
}

#[test]
fn whatever_is_done_to_a_text_ends_in_a_message_or_a_system() {
    let seconds = given("DSOCS_MUTATED_SECONDS", 4.0);
    let mut chance = Chance(given("DSOCS_MUTATED_SEED", 1_u64).max(1));
    let mut texts: Vec<String> = dsocs_systems::systems::all()
        .iter()
        .filter_map(|entry| entry.text().ok())
        .collect();
    assert!(texts.len() > 5);
    let seeds = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/fuzz/seeds/text");
    for seed in fs::read_dir(seeds).into_iter().flatten() {
        texts.push(fs::read_to_string(seed.unwrap().path()).unwrap());
    }
    let place = Path::new(env!("CARGO_TARGET_TMPDIR")).join("mutated.dsocs");
    let begun = Instant::now();
    let (mut count, mut systems, mut slowest) = (0_u64, 0_u64, Duration::ZERO);
    while begun.elapsed().as_secs_f64() < seconds {
        let bytes = mutated(&mut chance, &texts);
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
    }
    eprintln!("{count} texts, {systems} of them systems, the slowest in {slowest:?}");
    assert!(systems > 0 && systems < count);
}
