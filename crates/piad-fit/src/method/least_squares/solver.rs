//! Solves the normal equations `N δ = g`, `N = AᵀΩA + w H`: a step of their solution leads to the minimum, with the
//! projection of metric N⁻¹ to the minimum under all conditions.
//!
//! The rows of A, of a root of `w H`, and of the conditions (whose squares do not change a minimum
//! among feasible points) are factorized by rotations, `A = Q R`, in O(m p²) for B-splines. The matrices of
//! the two directions of a surface are factorized separately, `(A_u ⊗ A_v)⁺ = A_u⁺ ⊗ A_v⁺`, if no point is
//! missing, all weights are equal and there is no `w H`; otherwise that of the whole surface is, if this takes at
//! most [`MAX_SURFACE_MULTIPLICATIONS`] multiplications. A step is solved twice, the second time with the gradient that
//! rounding has left (corrected seminormal equations, Björck 1987), so that it is as exact as by
//! orthogonal transformations. If rotations would take more than [`MOST_ROTATIONS`] multiplications,
//! N is computed and decomposed instead, with more refinements of the step; the same holds with
//! conditions, as their decomposition multiplies rounding errors by the square of the condition number.

use super::constraints::{Condition, Projection, Tangents};
use super::fairness::Energy;
use super::objective::Objective;
use super::settings::LeastSquares;
use crate::basis::direction::Direction;
use crate::data::grid::Grid;
use crate::data::points::Points;
use crate::linear::apply_tensor;
use crate::linear::banded::Banded;
use crate::linear::folded;
use crate::linear::rows::Rows;
use crate::linear::triangular::Triangular;
use crate::matrix::collocation::Collocation;
use crate::matrix::operator::Operator;
use crate::matrix::sparse::Sparse;
use crate::matrix::tensor::Tensor;
use crate::method::equations::Equations;
use crate::method::plain::compute_residual;
use crate::method::update::State;
use crate::setup::Setup;

/// The most multiplications that the factorization of a whole surface may take.
pub(super) const MAX_SURFACE_MULTIPLICATIONS: usize = 4_000_000_000;

/// The most multiplications of rotations; beyond them N is summed up.
const MOST_ROTATIONS: usize = 20_000_000;

/// The most refinements of a step by a factor of N, or with conditions.
const REFINEMENTS: usize = 4;

/// `(AᵀA)⁻¹`, as a factorization.
#[derive(Debug)]
pub(super) struct Solver {
    /// Of a curve, of the u direction, or of a whole surface.
    u: Triangular,
    /// Of the v direction.
    v: Option<Triangular>,
    /// The arrangement of the control points.
    grid: Grid,
    /// The conditions that every level satisfies.
    projection: Option<Projection>,
    /// The number of refinements of a step.
    refinements: usize,
}

impl Solver {
    /// Factorizes; control points whose factor in `scale` is zero stay where they are.
    pub(super) fn new(
        equations: &Equations,
        (objective, conditions): (&Objective, &[Condition]),
        scale: &[f64],
        sums_products: bool,
    ) -> Self {
        let setup = &equations.setup;
        let fixed = |index: usize| scale[index] == 0.0;
        let additional = Additional {
            objective,
            conditions,
            scale,
            sums_products,
        };
        let whole = |rows: Rows| Self::whole(setup, rows.triangular(fixed));
        let mut solver = match &equations.collocation {
            Operator::Sparse(sparse) => whole(scattered(sparse, &additional)),
            Operator::Tensor(tensor) => Self::of_tensor(setup, tensor, &additional),
        };
        if sums_products {
            solver.refinements = REFINEMENTS;
        }
        let mut scratch = vec![0.0; equations.scratch()];
        solver.projection = Projection::inverse(conditions, scale.len(), |column| {
            solver.apply(&mut [column], &mut scratch);
        });
        if solver.projection.is_some() {
            solver.refinements = REFINEMENTS;
        }
        solver
    }

