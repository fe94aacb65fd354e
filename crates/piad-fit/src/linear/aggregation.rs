//! A multigrid preconditioner for M-matrices: neighbours that are strongly coupled become one unknown of a coarser system,
//! until there are few (aggregation; Braess 1995).

use super::sparse_rows::SparseRows;

/// Systems of this size are not made coarser.
const FEW: usize = 64;

/// Sweeps that solve the coarsest system.
const SWEEPS: usize = 30;

/// An entry is strong if it is at least this part of the largest of its row.
const STRONG: f64 = 0.25;

/// Corrections of constants are too small by about this factor.
const OVERCORRECTION: f64 = 1.5;

/// The systems from the finest to the coarsest.
pub(super) struct Hierarchy<'a> {
    finest: &'a SparseRows,
    /// How the next coarser system comes from the one before, and that system.
    coarser: Vec<Coarser>,
}

struct Coarser {
    /// The coarse unknown of each fine one.
    aggregates: Vec<u32>,
    /// What the rows of the coarse system were divided by.
    diagonal: Vec<f64>,
    rows: SparseRows,
}

impl<'a> Hierarchy<'a> {
    pub(super) fn new(finest: &'a SparseRows) -> Self {
        let mut coarser: Vec<Coarser> = Vec::new();
        loop {
            let rows = coarser.last().map_or(finest, |it| &it.rows);
            let before = rows.len();
            if before <= FEW {
                break;
            }
            let next = Coarser::of(rows);
            // Nothing is strongly coupled.
            if 10 * next.rows.len() > 9 * before {
                break;
            }
            coarser.push(next);
        }
        Self { finest, coarser }
    }

    fn rows(&self, level: usize) -> &SparseRows {
        match level.checked_sub(1) {
            None => self.finest,
            Some(level) => &self.coarser[level].rows,
        }
    }

    /// An approximate solution of `A x = b` by a W-cycle.
    pub(super) fn apply(&self, b: &[f64]) -> Vec<f64> {
        self.cycle(0, b)
    }

    fn cycle(&self, level: usize, b: &[f64]) -> Vec<f64> {
        let rows = self.rows(level);
        let mut x = vec![0.0; b.len()];
        let Some(coarser) = self.coarser.get(level) else {
            for _ in 0..SWEEPS {
                rows.sweep(b, &mut x, false);
                rows.sweep(b, &mut x, true);
            }
            return x;
        };
        rows.sweep(b, &mut x, false);
        let mut residual = coarser.restricted(&rows.residual(b, &x));
        let mut correction = self.cycle(level + 1, &residual);
        if level + 1 < self.coarser.len() {
            residual = coarser.rows.residual(&residual, &correction);
            let more = self.cycle(level + 1, &residual);
            correction.iter_mut().zip(&more).for_each(|(x, y)| *x += y);
        }
        for (x, &of) in x.iter_mut().zip(&coarser.aggregates) {
            *x += OVERCORRECTION * correction[of as usize];
        }
        rows.sweep(b, &mut x, true);
        x
    }
}

impl Coarser {
    fn of(rows: &SparseRows) -> Self {
        let aggregates = aggregates(rows);
        let count = aggregates.iter().max().map_or(0, |last| *last as usize + 1);
        // The fine rows of each coarse one.
        let mut starts = vec![0_u32; count + 1];
        for &of in &aggregates {
            starts[of as usize + 1] += 1;
        }
        for k in 0..count {
            starts[k + 1] += starts[k];
        }
        let mut places = starts.clone();
        let mut fine = vec![0_u32; aggregates.len()];
        for (row, &of) in aggregates.iter().enumerate() {
            fine[places[of as usize] as usize] = row as u32;
            places[of as usize] += 1;
        }
        let mut coarse = SparseRows::with_room(count, 6 * count);
        let mut diagonals = Vec::with_capacity(count);
        let mut entries: Vec<(u32, f64)> = Vec::new();
        for of in 0..count {
            let mut diagonal = 0.0;
            entries.clear();
            for &row in &fine[starts[of] as usize..starts[of + 1] as usize] {
                diagonal += 1.0;
                for (column, value) in rows.entries(row as usize) {
                    match aggregates[column] {
                        other if other as usize == of => diagonal += value,
                        other => entries.push((other, value)),
                    }
                }
            }
            entries.sort_by_key(|(other, _)| *other);
            let merged = entries.chunk_by(|a, b| a.0 == b.0);
            let merged = merged.map(|same| {
                let sum: f64 = same.iter().map(|(_, value)| value).sum();
                (same[0].0, sum / diagonal)
            });
            coarse.push(merged);
            diagonals.push(diagonal);
        }
        Self {
            aggregates,
            diagonal: diagonals,
            rows: coarse,
        }
    }

    /// The sums over the aggregates, divided as the rows of the coarse system are.
    fn restricted(&self, fine: &[f64]) -> Vec<f64> {
        let mut coarse = vec![0.0; self.diagonal.len()];
        for (value, &of) in fine.iter().zip(&self.aggregates) {
            coarse[of as usize] += value;
        }
        coarse
            .iter_mut()
            .zip(&self.diagonal)
            .for_each(|(x, d)| *x /= d);
        coarse
    }
}

/// The aggregate of each row: first those around rows without any neighbour in one, then the others join one.
fn aggregates(rows: &SparseRows) -> Vec<u32> {
    const NONE: u32 = u32::MAX;
    let mut of = vec![NONE; rows.len()];
    let mut count = 0;
    let strong = |row: usize| {
        let largest = rows
            .entries(row)
            .map(|(_, value)| value.abs())
            .fold(0.0, f64::max);
        let is_strong = move |(_, value): &(usize, f64)| value.abs() >= STRONG * largest;
        rows.entries(row).filter(is_strong)
    };
    for row in 0..rows.len() {
        if of[row] == NONE && strong(row).all(|(other, _)| of[other] == NONE) {
            of[row] = count;
            strong(row).for_each(|(other, _)| of[other] = count);
            count += 1;
        }
    }
    let first = of.clone();
    for (row, of) in of.iter_mut().enumerate() {
        if *of != NONE {
            continue;
        }
        let beside = strong(row).filter(|(other, _)| first[*other] != NONE);
        let nearest = beside.fold(None, |most: Option<(usize, f64)>, it| match most {
            Some(most) if most.1.abs() >= it.1.abs() => Some(most),
            _ => Some(it),
        });
        *of = match nearest {
            Some((other, _)) => first[other],
            None => {
                count += 1;
                count - 1
            }
        };
    }
    of
}
