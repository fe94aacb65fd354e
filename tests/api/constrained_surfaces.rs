//! Surfaces that choose their knots, and obey and weigh more than distances.

use serde_json::{Value, json};

use crate::data;
use crate::numbers::flat;
use crate::support::{Server, Story};

/// Franke's function.
fn franke(x: f64, y: f64) -> f64 {
    let (x, y) = (9.0 * x, 9.0 * y);
    0.75 * (-((x - 2.0).powi(2) + (y - 2.0).powi(2)) / 4.0).exp()
        + 0.75 * (-(x + 1.0).powi(2) / 49.0 - (y + 1.0) / 10.0).exp()
        + 0.5 * (-((x - 7.0).powi(2) + (y - 3.0).powi(2)) / 4.0).exp()
        - 0.2 * (-(x - 4.0).powi(2) - (y - 7.0).powi(2)).exp()
}

/// Points of it with errors of at most `noise`.
fn noisy(count: usize, noise: f64) -> Value {
    let point = |i: usize| {
        let i = i as f64;
        let (x, y) = ((0.754_877_666 * i).fract(), (0.569_840_291 * i).fract());
        // The fractions of large products look random.
        let error = 2.0 * (43_758.545 * (12.9898 * i).sin()).rem_euclid(1.0) - 1.0;
        json!([x, y, franke(x, y) + noise * error])
    };
    (1..=count).map(point).collect()
}

fn scattered(points: &Value, method: Value, tolerance: f64) -> Value {
    let mut method = method;
    method["kind"] = json!("least_squares");
    method["control_points"] = json!("auto");
    json!({
        "surface": {"scattered": points, "parameters": {"project": "xy"}},
        "method": method,
        "stop": {"tolerance": tolerance},
    })
}

/// The root of the mean of the squared differences from Franke's function, of the last surface.
async fn from_truth(server: &Server, story: &Story) -> f64 {
    let result = story.end["links"]["result"].as_str().unwrap();
    let samples = server
        .json(&format!("{result}?view=samples&samples=40x40"))
        .await;
    let points = flat(&samples["samples"]);
    let squares = points
        .chunks_exact(3)
        .map(|point| (point[2] - franke(point[0], point[1])).powi(2));
    (squares.sum::<f64>() / 1600.0).sqrt()
}

/// Where the tolerance is near the noise the surface follows it; fairness keeps it nearer to the truth.
#[tokio::test]
async fn fair_surfaces_of_scans_are_nearer_to_the_truth() {
    let server = Server::start().await;
    let points = noisy(1500, 0.05);
    let mut found = Vec::new();
    for fairness in [0.0, 1e-8] {
        let story = server
            .stream(&scattered(&points, json!({"fairness": fairness}), 0.058))
            .await;
        assert_eq!(story.state(), "converged", "{}", story.end);
        let last = story.iterations.len() - 1;
        assert!(story.error(last) <= 0.058, "{}", story.end);
        found.push(from_truth(&server, &story).await);
    }
    let [plain, fair] = found[..] else {
        panic!("two fits")
    };
    assert!(fair < 0.5 * plain, "{fair} {plain}");
}

/// Points that spread evenly over the unit square (fractional parts of multiples of powers of the plastic number's
/// inverse), without a hole and a corner, on Franke's function.
fn with_a_hole() -> (Vec<[f64; 2]>, Vec<[f64; 3]>) {
    let mut plastic: f64 = 1.5;
    for _ in 0..60 {
        plastic = (1.0 + plastic).cbrt();
    }
    let place = |k: usize| [1, 2].map(|power| (0.5 + k as f64 * plastic.powi(-power)).fract());
    let is_there = |[u, v]: &[f64; 2]| (u - 0.35).hypot(v - 0.6) > 0.22 && u + v < 1.7;
    let places: Vec<[f64; 2]> = (1..=1500).map(place).filter(is_there).collect();
    let points = places.iter().map(|&[u, v]| [u, v, franke(u, v)]).collect();
    (places, points)
}

/// Distances of an independent implementation, and heights where there are no data.
#[tokio::test]
async fn gaps_are_stiff() {
    let server = Server::start().await;
    let (places, points) = with_a_hole();
    let knots: Vec<f64> = [0.0; 3]
        .into_iter()
        .chain((0..=17).map(|i| f64::from(i) / 17.0))
        .chain([1.0; 3])
        .collect();
    let basis = json!({"kind": "bspline", "degree": 3, "knots": knots});
    for (stiffness, largest) in [(Some(0.0), 0.000_723_94), (None, 0.001_287_50)] {
        for variant in ["direct", "cg"] {
            let mut method = json!({"kind": "least_squares", "control_points": 20, "variant": variant, "fairness": 1e-9});
            if let Some(stiffness) = stiffness {
                method["gap_stiffness"] = json!(stiffness);
            }
            let job = json!({
                "surface": {"scattered": points, "parameters": places, "basis": {"u": basis, "v": basis}},
                "method": method, "stop": {"max_iterations": 10_000},
            });
            let story = server.stream(&job).await;
            let last = story.iterations.len() - 1;
            let off = (story.error(last) - largest).abs();
            let rounding = if variant == "direct" { 0.6e-8 } else { 2e-5 };
            assert!(
                off < rounding,
                "{variant}: {} {}",
                story.error(last),
                story.end
            );
            let result = story.end["links"]["result"].as_str().unwrap();
            let samples = server
                .json(&format!("{result}?view=samples&samples=101x101"))
                .await;
            let heights = flat(&samples["samples"]);
            let heights: Vec<f64> = heights.chunks_exact(3).map(|point| point[2]).collect();
            let least = heights.iter().copied().fold(f64::INFINITY, f64::min);
            let most = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            if stiffness.is_none() {
                assert!(least > 0.0 && most < 1.23, "{variant}: {least} {most}");
            }
        }
    }
}

