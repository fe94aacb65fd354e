//! Surfaces: whole knot lines, in the direction that gains more.
//!
//! Least squares of a grid by a tensor-product surface are those of its lines, one direction after
//! the other: `X = L_u P L_vᵀ`. With the projections Π_u and Π_v onto the splines of each direction
//!
//! ```text
//! P − Π_u Π_v P = (P − Π_u P) + Π_u (P − Π_v P)
//! ```
//!
//! so what either direction leaves is known by itself, and each has a density of knots of its own:
//! that of a curve in as many dimensions as there are lines across. The corners are interpolated,
//! and each boundary is the fit of the data there, whatever lies inside.

use std::collections::VecDeque;
use std::sync::Arc;

use super::Phase;
use super::equations::{Distances, LeastSquares, Minimum};
use super::growth::grown;
use super::insertion::refine;
use super::line::KnotLine;
use super::monitor::{Monitor, needed, span_maxima};
use super::placement::place;
use super::values::Values;
use crate::fit::outcome::Outcome;
use crate::fit::points::{Grid, Points};
use crate::fit::scaling::normalizing_scale;

/// Both directions together may leave the tolerance: each about this part of it.
const SHARE: f64 = 0.6;

/// Redistributions of an attempt.
const TRIES: usize = 5;

/// Attempts after growth.
const ATTEMPTS: usize = 40;

/// How far knots go towards equal distances.
const DAMPING: f64 = 0.7;

/// A grid of data, and what is asked for.
#[derive(Clone, Debug)]
pub struct Request {
    /// The data, row by row.
    pub points: Arc<Points>,
    /// Their arrangement; rows are successive in u.
    pub grid: Grid,
    /// Increasing parameters in u and in v.
    pub parameters: [Arc<Vec<f64>>; 2],
    /// The degrees in u and in v.
    pub degrees: [usize; 2],
    /// The largest distance that is accepted, in data units.
    pub tolerance: f64,
}

/// A surface on the way.
#[derive(Clone, Debug)]
pub struct SurfaceLevel {
    /// What was done since the level before.
    pub phase: Phase,
    /// The knots in u and in v.
    pub lines: [KnotLine; 2],
    /// The control points, row by row.
    pub control_points: Points,
    /// The distances from the data.
    pub distances: Distances,
}

impl SurfaceLevel {
    /// The number of control points.
    pub fn count(&self) -> usize {
        self.lines[0].control_points() * self.lines[1].control_points()
    }
}

/// A least-squares surface, and which density of knots each direction asks for.
struct Fit {
    level: SurfaceLevel,
    /// For each direction, the largest distance that it leaves at each parameter.
    left: [Vec<f64>; 2],
}

/// A surface with as few control points as its tolerance needs, level by level.
#[derive(Debug)]
pub struct SurfaceSchedule {
    request: Request,
    /// The data as curves in u and in v, with a coordinate for each coordinate of each line across.
    curves: [Arc<Points>; 2],
    queue: VecDeque<Arc<SurfaceLevel>>,
    last: Option<Arc<SurfaceLevel>>,
    best: Option<Arc<SurfaceLevel>>,
    closest: Option<Arc<SurfaceLevel>>,
    outcome: Option<Outcome>,
}

impl SurfaceSchedule {
    /// Fits a grid with more data than the degree in each direction: all levels at once.
    pub fn new(request: Request) -> Self {
        let Grid { rows, columns } = request.grid;
        let v = lines_of(&request.points, rows, columns);
        let u = lines_of(&transposed(&request.points, rows, columns), columns, rows);
        let mut schedule = Self {
            request,
            curves: [Arc::new(u), Arc::new(v)],
            queue: VecDeque::new(),
            last: None,
            best: None,
            closest: None,
            outcome: None,
        };
        schedule.run();
        schedule
    }

    /// How it has ended.
    pub fn outcome(&self) -> Option<Outcome> {
        self.outcome
    }

