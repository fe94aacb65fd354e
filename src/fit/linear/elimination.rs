//! LU decomposition of totally positive banded matrices, which needs no pivots: elimination makes no
//! entry larger (de Boor, Pinkus 1977).
//!
//! Long matrices are eliminated from both ends at a time, by two threads that meet in the middle: read
//! backwards a totally positive matrix is one, too. What is left there is a small system.
//!
//! Rows of a fixed number of entries, and as many lines as registers hold: each step waits for the one
//! before, so that several lines take as long as one.

use std::array::from_fn;
use std::ops::Range;

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::banded::Banded;
use super::dense::DenseLu;
use super::map::LineMap;
use crate::fit::order;

/// Lines that are solved side by side.
const LINES: usize = 4;

/// Groups of lines with fewer numbers in all are solved by one thread.
const PARALLEL: usize = 100_000;

/// Matrices with fewer rows are eliminated from one end: fits that are computed at once should not wait
/// for the threads of large ones.
const HALVED: usize = 100_000;

/// Rows that are looked at together.
const CHUNK: usize = 1024;

/// `σ B − τ I`.
#[derive(Clone, Copy)]
pub(super) struct Shifted<'a> {
    pub matrix: &'a Banded,
    pub sigma: f64,
    pub tau: f64,
}

/// A decomposed matrix with at most H entries on each side of the diagonal.
#[derive(Debug)]
struct Elimination<const H: usize> {
    front: Half<H, false>,
    back: Half<H, true>,
    /// The last H rows of both halves, the unknowns in the order of the matrix.
    middle: Option<DenseLu>,
}

/// `L U` of consecutive rows from one end on, in the order in which they are eliminated; the diagonal
/// of U is one. The last H rows of U reach into the other half.
#[derive(Debug)]
struct Half<const H: usize, const BACK: bool> {
    lower: Vec<Lower<H>>,
    /// The entries of each row of U behind the diagonal, nearest first.
    upper: Vec<[f64; H]>,
}

/// A row of L.
#[derive(Debug)]
struct Lower<const H: usize> {
    /// The reciprocal of the entry on the diagonal.
    reciprocal: f64,
    /// The entries before it, nearest first, divided by it.
    entries: [f64; H],
}

/// A row of U that later ones need, not yet divided by its pivot.
#[derive(Clone, Copy)]
struct Before<const H: usize> {
    entries: [f64; H],
    reciprocal: f64,
}

impl<const H: usize> Before<H> {
    fn none() -> Self {
        Self {
            entries: [0.0; H],
            reciprocal: 1.0,
        }
    }
}

/// A decomposed matrix, of whatever width.
pub trait Solver: LineMap {
    /// Solves each line in place, and adds another line to it while it is at hand.
    fn apply_onto(&self, lines: &mut [&mut [f64]], others: &[&[f64]]);
}

/// Decomposes a square matrix that needs no pivots and is not cyclic, if its band is narrow.
pub(super) fn decompose(given: Shifted<'_>) -> Option<Box<dyn Solver>> {
    let filled = given
        .matrix
        .diagonals()
        .filter(|it| !order::is_zero(it.values));
    let reach = filled.map(|it| it.offset.unsigned_abs()).max().unwrap_or(0);
    Some(match reach {
        0 | 1 => Box::new(Elimination::<1>::new(given)),
        2 => Box::new(Elimination::<2>::new(given)),
        3 => Box::new(Elimination::<3>::new(given)),
        4 => Box::new(Elimination::<4>::new(given)),
        _ => return None,
    })
}

impl<const H: usize> Elimination<H> {
    fn new(given: Shifted<'_>) -> Self {
        let n = given.matrix.rows();
        let middle = if n < HALVED { n } else { n / 2 };
        let front = || Half::new(given, 0..middle);
        let back = || Half::new(given, middle..n);
        let meets = middle < n;
        let (front, back) = if meets {
            rayon::join(front, back)
        } else {
            (front(), back())
        };
        let middle = meets.then(|| DenseLu::new(&Self::middle(&front, &back)));
        Self {
            front,
            back,
            middle,
        }
    }

    fn middle(front: &Half<H, false>, back: &Half<H, true>) -> DMatrix<f64> {
        let mut middle = DMatrix::identity(2 * H, 2 * H);
        for (above, row) in front.upper.iter().rev().take(H).enumerate() {
            let i = H - 1 - above;
            (0..H).for_each(|k| middle[(i, i + 1 + k)] = row[k]);
        }
        for (below, row) in back.upper.iter().rev().take(H).enumerate() {
            let i = H + below;
            (0..H).for_each(|k| middle[(i, i - 1 - k)] = row[k]);
        }
        middle
    }

