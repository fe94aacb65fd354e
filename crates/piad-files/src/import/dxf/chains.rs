//! Joins lines and arcs whose ends meet to curves.

use std::collections::{HashMap, VecDeque};

use crate::import::curves::{Curve, Point, distance, size};

/// Ends meet if they are no further from each other than this part of the size of all pieces.
const RELATIVE_GAP: f64 = 1e-9;

/// The joint at ends that meet no others.
const NOWHERE: usize = usize::MAX;

/// Where ends of pieces meet.
struct Joint {
    point: Point,
    /// The number of ends.
    count: usize,
    /// The pieces of the first two.
    pieces: [usize; 2],
}

/// A piece of a chain, and whether it is passed from its end to its start.
type Link = (usize, bool);

/// Pieces with the joints at their ends.
struct Pieces {
    ends: Vec<[usize; 2]>,
    joints: Vec<Joint>,
}

/// The curves that pieces form, each with the index of its first piece and in the direction of it. They end where other
/// than two pieces meet.
pub(super) fn chains(pieces: Vec<Curve>) -> Vec<(usize, Curve)> {
    let graph = Pieces::of(&pieces);
    let mut pieces: Vec<Option<Curve>> = pieces.into_iter().map(Some).collect();
    let mut passed = vec![false; pieces.len()];
    let mut curves = Vec::new();
    for first in 0..pieces.len() {
        if passed.get(first) == Some(&false) {
            let (links, closed) = graph.chain(first, &mut passed);
            let links = links
                .into_iter()
                .filter_map(|(index, backward)| Some((pieces.get_mut(index)?.take()?, backward)));
            curves.push((first, joined(links, closed)));
        }
    }
    curves
}

impl Pieces {
    fn of(pieces: &[Curve]) -> Self {
        let all = || pieces.iter().flat_map(|piece| &piece.points);
        let near = (RELATIVE_GAP * size(all())).max(f64::MIN_POSITIVE);
        let mut places = Places {
            near,
            cells: HashMap::new(),
            joints: Vec::new(),
        };
        let ends = pieces.iter().enumerate().map(|(index, piece)| {
            match (piece.points.first(), piece.points.last()) {
                (Some(first), Some(last)) if distance(first, last) > near => {
                    [first, last].map(|end| places.joint(*end, index))
                }
                // A closed curve, or a line without a length, which stands between no others.
                _ => [NOWHERE; 2],
            }
        });
        Self {
            ends: ends.collect(),
            joints: places.joints,
        }
    }

    /// The pieces of a chain with this one, and whether it is closed.
    fn chain(&self, first: usize, passed: &mut [bool]) -> (VecDeque<Link>, bool) {
        let mut links = VecDeque::from([(first, false)]);
        if let Some(passed) = passed.get_mut(first) {
            *passed = true;
        }
        let [mut start, mut end] = self.ends.get(first).copied().unwrap_or_default();
        let (mut head, mut tail) = (first, first);
        while let Some((piece, [from, to])) = self.beyond(tail, end, passed) {
            let backward = from != end;
            links.push_back((piece, backward));
            (tail, end) = (piece, if backward { from } else { to });
        }
        while start != end {
            let Some((piece, [from, to])) = self.beyond(head, start, passed) else {
                break;
            };
            let backward = to != start;
            links.push_front((piece, backward));
            (head, start) = (piece, if backward { to } else { from });
        }
        (links, start == end)
    }

    /// The other piece at a joint of two, with its ends, if it was not passed yet; it is from now on.
    fn beyond(
        &self,
        piece: usize,
        joint: usize,
        passed: &mut [bool],
    ) -> Option<(usize, [usize; 2])> {
        let joint = self.joints.get(joint).filter(|joint| joint.count == 2)?;
        let other = joint.pieces.into_iter().find(|it| *it != piece)?;
        let ends = self.ends.get(other)?;
        let passed = passed.get_mut(other).filter(|passed| !**passed)?;
        *passed = true;
        Some((other, *ends))
    }
}

/// Finds joints by position.
struct Places {
    near: f64,
    cells: HashMap<[i64; 3], usize>,
    joints: Vec<Joint>,
}

impl Places {
    /// The joint at a point, at which a piece ends.
    fn joint(&mut self, point: Point, piece: usize) -> usize {
        let index = self.find(&point).unwrap_or_else(|| {
            self.cells.insert(self.cell(&point), self.joints.len());
            self.joints.push(Joint {
                point,
                count: 0,
                pieces: [piece; 2],
            });
            self.joints.len() - 1
        });
        if let Some(joint) = self.joints.get_mut(index) {
            if let Some(place) = joint.pieces.get_mut(joint.count) {
                *place = piece;
            }
            joint.count += 1;
        }
        index
    }

