//! Points along a curve, compared with those before and behind them.
//!
//! A point may be where any of these polynomials of its neighbours is:
//!
//! - the cubic through the two on either side, which follows a curve that is sampled coarsely;
//! - the parabola nearest to the five on either side, which averages noise;
//! - the straight lines through the two before it, or behind it, and along the five there, which reach up to corners.
//!
//! It is off by its distance from the nearest of them. The cubic and the chord between the neighbours disagree where
//! samples are coarse: that is the doubt.

use super::{Combination, Comparison, Neighbourhood, apart, fitted, median};
use crate::data::aligned::Lane;
use crate::data::points::Points;

/// How many neighbours on either side are looked at.
const NEAREST: usize = 5;

/// Neighbours are looked for no further away than this number of places.
const REACH: usize = 64;

/// The points of a curve.
pub(crate) struct Along<'a> {
    /// In their order.
    pub points: &'a Points,
    /// Their parameters, if they are given: of a closed curve also the end of its period. Otherwise they are distances.
    pub parameters: Option<&'a [f64]>,
    /// True if the first point follows the last one.
    pub closed: bool,
}

/// A neighbour, and where it is along the curve from the point that is compared.
#[derive(Clone, Copy)]
struct Neighbour {
    index: usize,
    place: f64,
}

impl Along<'_> {
    /// The nearest neighbours that are not left out on one side, in steps of 1 or -1.
    fn side(&self, index: usize, step: isize, is_left_out: &[bool]) -> Vec<usize> {
        let count = self.points.len() as isize;
        let reach = (count / 2).min(REACH as isize);
        let places = (1..=reach).map(|k| index as isize + step * k);
        let indices = places.filter_map(|place| match self.closed {
            true => Some(place.rem_euclid(count) as usize),
            false => (0..count).contains(&place).then_some(place as usize),
        });
        indices
            .filter(|&index| !is_left_out[index])
            .take(NEAREST)
            .collect()
    }

    /// Where neighbours are along the curve.
    fn placed(&self, index: usize, before: &[usize], behind: &[usize]) -> [Vec<Neighbour>; 2] {
        if self.parameters.is_some() || self.points.dimension() == 1 {
            let side = |indices: &[usize], sign: f64| {
                let place = |&other: &usize| Neighbour {
                    index: other,
                    place: sign * self.step(index, other, sign),
                };
                indices.iter().map(place).collect()
            };
            return [side(before, -1.0), side(behind, 1.0)];
        }
        let distance = |i: usize, j: usize| self.points.distance(i, j);
        let nearest = |side: &[usize]| side.first().map_or(0.0, |&it| distance(it, index));
        let [mut back, mut ahead] = [before, behind].map(nearest);
        if let (Some(&first), Some(&last)) = (before.first(), behind.first())
            && back + ahead > 0.0
        {
            // An outlier is between its neighbours all the same.
            let part = distance(first, last) / (back + ahead);
            (back, ahead) = (back * part, ahead * part);
        }
        let side = |indices: &[usize], mut place: f64, sign: f64| {
            let mut last = indices.first().copied();
            let mut neighbour = |&index: &usize| {
                place += last.map_or(0.0, |last| distance(last, index));
                last = Some(index);
                Neighbour {
                    index,
                    place: sign * place,
                }
            };
            indices.iter().map(&mut neighbour).collect()
        };
        [side(before, back, -1.0), side(behind, ahead, 1.0)]
    }

    /// How far another point is ahead by parameters, or by numbers of points.
    fn step(&self, index: usize, other: usize, sign: f64) -> f64 {
        let count = self.points.len();
        let (from, to, period) = match self.parameters {
            Some(t) => (t[index], t[other], t[t.len() - 1] - t[0]),
            None => (index as f64, other as f64, count as f64),
        };
        match sign * (to - from) {
            ahead if ahead < 0.0 => ahead + period,
            ahead => ahead,
        }
    }

    /// The cubic through two neighbours on either side, at an end the parabola through three; and how far the chord of those
    /// beside the point is from it.
    fn narrow(
        &self,
        index: usize,
        before: &[Neighbour],
        behind: &[Neighbour],
    ) -> Option<(Combination, f64)> {
        let (nearest, chord) = match (before, behind) {
            ([], [a, b, c, ..]) | ([a, b, c, ..], []) => (vec![*a, *b, *c], [*a, *b]),
            ([a, ..], [b, ..]) => {
                let sides = before.iter().take(2).chain(behind.iter().take(2));
                (sides.copied().collect(), [*a, *b])
            }
            _ => return None,
        };
        let through = interpolated(&nearest);
        let doubt = apart(self.points, index, &through, &interpolated(&chord));
        Some((through, doubt))
    }
}

