//! A job whose points are in a file, and whose other fields are not.
//!
//! The fields are parsed from their JSON without points, which are then inserted. Errors are located at the line of a
//! point, or at the parameter of a field.

use std::sync::Arc;

use bytes::Bytes;
use serde::Deserialize;
use serde_json::{Map, Value, json, to_value};

use super::job;
use super::places::Places;
use super::points::Data;
use crate::api::json::view::to_bytes;
use crate::api::problem::{Kind, Location, Locator, Problem};
use crate::model::errors::SpecPart;
use crate::model::job::{JobRequest, LONGEST_NAME};
use crate::model::points::{PointGrid, PointList};
use crate::model::scattered::{MeshUnfoldingInput, SurfaceParameters};
use crate::model::stream::Samples;
use piad_files::import::{Columns, Hints, Imported, Kind as FileKind, PartChoice};
use piad_files::text;
use piad_fit::data::Grid;
use piad_fit::parameters::{Mesh, MeshUnfolding, Scattered};

/// The number of rows and columns of the points of a file: a hint for reading it, not a field of a job.
pub(crate) const SIZE: &str = "surface.size";

/// True if the parts of a file are sections of one surface.
pub(crate) const SECTIONS: &str = "surface.sections";

/// The order of the points of a curve.
pub(crate) const ORDER: &str = "curve.order";

/// The known orders.
const ORDERS: [&str; 2] = ["given", "nearest"];

/// The roles of the columns of a table.
pub(crate) const COLUMNS: &str = "columns";

/// The part to read from a file with several.
pub(crate) const PART: &str = "part";

/// The piece of a mesh to read.
pub(crate) const PIECE: &str = "piece";

/// Hints for reading a file of points, besides the fields of the job.
#[derive(Clone, Debug, Default)]
pub(crate) struct FileHints {
    /// The rows and columns of a surface.
    pub size: Option<Grid>,
    /// True if the points of a curve are in order along it.
    pub ordered: bool,
    /// The roles of the columns of a table.
    pub columns: Option<Columns>,
    /// The part to read from a file with several.
    pub part: Option<PartChoice>,
    /// True if the parts are sections of one surface.
    pub sections: Option<bool>,
    /// The piece of a mesh to read, from 1.
    pub piece: Option<usize>,
}

impl FileHints {
    /// Takes a parameter about reading a file; returns true if it is one.
    ///
    /// # Errors
    ///
    /// The error in its value.
    pub(crate) fn take(&mut self, name: &str, text: &str) -> Result<bool, String> {
        match name {
            SIZE => self.size = Some(size(text)?),
            SECTIONS => {
                let wrong = |_| format!("{} is neither true nor false", text::quoted(text));
                self.sections = Some(text.parse::<bool>().map_err(wrong)?);
            }
            PART => self.part = Some(PartChoice::of_text(text)),
            PIECE => {
                let piece = text.parse().map_err(|_| {
                    format!(
                        "{} is not the number of a piece; expected a number such as 1 for the largest",
                        text::quoted(text)
                    )
                })?;
                self.piece = Some(piece);
            }
            COLUMNS => self.columns = Some(Columns::of_text(text)?),
            ORDER if ORDERS.contains(&text) => self.ordered = true,
            ORDER => {
                let [given, nearest] = ORDERS;
                return Err(format!(
                    "unknown order {}; expected {given} or {nearest}",
                    text::quoted(text)
                ));
            }
            _ => return Ok(false),
        }
        Ok(true)
    }
}

/// Rows and columns, such as 40x60.
fn size(text: &str) -> Result<Grid, String> {
    match Samples::of_text(text) {
        Some(Samples::Grid(rows, columns)) if rows >= 2 && columns >= 2 => {
            Ok(Grid { rows, columns })
        }
        _ => Err(format!(
            "{} is not a size; expected rows and columns such as 40x60",
            text::quoted(text)
        )),
    }
}

/// The parameters of a curve that are the times of its points in a file.
pub(crate) const TIME: &str = "time";

/// The hints for reading a file of at most `most` points, from the fields of the job and the parameters of the file.
pub(crate) fn hints(fields: &Map<String, Value>, reading: FileHints, most: usize) -> Hints {
    let FileHints {
        size,
        ordered,
        columns,
        part,
        sections,
        piece,
    } = reading;
    let has = |name| fields.contains_key(name);
    let of_curve = |name| fields.get("curve").and_then(|curve| curve.get(name));
    let is_surface = has("surface") || size.is_some() || sections == Some(true);
    let kind = match (has("curve"), is_surface) {
        (true, _) => Some(FileKind::Curve),
        (false, true) => Some(FileKind::Surface),
        (false, false) => None,
    };
    Hints {
        kind,
        size,
        closed: closed(fields),
        ordered: ordered || of_curve("order").is_some(),
        columns,
        part,
        sections,
        piece,
        times: of_curve("parameters").is_some_and(|it| it == TIME),
        most,
    }
}

