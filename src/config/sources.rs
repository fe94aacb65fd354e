//! The sources of settings: flags first, then variables, then the file, then the defaults.

use std::ffi::OsString;
use std::fmt::Write;
use std::path::PathBuf;

use clap::error::{ContextKind, ContextValue, Error, ErrorKind};
use clap::parser::ValueSource;
use clap::{Arg, ArgAction, ArgMatches, Command, CommandFactory, FromArgMatches};
use toml::Value;

use super::cli::Cli;
use super::file::SettingsFile;
use crate::redact::{has_secret, redacted};
use crate::terminal::escaped;

/// The commands that take settings of a server.
const OF_SERVERS: [&str; 3] = ["serve", "config", "health"];

/// The sources of the settings of a server.
#[derive(Debug)]
pub struct Sources {
    command: Command,
    matches: ArgMatches,
    file: Option<SettingsFile>,
}

/// Reads the command line, and the file of settings if it or a variable names one.
///
/// # Errors
///
/// If there are errors in them, or help was requested. Errors show no passwords.
pub fn parse(arguments: Vec<OsString>) -> Result<(Cli, Sources), Error> {
    read(arguments).map_err(without_secrets)
}

fn read(arguments: Vec<OsString>) -> Result<(Cli, Sources), Error> {
    let mut command = Cli::command();
    let mut matches = command.clone().try_get_matches_from(&arguments)?;
    let path = of_server(&matches).and_then(|it| it.get_one::<PathBuf>("config_file"));
    let mut file = None;
    if let Some(path) = path {
        let read = SettingsFile::read(path, &command);
        let read = read.map_err(|reason| command.error(ErrorKind::Io, reason))?;
        command = beneath(command, &read);
        matches = command
            .clone()
            .try_get_matches_from(&arguments)
            .map_err(|error| of_file(&mut command, &read, &without_secrets(error)))?;
        file = Some(read);
    }
    let cli = Cli::from_arg_matches(&matches)?;
    let matches = of_server(&matches).cloned().unwrap_or_default();
    let sources = Sources {
        command,
        matches,
        file,
    };
    Ok((cli, sources))
}

/// The part of the command line with the settings of a server.
fn of_server(matches: &ArgMatches) -> Option<&ArgMatches> {
    match matches.subcommand() {
        None => Some(matches),
        Some((name, of_command)) => OF_SERVERS.contains(&name).then_some(of_command),
    }
}

/// Replaces the defaults by the settings of a file.
fn beneath(command: Command, file: &SettingsFile) -> Command {
    let command = file.beneath(command);
    OF_SERVERS.into_iter().fold(command, |command, name| {
        command.mut_subcommand(name, |it| file.beneath(it))
    })
}

/// The error of a value in a file.
fn of_file(command: &mut Command, file: &SettingsFile, error: &Error) -> Error {
    let text = error.to_string();
    let text = text.lines().next().unwrap_or_default();
    let text = text.trim_start_matches("error: ");
    let path = file.path.display().to_string();
    command.error(error.kind(), format!("{}: {text}", escaped(&path)))
}

/// The error without passwords and control characters in the values that it repeats.
fn without_secrets(mut error: Error) -> Error {
    let shown = |text: &String| escaped(&redacted(text)).into_owned();
    let context = error.context().filter_map(|(kind, value)| {
        let value = match value {
            ContextValue::String(text) => ContextValue::String(shown(text)),
            ContextValue::Strings(texts) => {
                ContextValue::Strings(texts.iter().map(shown).collect())
            }
            _ => return None,
        };
        Some((kind, value))
    });
    let context: Vec<(ContextKind, ContextValue)> = context.collect();
    for (kind, value) in context {
        error.insert(kind, value);
    }
    error
}

impl Sources {
    /// All settings in the form of a file, with the source of each.
    pub fn shown(&self) -> String {
        let mut shown = String::new();
        for argument in self.command.get_arguments() {
            let Some(name) = argument.get_long() else {
                continue;
            };
            if ["config", "help", "version"].contains(&name) {
                continue;
            }
            // Writing to memory cannot fail.
            let _ = match self.value(argument) {
                None => writeln!(shown, "# {name} is not set"),
                Some(value) if is_secret(argument, &value) => {
                    let source = self.source(argument, name);
                    writeln!(
                        shown,
                        "# {name} is a URL, which may hold a password  # {source}"
                    )
                }
                Some(value) => {
                    writeln!(shown, "{name} = {value}  # {}", self.source(argument, name))
                }
            };
        }
        shown
    }

    fn value(&self, argument: &Arg) -> Option<Value> {
        let raw = self.matches.get_raw(argument.get_id().as_str())?;
        let mut values = raw.map(|it| plain(&it.to_string_lossy()));
        match argument.get_action() {
            ArgAction::Append => Some(Value::Array(values.collect())),
            _ => values.next(),
        }
    }

    fn source(&self, argument: &Arg, name: &str) -> String {
        match (
            self.matches.value_source(argument.get_id().as_str()),
            &self.file,
        ) {
            (Some(ValueSource::CommandLine), _) => format!("--{name}"),
            (Some(ValueSource::EnvVariable), _) => {
                let variable = argument.get_env().unwrap_or_default();
                variable.to_string_lossy().into_owned()
            }
            (_, Some(file)) if file.sets(name) => {
                escaped(&file.path.display().to_string()).into_owned()
            }
            _ => "the default".to_owned(),
        }
    }
}

/// Returns true if a value must not be shown: it contains a password, or is the URL of a database.
fn is_secret(argument: &Arg, value: &Value) -> bool {
    match value {
        Value::String(text) => {
            has_secret(text) || argument.is_hide_env_values_set() && text.contains("://")
        }
        Value::Array(values) => values.iter().any(|it| is_secret(argument, it)),
        _ => false,
    }
}

/// A number or a text.
fn plain(text: &str) -> Value {
    let number = text.parse().map(Value::Integer);
    let number = number.or_else(|_| text.parse().map(Value::Boolean));
    number.unwrap_or_else(|_| Value::String(text.to_owned()))
}
