//! Readers of point files and writers of geometry files.
//!
//! - [`import`]: CSV, whitespace-separated tables, point clouds, height grids, airfoils, JSON arrays, mesh vertices,
//!   tracks (GPX), maps (GeoJSON), drawings (DXF, SVG) and tool paths (G-code) become points;
//!   [`json`]: points in JSON;
//! - [`export`]: a fitted curve or surface becomes STEP, IGES, OBJ, glTF, STL, PLY, DXF, SVG, GeoJSON, GPX or CSV.
//! - [`wgs84`]: longitudes and latitudes as metres in a plane, and back.
//!
//! Nothing here opens a file: functions take and return bytes.
//!
//! # Example
//!
//! Points of a table, a curve through them, and its STEP file:
//!
//! ```
//! use piad_files::export::{Fitted, Format, write};
//! use piad_files::import::{Hints, read};
//! use piad_fit::Fit;
//!
//! let file = read(b"x,y\n0,0\n1,2\n3,3\n5,2\n6,0\n", &Hints::default())?;
//! let fit = Fit::curve(file.points).tolerance(1e-9).prepare()?;
//! let level = fit.levels().last().ok_or("no level")?;
//! let step = write(Format::Step, &Fitted::of(&level))?;
//! assert!(step.starts_with(b"ISO-10303-21;"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod export;
pub mod import;
pub mod json;
#[doc(hidden)]
pub mod text;
pub mod wgs84;
