//! The lines of the answer to a batch: one for each item, then the totals, or why it ended early.

use bytes::Bytes;
use schemars::{JsonSchema, json_schema};
use serde::Serialize;

use super::document::Document;
use super::error::ErrorView;
use super::examples;
use super::level::{Shown, digits};
use super::result::FitGeometry;
use super::to_bytes;
use super::writer::Digits;
use crate::api::json::plain::never_null;
use crate::api::problem::ProblemBody;
use crate::job::content::Content;
use crate::job::frame::Frame;
use crate::job::state::{State, Status};
use crate::model::schema::schema_of;
use crate::model::stream::form::{Form, View};

/// An item of a batch that has ended.
#[derive(Serialize, JsonSchema)]
#[schemars(transform = never_null)]
#[schemars(example = examples::batch_item())]
struct BatchItem<'a> {
    /// Its place among the items, from 0.
    index: usize,
    /// The client's name for it.
    #[serde(skip_serializing_if = "Option::is_none")]
    name: Option<&'a str>,
    /// The final state; `failed` also if the item is no fit that can be computed.
    #[schemars(with = "State")]
    state: &'static str,
    /// Notices about the file that has its points, in sentences. Absent if there are none.
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    notices: &'a [String],
    /// The number of the last iteration. Absent if there was none.
    #[serde(skip_serializing_if = "Option::is_none")]
    iteration: Option<usize>,
    /// The distances from the data at that iteration.
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<ErrorView>,
    /// The fitted curve, also of a fit that has not converged: that of the last iteration.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "FitGeometry<'a>")]
    curve: Option<ItemGeometry<'a>>,
    /// The fitted surface, also of a fit that has not converged.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "FitGeometry<'a>")]
    surface: Option<ItemGeometry<'a>>,
    /// Why the fit has not converged.
    #[serde(skip_serializing_if = "Option::is_none")]
    problem: Option<ProblemBody>,
}

/// The geometry of an item, in the view that the request has chosen.
#[derive(Serialize)]
#[serde(untagged)]
enum ItemGeometry<'a> {
    Complete(FitGeometry<'a>),
    View(Shown),
}

/// The result of an item.
pub(crate) struct ItemEnd<'a> {
    /// Its place among the items.
    pub index: usize,
    /// The client's name for it.
    pub name: Option<&'a str>,
    /// Notices about its points.
    pub notices: &'a [String],
    /// The final status of its fit.
    pub status: &'a Status,
    /// The last level.
    pub frame: Option<&'a Frame>,
    /// Why it has not converged.
    pub problem: Option<ProblemBody>,
}

/// The line of a fit that has ended, in this form.
pub(crate) fn fitted(item: ItemEnd<'_>, form: &Form) -> Content {
    let digits = item
        .frame
        .map_or(Digits::Decimal(None), |frame| digits(form, &frame.level));
    let mut document = Document::new(digits);
    let shown = item.frame.and_then(|frame| match form.view {
        View::ControlPoints => {
            let geometry = FitGeometry::new(&mut document, frame);
            Some(ItemGeometry::Complete(geometry))
        }
        View::Errors => None,
        view => Some(ItemGeometry::View(Shown::new(&mut document, frame, view))),
    });
    let is_surface = item.frame.is_some_and(|frame| frame.problem.v().is_some());
    let (curve, surface) = match is_surface {
        false => (shown, None),
        true => (None, shown),
    };
    let level = item.status.levels.map(|levels| levels.last);
    let error = item
        .frame
        .map(|frame| (&frame.level.error, &*frame.problem));
    document.finish(&BatchItem {
        index: item.index,
        name: item.name,
        state: item.status.state.name(),
        notices: item.notices,
        iteration: level.map(|level| level.iteration),
        error: error.map(|(error, problem)| ErrorView::new(error, problem)),
        curve,
        surface,
        problem: item.problem,
    })
}

/// The line of an item that is invalid.
pub(crate) fn failed(
    index: usize,
    name: Option<&str>,
    notices: &[String],
    problem: ProblemBody,
) -> Bytes {
    to_bytes(&BatchItem {
        index,
        name,
        state: State::Failed.name(),
        notices,
        iteration: None,
        error: None,
        curve: None,
        surface: None,
        problem: Some(problem),
    })
}

/// The last line of a batch that was read to its end.
#[derive(Serialize, JsonSchema)]
#[schemars(extend("examples" = [{"totals": {"items": 3, "converged": 2, "failed": 1, "seconds": 0.0031}}]))]
pub(crate) struct BatchEnd {
    /// The results of the items.
    pub totals: BatchTotals,
}

/// The numbers of items of a batch.
#[derive(Clone, Copy, Default, Serialize, JsonSchema)]
#[schemars(extend("examples" = [{"items": 3, "converged": 2, "failed": 1, "seconds": 0.0031}]))]
pub(crate) struct BatchTotals {
    /// The number of items.
    pub items: usize,
    /// The number of items that have converged.
    pub converged: usize,
    /// The number of items that have not converged: those with a problem.
    pub failed: usize,
    /// Seconds from the beginning of the request to its end.
    pub seconds: f64,
}

/// The last line of a batch that has ended before its end: no totals follow.
#[derive(Serialize, JsonSchema)]
#[schemars(extend("examples" = [{"problem": examples::problem()}]))]
pub(crate) struct BatchProblem {
    /// Why there is no more.
    pub problem: ProblemBody,
}

/// A line of a batch.
pub(crate) enum BatchLine {}

schema_of!(BatchLine, "BatchLine", generator => {
    let lines = [
        generator.subschema_for::<BatchItem<'_>>(),
        generator.subschema_for::<BatchEnd>(),
        generator.subschema_for::<BatchProblem>(),
    ];
    json_schema!({
        "description": "A line of a batch: the items in their order, then the totals; or the problem that has ended the batch early.",
        "anyOf": lines,
        "examples": [examples::batch_item()],
    })
});

/// A line as a server-sent event.
pub(crate) enum BatchEvent {}

schema_of!(BatchEvent, "BatchEvent", generator => json_schema!({
    "description": "The fields of a server-sent event: `item` with its index as its id, in order, then `totals`; or `problem`. Comments keep quiet streams open.",
    "type": "object",
    "properties": {
        "event": {"description": "What has ended.", "type": "string", "enum": ["item", "totals", "problem"]},
        "id": {"description": "The index of the item.", "type": "string", "pattern": "^[0-9]+$"},
        "data": {
            "description": "The line, as JSON: a BatchItem, a BatchEnd or a BatchProblem.",
            "type": "string",
            "contentMediaType": "application/json",
            "contentSchema": generator.subschema_for::<BatchLine>(),
        },
    },
    "required": ["event", "data"],
    "examples": [{"event": "totals", "data": "{\"totals\":{\"items\":3,\"converged\":2,\"failed\":1,\"seconds\":0.0031}}"}],
}));