/// Where fairness keeps a surface away from its data, more control points are not tried for long.
#[tokio::test]
async fn what_fairness_does_not_allow_ends() {
    let server = Server::start().await;
    for job in [
        scattered(&noisy(1500, 0.0), json!({"fairness": 1e-5}), 1e-3),
        json!({
            "surface": {"points": data::peaks(30)},
            "method": {"kind": "least_squares", "control_points": "auto", "fairness": 1e-4},
            "stop": {"tolerance": 1e-3},
        }),
    ] {
        let job = server.fit(&job).await;
        assert_eq!(
            (&job["state"], &job["reason"]),
            (&json!("stalled"), &json!("minimum"))
        );
        // Far fewer than it takes to try as many control points as there are data.
        assert!(job["iteration"].as_u64().unwrap() < 30, "{job}");
    }
}

/// The bending energy and the distances of grids: with little fairness as without.
#[tokio::test]
async fn fair_grids() {
    let server = Server::start().await;
    let between = json!("between");
    for (fairness, order, reason) in [
        (1e-15, 2, &Value::Null),
        (1e-15, 3, &between),
        (1e-11, 2, &between),
    ] {
        let job = json!({
            "surface": {"points": data::peaks(31)},
            "method": {"kind": "least_squares", "control_points": "auto", "fairness": fairness, "fairness_order": order},
            "stop": {"tolerance": 0.05},
        });
        let story = server.stream(&job).await;
        // Where fairness is given, there is no more of it, and some of these swing between the points.
        assert_eq!(&story.end["reason"], reason, "{}", story.end);
        assert!(story.end["error"]["max"].as_f64() <= Some(0.05));
        // Corners are interpolated at each level.
        for iteration in &story.iterations {
            let net = iteration["control_points"].as_array().unwrap();
            let corner = flat(&net[0][0]);
            let expected = flat(&data::peaks(31)[0][0]);
            for (x, y) in corner.iter().zip(expected) {
                assert!((x - y).abs() < 1e-12, "{corner:?}");
            }
        }
    }
}

/// Points and derivatives that each level has, from the first one on.
#[tokio::test]
async fn every_level_obeys() {
    let server = Server::start().await;
    let (point, slope) = ([-0.1, -0.1, 0.9], [1.2, 0.0, -0.5]);
    let constraints = json!([
        {"at": {"parameter": [0, 0]}, "point": point},
        {"at": {"parameter": [0, 0]}, "derivative_u": slope},
        {"index": 700},
    ]);
    // Its corner is that of the domain.
    let mut points = noisy(1500, 0.0);
    points[3] = json!([0, 0, franke(0.0, 0.0)]);
    let job = scattered(&points, json!({"constraints": constraints}), 0.2);
    let story = server.stream(&job).await;
    assert_eq!(story.state(), "converged", "{}", story.end);
    let mut knots = story.job["knots"].clone();
    for iteration in &story.iterations {
        if !iteration["knots"].is_null() {
            knots = iteration["knots"].clone();
        }
        let net = iteration["control_points"].as_array().unwrap();
        let [corner, beside] = [flat(&net[0][0]), flat(&net[1][0])];
        let u = flat(&knots["u"]);
        let width = u[4] - u[3];
        for c in 0..3 {
            assert!((corner[c] - point[c]).abs() < 1e-12, "{corner:?}");
            let derivative = 3.0 * (beside[c] - corner[c]) / width;
            assert!((derivative - slope[c]).abs() < 1e-11, "{derivative}");
        }
    }
}

/// Points that count more are nearer.
#[tokio::test]
async fn data_weights_of_surfaces() {
    let server = Server::start().await;
    let points = noisy(800, 0.1);
    let mut near = Vec::new();
    for weight in [1.0, 1e4] {
        let weights: Vec<f64> = (0..800)
            .map(|i| if i == 400 { weight } else { 1.0 })
            .collect();
        let method = json!({"data_weights": weights, "max_control_points": 7});
        let job = server.fit(&scattered(&points, method, 1e-3)).await;
        assert_eq!(job["state"], "exhausted", "{job}");
        let result = job["links"]["result"].as_str().unwrap();
        let errors = server.json(&format!("{result}?view=errors")).await;
        near.push(errors["error"]["max"].as_f64().unwrap());
        let input = server
            .json(&format!("{}/input", crate::support::base(&job)))
            .await;
        assert_eq!(input["method"]["data_weights"][400].as_f64(), Some(weight));
    }
    assert_ne!(near[0], near[1]);
}

/// Knots along a boundary change, and with them the number of control points there.
#[tokio::test]
async fn boundaries_have_a_number_of_control_points() {
    let server = Server::start().await;
    let row: Vec<[f64; 3]> = (0..4).map(|i| [f64::from(i), 0.0, 0.0]).collect();
    let job = json!({
        "surface": {"points": data::peaks(12)},
        "method": {
            "kind": "least_squares", "control_points": "auto",
            "constraints": [{"at": {"boundary": "u_start"}, "control_points": row}],
        },
    });
    let reason = "changes the knots along a boundary from level to level";
    server
        .assert_refused(&job, "/method/constraints/0", reason)
        .await;
}
