//! The parameters of a surface as they are asked for: of points in a grid, or of scattered ones.

use std::fmt;
use std::sync::Arc;

use schemars::{JsonSchema, Schema, json_schema};
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer, StrDeserializer};
use serde::de::{Deserializer, Error, MapAccess, SeqAccess, Visitor};
use serde::ser::SerializeMap;
use serde::{Deserialize, Serialize, Serializer};
use serde_json::{Value, json};

use super::basis::ParametersInput;
use super::either::{Whole, below, object};
use super::iteration::IterationChoice;
use super::lists::{LISTS, Lists};
use super::mistakes::{Mistake, SpecPart};
use super::named::{Named, Rule, names};
use super::per_direction::PerDirection;
use super::schema::schema_of;
use piad_fit::data::Points;
use piad_fit::geometry::{Nurbs, foot_points};
use piad_fit::parameters::{
    CoordinatePlane, Cylinder, Domain, FoldedTriangles, MAX_TRIANGLES, Mesh, MeshUnfolding, Pairs,
    Parametrization, Scattered, Sections, Sphere,
};

/// The parameters of the data points of a surface.
#[derive(Clone, Debug)]
pub(crate) enum SurfaceParameters {
    /// Those of the rows and columns of a grid.
    Grid(PerDirection<ParametersInput>),
    /// Those of scattered points, as they are given, or from a plane.
    Scattered(Scattered),
    /// Those of the foot points of scattered points on the surface of another job.
    FootPoints(FootPoints),
}

/// The surface on which scattered points have their parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ProjectionSurface {
    Plane,
    Cylinder,
    Sphere,
    Xy,
    Xz,
    Yz,
}

names!(ProjectionSurface, "projection", [
    "plane" => Plane,
    "cylinder" => Cylinder,
    "sphere" => Sphere,
    "xy" => Xy,
    "xz" => Xz,
    "yz" => Yz,
]);

/// How the vertices of a mesh get their parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MeshUnfoldingInput {
    Auto,
    MeanValue,
}

names!(MeshUnfoldingInput, "unfolding of a mesh", [
    "auto" => Auto,
    "mean_value" => MeanValue,
]);

impl From<MeshUnfoldingInput> for MeshUnfolding {
    fn from(unfolding: MeshUnfoldingInput) -> Self {
        match unfolding {
            MeshUnfoldingInput::Auto => Self::Auto,
            MeshUnfoldingInput::MeanValue => Self::MeanValue,
        }
    }
}

/// A projection with what is known of its surface.
#[derive(Deserialize, Serialize)]
struct Projection {
    project: ProjectionSurface,
    #[serde(skip_serializing_if = "Option::is_none")]
    axis: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    center: Option<[f64; 3]>,
}

impl Projection {
    /// The rule, or what is given that it does not have.
    fn rule(self) -> Result<Scattered, &'static str> {
        use ProjectionSurface as S;
        let Self {
            project,
            axis,
            center,
        } = self;
        Ok(match project {
            S::Cylinder => Scattered::Cylinder(Cylinder { axis, center }),
            S::Sphere => Scattered::Sphere(Sphere { axis, center }),
            _ if axis.is_some() => return Err("only a cylinder and a sphere have an axis"),
            _ if center.is_some() => return Err("only a cylinder and a sphere have a center"),
            S::Plane => Scattered::Plane,
            S::Xy => Scattered::Coordinates(CoordinatePlane::Xy),
            S::Xz => Scattered::Coordinates(CoordinatePlane::Xz),
            S::Yz => Scattered::Coordinates(CoordinatePlane::Yz),
        })
    }

    /// That of a rule; `None` of pairs, of `auto` and of a mesh.
    fn of(rule: &Scattered) -> Option<Self> {
        use ProjectionSurface as S;
        let (project, axis, center) = match *rule {
            Scattered::Given(_) | Scattered::Auto | Scattered::Sections(_) | Scattered::Mesh(_) => {
                return None;
            }
            Scattered::Plane => (S::Plane, None, None),
            Scattered::Coordinates(CoordinatePlane::Xy) => (S::Xy, None, None),
            Scattered::Coordinates(CoordinatePlane::Xz) => (S::Xz, None, None),
            Scattered::Coordinates(CoordinatePlane::Yz) => (S::Yz, None, None),
            Scattered::Cylinder(Cylinder { axis, center }) => (S::Cylinder, axis, center),
            Scattered::Sphere(Sphere { axis, center }) => (S::Sphere, axis, center),
        };
        Some(Self {
            project,
            axis,
            center,
        })
    }
}

