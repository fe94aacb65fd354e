//! Points of a surface come in rows: blank lines separate them, or x and y say it, or somebody does.

use super::closed_outline;
use super::error::FileError;
use super::imported::{Hints, Imported, Kind};
use super::repeated;
use super::table::Table;
use piad_fit::data::{Grid, Points};
use piad_fit::engine::is_unordered;

/// What is said of points that seem to have no order along a curve.
const NO_ORDER: &str = "the points have no order along a curve: few of them have a neighbour of the list among their nearest points; fit a surface to scattered points (--surface, or surface.parameters=project in a query), or put them in order (--order nearest, or curve.order=nearest), or say that theirs is meant (--order given, or curve.order=given)";

/// What is said of them where they are those of a surface.
const SCATTERED: &str = "The points have no order, and are scattered points of a surface.";

/// The points as a curve or a surface.
pub(super) fn arranged(mut table: Table, hints: &Hints) -> Result<Imported, FileError> {
    let grid = match hints {
        Hints {
            size: Some(size), ..
        } => Some(asked_for(&table, *size)?),
        Hints {
            kind: Some(Kind::Curve),
            ..
        } => None,
        _ => shown(&mut table),
    };
    let unordered = grid.is_none() && !hints.ordered;
    let unordered = unordered && (table.is_mesh || is_unordered(&table.points));
    if unordered && hints.kind != Some(Kind::Surface) {
        return Err(FileError::of_file(NO_ORDER));
    }
    if unordered {
        table.notices.push(SCATTERED.to_owned());
    }
    if grid.is_none() && hints.kind != Some(Kind::Surface) {
        repeated::leave_out(&mut table);
    }
    let closed = grid.is_none() && closed_outline::closed(&mut table, hints);
    Ok(Imported {
        points: table.points,
        grid,
        missing: Vec::new(),
        closed,
        unordered,
        lines: table.lines,
        name: table.name,
        notices: table.notices,
    })
}

fn asked_for(table: &Table, size: Grid) -> Result<Grid, FileError> {
    let count = table.points.len();
    if size.rows.checked_mul(size.columns) == Some(count) {
        return Ok(size);
    }
    let (rows, columns) = (size.rows, size.columns);
    let detail = format!("the file has {count} points, which are not {rows} rows of {columns}");
    Err(FileError::of_file(detail))
}

/// The grid that a file shows, if it is one.
fn shown(table: &mut Table) -> Option<Grid> {
    if table.points.dimension() != 3 {
        return None;
    }
    let blanks = blank_lines(table);
    let (grid, why) = match blanks {
        Some(grid) => (grid, "blank lines are between the rows"),
        None => (lattice(&table.points)?, "x and y form a lattice"),
    };
    table.notices.push(format!(
        "The points are {} rows of {}: {why}.",
        grid.rows, grid.columns
    ));
    Some(grid)
}

/// Rows of the same length with blank lines between them.
fn blank_lines(table: &mut Table) -> Option<Grid> {
    let columns = *table.breaks.first()?;
    let rows = table.breaks.len() + 1;
    let starts = (1..rows).map(|row| row * columns);
    let regular = starts.eq(table.breaks.iter().copied());
    if columns >= 2 && regular && rows * columns == table.points.len() {
        return Some(Grid { rows, columns });
    }
    let notice = "The parts between blank lines differ in length, so that they are no rows of a surface; the blank lines are passed over.";
    table.notices.push(notice.to_owned());
    None
}

/// Rows in which x is the same and y is as in the first one, or the other way around.
fn lattice(points: &Points) -> Option<Grid> {
    let (x, y) = (points.lane(0), points.lane(1));
    rows_of(x, y).or_else(|| rows_of(y, x))
}

fn rows_of(fixed: &[f64], running: &[f64]) -> Option<Grid> {
    let first = *fixed.first()?;
    let columns = fixed.iter().take_while(|value| **value == first).count();
    let rows = fixed.len() / columns.max(1);
    if columns < 2 || rows < 2 || fixed.len() != rows * columns {
        return None;
    }
    let start = running.get(..columns)?;
    let each = fixed.chunks(columns).zip(running.chunks(columns));
    let regular = each.clone().all(|(fixed, running)| {
        let same = fixed.first();
        fixed.iter().all(|value| Some(value) == same) && running == start
    });
    let across: Vec<f64> = each
        .filter_map(|(fixed, _)| fixed.first().copied())
        .collect();
    (regular && is_monotone(start) && is_monotone(&across)).then_some(Grid { rows, columns })
}

fn is_monotone(values: &[f64]) -> bool {
    let mut steps = values.windows(2).map(|pair| match pair {
        [before, after] => after - before,
        _ => 0.0,
    });
    steps.clone().all(|step| step > 0.0) || steps.all(|step| step < 0.0)
}
