//! DXF, the exchange format of AutoCAD.
//!
//! By default R12, which all DXF software reads: a polyline through samples of a curve, a polygon mesh through samples
//! of a surface. This version has no units, and numbers are text. With [`Version::R2000`] curves are exact splines;
//! surfaces stay polygon meshes, as DXF has no spline surfaces outside of solids.

mod groups;
mod layers;
mod r12;
mod r2000;
mod sampled;
mod skeleton;

use super::document::Document;
use super::error::ExportError;
use super::options::Version;

/// The curves and surfaces as a DXF file, an entity each, on layers with the names of parts.
pub(super) fn write(document: &Document<'_>) -> Result<Vec<u8>, ExportError> {
    match document.options.version {
        Version::R12 => r12::write(document),
        Version::R2000 => r2000::write(document),
    }
}
