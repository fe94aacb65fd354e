//! The JSON of a method, and its settings.
//!
//! - `kinds`: the kinds of methods, and names of settings;
//! - `least_squares`: the settings of least squares, with `constraint`;
//! - `written`: methods as they were asked for.

mod constraint;
pub(in crate::api) mod counts;
mod kinds;
mod least_squares;
mod written;

use std::borrow::Cow;
use std::fmt;
use std::sync::{Arc, LazyLock};

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;
use serde::de::value::{MapAccessDeserializer, MapDeserializer};
use serde::de::{Deserializer, Error, MapAccess, Visitor};
use serde_json::{Map, Value};

use super::schema;
use super::settings::{Index, Matrix, Omega, Thresholds};
use crate::api::json::per_direction::{PerDirection, direction};
use crate::fit::invalid::{Place as P, Setting};
use crate::fit::method::{
    self as fit, Adaptive, Convex, Custom, Extended, Local, METHODS, Method, Start, Sweeps,
    Weighted,
};
use crate::fit::points::Grid;
use crate::model::either::Kept;
use crate::model::method::{MethodSpec, sweeps};
use crate::model::mistakes::{Mistake, OrMistakes, SpecPart};
use crate::model::named::Named;
use least_squares::LeastSquaresRequest;

pub(in crate::api) use kinds::{MethodKind, VariantRequest, variant_name};
pub(in crate::api) use written::written;

/// How the control points move from iteration to iteration.
#[derive(Debug)]
pub(in crate::api) enum MethodRequest {
    Global,
    Weighted(WeightedRequest),
    Local(LocalRequest),
    Adaptive(AdaptiveRequest),
    Extended(ExtendedRequest),
    Transpose,
    Convex(ConvexRequest),
    Chebyshev,
    Direct,
    LeastSquares(Box<LeastSquaresRequest>),
    Custom(CustomRequest),
}

/// A method without settings.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct NoSettings {}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in crate::api) struct WeightedRequest {
    /// The relaxation. Without one it is `auto` for `weighted`, and 1 for the others.
    omega: Option<Omega>,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in crate::api) struct LocalRequest {
    /// The data points whose control points may move.
    #[schemars(length(min = 1), extend("uniqueItems" = true))]
    indices: Option<Vec<Index>>,
    /// Surfaces: the lines of points that are adjusted one after the other, until all are within the
    /// tolerance.
    sweeps: Option<Sweeps>,
    /// The relaxation.
    omega: Option<Omega>,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in crate::api) struct AdaptiveRequest {
    /// Only control points move whose data point is further away than this, in data units.
    threshold: Option<Thresholds>,
    /// The relaxation.
    omega: Option<Omega>,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in crate::api) struct ExtendedRequest {
    /// What iteration 0 is.
    start: Option<Start>,
    /// Whether each iteration tells the largest length of U Δ, too, as `error.transformed`: how far a
    /// control point moves in the next one.
    #[schemars(extend("default" = false))]
    transformed_error: Option<bool>,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in crate::api) struct ConvexRequest {
    /// How near bisection comes to the longest step that keeps the turns, as a part of the plain step.
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1, "default" = 1e-6))]
    step_tolerance: Option<f64>,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in crate::api) struct CustomRequest {
    /// The transform U in `X ← X + U (P − B X)`; on surfaces of both directions, or one for each.
    #[schemars(with = "Option<PerDirection<Matrix>>")]
    transform: Option<PerDirection<Matrix>>,
}

/// Reads a method by its kind, wherever that stands, or from the name of the kind alone.
impl<'de> Deserialize<'de> for MethodRequest {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct MethodVisitor;

        impl<'de> Visitor<'de> for MethodVisitor {
            type Value = MethodRequest;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an object with a kind, or the name of a kind")
            }

            fn visit_str<E: Error>(self, name: &str) -> Result<MethodRequest, E> {
                let none = std::iter::empty::<(&str, &str)>();
                MethodRequest::of(MethodKind::read(name)?, MapDeserializer::new(none))
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<MethodRequest, A::Error> {
                let (kind, settings) = Kept::read(map)?;
                MethodRequest::of(kind, MapAccessDeserializer::new(settings))
            }
        }

        deserializer.deserialize_any(MethodVisitor)
    }
}

