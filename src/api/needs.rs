//! What requests need to be answered.

use std::collections::BTreeMap;

use crate::access::scope::Scope;

/// What a request needs to be answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::api) enum Needs {
    /// Nothing: everybody may know it.
    Nothing,
    /// A token with this scope.
    A(Scope),
}

/// What the methods of each path need.
pub(in crate::api) type Methods = BTreeMap<&'static str, Vec<(&'static str, Needs)>>;
