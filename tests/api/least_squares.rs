//! Least-squares fits: fewer control points than data.

use std::f64::consts::{FRAC_PI_4, TAU};

use serde_json::{Value, json};

use crate::data;
use crate::support::{Server, problem};

fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("{value} is no number"))
}

fn wiggle() -> (Vec<f64>, Vec<[f64; 2]>) {
    let t: Vec<f64> = (0..=40).map(|i| f64::from(i) / 40.0).collect();
    let points = t
        .iter()
        .map(|x| [*x, (6.0 * x).sin() + 0.1 * (40.0 * x).cos()])
        .collect();
    (t, points)
}

/// Control points of `scipy.interpolate.make_lsq_spline` (scipy 1.17.1) on the knots of Piegl &
/// Tiller (9.68)–(9.69).
const MINIMUM: [[f64; 2]; 10] = [
    [0.0, 0.12447262330593666],
    [0.040476190476190686, 0.09712277690607181],
    [0.12976190476190447, 0.8696685120453358],
    [0.267857142857143, 1.090038023450126],
    [0.414285714285714, 0.726217966462153],
    [0.560714285714286, -0.283088619390823],
    [0.7071428571428571, -0.9699077705563128],
    [0.853571428571428, -1.1276425353128423],
    [0.9511904761904767, -0.4486363256888878],
    [1.0, -0.3218596436972815],
];

#[tokio::test]
async fn the_minimum_is_that_of_scipy() {
    let server = Server::start().await;
    let (t, points) = wiggle();
    // The fit ends where its error falls by less than a millionth. It is quadratic at the minimum, so
    // that control points are a few times the root of that away. Conjugate gradients are exact
    // after ten steps.
    for (variant, tolerance, rms_tolerance, gradient) in [
        ("cg", 1e-9, 1e-10, 1e-18),
        ("direct", 1e-12, 1e-12, 1e-26),
        ("diagonal", 1e-2, 1e-4, 1e-6),
        ("lspia", 1e-2, 1e-4, 1e-6),
    ] {
        let story = server
            .stream(&json!({
                "curve": {
                    "points": points, "parameters": t,
                    "basis": {"kind": "bspline", "knots": data::piegl_tiller(&t, 3, 10)},
                },
                "method": {"kind": "least_squares", "control_points": 10, "variant": variant, "end_points": "free"},
                "stop": {"tolerance": 1e-9, "max_iterations": 10_000},
            }))
            .await;
        // The data do not lie on such a curve.
        assert_eq!(story.state(), "stalled", "{variant}");
        assert_eq!(story.end["reason"], "minimum");
        let last = story.iterations.last().unwrap();
        let rms = number(&last["error"]["rms"]);
        assert!((rms / 0.06523143017015508 - 1.0).abs() < rms_tolerance);
        assert!(number(&last["error"]["gradient"]) < gradient);
        assert_eq!(story.iterations[0]["error"]["gradient"], 1.0);
        for (control_point, expected) in last["control_points"]
            .as_array()
            .unwrap()
            .iter()
            .zip(MINIMUM)
        {
            for c in 0..2 {
                let deviation = (number(&control_point[c]) - expected[c]).abs();
                assert!(deviation < tolerance, "{variant}: {deviation}");
            }
        }
    }
}

/// r = 2 + 4 cos(2θ + π/4) + cos(3θ + π/4), 15001 points, 3001 control points: `diagonal` and `cg` take two
/// iterations to ‖Aᵀr‖²/‖Aᵀr⁰‖² < 1e-6.
#[tokio::test]
async fn the_published_curve_takes_two_iterations() {
    let server = Server::start().await;
    let points: Vec<[f64; 2]> = (0..=15_000)
        .map(|i| TAU * f64::from(i) / 15_000.0)
        .map(|a| {
            (
                a,
                2.0 + 4.0 * (2.0 * a + FRAC_PI_4).cos() + (3.0 * a + FRAC_PI_4).cos(),
            )
        })
        .map(|(a, r)| [r * a.cos(), r * a.sin()])
        .collect();
    let knots = data::piegl_tiller(&data::chord_lengths(&points), 3, 3001);
    for variant in ["diagonal", "cg"] {
        let job = server
            .fit(&json!({
                "curve": {"points": points, "basis": {"kind": "bspline", "knots": knots}},
                "method": {"kind": "least_squares", "control_points": 3001, "variant": variant},
                "stop": {"tolerance": 0, "max_iterations": 2},
            }))
            .await;
        assert_eq!(job["iteration"], 2);
        assert!(number(&job["error"]["gradient"]) < 1e-6, "{variant}: {job}");
        let first = server
            .json(&format!(
                "{}/iterations/1",
                job["links"]["self"].as_str().unwrap()
            ))
            .await;
        assert!(number(&first["error"]["gradient"]) > 1e-6);
    }
}

