//! Packs the rows of a matrix into one of the least width, with long stretches.
//!
//! B-splines of degree p have p + 1 functions at a parameter, but with knots at the data one of
//! them vanishes at each, sometimes the first and sometimes the last. Packing leaves out places at
//! either end that are zero throughout a stretch, so that a cubic takes three numbers in each row
//! rather than four. Where rows begin differently at every other parameter, as between averaged
//! knots, it joins them again by zeros, as a few long stretches are multiplied many times faster
//! than many short ones.
//!
//! It is done in place: entries move from lane to lane, and no row is copied elsewhere. O(n p) in
//! all.

use std::ops::Range;

use super::banded::{Banded, Stretch};
use crate::data::aligned::Lane;
use crate::data::monotonic;

/// If stretches have fewer rows than this on average, they are joined by zeros.
const JOINED_ROWS: usize = 64;

/// This many stretches are few, whatever their length: rows at the ends of a curve have stretches
/// of their own.
const FEW: usize = 16;

/// Consecutive rows with nonzero entries at the same offsets.
#[derive(Clone, Copy)]
struct Run {
    /// The first row.
    start: u32,
    /// The column of the first entry minus the row.
    offset: i32,
    /// The lane in which the first entries stand.
    low: u32,
    /// The number of entries of a row.
    length: u32,
}

impl Banded {
    /// Packs rows with `columns` columns. Entry k of all rows is in `lanes[k]`, and the entries of
    /// each stretch start at its offset from the diagonal, reduced by the period or not. Zeros at
    /// either end of a stretch are left out, unless a few of them make the stretches long.
    pub fn pack(mut lanes: Vec<Lane>, given: &[Stretch], columns: usize) -> Self {
        let rows = lanes.first().map_or(0, |lane| lane.len());
        let runs = || parts(given, rows).map(|(stretch, rows)| Run::new(stretch, rows, &lanes));
        let cyclic = runs().zip(parts(given, rows)).any(|(run, (_, rows))| {
            let first = run.reduced(columns, false).offset + run.start as i32;
            first as usize + rows.len() - 1 + run.length as usize > columns
        });
        let runs: Vec<Run> = runs().map(|run| run.reduced(columns, cyclic)).collect();
        let width = runs.iter().map(|run| run.length).max().unwrap_or(1) as usize;
        let room = |width| (!cyclic).then(|| columns - width);
        let mut width = width;
        let mut stretches = stretches(&runs, rows, |run| run.offset, room(width));
        let lowest = runs.iter().map(|run| run.offset).min().unwrap_or(0);
        let ends = runs.iter().map(|run| run.offset + run.length as i32);
        let uniform = (ends.max().unwrap_or(1) - lowest) as usize;
        if stretches.len() > FEW + rows / JOINED_ROWS && uniform <= (width + 1).min(columns) {
            width = uniform;
            stretches = self::stretches(&runs, rows, |_| lowest, room(uniform));
        }
        while lanes.len() < width {
            lanes.push(Lane::zeros(rows));
        }
        arrange(&mut lanes, &runs, &stretches);
        lanes.truncate(width);
        Self::new(lanes, columns, stretches, cyclic)
    }
}

/// Each stretch with its rows.
fn parts(stretches: &[Stretch], rows: usize) -> impl Iterator<Item = (Stretch, Range<usize>)> + '_ {
    let ends = stretches.iter().skip(1).map(|next| next.start as usize);
    let ends = ends.chain([rows]);
    stretches
        .iter()
        .zip(ends)
        .map(|(stretch, end)| (*stretch, stretch.start as usize..end))
}

impl Run {
    /// The entries of a stretch between the zeros at both of its ends.
    fn new(stretch: Stretch, rows: Range<usize>, lanes: &[Lane]) -> Self {
        let filled = |lane: &Lane| !monotonic::is_zero(&lane[rows.clone()]);
        let low = lanes.iter().position(filled).unwrap_or(0);
        let high = lanes.iter().rposition(filled).unwrap_or(0);
        Self {
            start: stretch.start,
            offset: stretch.offset + low as i32,
            low: low as u32,
            length: (high + 1 - low) as u32,
        }
    }

    /// The same with an offset that leads to a column of the matrix, or, of cyclic matrices, the
    /// shorter way around.
    fn reduced(self, columns: usize, cyclic: bool) -> Self {
        let (columns, start) = (columns as i32, self.start as i32);
        let offset = if cyclic {
            let half = columns / 2;
            (self.offset + half).rem_euclid(columns) - half
        } else {
            (self.offset + start).rem_euclid(columns) - start
        };
        Self { offset, ..self }
    }
}

/// Joins runs of equal offsets to stretches. With `room`, rows start at that column at the latest
/// and at the first one at the earliest, so that all of their places are columns of the matrix.
fn stretches(
    runs: &[Run],
    rows: usize,
    offset: impl Fn(&Run) -> i32,
    room: Option<usize>,
) -> Vec<Stretch> {
    let mut stretches: Vec<Stretch> = Vec::new();
    let mut push = |start: i32, offset: i32| {
        if stretches.last().is_none_or(|last| last.offset != offset) {
            let start = start as u32;
            stretches.push(Stretch { start, offset });
        }
    };
    let ends = runs.iter().skip(1).map(|next| next.start as i32);
    for (run, end) in runs.iter().zip(ends.chain([rows as i32])) {
        let (start, offset) = (run.start as i32, offset(run));
        let Some(room) = room.map(|room| room as i32) else {
            push(start, offset);
            continue;
        };
        // Rows that would start before the first column, or too late.
        let early = (-offset).clamp(start, end);
        let late = (room - offset + 1).clamp(early, end);
        (start..early).for_each(|i| push(i, -i));
        if early < late {
            push(early, offset);
        }
        (late..end).for_each(|i| push(i, room - i));
    }
    stretches
}

/// Moves the entries of all rows from the lanes of their runs to those of their stretches.
fn arrange(lanes: &mut [Lane], runs: &[Run], stretches: &[Stretch]) {
    let rows = lanes.first().map_or(0, |lane| lane.len());
    let mut runs = runs.iter().peekable();
    let mut run = None;
    for (stretch, range) in parts(stretches, rows) {
        let mut start = range.start;
        while start < range.end {
            run = runs.next_if(|next| next.start as usize <= start).or(run);
            let Some(run) = run else { return };
            let next = runs.peek().map_or(rows, |next| next.start as usize);
            let end = range.end.min(next);
            let lead = (run.offset - stretch.offset) as usize;
            shift(lanes, start..end, run, lead);
            start = end;
        }
    }
}

/// Moves the entries of some rows to the lanes from `lead` on, and leaves zeros behind.
fn shift(lanes: &mut [Lane], rows: Range<usize>, run: &Run, lead: usize) {
    let (low, length) = (run.low as usize, run.length as usize);
    let mut copy = |k: usize| {
        let (from, to) = (low + k, lead + k);
        let (before, behind) = lanes.split_at_mut(from.max(to));
        if from > to {
            before[to][rows.clone()].copy_from_slice(&behind[0][rows.clone()]);
            behind[0][rows.clone()].fill(0.0);
        } else {
            behind[0][rows.clone()].copy_from_slice(&before[from][rows.clone()]);
            before[from][rows.clone()].fill(0.0);
        }
    };
    if lead < low {
        (0..length).for_each(&mut copy);
    } else if lead > low {
        (0..length).rev().for_each(copy);
    }
}