impl Along<'_> {
    /// Compares a point with its neighbours at these places.
    fn compared(
        &self,
        index: usize,
        before: &[Neighbour],
        behind: &[Neighbour],
    ) -> Option<Comparison> {
        let (through, mut doubt) = self.narrow(index, before, behind)?;
        // One of the three neighbours on either side may be wrong: by most pairs of them the doubt is at least the third.
        let sides =
            pairs(before).flat_map(|before| pairs(behind).map(move |behind| (before, behind)));
        let others = sides.filter_map(|(before, behind)| self.narrow(index, &before, &behind));
        let mut doubts: Vec<f64> = others.map(|(_, doubt)| doubt).collect();
        doubts.sort_by(f64::total_cmp);
        if let Some(third) = doubts.get(2) {
            doubt = doubt.min(*third);
        }
        let all: Vec<Neighbour> = before.iter().chain(behind).copied().collect();
        let sides = [before, behind].into_iter().filter(|side| side.len() > 1);
        let lines = sides.flat_map(|side| [&side[..2], side]);
        let off_lines = lines.map(|side| {
            let line = line(self.points, index, side);
            line.into_iter().fold(0.0, f64::hypot)
        });
        let combined = parabola(&all).into_iter().chain([through]);
        let off = combined.map(|it| apart(self.points, index, &it, &[]));
        Some(Comparison {
            off: off.chain(off_lines).fold(f64::INFINITY, f64::min),
            doubt,
        })
    }
}

impl Neighbourhood for Along<'_> {
    const DOUBT: f64 = 4.0;

    fn count(&self) -> usize {
        self.points.len()
    }

    fn compare(&self, index: usize, is_left_out: &[bool]) -> Option<Comparison> {
        let before = self.side(index, -1, is_left_out);
        let behind = self.side(index, 1, is_left_out);
        let [before, behind] = self.placed(index, &before, &behind);
        let comparison = self.compared(index, &before, &behind)?;
        let nearer = match (&before[..], &behind[..]) {
            ([], [a, b, ..]) => (b.place - a.place).min(a.place) - a.place,
            ([a, b, ..], []) => (b.place - a.place).max(a.place) - a.place,
            _ => return Some(comparison),
        };
        // An end that is an outlier is not as far along the curve as it is away.
        let moved = |side: &[Neighbour]| -> Vec<Neighbour> {
            let moved = side.iter().map(|it| Neighbour {
                place: it.place + nearer,
                ..*it
            });
            moved.collect()
        };
        let nearer = self.compared(index, &moved(&before), &moved(&behind))?;
        Some(Comparison {
            off: comparison.off.min(nearer.off),
            doubt: nearer.doubt,
        })
    }
}

/// Each two of the three nearest neighbours on one side; none if there are fewer.
fn pairs(side: &[Neighbour]) -> impl Iterator<Item = [Neighbour; 2]> + '_ {
    let three = side.first_chunk::<3>();
    three
        .into_iter()
        .flat_map(|[a, b, c]| [[*a, *b], [*a, *c], [*b, *c]])
}

/// The polynomial through neighbours, at place zero.
fn interpolated(neighbours: &[Neighbour]) -> Combination {
    let factor = |it: &Neighbour| {
        let others = neighbours.iter().filter(|other| other.index != it.index);
        let parts = others.map(|other| other.place / (other.place - it.place));
        (it.index, parts.product())
    };
    neighbours.iter().map(factor).collect()
}

/// The straight line along neighbours of which one or two can be wrong, at place zero: the median of the slopes between each
/// two of them leads to it (Theil 1950, Sen 1968). Relative to point `index`, for each coordinate.
fn line(points: &Points, index: usize, neighbours: &[Neighbour]) -> Vec<f64> {
    let along = |lane: &Lane| {
        let value = |it: &Neighbour| lane[it.index] - lane[index];
        let rest = |i: usize| neighbours[i + 1..].iter();
        let all = neighbours.iter().enumerate();
        let slopes = all
            .flat_map(|(i, a)| rest(i).map(move |b| (value(b) - value(a)) / (b.place - a.place)));
        let slope = median(slopes.filter(|it| it.is_finite()).collect());
        median(
            neighbours
                .iter()
                .map(|it| value(it) - slope * it.place)
                .collect(),
        )
    };
    points.lanes().iter().map(along).collect()
}

/// The parabola nearest to neighbours, at place zero; `None` of hardly more than three.
fn parabola(neighbours: &[Neighbour]) -> Option<Combination> {
    let largest = neighbours
        .iter()
        .map(|it| it.place.abs())
        .fold(0.0, f64::max);
    let powers = |it: &Neighbour| {
        let s = it.place / largest;
        (it.index, [1.0, s, s * s])
    };
    let is_enough = neighbours.len() > NEAREST;
    is_enough.then(|| fitted(neighbours.iter().map(powers)))?
}
