//! A file of settings: TOML, with the names of the flags.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use clap::Command;
use toml::{Table, Value};

use crate::files;
use crate::redact::redacted;
use crate::terminal::escaped;
use crate::toml_text;

/// The settings of a file.
#[derive(Debug)]
pub(super) struct SettingsFile {
    pub(super) path: PathBuf,
    /// The values of each setting, as they would follow its flag.
    values: BTreeMap<String, Vec<String>>,
}

impl SettingsFile {
    /// Reads a file; the error names it, and the line or the setting, but shows no value.
    pub(super) fn read(path: &Path, server: &Command) -> Result<Self, String> {
        let wrong = |reason: String| {
            let message = format!("{}: {reason}", path.display());
            escaped(&message).into_owned()
        };
        let text = files::read_settings(path).map_err(|reason| wrong(reason.to_string()))?;
        let table: Table = toml_text::parse(&text).map_err(wrong)?;
        let mut values = BTreeMap::new();
        for (name, value) in table {
            if name == "config"
                || !server
                    .get_arguments()
                    .any(|it| it.get_long() == Some(&name))
            {
                return Err(wrong(format!(
                    "there is no setting {}: piad --help has them all",
                    redacted(&name)
                )));
            }
            let Some(texts) = texts(value) else {
                let kinds = "a text, a number, true or false, or several of them in brackets";
                return Err(wrong(format!("{name} is not {kinds}")));
            };
            values.insert(name, texts);
        }
        let path = path.to_owned();
        Ok(Self { path, values })
    }

    /// Returns true if the file has a setting.
    pub(super) fn sets(&self, name: &str) -> bool {
        self.values.contains_key(name)
    }

    /// The command with these settings in the place of its defaults.
    pub(super) fn beneath(&self, command: Command) -> Command {
        command.mut_args(|argument| {
            let values = argument.get_long().and_then(|name| self.values.get(name));
            match values.cloned() {
                Some(values) => argument.default_values(values),
                None => argument,
            }
        })
    }
}

/// A value as it would follow a flag; several of a list.
fn texts(value: Value) -> Option<Vec<String>> {
    match value {
        Value::Array(values) => values.into_iter().map(text).collect(),
        value => Some(vec![text(value)?]),
    }
}

fn text(value: Value) -> Option<String> {
    match value {
        Value::String(text) => Some(text),
        Value::Integer(number) => Some(number.to_string()),
        Value::Float(number) => Some(number.to_string()),
        Value::Boolean(is_so) => Some(is_so.to_string()),
        Value::Datetime(_) | Value::Array(_) | Value::Table(_) => None,
    }
}
