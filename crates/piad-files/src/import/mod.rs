//! Readers of point files: CSV, whitespace-separated tables, point clouds (XYZ, PTS, PCD, LAS), meshes (PLY, STL, OBJ,
//! OFF), height grids (ESRI), airfoils (`.dat`), JSON arrays, tracks, maps, drawings and tool paths.
//!
//! [`read`] returns one part of a file, and [`read_parts`] all of them. They do not depend on HTTP or jobs: files
//! become points, and errors are located by line. The format is detected by the content:
//!
//! - `encoding`: text in UTF-16 becomes UTF-8;
//! - `unread`: file types that are not supported, named in the error;
//! - `number_format`: separators of columns and decimals;
//! - `format`: detection of the format;
//! - `part`: the parts of a file, the output of each reader;
//! - `columns`: columns as a user chooses them; `choice`: columns by their names (`names`) and contents (`sample`);
//!   `column_notice`: notices about them;
//! - `head`: the first row of a table; `layout`: the values of a line, and the detection of titles, remarks and damaged
//!   points; `text_column`: tables without numbers;
//! - `line`: comments and blanks of a line; `lines`: lines become points of a `part`, with titles above them and
//!   remarks below them; `fast_path`: those of large files, by all threads;
//! - `table`: the numbers of these lines become coordinates and times (`timestamps`), and degrees metres; `gaps`:
//!   missing values;
//! - `array`: points, rows of points and rows of heights in JSON;
//! - `off`, `ply`, `stl`, `obj`: the vertices and faces of meshes, and the polylines of OBJ; `mesh`: one piece of them;
//! - `pts`, `pcd`, `las`: clouds; `cloud`: common code of these and the meshes, with `binary` and `byte_lines`;
//! - `esri_grid`: heights at equal steps;
//! - `curves`: the curves of a file with several, before they become parts;
//! - `geojson`: lines, polygons and points; `xml`, `gpx`, `kml`: tracks, routes and lines, by `tracks`; `degrees`: longitude and latitude as metres in a plane;
//! - `dxf`, `svg`: drawings; `gcode`: tool paths; `sampled`: points on their arcs and other curves;
//! - `airfoil`: upper and lower sides one after the other (Lednicer) become one curve, and the header of MSES files is
//!   recognised;
//! - `closed_outline`: outlines that return to their first point;
//! - `repeated`: removal of repeated points;
//! - `grid_detection`: rows of points become a surface; `sections`: curves that are sections of one.

mod airfoil;
mod array;
mod binary;
mod byte_lines;
mod choice;
mod closed_outline;
mod cloud;
mod column_notice;
mod columns;
mod curves;
mod degrees;
mod dxf;
mod encoding;
mod error;
mod esri_grid;
mod fast_path;
mod format;
mod gaps;
mod gcode;
mod geojson;
mod gpx;
mod grid_detection;
mod head;
mod imported;
mod kml;
mod las;
mod layout;
mod line;
mod line_parameters;
mod lines;
mod mesh;
mod names;
mod number_format;
mod obj;
mod off;
mod part;
mod pcd;
mod ply;
mod pts;
mod repeated;
mod sample;
mod sampled;
mod sections;
mod stl;
mod svg;
mod table;
mod text_column;
mod times;
mod timestamps;
mod tracks;
mod unread;
mod xml;

use std::borrow::Cow;

use crate::text::quoted;

pub use columns::Columns;
pub use error::{FileError, FileErrors};
pub use geojson::is_geojson;
pub use imported::{Hints, Imported, Kind, PartChoice};

use format::{ByteFormat, Format};
use part::{Part, Parts};

/// The most names of parts that an error lists.
const MOST_NAMES: usize = 20;

/// Reads one part of a file, with or without a byte-order mark: the only one, or the one of the hints.
///
/// # Errors
///
/// The first ten errors of the file, each with its line; or that there are several parts, if the hints choose none.
pub fn read(file: &[u8], hints: &Hints) -> Result<Imported, FileErrors> {
    let Parts { parts, notices } = parts(file, hints)?;
    let part = one(parts, hints.part.as_ref())?;
    Ok(finished(part, &notices, hints)?)
}

/// Reads all parts of a file, or the one of the hints, in their order.
///
/// # Errors
///
/// The first ten errors of the file, each with its line.
pub fn read_parts(file: &[u8], hints: &Hints) -> Result<Vec<Imported>, FileErrors> {
    let Parts { mut parts, notices } = parts(file, hints)?;
    if hints.part.is_some() {
        parts = vec![one(parts, hints.part.as_ref())?];
    }
    let all = parts
        .into_iter()
        .map(|part| finished(part, &notices, hints));
    Ok(all.collect::<Result<_, _>>()?)
}

/// The parts of a file, sections as one.
fn parts(file: &[u8], hints: &Hints) -> Result<Parts, FileErrors> {
    let (parts, is_table) = parts_of_format(file, hints)?;
    let mut parts = sections::joined(parts, is_table, hints)?;
    let count = parts.parts.len();
    if is_table && count > 1 {
        let notice = format!("The file has {count} parts between blank lines.");
        parts.notices.push(notice);
    }
    Ok(parts)
}