    /// The next level, or `None` after the last one.
    pub fn next_level(&mut self) -> Option<Arc<SurfaceLevel>> {
        self.queue.pop_front()
    }

    /// Growth, then attempts with fewer lines of control points.
    fn run(&mut self) {
        if let Some(fit) = self.grow()
            && self.best.is_some()
        {
            self.search(fit);
        }
        let end = self.best.clone().or_else(|| self.closest.clone());
        if let (Some(end), Some(last)) = (end, &self.last)
            && !Arc::ptr_eq(&end, last)
        {
            self.queue.push_back(Arc::new(SurfaceLevel {
                phase: Phase::Result,
                ..SurfaceLevel::clone(&end)
            }));
        }
        self.outcome = Some(match self.best {
            Some(_) => Outcome::Converged,
            None => Outcome::Stationary,
        });
    }

    /// Inserts knots until the surface is within the tolerance; `None` if there is no fit at all.
    fn grow(&mut self) -> Option<Fit> {
        let coarsest = |axis: usize| {
            let t = &self.request.parameters[axis];
            KnotLine::coarsest(self.request.degrees[axis], false, t[0], t[t.len() - 1])
        };
        let mut lines = [coarsest(0)?, coarsest(1)?];
        let mut fit = self.fit(Phase::Steps, lines.clone())?;
        self.issue(fit.level.clone());
        while fit.level.distances.max > self.request.tolerance {
            let Some((axis, line)) = self.finer(&fit) else {
                return Some(fit);
            };
            let last = self.last.clone()?;
            let control_points = refined(&last, axis, &line);
            lines[axis] = line;
            let inserted = self.level(Phase::Insertion, lines.clone(), control_points);
            let before = inserted.distances.max;
            self.issue(inserted);
            fit = self.fit(Phase::Steps, lines.clone())?;
            if fit.level.distances.max <= before {
                self.issue(fit.level.clone());
            }
        }
        Some(fit)
    }

    /// More knots in the direction that leaves more, or else in the other one.
    fn finer(&self, fit: &Fit) -> Option<(usize, KnotLine)> {
        let most = |axis: usize| fit.left[axis].iter().copied().fold(0.0, f64::max);
        let first = usize::from(most(1) > most(0));
        [first, 1 - first].into_iter().find_map(|axis| {
            let t = &self.request.parameters[axis];
            let share = SHARE * self.request.tolerance;
            let line = &fit.level.lines[axis];
            grown(line, t, &fit.left[axis], share, t.len()).map(|line| (axis, line))
        })
    }

    /// Attempts with fewer lines, until neither direction can spare one.
    fn search(&mut self, fit: Fit) {
        let count = |fit: &Fit, axis: usize| fit.level.lines[axis].control_points();
        let share = SHARE * self.request.tolerance;
        let asked = [0, 1].map(|axis| {
            let line = &fit.level.lines[axis];
            let starts = line.starts(&self.request.parameters[axis]);
            let asked = needed(line, &span_maxima(&starts, &fit.left[axis]), share);
            asked.clamp(line.degree() + 1, line.control_points())
        });
        let mut within = fit;
        // For each direction, from where a line less has failed.
        let mut failed = [[0, 0]; 2];
        if asked != [count(&within, 0), count(&within, 1)] {
            match self.attempt(&within, asked) {
                Some(fit) => within = fit,
                // In between, where the estimate is too low.
                None => {
                    let middle = [0, 1].map(|axis| asked[axis].midpoint(count(&within, axis)));
                    within = self.attempt(&within, middle).unwrap_or(within);
                }
            }
        }
        for _ in 0..ATTEMPTS {
            let now = [count(&within, 0), count(&within, 1)];
            // A line of u has as many control points as there are lines of v.
            let first = usize::from(now[0] > now[1]);
            let spare = |axis: &usize| {
                let fewest = self.request.degrees[*axis] + 1;
                now[*axis] > fewest && failed[*axis] != now
            };
            let Some(axis) = [first, 1 - first].into_iter().find(spare) else {
                break;
            };
            let mut fewer = now;
            fewer[axis] -= 1;
            match self.attempt(&within, fewer) {
                Some(fit) => within = fit,
                None => failed[axis] = now,
            }
        }
    }

