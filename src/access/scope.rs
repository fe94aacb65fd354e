//! Permissions of tokens.

use std::fmt;

use clap::ValueEnum;
use serde::{Deserialize, Serialize};

/// A permission. Each route and each call needs one, or none.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, ValueEnum, Serialize, Deserialize,
)]
pub enum Scope {
    /// Listing jobs, and reading them, their streams, iterations and results.
    #[serde(rename = "jobs:read")]
    #[value(name = "jobs:read")]
    JobsRead,
    /// Making, editing, cancelling and deleting jobs, and fits without a job.
    #[serde(rename = "jobs:write")]
    #[value(name = "jobs:write")]
    JobsWrite,
    /// Reading the metrics of the server as a whole and of the tenant of the token.
    #[serde(rename = "metrics")]
    #[value(name = "metrics")]
    Metrics,
    /// Reading the metrics, those of all tenants included: for those who run the server.
    #[serde(rename = "metrics:all")]
    #[value(name = "metrics:all")]
    MetricsAll,
    /// All permissions.
    #[serde(rename = "admin")]
    #[value(name = "admin")]
    Admin,
}

impl Scope {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::JobsRead => "jobs:read",
            Self::JobsWrite => "jobs:write",
            Self::Metrics => "metrics",
            Self::MetricsAll => "metrics:all",
            Self::Admin => "admin",
        }
    }
}

impl fmt::Display for Scope {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
