//! Why somebody is turned away.

use super::scope::Scope;

/// Why a request is not answered.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Denial {
    /// It has no token.
    Missing,
    /// It has no token in the form in which tokens come.
    Malformed(&'static str),
    /// Its token is none of this server, or not any more.
    Unknown,
    /// The time of its token is over.
    Expired { token: String },
    /// Its token is not good for this.
    Scope { token: String, needed: Scope },
    /// Its ticket is none of this server, is for another stream, or its time is over.
    Ticket,
}

impl Denial {
    /// Its name in the metrics and in the log.
    pub(crate) fn name(&self) -> &'static str {
        match self {
            Self::Missing => "missing",
            Self::Malformed(_) => "malformed",
            Self::Unknown => "unknown",
            Self::Expired { .. } => "expired",
            Self::Scope { .. } => "scope",
            Self::Ticket => "ticket",
        }
    }

    /// The id of the token, where it is known whose it is.
    pub(crate) fn token(&self) -> Option<&str> {
        match self {
            Self::Expired { token } | Self::Scope { token, .. } => Some(token),
            _ => None,
        }
    }
}