    /// Redistributes so many lines until the surface is within the tolerance.
    fn attempt(&mut self, from: &Fit, counts: [usize; 2]) -> Option<Fit> {
        let mut monitors = self.monitors(from, 1.0);
        let mut lowest = f64::INFINITY;
        for _ in 0..TRIES {
            let place = |axis: usize| {
                place(
                    &monitors[axis],
                    &self.request.parameters[axis],
                    counts[axis],
                )
            };
            let lines = [place(0)?, place(1)?];
            let before = self.last.as_ref().map_or(0, |last| last.count());
            let phase = if counts[0] * counts[1] < before {
                Phase::Removal
            } else {
                Phase::Redistribution
            };
            let fit = self.fit(phase, lines)?;
            let largest = fit.level.distances.max;
            if largest < lowest {
                lowest = largest;
                self.issue(fit.level.clone());
            }
            if largest <= self.request.tolerance {
                return Some(fit);
            }
            monitors = self.monitors(&fit, DAMPING);
        }
        None
    }

    /// What each direction asks for.
    fn monitors(&self, fit: &Fit, damping: f64) -> [Monitor; 2] {
        [0, 1].map(|axis| {
            let line = &fit.level.lines[axis];
            let starts = line.starts(&self.request.parameters[axis]);
            Monitor::new(line, &starts, &fit.left[axis], damping)
        })
    }

    /// The least-squares surface over some knots, if the data determine it.
    fn fit(&self, phase: Phase, lines: [KnotLine; 2]) -> Option<Fit> {
        let Grid { columns, .. } = self.request.grid;
        let dimension = self.request.points.dimension();
        let (along, left_u) = self.project(0, &lines[0])?;
        let (_, left_v) = self.project(1, &lines[1])?;
        // The control points of all lines in u, as curves in v.
        let rows = lines[0].control_points();
        let between = joined(&along, dimension, columns, rows);
        let curves = Arc::new(lines_of(
            &transposed(&between, columns, rows),
            rows,
            columns,
        ));
        let values = Values::new(&lines[1], &self.request.parameters[1]);
        let least_squares = LeastSquares {
            points: curves,
            data_weights: None,
        };
        let across = least_squares.minimum(&lines[1], &values, None)?;
        let control_points = joined(&across, dimension, rows, lines[1].control_points());
        Some(Fit {
            level: self.level(phase, lines, control_points),
            left: [left_u, left_v],
        })
    }

    /// The fits of all lines of a direction, and the largest distance that they leave at each
    /// parameter.
    fn project(&self, axis: usize, line: &KnotLine) -> Option<(Points, Vec<f64>)> {
        let (points, t) = (&self.curves[axis], &self.request.parameters[axis]);
        let values = Values::new(line, t);
        let least_squares = LeastSquares {
            points: Arc::clone(points),
            data_weights: None,
        };
        let fits = least_squares.minimum(line, &values, None)?;
        let dimension = self.request.points.dimension();
        let lines = points.dimension() / dimension;
        let mut left = vec![0.0; t.len()];
        let mut fit = vec![0.0; t.len()];
        for k in 0..lines {
            let mut distances = vec![0.0; t.len()];
            for c in 0..dimension {
                values.apply(line, fits.lane(c * lines + k), &mut fit);
                let pairs = fit.iter().zip(points.lane(c * lines + k));
                for (sum, (fit, datum)) in distances.iter_mut().zip(pairs) {
                    *sum = f64::hypot(*sum, datum - fit);
                }
            }
            for (left, distance) in left.iter_mut().zip(distances) {
                *left = f64::max(*left, distance);
            }
        }
        Some((fits, left))
    }

