//! The curve or surface of some control points: evaluation and sampling.
//!
//! ```text
//! C(t) = Σ_j X_j B_j(t),   S(u, v) = Σ_i Σ_j X_ij B_i(u) B_j(v)
//! ```
//!
//! with the rational basis functions of directions that have weights. In a homogeneous fit X has
//! one coordinate more, the weight, and points are projected: the first d coordinates of the sum
//! over the last one.
//!
//! Readers see the *complete* control net, as a CAD kernel stores it: with end copies, and on
//! closed curves with the control points of the next turn, one for each basis function. The
//! iteration has the free ones only.

use super::direction::Direction;
use super::points::{Grid, Points};
use super::problem::Problem;

/// The fitted curve or surface with the control points of one level. It borrows both, and copies
/// nothing.
#[derive(Clone, Copy, Debug)]
pub struct Geometry<'a> {
    problem: &'a Problem,
    control_points: &'a Points,
}

impl<'a> Geometry<'a> {
    /// The geometry of `control_points`, the free ones of some level of `problem`, in homogeneous
    /// coordinates if the problem is.
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

    /// How many free control points there are.
    pub fn control_points(&self) -> usize {
        self.control_points.len()
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

    /// Where the complete control net has free control point `index`: every `(row, column)`, the
    /// column of a curve being 0.
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

    /// The place of free control point `index`, d coordinates in data units: those of a homogeneous
    /// fit are divided by its weight, and infinite or NaN if that is zero.
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

    /// The points of the curve at the parameters `u`, or of the surface on the grid `u × v`, row by
    /// row, d coordinates each. Parameters lie in the domains of the bases. Of a curve each point
    /// costs `d (p + 1)` multiplications besides evaluating the basis.
    pub fn evaluate(&self, u: &[f64], v: &[f64]) -> Points {
        let grid = Values {
            along: LineValues::new(self.problem.u(), u),
            across: match self.problem.v() {
                None => LineValues::one(),
                Some(direction) => LineValues::new(direction, v),
            },
            controls: self.problem.control_grid(),
        };
        let lanes = self.control_points.lanes().iter();
        let mut lanes: Vec<Vec<f64>> = lanes.map(|lane| grid.sums(lane)).collect();
        // From homogeneous coordinates to points.
        if self.is_homogeneous()
            && let Some(weights) = lanes.pop()
        {
            for lane in &mut lanes {
                lane.iter_mut().zip(&weights).for_each(|(x, w)| *x /= w);
            }
        }
        Points::from_lanes(lanes)
    }

    /// Whether the curve or surface lies in the convex hull of its control points: whether all
    /// weights are positive.
    pub fn is_within_hull(&self) -> bool {
        let positive = |weights: &[f64]| weights.iter().all(|weight| *weight > 0.0);
        let lanes = self.control_points.lanes();
        let weights = lanes.last().filter(|_| self.is_homogeneous());
        let mut given = self.problem.directions().filter_map(Direction::weights);
        weights.is_none_or(|lane| positive(lane)) && given.all(positive)
    }
}

/// The values of the basis functions at the places of a grid, for sums over control points.
struct Values {
    /// Of direction u.
    along: LineValues,
    /// Of direction v; of a curve the one function that is 1.
    across: LineValues,
    /// The arrangement of the free control points.
    controls: Grid,
}

impl Values {
    /// The sums at all places of the grid, of one coordinate of the control points. Sums along one
    /// direction can serve a whole row or column of the grid, so that there are three orders of
    /// summation; the one with the fewest multiplications is taken.
    fn sums(&self, lane: &[f64]) -> Vec<f64> {
        let (along, across) = (&self.along, &self.across);
        let Grid { rows, columns } = self.controls;
        let (r, c) = (along.count(), across.count());
        let at_once = r * c * along.width * across.width;
        let by_rows = r * along.width * columns + r * c * across.width;
        let by_columns = c * across.width * rows + r * c * along.width;
        let mut sums = vec![0.0; r * c];
        if at_once <= by_rows.min(by_columns) {
            for (place, sum) in sums.iter_mut().enumerate() {
                let inner = |k: usize| across.sum(place % c, |l| lane[k * columns + l]);
                *sum = along.sum(place / c, inner);
            }
        } else if by_rows <= by_columns {
            let mut line = vec![0.0; columns];
            for (i, sums) in sums.chunks_exact_mut(c).enumerate() {
                line.fill(0.0);
                along.each(i, |k, a| {
                    let row = &lane[k * columns..][..columns];
                    line.iter_mut().zip(row).for_each(|(sum, x)| *sum += a * x);
                });
                for (j, sum) in sums.iter_mut().enumerate() {
                    *sum = across.sum(j, |l| line[l]);
                }
            }
        } else {
            for j in 0..c {
                let column = |k: usize| across.sum(j, |l| lane[k * columns + l]);
                let column: Vec<f64> = (0..rows).map(column).collect();
                for i in 0..r {
                    sums[i * c + j] = along.sum(i, |k| column[k]);
                }
            }
        }
        sums
    }
}

/// The values of the basis functions of a direction at some parameters.
struct LineValues {
    /// How many functions can differ from zero at a parameter.
    width: usize,
    /// At each parameter the free control points of these functions.
    indices: Vec<u32>,
    /// At each parameter the values of these functions.
    values: Vec<f64>,
}

impl LineValues {
    /// Evaluates the basis of a direction at all parameters.
    fn new(direction: &Direction, parameters: &[f64]) -> Self {
        let width = direction.basis.support_width();
        let mut values = vec![0.0; width * parameters.len()];
        let mut indices = Vec::with_capacity(values.len());
        for (values, &t) in values.chunks_exact_mut(width).zip(parameters) {
            let start = direction.evaluate(t, values);
            indices.extend((0..width).map(|k| direction.free_index(start + k) as u32));
        }
        Self {
            width,
            indices,
            values,
        }
    }

    /// Across a curve there is one control point, whose function is 1.
    fn one() -> Self {
        Self {
            width: 1,
            indices: vec![0],
            values: vec![1.0],
        }
    }

    /// The number of parameters.
    fn count(&self) -> usize {
        self.values.len() / self.width
    }

    /// Each control point that matters at parameter `i`, with the value of its function.
    fn each(&self, i: usize, mut visit: impl FnMut(usize, f64)) {
        let range = i * self.width..(i + 1) * self.width;
        for (&index, &value) in self.indices[range.clone()].iter().zip(&self.values[range]) {
            visit(index as usize, value);
        }
    }

    /// The sum at parameter `i`.
    fn sum(&self, i: usize, control: impl Fn(usize) -> f64) -> f64 {
        let mut sum = 0.0;
        self.each(i, |index, value| sum += value * control(index));
        sum
    }
}