/// How far the directions of pairs go that do not end at the data.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(remote = "Self", deny_unknown_fields)]
#[schemars(rename = "ParameterDomains")]
#[schemars(example = json!({"u": {"period": 94.2}}))]
struct Domains {
    /// That of u; without it from the least to the largest parameter.
    #[serde(skip_serializing_if = "Option::is_none")]
    u: Option<DomainInput>,
    /// That of v.
    #[serde(skip_serializing_if = "Option::is_none")]
    v: Option<DomainInput>,
}

object!(Domains, "an object with u or v");

/// How far a direction goes: a period, or both ends.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(remote = "Self", deny_unknown_fields)]
#[schemars(rename = "ParameterDomain")]
#[schemars(example = json!({"ends": [-39.3, 39.3], "poles": [true, true]}))]
struct DomainInput {
    /// The direction is closed, and repeats after this length.
    #[serde(skip_serializing_if = "Option::is_none")]
    period: Option<f64>,
    /// Where the direction begins and ends.
    #[serde(skip_serializing_if = "Option::is_none")]
    ends: Option<[f64; 2]>,
    /// Of v: which ends are poles, at which all control points are one. With `control_points` "auto".
    #[serde(skip_serializing_if = "Option::is_none")]
    poles: Option<[bool; 2]>,
}

object!(DomainInput, "an object with a period or with ends");

impl DomainInput {
    fn domain(self) -> Result<Domain, &'static str> {
        match (self.period, self.ends, self.poles) {
            (None, None, None) => Ok(Domain::Data),
            (Some(period), None, None) => Ok(Domain::Closed(period)),
            (None, Some(ends), poles) => Ok(Domain::Between {
                ends,
                poles: poles.unwrap_or_default(),
            }),
            (Some(_), ..) => Err("a direction with a period has neither ends nor poles"),
            (None, None, Some(_)) => Err("poles are at ends: give both ends"),
        }
    }

    fn of(domain: Domain) -> Option<Self> {
        match domain {
            Domain::Data => None,
            Domain::Closed(period) => Some(Self {
                period: Some(period),
                ..Self::default()
            }),
            Domain::Between { ends, poles } => Some(Self {
                ends: Some(ends),
                poles: (poles != [false; 2]).then_some(poles),
                ..Self::default()
            }),
        }
    }
}

impl Domains {
    fn domains(self) -> Result<[Domain; 2], &'static str> {
        let [u, v] = [self.u, self.v].map(|it| it.unwrap_or_default().domain());
        Ok([u?, v?])
    }

    fn of([u, v]: [Domain; 2]) -> Self {
        let [u, v] = [u, v].map(DomainInput::of);
        Self { u, v }
    }
}

/// The surface of another job, for foot points: the nearest points of it. They are found once, when the
/// new job is made.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(remote = "Self", deny_unknown_fields)]
#[schemars(rename = "FootPointsRequest")]
#[schemars(example = json!({"job": "01a1e1b6-7c2e-7d58-9b5f-6c1f6f3c1b7a", "iteration": 12}))]
pub struct FootPoints {
    /// The id of the job whose surface it is, with as many coordinates as the points.
    pub job: String,
    /// An iteration that the job has reached; without it, the last one of a job that has ended.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) iteration: Option<IterationChoice>,
}

object!(FootPoints, "an object with a job");

/// The parameters of the foot points of scattered points on a surface, or why there are none.
pub(super) fn on_surface(
    points: &Points,
    surface: Result<&Nurbs, Mistake>,
) -> Result<Scattered, Mistake> {
    match foot_points(surface?, points) {
        Ok(pairs) => Ok(Scattered::Given(pairs)),
        Err(reason) => Err(Mistake::at(SpecPart::FootPoints, reason.to_string())),
    }
}

/// What is said of parameters that the fit has chosen, and of triangles of a mesh that these turn over.
pub(crate) fn notices(chosen: &Scattered, folded: Option<FoldedTriangles>) -> Vec<String> {
    let folded = folded.map(|folded| {
        let FoldedTriangles {
            count,
            triangle,
            share,
        } = folded;
        let percent = 100.0 * share;
        format!(
            "{count} triangles of the mesh, with {percent:.2} % of its area, are turned over or have no area by the parameters of their points; the first of them is triangle {triangle}"
        )
    });
    notice(chosen).into_iter().chain(folded).collect()
}