    /// The level of some control points.
    fn level(&self, phase: Phase, lines: [KnotLine; 2], control_points: Points) -> SurfaceLevel {
        let Request {
            points,
            grid,
            parameters,
            ..
        } = &self.request;
        let values = [0, 1].map(|axis| Values::new(&lines[axis], &parameters[axis]));
        let (rows, columns) = (lines[0].control_points(), lines[1].control_points());
        let mut squares = vec![0.0; points.len()];
        let unit = normalizing_scale(points.magnitude());
        let mut fit = vec![0.0; grid.rows];
        for (x, data) in control_points.lanes().iter().zip(points.lanes()) {
            let mut across = vec![0.0; rows * grid.columns];
            let both = x
                .chunks_exact(columns)
                .zip(across.chunks_exact_mut(grid.columns));
            both.for_each(|(x, y)| values[1].apply(&lines[1], x, y));
            let across = flipped(&across, rows, grid.columns);
            for (j, x) in across.chunks_exact(rows).enumerate() {
                values[0].apply(&lines[0], x, &mut fit);
                for (i, fit) in fit.iter().enumerate() {
                    let place = i * grid.columns + j;
                    let distance = (data[place] - fit) * unit;
                    squares[place] += distance * distance;
                }
            }
        }
        SurfaceLevel {
            phase,
            lines,
            control_points,
            distances: Distances::of_squares(squares, unit),
        }
    }

    /// Hands out a level, and remembers it if it is the best or the closest.
    fn issue(&mut self, level: SurfaceLevel) {
        let level = Arc::new(level);
        let within = level.distances.max <= self.request.tolerance;
        let fewer = |best: &Arc<SurfaceLevel>| level.count() <= best.count();
        if within && self.best.as_ref().is_none_or(fewer) {
            self.best = Some(Arc::clone(&level));
        }
        let closer = |best: &Arc<SurfaceLevel>| level.distances.max < best.distances.max;
        if self.closest.as_ref().is_none_or(closer) {
            self.closest = Some(Arc::clone(&level));
        }
        self.last = Some(Arc::clone(&level));
        self.queue.push_back(level);
    }
}

/// The same surface with more knots in a direction.
fn refined(level: &SurfaceLevel, axis: usize, fine: &KnotLine) -> Points {
    let coarse = &level.lines[axis];
    let (rows, columns) = (
        level.lines[0].control_points(),
        level.lines[1].control_points(),
    );
    let (points, dimension) = (&level.control_points, level.control_points.dimension());
    if axis == 1 {
        let curves = refine(coarse, fine, &lines_of(points, rows, columns));
        joined(&curves, dimension, rows, fine.control_points())
    } else {
        let turned = lines_of(&transposed(points, rows, columns), columns, rows);
        let curves = refine(coarse, fine, &turned);
        let joined = joined(&curves, dimension, columns, fine.control_points());
        transposed(&joined, columns, fine.control_points())
    }
}

/// The lines of a grid side by side: coordinate c of line k becomes lane c · lines + k.
fn lines_of(points: &Points, lines: usize, length: usize) -> Points {
    let all = points.lanes().iter();
    debug_assert_eq!(points.len(), lines * length);
    Points::from_lanes(all.flat_map(|lane| lane.chunks_exact(length)))
}

/// The inverse of [`lines_of`].
fn joined(curves: &Points, dimension: usize, lines: usize, length: usize) -> Points {
    Points::from_lanes((0..dimension).map(|c| {
        let mut lane = Vec::with_capacity(lines * length);
        (0..lines).for_each(|k| lane.extend_from_slice(curves.lane(c * lines + k)));
        lane
    }))
}

/// The grid with rows and columns exchanged.
fn transposed(points: &Points, rows: usize, columns: usize) -> Points {
    let lanes = points.lanes().iter();
    Points::from_lanes(lanes.map(|lane| flipped(lane, rows, columns)))
}

/// The same for one coordinate.
fn flipped(lane: &[f64], rows: usize, columns: usize) -> Vec<f64> {
    (0..columns)
        .flat_map(|j| (0..rows).map(move |i| lane[i * columns + j]))
        .collect()
}
