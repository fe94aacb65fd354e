//! Options of a file besides its format.

use super::error::ExportError;
use super::format::Format;
use crate::wgs84::{Origin, Plane};
use piad_fit::data::Grid;

/// Options of a file.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Options {
    /// The number of samples in each direction, at least 2, for formats that sample; chosen to suit the
    /// curve or surface by default.
    pub samples: Option<Grid>,
    /// The choice to show data points in drawings.
    pub dots: Dots,
    /// The unit of length that a file declares: millimetres by default, in formats that have one.
    pub unit: Option<Unit>,
    /// The contents of an SVG file.
    pub style: Style,
    /// The version of DXF.
    pub version: Version,
    /// The origin of the coordinates on the earth, for formats with longitudes and latitudes.
    pub origin: Option<Origin>,
    /// The distance between samples along a curve, in units of the data, instead of their number: they are at most this
    /// far apart, all equally far, and the first and the last one are the ends.
    pub spacing: Option<f64>,
    /// True if samples of a curve are at equal distances along it, instead of at equal steps of the parameter.
    pub by_length: bool,
}

impl Options {
    /// Returns true if samples are at equal distances along a curve.
    pub(super) fn is_by_length(&self) -> bool {
        self.by_length || self.spacing.is_some()
    }
}

/// The contents of an SVG file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Style {
    /// A fit with its data, for people. Files of several parts have no data, so that they are always paths.
    #[default]
    Drawing,
    /// Curves alone, as paths of cubic Bézier curves in the units of the data, for editors and plotters.
    Path,
}

/// A version of DXF.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Version {
    /// AutoCAD R12: polylines and polygon meshes, which all programs read.
    #[default]
    R12,
    /// AutoCAD R2000: exact splines.
    R2000,
}

/// The length of the unit. Coordinates themselves are those of the data in any unit.
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

/// The choice to show data points as dots.
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
    /// Returns true if files of this format can show data points.
    pub fn has_dots(self) -> bool {
        self == Self::Svg
    }

    /// Returns true if files of this format consist of samples: the others hold the exact curve or surface.
    pub fn has_samples(self) -> bool {
        !matches!(self, Self::Step | Self::Iges | Self::Obj)
    }

    /// Returns true if files of this format have a style to choose.
    pub fn has_style(self) -> bool {
        self == Self::Svg
    }

    /// Returns true if files of this format have a version to choose.
    pub fn has_version(self) -> bool {
        self == Self::Dxf
    }

    /// Returns true if files of this format hold longitudes and latitudes if there is an origin.
    pub fn has_origin(self) -> bool {
        matches!(self, Self::GeoJson | Self::Gpx)
    }

    /// Returns true if files of this format have samples of curves, which can be at equal distances.
    pub fn has_spacing(self) -> bool {
        matches!(
            self,
            Self::Gltf | Self::Dxf | Self::GeoJson | Self::Gpx | Self::Csv
        )
    }

    /// Returns true if files of this format declare a unit of length that can be chosen. That of glTF is always the
    /// metre.
    pub fn has_unit(self) -> bool {
        matches!(self, Self::Step | Self::Iges)
    }
}

/// Checks that a format supports the chosen options, for a curve or a surface.
pub fn check_options(format: Format, surface: bool, options: &Options) -> Result<(), ExportError> {
    let no_option = |option, has| ExportError::NoOption {
        format,
        option,
        has,
    };
    if options.unit.is_some() && !format.has_unit() {
        return Err(ExportError::NoUnit { format });
    }
    if options.style == Style::Path && !format.has_style() {
        return Err(no_option("style", "svg"));
    }
    if options.style == Style::Path && surface {
        return Err(ExportError::NoLine {
            format,
            what: "paths are curves",
            instead: "a drawing",
        });
    }
    if options.version != Version::R12 && !format.has_version() {
        return Err(no_option("version", "dxf"));
    }
    if let Some(what) = exact(format, surface, options)
        && (options.samples.is_some() || options.is_by_length())
    {
        return Err(ExportError::NoSamples { what });
    }
    check_spacing(format, surface, options)?;
    if format == Format::Gpx && options.origin.is_none() {
        return Err(ExportError::NoOrigin { format });
    }
    if let Some(origin) = options.origin.filter(|_| format.has_origin()) {
        plane(origin)?;
    }
    Ok(())
}

/// Checks samples at equal distances.
fn check_spacing(format: Format, surface: bool, options: &Options) -> Result<(), ExportError> {
    if !options.is_by_length() {
        return Ok(());
    }
    if !format.has_spacing() {
        return Err(ExportError::NoOption {
            format,
            option: "spacing",
            has: "gltf, dxf, geojson, gpx and csv",
        });
    }
    if surface {
        return Err(ExportError::NoSpacing);
    }
    match options.spacing {
        Some(spacing) if !(spacing > 0.0 && spacing.is_finite()) => {
            Err(ExportError::Spacing { spacing })
        }
        Some(_) if options.samples.is_some() => Err(ExportError::SpacingAndSamples),
        _ => Ok(()),
    }
}

/// Files that are exact because of an option, although their format has samples.
fn exact(format: Format, surface: bool, options: &Options) -> Option<&'static str> {
    match format {
        Format::Dxf if options.version == Version::R2000 && !surface => {
            Some("curves in dxf files of version r2000")
        }
        Format::Svg if options.style == Style::Path => Some("paths in svg files"),
        _ => None,
    }
}

/// The plane of an origin, if that is a place on the earth.
pub(super) fn plane(origin: Origin) -> Result<Plane, ExportError> {
    let Origin {
        longitude,
        latitude,
    } = origin;
    match (-360.0..=360.0).contains(&longitude) && (-90.0..=90.0).contains(&latitude) {
        true => Ok(Plane::new(longitude, latitude)),
        false => Err(ExportError::Origin {
            longitude,
            latitude,
        }),
    }
}
