//! Knots of least-squares fits: they do not depend on the direction of the data, and have names.

use serde_json::{Value, json};

use crate::data;
use crate::numbers::numbers;
use crate::support::{Server, Story, base};

const VARIANTS: [&str; 3] = ["direct", "cg", "diagonal"];

fn reversed(points: &Value) -> Value {
    let mut points = points.clone();
    points.as_array_mut().unwrap().reverse();
    points
}

/// Rows, columns, or both in reverse.
fn turned(rows: &Value, [u, v]: [bool; 2]) -> Value {
    let mut rows = rows.clone();
    let lines = rows.as_array_mut().unwrap();
    if u {
        lines.reverse();
    }
    if v {
        lines.iter_mut().for_each(|line| *line = reversed(line));
    }
    rows
}

fn assert_equal(a: &Value, b: &Value, tolerance: f64, what: &str) {
    let (a, b) = (numbers(a), numbers(b));
    assert_eq!(a.len(), b.len(), "{what}");
    for (a, b) in a.iter().zip(&b) {
        assert!((a - b).abs() <= tolerance, "{what}: {a} {b}");
    }
}

/// The knots are those of the other fit, mirrored in the range of the parameters, which begin at 0.
fn assert_mirrored(knots: &Value, others: &Value, what: &str) {
    let (knots, others) = (numbers(knots), numbers(others));
    let end = knots[knots.len() - 1];
    assert_eq!(knots.len(), others.len(), "{what}");
    for (a, b) in knots.iter().zip(others.iter().rev()) {
        assert!((a + b - end).abs() <= 1e-14 * end, "{what}: {a} {b}");
    }
}

/// Uneven points of a noisy curve.
fn curve(count: usize) -> Value {
    let point = |i: usize| {
        let x = (i as f64).powf(1.3) / 4.0;
        [x, x.sin() + 0.1 * (7.0 * i as f64).cos(), (0.4 * x).cos()]
    };
    (0..count).map(|i| json!(point(i))).collect()
}

fn method(variant: &str, control_points: Value) -> Value {
    json!({"kind": "least_squares", "control_points": control_points, "variant": variant})
}

fn stop(variant: &str) -> Value {
    // What is wanted of slow steps is that each of them is reversed.
    let iterations = if variant == "diagonal" { 30 } else { 300 };
    json!({"tolerance": 0, "max_iterations": iterations})
}

#[tokio::test]
async fn reversed_curves_are_fitted_in_reverse() {
    let server = Server::start().await;
    let sizes = [
        (1, 12, 40),
        (2, 9, 41),
        (3, 10, 23),
        (3, 17, 17),
        (5, 20, 64),
    ];
    for (degree, control_points, count) in sizes {
        for variant in VARIANTS {
            let what = format!("{variant}, degree {degree}, {control_points} of {count}");
            let fit = async |points: &Value| -> Story {
                let basis = json!({"kind": "bspline", "degree": degree});
                let asked = json!({
                    "curve": {"points": points, "basis": basis},
                    "method": method(variant, json!(control_points)), "stop": stop(variant),
                });
                server.stream(&asked).await
            };
            let points = curve(count);
            let (forth, back) = (fit(&points).await, fit(&reversed(&points)).await);
            assert_mirrored(&forth.job["knots"], &back.job["knots"], &what);
            let levels = |story: &Story| match variant {
                // Where conjugate gradients are at the minimum, rounding leads each its own way.
                "cg" => vec![0, 1, 2, story.iterations.len() - 1],
                _ => (0..story.iterations.len()).collect(),
            };
            for (i, k) in levels(&forth).into_iter().zip(levels(&back)) {
                let (a, b) = (&forth.iterations[i], &back.iterations[k]);
                let back = reversed(&b["control_points"]);
                // Rounding grows on the way of conjugate gradients to the minimum.
                let tolerance = if variant == "cg" && i > 2 {
                    1e-6
                } else {
                    1e-10
                };
                assert_equal(&a["control_points"], &back, tolerance, &what);
            }
        }
    }
}

