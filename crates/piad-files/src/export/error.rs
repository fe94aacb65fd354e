//! Errors of writing a curve or surface.

use std::fmt;

use thiserror::Error;

use super::format::Format;
use crate::text::quoted;

/// Why a curve or surface cannot be written in a format.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ExportError {
    /// Values of a function have no place in the plane or in space.
    #[error(
        "{format} holds curves and surfaces of the plane or of space, and these points have one coordinate: \
         export csv, or fit points that have their argument as a coordinate; give heights a spacing"
    )]
    OneCoordinate {
        /// The requested format.
        format: Format,
    },
    /// Points with more coordinates than those of space.
    #[error(
        "{format} holds curves and surfaces of the plane or of space, and these points have {dimension} coordinates: \
         export csv or json"
    )]
    ManyCoordinates {
        /// The requested format.
        format: Format,
        /// The number of coordinates.
        dimension: usize,
    },
    /// Rational B-splines need positive weights.
    #[error(
        "the weight of control point {place} is {weight}, and rational curves and surfaces are only exported \
         with positive weights: choose another iteration, or export csv"
    )]
    Weight {
        /// The control point, in the complete net.
        place: NetIndex,
        /// Its weight.
        weight: f64,
    },
    /// CAD systems do not load files with such a degree.
    #[error(
        "the degree is {degree}, and CAD systems read curves and surfaces up to degree {most} from {format} files: \
         fit B-splines, or export another format"
    )]
    Degree {
        /// The requested format.
        format: Format,
        /// The degree.
        degree: usize,
        /// The highest degree that is written.
        most: usize,
    },
    /// A coordinate is infinite or NaN.
    #[error("coordinate {coordinate} of {what} {place} is {value}, and files hold finite numbers")]
    NotFinite {
        /// A control point or a sample.
        what: &'static str,
        /// Its index.
        place: NetIndex,
        /// The coordinate, counted from 0.
        coordinate: usize,
        /// Its value.
        value: f64,
    },
    /// A unit was chosen for a format without units.
    #[error("{format} files have {}; step and iges files have a unit to choose", unit_of(*format))]
    NoUnit {
        /// The requested format.
        format: Format,
    },
    /// A curve has no triangles.
    #[error(
        "{format} files hold the triangles of surfaces, and a curve has none: export dxf, gltf or step"
    )]
    NoTriangles {
        /// The requested format.
        format: Format,
    },
    /// An edge of a trimmed surface is a point.
    #[error(
        "the outline of the trimmed surface goes through a pole, where an edge would be a point, which {format} files do not hold: \
         export gltf, stl or ply"
    )]
    TrimmedAtPole {
        /// The requested format.
        format: Format,
    },
    /// A trimmed surface has no rows and columns.
    #[error(
        "{format} files hold surfaces as meshes of rows and columns, and a trimmed one has none: export step, gltf or stl"
    )]
    Trimmed {
        /// The requested format.
        format: Format,
    },
    /// The loops of a trimmed surface cross where they are sampled.
    #[error(
        "the outline of the trimmed surface crosses itself between samples: ask for more samples"
    )]
    NoTriangulation,
    /// A surface is no line.
    #[error("{format} {what}, and a surface is none: export {instead}")]
    NoLine {
        /// The requested format.
        format: Format,
        /// The contents of files of the format.
        what: &'static str,
        /// Formats that hold surfaces.
        instead: &'static str,
    },
    /// Longitudes and latitudes need a place on the earth.
    #[error(
        "{format} files hold longitudes and latitudes, and the coordinates have no place on the earth: choose an \
         origin (longitude and latitude), which the coordinates are metres to the east and north of, or export geojson"
    )]
    NoOrigin {
        /// The requested format.
        format: Format,
    },
    /// The origin is not a place on the earth.
    #[error(
        "the origin has longitude {longitude} and latitude {latitude}: they are degrees, up to 180 and up to 90"
    )]
    Origin {
        /// Its longitude.
        longitude: f64,
        /// Its latitude.
        latitude: f64,
    },
    /// Metres beyond the horizon of the origin.
    #[error(
        "a point is {east} m to the east and {north} m to the north of the origin, and no place on the earth is: \
         {format} files need coordinates in metres from their origin"
    )]
    OffTheEarth {
        /// The requested format.
        format: Format,
        /// Metres to the east.
        east: f64,
        /// Metres to the north.
        north: f64,
    },
    /// The format does not have this option.
    #[error("{format} files have no {option} to choose; {has} files have")]
    NoOption {
        /// The requested format.
        format: Format,
        /// The option.
        option: &'static str,
        /// The formats that have it.
        has: &'static str,
    },
    /// Samples were requested for a file without any.
    #[error("{what} are no samples, so that their number cannot be chosen")]
    NoSamples {
        /// The files.
        what: &'static str,
    },
    /// The spacing is not a distance.
    #[error("the spacing is {spacing}, and it is a distance between samples, more than 0")]
    Spacing {
        /// The spacing.
        spacing: f64,
    },
    /// Both a spacing and a number of samples were given.
    #[error("spacing and samples both choose the number of samples: give one of them")]
    SpacingAndSamples,
    /// Surfaces have rows and columns of samples.
    #[error(
        "samples at equal distances are those of curves: choose the number of samples of a surface in each direction"
    )]
    NoSpacing,
    /// The spacing is too small for the curve.
    #[error(
        "the curve is {length} long, and with a spacing of {spacing} it would have more than {most} samples: choose a larger one"
    )]
    TooManySamples {
        /// The spacing.
        spacing: f64,
        /// The length of the curve.
        length: f64,
        /// The most samples.
        most: usize,
    },
    /// More samples than a mesh of the format can have.
    #[error(
        "polygon meshes of {format} files have at most {most} samples in each direction: ask for fewer, or export gltf or stl"
    )]
    MeshSize {
        /// The requested format.
        format: Format,
        /// The most samples in each direction.
        most: usize,
    },
    /// A coordinate that the numbers of the format cannot hold.
    #[error("a coordinate is {value}, and {format} holds single-precision numbers, up to 3.4e38")]
    SinglePrecision {
        /// The requested format.
        format: Format,
        /// The coordinate.
        value: f64,
    },
    /// The extent is beyond the range of 64-bit floating-point numbers.
    #[error(
        "the numbers of the curve or surface, or their sums, are beyond the range of 64-bit numbers, so that it cannot \
         be drawn: export csv or json, or scale the data"
    )]
    Extent,
    /// A file without curves and surfaces.
    #[error("there is no curve or surface to write to a {format} file")]
    NoParts {
        /// The requested format.
        format: Format,
    },
    /// One of several parts cannot be written.
    #[error("part {number}{}: {reason}", in_brackets(name.as_deref()))]
    InPart {
        /// The number of the part, from 1.
        number: usize,
        /// Its name.
        name: Option<String>,
        /// The reason.
        reason: Box<ExportError>,
    },
    /// Tables have the same columns for all parts.
    #[error(
        "its columns are {found} and those of the first part {expected}: all parts of a {format} file have the same columns"
    )]
    OtherColumns {
        /// The requested format.
        format: Format,
        /// The columns of the part.
        found: String,
        /// The columns of the first part.
        expected: String,
    },
    /// A binary file counts its bytes or its elements with 32 bits.
    #[error(
        "the file would be larger than the 4 GB that {format} files can have: ask for fewer samples, or write several files"
    )]
    TooLarge {
        /// The requested format.
        format: Format,
    },
    /// IGES numbers its lines with seven digits.
    #[error(
        "{lines} lines of parameter data are more than the {most} that an IGES file numbers: export step"
    )]
    TooManyLines {
        /// The number of lines needed.
        lines: usize,
        /// The most lines.
        most: usize,
    },
}

