//! Detects rows of points of a surface: by blank lines, by x and y, or by the hints.

use super::closed_outline;
use super::error::FileError;
use super::imported::{Hints, Imported, Kind};
use super::line_parameters;
use super::mesh;
use super::part::{Order, Part};
use super::repeated;
use super::times;
use piad_fit::data::{Grid, Points};
use piad_fit::engine::is_unordered;

/// The notice about points that seem to have no order along a curve.
const NO_ORDER: &str = "the points have no order along a curve: few of them have a neighbour of the list among their nearest points; fit a surface to scattered points (--surface, or surface.parameters=auto in a query), or put them in order (--order nearest, or curve.order=nearest), or confirm that theirs is intended (--order given, or curve.order=given)";

/// The notice about them if they are those of a surface.
const SCATTERED: &str = "The points have no order, and are scattered points of a surface.";

/// The points as a curve or a surface.
///
/// # Errors
///
/// If they are neither: no order, another number of rows than requested, times that do not increase.
pub(super) fn arranged(mut part: Part, hints: &Hints) -> Result<Imported, FileError> {
    let are_sections = part.order == Order::Sections;
    let is_mesh = !part.triangles.is_empty();
    let surface = hints.kind == Some(Kind::Surface)
        || are_sections
        || is_mesh && hints.kind.is_none() && !hints.ordered;
    let grid = match is_mesh && surface && hints.size.is_none() {
        true => None,
        false => grid(&mut part, hints)?,
    };
    let looked_at = match part.order {
        Order::Unsaid => grid.is_none() && !hints.ordered && is_unordered(&part.points),
        Order::Curve | Order::Rows(_) | Order::Sections => false,
        Order::None => !hints.ordered,
    };
    let unordered = looked_at || (part.order == Order::None && surface);
    if unordered && !surface {
        return Err(FileError::of_file(NO_ORDER));
    }
    if grid.is_none() && surface && (is_mesh || hints.piece.is_some()) {
        mesh::take_piece(&mut part, hints)?;
    } else {
        part.triangles.clear();
    }
    if unordered && part.triangles.is_empty() {
        part.notices.push(SCATTERED.to_owned());
    }
    let curve = grid.is_none() && !surface;
    if curve {
        repeated::leave_out(&mut part);
    }
    let closed = grid.is_none() && !are_sections && closed_outline::closed(&mut part, hints);
    let parameters = match curve {
        true => times::parameters(&mut part, hints)?,
        false => None,
    };
    let sections = match are_sections {
        true => part.counts(),
        false => Vec::new(),
    };
    let has_gaps = !part.missing.is_empty();
    let grid_with_gaps = grid.filter(|_| has_gaps);
    Ok(Imported {
        sections,
        line_parameters: grid_with_gaps
            .and_then(|grid| line_parameters::of_lattice(&part.points, &part.missing, grid)),
        points: part.points,
        grid,
        missing: part.missing,
        closed,
        unordered,
        parameters,
        triangles: part.triangles,
        origin: part.origin,
        lines: part.lines,
        name: part.name,
        notices: part.notices,
    })
}

/// The rows and columns of a part, if it is a grid.
fn grid(part: &mut Part, hints: &Hints) -> Result<Option<Grid>, FileError> {
    if let Order::Rows(grid) = part.order {
        check_rows(grid, hints)?;
        return Ok(Some(grid));
    }
    if part.order == Order::Sections {
        return Ok(None);
    }
    Ok(match (hints.size, hints.kind) {
        (Some(size), _) => Some(requested(part, size)?),
        (None, Some(Kind::Curve)) => None,
        _ if part.order == Order::Curve => None,
        _ => shown(part),
    })
}

/// Refuses rows that are not curves, or whose number differs from the requested one.
fn check_rows(grid: Grid, hints: &Hints) -> Result<(), FileError> {
    if hints.kind == Some(Kind::Curve) {
        let detail = "these are rows of a surface, and the fit is one of a curve";
        return Err(FileError::of_file(detail));
    }
    let Grid { rows, columns } = grid;
    match hints.size.filter(|size| *size != grid) {
        None => Ok(()),
        Some(size) => Err(FileError::of_file(format!(
            "the file has {rows} rows of {columns}, and not {} rows of {}",
            size.rows, size.columns
        ))),
    }
}

/// Returns true if blank lines separate curves of a table, and not the rows of a surface.
pub(super) fn is_several(table: &Part, hints: &Hints) -> bool {
    let surface = hints.kind == Some(Kind::Surface) || hints.size.is_some();
    let rows = hints.kind.is_none() && table.points.dimension() == 3 && rows(table).is_some();
    // A blank line after each point does not separate rows.
    let spaced = table.breaks.len() + 1 == table.points.len();
    !table.breaks.is_empty() && !surface && !rows && !spaced
}

/// Returns true if blank lines are between rows of different lengths.
pub(super) fn are_uneven_rows(table: &Part, hints: &Hints) -> bool {
    if table.breaks.is_empty() || table.points.dimension() != 3 || hints.size.is_some() {
        return false;
    }
    let is_grid = rows(table).is_some() || lattice(&table.points).is_some();
    !is_grid && table.counts().into_iter().min() >= Some(2)
}

fn requested(part: &Part, size: Grid) -> Result<Grid, FileError> {
    let count = part.points.len();
    if size.rows.checked_mul(size.columns) == Some(count) {
        return Ok(size);
    }
    let (rows, columns) = (size.rows, size.columns);
    let detail = format!("the file has {count} points, which are not {rows} rows of {columns}");
    Err(FileError::of_file(detail))
}

/// The grid that a file shows, if it is one.
pub(super) fn shown(part: &mut Part) -> Option<Grid> {
    if part.points.dimension() != 3 {
        return None;
    }
    let (grid, why) = match rows(part) {
        Some(grid) => (grid, "blank lines are between the rows"),
        None => (lattice(&part.points)?, "x and y form a grid"),
    };
    part.notices.push(format!(
        "The points are {} rows of {}: {why}.",
        grid.rows, grid.columns
    ));
    Some(grid)
}

/// Rows of the same length with blank lines between them.
fn rows(part: &Part) -> Option<Grid> {
    let columns = *part.breaks.first()?;
    let rows = part.breaks.len() + 1;
    let starts = (1..rows).map(|row| row * columns);
    let regular = starts.eq(part.breaks.iter().copied());
    (columns >= 2 && regular && rows * columns == part.points.len())
        .then_some(Grid { rows, columns })
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
