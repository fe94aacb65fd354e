//! Integrals over the spans of a direction, by Gauss quadrature, which is exact for polynomials.

use super::direction::Direction;

/// Numbers of control points and their factors.
pub(crate) type Row = Vec<(usize, f64)>;

/// For each span the derivatives of this order of all functions at its nodes, whose squares add up to their integrals;
/// `None` if the basis has no derivatives.
pub(crate) fn node_rows(direction: &Direction, order: usize) -> Option<Vec<Vec<Row>>> {
    let knots = direction.basis.knots()?;
    let (low, high) = direction.basis.domain();
    let nodes = gauss((direction.basis.degree() + 1).saturating_sub(order).max(1));
    let spans = knots
        .windows(2)
        .filter(|pair| low <= pair[0] && pair[1] <= high);
    let spans = spans.filter(|pair| pair[0] < pair[1]);
    let rows_of = |pair: &[f64]| {
        let (middle, half) = ((pair[0] + pair[1]) / 2.0, (pair[1] - pair[0]) / 2.0);
        let row = |&(node, weight): &(f64, f64)| {
            let mut row = direction.functional(middle + half * node, order)?;
            let root = (weight * half).sqrt();
            row.iter_mut().for_each(|(_, value)| *value *= root);
            Some(row)
        };
        nodes.iter().map(row).collect()
    };
    spans.map(rows_of).collect()
}

/// The nodes and weights of Gauss quadrature on [−1, 1], exact for polynomials of degree 2 n − 1:
/// the roots of the Legendre polynomial P_n, by Newton's method from their asymptotic places
/// (Abramowitz, Stegun 22.16.6), and `2 / ((1 − x²) P_n′(x)²)`.
fn gauss(count: usize) -> Vec<(f64, f64)> {
    let n = count as f64;
    let node = |k: usize| {
        let mut x = (std::f64::consts::PI * (k as f64 + 0.75) / (n + 0.5)).cos();
        let mut slope = 1.0;
        for _ in 0..NEWTON {
            let (mut before, mut value) = (1.0, x);
            for q in 2..=count {
                let q = q as f64;
                (before, value) = (
                    value,
                    ((2.0 * q - 1.0) * x * value - (q - 1.0) * before) / q,
                );
            }
            slope = n * (x * value - before) / (x * x - 1.0);
            x -= value / slope;
        }
        (x, 2.0 / ((1.0 - x * x) * slope * slope))
    };
    (0..count).map(node).collect()
}

/// Newton's method doubles the digits of a node in each step, of two that it starts with.
const NEWTON: usize = 8;

#[cfg(test)]
mod tests {
    use super::*;

    /// Integrals of powers up to degree 2 n − 1.
    #[test]
    fn quadrature_is_exact() {
        for count in 1..=32 {
            let nodes = gauss(count);
            for power in 0..2 * count as i32 {
                let sum: f64 = nodes.iter().map(|(x, weight)| weight * x.powi(power)).sum();
                let exact = if power % 2 == 0 {
                    2.0 / f64::from(power + 1)
                } else {
                    0.0
                };
                assert!(
                    (sum - exact).abs() < 1e-14,
                    "{count} nodes, power {power}: {sum}"
                );
            }
        }
    }
}