impl MethodRequest {
    /// A method of this kind with these settings.
    fn of<'de, D: Deserializer<'de>>(kind: MethodKind, settings: D) -> Result<Self, D::Error> {
        let none = |settings, method| NoSettings::deserialize(settings).map(|_| method);
        match kind {
            MethodKind::Global => none(settings, Self::Global),
            MethodKind::Weighted => Deserialize::deserialize(settings).map(Self::Weighted),
            MethodKind::Local => Deserialize::deserialize(settings).map(Self::Local),
            MethodKind::Adaptive => Deserialize::deserialize(settings).map(Self::Adaptive),
            MethodKind::Extended => Deserialize::deserialize(settings).map(Self::Extended),
            MethodKind::Transpose => none(settings, Self::Transpose),
            MethodKind::Convex => Deserialize::deserialize(settings).map(Self::Convex),
            MethodKind::Chebyshev => none(settings, Self::Chebyshev),
            MethodKind::Direct => none(settings, Self::Direct),
            MethodKind::LeastSquares => Deserialize::deserialize(settings).map(Self::LeastSquares),
            MethodKind::Custom => Deserialize::deserialize(settings).map(Self::Custom),
        }
    }
}

/// The schemas of the settings of methods that have some.
fn schemas(generator: &mut SchemaGenerator) -> [(&'static str, Schema); 7] {
    [
        ("weighted", WeightedRequest::json_schema(generator)),
        ("local", LocalRequest::json_schema(generator)),
        ("adaptive", AdaptiveRequest::json_schema(generator)),
        ("convex", ConvexRequest::json_schema(generator)),
        ("extended", ExtendedRequest::json_schema(generator)),
        ("least_squares", LeastSquaresRequest::json_schema(generator)),
        ("custom", CustomRequest::json_schema(generator)),
    ]
}

/// The fields of a schema.
fn fields(schema: &mut Schema) -> Map<String, Value> {
    match schema.remove("properties") {
        Some(Value::Object(fields)) => fields,
        _ => Map::new(),
    }
}

/// The settings of a method.
pub(in crate::api) fn settings(kind: &str) -> Vec<String> {
    static SETTINGS: LazyLock<Vec<(&str, Vec<String>)>> = LazyLock::new(|| {
        let schemas = schemas(&mut SchemaGenerator::default()).into_iter();
        let names = |mut schema| fields(&mut schema).into_iter().map(|(name, _)| name);
        let own = schemas.map(|(kind, schema)| (kind, names(schema).collect()));
        own.collect()
    });
    let entry = SETTINGS.iter().find(|(method, _)| *method == kind);
    entry.map_or_else(Vec::new, |(_, settings)| settings.clone())
}

/// One object with the settings of all methods, each of which says to which it belongs: generated
/// clients have one type for it.
impl JsonSchema for MethodRequest {
    fn schema_name() -> Cow<'static, str> {
        "Method".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let mut kind = generator.subschema_for::<MethodKind>();
        kind.insert("description".to_owned(), "The kind of the method.".into());
        let mut all = Map::from_iter([("kind".to_owned(), kind.to_value())]);
        let mut owners: Vec<(String, Vec<&str>)> = Vec::new();
        for (kind, mut schema) in schemas(generator) {
            for (name, setting) in fields(&mut schema) {
                match owners.iter_mut().find(|(known, _)| *known == name) {
                    Some((_, kinds)) => kinds.push(kind),
                    None => owners.push((name.clone(), vec![kind])),
                }
                all.entry(name).or_insert(setting);
            }
        }
        let mut schema = json_schema!({
            "description": "How the control points move from iteration to iteration.",
            "type": "object",
            "properties": all,
            "required": ["kind"],
            "additionalProperties": false,
            "examples": [{"kind": "weighted", "omega": "auto"}],
        });
        schema::explain(&mut schema, &METHODS);
        for (name, kinds) in owners {
            schema::belongs(&mut schema, &name, &kinds);
        }
        schema
    }
}

impl MethodRequest {
    /// How it is written.
    pub(super) fn form(&self) -> MethodForm {
        match self {
            Self::LeastSquares(settings) => {
                let most = settings.max_control_points;
                MethodForm {
                    each: settings.control_points.is_some_and(|count| count.is_each())
                        || most.is_some_and(|most| most.is_each()),
                    limited: most.is_some(),
                }
            }
            Self::Custom(CustomRequest { transform }) => MethodForm {
                each: transform.as_ref().is_some_and(PerDirection::is_each),
                limited: false,
            },
            _ => MethodForm::default(),
        }
    }

