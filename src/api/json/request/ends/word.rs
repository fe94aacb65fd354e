//! Ends that are named by a word.

use crate::api::json::read::names;

/// An end without vectors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::api) enum EndWord {
    Estimated,
    Repeated,
    Natural,
}

names!(EndWord, "rule for ends", [
    "estimated" => Estimated,
    "repeated" => Repeated,
    "natural" => Natural,
]);
