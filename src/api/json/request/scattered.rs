//! The JSON of the parameters of a surface: of points in a grid, or of scattered ones.

use std::sync::Arc;

use schemars::{JsonSchema, Schema, json_schema};
use serde::de::{MapAccess, SeqAccess};
use serde_json::{Value, json};

use super::basis::{ParameterRule, Parameters};
use super::iteration::IterationRequest;
use crate::api::json::numbers::{RuleOrNumbers, most_numbers};
use crate::api::json::per_direction::PerDirection;
use crate::api::json::read::{
    Field, Members, Most, Numeral, Of, Read, Reader, Reading, names, object,
};
use crate::api::json::schema::schema_of;
use crate::fit::points::Points;
use crate::fit::scattered::Scattered;
use crate::model::scattered::{BaseSpec, ScatteredSpec};

/// The parameters of the data points of a surface.
#[derive(Clone, Debug)]
pub(in crate::api) enum SurfaceParameters {
    /// Those of the rows and columns of a grid.
    Grid(PerDirection<RuleOrNumbers<ParameterRule>>),
    /// Those of scattered points.
    Scattered(ScatteredSpec),
}

/// The plane in which scattered points have their parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::api) enum ProjectionPlane {
    Nearest,
    Xy,
}

names!(ProjectionPlane, "plane", [
    "nearest" => Nearest,
    "xy" => Xy,
]);

impl From<ProjectionPlane> for Scattered {
    fn from(plane: ProjectionPlane) -> Self {
        match plane {
            ProjectionPlane::Nearest => Self::Plane,
            ProjectionPlane::Xy => Self::Coordinates,
        }
    }
}

/// Of points in a grid.
type OfGrid = PerDirection<RuleOrNumbers<ParameterRule>>;

impl Reader for Of<SurfaceParameters> {
    type Value = SurfaceParameters;

    fn expected(&self) -> String {
        let grid = OfGrid::reader().expected();
        format!("{grid}; of scattered points pairs, [[u, v], …], \"project\" or foot_points")
    }

    fn text(self, name: &str, at: &mut Reading) -> Option<SurfaceParameters> {
        if name == "project" {
            return Some(own(Scattered::Plane));
        }
        let rule = OfGrid::reader().text(name, at);
        rule.map(SurfaceParameters::Grid)
    }

    fn list<'de, A: SeqAccess<'de>>(
        self,
        list: A,
        at: &mut Reading,
    ) -> Result<Option<SurfaceParameters>, A::Error> {
        let (mut numbers, mut pairs) = (Vec::new(), Points::new(2));
        let most = most_numbers(at.limits());
        let whole = at.elements(
            list,
            most,
            || PairReader,
            |parameter, at| {
                match parameter {
                    Parameter::Number(t) if pairs.is_empty() => numbers.push(t),
                    Parameter::Pair(pair) if numbers.is_empty() => pairs.push(&pair),
                    _ => {
                        at.wrong("expected numbers only, or pairs [u, v] only");
                        return None;
                    }
                }
                Some(())
            },
        )?;
        Ok(whole.then_some(if pairs.is_empty() {
            numbers.shrink_to_fit();
            SurfaceParameters::Grid(PerDirection::Both(RuleOrNumbers::Numbers(numbers)))
        } else {
            pairs.shrink_to_fit();
            own(Scattered::Given(Arc::new(pairs)))
        }))
    }

    /// A projection, another surface, or a value for each direction.
    fn object<'de, A: MapAccess<'de>>(
        self,
        mut members: Members<A>,
        at: &mut Reading,
    ) -> Result<Option<SurfaceParameters>, A::Error> {
        match members.peek()? {
            Some("project") => {}
            Some("foot_points") => {
                let mut base = Field::<FootPointsRequest>::Absent;
                while let Some(name) = members.next(&["foot_points"], at)? {
                    members.field(name, &mut base, at)?;
                }
                let base = base.value("foot_points", at);
                return Ok(base.map(FootPointsRequest::parameters));
            }
            _ => {
                let grid = OfGrid::reader().object(members, at)?;
                return Ok(grid.map(SurfaceParameters::Grid));
            }
        }
        let mut plane = Field::<ProjectionPlane>::Absent;
        while let Some(name) = members.next(&["project"], at)? {
            members.field(name, &mut plane, at)?;
        }
        let plane = plane.value("project", at);
        Ok(plane.map(|plane| own(plane.into())))
    }
}