    /// The factor of the matrix of a curve or of a whole surface.
    fn whole(setup: &Setup, factor: Triangular) -> Self {
        Self {
            u: factor,
            v: None,
            grid: Grid {
                rows: setup.control_grid().count(),
                columns: 1,
            },
            projection: None,
            refinements: 1,
        }
    }

    /// The factors of a curve or a grid of points.
    fn of_tensor(setup: &Setup, tensor: &Tensor, additional: &Additional) -> Self {
        let fixed = |index: usize| additional.scale[index] == 0.0;
        let whole = |rows: Rows| Self::whole(setup, rows.triangular(fixed));
        match tensor.v.as_ref().zip(setup.v()) {
            Some((v, _)) if is_whole(setup, additional.objective.is_separable()) => {
                whole(surface(setup, tensor, v, additional))
            }
            Some((v, across)) => Self {
                u: line(&tensor.u, setup.u(), |_| 1.0).triangular(|_| false),
                v: Some(line(v, across, |_| 1.0).triangular(|_| false)),
                grid: setup.control_grid(),
                projection: None,
                refinements: 1,
            },
            None => {
                let mut rows = line(&tensor.u, setup.u(), |i| {
                    additional.objective.weight(i).sqrt()
                });
                additional.push(&mut rows);
                whole(rows)
            }
        }
    }

    /// `x ← N⁻¹ x` for each lane.
    fn apply(&self, lanes: &mut [&mut [f64]], scratch: &mut [f64]) {
        apply_tensor(&self.u, self.v.as_ref(), self.grid, lanes, scratch);
    }

    /// The step along which the minimum lies, for each coordinate of a gradient.
    pub(super) fn solve(&self, gradient: &mut Points, scratch: &mut [f64]) {
        let lanes = gradient.lanes_mut().iter_mut();
        let mut lanes: Vec<&mut [f64]> = lanes.map(AsMut::as_mut).collect();
        self.apply(&mut lanes, scratch);
        if let Some(projection) = &self.projection {
            let mut pulls: Vec<Vec<f64>> = lanes.iter().map(|lane| projection.pull(lane)).collect();
            let mut solved: Vec<&mut [f64]> = pulls.iter_mut().map(AsMut::as_mut).collect();
            self.apply(&mut solved, scratch);
            for (lane, pull) in lanes.iter_mut().zip(&pulls) {
                lane.iter_mut().zip(pull).for_each(|(x, step)| *x += step);
            }
        }
    }

    /// What the lengths of tangents do to the objective; `None` without conditions.
    pub(super) fn tangents(
        &self,
        equations: &Equations,
        objective: &mut Objective,
        (conditions, scale): (&[Condition], &[f64]),
    ) -> Option<Tangents> {
        let projection = self.projection.as_ref()?;
        let mut minimum = objective.pull_of_data(equations);
        let lanes = minimum.lanes_mut().iter_mut();
        let mut lanes: Vec<&mut [f64]> = lanes.map(AsMut::as_mut).collect();
        self.apply(&mut lanes, &mut vec![0.0; equations.scratch()]);
        let weights = conditions.iter();
        let weights: Vec<f64> = weights.map(|it| 1.0 / it.largest(scale)).collect();
        Some(Tangents::new(conditions, &weights, projection, &minimum))
    }

    /// A step to the minimum.
    pub(super) fn update(
        &self,
        equations: &Equations,
        state: &mut State,
        gradient: &Points,
        objective: &mut Objective,
    ) {
        let mut step = gradient.clone();
        self.solve(&mut step, &mut state.scratch);
        state.control_points.add(&step);
        let mut left = f64::INFINITY;
        for _ in 0..self.refinements {
            compute_residual(equations, state);
            objective.gradient(equations, state, &mut step);
            self.solve(&mut step, &mut state.scratch);
            // Not the gradient, which conditions keep from zero.
            if step.magnitude() >= left {
                break;
            }
            left = step.magnitude();
            state.control_points.add(&step);
        }
    }
}

