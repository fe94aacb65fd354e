//! Requested methods, and their form for a fit.
//!
//! - `settings`: their settings; `least_squares`: those of least squares, with `constraint` and `counts`;
//! - `choice`: their form for a fit; `form`: the locations of their settings; `schema`: their schema.

mod choice;
mod constraint;
pub(crate) mod counts;
mod form;
mod least_squares;
mod schema;
mod settings;

use std::fmt;

use schemars::JsonSchema;
use serde::de::value::{MapAccessDeserializer, MapDeserializer};
use serde::de::{Deserializer, Error, MapAccess, Visitor};
use serde::{Deserialize, Serialize};

use super::errors::OrErrors;
use super::named::{Named, names};
use super::per_direction::PerDirection;
use super::serde_helpers::Kept;
use piad_fit::data::Grid;
use piad_fit::engine::Request;
use piad_fit::method::Method;

pub(crate) use choice::MethodChoice;
pub(crate) use constraint::ConstraintInput;
pub(crate) use form::{MethodForm, pointer};
pub(crate) use least_squares::{EndPointsInput, FairnessInput, LeastSquaresInput, VariantKind};
pub(crate) use schema::settings_of;
pub(crate) use settings::{
    AdaptiveInput, ConvexInput, CustomInput, ExtendedInput, LocalInput, StartInput, SweepsInput,
    WeightedInput,
};

/// The rule by which the control points move from iteration to iteration.
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

/// A kind of method.
#[derive(Clone, Copy, Debug, JsonSchema, PartialEq, Eq)]
#[schemars(rename_all = "snake_case")]
#[schemars(rename = "MethodKind", example = &"global")]
pub(crate) enum MethodKind {
    Global,
    Weighted,
    Local,
    Adaptive,
    Extended,
    Transpose,
    Convex,
    Chebyshev,
    Direct,
    LeastSquares,
    Custom,
}

names!(MethodKind, "kind of method", [
    "global" => Global,
    "weighted" => Weighted,
    "local" => Local,
    "adaptive" => Adaptive,
    "extended" => Extended,
    "transpose" => Transpose,
    "convex" => Convex,
    "chebyshev" => Chebyshev,
    "direct" => Direct,
    "least_squares" => LeastSquares,
    "custom" => Custom,
]);

/// A method without settings.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct NoSettings {}

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

impl MethodInput {
    /// The method for data points arranged in `grid`, and the points that it selects.
    pub(crate) fn choice(self, grid: Grid, surface: bool) -> OrErrors<MethodChoice> {
        let method = match self {
            Self::Global => Method::Global,
            Self::Weighted(it) => Method::Weighted(it.settings()),
            Self::Local(it) => return it.choice(grid, surface),
            Self::Adaptive(it) => Method::Adaptive(it.settings(grid, surface)?),
            Self::Extended(it) => Method::Extended(it.settings()),
            Self::Transpose => Method::Transpose,
            Self::Convex(it) => Method::Convex(it.settings()),
            Self::Chebyshev => Method::Chebyshev,
            Self::Direct => Method::Direct,
            Self::LeastSquares(it) => Method::LeastSquares(it.settings(grid, surface)?),
            Self::Custom(it) => Method::Custom(it.settings()?),
        };
        Ok(method.into())
    }

    /// The method of a problem in the form of a request.
    pub(in crate::model) fn of(request: &Request) -> Self {
        let (grid, surface) = (request.grid, request.v.is_some());
        match &request.method {
            Method::Global => Self::Global,
            Method::Weighted(it) => Self::Weighted(WeightedInput::of(*it)),
            Method::Local(it) => Self::Local(LocalInput::of(it, request)),
            Method::Adaptive(it) => Self::Adaptive(AdaptiveInput::of(it, grid, surface)),
            Method::Extended(it) => Self::Extended(ExtendedInput::of(*it)),
            Method::Transpose => Self::Transpose,
            Method::Convex(it) => Self::Convex(ConvexInput::of(*it)),
            Method::Chebyshev => Self::Chebyshev,
            Method::Direct => Self::Direct,
            Method::LeastSquares(it) => {
                Self::LeastSquares(LeastSquaresInput::of(it, grid, surface).into())
            }
            Method::Custom(it) => Self::Custom(CustomInput::of(it)),
        }
    }

    /// Its form.
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