#[tokio::test]
async fn reversed_surfaces_are_fitted_in_reverse() {
    let server = Server::start().await;
    let points = json!(data::peaks(19));
    for variant in VARIANTS {
        let fit = async |points: &Value| {
            let asked = json!({
                "surface": {
                    "points": points,
                    "basis": {"u": {"kind": "bspline"}, "v": {"kind": "bspline", "degree": 2}},
                },
                "method": method(variant, json!({"u": 8, "v": 11})), "stop": stop(variant),
            });
            server.stream(&asked).await
        };
        let forth = fit(&points).await;
        for turns in [[true, false], [false, true], [true, true]] {
            let what = format!("{variant}, {turns:?}");
            let back = fit(&turned(&points, turns)).await;
            for (axis, turned) in [("u", turns[0]), ("v", turns[1])] {
                let (a, b) = (&forth.job["knots"][axis], &back.job["knots"][axis]);
                if turned {
                    assert_mirrored(a, b, &what);
                } else {
                    assert_equal(a, b, 1e-12, &what);
                }
            }
            let ends = [&forth, &back].map(|it| &it.iterations.last().unwrap()["control_points"]);
            let tolerance = if variant == "cg" { 1e-7 } else { 1e-9 };
            assert_equal(ends[0], &turned(ends[1], turns), tolerance, &what);
            let starts = [&forth, &back].map(|it| &it.iterations[0]["control_points"]);
            assert_equal(starts[0], &turned(starts[1], turns), 1e-12, &what);
        }
    }
}

/// Closed curves of odd degree have the reversed minimum where the first point stays the first.
#[tokio::test]
async fn closed_curves_are_reversed_around_their_first_point() {
    let server = Server::start().await;
    let around = |i: i32| {
        let angle = f64::from(i) + 0.3 * f64::from(i).sin();
        let angle = std::f64::consts::TAU * angle / 30.0;
        json!([2.0 * angle.cos() + 0.1 * (5.0 * angle).sin(), angle.sin()])
    };
    let about_first = |values: &Value| {
        let mut values = values.clone();
        values.as_array_mut().unwrap()[1..].reverse();
        values
    };
    for degree in [1, 3, 5] {
        let fit = async |points: &Value| {
            let asked = json!({
                "curve": {
                    "points": points, "closed": true,
                    "basis": {"kind": "bspline", "degree": degree},
                },
                "method": method("direct", json!(11)), "stop": stop("direct"),
            });
            let story = server.stream(&asked).await;
            story.iterations.last().unwrap()["control_points"].clone()
        };
        let points: Value = (0..30).map(around).collect();
        let (forth, back) = (fit(&points).await, fit(&about_first(&points)).await);
        let what = format!("degree {degree}");
        // The complete list, with the control points that are repeated on the way around.
        assert_equal(&forth, &reversed(&back), 1e-11, &what);
    }
}

/// What is usual has a name, which edits keep.
#[tokio::test]
async fn the_rule_has_a_name() {
    let server = Server::start().await;
    let asked = |basis: Value| {
        json!({
            "curve": {"points": curve(30), "basis": basis},
            "method": method("diagonal", json!(12)), "stop": {"tolerance": 0, "max_iterations": 5},
        })
    };
    let usual = server.fit(&asked(json!({"kind": "bspline"}))).await;
    let rule = async |job: &Value| {
        let input = server.json(&format!("{}/input", base(job))).await;
        input["curve"]["basis"]["knots"].clone()
    };
    assert_eq!(rule(&usual).await, "spread");
    let capabilities = server.json("/v1/capabilities").await;
    let methods = capabilities["methods"].as_array().unwrap();
    let announced = methods.iter().find(|it| it["kind"] == "least_squares");
    assert_eq!(
        announced.unwrap()["knots"],
        json!(["spread", "adaptive", "explicit"])
    );
    let basis = json!({"kind": "bspline", "knots": "spread"});
    let parent = server.stream(&asked(basis)).await;
    assert_eq!(rule(&parent.job).await, "spread");
    for change in [
        json!({"points": [{"index": 3, "point": [0, 1, 2]}]}),
        json!({"method": method("direct", json!(12))}),
    ] {
        let edits = server.post(&format!("{}/edits", base(&parent.job)));
        let edit = edits.json(&change).send().await.unwrap();
        assert!(edit.status().is_success());
        let edit: Value = edit.json().await.unwrap();
        assert_eq!(rule(&edit).await, "spread");
    }
    // Equal shares of 30 parameters in 9 spans: the first one ends at 29/9 = 3 + 2/9.
    let (knots, t) = (&parent.job["knots"], numbers(&parent.job["parameters"]));
    let expected = 7.0 / 9.0 * t[3] + 2.0 / 9.0 * t[4];
    assert!((numbers(knots)[4] - expected).abs() < 1e-14);
}