    /// Solves N lines in place, and adds others to them.
    fn solve<const N: usize>(&self, lines: [&mut [f64]; N], others: Option<[&[f64]; N]>) {
        let Self {
            front,
            back,
            middle,
        } = self;
        let at = front.lower.len();
        let (mut first, mut second) = split(lines, at);
        let others_of_first = others.map(|others| others.map(|line| &line[..at]));
        let others_of_second = others.map(|others| others.map(|line| &line[at..]));
        let Some(middle) = middle else {
            front.forward(&mut first);
            return front.backward(&mut first, 0, others_of_first);
        };
        rayon::join(|| front.forward(&mut first), || back.forward(&mut second));
        for (first, second) in first.iter_mut().zip(&mut second) {
            let last = first.len() - H;
            let (first, second) = (&mut first[last..], &mut second[..H]);
            let mut unknowns = [&*first, &*second].concat();
            middle.apply(&mut unknowns);
            first.copy_from_slice(&unknowns[..H]);
            second.copy_from_slice(&unknowns[H..]);
        }
        rayon::join(
            || front.backward(&mut first, H, others_of_first),
            || back.backward(&mut second, H, others_of_second),
        );
    }

    fn solve_group(&self, lines: &mut [&mut [f64]], others: Option<&[&[f64]]>) {
        match lines.len() {
            0 => {}
            1 => self.solve_lines::<1>(lines, others),
            2 => self.solve_lines::<2>(lines, others),
            3 => self.solve_lines::<3>(lines, others),
            _ => self.solve_lines::<LINES>(lines, others),
        }
    }

    fn solve_lines<const N: usize>(&self, lines: &mut [&mut [f64]], others: Option<&[&[f64]]>) {
        let n = self.front.lower.len() + self.back.lower.len();
        // One length for all, so that places need no checks.
        let mut cut = lines.iter_mut().map(|line| &mut line[..n]);
        let lines = from_fn(|_| cut.next().unwrap_or_default());
        let others = others.map(|others| from_fn(|line| &others[line][..n]));
        self.solve::<N>(lines, others);
    }
}

impl<const H: usize, const BACK: bool> Half<H, BACK> {
    fn new(given: Shifted<'_>, rows: Range<usize>) -> Self {
        let mut half = Self {
            lower: Vec::with_capacity(rows.len()),
            upper: Vec::with_capacity(rows.len()),
        };
        let spans = given.matrix.spans(rows);
        let mut spans: Vec<(i32, Range<usize>)> = spans
            .flat_map(|(offset, span)| {
                let starts = span.clone().step_by(CHUNK);
                starts.map(move |start| (offset, start..span.end.min(start + CHUNK)))
            })
            .collect();
        if BACK {
            spans.reverse();
        }
        let mut before = [Before::none(); H];
        for (offset, span) in spans {
            half.eliminate(given, offset, span, &mut before);
        }
        half
    }

    /// Row by row, by the rows of U before it, the farthest first.
    fn eliminate(
        &mut self,
        Shifted { matrix, sigma, tau }: Shifted<'_>,
        offset: i32,
        span: Range<usize>,
        before: &mut [Before<H>; H],
    ) {
        const NONE: [f64; CHUNK] = [0.0; CHUNK];
        let n = span.len();
        // Entries so far behind the diagonal, as this half is read.
        let diagonal = |behind: i32| {
            let place = if BACK { -behind } else { behind } - offset;
            let place = usize::try_from(place).ok();
            let place = place.filter(|&place| place < matrix.width());
            place.map_or(&NONE[..n], |k| &matrix.diagonal(k, span.clone())[..n])
        };
        let own = diagonal(0);
        let lefts: [&[f64]; H] = from_fn(|k| diagonal(-1 - k as i32));
        let rights: [&[f64]; H] = from_fn(|k| diagonal(1 + k as i32));
        for row in 0..n {
            let i = if BACK { n - 1 - row } else { row };
            let mut pivot = sigma * own[i] - tau;
            let mut lower = lefts.map(|entries| sigma * entries[i]);
            let mut upper = rights.map(|entries| sigma * entries[i]);
            for k in (0..H).rev() {
                let factor = lower[k];
                let Before {
                    entries,
                    reciprocal,
                } = before[k];
                // Entry j of that row is k − j columns left of the diagonal.
                for (j, entry) in entries.into_iter().enumerate() {
                    // The reciprocal is what all wait for.
                    let product = factor * entry * reciprocal;
                    match k.cmp(&j) {
                        std::cmp::Ordering::Greater => lower[k - j - 1] -= product,
                        std::cmp::Ordering::Equal => pivot -= product,
                        std::cmp::Ordering::Less => upper[j - k - 1] -= product,
                    }
                }
            }
            let reciprocal = 1.0 / pivot;
            self.lower.push(Lower {
                reciprocal,
                entries: lower.map(|x| x * reciprocal),
            });
            self.upper.push(upper.map(|x| x * reciprocal));
            before.rotate_right(1);
            before[0] = Before {
                entries: upper,
                reciprocal,
            };
        }
    }

