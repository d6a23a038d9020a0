//! Systems in text files, wherever a command takes the name of a system.

use std::path::{Path, PathBuf};

use clap::Args;
use dsocs_core::text::Text;

use crate::cli::CliError;
use crate::cli::output::terminal::tell;
use crate::entry::{Entry, UnknownName};

/// The ending of a text file with a system.
const ENDING: &str = ".dsocs";

/// The options for text files.
#[derive(Debug, Clone, Args)]
pub struct FileArguments {
    /// A number in place of the one that a text file gives a constant (`const n = 3;`)
    #[arg(long = "const", value_name = "NAME=NUMBER", value_parser = constant, global = true, help_heading = "Text files")]
    pub constants: Vec<(String, f64)>,
}

/// Reads `n=8`.
fn constant(text: &str) -> Result<(String, f64), String> {
    let parts = text.split_once('=');
    let constant =
        parts.and_then(|(name, number)| Some((name.trim().to_owned(), number.trim().parse().ok()?)));
    constant.ok_or_else(|| "expected a name and a number, n=8".to_owned())
}

/// The text file that a name denotes; `None` if it is no name of a file.
pub fn path(name: &str) -> Option<PathBuf> {
    file_and_run(name).map(|(file, _)| PathBuf::from(file))
}

/// The text file and the run that a name denotes, as in `swing.dsocs:fast`.
pub fn file_and_run(name: &str) -> Option<(String, Option<&str>)> {
    match name.rsplit_once(&format!("{ENDING}:")) {
        Some((stem, run)) => Some((format!("{stem}{ENDING}"), Some(run))),
        None => name.ends_with(ENDING).then(|| (name.to_owned(), None)),
    }
}

/// A hint for a name that is neither of a system nor of a text file: a file or folder of that name, or the
/// text file that may be meant.
pub fn file_hint(name: &str) -> Option<String> {
    let stem = name.split(':').next().unwrap_or(name);
    let path = Path::new(stem);
    let text = format!("{stem}{ENDING}");
    if path.is_dir() {
        Some(format!(
            ": it is a folder; expected a system, or a text file whose name ends in `{ENDING}`"
        ))
    } else if path.exists() {
        Some(format!(
            ": the name of a text file with a system ends in `{ENDING}`"
        ))
    } else if Path::new(&text).is_file() {
        let run = &name[stem.len()..];
        Some(format!(" (did you mean the file `{text}{run}`?)"))
    } else if stem.contains(['/', '.', '\\']) {
        Some(format!(
            ", and no file of this name; that of a text file with a system ends in `{ENDING}`"
        ))
    } else {
        None
    }
}

/// The system in a text file: with its default run (`swing.dsocs`), or with the run named
/// (`swing.dsocs:fast`). `None` if the name is not that of a file.
pub fn entry(name: &str, constants: &[(String, f64)]) -> Result<Option<Entry>, CliError> {
    let Some((file, run)) = file_and_run(name) else {
        return Ok(None);
    };
    let text = Text::read_with(&file, constants)?;
    for warning in text.warnings_shown(&file) {
        tell(warning);
    }
    let names = || text.runs.iter().filter_map(|run| run.name.as_deref());
    let chosen = match run {
        None => {
            let unnamed = text.runs.iter().find(|run| run.name.is_none());
            unnamed.or_else(|| text.runs.first())
        }
        Some(name) => {
            let found = text.runs.iter().find(|run| run.name.as_deref() == Some(name));
            Some(found.ok_or_else(|| UnknownName::new("run", name, names()))?)
        }
    };
    Ok(Some(Entry::of_text(system_name(&file), &text, chosen)))
}

/// The name of the system in a file, from the file's name.
fn system_name(file: &str) -> String {
    let stem = Path::new(file).file_stem();
    let own = stem.map_or_else(|| file.to_owned(), |stem| stem.to_string_lossy().into_owned());
    let own: String = own
        .chars()
        .map(|c| if c.is_whitespace() { '-' } else { c })
        .collect();
    let own = own.trim_start_matches('-');
    if own.is_empty() { "system" } else { own }.to_owned()
}

/// The system of a plan that names a text file beside it. Where there is no such file, as on another machine than the one where the sweep was
/// begun, the text in the folder of the sweep is taken: only its declaration is used, and no file that it names is read. `None` if the plan names
/// no text file.
#[cfg(feature = "sweep")]
pub fn system_of_plan(
    name: Option<&str>,
    plan: &Path,
    out: &Path,
    constants: &[(String, f64)],
) -> Result<Option<Entry>, CliError> {
    let Some((file, run)) = name.and_then(file_and_run) else {
        return Ok(None);
    };
    let path = plan.parent().unwrap_or(Path::new("")).join(&file);
    if !path.exists()
        && let Ok(text) = crate::sweep::text(out)
    {
        tell(format_args!(
            "note: there is no {}; its text in {} is taken",
            path.display(),
            out.display()
        ));
        let own = system_name(&file);
        let text = Text::parse(&own, &text)?;
        return Ok(Some(Entry::of_text(own, &text, text.runs.first())));
    }
    let path = path.to_string_lossy();
    match run {
        Some(run) => entry(&format!("{path}:{run}"), constants),
        None => entry(&path, constants),
    }
}
