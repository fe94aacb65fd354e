//! Methods and their settings as they are asked for.
//!
//! - `kinds`: the kinds of methods, and names of settings;
//! - `least_squares`: the settings of least squares, with `constraint`;
//! - `choice`: what they are for a fit.

mod choice;
mod constraint;
pub(crate) mod counts;
mod kinds;
mod least_squares;

use std::borrow::Cow;
use std::fmt;
use std::sync::LazyLock;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::value::{MapAccessDeserializer, MapDeserializer};
use serde::de::{Deserializer, Error, MapAccess, Visitor};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::either::Kept;
use super::named::Named;
use super::per_direction::{PerDirection, direction};
use super::schema;
use super::settings::{Index, Matrix, Omega, Thresholds};
use crate::fit::invalid::Place as P;
use crate::fit::method::{METHODS, Start, Sweeps};

pub(crate) use constraint::ConstraintInput;
pub(crate) use kinds::{MethodKind, VariantKind};
pub(crate) use least_squares::LeastSquaresInput;

/// How the control points move from iteration to iteration.
#[derive(Clone, Debug, Default, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub(crate) enum MethodInput {
    /// Classical PIA.
    #[default]
    Global,
    /// Weighted PIA.
    Weighted(WeightedInput),
    /// Local PIA.
    Local(LocalInput),
    /// Adaptive PIA.
    Adaptive(AdaptiveInput),
    /// Extended PIA.
    Extended(ExtendedInput),
    /// The transposed matrix as transform.
    Transpose,
    /// Convexity-preserving PIA.
    Convex(ConvexInput),
    /// Chebyshev semi-iteration.
    Chebyshev,
    /// The direct solution.
    Direct,
    /// Least-squares PIA.
    LeastSquares(Box<LeastSquaresInput>),
    /// PIA with a given transform.
    Custom(CustomInput),
}

/// A method without settings.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct NoSettings {}

/// Settings of weighted PIA.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct WeightedInput {
    /// The relaxation. Without one it is `auto` for `weighted`, and 1 for the others.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub omega: Option<Omega>,
}

/// Settings of local PIA.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct LocalInput {
    /// The data points whose control points may move.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = 1), extend("uniqueItems" = true))]
    pub indices: Option<Vec<Index>>,
    /// Surfaces: the lines of points that are adjusted one after the other, until all are within the
    /// tolerance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sweeps: Option<Sweeps>,
    /// The relaxation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub omega: Option<Omega>,
}

/// Settings of adaptive PIA.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct AdaptiveInput {
    /// Only control points move whose data point is further away than this, in data units.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub threshold: Option<Thresholds>,
    /// The relaxation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub omega: Option<Omega>,
}

/// Settings of extended PIA.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ExtendedInput {
    /// What iteration 0 is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub start: Option<Start>,
    /// Whether each iteration tells the largest length of U Δ, too, as `error.transformed`: how far a
    /// control point moves in the next one.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("default" = false))]
    pub transformed_error: Option<bool>,
}

/// Settings of convexity-preserving PIA.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ConvexInput {
    /// How near bisection comes to the longest step that keeps the turns, as a part of the plain step.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1, "default" = 1e-6))]
    pub step_tolerance: Option<f64>,
}

/// Settings of PIA with a given transform.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct CustomInput {
    /// The transform U in `X ← X + U (P − B X)`; on surfaces of both directions, or one for each.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub transform: Option<PerDirection<Matrix>>,
}

/// Reads a method by its kind, wherever that stands, or from the name of the kind alone.
impl<'de> Deserialize<'de> for MethodInput {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct MethodVisitor;

        impl<'de> Visitor<'de> for MethodVisitor {
            type Value = MethodInput;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an object with a kind, or the name of a kind")
            }

            fn visit_str<E: Error>(self, name: &str) -> Result<MethodInput, E> {
                let none = std::iter::empty::<(&str, &str)>();
                MethodInput::with_settings(MethodKind::read(name)?, MapDeserializer::new(none))
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<MethodInput, A::Error> {
                let (kind, settings) = Kept::read(map)?;
                MethodInput::with_settings(kind, MapAccessDeserializer::new(settings))
            }
        }

        deserializer.deserialize_any(MethodVisitor)
    }
}

impl MethodInput {
    /// A method of this kind with these settings.
    fn with_settings<'de, D: Deserializer<'de>>(
        kind: MethodKind,
        settings: D,
    ) -> Result<Self, D::Error> {
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
        ("weighted", WeightedInput::json_schema(generator)),
        ("local", LocalInput::json_schema(generator)),
        ("adaptive", AdaptiveInput::json_schema(generator)),
        ("convex", ConvexInput::json_schema(generator)),
        ("extended", ExtendedInput::json_schema(generator)),
        ("least_squares", LeastSquaresInput::json_schema(generator)),
        ("custom", CustomInput::json_schema(generator)),
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
pub(crate) fn settings(kind: &str) -> Vec<String> {
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
impl JsonSchema for MethodInput {
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

impl MethodInput {
    /// How it is written.
    pub(crate) fn form(&self) -> MethodForm {
        match self {
            Self::LeastSquares(settings) => settings.form(),
            Self::Custom(CustomInput { transform }) => MethodForm {
                each: transform.as_ref().is_some_and(PerDirection::is_each),
                limited: false,
            },
            _ => MethodForm::default(),
        }
    }
}

/// How a method is written.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct MethodForm {
    /// The directions have a setting each.
    pub each: bool,
    /// The numbers of control points are limits.
    pub limited: bool,
}

/// The JSON pointer to a setting, or a part of it; everything else is the method.
pub(crate) fn pointer(place: P, MethodForm { each, limited }: MethodForm) -> String {
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
