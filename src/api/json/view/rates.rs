//! Comparisons of bases.

use schemars::JsonSchema;
use serde::Serialize;

use crate::api::rates::Rates;
use crate::model::basis::BasisKind;

/// How fast classical PIA converges with each basis at the same parameters.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Rates")]
#[schemars(extend("examples" = [{"points": 3, "tolerance": 1e-6, "bases": [{"basis": "bernstein", "degree": 2, "lambda_min": 0.5, "rate": 0.5, "iterations": 20}]}]))]
pub(crate) struct RatesView {
    /// The number of points.
    points: usize,
    /// To which part an error is reduced.
    tolerance: f64,
    /// The bases: polynomials through all points, and B-splines with knots at the data.
    bases: Vec<RateView>,
}

/// The convergence of classical PIA with a basis.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "BasisRate")]
#[schemars(extend("examples" = [{"basis": "bernstein", "degree": 2, "lambda_min": 0.5, "rate": 0.5, "iterations": 20}]))]
struct RateView {
    /// The basis.
    #[schemars(with = "BasisKind")]
    basis: &'static str,
    /// The degree.
    degree: usize,
    /// The least eigenvalue of the collocation matrix, by its absolute value; null where rounding hides it, and for
    /// polynomials through more than 100 points other than Bernstein at equal steps.
    lambda_min: Option<f64>,
    /// The factor by which an iteration reduces distances in the long run, 1 − lambda_min where the basis is totally
    /// positive. Above one they grow.
    rate: Option<f64>,
    /// The number of iterations that reduce them to the part `tolerance`, by the rate; null where it is unknown or
    /// beyond 1e15.
    iterations: Option<u64>,
}

impl RatesView {
    /// A comparison.
    pub(crate) fn new(rates: &Rates) -> Self {
        let view = |rate: &piad_fit::engine::rates::BasisRate| RateView {
            basis: rate.basis,
            degree: rate.degree,
            lambda_min: rate.lambda_min,
            rate: rate.rate,
            iterations: rate.iterations(rates.tolerance),
        };
        Self {
            points: rates.points,
            tolerance: rates.tolerance,
            bases: rates.bases.iter().map(view).collect(),
        }
    }
}
