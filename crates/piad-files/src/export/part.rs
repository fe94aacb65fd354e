//! Several curves and surfaces in one file.

use jiff::Timestamp;

use super::nurbs::Nurbs;
use super::options::Options;
use piad_fit::geometry::Outline;

/// A curve or surface of a file with several.
#[derive(Clone, Debug)]
pub struct Part<'a> {
    /// Its name; any text. Names can be equal.
    pub name: Option<&'a str>,
    /// Its geometry: that of a fit ([`checked`](super::nurbs::checked)), or of plain data
    /// ([`assemble`](super::nurbs::assemble)).
    pub nurbs: Nurbs,
    /// The part of a surface that is left, if it is trimmed.
    pub outline: Option<Outline>,
}

/// The properties of a file with several parts.
#[derive(Clone, Copy, Debug)]
pub struct Header<'a> {
    /// The name of the whole, for formats that have one; any text.
    pub name: Option<&'a str>,
    /// The time of creation, for formats that have one. The same parts with the same time give the same file.
    pub created: Timestamp,
    /// The options of the file.
    pub options: Options,
}

impl Header<'_> {
    /// A file without a name.
    pub fn new(created: Timestamp, options: Options) -> Self {
        Self {
            name: None,
            created,
            options,
        }
    }
}
