//! Authorization of requests.

use std::collections::BTreeMap;

use crate::access::scope::Scope;

/// The authorization that a request needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::api) enum Needs {
    /// None.
    Nothing,
    /// A token with this scope.
    A(Scope),
}

/// The authorization of the methods of each path.
pub(in crate::api) type Methods = BTreeMap<&'static str, Vec<(&'static str, Needs)>>;
