//! The normal equations of scattered points, `N = AᵀA + H` with the matrix H of an energy.
//!
//! A product with A and with its transpose takes time for each datum, one with AᵀA for each control point, of which there
//! are far fewer where a tolerance is met by smoothing.

use super::rows::{Rows, add};
use crate::linear::LineMap;
use crate::linear::folded;
use crate::linear::stencil::{Reach, Stencil};
use crate::linear::triangular::Triangular;

/// The most numbers of a factor of N, and the most multiplications of its factorization.
pub(crate) const MOST_FACTOR: usize = 4_000_000;

/// See [`MOST_FACTOR`].
const MOST_WORK: usize = 2_000_000_000;

/// The matrix N.
#[derive(Debug)]
pub(super) struct Normal<'a> {
    rows: &'a Rows,
    /// AᵀA, if it has fewer numbers than A.
    products: Option<Stencil>,
    /// H.
    energy: Option<&'a Stencil>,
}

impl<'a> Normal<'a> {
    pub(super) fn new(rows: &'a Rows, energy: Option<&'a Stencil>) -> Self {
        let is_smaller = Stencil::numbers(rows.reach()) <= 2 * rows.numbers();
        let is_factorized = energy.is_some() && Band::of(rows).is_some();
        Self {
            products: (is_smaller || is_factorized).then(|| products(rows)),
            rows,
            energy,
        }
    }

    /// Returns true if there is an energy.
    pub(super) fn has_energy(&self) -> bool {
        self.energy.is_some()
    }

    /// The preconditioner: N⁻¹ where an energy determines it and it does not take too long, as an energy mostly affects
    /// what conjugate gradients find last; else the diagonal D.
    pub(super) fn preconditioner(&self) -> Preconditioner {
        match (&self.products, self.energy, Band::of(self.rows)) {
            (Some(products), Some(energy), Some(band)) => {
                Preconditioner::Inverse(band.factor([products, energy]))
            }
            _ => Preconditioner::Diagonal(self.diagonal()),
        }
    }

    /// `y = N x`; `image` has room for `A x`.
    pub(super) fn apply(&self, x: &[f64], y: &mut [f64], image: &mut [f64]) {
        match &self.products {
            Some(products) => {
                y.fill(0.0);
                self.add(products, x, y, 1.0);
            }
            None => {
                self.rows.apply(x, image);
                self.rows.apply_transposed(image, y);
            }
        }
        if let Some(energy) = self.energy {
            self.add(energy, x, y, 1.0);
        }
    }

    /// The residual `r = unit (P − A x)` of one coordinate, and half the negative gradient `Aᵀ r − unit H x` of the sum of
    /// squares and the energy, which it returns.
    pub(super) fn start(
        &self,
        (x, data, unit): (&[f64], &[f64], f64),
        residual: &mut [f64],
        gradient: &mut [f64],
    ) -> f64 {
        self.rows.apply(x, residual);
        let pairs = residual.iter_mut().zip(data);
        pairs.for_each(|(r, datum)| *r = (datum - *r) * unit);
        self.rows.apply_transposed(residual, gradient);
        let mut value: f64 = residual.iter().map(|r| r * r).sum();
        if let Some(energy) = self.energy {
            let mut pull = vec![0.0; x.len()];
            self.add(energy, x, &mut pull, unit);
            for ((gradient, pull), x) in gradient.iter_mut().zip(pull).zip(x) {
                *gradient -= pull;
                value += x * unit * pull;
            }
        }
        value
    }

    /// The diagonal D = 1 / at least the sums of the absolute values of the rows of N; zero where there is nothing.
    fn diagonal(&self) -> Vec<f64> {
        let mut sums = self.rows.sums();
        if let Some(energy) = self.energy {
            let more = energy.sums_of_absolute_values();
            self.rows
                .each_with_margin(|control_point, k| sums[control_point] += more[k]);
        }
        inverses(sums)
    }

    /// `y ← y + factor M x`.
    fn add(&self, matrix: &Stencil, x: &[f64], y: &mut [f64], factor: f64) {
        let sums = matrix.product(&self.rows.with_margin(x));
        let add = |control_point: usize, k: usize| y[control_point] += factor * sums[k];
        self.rows.each_with_margin(add);
    }
}

/// The preconditioner of a gradient.
#[derive(Debug)]
pub(super) enum Preconditioner {
    /// The diagonal of [`Normal::diagonal`].
    Diagonal(Vec<f64>),
    /// N⁻¹.
    Inverse(Triangular),
}

