//! `dsocs new`: a crate with a system of one's own.

use std::fs;
use std::path::{Component, Path, PathBuf};

use clap::Args;

use crate::cli::output;
use crate::cli::output::terminal;
use crate::cli::{CliError, Program};

/// The crate's `main.rs`.
const MAIN: &str = include_str!("new/main.rs.txt");

/// The arguments of `new`.
#[derive(Args, Debug)]
pub struct NewArguments {
    /// The folder of the new crate; its last part is the crate's name unless `--name` gives another
    path: PathBuf,
    /// A system that it begins with: a text file, or the name of one of this program's [default: a mass that swings on a spring]
    #[arg(long, value_name = "FILE")]
    from: Option<String>,
    /// The crate's name
    #[arg(long)]
    name: Option<String>,
    /// A checkout of dsocs; the new crate depends on its crates by path [default: the checkout from which this program was built; if there
    /// is none, or the program was installed from a registry, the crates of this version by name]
    #[arg(long, value_name = "DIR")]
    checkout: Option<PathBuf>,
}

/// Writes the crate.
///
/// # Errors
///
/// [`CliError`] if the name is not allowed for a crate, the folder is not empty, there is no checkout where
/// one is given, or a file cannot be written.
pub fn new(arguments: &NewArguments, program: &mut Program) -> Result<(), CliError> {
    let folder = &arguments.path;
    let name = name(arguments)?;
    if fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_some()) || folder.is_file() {
        return Err(CliError::Occupied(folder.clone()));
    }
    let mut tables = Vec::new();
    let (main, what) = match &arguments.from {
        None => (MAIN.to_owned(), "a mass that swings on a spring".to_owned()),
        Some(from) => {
            let entry = program.find(from)?;
            let beside = Path::new(from).parent().unwrap_or(Path::new(""));
            // files beside the text are copied; others stay where they are
            let is_beside = |file: &&str| {
                Path::new(file)
                    .components()
                    .all(|part| matches!(part, Component::Normal(_)))
            };
            for file in entry.files().filter(is_beside) {
                let path = beside.join(file);
                let bytes = fs::read(&path).map_err(|cause| CliError::Read {
                    path,
                    cause: cause.to_string(),
                })?;
                tables.push((file.to_owned(), bytes));
            }
            (entry.rust()?, format!("`{}`", entry.name()))
        }
    };
    let checkout = match &arguments.checkout {
        Some(given) => match checkout(given) {
            Some(found) => Some(found),
            None => return Err(CliError::NoCheckout(given.clone())),
        },
        None => checkout(&Path::new(env!("CARGO_MANIFEST_DIR")).join("..")),
    };
    for (file, content) in [
        ("Cargo.toml", manifest(&name, checkout.as_deref()).as_str()),
        ("src/main.rs", main.as_str()),
        (".gitignore", "/target\n/results\n"),
    ] {
        output::write(&folder.join(file), content.as_bytes())?;
    }
    for (file, bytes) in tables {
        output::write(&folder.join(file), &bytes)?;
    }
    let text = format!(
        "A crate with a system of one's own is in {0}: src/main.rs declares {what}.\n\n\
         cd {0}\n\
         cargo run --release -- list                      # coordinates, parameters, defaults\n\
         cargo run --release -- run --report motion.html  # a run, as a page to open in a browser\n\
         cargo run --release -- run --plot motion.svg     # the same as a figure\n\
         cargo run --release -- check                     # the theorems that hold for it\n",
        folder.display()
    );
    terminal::print(text.as_bytes())
}

/// The name of the crate.
fn name(arguments: &NewArguments) -> Result<String, CliError> {
    let last = || {
        let whole = std::path::absolute(&arguments.path).ok()?;
        Some(whole.file_name()?.to_string_lossy().into_owned())
    };
    let name = arguments.name.clone().or_else(last).unwrap_or_default();
    let letters = |letter: char| letter.is_ascii_alphanumeric() || matches!(letter, '-' | '_');
    let taken = [
        "dsocs",
        "dsocs-core",
        "dsocs-systems",
        "dsocs-macros",
        "dsocs-language",
        "core",
        "std",
        "test",
    ];
    if name.starts_with(|first: char| first.is_ascii_alphabetic())
        && name.chars().all(letters)
        && !taken.contains(&name.replace('_', "-").as_str())
    {
        Ok(name)
    } else {
        Err(CliError::CrateName(name))
    }
}

/// The canonical path of the folder, if it is a checkout of dsocs. A crate unpacked from a registry has no
/// such neighbours.
fn checkout(folder: &Path) -> Option<PathBuf> {
    let whole = fs::canonicalize(folder).ok()?;
    let there = |package: &str| whole.join(package).join("Cargo.toml").is_file();
    (there("dsocs-core") && there("dsocs-systems")).then_some(whole)
}

/// The crate's `Cargo.toml`.
fn manifest(name: &str, checkout: Option<&Path>) -> String {
    let version = env!("CARGO_PKG_VERSION");
    let from = |package: &str| match checkout {
        Some(folder) => format!("path = {}", quoted(&folder.join(package).to_string_lossy())),
        None => format!("version = \"{version}\""),
    };
    format!(
        "[package]\n\
         name = \"{name}\"\n\
         version = \"0.1.0\"\n\
         edition = \"2024\"\n\n\
         [dependencies]\n\
         dsocs-core = {{ {} }}\n\
         dsocs-systems = {{ {}, default-features = false, features = [\"cli\"] }}\n\
         # the features \"sweep\" and \"png\" add many runs by a plan, and figures as PNG\n\n\
         # a workspace of its own, also inside of another one's folder\n\
         [workspace]\n",
        from("dsocs-core"),
        from("dsocs-systems"),
    )
}

/// A string as TOML writes it.
fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dependencies_are_by_path_in_a_checkout_and_by_version_elsewhere() {
        let by_path = manifest("mine", Some(Path::new("/some/where")));
        assert!(
            by_path.contains("dsocs-core = { path = \"/some/where/dsocs-core\" }"),
            "{by_path}"
        );
        let by_version = manifest("mine", None);
        let version = env!("CARGO_PKG_VERSION");
        assert!(
            by_version.contains(&format!("dsocs-core = {{ version = \"{version}\" }}")),
            "{by_version}"
        );
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(checkout(folder.path()), None);
    }
}
