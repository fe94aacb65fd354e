//! Flags as fields of a job: their conversion to the JSON that servers read.

use serde_json::{Map, Value, json};

use super::failure::Failure;
use super::input::{Content, Input, not_json, not_read};
use super::point_kind::PointKind;
use super::pointer;
use crate::api::json::request::file::{self, COLUMNS, FileHints, PART, PIECE, SECTIONS, SIZE};
use crate::api::json::request::path::{insert, insert_value};
use crate::config::fit_arguments::FitArguments;
use crate::files;
use piad_files::import::Hints;

/// The kind of parameters of foot points.
const FOOT_POINTS: &str = "foot_points";

/// The requested options.
#[derive(Debug, Default)]
pub(super) struct JobOptions {
    /// Fields of a job, without points.
    pub fields: Map<String, Value>,
    /// Flags about the input file: query parameters, and their values.
    pub reading: Vec<(&'static str, String)>,
    /// The field of each flag.
    pub flags: Vec<(String, String)>,
}

impl JobOptions {
    /// Flags about a file of points.
    pub(super) fn hints(&self) -> Hints {
        let mut reading = FileHints::default();
        for (name, text) in &self.reading {
            // The server accepts them, too, and reports errors in them.
            let _ = reading.take(name, text);
        }
        file::hints(&self.fields, reading, usize::MAX)
    }

    /// The options of the flags for an input.
    pub(super) fn of(arguments: &FitArguments, input: &Input) -> Result<Self, Failure> {
        let mut options = Self::default();
        options.take_settings(arguments)?;
        for text in &arguments.set {
            options.take_set(text)?;
        }
        if arguments.surface.is_some() {
            let size = arguments.surface.clone().flatten();
            options.reading.extend(size.map(|size| (SIZE, size)));
            options.fields.entry("surface").or_insert_with(|| json!({}));
            options
                .flags
                .push((SIZE.to_owned(), "--surface".to_owned()));
        }
        if arguments.sections {
            options.reading.push((SECTIONS, true.to_string()));
            options.fields.entry("surface").or_insert_with(|| json!({}));
            options
                .flags
                .push((SECTIONS.to_owned(), "--sections".to_owned()));
        }
        for (name, flag, text) in [
            (COLUMNS, "--columns", &arguments.columns),
            (PART, "--part", &arguments.part),
            (PIECE, "--piece", &arguments.piece),
        ] {
            if let Some(text) = text {
                options.reading.push((name, text.clone()));
                options.flags.push((name.to_owned(), flag.to_owned()));
            }
        }
        let from_file = match &arguments.json {
            None => Map::new(),
            Some(path) => {
                let name = path.display().to_string();
                let text = files::read(path, arguments.max_input.as_u64());
                let text = text.map_err(|reason| not_read(&name, &reason))?;
                serde_json::from_slice(&text).map_err(|error| not_json(&name, &error))?
            }
        };
        options.take_shape(arguments, input, &from_file)?;
        let flags = std::mem::replace(&mut options.fields, from_file);
        merge(&mut options.fields, flags);
        Ok(options)
    }

    /// Returns true if heights are placed in space.
    pub(super) fn places_heights(&self) -> bool {
        let surface = self.fields.get("surface");
        surface.is_some_and(|surface| surface.get("spacing").is_some())
    }

    /// Refuses foot points on the surface of another job, which only a server has.
    pub(super) fn check_foot_points(&self, input: &Input) -> Result<(), Failure> {
        let is_one =
            |parameters: &Value| parameters == FOOT_POINTS || parameters.get(FOOT_POINTS).is_some();
        let surface = self.fields.get("surface");
        let given = surface.and_then(|surface| surface.get("parameters"));
        let place = match given {
            Some(given) if is_one(given) => {
                let flag = self.flag("surface.parameters");
                flag.unwrap_or("--json").to_owned()
            }
            None if input.content == Content::Job => {
                let pointer = "/surface/parameters";
                match pointer::value(input.json(), pointer).filter(is_one) {
                    None => return Ok(()),
                    Some(_) => {
                        let line = pointer::line(&input.bytes, pointer);
                        format!("{}:{line}: {pointer}", input.name)
                    }
                }
            }
            _ => return Ok(()),
        };
        let detail = "foot points are on the surface of a job of a server, and there is none: name it with --server URL";
        Err(Failure::usage(format!("{place}: {detail}")))
    }

