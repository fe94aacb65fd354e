//! What can be chosen about a file besides its format.

use super::format::Format;
use piad_fit::data::Grid;

/// What can be chosen about a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// The number of samples in each direction, at least 2, for formats that sample; chosen to suit the
    /// curve or surface by default.
    pub samples: Option<Grid>,
    /// Whether drawings show data points.
    pub dots: Dots,
    /// The unit of length that a file declares: millimetres by default, in formats that have one.
    pub unit: Option<Unit>,
}

/// What a coordinate of 1 is long. Coordinates themselves are those of the data in any unit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Unit {
    /// A millimetre.
    #[default]
    Millimetre,
    /// A metre.
    Metre,
    /// An inch, 25.4 millimetres.
    Inch,
}

/// Whether a drawing shows data points as dots.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Dots {
    /// Where they do not hide each other.
    #[default]
    Auto,
    /// Always.
    On,
    /// Never.
    Off,
}

impl Format {
    /// Whether files of this format can show data points.
    pub fn has_dots(self) -> bool {
        self == Self::Svg
    }

    /// Whether files of this format consist of samples: the others hold the exact curve or surface.
    pub fn has_samples(self) -> bool {
        !matches!(self, Self::Step | Self::Iges | Self::Obj)
    }

    /// Whether files of this format declare a unit of length that can be chosen. That of glTF is always
    /// the metre.
    pub fn has_unit(self) -> bool {
        matches!(self, Self::Step | Self::Iges)
    }
}
