//! Fairness: a measure of bending.
//!
//! ```text
//! w ∫ ‖C^(r)‖² dt = w Xᵀ H X,   H_ij = ∫ B_i^(r) B_j^(r) dt
//! ```
//!
//! On surfaces the integrals of all squared partial derivatives of order r, each as often as it
//! occurs: for r = 2 the energy of a thin plate, `H = H₂ ⊗ H₀ + 2 H₁ ⊗ H₁ + H₀ ⊗ H₂` with the
//! matrices `H_k` of the directions. Gauss quadrature with p + 1 − k nodes on a span is exact.
//!
//! The settings have f without units: beside the mean of the squared distances, it is that of parameters scaled to
//! [0, 1], on surfaces by one factor for both, which makes the longer range 1. So with the sum Ω of the weights of the
//! data and the range ℓ of the parameters `w = f Ω ℓ^(2r − 1)`, of a surface `w = f Ω max(ℓ_u, ℓ_v)^(2r − 2)`. Then neither
//! other units of the data or of the parameters, nor more points on the same curve, change the fit.

use super::gaps::Gaps;
use super::settings::{Fairness, LeastSquares};
use crate::basis::direction::Direction;
use crate::basis::quadrature::{Row, node_rows};
use crate::interrupt;
use crate::linear::columns::Columns;
use crate::setup::Setup;

/// A weighted sum of squares of derivatives, `w Xᵀ H X`.
#[derive(Debug)]
pub(super) struct Energy {
    terms: Vec<Term>,
    gaps: Option<Gaps>,
    /// The number of control points in the v direction; 1 of a curve.
    columns: usize,
}

/// A product of both directions.
#[derive(Debug)]
struct Term {
    factor: f64,
    u: Gram,
    v: Option<Gram>,
}

/// The integrals of the products of derivatives of all functions of a direction.
#[derive(Debug)]
struct Gram {
    /// A row for each node, whose squares add up to the integral.
    rows: Vec<Row>,
    /// The matrix H, which is symmetric.
    matrix: Columns,
    /// `Σ_j |H_ij|`.
    sums: Vec<f64>,
}

impl Energy {
    /// The energy of a fit whose weights of data have this sum, or `None` where it has none, or the basis has no
    /// derivatives.
    pub(super) fn new(setup: &Setup, settings: &LeastSquares, sum: f64) -> Option<Self> {
        let gaps = settings.gap_stiffness();
        let gaps = gaps.and_then(|stiffness| Gaps::new(setup, stiffness * sum));
        let terms = match settings.fairness() {
            Some(fairness) => Self::terms(setup, fairness, sum)?,
            None => Vec::new(),
        };
        (gaps.is_some() || !terms.is_empty()).then(|| Self {
            terms,
            gaps,
            columns: setup.v().map_or(1, Direction::free),
        })
    }

    fn terms(setup: &Setup, fairness: Fairness, sum: f64) -> Option<Vec<Term>> {
        let Fairness { value, order, .. } = fairness;
        let range = |direction: &Direction| {
            let (low, high) = direction.basis.domain();
            high - low
        };
        let length = range(setup.u());
        let twice = 2 * order as i32;
        let Some(v) = setup.v() else {
            return Some(vec![Term {
                factor: value * sum * length.powi(twice - 1),
                u: Gram::new(setup.u(), order)?,
                v: None,
            }]);
        };
        let weight = value * sum * length.max(range(v)).powi(twice - 2);
        let mut terms = Vec::new();
        let mut binomial = 1.0;
        for k in 0..=order {
            terms.push(Term {
                factor: weight * binomial,
                u: Gram::new(setup.u(), order - k)?,
                v: Some(Gram::new(v, k)?),
            });
            binomial *= (order - k) as f64 / (k + 1) as f64;
        }
        Some(terms)
    }

    /// `y ← y − w H x` for one coordinate.
    pub(super) fn subtract(&self, x: &[f64], y: &mut [f64]) {
        for Term { factor, u, v } in &self.terms {
            let across: Vec<f64>;
            let x = match v {
                None => x,
                Some(v) => {
                    let lines = x.chunks_exact(self.columns);
                    across = lines.flat_map(|line| v.products(line)).collect();
                    &across
                }
            };
            let columns = self.columns;
            for (i, y) in y.chunks_exact_mut(columns).enumerate() {
                for &(k, entry) in u.matrix.column(i) {
                    let line = &x[k as usize * columns..][..columns];
                    y.iter_mut()
                        .zip(line)
                        .for_each(|(y, x)| *y -= factor * entry * x);
                }
            }
        }
        if let Some(gaps) = &self.gaps {
            gaps.subtract(x, y);
        }
    }

