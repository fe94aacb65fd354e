//! The curve or surface of some control points: evaluation and sampling.

use super::basis::Basis;
use super::direction::Direction;
use super::points::Points;
use super::problem::Problem;

/// The fitted curve or surface with the control points of one level.
#[derive(Clone, Copy, Debug)]
pub struct Geometry<'a> {
    problem: &'a Problem,
    control_points: &'a Points,
}

impl<'a> Geometry<'a> {
    /// The geometry of `control_points`, the free ones of some level of `problem`.
    pub fn new(problem: &'a Problem, control_points: &'a Points) -> Self {
        Self {
            problem,
            control_points,
        }
    }

    /// Number of control points in the u direction, end copies included.
    pub fn rows(&self) -> usize {
        self.problem.u().basis.functions()
    }

    /// Number of control points in the v direction, end copies included; `None` for a curve.
    pub fn columns(&self) -> Option<usize> {
        self.problem.v().map(|v| v.basis.functions())
    }

    /// The complete control net as a CAD kernel stores it: the indices of the free control points,
    /// row by row, where end copies repeat theirs.
    pub fn row(&self, row: usize) -> impl Iterator<Item = usize> + 'a {
        let columns = self.problem.control_grid().columns;
        let problem = self.problem;
        let start = problem.u().free_index(row) * columns;
        (0..self.columns().unwrap_or(1))
            .map(move |j| start + problem.v().map_or(0, |v| v.free_index(j)))
    }

    /// Where the complete control net has free control point `index`: `(row, column)`, the column
    /// of a curve being 0.
    pub fn occurrences(&self, index: usize) -> impl Iterator<Item = (usize, usize)> + 'a {
        let columns = self.problem.control_grid().columns;
        let v = self.problem.v();
        let rows = self.problem.u().functions_of(index / columns);
        rows.flat_map(move |row| {
            let across = v.map(|v| v.functions_of(index % columns));
            let single = across.is_none().then_some(0);
            let across = across.into_iter().flatten().chain(single);
            across.map(move |column| (row, column))
        })
    }

    /// Whether the control points have weights of their own.
    pub fn is_homogeneous(&self) -> bool {
        self.problem.is_homogeneous()
    }

    /// The place of free control point `index`.
    pub fn place(&self, index: usize) -> impl ExactSizeIterator<Item = f64> + 'a {
        let weight = self.weight(index).unwrap_or(1.0);
        let dimension = self.problem.dimension();
        self.control_points
            .point(index)
            .take(dimension)
            .map(move |x| x / weight)
    }

    /// The weight of free control point `index` of a homogeneous fit.
    pub fn weight(&self, index: usize) -> Option<f64> {
        let weights = self.control_points.lanes().last()?;
        self.is_homogeneous().then(|| weights[index])
    }

    /// The points of the curve at the parameters `u`, or of the surface on the grid `u × v`, row
    /// by row. Parameters lie in the domains of the bases.
    pub fn evaluate(&self, u: &[f64], v: &[f64]) -> Points {
        let dimension = self.control_points.dimension();
        let mut result = Points::new(self.problem.dimension());
        let columns = self.problem.control_grid().columns;
        let curve = [vec![(0, 1.0)]];
        let across = self
            .problem
            .v()
            .map_or(curve.to_vec(), |direction| rows_of(direction, v));
        let mut point = vec![0.0; dimension];
        for row in rows_of(self.problem.u(), u) {
            for column in &across {
                point.fill(0.0);
                for &(i, a) in &row {
                    for &(j, b) in column {
                        let control = self.control_points.point(i * columns + j);
                        for (x, control) in point.iter_mut().zip(control) {
                            *x += a * b * control;
                        }
                    }
                }
                // From homogeneous coordinates to a point.
                if let (true, Some(&weight)) = (self.is_homogeneous(), point.last()) {
                    point.iter_mut().for_each(|x| *x /= weight);
                }
                result.push(&point);
            }
        }
        result
    }

    /// `count` parameters at equal distances over the domain of a direction, both ends included.
    pub fn uniform_parameters(basis: &Basis, count: usize) -> Vec<f64> {
        let (low, high) = basis.domain();
        let steps = count.saturating_sub(1).max(1) as f64;
        (0..count)
            .map(|i| {
                let s = i as f64 / steps;
                (1.0 - s) * low + s * high
            })
            .collect()
    }
}

/// For each parameter the free control points that matter there, with the values of their functions.
fn rows_of(direction: &Direction, parameters: &[f64]) -> Vec<Vec<(usize, f64)>> {
    let mut values = vec![0.0; direction.basis.support_width()];
    parameters
        .iter()
        .map(|&t| {
            let start = direction.evaluate(t, &mut values);
            values
                .iter()
                .enumerate()
                .map(|(k, &value)| (direction.free_index(start + k), value))
                .collect()
        })
        .collect()
}
