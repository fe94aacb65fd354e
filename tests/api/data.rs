//! Data of the papers, and others, from their formulas.

use std::f64::consts::PI;

use serde_json::{Value, json};

/// The lemniscate of Gerono, 11 points (DP07, Table 1).
pub fn lemniscate() -> Value {
    let points: Vec<[f64; 2]> = (0..=10)
        .map(|i| -PI / 2.0 + f64::from(i) * 2.0 * PI / 10.0)
        .map(|u| [u.cos(), u.sin() * u.cos()])
        .collect();
    json!(points)
}

/// A helix of three turns, 30 points (LBW05, Figs 5 and 6).
pub fn helix() -> Value {
    let points: Vec<[f64; 3]> = (0..30)
        .map(|i| 6.0 * PI * f64::from(i) / 29.0)
        .map(|a| [a.cos(), a.sin(), a / 2.0])
        .collect();
    json!(points)
}

/// MATLAB's `peaks(n)` as points (x, y, z); rows are lines of equal y.
pub fn peaks(n: usize) -> Value {
    let steps: Vec<f64> = (0..n)
        .map(|i| -3.0 + 6.0 * i as f64 / (n - 1) as f64)
        .collect();
    let z = |x: f64, y: f64| {
        3.0 * (1.0 - x).powi(2) * (-x * x - (y + 1.0).powi(2)).exp()
            - 10.0 * (x / 5.0 - x.powi(3) - y.powi(5)) * (-x * x - y * y).exp()
            - (-(x + 1.0).powi(2) - y * y).exp() / 3.0
    };
    let row = |y: f64| steps.iter().map(|&x| [x, y, z(x, y)]).collect();
    let rows: Vec<Vec<[f64; 3]>> = steps.iter().map(|&y| row(y)).collect();
    json!(rows)
}

/// A wavy closed curve without equal neighbours.
pub fn wave(n: usize) -> Value {
    let points: Vec<[f64; 2]> = (0..n)
        .map(|i| 2.0 * PI * i as f64 / n as f64)
        .map(|a| (a, 2.0 + (5.0 * a).sin() * 0.3))
        .map(|(a, r)| [r * a.cos(), r * a.sin()])
        .collect();
    json!(points)
}

/// A small job that converges within a few dozen iterations.
pub fn small_job() -> Value {
    json!({"curve": {"points": wave(100)}, "stop": {"relative_tolerance": 1e-9}})
}

/// A job that runs until it is cancelled: its tolerance cannot be reached.
pub fn endless_job() -> Value {
    json!({"curve": {"points": wave(100)}, "stop": {"tolerance": 0, "max_iterations": 1_000_000_000}})
}

/// Parameters of points by chord length.
pub fn chord_lengths<const D: usize>(points: &[[f64; D]]) -> Vec<f64> {
    let distance = |pair: &[[f64; D]]| {
        let squares = pair[0].iter().zip(&pair[1]).map(|(a, b)| (b - a).powi(2));
        squares.sum::<f64>().sqrt()
    };
    let sum = |sum: &mut f64, pair: &[[f64; D]]| {
        *sum += distance(pair);
        Some(*sum)
    };
    let lengths = points.windows(2).scan(0.0, sum);
    std::iter::once(0.0).chain(lengths).collect()
}

/// Clamped knots for fewer control points than parameters (Piegl & Tiller (9.68)–(9.69)).
pub fn piegl_tiller(t: &[f64], degree: usize, control_points: usize) -> Vec<f64> {
    let spans = control_points - degree;
    let d = t.len() as f64 / spans as f64;
    let interior = (1..spans).map(|j| {
        let x = j as f64 * d;
        let i = x as usize;
        let alpha = x - i as f64;
        (1.0 - alpha) * t[i - 1] + alpha * t[i]
    });
    let end = |t| std::iter::repeat_n(t, degree + 1);
    let (first, last) = (t[0], t[t.len() - 1]);
    end(first).chain(interior).chain(end(last)).collect()
}
