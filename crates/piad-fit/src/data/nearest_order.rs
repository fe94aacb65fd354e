//! Sorts unordered points along their curve.
//!
//! The shortest tree that connects all points (Prim 1957) runs along a curve that is sampled well enough: its longest path is
//! the order. Points beside the path, as noise has them, come before or after the point of the path that they hang on,
//! whichever is nearer. Where a branch is longer than that, the points are not those of one curve.

use super::points::Points;

/// The most points: the tree compares each point with each other one.
pub(crate) const MOST_POINTS: usize = 20_000;

/// The most points of a branch off the path.
const LONGEST_BRANCH: usize = 2;

/// The tree branches at a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Branch {
    pub point: usize,
}

/// The indices of points in the order along their curve, from the end of it that has the lower index. O(n²).
pub(crate) fn nearest_order(points: &Points) -> Result<Vec<usize>, Branch> {
    let tree = Tree::shortest(points);
    let path = tree.longest_path();
    let mut on_path = vec![false; points.len()];
    path.iter().for_each(|&it| on_path[it] = true);
    let mut order = Vec::with_capacity(points.len());
    for (place, &point) in path.iter().enumerate() {
        let beside = tree.beside(point, &on_path);
        let mut after = Vec::new();
        for branch in beside {
            if branch.len() > LONGEST_BRANCH {
                return Err(Branch { point });
            }
            let to = |neighbour: Option<usize>| {
                let other = neighbour.and_then(|it| path.get(it));
                other.map_or(f64::INFINITY, |&other| points.distance(branch[0], other))
            };
            match to(place.checked_sub(1)) < to(Some(place + 1)) {
                true => order.extend(branch.iter().rev()),
                false => after.extend(branch),
            }
        }
        order.push(point);
        order.extend(after);
    }
    Ok(order)
}

/// A tree that connects points.
struct Tree<'a> {
    points: &'a Points,
    neighbours: Vec<Vec<usize>>,
}

impl<'a> Tree<'a> {
    /// The one with the least sum of distances.
    fn shortest(points: &'a Points) -> Self {
        let count = points.len();
        let mut neighbours = vec![Vec::new(); count];
        let mut nearest = vec![(f64::INFINITY, 0); count];
        let mut outside: Vec<usize> = (1..count).collect();
        let mut last = 0;
        while !outside.is_empty() {
            let mut best = 0;
            for (place, &point) in outside.iter().enumerate() {
                let distance = points.distance(last, point);
                if distance < nearest[point].0 {
                    nearest[point] = (distance, last);
                }
                if nearest[point].0 < nearest[outside[best]].0 {
                    best = place;
                }
            }
            last = outside.swap_remove(best);
            let (_, parent) = nearest[last];
            neighbours[parent].push(last);
            neighbours[last].push(parent);
        }
        Self { points, neighbours }
    }

    /// The longest path, from its end with the lower index.
    fn longest_path(&self) -> Vec<usize> {
        let (start, _) = self.farthest(0);
        let (end, parents) = self.farthest(start);
        let mut path = vec![end];
        while let Some(parent) = path.last().and_then(|&it| parents[it]) {
            path.push(parent);
        }
        if path[0] > path[path.len() - 1] {
            path.reverse();
        }
        path
    }

    /// The point that is farthest from another one along the tree, and for each point the one before it on its path.
    fn farthest(&self, from: usize) -> (usize, Vec<Option<usize>>) {
        let mut parents = vec![None; self.neighbours.len()];
        let (mut most, mut end) = (0.0, from);
        let mut left = vec![(from, 0.0)];
        while let Some((point, length)) = left.pop() {
            if length > most {
                (most, end) = (length, point);
            }
            for &next in &self.neighbours[point] {
                if parents[point] != Some(next) {
                    parents[next] = Some(point);
                    left.push((next, length + self.points.distance(point, next)));
                }
            }
        }
        (end, parents)
    }

    /// The branches that hang on a point of the path, each from the path outwards.
    fn beside(&self, point: usize, on_path: &[bool]) -> Vec<Vec<usize>> {
        let starts = self.neighbours[point].iter().filter(|&&it| !on_path[it]);
        let branch = |&start: &usize| {
            let mut branch = vec![start];
            let mut place = 0;
            while let Some(&at) = branch.get(place) {
                let next = self.neighbours[at].iter().copied();
                let next: Vec<usize> = next
                    .filter(|it| !on_path[*it] && !branch.contains(it))
                    .take(LONGEST_BRANCH + 1)
                    .collect();
                branch.extend(next);
                if branch.len() > LONGEST_BRANCH {
                    break;
                }
                place += 1;
            }
            branch
        };
        starts.map(branch).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points of a spiral, each with some noise, mixed by steps of 7/20 of their number, with which it shares no factor.
    fn spiral(count: usize, noise: f64) -> (Points, Vec<usize>) {
        let mixed: Vec<usize> = (0..count)
            .map(|i| i * (7 * count / 20 + 1) % count)
            .collect();
        let mut points = Points::new(2);
        for &i in &mixed {
            let t = 1.0 + i as f64 / count as f64 * 5.0;
            let out = t + noise * ((i * 7919 % 101) as f64 / 101.0 - 0.5);
            points.push(&[out * t.cos(), out * t.sin()]);
        }
        (points, mixed)
    }

    #[test]
    fn mixed_points_come_into_order() {
        for (count, noise) in [(53, 0.0), (200, 0.0), (201, 0.02), (1999, 0.005)] {
            let (points, mixed) = spiral(count, noise);
            let order = nearest_order(&points).unwrap();
            let mut found: Vec<usize> = order.iter().map(|&it| mixed[it]).collect();
            if found[0] > found[count - 1] {
                found.reverse();
            }
            // With noise, neighbours can change places.
            let off = found
                .iter()
                .enumerate()
                .map(|(i, &it)| it.abs_diff(i))
                .max();
            assert!(
                off.unwrap() <= if noise > 0.0 { 2 } else { 0 },
                "{count} {noise}: {off:?}"
            );
        }
    }

    #[test]
    fn few_points_and_branches() {
        let line = Points::from_flat(1, &[3.0, 1.0, 2.0]);
        assert_eq!(nearest_order(&line), Ok(vec![0, 2, 1]));
        assert_eq!(nearest_order(&Points::from_flat(1, &[3.0])), Ok(vec![0]));
        let arm = |k: usize, x: f64, y: f64| [x * k as f64, y * k as f64];
        let star = (1..6).flat_map(|k| [arm(k, 1.0, 0.0), arm(k, 0.0, 1.0), arm(k, -1.0, 0.0)]);
        let star: Vec<f64> = [[0.0, 0.0]].into_iter().chain(star).flatten().collect();
        let star = Points::from_flat(2, &star);
        assert_eq!(nearest_order(&star), Err(Branch { point: 0 }));
    }
}
