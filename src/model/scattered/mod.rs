//! The requested parameters of a surface: of points in a grid, or of scattered ones.

mod domains;
mod foot_points;
mod notices;
mod projection;
mod schema;

use std::fmt;
use std::sync::Arc;

use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer, StrDeserializer};
use serde::de::{Deserializer, Error, MapAccess, SeqAccess, Visitor};
use serde::ser::SerializeMap;
use serde::{Deserialize, Serialize, Serializer};

use super::basis::ParametersInput;
use super::lists::{LISTS, Lists};
use super::named::{Rule, names};
use super::per_direction::PerDirection;
use super::serde_helpers::{Whole, below};
use piad_fit::data::Points;
use piad_fit::parameters::{
    Domain, Mesh, MeshUnfolding, Pairs, Parametrization, Scattered, Sections,
};

pub(super) use foot_points::on_surface;
pub use foot_points::{FootPoints, no_base};
pub(crate) use notices::notices;

use domains::Domains;
use projection::{Projection, ProjectionSurface};

/// The parameters of the data points of a surface.
#[derive(Clone, Debug)]
pub(crate) enum SurfaceParameters {
    /// Parameters of the rows and columns of a grid.
    Grid(PerDirection<ParametersInput>),
    /// Given parameters of scattered points, or those from a plane.
    Scattered(Scattered),
    /// Parameters of the foot points of scattered points on the surface of another job.
    FootPoints(FootPoints),
}

/// The rule for the parameters of the vertices of a mesh.
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

impl SurfaceParameters {
    /// The parameters of rows and of columns, one by one.
    pub(crate) fn of_lines(lines: [Vec<f64>; 2]) -> Self {
        let [u, v] = lines.map(|it| ParametersInput(Parametrization::Explicit(Arc::new(it))));
        Self::Grid(PerDirection::Each { u, v })
    }
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

/// The error for parameters with several rules.
const ONE_OF: &str =
    "parameters are u and v, or project, or pairs, or sections, or triangles, or foot_points";

/// The fields of parameters as an object.
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
