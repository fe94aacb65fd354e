//! Control points from derivatives, on one side of a direction.
//!
//! With knots at the data the functions 1 … k beside the outermost one, counted from the end, have
//! control points that are copies of its control point c_0 but for constants g_j. The curve has the
//! Taylor coefficients a_1 … a_k at its end if (by its polar form, whose arguments are p − j times
//! the end and the first j parameters s_1 … s_j behind it)
//!
//! ```text
//! c_j = c_0 + g_j,   g_j = Σ_{r=1}^{j} a_r e_r(s_1 … s_j) / C(p, r)
//! ```
//!
//! with the elementary symmetric polynomials e_r; of a cubic `g_1 = a_1 s_1 / 3`. With fixed weights
//! the same holds of `w_j c_j` and the products of a and the Taylor coefficients of `Σ w_k B_k`.
//!
//! Lengths s are relative to the furthest parameter that is used, so that nothing leaves the range
//! of numbers whatever the unit of the parameters.

use crate::basis::direction::Direction;
use crate::invalid::Side;

/// The copies of the outermost control point on one side of a direction.
#[derive(Debug)]
pub(super) struct Copies {
    side: Side,
    /// The number of copies, k.
    pub(super) count: usize,
    /// The number of basis functions, and of data points.
    functions: usize,
    points: usize,
    /// By how much the parameter changes where s changes by one; negative at the end.
    pub(super) unit: f64,
    /// The used parameters of the data points from the end on.
    pub(super) parameters: Vec<f64>,
    /// `e_r(s_1 … s_j) / C(p, r)`: r = 1 … j for each j.
    shares: Vec<Vec<f64>>,
    /// The fixed weights of functions 0 … k, and the Taylor coefficients of `Σ w_k B_k`.
    weights: Option<[Vec<f64>; 2]>,
}

impl Copies {
    /// The copies on one side of an open direction with knots at the data; `None` if there are
    /// none.
    pub(super) fn new(direction: &Direction, side: Side) -> Option<Self> {
        let count = direction.copies(side);
        if count == 0 {
            return None;
        }
        let (t, degree) = (&direction.parameters, direction.basis.degree());
        let points = t.len();
        let last = points - 1;
        let from_end = |i: usize| match side {
            Side::Start => t[i] - t[0],
            Side::End => t[last - i] - t[last],
        };
        let used = (count + 1).min(last);
        let unit = from_end(used);
        // Behind the last data point there are the knots at the other end.
        let behind = |j: usize| from_end(j.min(last)) / unit;
        let shares = shares(degree, (1..=count).map(behind));
        let parameters = (0..=used).map(|i| match side {
            Side::Start => t[i],
            Side::End => t[last - i],
        });
        let mut copies = Self {
            side,
            count,
            functions: direction.basis.functions(),
            points,
            unit,
            parameters: parameters.collect(),
            shares,
            weights: None,
        };
        copies.weights = direction.weights().map(|weights| {
            let own: Vec<f64> = (0..=count).map(|j| weights[copies.function(j)]).collect();
            let taylor = copies.taylor_of_weights(&own);
            [own, taylor]
        });
        Some(copies)
    }

    /// The basis function of copy j = 1 … k; that of the control point itself is j = 0.
    pub(super) fn function(&self, j: usize) -> usize {
        match self.side {
            Side::Start => j,
            Side::End => self.functions - 1 - j,
        }
    }

    /// The place of the data point that is the i-th one from this end.
    pub(super) fn point(&self, i: usize) -> usize {
        match self.side {
            Side::Start => i,
            Side::End => self.points - 1 - i,
        }
    }

    /// The constants g_1 … g_k of one coordinate, from its Taylor coefficients a_1 … a_k.
    pub(super) fn offsets(&self, taylor: &[f64]) -> Vec<f64> {
        let sum = |shares: &[f64], taylor: &[f64]| -> f64 {
            shares.iter().zip(taylor).map(|(s, a)| s * a).sum()
        };
        let Some([weights, of_weights]) = &self.weights else {
            return self.shares.iter().map(|it| sum(it, taylor)).collect();
        };
        let product = |r: usize| -> f64 {
            let terms = of_weights.iter().zip(taylor[..=r].iter().rev());
            terms.map(|(w, a)| w * a).sum()
        };
        let products: Vec<f64> = (0..taylor.len()).map(product).collect();
        let shares = self.shares.iter().zip(&weights[1..]);
        shares.map(|(it, w)| sum(it, &products) / w).collect()
    }

    /// The Taylor coefficients of `Σ w_k B_k`, from the constant one on.
    fn taylor_of_weights(&self, weights: &[f64]) -> Vec<f64> {
        let mut taylor = vec![weights[0]];
        for (shares, weight) in self.shares.iter().zip(&weights[1..]) {
            let before: f64 = shares.iter().zip(&taylor[1..]).map(|(s, a)| s * a).sum();
            let own = shares.last().copied().unwrap_or(1.0);
            taylor.push((weight - weights[0] - before) / own);
        }
        taylor
    }

    /// The part β of the next control point in natural ends, `c_1 = (1 − β) c_0 + β c_2`, of a cubic
    /// without second derivative at its end, with fixed weights or none.
    pub(super) fn natural(direction: &Direction, side: Side) -> f64 {
        let (t, last) = (&direction.parameters, direction.parameters.len() - 1);
        let gap = |i: usize| match side {
            Side::Start => t[i.min(last)] - t[0],
            Side::End => t[last] - t[last.saturating_sub(i)],
        };
        let (h, both) = (gap(1), gap(1) + gap(2));
        let Some(weights) = direction.weights() else {
            return h / both;
        };
        let functions = direction.basis.functions();
        let weight = |j: usize| match side {
            Side::Start => weights[j],
            Side::End => weights[functions - 1 - j],
        };
        // With C'' = 0: w_2 (c_2 − c_0) = (w_0 T_21 + 2 W' T_22) C', w_1 (c_1 − c_0) = w_0 T_11 C'.
        let [w0, w1, w2] = [0, 1, 2].map(weight);
        let slope = w0 * (both / 3.0 - gap(2)) + w1 * gap(2);
        w2 * w0 * (h / 3.0) / (w1 * slope)
    }
}

/// `e_r(s_1 … s_j) / C(p, r)`, r = 1 … j, for j = 1, 2, …
fn shares(degree: usize, arguments: impl Iterator<Item = f64>) -> Vec<Vec<f64>> {
    let mut symmetric = vec![1.0];
    let mut rows = Vec::new();
    for s in arguments {
        symmetric.push(0.0);
        for r in (1..symmetric.len()).rev() {
            symmetric[r] += s * symmetric[r - 1];
        }
        let mut choices = 1.0;
        let share = |(r, e): (usize, &f64)| {
            choices *= (degree - r) as f64 / (r + 1) as f64;
            e / choices
        };
        rows.push(symmetric[1..].iter().enumerate().map(share).collect());
    }
    rows
}
