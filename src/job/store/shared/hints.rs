//! Hints: notifications between replicas.

use std::fmt;

use uuid::Uuid;

/// An event at another replica, or at this one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Hint {
    /// A job waits that has no replica.
    Queued,
    /// A job that has waited runs now.
    Started(Uuid),
    /// A job has ended.
    Ended(Uuid),
    /// A job was deleted.
    Deleted(Uuid),
    /// A job is to be cancelled by the replica that runs it.
    Cancel(Uuid),
}

impl Hint {
    /// The hint of a payload.
    pub(super) fn of(payload: &str) -> Option<Self> {
        if payload == "queued" {
            return Some(Self::Queued);
        }
        let (what, id) = payload.split_once(' ')?;
        let id = Uuid::try_parse(id).ok()?;
        match what {
            "started" => Some(Self::Started(id)),
            "ended" => Some(Self::Ended(id)),
            "deleted" => Some(Self::Deleted(id)),
            "cancel" => Some(Self::Cancel(id)),
            _ => None,
        }
    }
}

impl fmt::Display for Hint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Queued => f.write_str("queued"),
            Self::Started(id) => write!(f, "started {id}"),
            Self::Ended(id) => write!(f, "ended {id}"),
            Self::Deleted(id) => write!(f, "deleted {id}"),
            Self::Cancel(id) => write!(f, "cancel {id}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn payloads_are_read() {
        let id = Uuid::now_v7();
        let all = [Hint::Started, Hint::Ended, Hint::Deleted, Hint::Cancel].map(|hint| hint(id));
        for hint in [&[Hint::Queued], &all[..]].concat() {
            assert_eq!(Hint::of(&hint.to_string()), Some(hint));
        }
        for other in ["", "ended", "ended x", &format!("begun {id}")] {
            assert_eq!(Hint::of(other), None);
        }
    }
}
