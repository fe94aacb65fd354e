//! Closed curves and surfaces: periodic B-splines.

use serde_json::{Value, json};

use crate::data;
use crate::numbers::numbers;
use crate::support::Server;

fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("{value} is no number"))
}

fn hexagon() -> Value {
    json!([[0, 0], [2, -1], [3, 1], [2.5, 3], [0.5, 2.5], [-1, 1]])
}

/// Nine samples over the period, of `scipy.interpolate.make_interp_spline(…, bc_type="periodic")`
/// (scipy 1.17.1), chord length.
const CUBIC: [[f64; 2]; 9] = [
    [0.0, 0.0],
    [1.4257103368862263, -0.938637391738016],
    [2.5068355529972366, -0.5798167498464358],
    [3.0090266019091696, 1.096139730164459],
    [2.760885828111181, 2.7307292329888577],
    [1.603348919727627, 3.0077206638600416],
    [-0.05616384035578436, 2.1677784728860168],
    [-1.0083576222691666, 1.0733641608225308],
    [0.0, 0.0],
];
const QUINTIC: [[f64; 2]; 9] = [
    [0.0, 0.0],
    [1.455796010170913, -0.9315366998309679],
    [2.490068328307692, -0.6190764734948563],
    [3.009564400460882, 1.100582113126358],
    [2.75433110483004, 2.7471172130426122],
    [1.6384769444372511, 3.0164785113233865],
    [-0.08372320979258557, 2.153322387976414],
    [-1.012144454470668, 1.0707574111792506],
    [0.0, 0.0],
];

#[tokio::test]
async fn the_limit_is_that_of_scipy() {
    let server = Server::start().await;
    for (degree, expected) in [(3, CUBIC), (5, QUINTIC)] {
        for method in ["global", "weighted", "chebyshev", "direct", "extended"] {
            let job = server
                .fit(&json!({
                    "curve": {
                        "points": hexagon(), "closed": true,
                        "basis": {"kind": "bspline", "degree": degree},
                    },
                    "method": {"kind": method},
                    "stop": {"tolerance": 1e-13, "max_iterations": 10_000},
                }))
                .await;
            assert!(number(&job["error"]["max"]) < 1e-12, "{method}");
            let path = job["links"]["result"].as_str().unwrap();
            let sampled = server.json(&format!("{path}?view=samples&samples=9")).await;
            for (sample, expected) in sampled["samples"].as_array().unwrap().iter().zip(expected) {
                for c in 0..2 {
                    let deviation = (number(&sample[c]) - expected[c]).abs();
                    assert!(deviation < 1e-12, "degree {degree}, {method}: {deviation}");
                }
            }
        }
    }
}

/// As CAD kernels store it: p control points are repeated, and the knots continue periodically.
#[tokio::test]
async fn geometry_is_complete_for_every_degree() {
    let server = Server::start().await;
    for degree in 1..=5_usize {
        let story = server
            .stream(&json!({
                "curve": {
                    "points": hexagon(), "closed": true,
                    "basis": {"kind": "bspline", "degree": degree},
                },
                "stop": {"tolerance": 1e-9, "max_iterations": 10_000},
            }))
            .await;
        assert_eq!(story.state(), "converged", "degree {degree}");
        assert_eq!(story.job["closed"], true);
        let knots: Vec<f64> = story.job["knots"]
            .as_array()
            .unwrap()
            .iter()
            .map(number)
            .collect();
        assert_eq!(knots.len(), 6 + 2 * degree + 1);
        let period = knots[6 + degree] - knots[degree];
        for i in 0..=2 * degree {
            assert!((knots[i + 6] - knots[i] - period).abs() < 1e-12);
        }
        let control_points = story.iterations.last().unwrap()["control_points"].clone();
        let control_points = control_points.as_array().unwrap();
        assert_eq!(control_points.len(), 6 + degree);
        assert_eq!(control_points[..degree], control_points[6..]);
        // The two ends are the same point.
        let path = story.job["links"]["result"].as_str().unwrap();
        let ends = server.json(&format!("{path}?view=samples&samples=2")).await;
        for c in 0..2 {
            let gap = number(&ends["samples"][0][c]) - number(&ends["samples"][1][c]);
            assert!(gap.abs() < 1e-12);
        }
    }
}

#[tokio::test]
async fn surfaces_close_in_either_direction() {
    let server = Server::start().await;
    let tube: Vec<Vec<[f64; 3]>> = (0..8)
        .map(|i| f64::from(i) * std::f64::consts::TAU / 8.0)
        .map(|a| {
            (0..5)
                .map(|j| {
                    [
                        a.cos() * (2.0 + 0.1 * f64::from(j)),
                        a.sin() * 2.0,
                        f64::from(j),
                    ]
                })
                .collect()
        })
        .collect();
    for (closed, rows, columns) in [
        (json!({"u": true, "v": false}), 11, 7),
        (json!({"u": false, "v": true}), 10, 8),
        (json!(true), 11, 8),
    ] {
        for method in ["global", "direct", "chebyshev", "extended"] {
            let story = server
                .stream(&json!({
                    "surface": {"points": tube, "closed": closed},
                    "method": {"kind": method},
                    "stop": {"tolerance": 1e-9, "max_iterations": 10_000},
                }))
                .await;
            assert_eq!(story.state(), "converged", "{method} {closed}");
            let net = story.iterations.last().unwrap()["control_points"]
                .as_array()
                .unwrap()
                .clone();
            assert_eq!(
                (net.len(), net[0].as_array().unwrap().len()),
                (rows, columns)
            );
        }
    }
}