impl ExportError {
    /// The option in question, if there is one: `style`, `version`, `units`, `samples`, `spacing` or `origin`.
    pub fn option(&self) -> Option<&'static str> {
        match self {
            Self::NoUnit { .. } => Some("units"),
            Self::NoOption { option, .. } => Some(option),
            Self::NoSamples { .. } => Some("samples"),
            Self::Spacing { .. }
            | Self::SpacingAndSamples
            | Self::NoSpacing
            | Self::TooManySamples { .. } => Some("spacing"),
            Self::NoOrigin { .. } | Self::Origin { .. } | Self::OffTheEarth { .. } => {
                Some("origin")
            }
            _ => None,
        }
    }

    /// The error of the part with this number, from 1.
    pub(super) fn in_part(self, number: usize, name: Option<&str>) -> Self {
        Self::InPart {
            number,
            name: name.map(str::to_owned),
            reason: Box::new(self),
        }
    }
}

/// The name of a part behind its number.
fn in_brackets(name: Option<&str>) -> String {
    name.map_or_else(String::new, |name| format!(" ({})", quoted(name)))
}

/// The unit of a format without a choice of units.
fn unit_of(format: Format) -> &'static str {
    match format {
        Format::Gltf => "metres as their unit, always",
        _ => "no unit of length",
    }
}

/// The place of a control point or sample: an index on curves, row and column on surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NetIndex {
    /// The index on a curve; the row on a surface.
    pub row: usize,
    /// The column on a surface.
    pub column: Option<usize>,
}

impl NetIndex {
    /// The location of number `index`, row by row, in a net with this many columns (`None`: a curve).
    pub fn new(index: usize, columns: Option<usize>) -> Self {
        Self {
            row: index / columns.unwrap_or(1),
            column: columns.map(|columns| index % columns),
        }
    }
}

impl fmt::Display for NetIndex {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.column {
            None => write!(f, "{}", self.row),
            Some(column) => write!(f, "[{}, {column}]", self.row),
        }
    }
}
