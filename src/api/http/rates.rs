//! Comparisons of bases.

use axum::Json;
use axum::extract::State;
use axum::http::Uri;
use serde::Deserialize;

use super::negotiate;
use crate::api::app::App;
use crate::api::json::view::rates::RatesView;
use crate::api::parse_uint::plain_number;
use crate::api::problem::Problem;
use crate::api::rates::{RatesRequest, WrongPart, rates};
use piad_files::text::quoted;
use piad_fit::engine::rates::MOST_POINTS;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Query {
    points: Option<String>,
    parameters: Option<String>,
    degree: Option<String>,
    tolerance: Option<String>,
}

/// `GET /v1/rates`
pub(super) async fn get(State(app): State<App>, uri: Uri) -> Result<Json<RatesView>, Problem> {
    let query: Query = negotiate::query(&uri)?;
    let request = RatesRequest {
        points: query
            .points
            .map(|text| whole("points", &text))
            .transpose()?,
        parameters: parameters(query.parameters.as_deref())?,
        degree: query
            .degree
            .map(|text| whole("degree", &text))
            .transpose()?,
        tolerance: query
            .tolerance
            .map(|text| number("tolerance", &text))
            .transpose()?,
    };
    let wrong = |WrongPart(name, detail)| Problem::at_parameter(name, detail);
    Ok(Json(RatesView::new(&rates(&app, request, wrong).await?)))
}

/// `uniform`, or numbers separated by commas.
fn parameters(text: Option<&str>) -> Result<Option<Vec<f64>>, Problem> {
    let Some(text) = text.filter(|text| *text != "uniform") else {
        return Ok(None);
    };
    if text.split(',').nth(MOST_POINTS).is_some() {
        let detail = format!("there are more than {MOST_POINTS}");
        return Err(Problem::at_parameter("parameters", detail));
    }
    let numbers = text.split(',').map(|text| number("parameters", text));
    numbers.collect::<Result<_, _>>().map(Some)
}

fn whole(name: &str, text: &str) -> Result<usize, Problem> {
    let wrong = || Problem::at_parameter(name, format!("{} is not a whole number", quoted(text)));
    plain_number(text).ok_or_else(wrong)
}

fn number(name: &str, text: &str) -> Result<f64, Problem> {
    let value = text.parse().ok().filter(|value: &f64| value.is_finite());
    let wrong = || Problem::at_parameter(name, format!("{} is no number", quoted(text)));
    value.ok_or_else(wrong)
}