    fn take_settings(&mut self, arguments: &FitArguments) -> Result<(), Failure> {
        let method = arguments.method.as_deref();
        let (count, fairness) = (&arguments.control_points, &arguments.fairness);
        let implied = [
            ("--control-points", count.is_some()),
            ("--fairness", fairness.is_some()),
            ("--robust", arguments.robust),
            ("--trim", arguments.trim.is_some()),
        ];
        let implied = implied.iter().find(|(_, is_given)| *is_given);
        match (method, implied) {
            (Some(kind), _) => self.take("method.kind", "--method", Value::from(kind))?,
            (None, Some((flag, _))) => {
                self.take("method.kind", flag, Value::from("least_squares"))?
            }
            (None, None) => {}
        }
        match (count, implied) {
            (Some(text), _) => {
                self.take("method.control_points", "--control-points", pair(text, 'x'))?;
            }
            (None, Some((flag, _))) if method.is_none() => {
                self.take("method.control_points", flag, Value::from("auto"))?;
            }
            (None, _) => {}
        }
        if arguments.robust {
            self.take("method.robust", "--robust", Value::from(true))?;
        }
        if let Some(text) = fairness {
            self.take("method.fairness", "--fairness", number(text))?;
        }
        if let Some(text) = &arguments.tolerance {
            self.take("stop.tolerance", "--tolerance", number(text))?;
        }
        if let Some(text) = &arguments.max_iterations {
            self.take("stop.max_iterations", "--max-iterations", number(text))?;
        }
        Ok(())
    }

    /// Takes the flags that are about curves or surfaces.
    fn take_shape(
        &mut self,
        arguments: &FitArguments,
        input: &Input,
        from_file: &Map<String, Value>,
    ) -> Result<(), Failure> {
        let FitArguments {
            degree,
            basis,
            order,
            corners,
            polyline,
            ends,
            closed,
            trim,
            ..
        } = arguments;
        if let Some(text) = order {
            self.take("curve.order", "--order", Value::from(text.as_str()))?;
        }
        if let Some(text) = corners {
            self.take("curve.corners", "--corners", corners_of(text)?)?;
        }
        if *polyline {
            self.take("curve.polyline", "--polyline", Value::from(true))?;
        }
        if let Some(distance) = trim {
            let distance = distance.as_deref().map(number);
            let value = distance.map_or(Value::from(true), |it| json!({"distance": it}));
            self.take("surface.trim", "--trim", value)?;
        }
        if degree.is_none() && basis.is_none() && ends.is_none() && !closed {
            return Ok(());
        }
        let is = |name| self.fields.contains_key(name) || from_file.contains_key(name);
        let shapes = match (is("curve"), is("surface")) {
            _ if input.content == Content::Batch => &["curve", "surface"][..],
            (_, true) => &["surface"],
            (true, false) => &["curve"],
            (false, false) => &[shape(input)?],
        };
        for shape in shapes {
            self.take_basis_and_ends(arguments, shape)?;
        }
        Ok(())
    }

    /// Takes the flags that are about curves or surfaces, as those of the one or the other.
    fn take_basis_and_ends(
        &mut self,
        arguments: &FitArguments,
        shape: &str,
    ) -> Result<(), Failure> {
        let FitArguments {
            degree,
            basis,
            ends,
            closed,
            ..
        } = arguments;
        let degree = degree.as_deref().map(|text| pair(text, ','));
        match (basis, degree) {
            (None, None) => {}
            (None, Some(degree)) => self.take(&format!("{shape}.degree"), "--degree", degree)?,
            (Some(basis), None) => {
                let basis = Value::from(basis.as_str());
                self.take(&format!("{shape}.basis"), "--basis", basis)?;
            }
            (Some(basis), Some(degree)) => {
                let of = |degree: &Value| json!({"kind": basis, "degree": degree});
                let both = match degree.as_object() {
                    None => of(&degree),
                    Some(each) => each
                        .iter()
                        .map(|(name, it)| (name.clone(), of(it)))
                        .collect(),
                };
                let path = format!("{shape}.basis");
                self.flags
                    .push((format!("{path}.degree"), "--degree".to_owned()));
                self.take(&path, "--basis", both)?;
            }
        }
        if let Some(text) = ends {
            let json = serde_json::from_str(text).unwrap_or_else(|_| Value::from(text.as_str()));
            self.take(&format!("{shape}.ends"), "--ends", json)?;
        }
        if *closed {
            self.take(&format!("{shape}.closed"), "--closed", Value::from(true))?;
        }
        Ok(())
    }

    fn take(&mut self, path: &str, flag: &str, value: Value) -> Result<(), Failure> {
        self.flags.push((path.to_owned(), flag.to_owned()));
        insert_value(&mut self.fields, path, value)
            .map_err(|detail| Failure::usage(format!("{flag}: {detail}")))
    }