/// Rows besides those of the data.
struct Additional<'a> {
    objective: &'a Objective,
    conditions: &'a [Condition],
    scale: &'a [f64],
    /// True if the products of columns are summed up, rather than rows rotated.
    sums_products: bool,
}

impl Additional<'_> {
    /// No rows of a whole surface yet.
    fn rows(&self, places: Vec<u32>, width: usize) -> Rows {
        match self.sums_products {
            true => Rows::of_products(places, width),
            false => Rows::new(places, width),
        }
    }

    /// Adds those of fairness and of conditions, which are made as large as those of the data.
    fn push(&self, rows: &mut Rows) {
        if let Some(energy) = self.objective.energy() {
            energy.each_row(|row| rows.push(row.into_iter(), 1.0));
        }
        for condition in self.conditions {
            let factor = condition.largest(self.scale);
            if factor > 0.0 {
                rows.push(condition.row.iter().copied(), 1.0 / factor.sqrt());
            }
        }
    }
}

/// Returns true if the normal equations of a surface are those of the whole grid, rather than of both directions: the
/// objective may not be `separable`.
pub(super) fn is_whole(setup: &Setup, separable: bool) -> bool {
    let scattered = setup.is_scattered();
    setup.v().is_some() && (scattered || setup.missing().is_some() || !separable)
}

/// The approximate number of multiplications that the factorization takes.
pub(super) fn cost(setup: &Setup, settings: &LeastSquares) -> usize {
    match setup.v() {
        Some(v) if sums_products(setup, settings) => {
            let widths = setup.directions().map(|it| it.basis.support_width());
            let width = widths.product::<usize>();
            let rows = setup
                .grid()
                .count()
                .saturating_add(Energy::count(setup, settings));
            let sums = rows.saturating_mul(width.saturating_mul(width));
            let band = setup.u().basis.support_width().saturating_mul(v.free());
            let factor = setup
                .control_grid()
                .count()
                .saturating_mul(band.saturating_mul(band));
            sums.saturating_add(factor)
        }
        _ => rotations(setup, settings),
    }
}

/// Returns true if the normal equations are summed up as products, because rotations take too many multiplications.
pub(super) fn sums_products(setup: &Setup, settings: &LeastSquares) -> bool {
    is_whole(setup, settings.is_separable()) && rotations(setup, settings) > MOST_ROTATIONS
}

/// The same by rotations.
fn rotations(setup: &Setup, settings: &LeastSquares) -> usize {
    let span = |direction: &Direction| {
        let (width, free) = (direction.basis.support_width(), direction.free());
        let places = if direction.is_closed() {
            2 * width
        } else {
            width
        };
        places.min(free)
    };
    let of_rows = |rows: usize, width: usize| {
        let each = width.saturating_mul(width).saturating_mul(4);
        rows.saturating_mul(each)
    };
    match setup.v() {
        Some(v) if is_whole(setup, settings.is_separable()) => {
            let width = span(setup.u()).saturating_mul(v.free());
            let bending = Energy::count(setup, settings);
            let count = setup.grid().count();
            if setup.is_scattered() {
                // Those of each cell are reduced to as many rows as it has functions.
                let cell = span(setup.u()) * span(v);
                let cells = (setup.u().free() + 1 - span(setup.u())) * (v.free() + 1 - span(v));
                let left = cells
                    .saturating_mul(cell)
                    .min(count)
                    .saturating_add(bending);
                return of_rows(left, width).saturating_add(of_rows(count, cell));
            }
            of_rows(count.saturating_add(bending), width)
        }
        _ => {
            let costs = setup
                .directions()
                .map(|direction| of_rows(direction.parameters.len(), span(direction)));
            costs.fold(0, usize::saturating_add)
        }
    }
}