#[tokio::test]
async fn surfaces_with_holes_are_fitted_around_them() {
    let server = Server::start().await;
    let whole = data::peaks(30);
    let mut holed = whole.clone();
    // A corner, a window as wide as several control points, and scattered points.
    for (i, j) in (0..4).flat_map(|i| (0..4).map(move |j| (i, j))) {
        holed[i][j] = Value::Null;
    }
    for (i, j) in (10..20).flat_map(|i| (12..22).map(move |j| (i, j))) {
        holed[i][j] = Value::Null;
    }
    holed[25][3] = Value::Null;
    for variant in ["diagonal", "lspia", "cg", "direct"] {
        for points in [&whole, &holed] {
            let story = server
                .stream(&json!({
                    "surface": {"points": points},
                    "method": {
                        "kind": "least_squares", "variant": variant,
                        "control_points": {"u": 15, "v": 14},
                    },
                    "stop": {"tolerance": 1e-3, "max_iterations": 500},
                }))
                .await;
            // The other variants descend slowly near the minimum.
            assert!(!["cg", "direct"].contains(&variant) || story.end["reason"] == "minimum");
            let last = story.iterations.last().unwrap();
            assert!(
                number(&last["error"]["rms"]) < 0.12,
                "{variant}: {}",
                last["error"]
            );
            assert!(number(&last["error"]["rms"]) < number(&story.iterations[0]["error"]["rms"]));
            let net = last["control_points"].as_array().unwrap();
            assert_eq!((net.len(), net[0].as_array().unwrap().len()), (15, 14));
        }
    }
}

/// Control points without data keep their place.
#[tokio::test]
async fn control_points_without_data_stay() {
    let server = Server::start().await;
    // Explicit knots with many spans in a gap between the parameters.
    let t: Vec<f64> = (0..30)
        .map(|i| f64::from(i) / 100.0)
        .chain([0.98, 0.99, 1.0])
        .collect();
    let points: Vec<[f64; 2]> = t.iter().map(|t| [*t, t * t]).collect();
    let knots = json!([
        0, 0, 0, 0, 0.1, 0.2, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1, 1, 1, 1
    ]);
    for variant in ["diagonal", "lspia", "cg", "direct"] {
        let story = server
            .stream(&json!({
                "curve": {
                    "points": points, "parameters": t,
                    "basis": {"kind": "bspline", "degree": 3, "knots": knots},
                },
                "method": {"kind": "least_squares", "control_points": 12, "variant": variant},
                "stop": {"tolerance": 1e-6, "max_iterations": 2000},
            }))
            .await;
        // Where there are no data, the minimum of `direct` swings; the others come from level 0.
        match variant {
            "cg" => assert_eq!(story.state(), "converged"),
            "direct" => assert_eq!(story.end["reason"], "between"),
            _ => assert_eq!(story.state(), "exhausted"),
        }
        let first = &story.iterations[0]["control_points"];
        let last = &story.iterations.last().unwrap()["control_points"];
        // B-spline 6 lives on [0.4, 0.8], where there are no data.
        assert_eq!(first[6], last[6]);
        assert_ne!(first[2], last[2]);
    }
}

const CLOSED_MINIMA: [(usize, f64); 3] = [
    (1, 0.15076793572845143),
    (2, 0.0483608182541975),
    (3, 0.015872019929135704),
];

/// Closed curves of even degree have their knots half a parameter before the places of the control
/// points. The values are those of `numpy.linalg.lstsq` on the periodic design matrix.
#[tokio::test]
async fn closed_curves_of_every_degree_reach_the_minimum() {
    let server = Server::start().await;
    let points: Vec<[f64; 2]> = (0..11)
        .map(|i| TAU * f64::from(i) / 11.0)
        .map(|a| [a.cos(), 1.5 * a.sin()])
        .collect();
    let variants = |(degree, rms)| ["cg", "direct"].map(|variant| (degree, rms, variant));
    for (degree, rms, variant) in CLOSED_MINIMA.into_iter().flat_map(variants) {
        let story = server
            .stream(&json!({
                "curve": {
                    "points": points, "parameters": "uniform", "closed": true,
                    "basis": {"kind": "bspline", "degree": degree},
                },
                "method": {"kind": "least_squares", "control_points": 4, "variant": variant},
                "stop": {"tolerance": 0},
            }))
            .await;
        assert_eq!(story.end["reason"], "minimum");
        let found = number(&story.end["error"]["rms"]);
        assert!(
            (found - rms).abs() < 1e-9,
            "{variant}, degree {degree}: {found}"
        );
    }
}

/// Nearly as many control points as data: the smallest singular values of the collocation matrix are
/// below 1e-16, down to 1e-31, and below 1e-11 (numpy).
#[tokio::test]
async fn nearly_as_many_control_points_as_data() {
    let server = Server::start().await;
    let point = |i: usize| {
        let t = i as f64 / 1000.0;
        [(6.0 * t).cos() * (1.0 + t), (6.0 * t).sin(), t]
    };
    let points: Vec<_> = (0..1000).map(point).collect();
    for count in [999, 998, 995, 990, 900] {
        for variant in ["direct", "cg"] {
            let method =
                json!({"kind": "least_squares", "control_points": count, "variant": variant});
            let job = json!({"curve": {"points": points}, "method": method});
            let job = server.fit(&job).await;
            // Hardly fewer than data leave the minimum free between the first ones, by up to a million times its size.
            let reason = match (variant, count) {
                ("direct", 990..) => json!("between"),
                _ => Value::Null,
            };
            assert_eq!(job["reason"], reason, "{count} {variant}: {job:#}");
            // The curve is smooth with a thousand points: more digits than requested.
            let most = if variant == "direct" { 1e-8 } else { 5e-6 };
            assert!(number(&job["error"]["max"]) < most, "{count} {variant}");
        }
    }
}