/// The parts of a file as in its format, and true if that is a table.
fn parts_of_format(file: &[u8], hints: &Hints) -> Result<(Parts, bool), FileErrors> {
    let file = encoding::as_utf8(file)?;
    if let Some(format) = ByteFormat::of(&file) {
        check_no_columns(hints)?;
        let part = match format {
            ByteFormat::Las => las::read(&file, hints)?,
            ByteFormat::Pcd => pcd::read(&file, hints)?,
            ByteFormat::Ply => ply::read(&file, hints)?,
            ByteFormat::Stl => stl::read_binary(&file, hints)?,
        };
        return Ok((part.into(), false));
    }
    unread::check(&file)?;
    let text = unread::without_padding(&file);
    // Validates the whole file at once, which is much faster than line by line.
    let text = str::from_utf8(text)
        .map(Cow::Borrowed)
        .unwrap_or_else(|_| String::from_utf8_lossy(text));
    let format = Format::of(&text);
    if format != Format::Table {
        check_no_columns(hints)?;
    }
    let parts = match format {
        Format::Array => Ok(array::read(&text, hints)?.into()),
        Format::Dxf => dxf::read(&text, hints),
        Format::GCode => gcode::read(&text, hints),
        Format::GeoJson => geojson::read(&text, hints),
        Format::Gpx => gpx::read(&text, hints),
        Format::Kml => kml::read(&text, hints),
        Format::Off => Ok(off::read(&text, hints)?.into()),
        Format::Stl => Ok(stl::read_text(&text, hints)?.into()),
        Format::Obj => obj::read(&text, hints),
        Format::Pts => Ok(pts::read(&text, hints)?.into()),
        Format::EsriGrid => Ok(esri_grid::read(&text, hints)?.into()),
        Format::Svg => svg::read(&text, hints),
        Format::Table => tables(airfoil::around(lines::read(&text, hints)?), hints),
    };
    Ok((parts?, format == Format::Table))
}

/// Refuses columns for data other than tables.
fn check_no_columns(hints: &Hints) -> Result<(), FileError> {
    let detail = "columns can be chosen only in a table, and this file is not one";
    match hints.columns {
        None => Ok(()),
        Some(_) => Err(FileError::of_hint(COLUMNS, detail)),
    }
}

/// A table as one part, or each of its parts between blank lines if they are not rows of a surface.
fn tables(mut table: Part, hints: &Hints) -> Result<Parts, FileErrors> {
    if !grid_detection::is_several(&table, hints) {
        return Ok(table.into());
    }
    let notices = std::mem::take(&mut table.notices);
    let parts = table.split()?;
    Ok(Parts { parts, notices })
}

/// The hint that chooses columns.
const COLUMNS: &str = "columns";

/// The hint that chooses a part.
const PART: &str = "part";

/// The only part, or the one that is chosen.
fn one(mut parts: Vec<Part>, choice: Option<&PartChoice>) -> Result<Part, FileError> {
    let index = match choice {
        None if parts.len() == 1 => Some(0),
        None => return Err(several(&parts)),
        Some(PartChoice::Number(number)) => {
            number.checked_sub(1).filter(|index| *index < parts.len())
        }
        Some(PartChoice::Name(name)) => {
            let is_it = |part: &Part| part.name.as_ref() == Some(name);
            parts.iter().position(is_it)
        }
    };
    let Some(index) = index else {
        let detail = match choice {
            Some(PartChoice::Name(name)) => {
                format!(
                    "no part of the file is called {}{}",
                    quoted(name),
                    names(&parts)
                )
            }
            _ => format!("the file has parts 1 to {}{}", parts.len(), names(&parts)),
        };
        return Err(FileError::of_hint(PART, detail));
    };
    Ok(parts.swap_remove(index))
}

/// The error for a file without parts, or with several where one is wanted.
fn several(parts: &[Part]) -> FileError {
    if parts.is_empty() {
        return FileError::of_file(part::NO_POINTS);
    }
    let detail = format!(
        "the file has {} parts, and a fit is of one: say which by its number or name (--part 1, or part=1 in a query){}",
        parts.len(),
        names(parts)
    );
    FileError::of_hint(PART, detail)
}

/// The names of parts, if they have some.
fn names(parts: &[Part]) -> String {
    let named: Vec<String> = parts
        .iter()
        .filter_map(|part| part.name.as_deref())
        .take(MOST_NAMES)
        .map(|name| quoted(name).to_string())
        .collect();
    match named.is_empty() {
        true => String::new(),
        false => format!("; there are {}", named.join(", ")),
    }
}

/// A part as a curve or a surface, with the notices about the whole file.
fn finished(part: Part, notices: &[String], hints: &Hints) -> Result<Imported, FileError> {
    let mut imported = grid_detection::arranged(part, hints)?;
    imported.notices.splice(0..0, notices.iter().cloned());
    Ok(imported)
}

#[cfg(test)]
mod format_tests;
#[cfg(test)]
mod tests;
