//! A job as it was asked for.

use bytes::Bytes;
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};
use serde_json::{Value, json};

use super::ends;
use super::job::stream;
use super::to_bytes;
use crate::api::json::request::method;
use crate::fit::basis::knots::Knots;
use crate::fit::direction::{BasisChoice, DirectionChoice};
use crate::fit::parameters::Parametrization;
use crate::fit::points::Points;
use crate::fit::problem::{Problem, Request, Tolerance, Weights};
use crate::fit::scattered::Scattered;
use crate::job::outline::Outline;
use crate::model::named::Named;
use crate::model::weights::Rational;

/// The body that would ask for the same problem again. The start of an edit is not a part of it: that
/// is its iteration 0.
pub fn input(outline: &Outline, problem: &Problem) -> Bytes {
    to_bytes(&Input { outline, problem })
}

struct Input<'a> {
    outline: &'a Outline,
    problem: &'a Problem,
}

impl Serialize for Input<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self { outline, problem } = self;
        let request = problem.request();
        let mut fields = serializer.serialize_map(None)?;
        if let Some(name) = &outline.label.name {
            fields.serialize_entry("name", name)?;
        }
        let kind = if outline.surface { "surface" } else { "curve" };
        fields.serialize_entry(kind, &Shape(request))?;
        if let Some(rational) = Rational::of(request) {
            fields.serialize_entry("rational", rational.name())?;
        }
        fields.serialize_entry("method", &method::written(problem))?;
        fields.serialize_entry("stop", &stop(request))?;
        if let Some(stream) = stream(outline) {
            fields.serialize_entry("stream", &stream)?;
        }
        fields.end()
    }
}

/// The curve or the surface.
struct Shape<'a>(&'a Request);

impl Serialize for Shape<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let request = self.0;
        let mut fields = serializer.serialize_map(None)?;
        let points = DataPoints::new(request);
        let list = || points.line(0, request.grid.rows);
        match (&request.v, &request.scattered) {
            (None, _) => fields.serialize_entry("points", &list())?,
            (Some(_), None) => fields.serialize_entry("points", &points)?,
            (Some(_), Some(_)) => fields.serialize_entry("scattered", &list())?,
        }
        fields.serialize_entry("basis", &per_direction(request, basis))?;
        match &request.scattered {
            None => {
                fields.serialize_entry("parameters", &per_direction(request, parameters))?;
            }
            Some(Scattered::Given(pairs)) => {
                fields.serialize_entry("parameters", &Pairs(pairs))?;
            }
            Some(Scattered::Plane) => fields.serialize_entry("parameters", "project")?,
            Some(Scattered::Coordinates) => {
                fields.serialize_entry("parameters", &json!({"project": "xy"}))?;
            }
        }
        if let Some(weights) = weights(request) {
            fields.serialize_entry("weights", &weights)?;
        }
        fields.serialize_entry("closed", &per_direction(request, |it| json!(it.closed)))?;
        let surface = request.v.is_some();
        match per_direction(request, |it| ends::written(it.ends.as_ref(), surface)) {
            Value::Null => {}
            ends => fields.serialize_entry("ends", &without_nulls(ends))?,
        }
        fields.end()
    }
}

/// Rows of points; missing ones are null.
struct DataPoints<'a> {
    points: &'a Points,
    missing: Vec<bool>,
    rows: usize,
    columns: usize,
}

impl<'a> DataPoints<'a> {
    fn new(request: &'a Request) -> Self {
        let mut missing = vec![false; request.grid.count()];
        for &index in &request.missing {
            missing[index] = true;
        }
        Self {
            points: &request.points,
            missing,
            rows: request.grid.rows,
            columns: request.grid.columns,
        }
    }

    fn line(&self, start: usize, count: usize) -> DataLine<'_> {
        DataLine {
            points: self.points,
            missing: &self.missing[start..start + count],
            start,
        }
    }
}

impl Serialize for DataPoints<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let rows = (0..self.rows).map(|row| self.line(row * self.columns, self.columns));
        serializer.collect_seq(rows)
    }
}

struct DataLine<'a> {
    points: &'a Points,
    missing: &'a [bool],
    start: usize,
}

impl Serialize for DataLine<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let places = self.missing.iter().enumerate();
        serializer.collect_seq(
            places.map(|(k, missing)| (!missing).then(|| DataPoint(self.points, self.start + k))),
        )
    }
}

/// The parameters of scattered points.
struct Pairs<'a>(&'a Points);

impl Serialize for Pairs<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq((0..self.0.len()).map(|i| DataPoint(self.0, i)))
    }
}

struct DataPoint<'a>(&'a Points, usize);

impl Serialize for DataPoint<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.0.point(self.1))
    }
}

/// One value if both directions have the same, else `{"u": …, "v": …}`.
fn per_direction(request: &Request, of: impl Fn(&DirectionChoice) -> Value) -> Value {
    let u = of(&request.u);
    match request.v.as_ref().map(of) {
        Some(v) if v != u => json!({"u": u, "v": v}),
        _ => u,
    }
}

/// Without the directions that have nothing to choose.
fn without_nulls(mut value: Value) -> Value {
    if let Value::Object(fields) = &mut value {
        fields.retain(|_, value| !value.is_null());
    }
    value
}

fn basis(choice: &DirectionChoice) -> Value {
    match &choice.basis {
        BasisChoice::Polynomial(kind) => json!({"kind": kind.name()}),
        BasisChoice::BSpline { degree, knots } => {
            let mut value = json!({"kind": "bspline", "degree": degree});
            match knots {
                Knots::Usual => {}
                Knots::Data => value["knots"] = json!("data"),
                Knots::Averaged => value["knots"] = json!("averaged"),
                Knots::Spread => value["knots"] = json!("spread"),
                Knots::Explicit(knots) => value["knots"] = json!(**knots),
            }
            value
        }
    }
}

fn parameters(choice: &DirectionChoice) -> Value {
    match &choice.parameters {
        Parametrization::ChordLength => json!("chord_length"),
        Parametrization::Centripetal => json!("centripetal"),
        Parametrization::Uniform => json!("uniform"),
        Parametrization::Explicit(values) => json!(**values),
    }
}

fn weights(request: &Request) -> Option<Value> {
    let columns = request.grid.columns;
    match (&request.weights, &request.u.weights, &request.v) {
        (Weights::None, None, _) => None,
        (Weights::None, Some(weights), None) => Some(json!(weights)),
        (Weights::None, Some(u), Some(v)) => Some(json!({"u": u, "v": v.weights})),
        (Weights::Homogeneous(weights), _, None) => Some(json!(weights)),
        (Weights::Homogeneous(grid) | Weights::FixedGrid(grid), ..) => {
            Some(grid.chunks(columns).map(|row| json!(row)).collect())
        }
    }
}

fn stop(request: &Request) -> Value {
    let mut stop = json!({"max_iterations": request.max_iterations});
    match request.tolerance {
        Some(Tolerance::Absolute(value)) => stop["tolerance"] = json!(value),
        Some(Tolerance::Relative(value)) => stop["relative_tolerance"] = json!(value),
        None => {}
    }
    stop
}
