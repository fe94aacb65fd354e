//! Reasons to deny a request.

use super::scope::Scope;

/// The reason to deny a request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Denial {
    /// It has no token.
    Missing,
    /// Its token is malformed.
    Malformed(&'static str),
    /// Its token is unknown, or was revoked.
    Unknown,
    /// Its token has expired.
    Expired { token: String },
    /// Its token lacks the scope.
    Scope { token: String, needed: Scope },
    /// Its ticket is unknown, is for another stream, or has expired.
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

    /// The id of the token, if it is known.
    pub(crate) fn token(&self) -> Option<&str> {
        match self {
            Self::Expired { token } | Self::Scope { token, .. } => Some(token),
            _ => None,
        }
    }
}
