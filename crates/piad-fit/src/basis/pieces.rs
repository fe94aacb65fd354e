//! Curves in pieces that meet at corners.
//!
//! At a corner the knot has multiplicity p: the curve passes through a control point there, is continuous, and may turn.
//! Between two corners it is a B-spline by itself, whose first and last control points are those of the corners:
//!
//! ```text
//! knots, p = 3            0 0 0 0   1   2 2 2   3 3 3 3
//! functions of pieces     0 1 2 3 4
//!                                 4 5 6 7
//! ```
//!
//! A closed curve begins and ends at its first corner, with the same control point, and is clamped there like an open one.
//!
//! A piece of m + 1 ≤ p control points still has p + 1 functions: it is the polynomial of degree m, whose degree is
//! raised (PT97 (5.36)):
//!
//! ```text
//! c_i = Σ_l C(m, l) C(p − m, i − l) / C(p, i) d_l
//! ```

use std::ops::Range;

/// Which control points the functions of a curve in pieces belong to.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Pieces {
    degree: usize,
    /// The first function of each piece, and the last function of the last one.
    functions: Vec<usize>,
    /// The first free control point of each piece, and the last one of the last piece.
    free: Vec<usize>,
    /// True if no piece has a raised degree.
    plain: bool,
    /// Of a closed curve the number of its first control point, that of its first corner; the others follow, and after
    /// the last number the first.
    first: Option<usize>,
}

impl Pieces {
    /// Pieces with these numbers of control points. Neighbours share one. On a closed curve, where `first` is the
    /// number of the first control point, the last piece and the first share one, too.
    pub(crate) fn new(degree: usize, control_points: &[usize], first: Option<usize>) -> Self {
        let sums = |each: &dyn Fn(usize) -> usize| {
            let mut sum = 0;
            let ends = control_points.iter().map(|&count| {
                sum += each(count);
                sum
            });
            std::iter::once(0).chain(ends.collect::<Vec<_>>()).collect()
        };
        Self {
            degree,
            functions: sums(&|count| count.max(degree + 1) - 1),
            free: sums(&|count| count - 1),
            plain: control_points.iter().all(|&count| count > degree),
            first,
        }
    }

    /// The number of free control points.
    pub(crate) fn free(&self) -> usize {
        self.free[self.free.len() - 1] + usize::from(self.first.is_none())
    }

    /// The number of the control point at a place behind the first.
    fn number(&self, place: usize) -> usize {
        match self.first {
            None => place,
            Some(first) => (first + place) % self.free(),
        }
    }

    /// Returns true if each function has its own control point.
    pub(crate) fn are_plain(&self) -> bool {
        self.plain && self.first.is_none()
    }

    /// The piece of a function; at a corner the piece that begins there.
    fn piece(&self, function: usize) -> usize {
        let last = self.functions.len() - 2;
        let after = self.functions.partition_point(|&first| first <= function);
        (after - 1).min(last)
    }

    /// The degree to which the control points of a piece belong, where it is raised.
    fn raised(&self, piece: usize) -> Option<usize> {
        let lower = self.free[piece + 1] - self.free[piece];
        (lower < self.degree).then_some(lower)
    }

    /// The control point at a place of a window of functions that begins with `start`, where those of a piece whose
    /// degree is raised are the first in the window ([`Self::share`]).
    pub(crate) fn free_index(&self, function: usize) -> usize {
        let piece = self.piece(function);
        let place = self.free[piece] + function - self.functions[piece];
        self.number(place.min(self.free[piece + 1]))
    }

    /// The control points of which that of a function consists, each with its part.
    pub(crate) fn parts(&self, function: usize) -> Vec<(usize, f64)> {
        let piece = self.piece(function);
        let (first, i) = (self.free[piece], function - self.functions[piece]);
        match self.raised(piece) {
            None => vec![(self.number(first + i), 1.0)],
            Some(lower) => {
                let all = (0..=lower).map(|l| (self.number(first + l), self.part(lower, i, l)));
                all.filter(|(_, part)| *part > 0.0).collect()
            }
        }
    }

    /// The part of control point `l` of degree `lower` in control point `i` of the degree of the curve.
    fn part(&self, lower: usize, i: usize, l: usize) -> f64 {
        let more = self.degree - lower;
        match (l..=l + more).contains(&i) {
            true => binomial(lower, l) * binomial(more, i - l) / binomial(self.degree, i),
            false => 0.0,
        }
    }

    /// Makes values of the functions from `start` on those of control points, in the places of [`Self::free_index`].
    pub(crate) fn share(&self, start: usize, values: &mut [f64]) {
        let piece = self.piece(start);
        let Some(lower) = self.raised(piece) else {
            return;
        };
        let shared = (0..=lower).map(|l| {
            let terms = values.iter().enumerate();
            terms.map(|(i, value)| self.part(lower, i, l) * value).sum()
        });
        let shared: Vec<f64> = shared.collect();
        values.fill(0.0);
        values[..=lower].copy_from_slice(&shared);
    }

    /// The functions whose control points a free one is a part of, in up to two ranges.
    pub(crate) fn functions_of(&self, index: usize) -> [Range<usize>; 2] {
        let place = match self.first {
            None => index,
            Some(first) => (index + self.free() - first) % self.free(),
        };
        let last = self.free.len() - 2;
        let after = self.free.partition_point(|&first| first <= place);
        let piece = (after - 1).min(last);
        let within = |piece: usize, place: usize| {
            let l = place - self.free[piece];
            let more = self.raised(piece).map_or(0, |lower| self.degree - lower);
            self.functions[piece] + l..self.functions[piece] + l + more + 1
        };
        let own = within(piece, place);
        match (piece, self.first) {
            (1.., _) if place == self.free[piece] => {
                [within(piece - 1, place).start..own.end, 0..0]
            }
            (0, Some(_)) if place == 0 => [own, within(last, self.free[last + 1])],
            _ => [own, 0..0],
        }
    }
}