fn notice(chosen: &Scattered) -> Option<String> {
    let place = |place: Option<[f64; 3]>| {
        let [x, y, z] = place.unwrap_or_default();
        format!("({x:.6}, {y:.6}, {z:.6})")
    };
    let surface = match chosen {
        Scattered::Given(_) | Scattered::Auto | Scattered::Coordinates(_) => return None,
        Scattered::Sections(sections) => {
            let (count, kind) = match sections.closed {
                Some(true) => (sections.counts.len(), "closed"),
                _ => (sections.counts.len(), "open"),
            };
            return Some(format!("the points are {count} {kind} sections"));
        }
        Scattered::Mesh(_) => {
            let notice =
                "the parameters of the points are their mean value coordinates on the mesh";
            return Some(notice.to_owned());
        }
        Scattered::Plane => "the plane nearest to them".to_owned(),
        Scattered::Cylinder(Cylinder { axis, center }) => {
            format!(
                "a cylinder along {} through {}",
                place(*axis),
                place(*center)
            )
        }
        Scattered::Sphere(Sphere { axis, center }) => {
            format!(
                "a sphere around {} with a pole in direction {}",
                place(*center),
                place(*axis)
            )
        }
    };
    Some(format!(
        "the parameters of the points are their places on {surface}"
    ))
}

/// What is said of a surface that nobody has looked for.
pub fn no_base() -> Mistake {
    Mistake::at(SpecPart::FootPoints, "other jobs are not known here")
}

impl<'de> Deserialize<'de> for SurfaceParameters {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(ParametersVisitor)
    }
}

struct ParametersVisitor;

impl<'de> Visitor<'de> for ParametersVisitor {
    type Value = SurfaceParameters;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (what, names) = (ParametersInput::WHAT, ParametersInput::names().join(", "));
        write!(
            f,
            "the name of a {what}: {names}; or a list of numbers; or one for each direction, {{\"u\": …, \"v\": …}}; of scattered points pairs, [[u, v], …], \"auto\", \"project\", triangles or foot_points"
        )
    }

    fn visit_str<E: Error>(self, name: &str) -> Result<SurfaceParameters, E> {
        match name {
            "auto" => return Ok(SurfaceParameters::Scattered(Scattered::Auto)),
            "project" => return Ok(SurfaceParameters::Scattered(Scattered::Plane)),
            _ => {}
        }
        let rule = ParametersInput::deserialize(StrDeserializer::new(name))?;
        Ok(SurfaceParameters::Grid(PerDirection::Both(rule)))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<SurfaceParameters, A::Error> {
        let Lists { values, lengths } =
            Lists::read(SeqAccessDeserializer::new(list), LISTS, false, 2)?;
        match lengths[..] {
            [_] => {
                let numbers = ParametersInput(Parametrization::Explicit(Arc::new(values)));
                Ok(SurfaceParameters::Grid(PerDirection::Both(numbers)))
            }
            [_, 2] => {
                let pairs = Pairs::open(Arc::new(Points::from_flat(2, &values)));
                Ok(SurfaceParameters::Scattered(Scattered::Given(pairs)))
            }
            // All have the same length.
            _ => Err(below(
                "/0",
                "expected a number, or of scattered points a pair [u, v]",
            )),
        }
    }

    /// A projection, another surface, or a value for each direction.
    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<SurfaceParameters, A::Error> {
        let Each {
            u,
            v,
            project,
            axis,
            center,
            pairs,
            domains,
            sections,
            mut triangles,
            unfolding,
            foot_points,
        } = Each::deserialize(MapAccessDeserializer::new(map))?;
        let missing = |name| Err(A::Error::missing_field(name));
        let wrong = |detail| Err(A::Error::custom(detail));
        if project.is_none() && (axis.is_some() || center.is_some()) {
            return wrong("axis and center are those of the surface of project");
        }
        if pairs.is_none() && domains.is_some() {
            return wrong("domains are those of pairs");
        }
        if let Some(counts) = sections {
            let others = project.is_some() || pairs.is_some() || foot_points.is_some();
            let others = others || triangles.is_some();
            return match others || u.is_some() || v.is_some() {
                true => wrong("sections have parameters of their own"),
                false => {
                    let counts: Vec<usize> = counts.iter().map(|Whole(count)| *count).collect();
                    let sections = Scattered::Sections(Sections::new(counts));
                    Ok(SurfaceParameters::Scattered(sections))
                }
            };
        }
        if triangles.is_none() && unfolding.is_some() {
            return wrong("unfolding is that of triangles");
        }
        let is_alone = project.is_none() && pairs.is_none() && foot_points.is_none();
        if let (Some(TriangleList(triangles)), true, None, None) =
            (&mut triangles, is_alone, &u, &v)
        {
            let mesh = Mesh {
                triangles: Arc::new(std::mem::take(triangles)),
                unfolding: unfolding.map_or(MeshUnfolding::Auto, MeshUnfolding::from),
            };
            return Ok(SurfaceParameters::Scattered(Scattered::Mesh(mesh)));
        }
        match (project, pairs, foot_points, u, v) {
            _ if triangles.is_some() => wrong(ONE_OF),
            (Some(project), None, None, None, None) => {
                let projection = Projection {
                    project,
                    axis,
                    center,
                };
                projection
                    .rule()
                    .map_or_else(wrong, |rule| Ok(SurfaceParameters::Scattered(rule)))
            }
            (None, Some(PairList(values)), None, None, None) => {
                let domains = domains.unwrap_or_default().domains();
                domains.map_or_else(wrong, |domains| {
                    let pairs = Pairs { values, domains };
                    Ok(SurfaceParameters::Scattered(Scattered::Given(pairs)))
                })
            }
            (None, None, Some(base), None, None) => Ok(SurfaceParameters::FootPoints(base)),
            (None, None, None, Some(u), Some(v)) => {
                Ok(SurfaceParameters::Grid(PerDirection::Each { u, v }))
            }
            (None, None, None, None, _) => missing("u"),
            (None, None, None, _, None) => missing("v"),
            _ => wrong(ONE_OF),
        }
    }
}

