//! The JSON of an edit.

use bytes::Bytes;

use super::places::Places;
use crate::api::json::read::parse;
use crate::api::problem::Problem;
use crate::job::outline::Outline;
use crate::model::edit::EditRequest;

/// The edit of a job, and the locations of its parts.
pub(crate) fn read(body: Bytes, parent: &Outline) -> Result<(EditRequest, Places), Problem> {
    let request: EditRequest = parse(&body, parent.grid.count())?;
    let places = Places::of_edit(&request, parent.surface.then_some(parent.grid));
    Ok((request, places))
}
