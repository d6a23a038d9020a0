//! Each kind of mistake in a declaration is reported at the user's own tokens: the compiler's output is
//! compared with the `.stderr` file beside the program.
//!
//! Errors of the attribute itself are grouped by subject. Errors of the compiler in the user's code have a
//! file each: the compiler reaches them only where nothing else is wrong.
//!
//! The compiler is run with the library that this test was built with. So nothing is built for these tests alone.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Tests one file each, and lists them.
macro_rules! files {
    ($($name:ident)*) => {
        const FILES: &[&str] = &[$(stringify!($name)),*];

        $(
            #[test]
            fn $name() {
                errors_are_expected(stringify!($name));
            }
        )*
    };
}

files! {
    arrays constraints elsewhere expressions external_forces maps method_of_numbers names no_effect number_type statements third_order time
    unknown_function used_all_the_same user_function_of_f64
}

/// The folder of this crate.
fn here() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The file with the expected errors of a program.
fn expected(name: &str) -> PathBuf {
    here().join(format!("compile-fail/{name}.stderr"))
}

/// The library. It may be there with several sets of features. The one that was built last is of the present source.
fn library() -> PathBuf {
    let mut found = Vec::new();
    for entry in fs::read_dir(env::current_exe().unwrap().parent().unwrap()).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy();
        if name.starts_with("libdsocs_core-") && name.ends_with(".rlib") {
            found.push((fs::metadata(&path).unwrap().modified().unwrap(), path));
        }
    }
    found.into_iter().max().unwrap().1
}

/// The errors of the compiler for a program, without the closing lines and with `$WORKSPACE` for the
/// workspace.
fn compiler_errors(name: &str) -> String {
    let (library, workspace) = (library(), here().ancestors().nth(2).unwrap());
    let compiler = Path::new(env!("CARGO")).with_file_name("rustc");
    let output = Command::new(compiler)
        .args(["--edition=2024", "--emit=metadata", "--diagnostic-width=140"])
        .arg(format!("-Ldependency={}", library.parent().unwrap().display()))
        .arg(format!("--extern=dsocs_core={}", library.display()))
        .args(["--out-dir", env!("CARGO_TARGET_TMPDIR")])
        .arg(format!("tests/compile/compile-fail/{name}.rs"))
        .current_dir(workspace)
        .output()
        .unwrap();
    assert!(!output.status.success(), "{name} compiles");
    let text = String::from_utf8(output.stderr).unwrap();
    let text = text.replace("tests/compile/compile-fail", "compile-fail");
    let text = text.replace(&workspace.display().to_string(), "$WORKSPACE");
    let end = text.find("error: aborting due to").unwrap_or(text.len());
    text[..end].trim_end().to_owned() + "\n"
}

/// Lines that depend on the features that the library was built with: the types that have a trait.
const FEATURE_LINES: [&str; 4] = [
    "help: the trait `",
    "help: the following other types implement trait",
    "note: required for `",
    "note: this error originates in the macro `impl_",
];

/// The lines that are compared: without their margins, which are as wide as the longest number of a line, without lines of the library's source,
/// and without lines that depend on its features.
fn compared_lines(text: &str) -> Vec<&str> {
    let mut lines = Vec::new();
    let (mut of_features, mut elsewhere) = (false, false);
    for line in text.lines() {
        let line = line.trim_start_matches(|c: char| c == ' ' || c.is_ascii_digit());
        let word = line.trim_start_matches("= ");
        if ["error", "warning", "help: ", "note: "]
            .iter()
            .any(|begin| word.starts_with(begin))
        {
            of_features = FEATURE_LINES.iter().any(|begin| word.starts_with(begin));
            elsewhere = false;
        }
        if line.starts_with("--> ") {
            elsewhere = !line.starts_with("--> compile-fail");
        }
        if !(line.is_empty() || of_features || elsewhere) {
            lines.push(line);
        }
    }
    lines
}

/// Compares the errors of a program with the expected ones.
fn errors_are_expected(name: &str) {
    let (found, expected) = (compiler_errors(name), fs::read_to_string(expected(name)).unwrap());
    assert!(
        compared_lines(&found) == compared_lines(&expected),
        "errors of {name}:\n\n{found}\n\nexpected:\n\n{expected}\n\nto accept it: `cargo test -p dsocs-compile-tests accept -- --ignored`"
    );
}

#[test]
fn every_file_is_tested() {
    let files = fs::read_dir(here().join("compile-fail")).unwrap();
    let files = files.map(|entry| entry.unwrap().path());
    let sources = files.filter(|path| path.extension().is_some_and(|end| end == "rs"));
    assert_eq!(sources.count(), FILES.len());
}

#[test]
#[ignore = "writes the files"]
fn accept() {
    for name in FILES {
        fs::write(expected(name), compiler_errors(name)).unwrap();
    }
}
