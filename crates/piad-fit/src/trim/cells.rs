//! A rectangle of parameters in cells, of which some hold data.

use crate::interrupt::Meter;

/// The most cells of holes that are filled, along both directions.
const SMALL: usize = 3;

/// The most empty cells at a corner of a rectangle of many cells that are filled, along both directions: those of scattered points
/// have none now and then.
const SMALL_CORNER: usize = 2;
const MANY: usize = 12;

/// The most empty cells in a row along a side of the rectangle that are filled.
const SHALLOW: usize = 8;

/// The least part of the points that lie in blocks of 3 × 3 cells where the cells are large enough.
const IN_BLOCKS: f64 = 0.8;

/// A part of a cell by which points are moved up before they are counted, so that points at the edges of cells lie in one of
/// them whatever their rounding.
const NUDGE: f64 = 1e-9;

/// One direction of a rectangle of parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Side {
    /// Where it begins.
    pub low: f64,
    /// Where it ends.
    pub high: f64,
    /// True if it repeats.
    pub is_closed: bool,
}

impl Side {
    pub(super) fn length(self) -> f64 {
        self.high - self.low
    }
}

/// One direction of cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Steps {
    side: Side,
    /// Where the first cell begins: half a cell before the direction if it is that of a grid of points.
    origin: f64,
    /// The length of a cell.
    pub size: f64,
    /// The number of cells.
    pub count: usize,
}

impl Steps {
    /// Cells that are at most this long.
    pub(super) fn at_most(side: Side, length: f64) -> Self {
        let count = (side.length() / length * (1.0 - NUDGE)).ceil().max(1.0);
        Self::between(side, count as usize)
    }

    /// Cells around lines of points that are at most this far from each other.
    pub(super) fn around_lines(side: Side, step: f64) -> Self {
        let steps = (side.length() / step * (1.0 + NUDGE)).floor().max(1.0) as usize;
        if side.is_closed {
            return Self::between(side, steps);
        }
        let size = side.length() / steps as f64;
        Self {
            side,
            origin: side.low - 0.5 * size,
            size,
            count: steps + 1,
        }
    }

    fn between(side: Side, count: usize) -> Self {
        Self {
            side,
            origin: side.low,
            size: side.length() / count as f64,
            count,
        }
    }

    /// The cell of a parameter.
    fn cell(self, t: f64) -> usize {
        let place = (t - self.origin) / self.size + NUDGE;
        let last = self.count - 1;
        match self.side.is_closed {
            true => (place.rem_euclid(self.count as f64) as usize).min(last),
            false => (place.max(0.0) as usize).min(last),
        }
    }

    /// The number of cells on either side of its own that a point at v fills, of rows that become shorter towards poles
    /// as the parallels of a sphere do.
    fn reach(self, v: f64, poles: [bool; 2], around: Self) -> usize {
        if poles == [false; 2] || !around.side.is_closed {
            return 0;
        }
        let radius = around.side.length() / std::f64::consts::TAU;
        let ends = [v - self.side.low, self.side.high - v];
        let near = ends.into_iter().zip(poles).filter(|(_, is_pole)| *is_pole);
        let shares = near.map(|(from, _)| {
            let angle = (from / radius).clamp(0.0, std::f64::consts::FRAC_PI_2);
            angle.sin()
        });
        let share = shares.fold(1.0, f64::min);
        let most = around.count as f64;
        (0.5 * (1.0 / share - 1.0)).min(most).ceil() as usize
    }

    /// Where the rectangle begins and ends, in cells from the first one.
    pub(super) fn range(self) -> [f64; 2] {
        let start = (self.side.low - self.origin) / self.size;
        [start, self.count as f64 - start]
    }

    /// The parameter of a place in cells, which at both ends is that of the rectangle.
    pub(super) fn parameter(self, place: f64) -> f64 {
        let [first, last] = self.range();
        match place {
            _ if place <= first => self.side.low,
            _ if place >= last => self.side.high,
            _ => (self.origin + place * self.size).clamp(self.side.low, self.side.high),
        }
    }
}

/// Cells of both directions, those of u in each row.
#[derive(Clone, Debug)]
pub(super) struct Cells {
    pub steps: [Steps; 2],
    filled: Vec<bool>,
}

/// A cell by its numbers in u and v, which may be outside.
pub(super) type Cell = [isize; 2];

/// A cell and its eight neighbours.
fn around([i, j]: Cell) -> impl Iterator<Item = Cell> {
    (-1..=1).flat_map(move |dj| (-1..=1).map(move |di| [i + di, j + dj]))
}

