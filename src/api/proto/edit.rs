//! An edit that a message asks for, as its JSON would have been read.

use std::collections::HashMap;

use super::bounds::check_count;
use super::fields::Layout;
use super::messages as pb;
use super::method;
use super::request::{Weights, rational, stop};
use super::stream;
use crate::api::json::numbers::{Coordinates, WeightList};
use crate::api::json::per_direction::PerDirection;
use crate::api::json::read::values::Number;
use crate::api::json::request::edit::{EditRequest, Move};
use crate::api::json::request::iteration::IterationRequest;
use crate::api::json::request::settings::Index;
use crate::api::problem::Problem;
use crate::job::outline::Outline;

/// The edit of a job with this outline, and where its parts are in the message.
pub fn edit(edit: pb::Edit, parent: &Outline) -> Result<(EditRequest, Layout), Problem> {
    let points = parent.grid.count();
    check_count(edit.moved.len(), points, "moved points", "moved")?;
    check_count(edit.weighted.len(), points, "weighted points", "weighted")?;
    let dimension = dimension(&edit)?;
    let columns = parent.surface.then_some(parent.grid.columns);
    let mut layout = Layout::of_edit(dimension, columns, edit.method.as_ref());
    let points = moves(&edit, dimension, &mut layout)?;
    let stream = edit.stream.map(stream::spec).transpose();
    let iteration = edit
        .iteration
        // Too large for this machine is beyond every job.
        .map(|k| IterationRequest(Some(usize::try_from(k).unwrap_or(usize::MAX))));
    let request = EditRequest {
        name: edit.name,
        iteration,
        points: (!points.is_empty()).then_some(points),
        weights: weights(edit.weights, parent)?,
        rational: rational(edit.rational)?,
        method: method::request(edit.method, parent.grid.count())?,
        stop: stop(edit.stop),
        stream: stream.map_err(|problem| problem.within("stream"))?,
    };
    Ok((request, layout))
}

/// The number of coordinates that moved points have.
fn dimension(edit: &pb::Edit) -> Result<usize, Problem> {
    let (count, moved) = (edit.points.len(), edit.moved.len());
    if moved == 0 && count == 0 {
        return Ok(1);
    }
    match count.checked_div(moved) {
        Some(dimension) if dimension > 0 && dimension * moved == count => Ok(dimension),
        _ => {
            let detail = format!("{count} coordinates for {moved} moved points");
            Err(Problem::at_field("points", detail))
        }
    }
}

/// All points that change: those that are moved, and those that get another weight.
fn moves(edit: &pb::Edit, dimension: usize, layout: &mut Layout) -> Result<Vec<Move>, Problem> {
    if edit.weighted.len() != edit.point_weights.len() {
        let (given, needed) = (edit.point_weights.len(), edit.weighted.len());
        let detail = format!("{given} weights for {needed} points");
        return Err(Problem::at_field("point_weights", detail));
    }
    let places = edit.points.chunks_exact(dimension);
    let mut moves: Vec<Move> = Vec::with_capacity(edit.moved.len() + edit.weighted.len());
    let mut entries = HashMap::with_capacity(edit.moved.len());
    for (k, (&index, place)) in edit.moved.iter().zip(places).enumerate() {
        entries.insert(index, k);
        layout.changes.push((Some(k), None));
        moves.push(Move {
            index: Index::Flat(index as usize),
            point: Coordinates::of(place),
            weight: None,
        });
    }
    for (k, (index, &weight)) in edit.weighted.iter().zip(&edit.point_weights).enumerate() {
        // A second weight of the same point is an entry of its own, and refused as such.
        if let Some(entry) = entries.remove(index) {
            moves[entry].weight = Some(Number(weight));
            layout.changes[entry].1 = Some(k);
            continue;
        }
        layout.changes.push((None, Some(k)));
        moves.push(Move {
            index: Index::Flat(*index as usize),
            point: None,
            weight: Some(Number(weight)),
        });
    }
    Ok(moves)
}

fn weights(
    weights: Option<pb::Weights>,
    parent: &Outline,
) -> Result<Option<PerDirection<WeightList>>, Problem> {
    let Some(pb::Weights { values, u, v }) = weights else {
        return Ok(None);
    };
    if parent.surface {
        let (rows, columns) = (parent.grid.rows, parent.grid.columns);
        return Weights { values, u, v }.of_surface(rows, columns, "weights.values");
    }
    if !u.is_empty() || !v.is_empty() {
        let detail = "the weights of a curve are a list of numbers";
        return Err(Problem::at_field("weights", detail));
    }
    Ok(Some(PerDirection::Both(WeightList::Line(values))))
}
