//! The spacing of the points of a surface in space and in their parameters, and the cells that follow.

use super::cells::{Cells, Side, Steps};
use crate::data::grid::Grid;
use crate::interrupt::Meter;
use crate::invalid::{Invalid, Place};

/// The approximate number of points of a filled cell of scattered points, so that few cells between them are empty.
const IN_A_CELL: f64 = 2.3;

/// By how much cells grow until they hold as many.
const GROWTH: f64 = 1.2;

/// The most cells for each point, and for few points.
const CELLS_PER_POINT: usize = 16;
const CELLS: usize = 1 << 12;
const MOST_CELLS: usize = 1 << 24;

/// The most blocks along a direction in which the places of scattered points are averaged, and the points in each.
const BLOCKS: usize = 32;
const IN_A_BLOCK: usize = 8;

/// The data of a surface.
#[derive(Clone, Debug)]
pub(super) struct Data {
    /// u and v of each point, of a grid row by row.
    pub parameters: Vec<[f64; 2]>,
    /// Their places; values of a function have none.
    pub places: Option<Vec<[f64; 3]>>,
    /// True where a point is there.
    pub is_given: Vec<bool>,
    /// The arrangement of the points of a grid.
    pub grid: Option<Grid>,
    pub sides: [Side; 2],
    /// Which ends of v are points.
    pub poles: [bool; 2],
}

impl Data {
    /// The parameters of the points that are there.
    pub(super) fn given(&self) -> impl Iterator<Item = [f64; 2]> {
        let all = self.parameters.iter().zip(&self.is_given);
        all.filter(|(_, is_given)| **is_given)
            .map(|(pair, _)| *pair)
    }

    /// The mean length in space of a unit of u and of v; 1 for plain values.
    fn scales(&self) -> [f64; 2] {
        let Some(places) = &self.places else {
            return [1.0; 2];
        };
        let averaged = match self.grid {
            Some(grid) => Lattice::of_grid(self, grid, places),
            None => Lattice::of_blocks(self, places),
        };
        [0, 1].map(|axis| averaged.scale(axis))
    }
}

/// Places in rows and columns, some of which are missing.
struct Lattice {
    /// The number in each row, and of rows.
    counts: [usize; 2],
    nodes: Vec<Option<([f64; 2], [f64; 3])>>,
}

impl Lattice {
    fn of_grid(data: &Data, grid: Grid, places: &[[f64; 3]]) -> Self {
        let node = |k: usize| data.is_given[k].then(|| (data.parameters[k], places[k]));
        Self {
            counts: [grid.columns, grid.rows],
            nodes: (0..places.len()).map(node).collect(),
        }
    }

    fn of_blocks(data: &Data, places: &[[f64; 3]]) -> Self {
        let blocks = (places.len() / IN_A_BLOCK).isqrt().clamp(1, BLOCKS);
        let mut sums = vec![([0.0; 2], [0.0; 3], 0.0); blocks * blocks];
        let block = |axis: usize, t: f64| {
            let side = data.sides[axis];
            let place = (t - side.low) / side.length() * blocks as f64;
            (place.max(0.0) as usize).min(blocks - 1)
        };
        for (k, pair) in data.parameters.iter().enumerate() {
            if !data.is_given[k] {
                continue;
            }
            let sum = &mut sums[block(0, pair[0]) * blocks + block(1, pair[1])];
            (0..2).for_each(|axis| sum.0[axis] += pair[axis]);
            (0..3).for_each(|c| sum.1[c] += places[k][c]);
            sum.2 += 1.0;
        }
        let mean = |(pair, place, count): ([f64; 2], [f64; 3], f64)| {
            (count > 0.0).then(|| (pair.map(|t| t / count), place.map(|x| x / count)))
        };
        Self {
            counts: [blocks; 2],
            nodes: sums.into_iter().map(mean).collect(),
        }
    }

    /// The mean length of a unit of u, which grows from row to row, or of v.
    fn scale(&self, axis: usize) -> f64 {
        let [columns, rows] = self.counts;
        let (mut in_space, mut between) = (0.0, 0.0);
        for k in 0..self.nodes.len() {
            let (row, column) = (k / columns, k % columns);
            let next = match axis {
                0 => (row + 1 < rows).then_some(k + columns),
                _ => (column + 1 < columns).then_some(k + 1),
            };
            let next = next.and_then(|next| self.nodes[next]);
            if let Some(((a, p), (b, q))) = self.nodes[k].zip(next) {
                let squares = (0..3).map(|c| (q[c] - p[c]) * (q[c] - p[c]));
                in_space += squares.sum::<f64>().sqrt();
                between += (b[axis] - a[axis]).abs();
            }
        }
        let scale = in_space / between;
        match scale.is_finite() && scale > 0.0 {
            true => scale,
            false => 1.0,
        }
    }
}

