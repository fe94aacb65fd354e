//! Comparisons of bases, for both transports.

use super::app::App;
use super::create_job;
use super::problem::Problem;
use piad_fit::engine::rates::{BasisRate, MOST_DEGREE, MOST_POINTS, compare};
use piad_fit::invalid::{Invalid, Place, one_for_each};

/// The default part of an error that is left.
pub(super) const USUAL_TOLERANCE: f64 = 1e-6;

/// The default number of points: that of DP07, Table 1.
pub(super) const USUAL_POINTS: usize = 11;

/// The default degree of the B-splines.
pub(super) const USUAL_DEGREE: usize = 3;

/// The request.
#[derive(Clone, Debug, Default)]
pub(super) struct RatesRequest {
    /// The number of points; it follows from explicit parameters.
    pub points: Option<usize>,
    /// Explicit parameters; equal steps without them.
    pub parameters: Option<Vec<f64>>,
    /// The degree of the B-splines.
    pub degree: Option<usize>,
    /// The part to which an error is to be reduced.
    pub tolerance: Option<f64>,
}

/// A comparison.
#[derive(Clone, Debug)]
pub(crate) struct Rates {
    /// The number of points.
    pub points: usize,
    /// The part to which an error is reduced.
    pub tolerance: f64,
    /// The bases.
    pub bases: Vec<BasisRate>,
}

/// A validation error: the name of a part, which is the same in both encodings, and the reason.
#[derive(Debug)]
pub(super) struct WrongPart(pub &'static str, pub String);

/// Compares on the compute pool, as eigenvalues take long. `wrong` makes the problem of an error of
/// a part.
pub(super) async fn rates(
    app: &App,
    request: RatesRequest,
    wrong: fn(WrongPart) -> Problem,
) -> Result<Rates, Problem> {
    create_job::read(app, usize::MAX, move || request.answer().map_err(wrong)).await
}

impl RatesRequest {
    fn answer(self) -> Result<Rates, WrongPart> {
        let points = self.count()?;
        let degree = self.degree.unwrap_or(USUAL_DEGREE);
        if !(1..=MOST_DEGREE).contains(&degree) {
            let detail = format!("{degree} is not between 1 and {MOST_DEGREE}");
            return Err(WrongPart("degree", detail));
        }
        let tolerance = self.tolerance.unwrap_or(USUAL_TOLERANCE);
        if !(tolerance > 0.0 && tolerance < 1.0) {
            let detail = format!(
                "{tolerance} is not between 0 and 1: it is the part of an error that is left"
            );
            return Err(WrongPart("tolerance", detail));
        }
        let bases = compare(points, self.parameters.as_deref(), degree);
        Ok(Rates {
            points,
            tolerance,
            bases: bases.map_err(|error| WrongPart(part(&error), error.to_string()))?,
        })
    }

    /// The number of points, which is that of explicit parameters.
    fn count(&self) -> Result<usize, WrongPart> {
        let given = self.parameters.as_ref().map(Vec::len);
        let (part, count) = match (self.points, given) {
            (None, None) => ("points", USUAL_POINTS),
            (Some(points), Some(given)) if points != given => {
                let detail = one_for_each(given, "parameters", points);
                return Err(WrongPart("parameters", detail));
            }
            (_, Some(given)) => ("parameters", given),
            (Some(points), None) => ("points", points),
        };
        if (2..=MOST_POINTS).contains(&count) {
            Ok(count)
        } else {
            let detail = format!("{count} points are not between 2 and {MOST_POINTS}");
            Err(WrongPart(part, detail))
        }
    }
}

/// The part of the request that a numerical error is about.
fn part(error: &Invalid) -> &'static str {
    match error.place {
        Place::Degree(_) => "degree",
        Place::Parameters(_) | Place::Parameter(..) => "parameters",
        _ => "points",
    }
}
