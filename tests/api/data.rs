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

/// A job that goes on until it is stopped: its tolerance cannot be reached.
pub fn endless_job() -> Value {
    json!({"curve": {"points": wave(100)}, "stop": {"tolerance": 0, "max_iterations": 1_000_000_000}})
}