impl Preconditioner {
    /// The product with a gradient.
    pub(super) fn apply(&self, gradient: &[f64], product: &mut [f64]) {
        match self {
            Self::Diagonal(diagonal) => {
                let pairs = gradient.iter().zip(diagonal);
                let products = product.iter_mut().zip(pairs);
                products.for_each(|(product, (g, d))| *product = g * d);
            }
            Self::Inverse(factor) => {
                product.copy_from_slice(gradient);
                factor.apply(product);
            }
        }
    }
}

/// The control points in the order in which N is narrow, row by row; a closed direction of u is folded.
struct Band {
    reach: [Reach; 2],
    free: [usize; 2],
    width: usize,
}

impl Band {
    /// That of N, if its factorization does not take too long. At poles there are fewer unknowns than control points.
    fn of(rows: &Rows) -> Option<Self> {
        let band = Self::new(rows.reach());
        (band.is_affordable() && !rows.has_poles()).then_some(band)
    }

    fn new(reach: [Reach; 2]) -> Self {
        let free = reach.map(|it| it.count - if it.is_closed { it.degree } else { 0 });
        let [u, v] = reach;
        let lines = if u.is_closed { 2 * u.degree } else { u.degree };
        let columns = if v.is_closed { free[1] } else { v.degree + 1 };
        let width = (lines * free[1] + columns).min(free[0] * free[1]);
        Self { reach, free, width }
    }

    fn is_affordable(&self) -> bool {
        let numbers = (self.free[0] * self.free[1]).saturating_mul(self.width);
        numbers <= MOST_FACTOR && numbers.saturating_mul(self.width) <= MOST_WORK
    }

    /// The factor of a sum of matrices; control points without entries are left out.
    fn factor(&self, matrices: [&Stencil; 2]) -> Triangular {
        let [rows, columns] = self.free;
        let line = match self.reach[0].is_closed {
            true => (0..rows).map(folded(rows)).collect(),
            false => (0..rows).collect::<Vec<usize>>(),
        };
        let place = |[k, l]: [usize; 2]| line[k % rows] * columns + l % columns;
        let mut products = vec![0.0; rows * columns * self.width];
        for matrix in matrices {
            matrix.each_entry(|one, other, entry| {
                let (one, other) = (place(one), place(other));
                if let Some(apart) = other.checked_sub(one) {
                    products[one * self.width + apart] += entry;
                }
            });
        }
        let places = (0..rows * columns).map(|j| place([j / columns, j % columns]) as u32);
        Triangular::of_products(places.collect(), self.width, products, |_| false)
    }
}

/// 1 over each sum, or zero.
pub(super) fn inverses(sums: Vec<f64>) -> Vec<f64> {
    let inverse = |sum: f64| if sum > 0.0 { 1.0 / sum } else { 0.0 };
    sums.into_iter().map(inverse).collect()
}

/// `AᵀA`.
fn products(rows: &Rows) -> Stencil {
    let [p, q] = [&rows.u, &rows.v].map(|it| it.degree());
    let (columns, block) = (rows.v.count(), (q + 1) * (q + 1));
    Stencil::by_lines(rows.reach(), |k, diagonals| {
        let cells = products_of_cells(rows, k);
        for (column, cell) in cells.chunks_exact((2 * p + 1) * block).enumerate() {
            for (other, products) in cell.chunks_exact(block).enumerate() {
                for (at, product) in products.iter().enumerate() {
                    let (l, m) = (at / (q + 1), at % (q + 1));
                    let diagonal = other * (2 * q + 1) + q + m - l;
                    diagonals[diagonal * columns + column + l] += product;
                }
            }
        }
    })
}

/// For each span of v, and each function of u that meets the one of line `k`, the sums of products of two functions of v.
fn products_of_cells(rows: &Rows, k: usize) -> Vec<f64> {
    let [p, q] = [&rows.u, &rows.v].map(|it| it.degree());
    let block = (q + 1) * (q + 1);
    let mut cells = vec![0.0; (rows.v.count() - q) * (2 * p + 1) * block];
    for i in rows.points_from(k.saturating_sub(p)..k + 1) {
        let [(row, along), (column, across)] = rows.functions(i);
        let own = k - row;
        let first = (column * (2 * p + 1) + p - own) * block;
        let blocks = cells[first..][..(p + 1) * block].chunks_exact_mut(block);
        for (sums, b) in blocks.zip(along) {
            let factor = along[own] * b;
            for (sums, a) in sums.chunks_exact_mut(q + 1).zip(across) {
                add(factor * a, across, sums);
            }
        }
    }
    cells
}