#[tokio::test]
async fn wrong_settings_are_refused() {
    let server = Server::start().await;
    let job = |method: Value| json!({"curve": {"points": data::wave(20)}, "method": method});
    let cases = [
        (
            json!({"kind": "least_squares"}),
            "/method",
            "needs control_points",
        ),
        (
            json!({"kind": "least_squares", "control_points": 21}),
            "/method/control_points",
            "21 control points for 20",
        ),
        (
            json!({"kind": "least_squares", "control_points": 1}),
            "/method/control_points",
            "at least 2",
        ),
        (
            json!({"kind": "least_squares", "control_points": 3}),
            "/method/control_points",
            "too few for degree 3",
        ),
        (
            json!({"kind": "least_squares", "control_points": {"u": 5, "v": 5}}),
            "/method/control_points",
            "one number",
        ),
        (
            json!({"kind": "least_squares", "control_points": 8, "variant": "qr"}),
            "/method/variant",
            "unknown least-squares variant",
        ),
        (
            json!({"kind": "least_squares", "control_points": 8, "mu": 1}),
            "/method/mu",
            "lspia",
        ),
        (
            json!({"kind": "least_squares", "control_points": 8, "variant": "lspia", "mu": 0}),
            "/method/mu",
            "greater than 0",
        ),
        (
            json!({"kind": "weighted", "omega": 2}),
            "/method/omega",
            "between 0 and 2",
        ),
        (
            json!({"kind": "weighted", "omega": "best"}),
            "/method/omega",
            "auto",
        ),
        (json!({"kind": "local"}), "/method", "indices"),
        (
            json!({"kind": "local", "indices": []}),
            "/method/indices",
            "indices is empty",
        ),
        (
            json!({"kind": "local", "indices": [3, 20]}),
            "/method/indices/1",
            "there are 20 points",
        ),
        (
            json!({"kind": "local", "indices": [3, 5, 3]}),
            "/method/indices/2",
            "repeats",
        ),
        (
            json!({"kind": "local", "indices": [[3, 5]]}),
            "/method/indices/0",
            "single indices",
        ),
        (
            json!({"kind": "local", "indices": [-1]}),
            "/method/indices/0",
            "-1",
        ),
        (
            json!({"kind": "local", "sweeps": "rows"}),
            "/method/sweeps",
            "no rows",
        ),
        (json!({"kind": "adaptive"}), "/method", "threshold"),
        (
            json!({"kind": "adaptive", "threshold": 0}),
            "/method/threshold",
            "greater than 0",
        ),
        (
            json!({"kind": "extended", "start": "zero"}),
            "/method/start",
            "unknown start",
        ),
    ];
    for (method, pointer, reason) in cases {
        server.assert_refused(&job(method), pointer, reason).await;
    }
    for (closed, knots) in [(false, "data"), (false, "averaged"), (true, "data")] {
        let job = json!({
            "curve": {
                "points": data::wave(20), "closed": closed,
                "basis": {"kind": "bspline", "knots": knots},
            },
            "method": {"kind": "least_squares", "control_points": 8},
        });
        let response = server.post("/v1/jobs").json(&job).send().await.unwrap();
        let (_, answer) = problem(response).await;
        assert_eq!(
            answer["errors"][0]["pointer"], "/curve/basis/knots",
            "{answer:#}"
        );
    }
    let mut holed = data::peaks(5);
    holed[2][3] = Value::Null;
    let surface = json!({"surface": {"points": holed}});
    let response = server.post("/v1/jobs").json(&surface).send().await.unwrap();
    let (_, answer) = problem(response).await;
    assert_eq!(answer["errors"][0]["pointer"], "/surface/points/2/3");
    assert!(
        answer["detail"]
            .as_str()
            .unwrap()
            .contains("only least-squares")
    );
    let surface = json!({"surface": {"points": data::peaks(5)}, "method": {"kind": "local", "indices": [[0, 5]]}});
    let response = server.post("/v1/jobs").json(&surface).send().await.unwrap();
    let (_, answer) = problem(response).await;
    assert_eq!(answer["errors"][0]["pointer"], "/method/indices/0");
    let surface = json!({"surface": {"points": data::peaks(5)}, "method": {"kind": "convex"}});
    let response = server.post("/v1/jobs").json(&surface).send().await.unwrap();
    let (_, answer) = problem(response).await;
    assert!(answer["detail"].as_str().unwrap().contains("planar"));
}