    fn take_set(&mut self, text: &str) -> Result<(), Failure> {
        let Some((path, value)) = text.split_once('=') else {
            let detail = "not a field with a value; expected one such as curve.degree=3";
            return Err(Failure::usage(format!("--set {text}: {detail}")));
        };
        let flag = format!("--set {path}");
        if path == SIZE {
            return Err(Failure::usage(format!("{flag}: use --surface {value}")));
        }
        let inserted = insert(&mut self.fields, path, value);
        inserted.map_err(|detail| Failure::usage(format!("{flag}: {detail}")))?;
        self.flags.push((path.to_owned(), flag));
        Ok(())
    }
}

/// Only one of these is allowed, so each overrides both.
const TOLERANCES: [&str; 2] = ["tolerance", "relative_tolerance"];

/// Overrides fields. A method of another kind has other settings, so it replaces the method.
pub(super) fn merge(fields: &mut Map<String, Value>, over: Map<String, Value>) {
    if TOLERANCES.iter().any(|name| over.contains_key(*name)) {
        TOLERANCES
            .iter()
            .for_each(|name| drop(fields.remove(*name)));
    }
    for (name, value) in over {
        let before = fields.get_mut(&name);
        match (before.and_then(Value::as_object_mut), value) {
            (Some(before), Value::Object(value)) if !is_other_kind(before, &value) => {
                merge(before, value);
            }
            (_, value) => {
                fields.insert(name, value);
            }
        }
    }
}

fn is_other_kind(before: &Map<String, Value>, after: &Map<String, Value>) -> bool {
    let kind = after.get("kind");
    kind.is_some() && kind != before.get("kind")
}

/// Overrides fields of each item of a batch, of curves or surfaces.
pub(super) fn merge_into_items(batch: &mut Value, over: &Map<String, Value>) {
    let items = batch.get_mut("items").and_then(Value::as_array_mut);
    for item in items.into_iter().flatten().filter_map(Value::as_object_mut) {
        let mut over = over.clone();
        for (shape, other) in [("curve", "surface"), ("surface", "curve")] {
            if item.contains_key(shape) && !item.contains_key(other) {
                over.remove(other);
            }
        }
        merge(item, over);
    }
}

/// Returns `curve` or `surface` for the points of an input.
fn shape(input: &Input) -> Result<&'static str, Failure> {
    let surface = match input.content {
        // The reader of the input reports its errors.
        Content::Points => PointKind::of(input, &JobOptions::default().hints())
            .is_some_and(|points| points.surface),
        Content::Job | Content::Batch => input.value()?.get("surface").is_some(),
    };
    Ok(match surface {
        true => "surface",
        false => "curve",
    })
}

/// A number if it is one; else the text, which the reader of jobs refuses.
fn number(text: &str) -> Value {
    let json = serde_json::from_str(text).ok().filter(Value::is_number);
    let number = || text.parse::<f64>().ok().map(Value::from);
    json.or_else(number).unwrap_or_else(|| Value::from(text))
}

/// A value, or one for each direction.
fn pair(text: &str, separator: char) -> Value {
    match text.split_once(separator) {
        Some((u, v)) if !u.is_empty() => json!({"u": number(u.trim()), "v": number(v.trim())}),
        _ => number(text),
    }
}

/// Corners as the flag gives them.
fn corners_of(text: &str) -> Result<Value, Failure> {
    if text == "auto" {
        return Ok(Value::from(text));
    }
    if let Some(degrees) = text
        .strip_suffix("deg")
        .and_then(|it| it.parse::<f64>().ok())
    {
        return Ok(json!({"angle": degrees}));
    }
    let indices = text.split(',').map(|index| index.trim().parse::<usize>());
    let indices: Result<Vec<usize>, _> = indices.collect();
    indices.map(Value::from).map_err(|_| {
        let detail = format!(
            "--corners {text}: give indices of points, such as 12,40, or auto, or an angle, such as 30deg"
        );
        Failure::usage(detail)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_go_over_others_and_methods_replace_others() {
        let object = |value: Value| value.as_object().unwrap().clone();
        let mut fields = object(
            json!({"method": {"kind": "least_squares", "control_points": 9}, "stop": {"tolerance": 1}}),
        );
        merge(
            &mut fields,
            object(json!({"stop": {"max_iterations": 5}, "method": {"variant": "cg"}})),
        );
        assert_eq!(
            Value::from(fields.clone()),
            json!({"method": {"kind": "least_squares", "control_points": 9, "variant": "cg"}, "stop": {"tolerance": 1, "max_iterations": 5}})
        );
        merge(&mut fields, object(json!({"method": {"kind": "direct"}})));
        assert_eq!(fields["method"], json!({"kind": "direct"}));
        merge(
            &mut fields,
            object(json!({"stop": {"relative_tolerance": 2}})),
        );
        assert_eq!(
            fields["stop"],
            json!({"max_iterations": 5, "relative_tolerance": 2})
        );
    }

    #[test]
    fn numbers_and_pairs_are_read() {
        assert_eq!(number("1e-4"), json!(1e-4));
        assert_eq!(number(".5"), json!(0.5));
        assert_eq!(number("12"), json!(12));
        assert_eq!(number("few"), json!("few"));
        assert_eq!(pair("3,2", ','), json!({"u": 3, "v": 2}));
        assert_eq!(pair("20x30", 'x'), json!({"u": 20, "v": 30}));
        assert_eq!(pair("auto", 'x'), json!("auto"));
    }
}
