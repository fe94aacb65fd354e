//! An edit that a message asks for.

use std::collections::HashMap;

use super::fields::MessageLayout;
use crate::api::problem::Problem;
use crate::job::outline::Outline;
use crate::model::edit::{Coordinates, EditSpec, PointChange};
use crate::model::mistakes::Mistake;
use crate::model::weights::WeightSpec;
use crate::proto::job::{rational, stop, surface_weights};
use crate::proto::messages as pb;
use crate::proto::method;
use crate::proto::stream;
use crate::proto::values::{MethodTarget, check_count};

/// The edit of a job with this outline, and where its parts are in the message.
pub fn edit(edit: pb::Edit, parent: &Outline) -> Result<(EditSpec, MessageLayout), Problem> {
    let mut layout = MessageLayout::of_edit(edit.method.as_ref());
    match spec(edit, parent, &mut layout) {
        Ok(spec) => Ok((spec, layout)),
        Err(mistake) => Err(Problem::of_mistakes(mistake.into(), &layout)),
    }
}

fn spec(edit: pb::Edit, parent: &Outline, layout: &mut MessageLayout) -> Result<EditSpec, Mistake> {
    let points = parent.grid.count();
    check_count(edit.moved.len(), points, "moved points", "moved")?;
    check_count(edit.weighted.len(), points, "weighted points", "weighted")?;
    layout.dimension = dimension(&edit)?;
    let changes = changes(&edit, layout)?;
    let scope = MethodTarget {
        points,
        surface: parent.surface,
        most: points,
    };
    let stream = edit.stream.map(|it| stream::spec(it, "stream."));
    Ok(EditSpec {
        name: edit.name,
        // Too large for this machine is beyond every job.
        iteration: edit
            .iteration
            .map(|k| usize::try_from(k).unwrap_or(usize::MAX)),
        ephemeral: edit.ephemeral,
        session: edit.session,
        points: changes,
        weights: weights(edit.weights, parent).map_err(Into::into),
        rational: rational(edit.rational).map_err(Into::into),
        method: method::spec(edit.method, scope),
        stop: stop(edit.stop),
        stream: stream.transpose().map_err(Into::into),
    })
}

/// The number of coordinates that moved points have.
fn dimension(edit: &pb::Edit) -> Result<usize, Mistake> {
    let (count, moved) = (edit.points.len(), edit.moved.len());
    if moved == 0 && count == 0 {
        return Ok(1);
    }
    match count.checked_div(moved) {
        Some(dimension) if dimension > 0 && dimension * moved == count => Ok(dimension),
        _ => {
            let detail = format!("{count} coordinates for {moved} moved points");
            Err(Mistake::at_text("points", detail))
        }
    }
}

/// All points that change: those that are moved, and those that get another weight.
fn changes(edit: &pb::Edit, layout: &mut MessageLayout) -> Result<Vec<PointChange>, Mistake> {
    if edit.weighted.len() != edit.point_weights.len() {
        let (given, needed) = (edit.point_weights.len(), edit.weighted.len());
        let detail = format!("{given} weights for {needed} points");
        return Err(Mistake::at_text("point_weights", detail));
    }
    let places = edit.points.chunks_exact(layout.dimension);
    let mut changes: Vec<PointChange> = Vec::with_capacity(edit.moved.len() + edit.weighted.len());
    let mut entries = HashMap::with_capacity(edit.moved.len());
    for (k, (&index, place)) in edit.moved.iter().zip(places).enumerate() {
        entries.insert(index, k);
        layout.changes.push((Some(k), None));
        changes.push(PointChange {
            index: Ok(index as usize),
            point: Coordinates::of(place),
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
        changes.push(PointChange {
            index: Ok(*index as usize),
            point: None,
            weight: Some(weight),
        });
    }
    Ok(changes)
}

fn weights(weights: Option<pb::Weights>, parent: &Outline) -> Result<Option<WeightSpec>, Mistake> {
    let Some(weights) = weights else {
        return Ok(None);
    };
    if parent.surface {
        return surface_weights(weights, parent.grid, "weights.values");
    }
    if !weights.u.is_empty() || !weights.v.is_empty() {
        let detail = "the weights of a curve are a list of numbers";
        return Err(Mistake::at_text("weights", detail));
    }
    Ok(Some(WeightSpec::List(weights.values)))
}
