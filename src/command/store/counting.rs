//! Reports the number of jobs examined.

use std::io::{IsTerminal, stderr};

use indicatif::ProgressBar;

/// Shows the number of jobs examined, on a terminal.
pub(super) fn counter() -> ProgressBar {
    match stderr().is_terminal() {
        true => ProgressBar::new_spinner(),
        false => ProgressBar::hidden(),
    }
}

/// A number of jobs in words.
pub(super) fn jobs(count: usize) -> String {
    match count {
        1 => "1 job".to_owned(),
        count => format!("{count} jobs"),
    }
}
