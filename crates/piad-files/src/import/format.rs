//! What a file is, by what is in it.

/// The formats that are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Format {
    /// A JSON array of points, of rows of points or of rows of heights.
    Array,
    /// Drawings.
    Dxf,
    /// Paths of tools.
    GCode,
    /// Lines, polygons and points of maps.
    GeoJson,
    /// Tracks, routes and waypoints.
    Gpx,
    /// The vertices of a mesh in OFF.
    Off,
    /// Outlines.
    Svg,
    /// Lines of numbers: CSV, tables with blanks, XYZ, airfoils.
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
            () if super::svg::is_svg(text) => Self::Svg,
            () if super::gcode::is_gcode(text) => Self::GCode,
            () if super::off::is_off(text) => Self::Off,
            () => Self::Table,
        }
    }
}
