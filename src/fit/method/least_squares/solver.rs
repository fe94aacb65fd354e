//! The normal equations `AᵀA δ = Aᵀ Δ`, solved: a step of their solution leads to the minimum.
//!
//! A is factorized by rotations, `A = Q R`, in O(m p²) for B-splines: of a surface in both directions,
//! `(A_u ⊗ A_v)⁺ = A_u⁺ ⊗ A_v⁺`, if all its points are there. Otherwise the matrix of the whole
//! surface is, as far as [`MOST`] multiplications go. A step is solved for twice, the second time
//! for what rounding has left of the gradient (corrected seminormal equations, Björck 1987), so that
//! it is as exact as by orthogonal transformations.

use crate::fit::collocation::Collocation;
use crate::fit::direction::Direction;
use crate::fit::equations::Equations;
use crate::fit::linear::apply_tensor;
use crate::fit::linear::folded;
use crate::fit::linear::triangular::{Rows, Triangular};
use crate::fit::method::update::State;
use crate::fit::points::{Grid, Points};
use crate::fit::setup::Setup;
use crate::fit::tensor::Tensor;

/// The most multiplications that the factorization of a whole surface may take.
pub(super) const MOST: usize = 4_000_000_000;

/// `(AᵀA)⁻¹`, as a factorization.
#[derive(Debug)]
pub(super) struct Solver {
    /// Of a curve, of the u direction, or of a whole surface.
    u: Triangular,
    /// Of the v direction.
    v: Option<Triangular>,
    /// The arrangement of the control points.
    grid: Grid,
}

impl Solver {
    /// Factorizes; control points whose factor in `scale` is zero stay where they are.
    pub(super) fn new(equations: &Equations, scale: &[f64]) -> Self {
        let (setup, tensor) = (&equations.setup, &*equations.collocation);
        let grid = setup.control_grid();
        match &tensor.v {
            Some(v) if is_whole(setup) => Self {
                u: whole(setup, tensor, v, |index| scale[index] == 0.0),
                v: None,
                grid: Grid {
                    rows: grid.count(),
                    columns: 1,
                },
            },
            v => Self {
                u: line(&tensor.u, |index| v.is_none() && scale[index] == 0.0),
                v: v.as_ref().map(|v| line(v, |_| false)),
                grid,
            },
        }
    }

    /// `g ← (AᵀA)⁻¹ g` for each coordinate.
    pub(super) fn solve(&self, gradient: &mut Points, scratch: &mut [f64]) {
        let lanes = gradient.lanes_mut().iter_mut();
        let mut lanes: Vec<&mut [f64]> = lanes.map(AsMut::as_mut).collect();
        apply_tensor(&self.u, self.v.as_ref(), self.grid, &mut lanes, scratch);
    }

    /// A step to the minimum.
    pub(super) fn update(&self, equations: &Equations, state: &mut State, gradient: &Points) {
        let collocation = &equations.collocation;
        let mut step = gradient.clone();
        self.solve(&mut step, &mut state.scratch);
        state.control_points.add(&step);
        let mut left = gradient.clone();
        let mut image = vec![0.0; state.residual.len()];
        let lanes = state.residual.lanes_mut().iter_mut().zip(left.lanes_mut());
        for ((residual, left), step) in lanes.zip(step.lanes()) {
            collocation.apply(step, &mut image, &mut state.scratch);
            for (residual, image) in residual.iter_mut().zip(&image) {
                *residual -= image;
            }
            if let Some(missing) = equations.setup.missing() {
                missing.clear(residual);
            }
            collocation.apply_transposed(residual, left, &mut state.scratch);
        }
        self.solve(&mut left, &mut state.scratch);
        state.control_points.add(&left);
    }
}

/// Whether the normal equations of a surface are those of the whole grid, rather than of both
/// directions.
pub(super) fn is_whole(setup: &Setup) -> bool {
    setup.v().is_some() && setup.missing().is_some()
}

/// About how many multiplications the factorization takes.
pub(super) fn cost(setup: &Setup) -> usize {
    let span = |direction: &Direction| {
        let (width, free) = (direction.basis.support_width(), direction.free());
        let places = if direction.is_closed() {
            2 * width
        } else {
            width
        };
        places.min(free)
    };
    let rotations = |rows: usize, width: usize| {
        let each = width.saturating_mul(width).saturating_mul(4);
        rows.saturating_mul(each)
    };
    match setup.v() {
        Some(v) if is_whole(setup) => {
            let width = span(setup.u()).saturating_mul(v.free());
            rotations(setup.grid().count(), width)
        }
        _ => {
            let costs = setup
                .directions()
                .map(|direction| rotations(direction.parameters.len(), span(direction)));
            costs.fold(0, usize::saturating_add)
        }
    }
}

/// The order of the columns of a direction in which rows are narrow, and how wide they are then.
fn places(matrix: &Collocation) -> (Vec<u32>, usize) {
    let n = matrix.columns();
    match matrix.as_banded() {
        Some(banded) if banded.is_cyclic() => {
            let fold = folded(n);
            ((0..n).map(|j| fold(j) as u32).collect(), 2 * banded.width())
        }
        Some(banded) => ((0..n as u32).collect(), banded.width()),
        None => ((0..n as u32).collect(), n),
    }
}

/// The entries of a row of a matrix.
fn row(matrix: &Collocation, i: usize) -> Vec<(usize, f64)> {
    match matrix {
        Collocation::Banded(banded) => banded.row(i).collect(),
        Collocation::Dense { matrix, .. } => matrix.row(i).iter().copied().enumerate().collect(),
    }
}

/// The factor of the matrix of one direction.
fn line(matrix: &Collocation, fixed: impl Fn(usize) -> bool) -> Triangular {
    let (places, width) = places(matrix);
    let mut rows = Rows::new(places, width);
    for i in 0..matrix.rows() {
        rows.push(row(matrix, i).into_iter(), 1.0);
    }
    rows.triangular(fixed)
}

/// The factor of the matrix of a whole surface, with a row for each data point that is there.
fn whole(
    setup: &Setup,
    tensor: &Tensor,
    v: &Collocation,
    fixed: impl Fn(usize) -> bool,
) -> Triangular {
    let (grid, columns) = (setup.grid(), v.columns());
    let (places_u, width_u) = places(&tensor.u);
    let places = places_u.iter();
    let places =
        places.flat_map(|&place| (0..columns).map(move |j| place * columns as u32 + j as u32));
    let mut rows = Rows::new(places.collect(), width_u * columns);
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
            rows.push(entries, 1.0);
        }
    }
    rows.triangular(fixed)
}