fn own(scattered: Scattered) -> SurfaceParameters {
    SurfaceParameters::Scattered(ScatteredSpec::Own(scattered))
}

/// The surface of another job, for foot points: the nearest points of it. They are found once, when the
/// new job is made.
#[derive(Debug, JsonSchema)]
#[schemars(deny_unknown_fields)]
#[schemars(example = json!({"job": "01a1e1b6-7c2e-7d58-9b5f-6c1f6f3c1b7a", "iteration": 12}))]
pub(in crate::api) struct FootPointsRequest {
    /// The id of the job whose surface it is, with as many coordinates as the points.
    job: String,
    /// An iteration that the job has reached; without it, the last one of a job that has ended.
    iteration: Option<IterationRequest>,
}

object!(FootPointsRequest, "an object with a job", [job, iteration]);

impl FootPointsRequest {
    fn parameters(self) -> SurfaceParameters {
        SurfaceParameters::Scattered(ScatteredSpec::FootPoints(BaseSpec {
            job: self.job,
            iteration: self.iteration.and_then(|IterationRequest(k)| k),
        }))
    }
}

/// A parameter of a line of points, or both of a scattered point.
enum Parameter {
    Number(f64),
    Pair([f64; 2]),
}

struct PairReader;

impl Reader for PairReader {
    type Value = Parameter;

    fn expected(&self) -> String {
        "a number, or of scattered points a pair [u, v]".to_owned()
    }

    fn number(self, value: Numeral, _: &mut Reading) -> Option<Parameter> {
        Some(Parameter::Number(value.real()))
    }

    fn list<'de, A: SeqAccess<'de>>(
        self,
        list: A,
        at: &mut Reading,
    ) -> Result<Option<Parameter>, A::Error> {
        let (mut pair, mut count) = ([0.0; 2], 0);
        let whole = at.elements(list, Most::any(), f64::reader, |t, _| {
            if let Some(place) = pair.get_mut(count) {
                *place = t;
            }
            count += 1;
            Some(())
        })?;
        if whole && count != 2 {
            at.wrong(format!("expected a pair [u, v], found {count} numbers"));
        }
        Ok((whole && count == 2).then_some(Parameter::Pair(pair)))
    }
}

/// The parameters of a surface.
pub(super) enum SurfaceParameterChoice {}

schema_of!(SurfaceParameterChoice, "SurfaceParameters", generator => {
    let of_grid: Schema = PerDirection::<Parameters>::json_schema(generator);
    let mut choices = match of_grid.get("oneOf") {
        Some(Value::Array(choices)) => choices.clone(),
        _ => vec![of_grid.to_value()],
    };
    let mut base = generator.subschema_for::<FootPointsRequest>();
    base.insert("description".to_owned(), "The other job.".into());
    let scattered = [
        json_schema!({
            "title": "Pairs",
            "description": "Of scattered points: u and v of each.",
            "type": "array",
            "items": {"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 2},
            "minItems": 2,
        }),
        json_schema!({
            "description": "Of scattered points: their coordinates in the plane that lies nearest to them, along their principal axes.",
            "type": "string",
            "const": "project",
        }),
        json_schema!({
            "title": "Projection",
            "description": "Of scattered points: `nearest` is the same, `xy` their x and y.",
            "type": "object",
            "properties": {
                "project": {"type": "string", "enum": ProjectionPlane::NAMES, "description": "The plane.", "examples": ["xy"]},
            },
            "required": ["project"],
            "additionalProperties": false,
            "examples": [{"project": "xy"}],
        }),
        json_schema!({
            "title": "FootPointParameters",
            "description": "Of scattered points: the parameters of the nearest points of the surface of another job.",
            "type": "object",
            "properties": {
                "foot_points": base,
            },
            "required": ["foot_points"],
            "additionalProperties": false,
        }),
    ];
    choices.extend(scattered.into_iter().map(Schema::to_value));
    json_schema!({
        "description": "How the data points get their parameters: rows and columns by a rule or by numbers, for both directions or for each; scattered points by pairs, by a projection or by their foot points on another surface.",
        "oneOf": choices,
        "examples": ["centripetal", [[0, 0], [0.3, 1.2], [1, 0.7]], {"project": "xy"}],
    })
});