#[tokio::test]
async fn what_cannot_be_closed_is_refused() {
    let server = Server::start().await;
    let curve = |change: Value| {
        let mut curve = json!({"points": hexagon(), "closed": true});
        for (field, value) in change.as_object().unwrap() {
            curve[field] = value.clone();
        }
        json!({ "curve": curve })
    };
    let repeated = json!([[0, 0], [2, -1], [3, 1], [0, 0]]);
    let mut ring = data::peaks(4);
    ring[3] = ring[0].clone();
    let cases = [
        (
            curve(json!({"points": repeated})),
            "/curve/points/3",
            "leave the last one out",
        ),
        (
            json!({"surface": {"points": ring, "closed": {"u": true, "v": false}}}),
            "/surface/points/3",
            "leave the last one out",
        ),
        (
            curve(json!({"basis": {"kind": "bernstein"}})),
            "/curve/closed",
            "polynomials cannot be closed",
        ),
        (
            json!({"surface": {"points": data::peaks(4), "closed": {"u": false, "v": true}, "basis": {"kind": "said_ball"}}}),
            "/surface/closed/v",
            "polynomials cannot be closed",
        ),
        (
            curve(json!({"basis": {"kind": "bspline", "knots": "averaged"}})),
            "/curve/basis/knots",
            "knots at the data",
        ),
        (
            curve(json!({"basis": {"kind": "bspline", "degree": 6}})),
            "/curve/basis/degree",
            "at least 7 control points",
        ),
        (
            curve(json!({"parameters": [0, 1, 2, 3, 4, 5]})),
            "/curve/parameters",
            "7 needed",
        ),
        (
            curve(json!({"closed": "yes"})),
            "/curve/closed",
            "expected true or false",
        ),
    ];
    for (job, pointer, reason) in cases {
        server.assert_refused(&job, pointer, reason).await;
    }
}

/// The value of a B-spline at a parameter, by de Boor's algorithm.
fn de_boor(degree: usize, knots: &[f64], points: &[Vec<f64>], t: f64) -> Vec<f64> {
    let last = points.len() - 1;
    let span = (degree..last).find(|&i| t < knots[i + 1]).unwrap_or(last);
    let mut d = points[span - degree..=span].to_vec();
    for r in 1..=degree {
        for j in (r..=degree).rev() {
            let i = span - degree + j;
            let alpha = (t - knots[i]) / (knots[i + degree - r + 1] - knots[i]);
            d[j] = (0..d[j].len())
                .map(|c| (1.0 - alpha) * d[j - 1][c] + alpha * d[j][c])
                .collect();
        }
    }
    d.remove(degree)
}

/// A curve is where its stream says, by nothing but degree, knots, control points and parameters:
/// these lie in the domain, and there the distances are those of the event.
async fn check_streamed(server: &Server, job: &Value) {
    let story = server.stream(job).await;
    let degree = story.job["degree"].as_u64().unwrap() as usize;
    let (knots, parameters) = (
        numbers(&story.job["knots"]),
        numbers(&story.job["parameters"]),
    );
    let (low, high) = (knots[degree], knots[knots.len() - 1 - degree]);
    let inside = parameters.iter().all(|t| (low..=high).contains(t));
    assert!(inside, "{low} {high} {parameters:?}\n{job}");
    let last = story.iterations.last().unwrap();
    let control_points: Vec<_> = last["control_points"]
        .as_array()
        .unwrap()
        .iter()
        .map(numbers)
        .collect();
    let points = job["curve"]["points"]
        .as_array()
        .unwrap()
        .iter()
        .map(numbers);
    let largest = points
        .zip(&parameters)
        .map(|(point, &t)| {
            let place = de_boor(degree, &knots, &control_points, t);
            point
                .iter()
                .zip(place)
                .map(|(a, b)| (a - b).powi(2))
                .sum::<f64>()
                .sqrt()
        })
        .fold(0.0, f64::max);
    let said = number(&last["error"]["max"]);
    // Rounding of coordinates below 4, in up to twelve steps.
    assert!((largest - said).abs() < 1e-12, "{largest} {said}\n{job}");
}

#[tokio::test]
async fn the_domain_contains_the_data() {
    let server = Server::start().await;
    let ring = |count: usize| -> Vec<[f64; 2]> {
        (0..count)
            .map(|i| i as f64 + 0.4 * (i as f64 * 2.7).sin())
            .map(|i| i * std::f64::consts::TAU / count as f64)
            .map(|a| [2.0 * a.cos() + 0.3 * (3.0 * a).sin(), a.sin()])
            .collect()
    };
    for degree in 1..=10_usize {
        for count in [12, 23, 39, 64] {
            let explicit: Vec<f64> = (0..=count).map(|i| (i * i + 5 * i) as f64).collect();
            for parameters in [
                json!("uniform"),
                json!("chord_length"),
                json!("centripetal"),
                json!(explicit),
            ] {
                let mut job = json!({
                    "curve": {
                        "points": ring(count), "closed": true, "parameters": parameters,
                        "basis": {"kind": "bspline", "degree": degree},
                    },
                    "stop": {"max_iterations": 2},
                });
                check_streamed(&server, &job).await;
                for control_points in [degree + 1, count / 2, count - 1, count] {
                    if control_points > degree {
                        job["method"] = json!({"kind": "least_squares", "control_points": control_points, "variant": "cg"});
                        check_streamed(&server, &job).await;
                    }
                }
            }
        }
    }
}
