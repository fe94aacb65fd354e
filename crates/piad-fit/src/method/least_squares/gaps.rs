//! Stiffness of gaps: membrane energy over the spans of a surface in which no datum lies,
//!
//! ```text
//! g Ω ∬_{spans without data} ‖S_u‖² + ‖S_v‖²
//! ```
//!
//! beside the sum of squares with the sum Ω of the weights of the data. It does not depend on the scale of the
//! parameters if that is one for both. Where there are data it adds nothing.

use crate::basis::direction::Direction;
use crate::basis::quadrature::{Row, node_rows};
use crate::interrupt;
use crate::setup::Setup;

/// The energy over the spans without data.
#[derive(Debug)]
pub(super) struct Gaps {
    /// The root of `g Ω`.
    root: f64,
    /// The spans of u and of v.
    cells: Vec<(usize, usize)>,
    u: Nodes,
    v: Nodes,
    products_u: Vec<Products>,
    products_v: Vec<Products>,
    /// The number of control points in the v direction.
    columns: usize,
}

/// For each span of a direction the values and the first derivatives of its functions at its nodes.
type Nodes = [Vec<Vec<Row>>; 2];

/// Two functions of a span, and the integrals of the products of their values and of their first derivatives.
type Products = Vec<(usize, usize, [f64; 2])>;

impl Gaps {
    /// Those of a surface; `None` if it has none, or the basis has no derivatives.
    pub(super) fn new(setup: &Setup, stiffness: f64) -> Option<Self> {
        let cells = empty_cells(setup);
        let v = setup.v().filter(|_| !cells.is_empty() && stiffness > 0.0)?;
        let nodes = |direction: &Direction| -> Option<Nodes> {
            Some([node_rows(direction, 0)?, node_rows(direction, 1)?])
        };
        let (u, v_nodes) = (nodes(setup.u())?, nodes(v)?);
        Some(Self {
            root: stiffness.sqrt(),
            products_u: products(&u),
            products_v: products(&v_nodes),
            u,
            v: v_nodes,
            columns: v.free(),
            cells,
        })
    }

    /// The number of their rows.
    pub(super) fn count(setup: &Setup) -> usize {
        let width = |direction: &Direction| direction.basis.degree() + 1;
        let nodes = setup.directions().map(width).product::<usize>();
        empty_cells(setup).len().saturating_mul(2 * nodes)
    }

    /// Rows G with `Gᵀ G` the matrix of the energy.
    pub(super) fn each_row(&self, mut visit: impl FnMut(Row)) {
        for &(i, j) in &self.cells {
            interrupt::check();
            for (of_u, of_v) in [(1, 0), (0, 1)] {
                for along in &self.u[of_u][i] {
                    for across in &self.v[of_v][j] {
                        let products = along.iter().flat_map(|&(k, a)| {
                            let across = across.iter();
                            across.map(move |&(l, b)| (k * self.columns + l, self.root * a * b))
                        });
                        visit(products.collect());
                    }
                }
            }
        }
    }

    /// The entries of the matrix, by the rows and columns of two control points; those of several cells add up.
    pub(super) fn each_entry(&self, mut visit: impl FnMut([usize; 2], [usize; 2], f64)) {
        let factor = self.root * self.root;
        for &(i, j) in &self.cells {
            for &(k, m, [values_u, slopes_u]) in &self.products_u[i] {
                for &(l, n, [values_v, slopes_v]) in &self.products_v[j] {
                    let entry = factor * (slopes_u * values_v + values_u * slopes_v);
                    visit([k, l], [m, n], entry);
                }
            }
        }
    }

    /// `y ← y − H x` for one coordinate.
    pub(super) fn subtract(&self, x: &[f64], y: &mut [f64]) {
        interrupt::check();
        let columns = self.columns;
        self.each_entry(|[k, l], [m, n], entry| y[k * columns + l] -= entry * x[m * columns + n]);
    }

    /// Adds at least `Σ_j |H_ij|` for each control point i.
    pub(super) fn add_sums(&self, sums: &mut [f64]) {
        let columns = self.columns;
        self.each_entry(|[k, l], _, entry| sums[k * columns + l] += entry.abs());
    }
}

/// Those of each span.
fn products([values, slopes]: &Nodes) -> Vec<Products> {
    let spans = values.iter().zip(slopes);
    let products = spans.map(|(values, slopes)| {
        let rows = || values.iter().chain(slopes);
        let mut functions: Vec<usize> = rows().flatten().map(|it| it.0).collect();
        functions.sort_unstable();
        functions.dedup();
        let pairs = functions
            .iter()
            .flat_map(|&k| functions.iter().map(move |&m| (k, m)));
        let product = |(k, m)| (k, m, [sum(values, k, m), sum(slopes, k, m)]);
        pairs.map(product).collect()
    });
    products.collect()
}

/// The sum of the products of two functions at nodes.
fn sum(rows: &[Row], k: usize, m: usize) -> f64 {
    let of = |row: &Row, k: usize| {
        let found = row.iter().find(|it| it.0 == k);
        found.map_or(0.0, |it| it.1)
    };
    rows.iter().map(|row| of(row, k) * of(row, m)).sum()
}

/// The spans of u and of v in which no datum lies; none of curves.
fn empty_cells(setup: &Setup) -> Vec<(usize, usize)> {
    let Some(v) = setup.v() else {
        return Vec::new();
    };
    let (breaks_u, breaks_v) = (breaks(setup.u()), breaks(v));
    let columns = breaks_v.len().saturating_sub(1);
    let mut has_data = vec![false; breaks_u.len().saturating_sub(1) * columns];
    let along = places(&breaks_u, setup.u());
    let across = places(&breaks_v, v);
    let grid = setup.grid();
    let pairs: &mut dyn Iterator<Item = (usize, (usize, usize))> = match setup.is_scattered() {
        true => &mut along
            .iter()
            .copied()
            .zip(across.iter().copied())
            .enumerate(),
        false => {
            &mut (0..grid.count()).map(|k| (k, (along[k / grid.columns], across[k % grid.columns])))
        }
    };
    for (k, (i, j)) in pairs {
        let is_there = setup.missing().is_none_or(|missing| !missing.contains(k));
        if is_there && let Some(cell) = has_data.get_mut(i * columns + j) {
            *cell = true;
        }
    }
    let cells = has_data
        .iter()
        .enumerate()
        .filter(|(_, has_data)| !**has_data);
    cells
        .map(|(cell, _)| (cell / columns, cell % columns))
        .collect()
}

/// The different knots within the domain; none of bases without knots.
fn breaks(direction: &Direction) -> Vec<f64> {
    let (low, high) = direction.basis.domain();
    let knots = direction.basis.knots().unwrap_or_default();
    let mut breaks: Vec<f64> = knots
        .iter()
        .copied()
        .filter(|&x| low <= x && x <= high)
        .collect();
    breaks.dedup();
    breaks
}

/// The span of each parameter.
fn places(breaks: &[f64], direction: &Direction) -> Vec<usize> {
    let (low, high) = direction.basis.domain();
    let inside = |t: f64| match direction.is_closed() {
        true => low + (t - low).rem_euclid(high - low),
        false => t,
    };
    let span = |&t: &f64| {
        let after = breaks.partition_point(|&knot| knot <= inside(t));
        after.clamp(1, breaks.len().saturating_sub(1).max(1)) - 1
    };
    direction.parameters.iter().map(span).collect()
}