/// The cells of some data, filled where points lie, closed; and the length of their longer side in space.
pub(super) fn cells(data: &Data, distance: Option<f64>) -> Result<(Cells, f64), Invalid> {
    let scales = data.scales();
    let mut meter = Meter::default();
    let of_data = match data.grid {
        Some(grid) => of_grid(data, grid),
        None => of_scattered(data, scales, &mut meter),
    };
    let spacing = (0..2).map(|axis| of_data[axis].size * scales[axis]);
    let spacing = spacing.fold(0.0, f64::max);
    let Some(distance) = distance else {
        let mut cells = Cells::of(of_data, data.given(), data.poles, &mut meter);
        cells.close(&mut meter);
        return Ok((cells, spacing));
    };
    check(data, distance, spacing)?;
    let steps = [0, 1].map(|axis| Steps::at_most(data.sides[axis], distance / scales[axis]));
    let mut cells = Cells::of(steps, data.given(), data.poles, &mut meter);
    cells.close(&mut meter);
    Ok((cells, distance))
}

/// Refuses a distance that is no length, or less than the spacing of neighbouring points.
fn check(data: &Data, distance: f64, spacing: f64) -> Result<(), Invalid> {
    let wrong = |detail: String| Err(Invalid::at(Place::TrimDistance, detail));
    if !(distance > 0.0 && distance.is_finite()) {
        return wrong(format!(
            "the distance is {distance}, and it is a finite number greater than 0"
        ));
    }
    if data.places.is_none() {
        return wrong("values of a function have no distances in space: leave it out".to_owned());
    }
    // Gaps of two cells are closed; cells of scattered points hold several.
    let least = match data.grid {
        Some(_) => 0.5 * spacing,
        None => spacing / 3.0,
    };
    if distance < least {
        return wrong(format!(
            "the distance {distance} leaves nothing between neighbouring points: it is at least {least:.4}, and without one {spacing:.4}"
        ));
    }
    Ok(())
}

/// Cells around the rows and columns of a grid, as long as the longest step.
fn of_grid(data: &Data, grid: Grid) -> [Steps; 2] {
    let step = |axis: usize| {
        let (count, stride) = match axis {
            0 => (grid.rows, grid.columns),
            _ => (grid.columns, 1),
        };
        let line: Vec<f64> = (0..count)
            .map(|k| data.parameters[k * stride][axis])
            .collect();
        let steps = line.windows(2).map(|pair| pair[1] - pair[0]);
        let side = data.sides[axis];
        let last = line.last().zip(line.first()).filter(|_| side.is_closed);
        let last = last.map(|(last, first)| side.length() - (last - first));
        let longest = steps.chain(last).fold(0.0, f64::max);
        Steps::around_lines(side, longest)
    };
    [step(0), step(1)]
}

/// Cells of scattered points: as long in space in both directions, the smallest that hold about two points and in which the
/// points lie beside each other, not along lines.
fn of_scattered(data: &Data, scales: [f64; 2], meter: &mut Meter) -> [Steps; 2] {
    let count = data.given().count();
    let most = (CELLS_PER_POINT * count).clamp(CELLS, MOST_CELLS) as f64;
    let area = data.sides[0].length() * scales[0] * data.sides[1].length() * scales[1];
    let steps =
        |length: f64| [0, 1].map(|axis| Steps::at_most(data.sides[axis], length / scales[axis]));
    let mut length = (area / most).sqrt();
    let mut dense = None;
    loop {
        let these = steps(length);
        if these[0].count * these[1].count == 1 {
            return dense.unwrap_or(these);
        }
        length *= GROWTH;
        // A long narrow rectangle has more.
        if these[0].count.saturating_mul(these[1].count) > 2 * most as usize {
            continue;
        }
        let mut cells = Cells::of(these, data.given(), data.poles, meter);
        let filled = cells.filled_count();
        if count as f64 >= IN_A_CELL * filled as f64 {
            let dense = dense.get_or_insert(these);
            cells.close(meter);
            let is_filled = 2 * filled >= cells.filled_count();
            if is_filled && cells.are_wide(data.given(), meter) {
                return these;
            }
            if these[0].count.min(these[1].count) == 1 {
                return *dense;
            }
        }
    }
}