/// What is wrong with parameters that have several rules.
const ONE_OF: &str =
    "parameters are u and v, or project, or pairs, or sections, or triangles, or foot_points";

/// What parameters may have as an object.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Each {
    u: Option<ParametersInput>,
    v: Option<ParametersInput>,
    project: Option<ProjectionSurface>,
    axis: Option<[f64; 3]>,
    center: Option<[f64; 3]>,
    pairs: Option<PairList>,
    domains: Option<Domains>,
    sections: Option<Vec<Whole>>,
    triangles: Option<TriangleList>,
    unfolding: Option<MeshUnfoldingInput>,
    foot_points: Option<FootPoints>,
}

/// The triangles of a mesh.
#[derive(Deserialize)]
struct TriangleList(Vec<[u32; 3]>);

/// u and v of each point.
struct PairList(Arc<Points>);

impl<'de> Deserialize<'de> for PairList {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        match SurfaceParameters::deserialize(deserializer)? {
            SurfaceParameters::Scattered(Scattered::Given(Pairs { values, .. })) => {
                Ok(Self(values))
            }
            _ => Err(D::Error::custom("pairs are a list, [[u, v], …]")),
        }
    }
}

/// Writes u and v of each point.
fn pair_list(values: &Points) -> Vec<Vec<f64>> {
    (0..values.len())
        .map(|k| values.point(k).collect())
        .collect()
}

impl Serialize for SurfaceParameters {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Grid(parameters) => parameters.serialize(serializer),
            Self::Scattered(Scattered::Given(Pairs { values, domains })) => {
                let pairs = pair_list(values);
                match domains {
                    [Domain::Data, Domain::Data] => pairs.serialize(serializer),
                    domains => {
                        let mut map = serializer.serialize_map(Some(2))?;
                        map.serialize_entry("pairs", &pairs)?;
                        map.serialize_entry("domains", &Domains::of(*domains))?;
                        map.end()
                    }
                }
            }
            Self::Scattered(Scattered::Sections(sections)) => {
                serializer.collect_map([("sections", &*sections.counts)])
            }
            Self::Scattered(Scattered::Auto) => serializer.serialize_str("auto"),
            Self::Scattered(Scattered::Plane) => serializer.serialize_str("project"),
            Self::Scattered(Scattered::Mesh(Mesh {
                triangles,
                unfolding,
            })) => {
                let mut fields = serializer.serialize_map(None)?;
                fields.serialize_entry("triangles", &**triangles)?;
                if *unfolding == MeshUnfolding::MeanValue {
                    fields.serialize_entry("unfolding", &MeshUnfoldingInput::MeanValue)?;
                }
                fields.end()
            }
            Self::Scattered(rule) => Projection::of(rule).serialize(serializer),
            Self::FootPoints(base) => serializer.collect_map([("foot_points", base)]),
        }
    }
}

