//! Completions and manual pages, generated from the definitions of the arguments; texts on the
//! standard output.

use std::io::{self, ErrorKind, Write};
use std::process::ExitCode;

use clap::CommandFactory;
use clap_complete::Shell;

use super::failure::Failure;
use crate::config::Cli;
use crate::terminal::escaped;

/// Writes the completions of a shell to the standard output.
pub fn completions(shell: Shell) -> ExitCode {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "piad", &mut script);
    show(&script)
}

/// Writes a manual page to the standard output: of the program, or of one of its commands.
pub fn manual(name: Option<&str>) -> ExitCode {
    let mut program = Cli::command();
    program.build();
    let command = match name {
        None => Some(&program),
        Some(name) => program.find_subcommand(name),
    };
    let Some(command) = command else {
        let name = name.unwrap_or_default();
        let failure = Failure::usage(format!("piad man: there is no command {name}"));
        failure.tell();
        return failure.status().into();
    };
    let mut page = Vec::new();
    // Writing to memory cannot fail.
    let page_made = clap_mangen::Man::new(command.clone()).render(&mut page);
    match page_made {
        Ok(()) => show(&page),
        Err(_) => ExitCode::FAILURE,
    }
}

/// Writes lines to the standard output; names and notes in them do not control the terminal.
pub(super) fn show_lines<'a>(lines: impl IntoIterator<Item = &'a str>) -> ExitCode {
    let lines = lines.into_iter().map(|line| escaped(line) + "\n");
    show(lines.collect::<String>().as_bytes())
}

/// Writes a text to the standard output.
pub fn show(text: &[u8]) -> ExitCode {
    let mut output = io::stdout().lock();
    match output.write_all(text).and_then(|()| output.flush()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(reason) => {
            let failure = Failure::of_file("<stdout>", &reason);
            if reason.kind() != ErrorKind::BrokenPipe {
                failure.tell();
            }
            failure.status().into()
        }
    }
}
