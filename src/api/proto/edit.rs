//! Requested edits in messages.

use std::collections::HashMap;

use super::fields::MessageLayout;
use crate::api::problem::Problem;
use crate::job::outline::Outline;
use crate::model::edit::{EditRequest, Move};
use crate::model::errors::{OrErrors, ValidationError, ValidationErrors};
use crate::model::iteration::IterationChoice;
use crate::model::lists::PointNumbers;
use crate::model::per_direction::PerDirection;
use crate::proto::job::{rational, stop, surface_weights};
use crate::proto::messages as pb;
use crate::proto::method;
use crate::proto::stream;
use crate::proto::values::{MethodTarget, check_count};
use piad_files::json::Coordinates;
use piad_fit::invalid::one_for_each;

/// The edit of a job with this outline, and the locations of its parts in the message.
pub(crate) fn edit(
    edit: pb::Edit,
    parent: &Outline,
) -> Result<(EditRequest, MessageLayout), Problem> {
    let mut layout = MessageLayout::of_edit(edit.method.as_ref());
    match request(edit, parent, &mut layout) {
        Ok(request) => Ok((request, layout)),
        Err(errors) => Err(Problem::of_errors(errors, &layout)),
    }
}

fn request(edit: pb::Edit, parent: &Outline, layout: &mut MessageLayout) -> OrErrors<EditRequest> {
    let points = parent.grid.count();
    check_count(edit.moved.len(), points, "moved points", "moved")?;
    check_count(edit.weighted.len(), points, "weighted points", "weighted")?;
    layout.dimension = dimension(&edit)?;
    let target = MethodTarget {
        grid: parent.grid,
        surface: parent.surface,
        most: points,
    };
    let changes = changes(&edit, target, layout)?;
    let mut errors = ValidationErrors::default();
    let stream = edit.stream.map(|it| stream::spec(it, "stream."));
    let request = EditRequest {
        name: edit.name,
        iteration: edit.iteration.map(IterationChoice::of),
        ephemeral: Some(edit.ephemeral),
        session: edit.session,
        points: Some(changes),
        weights: errors.keep(weights(edit.weights, parent)).flatten(),
        rational: errors.keep(rational(edit.rational)).flatten(),
        method: errors.keep(method::input(edit.method, target)).flatten(),
        stop: edit.stop.map(stop),
        stream: errors.keep(stream.transpose()).flatten(),
    };
    errors.or(request)
}

/// The number of coordinates that moved points have.
fn dimension(edit: &pb::Edit) -> Result<usize, ValidationError> {
    let (count, moved) = (edit.points.len(), edit.moved.len());
    if moved == 0 && count == 0 {
        return Ok(1);
    }
    match count.checked_div(moved) {
        Some(dimension) if dimension > 0 && dimension * moved == count => Ok(dimension),
        _ => {
            let detail = format!("{count} coordinates for {moved} moved points");
            Err(ValidationError::at_text("points", detail))
        }
    }
}

/// All points that change: those that are moved, and those that get another weight.
fn changes(
    edit: &pb::Edit,
    target: MethodTarget,
    layout: &mut MessageLayout,
) -> Result<Vec<Move>, ValidationError> {
    if edit.weighted.len() != edit.point_weights.len() {
        let (given, needed) = (edit.point_weights.len(), edit.weighted.len());
        let detail = one_for_each(given, "weights", needed);
        return Err(ValidationError::at_text("point_weights", detail));
    }
    let places = edit.points.chunks_exact(layout.dimension);
    let mut changes: Vec<Move> = Vec::with_capacity(edit.moved.len() + edit.weighted.len());
    let mut entries = HashMap::with_capacity(edit.moved.len());
    for (k, (&index, place)) in edit.moved.iter().zip(places).enumerate() {
        entries.insert(index, k);
        layout.changes.push((Some(k), None));
        changes.push(Move {
            index: target.index(index),
            point: Some(Coordinates::from(place)),
            weight: None,
        });
    }
    for (k, (index, &weight)) in edit.weighted.iter().zip(&edit.point_weights).enumerate() {
        // A second weight of the same point is an entry of its own, and refused as such.
        if let Some(entry) = entries.remove(index) {
            changes[entry].weight = Some(weight);
            layout.changes[entry].1 = Some(k);
            continue;
        }
        layout.changes.push((None, Some(k)));
        changes.push(Move {
            index: target.index(*index),
            point: None,
            weight: Some(weight),
        });
    }
    Ok(changes)
}

fn weights(
    weights: Option<pb::Weights>,
    parent: &Outline,
) -> Result<Option<PerDirection<PointNumbers>>, ValidationError> {
    let Some(weights) = weights else {
        return Ok(None);
    };
    if parent.surface {
        return surface_weights(weights, parent.grid, "weights.values");
    }
    if !weights.u.is_empty() || !weights.v.is_empty() {
        let detail = "the weights of a curve are a list of numbers";
        return Err(ValidationError::at_text("weights", detail));
    }
    Ok(Some(PerDirection::Both(PointNumbers::Line(weights.values))))
}
