//! A job whose points are in a file, and whose other fields are not.
//!
//! The fields are read as the JSON that they are, without points; the points take their place. What is
//! wrong is told at the line of a point, or at the parameter that a field was given in.

use serde_json::{Map, Value, json};

use super::job;
use super::places::Places;
use super::points::Data;
use crate::api::json::view::to_bytes;
use crate::api::problem::{Location, Problem, Words};
use crate::model::job::{JobRequest, LONGEST_NAME};
use crate::model::mistakes::SpecPart;
use piad_files::import::{Hints, Imported, Kind};
use piad_files::short;
use piad_fit::data::Grid;

/// What is said of a file of points beside the fields of a job, as a help to read it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct FileHints {
    /// The rows and columns of a surface.
    pub size: Option<Grid>,
    /// True if the points of a curve are in order along it.
    pub ordered: bool,
}

/// The hints for reading a file of at most `most` points, from the fields of the job and the parameters of the file.
pub(crate) fn hints(fields: &Map<String, Value>, reading: FileHints, most: usize) -> Hints {
    let FileHints { size, ordered } = reading;
    let has = |name| fields.contains_key(name);
    let order = fields.get("curve").and_then(|curve| curve.get("order"));
    let kind = match (has("curve"), has("surface") || size.is_some()) {
        (true, _) => Some(Kind::Curve),
        (false, true) => Some(Kind::Surface),
        (false, false) => None,
    };
    Hints {
        kind,
        size,
        closed: closed(fields),
        ordered: ordered || order.is_some(),
        most,
    }
}

/// Whether these fields say that the curve of a file is closed or not. Ends and polynomial bases go
/// with open curves only.
fn closed(fields: &Map<String, Value>) -> Option<bool> {
    let curve = fields.get("curve")?.as_object()?;
    let basis = curve.get("basis").map(|it| it.get("kind").unwrap_or(it));
    let open = curve.contains_key("ends") || basis.is_some_and(|kind| kind != "bspline");
    let said = curve.get("closed").and_then(Value::as_bool);
    said.or(open.then_some(false))
}

/// Reads a job of these fields, with these points of a file, about which that was known.
pub(crate) fn read(
    mut fields: Map<String, Value>,
    file: Imported,
    hints: &Hints,
) -> Result<(JobRequest, FileWords), Problem> {
    let lines = Lines {
        columns: file.grid.map_or(1, |grid| grid.columns),
        lines: file.lines,
    };
    let shown = file.grid.map_or(Kind::Curve, |_| Kind::Surface);
    let kind = hints.kind.unwrap_or(shown);
    let (name, list) = match (kind, file.grid) {
        (Kind::Curve, _) => ("curve", "points"),
        (Kind::Surface, Some(_)) => ("surface", "points"),
        (Kind::Surface, None) => ("surface", "scattered"),
    };
    let shape = fields.entry(name).or_insert_with(|| json!({}));
    if let Some(shape) = shape.as_object_mut() {
        if list == "scattered" && file.unordered {
            shape.entry("parameters").or_insert("project".into());
        }
        if list == "scattered" && !shape.contains_key("parameters") {
            let detail = "the file does not show the rows of a surface: say how many rows and columns there are, such as 40x60, or give surface.parameters for scattered points, such as project";
            return Err(Problem::at_parameter("surface.size", detail));
        }
        shape.insert(list.to_owned(), json!([]));
        if file.closed {
            shape.entry("closed").or_insert(Value::from(true));
        }
    }
    if let Some(name) = file.name {
        let name = short::cut(&name, LONGEST_NAME - 1).into_owned();
        fields.entry("name").or_insert(Value::from(name));
    }
    let data = match (kind, file.grid) {
        (Kind::Curve, _) => Data::Curve(file.points),
        (Kind::Surface, Some(grid)) => Data::Grid(file.points, grid, file.missing),
        (Kind::Surface, None) => Data::Scattered(file.points),
    };
    match job::read_with(&to_bytes(&fields), data, hints.most) {
        Ok((spec, places)) => Ok((spec, FileWords { places, lines })),
        Err(problem) => Err(problem.relocated(|place| match place {
            Location::Pointer(pointer) => lines.place(pointer),
            place => place,
        })),
    }
}

/// Where the parts of such a job stand.
#[derive(Debug)]
pub(crate) struct FileWords {
    places: Places,
    lines: Lines,
}

impl Words for FileWords {
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
    lines: Vec<u32>,
}

impl Lines {
    /// The line of a point of the JSON at a pointer, or the parameter of another field.
    fn place(&self, pointer: String) -> Location {
        let lists = ["/curve/points", "/surface/points", "/surface/scattered"];
        match lists
            .into_iter()
            .find_map(|list| pointer.strip_prefix(list))
        {
            Some(rest) => Location::Line(self.line(rest)),
            None if pointer.is_empty() => Location::Pointer(pointer),
            None => Location::Parameter(pointer.trim_start_matches('/').replace('/', ".")),
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