#[tokio::test]
async fn spread_knots_are_for_open_least_squares() {
    let server = Server::start().await;
    let basis = json!({"kind": "bspline", "knots": "spread"});
    let pointer = "/curve/basis/knots";
    let global = json!({"curve": {"points": curve(20), "basis": basis}});
    server
        .assert_refused(&global, pointer, "for least squares")
        .await;
    let ended = json!({"curve": {"points": curve(20), "basis": basis, "ends": "natural"}});
    server
        .assert_refused(&ended, "/curve/ends", "for least squares")
        .await;
    let closed = json!({
        "curve": {"points": curve(20), "basis": basis, "closed": true},
        "method": method("direct", json!(8)),
    });
    server
        .assert_refused(&closed, pointer, "for open ones")
        .await;
    let polynomial = json!({
        "curve": {"points": curve(20), "basis": {"kind": "bernstein", "knots": "spread"}},
        "method": method("direct", json!(8)),
    });
    server
        .assert_refused(&polynomial, pointer, "no knots to choose")
        .await;
}

/// Points of a steep step between two flat parts.
fn step(count: usize) -> Value {
    let point = |i: usize| {
        let x = 2.0 * i as f64 / (count - 1) as f64 - 1.0;
        json!([x, (20.0 * x).tanh()])
    };
    (0..count).map(point).collect()
}

/// A closed curve that is nearly pointed at one place.
fn heart(count: usize) -> Value {
    let point = |i: usize| {
        let turn = std::f64::consts::TAU * i as f64 / count as f64;
        let out = 1.0 + 0.2 * (20.0 * turn.cos() - 20.0).exp();
        json!([out * turn.cos(), out * turn.sin()])
    };
    (0..count).map(point).collect()
}

/// Adaptive knots go where the data ask for them; edits keep them.
#[tokio::test]
async fn adaptive_knots_are_nearer_to_the_data() {
    let server = Server::start().await;
    for (closed, gain) in [(false, 100.0), (true, 3.0)] {
        let fit = async |knots: &str| {
            let points = if closed { heart(400) } else { step(801) };
            let basis = match knots {
                "" => json!({"kind": "bspline", "degree": 3}),
                _ => json!({"kind": "bspline", "degree": 3, "knots": knots}),
            };
            let curve = json!({"points": points, "basis": basis, "closed": closed});
            let method = method("direct", json!(40));
            server.fit(&json!({"curve": curve, "method": method})).await
        };
        let (usual, adaptive) = (fit("").await, fit("adaptive").await);
        let error = |job: &Value| job["error"]["max"].as_f64().unwrap();
        assert!(
            gain * error(&adaptive) < error(&usual),
            "{adaptive} {usual}"
        );
        let input = server.json(&format!("{}/input", base(&adaptive))).await;
        assert_eq!(input["curve"]["basis"]["knots"], "adaptive");
        assert_eq!(server.fit(&input).await["error"], adaptive["error"]);
        let moved = json!({"points": [{"index": 3, "point": [0.1, 0.2]}]});
        let edit = server
            .post(&format!("{}/edits", base(&adaptive)))
            .json(&moved);
        let edit: Value = edit.send().await.unwrap().json().await.unwrap();
        server.until_state(base(&edit), "converged").await;
        let knots = async |job: &Value| {
            let result = server.json(&format!("{}/result", base(job))).await;
            result["knots"].clone()
        };
        assert_eq!(knots(&edit).await, knots(&adaptive).await);
    }
}

#[tokio::test]
async fn adaptive_knots_are_for_least_squares_of_curves() {
    let server = Server::start().await;
    let basis = json!({"kind": "bspline", "degree": 3, "knots": "adaptive"});
    let points = curve(30);
    let curve =
        |method: Value| json!({"curve": {"points": points, "basis": basis}, "method": method});
    let fewer = method("direct", json!(5));
    for (job, pointer, reason) in [
        (
            curve(json!("global")),
            "/curve/basis/knots",
            "least squares",
        ),
        (
            curve(json!({"kind": "least_squares", "control_points": 9, "robust": true})),
            "/curve/basis/knots",
            "robust",
        ),
        (
            curve(json!({"kind": "least_squares", "control_points": 40, "fairness": 1e-9})),
            "/curve/basis/knots",
            "give fewer",
        ),
        (
            curve(json!({"kind": "least_squares", "control_points": "auto"})),
            "/curve/basis",
            "no knots can be given",
        ),
        (
            json!({"surface": {"points": data::peaks(8), "basis": basis}, "method": fewer}),
            "/surface/basis/knots",
            "knots of curves",
        ),
        (
            json!({"curve": {"points": points, "basis": basis, "corners": [9]}, "method": fewer}),
            "/curve/corners",
            "knots of their own",
        ),
    ] {
        server.assert_refused(&job, pointer, reason).await;
    }
}
