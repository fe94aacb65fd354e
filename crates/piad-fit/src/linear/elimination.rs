//! LU decomposition of totally positive banded matrices, which needs no pivots: elimination makes
//! no entry larger (de Boor, Pinkus, *Backward error analysis for totally positive linear systems*,
//! 1977).
//!
//! With at most H entries on each side of the diagonal `B = L U`, where U has ones on its diagonal,
//! is
//!
//! ```text
//! l_i,j = b_i,j − Σ_k l_i,k u_k,j   (j ≤ i),      u_i,j = (b_i,j − Σ_k l_i,k u_k,j) / l_i,i   (j > i)
//! ```
//!
//! with sums over the at most H columns k before i and j: `2 n H (H + 1)` operations, and `4 n H`
//! for solving for a line. Each row waits for the one before, so that the time is that of a chain
//! of n dependent steps; hence reciprocals rather than quotients, rows of a fixed number of
//! entries, and as many lines side by side as registers hold: several lines take as long as one.
//!
//! Long matrices are eliminated from both ends at a time, by two threads that meet in the middle: reversed, a totally
//! positive matrix is still one. A dense system of 2 H unknowns is left there.

use std::array::from_fn;
use std::ops::Range;

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::banded::Banded;
use super::dense::DenseLu;
use super::map::LineMap;
use crate::data::monotonic;

/// The most lines that are solved for side by side.
const LINES: usize = 4;

/// Lines with fewer numbers in all are solved for by one thread.
const PARALLEL: usize = 100_000;

/// Matrices with fewer rows are eliminated from one end, without other threads: small fits should
/// not wait for the threads of large ones.
const HALVED: usize = 100_000;

/// The number of rows whose entries are loaded together.
const CHUNK: usize = 1024;

/// The matrix `σ B − τ I`: B itself with σ = 1 and τ = 0.
#[derive(Clone, Copy)]
pub(super) struct Shifted<'a> {
    pub matrix: &'a Banded,
    pub sigma: f64,
    pub tau: f64,
}

/// A factorized matrix with at most H entries on each side of the diagonal.
#[derive(Debug)]
struct Elimination<const H: usize> {
    /// The rows from the first one on: all of them, or half of them.
    front: Half<H, false>,
    /// The rows from the last one on, if the matrix is long.
    back: Half<H, true>,
    /// The equations of the last H rows of both halves, in the order of the matrix, for long matrices.
    middle: Option<DenseLu>,
}

/// The factors `L U` of consecutive rows from one end on, in the order in which they are
/// eliminated. The diagonal of U is one. The last H rows of U reach into the other half.
#[derive(Debug)]
struct Half<const H: usize, const BACK: bool> {
    /// The rows of L.
    lower: Vec<Lower<H>>,
    /// The entries of each row of U behind its diagonal, the nearest first.
    upper: Vec<[f64; H]>,
}

/// A row of L.
#[derive(Debug)]
struct Lower<const H: usize> {
    /// The reciprocal of the entry on the diagonal.
    reciprocal: f64,
    /// The entries before it, the nearest first, divided by the one on the diagonal.
    entries: [f64; H],
}

/// A row of U that later rows need, before it is divided by its pivot.
#[derive(Clone, Copy)]
struct Before<const H: usize> {
    /// The entries behind the diagonal, the nearest first.
    entries: [f64; H],
    /// The reciprocal of the pivot.
    reciprocal: f64,
}

impl<const H: usize> Before<H> {
    /// Placeholder for rows before the first one: it changes nothing.
    fn none() -> Self {
        Self {
            entries: [0.0; H],
            reciprocal: 1.0,
        }
    }
}

/// A factorized matrix of any bandwidth.
pub trait Solver: LineMap {
    /// Solves for each line in place, and adds another line to it while it is in the cache:
    /// `x ← B⁻¹ x + other`.
    fn apply_onto(&self, lines: &mut [&mut [f64]], others: &[&[f64]]);
}

/// Factorizes a square matrix that needs no pivots and is not cyclic. `None` if there are more than
/// 4 entries on a side of the diagonal.
pub(super) fn decompose(given: Shifted<'_>) -> Option<Box<dyn Solver>> {
    let filled = given
        .matrix
        .diagonals()
        .filter(|it| !monotonic::is_zero(it.values));
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
    /// Factorizes a matrix, a long one from both ends at a time.
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
        let middle = meets.then(|| DenseLu::new(Self::middle(&front, &back)));
        Self {
            front,
            back,
            middle,
        }
    }

    /// The equations in which both halves meet: the last H rows of U of each, `2 H × 2 H`.
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

    /// Solves for N lines in place, and adds others to them.
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

    /// Solves for at most [`LINES`] lines.
    fn solve_group(&self, lines: &mut [&mut [f64]], others: Option<&[&[f64]]>) {
        match lines.len() {
            0 => {}
            1 => self.solve_lines::<1>(lines, others),
            2 => self.solve_lines::<2>(lines, others),
            3 => self.solve_lines::<3>(lines, others),
            _ => self.solve_lines::<LINES>(lines, others),
        }
    }

    /// Solves for N lines, which the compiler knows to have the same length.
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
    /// Factorizes consecutive rows, from the first one on or from the last one.
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

    /// Eliminates the rows of a span one after the other, each by the H rows of U before it, the
    /// farthest first, and leaves the last H rows of U in `before`.
    fn eliminate(
        &mut self,
        Shifted { matrix, sigma, tau }: Shifted<'_>,
        offset: i32,
        span: Range<usize>,
        before: &mut [Before<H>; H],
    ) {
        const NONE: [f64; CHUNK] = [0.0; CHUNK];
        let n = span.len();
        // The entries at this distance behind the diagonal, in the direction in which this half is read.
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
                    // The reciprocal is on the critical path.
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

    /// The place in a line of the row that is eliminated as number `row`.
    fn place(&self, row: usize) -> usize {
        if BACK {
            self.lower.len() - 1 - row
        } else {
            row
        }
    }

    /// Applies `L⁻¹` to N lines in place.
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
            // The nearest one, which is on the critical path, comes last.
            let mut x: [f64; N] = from_fn(|line| lines[line][i] * reciprocal);
            for k in (0..H).rev() {
                x = from_fn(|line| x[line] - entries[k] * before[k][line]);
            }
            before.rotate_right(1);
            before[0] = x;
            (0..N).for_each(|line| lines[line][i] = x[line]);
        }
    }

    /// Applies `U⁻¹` to N lines in place, where the last `known` places are solutions already, and
    /// adds other lines to them while they are in registers.
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

/// Splits all lines at the same place: the halves that are eliminated from both ends.
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

    /// Groups of lines that registers hold, on several threads if there are many numbers.
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
