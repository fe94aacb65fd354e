//! Reasons for a command to fail.

use std::fmt::{self, Display};
use std::io;

use crate::terminal::say;

/// The exit status of a command with invalid arguments.
pub(super) const USAGE: u8 = 2;

/// Why a command has failed, in lines for people.
#[derive(Debug)]
pub(super) enum Failure {
    /// The arguments or the data are invalid.
    Usage(Vec<String>),
    /// The operation failed.
    Failed(String),
    /// The reader of the standard output has gone, which needs no message.
    Closed,
}

impl Failure {
    /// Invalid arguments.
    pub(super) fn usage(line: impl Into<String>) -> Self {
        Self::Usage(vec![line.into()])
    }

    /// An operation with a file failed.
    pub(super) fn of_file(name: impl Display, reason: &io::Error) -> Self {
        Self::Failed(format!("{name}: {reason}"))
    }

    /// The exit status of the program.
    pub(super) fn status(&self) -> u8 {
        match self {
            Self::Usage(_) => USAGE,
            Self::Failed(_) | Self::Closed => 1,
        }
    }

    /// Writes it to the standard error.
    pub(super) fn tell(&self) {
        match self {
            // Each line begins with the file, as in compiler messages.
            Self::Usage(lines) => lines.iter().for_each(say),
            Self::Failed(line) => say(format_args!("piad: {line}")),
            Self::Closed => {}
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Usage(lines) => f.write_str(&lines.join("; ")),
            Self::Failed(line) => f.write_str(line),
            Self::Closed => f.write_str("the standard output is closed"),
        }
    }
}