    fn cell(&self, point: &Point) -> [i64; 3] {
        point.map(|x| (x / self.near).floor() as i64)
    }

    /// The joint that a point is near to. It is in its cell or in one of those around.
    fn find(&self, point: &Point) -> Option<usize> {
        let cell = self.cell(point);
        if let Some(index) = self.cells.get(&cell) {
            return Some(*index);
        }
        let around = (0..27).map(|i| [i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1]);
        let mut found = around.filter_map(|step: [i64; 3]| {
            let mut cell = cell;
            for (x, step) in cell.iter_mut().zip(step) {
                *x = x.saturating_add(step);
            }
            self.cells.get(&cell).copied()
        });
        found.find(|index| {
            let joint = self.joints.get(*index);
            joint.is_some_and(|joint| distance(&joint.point, point) <= self.near)
        })
    }
}

/// Pieces as one curve.
fn joined(links: impl Iterator<Item = (Curve, bool)>, closed: bool) -> Curve {
    let mut curve = Curve::new(None);
    for (mut piece, backward) in links {
        if backward {
            piece.points.reverse();
            piece.lines.reverse();
        }
        // The joint is there already.
        let joint = usize::from(!curve.points.is_empty());
        curve.points.extend(piece.points.iter().skip(joint));
        curve.lines.extend(piece.lines.iter().skip(joint));
        if curve.notices.is_empty() {
            curve.notices = piece.notices;
        }
    }
    if closed && curve.points.len() > 3 {
        curve.points.pop();
        curve.lines.pop();
        curve.closed = true;
    }
    curve
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(a: [f64; 2], b: [f64; 2]) -> Curve {
        let mut curve = Curve::new(None);
        for [x, y] in [a, b] {
            curve.push([x, y, 0.0], 1);
        }
        curve
    }

    fn found(pieces: &[[f64; 4]]) -> Vec<(usize, Vec<f64>, bool)> {
        let lines = pieces.iter().map(|[a, b, c, d]| line([*a, *b], [*c, *d]));
        let chains = chains(lines.collect()).into_iter();
        chains
            .map(|(first, curve)| {
                let xs = curve.points.iter().map(|point| point[0] + 10.0 * point[1]);
                (first, xs.collect(), curve.closed)
            })
            .collect()
    }

    #[test]
    fn lines_join_at_their_ends() {
        // In any order and direction, with ends that differ by rounding.
        let open = [
            [2.0, 0.0, 3.0, 0.0],
            [1.0, 0.0, 2.0, 1e-10],
            [7.0, 1.0, 8.0, 1.0],
            [4.0, -1e-10, 3.0, 0.0],
            [0.0, 0.0, 1.0, 0.0],
        ];
        let chains = found(&open);
        assert_eq!(chains.len(), 2);
        assert_eq!((chains[0].0, chains[1].0), (0, 2));
        assert_eq!(chains[0].1.len(), 5);
        assert!(chains[0].1.is_sorted() && !chains[0].2);
        let square = [
            [0.0, 0.0, 1.0, 0.0],
            [1.0, 1.0, 1.0, 0.0],
            [0.0, 1.0, 1.0, 1.0],
            [0.0, 0.0, 0.0, 1.0],
        ];
        assert_eq!(found(&square), [(0, vec![0.0, 1.0, 11.0, 10.0], true)]);
    }

    #[test]
    fn forks_end_curves() {
        let fork = [
            [0.0, 0.0, 1.0, 0.0],
            [1.0, 0.0, 2.0, 0.0],
            [1.0, 0.0, 1.0, 1.0],
        ];
        assert_eq!(found(&fork).len(), 3);
        // Lines that are there twice, and one without a length.
        let twice = [[0.0, 0.0, 1.0, 0.0]; 2];
        assert_eq!(found(&twice), [(0, vec![0.0, 1.0, 0.0], false)]);
        let point = [[0.5, 0.0, 0.5, 0.0], [0.0, 0.0, 1.0, 0.0]];
        assert_eq!(found(&point).len(), 2);
        let between = [
            [0.0, 0.0, 1.0, 0.0],
            [1.0, 0.0, 1.0, 0.0],
            [1.0, 0.0, 2.0, 0.0],
        ];
        assert_eq!(found(&between)[0], (0, vec![0.0, 1.0, 2.0], false));
        assert_eq!(found(&[]), []);
    }
}
