//! How far a job has come.

use crate::fit::iteration::Level;
use crate::fit::system::Forecast;

/// The first and the last level that a job has reached.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Levels {
    /// Level 0.
    pub first: Level,
    /// The last level so far.
    pub last: Level,
    /// What is known about the convergence.
    pub forecast: Forecast,
}