impl Cells {
    /// Those that hold one of these points. Towards `poles`, where rows are shorter, a point fills as much of its row as a cell is
    /// long elsewhere.
    pub(super) fn of(
        steps: [Steps; 2],
        points: impl Iterator<Item = [f64; 2]>,
        poles: [bool; 2],
        meter: &mut Meter,
    ) -> Self {
        let [columns, rows] = steps.map(|it| it.count);
        // Where points begin to fill cells, and where they end to.
        let mut changes = vec![0_i32; (columns + 1) * rows];
        for [u, v] in points {
            meter.add(4);
            let [column, row] = [steps[0].cell(u), steps[1].cell(v)];
            let line = &mut changes[row * (columns + 1)..][..=columns];
            let mut fill = |from: usize, to: usize| {
                line[from] += 1;
                line[to] -= 1;
            };
            match steps[1].reach(v, poles, steps[0]) {
                0 => fill(column, column + 1),
                reach if 2 * reach + 1 >= columns => fill(0, columns),
                reach => {
                    fill(
                        column.saturating_sub(reach),
                        (column + reach + 1).min(columns),
                    );
                    // A row near a pole goes around.
                    if column < reach {
                        fill(columns + column - reach, columns);
                    }
                    if column + reach >= columns {
                        fill(0, column + reach + 1 - columns);
                    }
                }
            }
        }
        let mut filled = Vec::with_capacity(columns * rows);
        for line in changes.chunks_exact(columns + 1) {
            let mut count = 0;
            filled.extend(line[..columns].iter().map(|change| {
                count += change;
                count > 0
            }));
        }
        Self { steps, filled }
    }

    fn counts(&self) -> [isize; 2] {
        self.steps.map(|it| it.count as isize)
    }

    /// The index of a cell; of closed directions also of one outside.
    fn index(&self, cell: Cell) -> Option<usize> {
        let mut place = [0, 0];
        for axis in 0..2 {
            let count = self.steps[axis].count as isize;
            let at = match self.steps[axis].side.is_closed {
                true => cell[axis].rem_euclid(count),
                false => cell[axis],
            };
            place[axis] = Some(at).filter(|it| (0..count).contains(it))? as usize;
        }
        Some(place[1] * self.steps[0].count + place[0])
    }

    /// Returns true if a cell is inside of the rectangle.
    pub(super) fn contains(&self, cell: Cell) -> bool {
        (0..2).all(|axis| (0..self.counts()[axis]).contains(&cell[axis]))
    }

    /// Returns true if a cell is filled: none is outside of the rectangle, also of a closed one.
    pub(super) fn is_filled(&self, cell: Cell) -> bool {
        self.contains(cell) && self.index(cell).is_some_and(|index| self.filled[index])
    }

    /// All cells, in their order.
    pub(super) fn each(&self) -> impl Iterator<Item = Cell> + use<> {
        let [columns, rows] = self.counts();
        (0..rows).flat_map(move |j| (0..columns).map(move |i| [i, j]))
    }

    /// The number of filled cells.
    pub(super) fn filled_count(&self) -> usize {
        self.filled.iter().filter(|it| **it).count()
    }

    /// Returns true if all cells are filled.
    pub(super) fn are_all_filled(&self) -> bool {
        self.filled.iter().all(|it| *it)
    }

    /// Returns true if a cell or one of its eight neighbours is filled, also for cells outside.
    fn is_near(&self, cell: Cell) -> bool {
        around(cell).any(|near| self.index(near).is_some_and(|index| self.filled[index]))
    }

    /// The cells of which this is true.
    fn those(&self, meter: &mut Meter, is: impl Fn(Cell) -> bool) -> Self {
        let mut filled = Vec::with_capacity(self.filled.len());
        for cell in self.each() {
            meter.add(9);
            filled.push(is(cell));
        }
        Self { filled, ..*self }
    }

    /// Fills gaps of up to two cells, and holes of up to three by three, corners of two by two and rows along
    /// a side.
    pub(super) fn close(&mut self, meter: &mut Meter) {
        let wider = self.those(meter, |cell| self.is_near(cell));
        let is_wider = |cell| match wider.index(cell) {
            Some(index) => wider.filled[index],
            None => self.is_near(cell),
        };
        let closed = self.those(meter, |cell| around(cell).all(is_wider));
        self.filled = closed.filled;
        self.fill_small(meter);
    }

    /// Returns true if most of these points lie in filled blocks of three by three cells.
    pub(super) fn are_wide(
        &self,
        points: impl Iterator<Item = [f64; 2]>,
        meter: &mut Meter,
    ) -> bool {
        let is_filled = |near| self.index(near).is_none_or(|index| self.filled[index]);
        let inner = self.those(meter, |cell| around(cell).all(is_filled));
        let blocks = inner.those(meter, |cell| inner.is_near(cell));
        let (mut inside, mut all) = (0_usize, 0_usize);
        for [u, v] in points {
            meter.add(4);
            let cell = [self.steps[0].cell(u), self.steps[1].cell(v)];
            inside += usize::from(blocks.filled[cell[1] * self.steps[0].count + cell[0]]);
            all += 1;
        }
        inside as f64 >= IN_BLOCKS * all as f64
    }

