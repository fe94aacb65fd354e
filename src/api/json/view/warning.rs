//! Warnings about a job.

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::{Value, json};

use crate::api::json::request::places::Places;
use crate::api::problem::Locator;
use crate::job::outline::Outline;
use crate::job::state::Levels;
use crate::model::errors::SpecPart;
use piad_fit::engine as fit;
use piad_fit::invalid::Axis;

/// A warning about a fit, which is computed nevertheless.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Warning", example = example())]
pub(crate) struct WarningView {
    /// The kind. `few_points`: with knots at the data and repeated ends the degree is no less than the number of
    /// points. `even_degree`: with knots at the data an even degree lets one point affect the whole curve. `rounding`:
    /// rounding will leave more of an extended fit than the tolerance. `shorter_interval`: Chebyshev steps by the least
    /// eigenvalue would make distances rise far, and others are taken. `ill_conditioned`: the slowest part of the error
    /// will hardly have changed after the last iteration. `without_data`: control points of a least-squares fit have no
    /// data and stay. `outliers`: a few points determine the bounding box, of which the tolerance is a part: its
    /// diagonal is more than 100 times that of the inner 90 % of the points. `reversed_tangent`: the data run against
    /// the vector of a tangent, so that the derivative there is zero. `slow_steps`: Chebyshev steps take hundreds of
    /// iterations to a hundredth of the error, and `global` is nearer in the first ones. `unordered`: fewer than a
    /// third of the points of a curve have a neighbour in the list among their three nearest points. `no_data_value`: a
    /// value of the points of a grid, such as -9999, often stands for missing data. `between_points`: the fit deviates
    /// between neighbouring data by more than these allow. `folded_parameters`: points of a surface with nearly the
    /// same parameters are far from each other, so that no surface is near both. `spikes`: a few points of a curve that
    /// least squares fits are far from where their neighbours predict them. `rounded_corners`: the points of a curve
    /// that chooses its knots turn as at corners, which `corners` would keep. Later versions may add others.
    #[schemars(extend("examples" = fit::Warning::CODES))]
    code: &'static str,
    /// A JSON pointer into the input of the job.
    pointer: String,
    /// The warning in words, with the reason and what to do.
    detail: String,
}

impl WarningView {
    /// The warnings about a job so far.
    pub(crate) fn of(outline: &Outline, levels: Option<&Levels>) -> Vec<Self> {
        let surface = outline.surface.then_some(outline.grid);
        let places = Places::of_input(surface, outline.bases_differ);
        let view = |warning: fit::Warning| Self {
            code: warning.code(),
            pointer: places.of(SpecPart::Fit(warning.place())),
            detail: warning.detail(),
        };
        outline.warnings(levels).map(view).collect()
    }
}

fn example() -> Value {
    let warning = fit::Warning::EvenDegree {
        axis: Axis::U,
        degree: 4,
    };
    json!({"code": warning.code(), "pointer": "/curve/basis/degree", "detail": warning.detail()})
}