/// The number of the first control point of a closed curve, that of its first corner: control points are numbered as data
/// are.
pub(crate) fn first_number(corner: usize, control_points: usize, data: usize) -> usize {
    corner * control_points / data
}

/// The number of control points of each piece, from the numbers of its data points: two, and a share of all others in
/// proportion to the data points between its ends, larger remainders first. There are at most as many others as those.
pub(crate) fn shares(data: &[usize], others: usize) -> Vec<usize> {
    let between: usize = data.iter().map(|count| count - 2).sum();
    let share = |&count: &usize| (count - 2) * others / between.max(1);
    let mut shares: Vec<usize> = data.iter().map(share).collect();
    let left = others - shares.iter().sum::<usize>();
    let mut order: Vec<usize> = (0..data.len()).collect();
    order.sort_by_key(|&piece| std::cmp::Reverse((data[piece] - 2) * others % between.max(1)));
    order[..left].iter().for_each(|&piece| shares[piece] += 1);
    shares.iter().map(|share| share + 2).collect()
}

/// The number of ways to choose k of n; exact for the degrees that there are.
fn binomial(n: usize, k: usize) -> f64 {
    (0..k).fold(1.0, |product, i| product * (n - i) as f64 / (i + 1) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Five, two and three control points of degree 3.
    #[test]
    fn control_points_of_short_pieces_are_on_their_polynomials() {
        let pieces = Pieces::new(3, &[5, 2, 3], None);
        assert_eq!((pieces.functions[3], pieces.free()), (10, 8));
        assert_eq!(pieces.free, [0, 4, 5, 7]);
        let parts: Vec<Vec<(usize, f64)>> = (0..11).map(|j| pieces.parts(j)).collect();
        let third = 1.0 / 3.0;
        for (j, parts) in parts.iter().take(5).enumerate() {
            assert_eq!(*parts, [(j, 1.0)]);
        }
        // A line in thirds, then a parabola.
        let line = [
            vec![(4, 1.0 - third), (5, third)],
            vec![(4, third), (5, 1.0 - third)],
        ];
        let parabola = [
            vec![(5, third), (6, 1.0 - third)],
            vec![(6, 1.0 - third), (7, third)],
        ];
        for (parts, expected) in parts[5..7]
            .iter()
            .zip(line)
            .chain(parts[8..10].iter().zip(parabola))
        {
            for (part, expected) in parts.iter().zip(expected) {
                assert!(
                    part.0 == expected.0 && (part.1 - expected.1).abs() < 1e-15,
                    "{parts:?}"
                );
            }
        }
        assert_eq!((&parts[7], &parts[10]), (&vec![(5, 1.0)], &vec![(7, 1.0)]));
    }

    /// Shares of the control points of pieces with 11, 2, 5 and 31 data points: 41 between their ends.
    #[test]
    fn control_points_are_shared_by_data_points() {
        let data = [11, 2, 5, 31];
        assert_eq!(shares(&data, 0), [2, 2, 2, 2]);
        assert_eq!(shares(&data, 41), data);
        assert_eq!(shares(&data, 1), [2, 2, 2, 3]);
        // 2.2, 0, .7 and 7.1.
        assert_eq!(shares(&data, 10), [4, 2, 3, 9]);
        assert_eq!(shares(&[2, 2], 0), [2, 2]);
    }

    /// The functions of a control point are those of which it is a part, and windows of functions have its values.
    #[test]
    fn all_ways_to_ask_agree() {
        let counts = [
            vec![2, 2],
            vec![3, 2, 7],
            vec![6, 4, 5],
            vec![2, 9, 3, 3],
            vec![8],
        ];
        let firsts = [None, Some(0), Some(1)];
        for (degree, first) in (1..6).flat_map(|degree| firsts.map(|first| (degree, first))) {
            for counts in &counts {
                let pieces = Pieces::new(degree, counts, first);
                for index in 0..pieces.free() {
                    let of: Vec<usize> = pieces.functions_of(index).into_iter().flatten().collect();
                    assert!(of.is_sorted());
                    for j in 0..=pieces.functions[counts.len()] {
                        let is_part = pieces.parts(j).iter().any(|part| part.0 == index);
                        assert_eq!(of.contains(&j), is_part, "{degree} {counts:?} {index} {j}");
                    }
                }
                for (piece, &start) in pieces.functions[..counts.len()].iter().enumerate() {
                    if pieces.raised(piece).is_none() {
                        continue;
                    }
                    let mut values: Vec<f64> = (0..=degree).map(|i| 0.3 + i as f64).collect();
                    let mut expected = vec![0.0; pieces.free()];
                    for (i, value) in values.iter().enumerate() {
                        for (index, part) in pieces.parts(start + i) {
                            expected[index] += part * value;
                        }
                    }
                    pieces.share(start, &mut values);
                    let mut found = vec![0.0; pieces.free()];
                    for (i, value) in values.iter().enumerate() {
                        found[pieces.free_index(start + i)] += value;
                    }
                    for (found, expected) in found.iter().zip(expected) {
                        assert!((found - expected).abs() < 1e-13);
                    }
                }
            }
        }
    }
}
