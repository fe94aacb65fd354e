//! Detects the format of a file by its content.

/// The formats that are read as bytes: they are binary, or have binary variants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ByteFormat {
    /// A scan in LAS.
    Las,
    /// A cloud in PCD.
    Pcd,
    /// A mesh or a cloud in PLY.
    Ply,
    /// A mesh in binary STL.
    Stl,
}

impl ByteFormat {
    /// The format of a file; `None` if it is read as text or not at all.
    pub(super) fn of(file: &[u8]) -> Option<Self> {
        Some(match () {
            // Such a file may begin with any bytes; its size identifies it.
            () if super::stl::is_binary(file) => Self::Stl,
            () if super::las::is_las(file) => Self::Las,
            () if super::ply::is_ply(file) => Self::Ply,
            () if super::pcd::is_pcd(file) => Self::Pcd,
            () => return None,
        })
    }
}

/// The formats that are read as text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Format {
    /// A JSON array of points, of rows of points or of rows of heights.
    Array,
    /// Drawings.
    Dxf,
    /// Tool paths.
    GCode,
    /// Lines, polygons and points of maps.
    GeoJson,
    /// Tracks, routes and waypoints.
    Gpx,
    /// Lines, rings and tracks of maps.
    Kml,
    /// The vertices of a mesh in OFF.
    Off,
    /// A mesh in STL.
    Stl,
    /// A mesh or polylines in OBJ.
    Obj,
    /// A scan in PTS.
    Pts,
    /// An ASCII grid of ESRI.
    EsriGrid,
    /// Outlines.
    Svg,
    /// Lines of numbers: CSV, whitespace-separated tables, XYZ, airfoils.
    Table,
}

impl Format {
    /// The format of a text.
    pub(super) fn of(text: &str) -> Self {
        match () {
            () if super::array::is_array(text) => Self::Array,
            () if super::dxf::is_dxf(text) => Self::Dxf,
            () if super::geojson::is_geojson(text.as_bytes()) => Self::GeoJson,
            () if super::gpx::is_gpx(text) => Self::Gpx,
            () if super::kml::is_kml(text) => Self::Kml,
            () if super::svg::is_svg(text) => Self::Svg,
            () if super::gcode::is_gcode(text) => Self::GCode,
            () if super::off::is_off(text) => Self::Off,
            () if super::stl::is_text(text) => Self::Stl,
            () if super::obj::is_obj(text) => Self::Obj,
            () if super::esri_grid::is_grid(text) => Self::EsriGrid,
            () if super::pts::is_pts(text) => Self::Pts,
            () => Self::Table,
        }
    }
}