    /// Fills the holes, corners and rows along sides that are small.
    fn fill_small(&mut self, meter: &mut Meter) {
        let mut seen = self.filled.clone();
        for start in self.each() {
            if self.index(start).is_none_or(|index| seen[index]) {
                continue;
            }
            let part = self.part(start, &mut seen, meter);
            let extent = |axis: usize| {
                let places = part.iter().map(|cell| cell[axis]);
                let (low, high) = places.fold((isize::MAX, isize::MIN), |(low, high), at| {
                    (low.min(at), high.max(at))
                });
                (high - low) as usize + 1
            };
            let is_hole = part
                .iter()
                .all(|&cell| around(cell).all(|it| self.index(it).is_some()));
            let extents = [extent(0), extent(1)];
            let [least, longest] = [extents[0].min(extents[1]), extents[0].max(extents[1])];
            let most = match is_hole {
                true => SMALL,
                false if part.iter().any(|cell| self.is_corner(*cell)) => SMALL_CORNER,
                // A row of cells along a side.
                false if least == 1 => SHALLOW,
                false => 0,
            };
            if longest <= most {
                for cell in part {
                    if let Some(index) = self.index(cell) {
                        self.filled[index] = true;
                    }
                }
            }
        }
    }

    /// Returns true if a cell is at a corner of a rectangle of many cells that is not closed.
    fn is_corner(&self, cell: Cell) -> bool {
        (0..2).all(|axis| {
            let Steps { side, count, .. } = self.steps[axis];
            let is_end = cell[axis] == 0 || cell[axis] == count as isize - 1;
            is_end && !side.is_closed && count >= MANY
        })
    }

    /// The connected empty cells around one, also across corners; closed directions wrap around.
    fn part(&self, start: Cell, seen: &mut [bool], meter: &mut Meter) -> Vec<Cell> {
        let mut part = Vec::new();
        let mut next = vec![start];
        if let Some(index) = self.index(start) {
            seen[index] = true;
        }
        while let Some([i, j]) = next.pop() {
            meter.add(9);
            part.push([i, j]);
            for cell in around([i, j]) {
                if let Some(index) = self.index(cell).filter(|index| !seen[*index]) {
                    seen[index] = true;
                    next.push(cell);
                }
            }
        }
        part
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn side(length: f64, is_closed: bool) -> Side {
        Side {
            low: 0.0,
            high: length,
            is_closed,
        }
    }

    fn cells(rows: &[&str], is_closed: bool) -> Cells {
        let width = rows[0].len();
        let steps = [
            Steps::at_most(side(width as f64, is_closed), 1.0),
            Steps::at_most(side(rows.len() as f64, false), 1.0),
        ];
        let points = rows.iter().enumerate().flat_map(|(j, row)| {
            let filled = row.bytes().enumerate().filter(|(_, mark)| *mark == b'#');
            filled.map(move |(i, _)| [i as f64 + 0.5, j as f64 + 0.5])
        });
        Cells::of(steps, points, [false; 2], &mut Meter::default())
    }

    fn drawn(cells: &Cells) -> Vec<String> {
        let rows = cells.filled.chunks(cells.steps[0].count);
        let mark = |filled: &bool| if *filled { '#' } else { '.' };
        rows.map(|row| row.iter().map(mark).collect()).collect()
    }

    #[test]
    fn small_holes_and_gaps_are_filled() {
        let mut it = cells(
            &[
                "####.###########",
                "####.###########",
                "################",
                "##...#######....",
                "##...#######....",
                "##...#######....",
                "############....",
                "################",
            ],
            false,
        );
        it.close(&mut Meter::default());
        let expected = [
            "################",
            "################",
            "################",
            "############....",
            "############....",
            "############....",
            "############....",
            "################",
        ];
        assert_eq!(drawn(&it), expected);
    }

    #[test]
    fn small_corners_of_many_cells_are_filled() {
        let row = "##############";
        let mut rows = vec![row; 14];
        (rows[0], rows[1], rows[13]) = ("..####.....###", ".#############", "###########...");
        let mut it = cells(&rows, false);
        it.close(&mut Meter::default());
        let mut expected = vec![row; 14];
        expected[13] = "###########...";
        assert_eq!(drawn(&it), expected);
    }

    /// A gap across the seam is one, not two.
    #[test]
    fn closed_directions_continue() {
        let rows = vec!["..########.."; 9];
        let mut it = cells(&rows, true);
        it.close(&mut Meter::default());
        assert_eq!(drawn(&it), rows);
        let mut narrow = cells(&[".##########."; 9], true);
        narrow.close(&mut Meter::default());
        assert!(narrow.are_all_filled());
    }

    #[test]
    fn lines_of_points_have_a_cell_each() {
        let steps = Steps::around_lines(side(1.0, false), 0.1);
        assert_eq!(steps.count, 11);
        for k in 0..11 {
            assert_eq!(steps.cell(0.1 * f64::from(k)), k as usize);
        }
        assert_eq!(steps.parameter(0.0), 0.0);
        assert_eq!(steps.parameter(11.0), 1.0);
        let closed = Steps::around_lines(side(1.0, true), 0.1);
        assert_eq!(closed.count, 10);
        assert_eq!(closed.cell(1.0), 0);
        assert_eq!(closed.cell(-0.05), 9);
    }
}
