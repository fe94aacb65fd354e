//! The file formats and their names.

use std::fmt;
use std::str::FromStr;

use thiserror::Error;

/// A file format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Format {
    /// ISO 10303-21 with the schema of AP214: the exact curve or surface, for CAD.
    Step,
    /// IGES 5.3: the exact curve or surface, for older CAD.
    Iges,
    /// Wavefront OBJ with free-form geometry: the exact curve or surface, for modellers.
    Obj,
    /// glTF 2.0 as one binary file: a mesh or a line, for viewers.
    Gltf,
    /// STL in its binary form: the triangles of a surface, for printers.
    Stl,
    /// PLY in its binary form: the mesh of a surface with its normals, for point cloud and scan software.
    Ply,
    /// DXF of AutoCAD R12: a polyline or a polygon mesh, for drafting; of R2000: the exact curve.
    Dxf,
    /// A drawing, for people; or paths, for editors.
    Svg,
    /// GeoJSON: curves as lines, for maps.
    GeoJson,
    /// GPX 1.1: curves as tracks, for navigation.
    Gpx,
    /// Samples with their parameters, for spreadsheets and scripts.
    Csv,
}

/// There is no format with this name.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error(
    "unknown format {0:?}; expected one of step, iges, obj, gltf, stl, ply, dxf, svg, geojson, gpx, csv"
)]
pub struct UnknownFormat(String);

impl Format {
    /// All formats.
    pub const ALL: [Self; 11] = [
        Self::Step,
        Self::Iges,
        Self::Obj,
        Self::Gltf,
        Self::Stl,
        Self::Ply,
        Self::Dxf,
        Self::Svg,
        Self::GeoJson,
        Self::Gpx,
        Self::Csv,
    ];

    /// Name, media type and usual file extension. Media types are those registered with IANA; PLY and GPX have none
    /// there, and get the usual ones.
    fn names(self) -> (&'static str, &'static str, &'static str) {
        match self {
            Self::Step => ("step", "model/step", "step"),
            Self::Iges => ("iges", "model/iges", "igs"),
            Self::Obj => ("obj", "model/obj", "obj"),
            Self::Gltf => ("gltf", "model/gltf-binary", "glb"),
            Self::Stl => ("stl", "model/stl", "stl"),
            Self::Ply => ("ply", "application/x-ply", "ply"),
            Self::Dxf => ("dxf", "image/vnd.dxf", "dxf"),
            Self::Svg => ("svg", "image/svg+xml", "svg"),
            Self::GeoJson => ("geojson", "application/geo+json", "geojson"),
            Self::Gpx => ("gpx", "application/gpx+xml", "gpx"),
            Self::Csv => ("csv", "text/csv", "csv"),
        }
    }

    /// The name of the format in requests.
    pub fn name(self) -> &'static str {
        self.names().0
    }

    /// The media type.
    pub fn media_type(self) -> &'static str {
        self.names().1
    }

    /// The usual extension of file names, without a dot.
    pub fn extension(self) -> &'static str {
        self.names().2
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Format {
    type Err = UnknownFormat;

    /// By name, or by a usual extension of file names.
    fn from_str(text: &str) -> Result<Self, UnknownFormat> {
        let is_called = |format: &Self| format.name() == text || format.extension() == text;
        match text {
            "stp" => Ok(Self::Step),
            _ => Self::ALL
                .into_iter()
                .find(is_called)
                .ok_or_else(|| UnknownFormat(text.to_owned())),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_endings_are_parsed() {
        for format in Format::ALL {
            assert_eq!(format.name().parse(), Ok(format));
            assert_eq!(format.extension().parse(), Ok(format));
        }
        let error = "STEP".parse::<Format>().unwrap_err().to_string();
        for format in Format::ALL {
            assert!(error.contains(format.name()), "{error}");
        }
    }
}