schema_of!(SurfaceParameters, "SurfaceParameters", generator => {
    let of_grid: Schema = PerDirection::<ParametersInput>::json_schema(generator);
    let mut choices = match of_grid.get("oneOf") {
        Some(Value::Array(choices)) => choices.clone(),
        _ => vec![of_grid.to_value()],
    };
    let mut base = generator.subschema_for::<FootPoints>();
    base.insert("description".to_owned(), "The other job.".into());
    let mut domains = generator.subschema_for::<Domains>();
    domains.insert("description".to_owned(), "How far they go where that is not from the least to the largest parameter.".into());
    let scattered = [
        json_schema!({
            "title": "Pairs",
            "description": "Of scattered points: u and v of each.",
            "type": "array",
            "items": {"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 2},
            "minItems": 2,
        }),
        json_schema!({
            "description": "Of scattered points: their places on a plane, a cylinder or a sphere near them, whichever unfolds them best; so it is where no parameters are given. The notices of the job have the choice.",
            "type": "string",
            "const": "auto",
        }),
        json_schema!({
            "description": "Of scattered points: their coordinates in the plane that lies nearest to them, along the sides of the least rectangle around them.",
            "type": "string",
            "const": "project",
        }),
        json_schema!({
            "title": "Projection",
            "description": "Of scattered points: `plane` is the same; of `cylinder` u goes around the cylinder nearest to them, and v along it; of `sphere` u is the longitude and v the latitude on the sphere nearest to them, both as lengths; `xy`, `xz` and `yz` are two of their coordinates. Where the points go all around, u is closed; where they come to a pole of the sphere, all control points there are one.",
            "type": "object",
            "properties": {
                "project": {"type": "string", "enum": ProjectionSurface::names(), "description": "The surface.", "examples": ["cylinder"]},
                "axis": {"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3, "description": "The direction of the axis of a cylinder, or of a pole of a sphere.", "examples": [[0, 0, 1]]},
                "center": {"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3, "description": "A point on the axis of a cylinder, or the centre of a sphere.", "examples": [[0, 0, 0]]},
            },
            "required": ["project"],
            "additionalProperties": false,
            "examples": [{"project": "xy"}, {"project": "cylinder", "axis": [0, 0, 1]}],
        }),
        json_schema!({
            "title": "PairsAndDomains",
            "description": "Of scattered points: u and v of each, and how far the directions go.",
            "type": "object",
            "properties": {
                "pairs": {
                    "type": "array",
                    "items": {"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 2},
                    "minItems": 2,
                    "description": "u and v of each point.",
                },
                "domains": domains,
            },
            "required": ["pairs"],
            "additionalProperties": false,
        }),
        json_schema!({
            "title": "SectionCounts",
            "description": "Of scattered points that are sections, one after the other: the number of points of each.",
            "type": "object",
            "properties": {
                "sections": {
                    "type": "array",
                    "items": {"type": "integer", "minimum": 2},
                    "minItems": 2,
                    "description": "The number of points of each section.",
                    "examples": [[24, 40, 31]],
                },
            },
            "required": ["sections"],
            "additionalProperties": false,
        }),
        json_schema!({
            "title": "MeshParameters",
            "description": "Of scattered points that are the vertices of a mesh, one piece without handles: the triangles between them. Where a plane, a cylinder or a sphere unfolds all triangles, the parameters are the places on it; else mean value coordinates (Floater 2003). A mesh with one boundary loop fills a rectangle, if its boundary is smooth between the corners; one with two loops is closed in u; a closed one is unrolled by a sphere. Loops shorter than a quarter of the longest one are holes. The notices of the job have the choice, and the triangles that are turned over.",
            "type": "object",
            "properties": {
                "triangles": {
                    "type": "array",
                    "items": {"type": "array", "items": {"type": "integer", "minimum": 0}, "minItems": 3, "maxItems": 3},
                    "minItems": 1,
                    "maxItems": MAX_TRIANGLES,
                    "description": "The indices of the corners of each triangle, from 0, in either sense.",
                    "examples": [[[0, 1, 2], [2, 1, 3]]],
                },
                "unfolding": {"type": "string", "enum": MeshUnfoldingInput::names(), "default": "auto", "description": "`mean_value`: no plane, cylinder or sphere is tried.", "examples": ["mean_value"]},
            },
            "required": ["triangles"],
            "additionalProperties": false,
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
        "description": "How the data points get their parameters: rows and columns by a rule or by numbers, for both directions or for each; scattered points by pairs, by a projection, as sections, by the triangles of a mesh or by their foot points on another surface.",
        "oneOf": choices,
        "examples": ["centripetal", [[0, 0], [0.3, 1.2], [1, 0.7]], {"project": "xy"}],
    })
});
