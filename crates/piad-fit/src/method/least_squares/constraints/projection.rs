//! The projection of gradients and control points.

use nalgebra::{Cholesky, DMatrix, DVectorViewMut, Dyn};

use super::conditions::Condition;

/// Rounding of a decomposition, relative to its diagonal.
const ROUNDING: f64 = 1e-12;

/// The projection for conditions `C X = R` and a metric M.
#[derive(Debug)]
pub(in super::super) struct Projection {
    conditions: Vec<Condition>,
    metric: Metric,
    /// The decomposition of `C M Cᵀ`.
    gram: Cholesky<f64, Dyn>,
}

/// The matrix M.
#[derive(Debug)]
enum Metric {
    /// Its diagonal.
    Diagonal(Vec<f64>),
    /// The inverse of a matrix that is factorized elsewhere.
    Inverse,
}

impl Projection {
    /// With a diagonal M that is positive at the control points of all conditions. `None` without
    /// conditions.
    pub(in super::super) fn diagonal(conditions: &[Condition], diagonal: &[f64]) -> Option<Self> {
        let mut dense = vec![0.0; diagonal.len()];
        let mut gram = DMatrix::zeros(conditions.len(), conditions.len());
        for (k, condition) in conditions.iter().enumerate() {
            for &(j, factor) in &condition.row {
                dense[j] = factor * diagonal[j];
            }
            for (l, other) in conditions.iter().enumerate().take(k + 1) {
                let product = other.row.iter().map(|&(j, factor)| factor * dense[j]).sum();
                gram[(k, l)] = product;
                gram[(l, k)] = product;
            }
            condition.row.iter().for_each(|&(j, _)| dense[j] = 0.0);
        }
        Self::new(conditions, Metric::Diagonal(diagonal.to_vec()), gram)
    }

    /// With the inverse M of a matrix of this order, which `solve` multiplies with: `C M Cᵀ` is the
    /// Schur complement of the bordered system, made a column at a time. Conditions on control points
    /// that do not move are left out, as the start satisfies them.
    pub(in super::super) fn inverse(
        conditions: &[Condition],
        order: usize,
        mut solve: impl FnMut(&mut [f64]),
    ) -> Option<Self> {
        let all = conditions.len();
        let mut gram = DMatrix::zeros(all, all);
        let mut column = vec![0.0; order];
        for (l, condition) in conditions.iter().enumerate() {
            column.fill(0.0);
            condition.add(1.0, &mut column);
            solve(&mut column);
            for (k, condition) in conditions.iter().enumerate() {
                gram[(k, l)] = product(condition, &column);
            }
        }
        let moving: Vec<usize> = (0..all).filter(|&k| gram[(k, k)] > 0.0).collect();
        let gram = gram.select_rows(&moving).select_columns(&moving);
        let moving = moving.iter().map(|&k| conditions[k].clone());
        Self::new(&moving.collect::<Vec<_>>(), Metric::Inverse, gram)
    }

    fn new(conditions: &[Condition], metric: Metric, gram: DMatrix<f64>) -> Option<Self> {
        if conditions.is_empty() {
            return None;
        }
        // Conditions that nearly depend on each other: what the larger diagonal leaves is corrected at
        // the next level.
        let rounded = || {
            let mut gram = gram.clone();
            (0..conditions.len()).for_each(|k| gram[(k, k)] *= 1.0 + ROUNDING);
            Cholesky::new(gram)
        };
        Some(Self {
            conditions: conditions.to_vec(),
            metric,
            gram: Cholesky::new(gram.clone()).or_else(rounded)?,
        })
    }

    /// A column of `(C M Cᵀ)⁻¹`.
    pub(super) fn inverse_column(&self, k: usize) -> Vec<f64> {
        let mut unit = vec![0.0; self.conditions.len()];
        unit[k] = 1.0;
        self.multipliers(unit)
    }

    /// `C x − R` of one coordinate, without the values of tangents.
    pub(super) fn apart(&self, coordinate: usize, x: &[f64]) -> Vec<f64> {
        let value = |condition: &Condition| match condition.is_tangent {
            true => 0.0,
            false => condition.value[coordinate],
        };
        let conditions = self.conditions.iter();
        conditions
            .map(|condition| product(condition, x) - value(condition))
            .collect()
    }

    /// `λ = (C M Cᵀ)⁻¹ v`.
    fn multipliers(&self, mut values: Vec<f64>) -> Vec<f64> {
        let count = values.len();
        self.gram
            .solve_mut(&mut DVectorViewMut::from_slice(&mut values, count));
        values
    }

    /// `x ← x + S (R − C x)` for one coordinate and a diagonal M: then x satisfies the conditions.
    pub(in super::super) fn correct(&self, coordinate: usize, x: &mut [f64]) {
        let Metric::Diagonal(diagonal) = &self.metric else {
            return;
        };
        let left = |condition: &Condition| condition.value[coordinate] - product(condition, x);
        let multipliers = self.multipliers(self.conditions.iter().map(left).collect());
        for (condition, multiplier) in self.conditions.iter().zip(multipliers) {
            for &(j, factor) in &condition.row {
                x[j] += diagonal[j] * factor * multiplier;
            }
        }
    }

    /// `−Cᵀ (C M Cᵀ)⁻¹ C x`: with M times this added, a step along x leaves the conditions as they
    /// are.
    pub(in super::super) fn pull(&self, x: &[f64]) -> Vec<f64> {
        let left = self.conditions.iter();
        let left = left.map(|condition| -product(condition, x)).collect();
        let mut pull = vec![0.0; x.len()];
        for (condition, multiplier) in self.conditions.iter().zip(self.multipliers(left)) {
            condition.add(multiplier, &mut pull);
        }
        pull
    }

    /// `g ← g − Cᵀ (C M Cᵀ)⁻¹ C M g` for a diagonal M.
    pub(in super::super) fn gradient(&self, gradient: &mut [f64]) {
        let Metric::Diagonal(diagonal) = &self.metric else {
            return;
        };
        let weighted = |condition: &Condition| {
            let row = condition.row.iter();
            row.map(|&(j, factor)| factor * diagonal[j] * gradient[j])
                .sum()
        };
        let multipliers = self.multipliers(self.conditions.iter().map(weighted).collect());
        for (condition, multiplier) in self.conditions.iter().zip(multipliers) {
            for &(j, factor) in &condition.row {
                gradient[j] -= factor * multiplier;
            }
        }
    }
}

impl Condition {
    /// Adds a multiple of its row.
    fn add(&self, factor: f64, x: &mut [f64]) {
        self.row
            .iter()
            .for_each(|&(j, entry)| x[j] += factor * entry);
    }
}

/// The product of a row with numbers for all control points.
fn product(condition: &Condition, x: &[f64]) -> f64 {
    condition.row.iter().map(|&(j, factor)| factor * x[j]).sum()
}