    /// Where a row stands in lines.
    fn place(&self, row: usize) -> usize {
        if BACK {
            self.lower.len() - 1 - row
        } else {
            row
        }
    }

    /// `L⁻¹` of N lines.
    fn forward<const N: usize>(&self, lines: &mut [&mut [f64]; N]) {
        let mut before = [[0.0; N]; H];
        for (
            row,
            Lower {
                reciprocal,
                entries,
            },
        ) in self.lower.iter().enumerate()
        {
            let i = self.place(row);
            // The nearest one, which all wait for, comes last.
            let mut x: [f64; N] = from_fn(|line| lines[line][i] * reciprocal);
            for k in (0..H).rev() {
                x = from_fn(|line| x[line] - entries[k] * before[k][line]);
            }
            before.rotate_right(1);
            before[0] = x;
            (0..N).for_each(|line| lines[line][i] = x[line]);
        }
    }

    /// `U⁻¹` of N lines, the last places of which are known, and the sum with others: they are looked
    /// at while the lines are at hand.
    fn backward<const N: usize>(
        &self,
        lines: &mut [&mut [f64]; N],
        known: usize,
        others: Option<[&[f64]; N]>,
    ) {
        let sum = |x: [f64; N], i: usize| match others {
            Some(others) => from_fn(|line| x[line] + others[line][i]),
            None => x,
        };
        let rows = self.upper.len() - known;
        let mut behind = [[0.0; N]; H];
        for (row, behind) in (rows..).zip(&mut behind[..known]) {
            let i = self.place(row);
            *behind = from_fn(|line| lines[line][i]);
            let x = sum(*behind, i);
            (0..N).for_each(|line| lines[line][i] = x[line]);
        }
        for (row, upper) in self.upper[..rows].iter().enumerate().rev() {
            let i = self.place(row);
            let mut x: [f64; N] = from_fn(|line| lines[line][i]);
            for k in (0..H).rev() {
                x = from_fn(|line| x[line] - upper[k] * behind[k][line]);
            }
            behind.rotate_right(1);
            behind[0] = x;
            let x = sum(x, i);
            (0..N).for_each(|line| lines[line][i] = x[line]);
        }
    }
}

/// Splits all lines at the same place.
fn split<const N: usize>(lines: [&mut [f64]; N], at: usize) -> ([&mut [f64]; N], [&mut [f64]; N]) {
    let mut parts = lines.map(|line| line.split_at_mut(at));
    let mut fronts = parts.iter_mut().map(|(front, _)| std::mem::take(front));
    let fronts = from_fn(|_| fronts.next().unwrap_or_default());
    (fronts, parts.map(|(_, back)| back))
}

impl<const H: usize> LineMap for Elimination<H> {
    fn apply(&self, lines: &mut [f64]) {
        let n = self.front.lower.len() + self.back.lower.len();
        let mut lines: Vec<&mut [f64]> = lines.chunks_exact_mut(n).collect();
        self.apply_each(&mut lines);
    }

    fn apply_each(&self, lines: &mut [&mut [f64]]) {
        let numbers = lines.iter().map(|line| line.len()).sum::<usize>();
        if lines.len() > LINES && numbers >= PARALLEL {
            let groups = lines.par_chunks_mut(LINES);
            groups.for_each(|group| self.solve_group(group, None));
        } else {
            let groups = lines.chunks_mut(LINES);
            groups.for_each(|group| self.solve_group(group, None));
        }
    }
}

impl<const H: usize> Solver for Elimination<H> {
    fn apply_onto(&self, lines: &mut [&mut [f64]], others: &[&[f64]]) {
        let groups = lines.chunks_mut(LINES).zip(others.chunks(LINES));
        groups.for_each(|(group, others)| self.solve_group(group, Some(others)));
    }
}