/// The order of the columns of a direction in which rows are narrow, and how wide they are then: those
/// of the data, which can leave out functions that vanish, and those of any parameter.
pub(super) fn places(matrix: &Collocation, direction: &Direction) -> (Vec<u32>, usize) {
    let n = matrix.columns();
    let width = |banded: &Banded| banded.width().max(direction.basis.support_width());
    match matrix.as_banded() {
        Some(banded) if banded.is_cyclic() || direction.is_closed() => {
            let fold = folded(n);
            ((0..n).map(|j| fold(j) as u32).collect(), 2 * width(banded))
        }
        Some(banded) => ((0..n as u32).collect(), width(banded)),
        None => ((0..n as u32).collect(), n),
    }
}

/// The entries of a row of a matrix.
pub(super) fn row(matrix: &Collocation, i: usize) -> Vec<(usize, f64)> {
    match matrix {
        Collocation::Banded(banded) => banded.row(i).collect(),
        Collocation::Dense(dense) => dense.row(i).collect(),
    }
}

/// The rows of the matrix of one direction, each with a factor.
fn line(matrix: &Collocation, direction: &Direction, factor: impl Fn(usize) -> f64) -> Rows {
    let (places, width) = places(matrix, direction);
    let mut rows = Rows::new(places, width);
    for i in 0..matrix.rows() {
        rows.push(row(matrix, i).into_iter(), factor(i));
    }
    rows
}

/// The rows of a whole surface: one for each data point that is there, and additional ones.
fn surface(setup: &Setup, tensor: &Tensor, v: &Collocation, additional: &Additional) -> Rows {
    let (grid, columns) = (setup.grid(), v.columns());
    let (places_u, width_u) = places(&tensor.u, setup.u());
    let places = places_u.iter();
    let places =
        places.flat_map(|&place| (0..columns).map(move |j| place * columns as u32 + j as u32));
    let mut rows = additional.rows(places.collect(), width_u * columns);
    let mut ones = vec![1.0; grid.count()];
    if let Some(missing) = setup.missing() {
        missing.clear(&mut ones);
    }
    for i in 0..grid.rows {
        let along = row(&tensor.u, i);
        for j in (0..grid.columns).filter(|j| ones[i * grid.columns + j] != 0.0) {
            let across = row(v, j);
            let entries = along.iter().flat_map(|&(k, a)| {
                let across = across.iter();
                across.map(move |&(l, b)| (k * columns + l, a * b))
            });
            let weight = additional.objective.weight(i * grid.columns + j);
            rows.push(entries, weight.sqrt());
        }
    }
    additional.push(&mut rows);
    rows
}

/// The rows of scattered points, and additional ones. Points with the same functions follow one
/// another and are first reduced among themselves: however many they are, (p + 1)(q + 1) rows are
/// left of them.
fn scattered(sparse: &Sparse, additional: &Additional) -> Rows {
    let [along, across] = sparse.widths();
    let mut points: Vec<usize> = (0..sparse.rows()).collect();
    points.sort_by_key(|&i| sparse.cell(i));
    let mut left = additional.rows(sparse.places(), sparse.band());
    for points in points.chunk_by(|&i, &j| sparse.cell(i) == sparse.cell(j)) {
        let (first, start) = sparse.cell(points[0]);
        let width = along * across;
        let mut cell = Triangular::new((0..width as u32).collect(), width);
        for &i in points {
            let factor = additional.objective.weight(i).sqrt();
            let values = sparse.row(i).map(|(_, value)| factor * value);
            cell.insert_row(values.enumerate());
        }
        for row in cell.rows() {
            let place = |k: usize| {
                sparse.control_point(first as usize + k / across, start as usize + k % across)
            };
            // Beyond the functions of the cell there are zeros.
            let entries = row.take_while(|(k, _)| *k < width);
            left.push(entries.map(|(k, value)| (place(k), value)), 1.0);
        }
    }
    additional.push(&mut left);
    left
}
