//! Least squares over given knots: the minimization behind the schedule.
//!
//! ```text
//! min Σ_i w_i ‖P_i − C(t_i)‖² + ε Ω/k Σ_spans h^(2r−1) ∫_span ‖C^(r)‖²,   C(t_0) = P_0 and C(t_n) = P_n on open curves
//! ```
//!
//! with the sum Ω of the weights, k spans of length h, r = 2 (1 for degree 1), and by default ε = 0. This fairness is
//! weighed span by span, so that fine knots keep their accuracy.
//!
//! The first and the last control point of an open curve are its ends, so these constraints take
//! two unknowns away and the normal equations stay banded and positive definite. Everything is
//! computed relative to the segment between the ends: `X = X⁰ + (AᵀWA)⁻¹ AᵀW (P − A X⁰)`, so that
//! data far from the origin lose no digits.

use std::sync::Arc;

use super::breaks::Breaks;
use super::gram::{Factor, Gram};
use super::knot_step::{can_move, moved};
use super::values::Values;
use crate::basis::quadrature::{Row, node_rows};
use crate::data::points::Points;

/// A minimum over some knots. Constraints and fairness are up to the implementation: the schedule only compares
/// distances.
pub(crate) trait Minimum {
    /// Returns true if steps of plain least squares come near to it, and so lead from a minimum to the next: not with
    /// constraints, fairness or freedom.
    fn has_steps(&self) -> bool {
        false
    }

    /// For each datum the distance that counts as zero; `None` if there is none.
    fn freedom(&self) -> Option<&[f64]> {
        None
    }

    /// The control points that are nearest to the data by the sum of squared distances, each
    /// multiplied with its weight, or `None` if the data do not determine them.
    fn minimum(&self, values: &Values, weights: Option<&[f64]>) -> Option<Points>;

    /// Knots over which this minimum is smaller, a step away from those over which these are its control points; `None`
    /// if knots do not move.
    fn moved_knots(
        &self,
        _values: &Values,
        _control_points: &Points,
        _damping: f64,
    ) -> Option<Breaks> {
        None
    }
}

/// Least squares of a curve with interpolated ends.
#[derive(Clone, Debug)]
pub(crate) struct LeastSquares {
    /// The data.
    pub points: Arc<Points>,
    /// The weight of each datum; `None` means equal weights.
    pub data_weights: Option<Arc<Vec<f64>>>,
    /// ε, how fair the curve is.
    pub fairness: f64,
    /// For each datum the distance that counts as zero; `None` if there is none.
    pub freedom: Option<Arc<[f64]>>,
}

impl Minimum for LeastSquares {
    fn has_steps(&self) -> bool {
        self.freedom.is_none()
    }

    fn freedom(&self) -> Option<&[f64]> {
        self.freedom.as_deref()
    }

    fn minimum(&self, values: &Values, weights: Option<&[f64]>) -> Option<Points> {
        let product: Vec<f64>;
        let weights = match (weights, self.data_weights.as_deref()) {
            (Some(weights), Some(own)) => {
                product = weights.iter().zip(own).map(|(a, b)| a * b).collect();
                Some(&product[..])
            }
            (given, own) => given.or(own.map(Vec::as_slice)),
        };
        let mut control_points = start(values.line(), &self.points);
        let bending = (self.fairness > 0.0).then(|| self.bending(values, weights));
        let bending = bending.unwrap_or_default();
        let factor = Gram::of(values, weights, &bending).factor()?;
        // Where there are few data for each control point, rounding matters: one step of refinement.
        let steps = 1 + usize::from(2 * control_points.len() > self.points.len());
        for _ in 0..steps {
            self.step(values, weights, (&factor, &bending), &mut control_points);
        }
        control_points.is_finite().then_some(control_points)
    }

    fn moved_knots(
        &self,
        values: &Values,
        control_points: &Points,
        damping: f64,
    ) -> Option<Breaks> {
        let weights = self.data_weights.as_deref().map(Vec::as_slice);
        let is_plain = self.fairness == 0.0 && can_move(values.line(), self.points.len());
        is_plain.then(|| moved(values, &self.points, weights, control_points, damping))?
    }
}

impl LeastSquares {
    /// Of data that count alike.
    pub(crate) fn of(points: &Arc<Points>) -> Self {
        Self {
            points: Arc::clone(points),
            data_weights: None,
            fairness: 0.0,
            freedom: None,
        }
    }

    /// Rows whose squares are the fairness.
    fn bending(&self, values: &Values, weights: Option<&[f64]>) -> Vec<Row> {
        let (line, data) = (values.line(), self.points.len());
        let sum: f64 = weights.map_or(data as f64, |weights| weights.iter().sum());
        let order = line.degree().min(2);
        let (turn, count) = (line.turn(), line.control_points());
        let each = self.fairness * sum / line.spans() as f64;
        let rows = node_rows(&line.direction(Arc::new(Vec::new())), order).unwrap_or_default();
        let spans = line.breaks().windows(2).map(|span| span[1] - span[0]);
        let scaled = rows.into_iter().zip(spans).flat_map(|(rows, width)| {
            let root = (each * width.powi(2 * order as i32 - 1)).sqrt();
            let scale = move |(j, b): (usize, f64)| ((j + turn) % count, root * b);
            let rows = rows.into_iter();
            rows.map(move |row| row.into_iter().map(scale).collect())
        });
        scaled.collect()
    }

    /// Adds the solution of the normal equations to control points.
    fn step(
        &self,
        values: &Values,
        weights: Option<&[f64]>,
        (factor, bending): (&Factor, &[Row]),
        x: &mut Points,
    ) {
        let (width, data) = (values.width(), self.points.lanes());
        let (fixed, count) = (values.line().fixed_ends(), x.len());
        let sums = values.right_sides(data, x.lanes(), weights);
        for (c, x) in x.lanes_mut().iter_mut().enumerate() {
            let mut right = vec![0.0; count];
            for (part, sums) in values
                .parts()
                .iter()
                .zip(sums.chunks_exact(data.len() * width))
            {
                values.add_to(&mut right, part, &sums[c * width..(c + 1) * width]);
            }
            for row in bending {
                let product: f64 = row.iter().map(|&(j, b)| b * x[j]).sum();
                row.iter().for_each(|&(j, b)| right[j] -= b * product);
            }
            factor.solve(&mut right[fixed..count - fixed]);
            let moved = x[fixed..count - fixed].iter_mut();
            moved.zip(&right[fixed..]).for_each(|(x, step)| *x += step);
        }
    }
}

/// The control points of the segment from the first datum to the last one, at the speed of the
/// parameters; of a closed curve the first datum.
pub(super) fn start(line: &Breaks, points: &Points) -> Points {
    let count = line.control_points();
    let breaks = line.breaks();
    let (low, high) = (breaks[0], breaks[line.spans()]);
    let last = points.len() - 1;
    let greville = |j: usize| {
        let knots = 1..=line.degree();
        let mean = knots
            .map(|k| (line.knot((j + k) as isize) - low) / (high - low))
            .sum::<f64>()
            / line.degree() as f64;
        // At the ends exactly.
        match j {
            0 => 0.0,
            _ if j + 1 == count => 1.0,
            _ => mean,
        }
    };
    Points::from_lanes(points.lanes().iter().map(|lane| {
        let at = |j: usize| match line.is_closed() {
            true => lane[0],
            false => {
                let s = greville(j);
                (1.0 - s) * lane[0] + s * lane[last]
            }
        };
        (0..count).map(at).collect::<Vec<f64>>()
    }))
}