/// The `closed` setting of these fields, if they have one. Ends and polynomial bases imply an open curve.
fn closed(fields: &Map<String, Value>) -> Option<bool> {
    let curve = fields.get("curve")?.as_object()?;
    let basis = curve.get("basis").map(|it| it.get("kind").unwrap_or(it));
    let open = curve.contains_key("ends") || basis.is_some_and(|kind| kind != "bspline");
    let said = curve.get("closed").and_then(Value::as_bool);
    said.or(open.then_some(false))
}

/// Reads a job with these fields and the points of a file, with notices about it.
pub(crate) fn read(
    fields: Map<String, Value>,
    file: Imported,
    hints: &Hints,
) -> Result<(JobRequest, FileLocator), Problem> {
    let (fields, data, lines) = parts_of_job(fields, file, hints)?;
    match job::read_with(&to_bytes(&fields), data, hints.most) {
        Ok((spec, places)) => Ok((spec, FileLocator { places, lines })),
        Err(problem) => Err(problem.relocated(|place| match place {
            Location::Pointer(pointer) => lines.place(pointer),
            place => place,
        })),
    }
}

/// The JSON of a job with these fields and the points of a file, with notices about it.
pub(crate) fn json(
    fields: Map<String, Value>,
    file: Imported,
    hints: &Hints,
) -> Result<Bytes, Problem> {
    let (mut fields, data, _) = parts_of_job(fields, file, hints)?;
    let unwritten = |_| Problem::new(Kind::Internal, "the points of the file cannot be written");
    let (shape, list, points) = match data {
        Data::Curve(points) => ("curve", "points", to_value(PointList(Arc::new(points)))),
        Data::Scattered(points) => (
            "surface",
            "scattered",
            to_value(PointList(Arc::new(points))),
        ),
        Data::Mesh(points, mesh) => {
            if let Some(surface) = fields.get_mut("surface").and_then(Value::as_object_mut) {
                let mesh = SurfaceParameters::Scattered(Scattered::Mesh(mesh));
                surface.entry("parameters").or_insert_with(|| json!(mesh));
            }
            (
                "surface",
                "scattered",
                to_value(PointList(Arc::new(points))),
            )
        }
        Data::Grid(points, grid, missing) => {
            let grid = PointGrid {
                points: Arc::new(points),
                missing,
                grid,
            };
            ("surface", "points", to_value(grid))
        }
    };
    if let Some(shape) = fields.get_mut(shape).and_then(Value::as_object_mut) {
        shape.insert(list.to_owned(), points.map_err(unwritten)?);
    }
    Ok(to_bytes(&fields))
}

/// The fields of a job without the points of this file, these points, and their lines.
fn parts_of_job(
    mut fields: Map<String, Value>,
    file: Imported,
    hints: &Hints,
) -> Result<(Map<String, Value>, Data, Lines), Problem> {
    let lines = Lines {
        columns: file.grid.map_or(1, |grid| grid.columns),
        sections: file.sections.clone(),
        lines: file.lines,
    };
    let has_triangles = !file.triangles.is_empty();
    let shown = match file.grid.is_some() || !file.sections.is_empty() || has_triangles {
        true => FileKind::Surface,
        false => FileKind::Curve,
    };
    let kind = hints.kind.unwrap_or(shown);
    let (name, list, data) = match (kind, file.grid) {
        (FileKind::Curve, _) => ("curve", "points", Data::Curve(file.points)),
        (FileKind::Surface, Some(grid)) => {
            let data = Data::Grid(file.points, grid, file.missing);
            ("surface", "points", data)
        }
        (FileKind::Surface, None) if has_triangles => {
            let mesh = Mesh {
                triangles: Arc::new(file.triangles),
                unfolding: unfolding_of_mesh(&mut fields)?,
            };
            ("surface", "scattered", Data::Mesh(file.points, mesh))
        }
        (FileKind::Surface, None) => ("surface", "scattered", Data::Scattered(file.points)),
    };
    let is_mesh = matches!(data, Data::Mesh(..));
    let shape = fields.entry(name).or_insert_with(|| json!({}));
    if let Some(shape) = shape.as_object_mut() {
        if let (Some([u, v]), false) = (file.line_parameters, shape.contains_key("closed")) {
            let parameters = || json!({"u": u, "v": v});
            shape.entry("parameters").or_insert_with(parameters);
        }
        if !file.sections.is_empty() {
            let parameters = || json!({"sections": file.sections});
            shape.entry("parameters").or_insert_with(parameters);
        }
        if list == "scattered" && file.unordered && !is_mesh {
            shape.entry("parameters").or_insert("auto".into());
        }
        if list == "scattered" && !is_mesh && !shape.contains_key("parameters") {
            let detail = "the file does not show the rows of a surface: give their number and that of the columns, such as 40x60, or surface.parameters for scattered points, such as auto";
            return Err(Problem::at_parameter(SIZE, detail));
        }
        shape.insert(list.to_owned(), json!([]));
        if file.closed {
            shape.entry("closed").or_insert(Value::from(true));
        }
        let given = shape.get("parameters").filter(|it| *it != TIME);
        if let (None, Some(times)) = (given, file.parameters) {
            shape.insert("parameters".to_owned(), Value::from(times));
        }
    }
    if let Some(name) = file.name {
        let name = text::cut(&name, LONGEST_NAME - 1).into_owned();
        fields.entry("name").or_insert(Value::from(name));
    }
    Ok((fields, data, lines))
}

