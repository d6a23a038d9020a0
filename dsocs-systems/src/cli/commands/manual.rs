//! `completions` and `man`: completions for shells and pages of the manual, generated from the parser of the
//! arguments.

use std::path::PathBuf;

use clap::Args;
use clap_complete::Shell;
use clap_mangen::Man;

use crate::cli::output;
use crate::cli::output::terminal;
use crate::cli::{CliError, Program};

/// The arguments of `completions`.
#[derive(Args, Debug)]
pub struct CompletionsArguments {
    /// The shell
    #[arg(value_enum)]
    shell: Shell,
}

/// The arguments of `man`.
#[derive(Args, Debug)]
pub struct ManArguments {
    /// The command whose page is written, one of those that `--help` lists [default: the page of the program]
    command: Option<String>,
    /// Write the pages of the program and of all commands to this folder
    #[arg(long, value_name = "DIR", conflicts_with = "command")]
    out: Option<PathBuf>,
}

/// Writes the completions of a shell to standard output.
///
/// # Errors
///
/// [`CliError`] if they cannot be written.
pub fn completions(arguments: &CompletionsArguments, program: &Program) -> Result<(), CliError> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut program.syntax(), &program.name, &mut script);
    terminal::print(&script)
}

/// Writes a page of the manual to standard output, or all of them to a folder.
///
/// # Errors
///
/// [`CliError`] if there is no such command, or they cannot be written.
pub fn man(arguments: &ManArguments, program: &Program) -> Result<(), CliError> {
    let mut whole = program.syntax();
    whole.build();
    if let Some(folder) = &arguments.out {
        output::check_folder(folder)?;
        let commands = whole
            .get_subcommands()
            .filter(|command| command.get_name() != "help");
        for command in [&whole].into_iter().chain(commands) {
            let page = Man::new(page_command(command));
            output::write(&folder.join(page.get_filename()), &rendered(&page, folder)?)?;
        }
        return Ok(());
    }
    let command = match &arguments.command {
        None => &whole,
        Some(name) => whole.find_subcommand(name).ok_or_else(|| {
            let known = whole
                .get_subcommands()
                .map(|command| command.get_name().to_owned());
            CliError::Unknown(crate::entry::UnknownName::new("command", name, known))
        })?,
    };
    let page = rendered(&Man::new(page_command(command)), "-".as_ref())?;
    terminal::print(&page)
}

/// A command under the name of its page, `dsocs-run`.
fn page_command(command: &clap::Command) -> clap::Command {
    let name = command
        .get_display_name()
        .unwrap_or(command.get_name())
        .to_owned();
    command.clone().name(name)
}

/// The text of a page.
fn rendered(page: &Man, place: &std::path::Path) -> Result<Vec<u8>, CliError> {
    let mut text = Vec::new();
    page.render(&mut text).map_err(|cause| CliError::Write {
        path: place.to_owned(),
        cause,
    })?;
    Ok(text)
}