    /// The method for data points arranged in `grid`, and the points that it selects.
    pub(super) fn spec(self, grid: Grid, surface: bool) -> OrMistakes<MethodSpec> {
        let method = match self {
            Self::Global => Method::Global,
            Self::Weighted(WeightedRequest { omega }) => Method::Weighted(Weighted {
                omega: omega.and_then(|Omega(omega)| omega),
            }),
            Self::Local(local) => return local.spec(grid, surface),
            Self::Adaptive(adaptive) => Method::Adaptive(adaptive.settings(grid, surface)?),
            Self::Extended(extended) => Method::Extended(Extended {
                start: extended.start.unwrap_or_default(),
                transformed_error: extended.transformed_error.unwrap_or(false),
            }),
            Self::Transpose => Method::Transpose,
            Self::Convex(ConvexRequest { step_tolerance }) => {
                let convex = step_tolerance.map(|step_tolerance| Convex { step_tolerance });
                Method::Convex(convex.unwrap_or_default())
            }
            Self::Chebyshev => Method::Chebyshev,
            Self::Direct => Method::Direct,
            Self::LeastSquares(it) => Method::LeastSquares(it.settings(grid, surface)?),
            Self::Custom(CustomRequest { transform }) => Method::Custom(match transform {
                Some(PerDirection::Both(Matrix(u))) => Custom::new(u, None),
                Some(PerDirection::Each { u, v }) => Custom::new(u.0, Some(v.0)),
                None => {
                    return incomplete(
                        "custom needs a transform: the rows of a matrix, on surfaces also {\"u\": …, \"v\": …}",
                    );
                }
            }),
        };
        Ok(method.into())
    }
}

impl LocalRequest {
    fn spec(self, grid: Grid, surface: bool) -> OrMistakes<MethodSpec> {
        let selected = self.indices.map(|mut given| {
            // Among more than there are points one is wrong, or given twice.
            given.truncate(grid.count().saturating_add(1));
            let of_point = |(k, index): (usize, Index)| {
                let wrong = |detail| Mistake::at(SpecPart::Fit(P::Index(k)), detail);
                index.of_point(grid, surface).map_err(wrong)
            };
            given.into_iter().enumerate().map(of_point).collect()
        });
        let selected: Option<Arc<[usize]>> = selected.transpose()?;
        let settings = Local {
            omega: match self.omega {
                None => fit::Omega::default(),
                Some(Omega(None)) => fit::Omega::Best,
                Some(Omega(Some(omega))) => fit::Omega::Given(omega),
            },
            sweeps: sweeps(self.sweeps, surface)?,
        };
        MethodSpec::local(selected, settings)
    }
}

impl AdaptiveRequest {
    fn settings(self, grid: Grid, surface: bool) -> OrMistakes<Adaptive> {
        let omega = match self.omega {
            None => 1.0,
            Some(Omega(Some(omega))) => omega,
            Some(Omega(None)) => {
                let detail = "adaptive needs a number: the best omega is another one for each choice of points";
                let place = P::Setting(Setting::Omega);
                return Err(Mistake::at(SpecPart::Fit(place), detail).into());
            }
        };
        let Some(threshold) = self.threshold else {
            return incomplete("adaptive needs a threshold, in data units");
        };
        let place = P::Setting(Setting::Threshold);
        let wrong = |detail| Mistake::at(SpecPart::Fit(place), detail);
        let threshold = threshold.of_points(grid, surface).map_err(wrong)?;
        Ok(Adaptive { threshold, omega })
    }
}

/// A setting is missing.
fn incomplete<T>(detail: &str) -> OrMistakes<T> {
    Err(Mistake::at(SpecPart::Fit(P::Method), detail).into())
}

/// How a method is written.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct MethodForm {
    /// The directions have a setting each.
    each: bool,
    /// The numbers of control points are limits.
    limited: bool,
}

/// The JSON pointer to a setting, or a part of it; everything else is the method.
pub(super) fn pointer(place: P, MethodForm { each, limited }: MethodForm) -> String {
    let setting = match place {
        P::Setting(setting) => setting.name().to_owned(),
        P::Index(index) => format!("indices/{index}"),
        P::Constraint(index) => format!("constraints/{index}"),
        P::ControlPoints(axis) if limited => {
            format!("max_control_points{}", direction(each, axis))
        }
        P::ControlPoints(axis) => format!("control_points{}", direction(each, axis)),
        P::Transform(axis) => format!("transform{}", direction(each, axis)),
        P::TransformRow(axis, row) => format!("transform{}/{row}", direction(each, axis)),
        P::TransformEntry(axis, row, column) => {
            format!("transform{}/{row}/{column}", direction(each, axis))
        }
        _ => return "/method".to_owned(),
    };
    format!("/method/{setting}")
}
