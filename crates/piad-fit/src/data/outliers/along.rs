//! Outliers of a curve: points compared with those before and behind them.
//!
//! A point is expected where any of these polynomials of its neighbours is:
//!
//! - the cubic through the two on either side, which follows a curve that is sampled coarsely;
//! - the parabola nearest to the five on either side, which averages noise;
//! - the straight lines through the two before it, or behind it, and along the five there, which reach up to corners.
//!
//! It is off by its distance from the nearest of them. The doubt is the distance between the cubic and the chord
//! between the neighbours, which is large where samples are coarse.

use super::{Combination, Neighbourhood, apart, fitted, median};
use crate::data::aligned::Lane;
use crate::data::points::Points;

/// The number of neighbours used on either side.
const NEAREST: usize = 5;

/// Neighbours are searched at most this number of places away.
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

/// A point, which is at place zero, and its neighbours.
struct Site<'a> {
    points: &'a Points,
    index: usize,
    before: Vec<Neighbour>,
    behind: Vec<Neighbour>,
}

/// A neighbour, and its position along the curve from the compared point.
#[derive(Clone, Copy)]
struct Neighbour {
    index: usize,
    place: f64,
}

impl Along<'_> {
    /// The nearest neighbours on one side that are not left out, in steps of 1 or -1.
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

    /// A point and its neighbours.
    fn site(&self, index: usize, is_left_out: &[bool]) -> Site<'_> {
        let [before, behind] = [-1, 1].map(|step| self.side(index, step, is_left_out));
        let [before, behind] = self.placed(index, &before, &behind);
        Site {
            points: self.points,
            index,
            before,
            behind,
        }
    }

    /// The positions of neighbours along the curve.
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
            // An outlier is still between its neighbours.
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
}

impl Neighbourhood for Along<'_> {
    const DOUBT: f64 = 4.0;

    fn count(&self) -> usize {
        self.points.len()
    }

    fn off(&self, index: usize, is_left_out: &[bool]) -> Option<f64> {
        let site = self.site(index, is_left_out);
        let off = site.off()?;
        let nearer = site.nearer().and_then(|site| site.off());
        Some(nearer.map_or(off, |nearer| off.min(nearer)))
    }

    fn doubt(&self, index: usize, is_left_out: &[bool]) -> f64 {
        let site = self.site(index, is_left_out);
        site.nearer().unwrap_or(site).doubt()
    }
}

impl Site<'_> {
    /// The distance of the point from the nearest prediction of its neighbours; `None` if there are too few.
    fn off(&self) -> Option<f64> {
        let through = interpolated(&nearest(&self.before, &self.behind)?);
        let all: Vec<Neighbour> = self.before.iter().chain(&self.behind).copied().collect();
        let combined = parabola(&all).into_iter().chain([through]);
        let combined = combined.map(|it| apart(self.points, self.index, &it, &[]));
        let sides = [&self.before, &self.behind].into_iter();
        let sides = sides.filter(|side| side.len() > 1);
        let lines = sides.flat_map(|side| [&side[..2], side]).map(|side| {
            let line = line(self.points, self.index, side);
            line.into_iter().fold(0.0, f64::hypot)
        });
        Some(combined.chain(lines).fold(f64::INFINITY, f64::min))
    }

    /// The distance of the chord between the neighbours beside the point from the cubic. One of the neighbours may be
    /// wrong: most choices do not include it, so the third least doubt is that of a choice without it.
    fn doubt(&self) -> f64 {
        let doubt = |before: &[Neighbour], behind: &[Neighbour]| {
            let all = nearest(before, behind)?;
            let chord = match (before, behind) {
                ([first, ..], [last, ..]) => [*first, *last],
                _ => [all[0], all[1]],
            };
            let (cubic, chord) = (interpolated(&all), interpolated(&chord));
            Some(apart(self.points, self.index, &cubic, &chord))
        };
        let own = doubt(&self.before, &self.behind).unwrap_or(0.0);
        let mut doubts: Vec<f64> = choices(&self.before, &self.behind)
            .filter_map(|(before, behind)| doubt(&before, &behind))
            .collect();
        doubts.sort_by(f64::total_cmp);
        doubts.get(2).map_or(own, |third| own.min(*third))
    }

    /// The same site, for an end, moved to be no further from its neighbours than they are from each other, as an
    /// outlier is displaced from the curve. `None` if it is no end.
    fn nearer(&self) -> Option<Self> {
        let by = match (&self.before[..], &self.behind[..]) {
            ([], [a, b, ..]) => (b.place - a.place).min(a.place) - a.place,
            ([a, b, ..], []) => (b.place - a.place).max(a.place) - a.place,
            _ => return None,
        };
        let moved = |side: &[Neighbour]| {
            let moved = side.iter().map(|it| Neighbour {
                place: it.place + by,
                ..*it
            });
            moved.collect()
        };
        Some(Self {
            before: moved(&self.before),
            behind: moved(&self.behind),
            ..*self
        })
    }
}

/// Two neighbours on either side, or three at an end; `None` if there are fewer.
fn nearest(before: &[Neighbour], behind: &[Neighbour]) -> Option<Vec<Neighbour>> {
    match (before, behind) {
        ([], side) | (side, []) => Some(side.first_chunk::<3>()?.to_vec()),
        _ => Some(
            before
                .iter()
                .take(2)
                .chain(behind.iter().take(2))
                .copied()
                .collect(),
        ),
    }
}

/// Each two of three neighbours on either side; at an end each three of five.
fn choices(
    before: &[Neighbour],
    behind: &[Neighbour],
) -> impl Iterator<Item = (Vec<Neighbour>, Vec<Neighbour>)> {
    let sides = match (before, behind) {
        ([], side) => [vec![Vec::new()], subsets(side, 5, 3)],
        (side, []) => [subsets(side, 5, 3), vec![Vec::new()]],
        _ => [subsets(before, 3, 2), subsets(behind, 3, 2)],
    };
    let [before, behind] = sides;
    before.into_iter().flat_map(move |before| {
        let behind = behind.clone().into_iter();
        behind.map(move |behind| (before.clone(), behind))
    })
}

/// All choices of `count` among the first `of` neighbours; none if there are fewer.
fn subsets(side: &[Neighbour], of: usize, count: usize) -> Vec<Vec<Neighbour>> {
    let first = side.get(..of).unwrap_or_default();
    let all = (0..1_usize << first.len()).filter(|set| set.count_ones() as usize == count);
    let chosen = all.map(|set| {
        let members = first.iter().enumerate();
        let members = members.filter(|(k, _)| set >> k & 1 == 1);
        members.map(|(_, it)| *it).collect()
    });
    chosen.collect()
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

/// The parabola nearest to neighbours, at place zero; `None` if there are hardly more than three.
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