    /// The entries of `w H` of a surface, by the rows and columns of two control points; repeated entries add up.
    pub(super) fn each_entry(&self, mut visit: impl FnMut([usize; 2], [usize; 2], f64)) {
        for Term { factor, u, v } in &self.terms {
            let Some(v) = v else { continue };
            for k in 0..u.sums.len() {
                for &(m, a) in u.matrix.column(k) {
                    for l in 0..v.sums.len() {
                        for &(n, b) in v.matrix.column(l) {
                            visit([k, l], [m as usize, n as usize], factor * a * b);
                        }
                    }
                }
            }
        }
        if let Some(gaps) = &self.gaps {
            gaps.each_entry(visit);
        }
    }

    /// Adds at least `w Σ_j |H_ij|` for each control point i: that itself on curves.
    pub(super) fn add_sums(&self, sums: &mut [f64]) {
        for Term { factor, u, v } in &self.terms {
            let one = [1.0];
            let across = v.as_ref().map_or(&one[..], |v| &v.sums);
            let products = u.sums.iter();
            let products = products.flat_map(|a| across.iter().map(move |b| factor * a * b));
            sums.iter_mut().zip(products).for_each(|(sum, x)| *sum += x);
        }
        if let Some(gaps) = &self.gaps {
            gaps.add_sums(sums);
        }
    }

    /// The cost, in multiplications, of all integrals of products: each product is searched for among those of its
    /// function, four in the time of a multiplication.
    pub(super) fn cost(setup: &Setup, order: usize) -> usize {
        let of = |direction: &Direction| {
            let width = direction.basis.degree() + 1;
            direction.free().saturating_mul(width.saturating_pow(4)) / 4
        };
        let grams = setup.directions().map(of).fold(0, usize::saturating_add);
        grams.saturating_mul(order + 1)
    }

    /// The number of rows.
    pub(super) fn count(setup: &Setup, settings: &LeastSquares) -> usize {
        let gaps = settings.gap_stiffness().map_or(0, |_| Gaps::count(setup));
        let bending = settings
            .fairness()
            .map_or(0, |it| Self::count_of_bending(setup, it.order));
        gaps.saturating_add(bending)
    }

    fn count_of_bending(setup: &Setup, order: usize) -> usize {
        let nodes = |direction: &Direction| {
            direction
                .free()
                .saturating_mul(direction.basis.degree() + 1)
        };
        let products = setup.directions().map(nodes).fold(1, usize::saturating_mul);
        products.saturating_mul(if setup.v().is_some() { order + 1 } else { 1 })
    }

    /// Rows G with `Gᵀ G = w H`.
    pub(super) fn each_row(&self, mut visit: impl FnMut(Vec<(usize, f64)>)) {
        for Term { factor, u, v } in &self.terms {
            let root = factor.sqrt();
            for along in &u.rows {
                let Some(v) = v else {
                    visit(along.iter().map(|&(i, a)| (i, root * a)).collect());
                    continue;
                };
                for across in &v.rows {
                    let products = along.iter().flat_map(|&(i, a)| {
                        let across = across.iter();
                        across.map(move |&(j, b)| (i * self.columns + j, root * a * b))
                    });
                    visit(products.collect());
                }
            }
        }
        if let Some(gaps) = &self.gaps {
            gaps.each_row(visit);
        }
    }
}

impl Gram {
    fn new(direction: &Direction, order: usize) -> Option<Self> {
        let rows: Vec<Row> = node_rows(direction, order)?.into_iter().flatten().collect();
        let mut lines = vec![Vec::<(usize, f64)>::new(); direction.free()];
        for row in &rows {
            interrupt::check();
            for &(i, a) in row {
                for &(j, b) in row {
                    match lines[i].iter_mut().find(|(other, _)| *other == j) {
                        Some((_, sum)) => *sum += a * b,
                        None => lines[i].push((j, a * b)),
                    }
                }
            }
        }
        let entries = lines.iter().enumerate();
        let entries = entries.flat_map(|(i, line)| line.iter().map(move |&(j, x)| (i, j, x)));
        let sum = |line: &Vec<(usize, f64)>| line.iter().map(|(_, x)| x.abs()).sum();
        Some(Self {
            matrix: Columns::new(direction.free(), entries),
            sums: lines.iter().map(sum).collect(),
            rows,
        })
    }

    /// `H x`.
    fn products(&self, x: &[f64]) -> Vec<f64> {
        let product = |i| {
            let column = self.matrix.column(i).iter();
            column.map(|&(j, entry)| entry * x[j as usize]).sum()
        };
        (0..x.len()).map(product).collect()
    }
}