/// Takes the rule for the parameters of mesh vertices out of the fields: all but the triangles.
fn unfolding_of_mesh(fields: &mut Map<String, Value>) -> Result<MeshUnfolding, Problem> {
    let surface = fields.get_mut("surface").and_then(Value::as_object_mut);
    let parameters = surface.and_then(|surface| match surface.get("parameters") {
        Some(Value::Object(given)) if given.len() == 1 && given.contains_key("unfolding") => {
            surface.remove("parameters")
        }
        _ => None,
    });
    let given = parameters.as_ref().and_then(|given| given.get("unfolding"));
    let unfolding = given.map(|unfolding| {
        MeshUnfoldingInput::deserialize(unfolding)
            .map_err(|error| Problem::at_parameter(UNFOLDING, error.to_string()))
    });
    let unfolding = unfolding.transpose()?;
    Ok(unfolding.map_or(MeshUnfolding::Auto, MeshUnfolding::from))
}

/// The rule for the parameters of mesh vertices.
const UNFOLDING: &str = "surface.parameters.unfolding";

/// The locations of the parts of such a job.
#[derive(Debug)]
pub(crate) struct FileLocator {
    places: Places,
    lines: Lines,
}

impl Locator for FileLocator {
    fn of(&self, place: SpecPart) -> String {
        self.places.of(place)
    }

    fn place(&self, text: String) -> Location {
        self.lines.place(text)
    }
}

/// The lines of the points.
#[derive(Debug)]
struct Lines {
    columns: usize,
    /// The numbers of points of sections.
    sections: Vec<usize>,
    lines: Vec<u32>,
}

impl Lines {
    /// The line of a point of the JSON at a pointer, or the parameter of another field.
    fn place(&self, pointer: String) -> Location {
        let lists = ["/curve/points", "/surface/points", "/surface/scattered"];
        let mut found = lists.into_iter();
        let point = found.find_map(|list| pointer.strip_prefix(list));
        let section = pointer.strip_prefix("/surface/parameters/sections/");
        let section = section.and_then(|index| index.parse::<usize>().ok());
        match (point, section) {
            (Some(rest), _) if !self.lines.is_empty() => Location::Line(self.line(rest)),
            (None, Some(index)) if !self.lines.is_empty() => {
                let before: usize = self.sections.iter().take(index).sum();
                Location::Line(self.line(&before.to_string()))
            }
            (Some(_), _) => Location::Pointer(pointer),
            (None, _) if pointer.is_empty() => Location::Pointer(pointer),
            (None, _) => Location::Parameter(pointer.trim_start_matches('/').replace('/', ".")),
        }
    }

    /// The line of the point with these indices; of all points the first one.
    fn line(&self, indices: &str) -> usize {
        let mut indices = indices.split('/').filter_map(|index| index.parse().ok());
        let mut next = || -> usize { indices.next().unwrap_or(0) };
        let index = match self.columns {
            1 => next(),
            columns => next() * columns + next(),
        };
        self.lines
            .get(index)
            .or(self.lines.first())
            .map_or(1, |line| *line as usize)
    }
}
