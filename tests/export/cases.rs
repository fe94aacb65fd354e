//! Jobs of every kind that has a form of its own in a file.

use std::f64::consts::PI;

use serde_json::{Value, json};

/// A job, and the name of its files.
pub struct Case {
    pub file: &'static str,
    pub job: Value,
}

/// All of them.
pub fn all() -> Vec<Case> {
    let mut cases = curves();
    cases.extend(closed());
    cases.extend(polynomials());
    cases.extend(rational_curves());
    cases.extend(surfaces());
    cases.extend(rational_surfaces());
    let case = |(file, job)| Case { file, job };
    cases.into_iter().map(case).collect()
}

type Jobs = Vec<(&'static str, Value)>;

/// A wave, a straight edge with points, and two with none.
fn outline() -> Vec<[f64; 2]> {
    let wave = (0..=10).map(f64::from).map(|x| [x, (0.6 * x).sin()]);
    let edge = (1..=10)
        .map(f64::from)
        .map(|x| [10.0 + x, (6_f64).sin() - x]);
    let last = [[25.0, -8.0], [25.0, 2.0], [20.0, 4.0]];
    wave.chain(edge).chain(last).collect()
}

fn curves() -> Jobs {
    let names = "Flügel 'A' \\ 翼 <b>&amp; \"x\"\n🛩";
    vec![
        ("cubic", curve("helix", helix(30), json!({"degree": 3}))),
        ("linear", curve("", zigzag(), json!({"degree": 1}))),
        ("quadratic", curve("q", wave(17), json!({"degree": 2}))),
        ("quintic", curve(names, wave(40), json!({"degree": 5}))),
        (
            "averaged",
            curve(
                "averaged",
                helix(21),
                json!({"degree": 4, "knots": "averaged"}),
            ),
        ),
        ("explicit", explicit()),
        (
            "least_squares",
            json!({
                "curve": {"points": wave(200)},
                "method": {"kind": "least_squares", "control_points": 20, "variant": "cg"},
            }),
        ),
        (
            "corners",
            json!({"curve": {"points": outline(), "corners": [10, 20, 21, 22]}, "method": "direct"}),
        ),
        (
            "polyline",
            json!({"curve": {"points": [[0, 0], [80, 0], [80, 20], [30, 20], [22, 25], [20, 30], [20, 60], [0, 60]], "closed": true, "polyline": true},
                "stop": {"tolerance": 0.05}}),
        ),
        (
            "tiny",
            curve("tiny", scaled(wave(12), 1e-9, 0.0), json!({})),
        ),
        (
            "huge",
            curve("huge", scaled(wave(12), 1e12, 0.0), json!({})),
        ),
        ("far", curve("far", scaled(helix(30), 1.0, 5e6), json!({}))),
    ]
}

fn closed() -> Jobs {
    let closed = |degree: usize, points: Value| {
        json!({
            "curve": {"points": points, "closed": true, "basis": {"kind": "bspline", "degree": degree}},
            "stop": {"relative_tolerance": 1e-9},
        })
    };
    let knot = |n: usize| -> Vec<[f64; 3]> {
        let turn = |i| 2.0 * PI * f64::from(i) / n as f64;
        let angles = (0..n as u32).map(turn);
        let place = |a: f64| {
            let r = 2.0 + (3.0 * a).cos();
            [r * (2.0 * a).cos(), r * (2.0 * a).sin(), (3.0 * a).sin()]
        };
        angles.map(place).collect()
    };
    let mut rational = closed(3, wave(24));
    rational["curve"]["weights"] = json!(
        (0..24)
            .map(|i| 1.0 + 0.3 * f64::from(i).sin())
            .collect::<Vec<_>>()
    );
    let mut fixed = rational.clone();
    fixed["rational"] = json!("fixed");
    vec![
        ("closed_1", closed(1, wave(9))),
        ("closed_2", closed(2, wave(24))),
        ("closed_3", closed(3, json!(knot(40)))),
        ("closed_4", closed(4, json!(knot(33)))),
        ("closed_5", closed(5, wave(30))),
        ("closed_few", closed(3, wave(4))),
        ("closed_homogeneous", rational),
        ("closed_fixed", fixed),
    ]
}

fn polynomials() -> Jobs {
    let polynomial = |kind: &str, points: Value, method: &str| {
        json!({
            "curve": {"points": points, "basis": {"kind": kind}, "parameters": "uniform"},
            "method": {"kind": method},
            "stop": {"max_iterations": 200},
        })
    };
    vec![
        (
            "bernstein",
            polynomial("bernstein", lemniscate(11), "global"),
        ),
        ("bernstein_25", polynomial("bernstein", helix(26), "global")),
        ("bernstein_29", polynomial("bernstein", helix(30), "global")),
        (
            "said_ball",
            polynomial("said_ball", lemniscate(11), "global"),
        ),
        ("said_ball_odd", polynomial("said_ball", helix(8), "global")),
        (
            "wang_ball",
            polynomial("wang_ball", lemniscate(5), "extended"),
        ),
        (
            "wang_ball_odd",
            polynomial("wang_ball", helix(10), "extended"),
        ),
    ]
}

fn rational_curves() -> Jobs {
    let weights =
        |n: usize| -> Vec<f64> { (0..n).map(|i| 1.0 + 0.4 * (0.4 * i as f64).sin()).collect() };
    let rational = |how: &str, basis: Value, points: Value| {
        let count = points.as_array().unwrap().len();
        json!({
            "curve": {"points": points, "basis": basis, "weights": weights(count)},
            "rational": how,
            "stop": {"relative_tolerance": 1e-10, "max_iterations": 2000},
        })
    };
    let spline = json!({"kind": "bspline", "degree": 3});
    vec![
        (
            "arc",
            json!({
                "name": "quarter circle",
                "curve": {
                    "points": [[1, 0], [0.6, 0.8], [0, 1]], "weights": [1, 1.25, 2],
                    "basis": {"kind": "bernstein"}, "parameters": [0, 0.5, 1],
                },
                "stop": {"tolerance": 1e-13},
            }),
        ),
        (
            "homogeneous",
            rational("homogeneous", spline.clone(), helix(25)),
        ),
        ("fixed", rational("fixed", spline, helix(25))),
        (
            "said_ball_homogeneous",
            rational("homogeneous", json!({"kind": "said_ball"}), lemniscate(8)),
        ),
        (
            "said_ball_fixed",
            rational("fixed", json!({"kind": "said_ball"}), lemniscate(7)),
        ),
    ]
}

fn surfaces() -> Jobs {
    let spline = |degree: usize| json!({"kind": "bspline", "degree": degree});
    let two = |u: Value, v: Value| json!({"u": u, "v": v});
    vec![
        ("peaks", surface("peaks", peaks(11, 11), spline(3))),
        (
            "mixed",
            surface(
                "mixed",
                peaks(9, 14),
                two(spline(4), json!({"kind": "bernstein"})),
            ),
        ),
        (
            "ball_both",
            surface(
                "",
                peaks(6, 7),
                two(json!({"kind": "said_ball"}), json!({"kind": "said_ball"})),
            ),
        ),
        (
            "ball_and_spline",
            surface(
                "",
                peaks(6, 9),
                two(json!({"kind": "said_ball"}), spline(2)),
            ),
        ),
        ("planar", surface("planar", flat(8, 7), spline(3))),
        (
            "degree_1_2",
            surface("", peaks(7, 8), two(spline(1), spline(2))),
        ),
        (
            "tube",
            turned(tube(14, 9), json!({"u": true, "v": false}), json!(3)),
        ),
        ("torus", turned(torus(16, 12), json!(true), json!(3))),
        ("torus_even", turned(torus(15, 13), json!(true), json!(2))),
        (
            "surface_least_squares",
            json!({
                "surface": {"points": peaks(30, 25)},
                "method": {"kind": "least_squares", "control_points": {"u": 12, "v": 10}, "variant": "cg"},
            }),
        ),
    ]
}

fn rational_surfaces() -> Jobs {
    let row = |n: usize| -> Vec<f64> { (0..n).map(|i| 1.0 + (i % 3) as f64).collect() };
    let with = |mut job: Value, how: &str, weights: Value| {
        job["surface"]["weights"] = weights;
        job["rational"] = json!(how);
        job
    };
    let grid: Vec<Vec<f64>> = (0..8)
        .map(|i| {
            (0..9)
                .map(|j| 1.0 + 0.3 * (0.1 * f64::from(i * j)).sin())
                .collect()
        })
        .collect();
    let spline = json!({"kind": "bspline", "degree": 3});
    let ball = json!({"u": {"kind": "said_ball"}, "v": {"kind": "bspline", "degree": 2}});
    vec![
        (
            "surface_homogeneous",
            with(
                surface("", peaks(8, 9), spline.clone()),
                "homogeneous",
                json!(grid),
            ),
        ),
        (
            "surface_fixed",
            with(
                surface("", peaks(8, 9), spline),
                "fixed",
                json!({"u": row(8), "v": row(9)}),
            ),
        ),
        (
            "ball_fixed",
            with(
                surface("", peaks(5, 9), ball),
                "fixed",
                json!({"u": row(5), "v": row(9)}),
            ),
        ),
        (
            "torus_fixed",
            with(
                turned(torus(12, 10), json!(true), json!(3)),
                "fixed",
                json!({"u": row(12), "v": row(10)}),
            ),
        ),
    ]
}

fn curve(name: &str, points: Value, settings: Value) -> Value {
    let mut basis = settings;
    basis["kind"] = json!("bspline");
    json!({
        "name": name,
        "curve": {"points": points, "basis": basis},
        "stop": {"relative_tolerance": 1e-10},
    })
}

/// Knots of higher multiplicity: a corner and a jump of the curvature.
fn explicit() -> Value {
    let parameters: Vec<f64> = (0..13).map(|i| f64::from(i) / 12.0).collect();
    let knots = [
        0.0, 0.0, 0.0, 0.0, 0.2, 0.35, 0.35, 0.5, 0.5, 0.5, 0.7, 0.75, 0.9, 1.0, 1.0, 1.0, 1.0,
    ];
    json!({
        "name": "explicit",
        "curve": {
            "points": helix(13),
            "basis": {"kind": "bspline", "degree": 3, "knots": knots},
            "parameters": parameters,
        },
        "method": {"kind": "direct"},
    })
}

fn surface(name: &str, points: Value, basis: Value) -> Value {
    json!({
        "name": name,
        "surface": {"points": points, "basis": basis},
        "stop": {"relative_tolerance": 1e-4, "max_iterations": 5000},
    })
}

fn turned(points: Value, closed: Value, degree: Value) -> Value {
    json!({
        "surface": {
            "points": points, "closed": closed,
            "basis": {"kind": "bspline", "degree": degree}, "parameters": "uniform",
        },
        "method": {"kind": "chebyshev"},
        "stop": {"relative_tolerance": 1e-9},
    })
}

fn helix(n: u32) -> Value {
    let angle = |i| 6.0 * PI * f64::from(i) / f64::from(n - 1);
    let points: Vec<[f64; 3]> = (0..n)
        .map(angle)
        .map(|a| [a.cos(), a.sin(), a / 2.0])
        .collect();
    json!(points)
}

fn lemniscate(n: u32) -> Value {
    let angle = |i| -PI / 2.0 + 2.0 * PI * f64::from(i) / f64::from(n - 1);
    let points: Vec<[f64; 2]> = (0..n)
        .map(angle)
        .map(|u| [u.cos(), u.sin() * u.cos()])
        .collect();
    json!(points)
}

fn wave(n: u32) -> Value {
    let angle = |i| 2.0 * PI * f64::from(i) / f64::from(n);
    let place = |a: f64| {
        let r = 2.0 + 0.3 * (5.0 * a).sin();
        [r * a.cos(), r * a.sin()]
    };
    let points: Vec<[f64; 2]> = (0..n).map(angle).map(place).collect();
    json!(points)
}

fn zigzag() -> Value {
    json!([[0, 0, 0], [1, 2, 0.5], [2, 0, 1], [3, 2, 1.5], [4.5, -1, 2]])
}

fn scaled(points: Value, factor: f64, shift: f64) -> Value {
    let points: Vec<Vec<f64>> = serde_json::from_value(points).unwrap();
    let moved = points
        .iter()
        .map(|point| point.iter().map(|x| x * factor + shift).collect());
    json!(moved.collect::<Vec<Vec<f64>>>())
}

/// MATLAB's `peaks`, with different numbers of rows and columns.
fn peaks(rows: u32, columns: u32) -> Value {
    let z = |x: f64, y: f64| {
        3.0 * (1.0 - x).powi(2) * (-x * x - (y + 1.0).powi(2)).exp()
            - 10.0 * (x / 5.0 - x.powi(3) - y.powi(5)) * (-x * x - y * y).exp()
            - (-(x + 1.0).powi(2) - y * y).exp() / 3.0
    };
    grid(rows, columns, |s, t| {
        let (x, y) = (6.0 * s - 3.0, 6.0 * t - 3.0);
        vec![x, y, z(x, y)]
    })
}

fn flat(rows: u32, columns: u32) -> Value {
    grid(rows, columns, |s, t| {
        vec![(1.0 + s) * (2.0 * t).cos(), (1.0 + s) * (2.0 * t).sin()]
    })
}

/// Closed in u: the last row is not the first again.
fn tube(rows: u32, columns: u32) -> Value {
    grid(rows, columns, |s, t| {
        let a = 2.0 * PI * s * f64::from(rows - 1) / f64::from(rows);
        let r = 1.0 + 0.4 * (3.0 * t).sin();
        vec![r * a.cos(), r * a.sin(), 3.0 * t]
    })
}

/// Closed in both directions.
fn torus(rows: u32, columns: u32) -> Value {
    grid(rows, columns, |s, t| {
        let a = 2.0 * PI * s * f64::from(rows - 1) / f64::from(rows);
        let b = 2.0 * PI * t * f64::from(columns - 1) / f64::from(columns);
        let r = 3.0 + b.cos();
        vec![r * a.cos(), r * a.sin(), b.sin()]
    })
}

fn grid(rows: u32, columns: u32, place: impl Fn(f64, f64) -> Vec<f64>) -> Value {
    let part = |i: u32, n: u32| f64::from(i) / f64::from(n - 1);
    let row = |i| {
        (0..columns)
            .map(|j| place(part(i, rows), part(j, columns)))
            .collect()
    };
    json!((0..rows).map(row).collect::<Vec<Vec<Vec<f64>>>>())
}
