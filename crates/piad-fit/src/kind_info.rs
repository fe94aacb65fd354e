//! Names and sources of methods and bases.
//!
//! The tables are [`METHODS`](super::method::METHODS) and [`BASES`](super::basis::BASES).

/// An entry of a table of methods or bases, in the terms of the field. Names, schemas and OpenAPI
/// descriptions derive from it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KindInfo {
    /// The name: lower case, with underscores between words.
    pub name: &'static str,
    /// The term that the literature uses.
    pub title: &'static str,
    /// What it does, in one sentence.
    pub summary: &'static str,
    /// The publication and equation that it follows.
    pub source: &'static str,
}
