//! As few control points as the tolerance needs: `control_points: "auto"`.

use serde_json::{Value, json};

use crate::numbers::numbers;
use crate::support::{Server, Story};

/// A point of Bernoulli's lemniscate.
fn lemniscate(t: f64) -> [f64; 2] {
    let denominator = 1.0 + t.sin().powi(2);
    [t.cos() / denominator, t.sin() * t.cos() / denominator]
}

/// Points of the whole lemniscate, from its right end to its right end.
fn points(count: usize) -> Vec<[f64; 2]> {
    let step = std::f64::consts::TAU / (count - 1) as f64;
    (0..count).map(|i| lemniscate(i as f64 * step)).collect()
}

/// The same without the last one, which is the first one.
fn closed(count: usize) -> Vec<[f64; 2]> {
    let mut points = points(count + 1);
    points.truncate(count);
    points
}

fn automatic(curve: Value, tolerance: f64, more: Value) -> Value {
    let mut method = json!({"kind": "least_squares", "control_points": "auto"});
    for (name, value) in more.as_object().into_iter().flatten() {
        method[name] = value.clone();
    }
    json!({"curve": curve, "method": method, "stop": {"tolerance": tolerance}})
}

/// Grid points of a smooth surface whose sides share no factor.
fn grid() -> Vec<Vec<[f64; 3]>> {
    let (u, v) = (31, 22);
    let z = |i: usize, j: usize| (i as f64 * 0.12).sin() * (j as f64 * 0.2).cos();
    let row = |i: usize| {
        (0..v)
            .map(|j| [i as f64 * 0.1, j as f64 * 0.15, z(i, j)])
            .collect()
    };
    (0..u).map(row).collect()
}

/// The value of a B-spline at a parameter, by the definition of its functions.
pub fn value(knots: &[f64], degree: usize, control_points: &[Vec<f64>], t: f64) -> Vec<f64> {
    let last = control_points.len() - 1;
    let inside = |k: usize| knots[k] <= t && (t < knots[k + 1] || (k == last && t <= knots[k + 1]));
    let span = (degree..=last).find(|&k| inside(k)).unwrap();
    let mut points: Vec<Vec<f64>> = control_points[span - degree..=span].to_vec();
    for r in 1..=degree {
        for j in (r..=degree).rev() {
            let i = span - degree + j;
            let part = (t - knots[i]) / (knots[i + degree + 1 - r] - knots[i]);
            let before = points[j - 1].clone();
            for (x, y) in points[j].iter_mut().zip(before) {
                *x = (1.0 - part) * y + part * *x;
            }
        }
    }
    points[degree].clone()
}

fn lists(value: &Value) -> Vec<Vec<f64>> {
    value.as_array().unwrap().iter().map(numbers).collect()
}

/// The largest distance of a B-spline from points at parameters.
fn largest(knots: &[f64], control_points: &Value, points: &[[f64; 2]], t: &[f64]) -> f64 {
    let control_points = lists(control_points);
    let distances = points.iter().zip(t).map(|(p, &t)| {
        let c = value(knots, 3, &control_points, t);
        f64::hypot(c[0] - p[0], c[1] - p[1])
    });
    distances.fold(0.0, f64::max)
}

/// Every event is a B-spline whose distances are what the event says. Knots are there where they are
/// others than before. The stream begins with p + 1 control points and ends within the tolerance.
#[tokio::test]
async fn every_event_is_the_curve_that_it_says_it_is() {
    let server = Server::start().await;
    for (is_closed, points) in [(false, points(500)), (true, closed(331))] {
        let curve = json!({"points": points, "closed": is_closed});
        let story = server.stream(&automatic(curve, 1e-5, json!({}))).await;
        assert_eq!(story.state(), "converged");
        let mut knots = numbers(&story.job["knots"]);
        let t = numbers(&story.job["parameters"]);
        let mut reported = 0;
        let mut before = f64::INFINITY;
        for iteration in &story.iterations {
            let new = iteration.get("knots").map(numbers);
            if let Some(new) = new {
                assert_ne!(new, knots, "knots are reported where they change");
                knots = new;
                reported += 1;
                before = f64::INFINITY;
            }
            let said = iteration["error"]["max"].as_f64().unwrap();
            let found = largest(&knots, &iteration["control_points"], &points, &t);
            // Both are sums of four products of numbers of the order of one.
            assert!((said - found).abs() < 1e-14, "{said} {found}");
            assert!(
                said <= before * (1.0 + 1e-12),
                "distances rise over the same knots"
            );
            before = said;
        }
        let first = story.iterations[0]["control_points"].as_array().unwrap();
        assert_eq!(first.len(), if is_closed { 7 } else { 4 });
        assert!(reported > 5, "{reported}");
        let last = story.iterations.last().unwrap();
        assert!(last["error"]["max"].as_f64().unwrap() <= 1e-5);
    }
}

/// The knots of the next event of a client are always those of its curve, also after skipped events and resumed
/// streams.
#[tokio::test]
async fn streams_that_skip_or_resume_have_the_knots() {
    let server = Server::start().await;
    let curve = json!({"points": points(300)});
    let job = server.fit(&automatic(curve, 1e-4, json!({}))).await;
    let path = job["links"]["events"].as_str().unwrap();
    let whole = Story::read(server.get(path).send().await.unwrap()).await;
    let mut known = whole.job["knots"].clone();
    let mut all = Vec::new();
    for iteration in &whole.iterations {
        known = iteration.get("knots").unwrap_or(&known).clone();
        all.push(known.clone());
    }
    let check = |story: &Story| {
        let mut known = story.job["knots"].clone();
        for iteration in &story.iterations {
            known = iteration.get("knots").unwrap_or(&known).clone();
            let k = iteration["iteration"].as_u64().unwrap() as usize;
            assert_eq!(known, all[k], "{k}");
        }
    };
    for query in [
        "?every=4",
        "?milestones=1e-1,1e-2,1e-3",
        "?changed=true",
        "?view=samples&samples=9",
    ] {
        let (iterations, _) =
            crate::support::thinned(&server, &format!("{path}{query}"), None).await;
        assert!(!iterations.is_empty());
        let mut known = whole.job["knots"].clone();
        for iteration in &iterations {
            known = iteration.get("knots").unwrap_or(&known).clone();
            let k = iteration["iteration"].as_u64().unwrap() as usize;
            assert_eq!(known, all[k], "{query} {k}");
        }
    }
    for after in [0, 7, 13, all.len() - 2] {
        let request = server.get(path).header("last-event-id", after.to_string());
        let story = Story::read(request.send().await.unwrap()).await;
        assert_eq!(story.iterations.len(), all.len() - 1 - after);
        check(&story);
        // The first of them has its knots, which the client may not know.
        let rest = story.iterations.iter().zip(&whole.iterations[after + 1..]);
        for (again, before) in rest {
            assert_eq!(again["control_points"], before["control_points"]);
            assert_eq!(again["error"], before["error"]);
        }
    }
    for k in [0, 9, all.len() - 1] {
        let base = job["links"]["self"].as_str().unwrap();
        let level = server.json(&format!("{base}/iterations/{k}")).await;
        assert_eq!(level["knots"], all[k]);
        assert_eq!(
            level["control_points"],
            whole.iterations[k]["control_points"]
        );
    }
    let result = server.json(job["links"]["result"].as_str().unwrap()).await;
    assert_eq!(result["knots"], all[all.len() - 1]);
}

/// Half a lemniscate of Gerono takes fewer control points than scipy's splprep (15, 27, 42) and
/// OpenCASCADE's GeomAPI_PointsToBSpline (17, 26, 39).
#[tokio::test]
async fn fewer_control_points_than_others_need_are_enough() {
    use std::f64::consts::{FRAC_PI_2, PI};
    let server = Server::start().await;
    let angle = |i: usize| PI * i as f64 / 499.0 - FRAC_PI_2;
    let points = (0..500).map(angle).map(|a| [a.cos(), a.sin() * a.cos()]);
    let points: Vec<[f64; 2]> = points.collect();
    for (tolerance, most) in [(1e-3, 13), (1e-4, 19), (1e-5, 29)] {
        let job = automatic(json!({"points": points}), tolerance, json!({}));
        let job = server.fit(&job).await;
        assert_eq!(job["state"], "converged");
        let result = server.json(job["links"]["result"].as_str().unwrap()).await;
        let count = result["control_points"].as_array().unwrap().len();
        assert!(count <= most, "{tolerance}: {count}");
    }
}

/// Surfaces have knots of both directions, and files have those of the result.
#[tokio::test]
async fn surfaces_choose_whole_lines_of_knots() {
    let server = Server::start().await;
    let method = json!({"kind": "least_squares", "control_points": "auto", "max_control_points": {"u": 20, "v": 15}});
    let job = json!({"surface": {"points": grid()}, "method": method, "stop": {"tolerance": 1e-3}});
    let story = server.stream(&job).await;
    assert_eq!(story.state(), "converged");
    assert_eq!(
        story.iterations[0]["control_points"]
            .as_array()
            .unwrap()
            .len(),
        4
    );
    let mut knots = story.job["knots"].clone();
    for iteration in &story.iterations {
        knots = iteration.get("knots").unwrap_or(&knots).clone();
        let rows = iteration["control_points"].as_array().unwrap();
        let columns = rows[0].as_array().unwrap().len();
        assert_eq!(knots["u"].as_array().unwrap().len(), rows.len() + 4);
        assert_eq!(knots["v"].as_array().unwrap().len(), columns + 4);
        assert!(rows.len() <= 20 && columns <= 15);
    }
    let id = story.job["id"].as_str().unwrap();
    let step = server
        .get(&format!("/v1/jobs/{id}/result/step"))
        .send()
        .await
        .unwrap();
    assert_eq!(step.status(), 200);
    assert!(step.text().await.unwrap().contains("B_SPLINE_SURFACE"));
}

/// Scattered points need fewer control points the looser the tolerance is, and distances are those of
/// the points.
#[tokio::test]
async fn scattered_points_are_fitted_within_the_tolerance() {
    let server = Server::start().await;
    let golden: Value = serde_json::from_str(include_str!("../golden/scattered.json")).unwrap();
    let mut counts = Vec::new();
    for tolerance in [0.1, 0.01] {
        let surface = json!({"scattered": golden["points"], "parameters": {"project": "xy"}});
        let method = json!({"kind": "least_squares", "control_points": "auto"});
        let job = json!({"surface": surface, "method": method, "stop": {"tolerance": tolerance}});
        let story = server.stream(&job).await;
        assert_eq!(story.state(), "converged", "{:#}", story.end);
        let last = story.iterations.last().unwrap();
        assert!(last["error"]["max"].as_f64().unwrap() <= tolerance);
        let rows = last["control_points"].as_array().unwrap();
        counts.push(rows.len() * rows[0].as_array().unwrap().len());
    }
    // 14 × 14 control points on equal steps come within .0067.
    assert!(counts[0] < counts[1] && counts[1] < 14 * 14, "{counts:?}");
}

/// Constraints hold at every level, and fair fits end within the tolerance, too.
#[tokio::test]
async fn constraints_hold_at_every_level() {
    let server = Server::start().await;
    let points = points(200);
    let more = json!({"constraints": [{"index": 50}, {"index": 121}], "fairness": 1e-13});
    let story = server
        .stream(&automatic(json!({"points": points}), 1e-3, more))
        .await;
    assert_eq!(story.state(), "converged");
    let mut knots = numbers(&story.job["knots"]);
    let t = numbers(&story.job["parameters"]);
    for iteration in &story.iterations {
        knots = iteration.get("knots").map_or(knots, numbers);
        let control_points = &iteration["control_points"];
        for index in [0, 50, 121, 199] {
            let distance = largest(
                &knots,
                control_points,
                &points[index..=index],
                &t[index..=index],
            );
            assert!(distance < 1e-12, "{index}: {distance}");
        }
    }
}

/// Where the tolerance needs more control points than are allowed, the fit ends with as many.
#[tokio::test]
async fn a_limit_ends_the_fit() {
    let server = Server::start().await;
    let more = json!({"max_control_points": 9});
    let story = server
        .stream(&automatic(json!({"points": points(200)}), 1e-6, more))
        .await;
    assert_eq!(story.state(), "exhausted");
    let count = |it: &Value| it["control_points"].as_array().unwrap().len();
    assert!(story.iterations.iter().all(|it| count(it) <= 9));
    let errors = story
        .iterations
        .iter()
        .map(|it| it["error"]["max"].as_f64().unwrap());
    let last = story.error(story.iterations.len() - 1);
    assert_eq!(
        last,
        errors.fold(f64::INFINITY, f64::min),
        "it ends with the closest one"
    );
}

/// Parameters that move to foot points need no more control points, and errors are distances from the
/// curve.
#[tokio::test]
async fn corrected_parameters_need_fewer_control_points() {
    let server = Server::start().await;
    let mut counts = Vec::new();
    for correct in [false, true] {
        let more = json!({"correct_parameters": correct});
        let job = server
            .fit(&automatic(json!({"points": points(500)}), 1e-4, more))
            .await;
        assert_eq!(job["state"], "converged");
        let result = server.json(job["links"]["result"].as_str().unwrap()).await;
        counts.push(result["control_points"].as_array().unwrap().len());
    }
    assert!(counts[1] <= counts[0], "{counts:?}");
}

/// Few, equal and degenerate points.
#[tokio::test]
async fn few_points_are_fitted() {
    let server = Server::start().await;
    for count in [2, 3, 4, 5, 6] {
        let points: Vec<[f64; 2]> = points(61).into_iter().take(count).collect();
        let job = server
            .fit(&automatic(json!({"points": points}), 1e-9, json!({})))
            .await;
        assert_eq!(job["state"], "converged", "{count}: {job:#}");
        assert!(job["error"]["max"].as_f64().unwrap() <= 1e-9);
    }
    let line: Vec<[f64; 3]> = (0..100).map(|i| [i as f64, 2.0 * i as f64, 1e6]).collect();
    let story = server
        .stream(&automatic(json!({"points": line}), 1e-6, json!({})))
        .await;
    assert_eq!(story.state(), "converged");
    let last = story.iterations.last().unwrap();
    assert_eq!(last["control_points"].as_array().unwrap().len(), 4);
}

/// An edit starts from the knots and the control points of its parent.
#[tokio::test]
async fn edits_start_from_the_knots_of_their_parent() {
    let server = Server::start().await;
    let job = server
        .fit(&automatic(json!({"points": points(300)}), 1e-4, json!({})))
        .await;
    let result = server.json(job["links"]["result"].as_str().unwrap()).await;
    let body = json!({"points": [{"index": 100, "point": [0.0, 0.1]}]});
    let edits = format!("{}/edits", job["links"]["self"].as_str().unwrap());
    let request = server
        .post(&edits)
        .header("accept", "text/event-stream")
        .json(&body);
    let story = Story::read(request.send().await.unwrap()).await;
    assert_eq!(story.state(), "converged");
    assert_eq!(story.job["knots"], result["knots"]);
    assert_eq!(
        story.iterations[0]["control_points"],
        result["control_points"]
    );
    assert!(story.error(story.iterations.len() - 1) <= 1e-4);
    // A looser tolerance needs fewer of them.
    let body = json!({"stop": {"tolerance": 1e-2}});
    let request = server
        .post(&edits)
        .header("accept", "text/event-stream")
        .json(&body);
    let story = Story::read(request.send().await.unwrap()).await;
    let count = |it: &Value| it["control_points"].as_array().unwrap().len();
    assert!(count(story.iterations.last().unwrap()) < count(&result));
}

/// The same for surfaces, of a grid and of scattered points.
#[tokio::test]
async fn edits_of_surfaces_start_from_their_knots() {
    let server = Server::start().await;
    let golden: Value = serde_json::from_str(include_str!("../golden/scattered.json")).unwrap();
    let scattered = json!({"scattered": golden["points"], "parameters": {"project": "xy"}});
    let surfaces = [
        (json!({"points": grid()}), json!([3, 4]), 1e-3),
        (scattered, json!(77), 0.05),
    ];
    for (surface, index, tolerance) in surfaces {
        let method = json!({"kind": "least_squares", "control_points": "auto"});
        let stop = json!({"tolerance": tolerance});
        let job = json!({"surface": surface, "method": method, "stop": stop});
        let job = server.fit(&job).await;
        assert_eq!(job["state"], "converged");
        let result = server.json(job["links"]["result"].as_str().unwrap()).await;
        let body = json!({"points": [{"index": index, "point": [0.3, 0.6, 0.5]}]});
        let edits = format!("{}/edits", job["links"]["self"].as_str().unwrap());
        let request = server
            .post(&edits)
            .header("accept", "text/event-stream")
            .json(&body);
        let story = Story::read(request.send().await.unwrap()).await;
        assert_eq!(story.job["knots"], result["knots"]);
        assert_eq!(
            story.iterations[0]["control_points"],
            result["control_points"]
        );
        assert!(story.iterations.len() > 1);
    }
}

/// What does not go with it is refused, with the place and the reason.
#[tokio::test]
async fn what_does_not_go_with_it_is_refused() {
    let server = Server::start().await;
    let curve = || json!({"points": points(50)});
    let with = |more: Value| automatic(curve(), 1e-3, more);
    for (more, pointer, reason) in [
        (json!({"variant": "direct"}), "/method/variant", "variant"),
        (
            json!({"max_control_points": 3}),
            "/method/max_control_points",
            "degree",
        ),
        (
            json!({"max_control_points": {"u": 5, "v": 5}}),
            "/method/max_control_points",
            "one number",
        ),
        (
            json!({"correct_parameters": true, "fairness": 1}),
            "/method/correct_parameters",
            "correct_parameters",
        ),
        (
            json!({"control_points": 9, "max_control_points": 12}),
            "/method/max_control_points",
            "auto",
        ),
        (
            json!({"control_points": 9, "correct_parameters": true}),
            "/method/correct_parameters",
            "auto",
        ),
        (
            json!({"control_points": "all"}),
            "/method/control_points",
            "auto",
        ),
    ] {
        server.assert_refused(&with(more), pointer, reason).await;
    }
    for (name, value, reason) in [
        ("basis", json!("bernstein"), "knots"),
        (
            "basis",
            json!({"kind": "bspline", "degree": 3, "knots": "averaged"}),
            "knots",
        ),
        ("weights", json!(vec![1.0; 50]), "weights"),
    ] {
        let mut job = with(json!({}));
        job["curve"][name] = value;
        let pointer = format!("/curve/{name}");
        server.assert_refused(&job, &pointer, reason).await;
    }
    let surface = |surface: Value, method: Value| json!({"surface": surface, "method": method});
    let auto = |u: Value| json!({"kind": "least_squares", "control_points": u});
    for (shape, method, pointer, reason) in [
        (
            json!({"points": grid()}),
            auto(json!({"u": "auto", "v": 5})),
            "/method/control_points",
            "both",
        ),
        (
            json!({"points": grid()}),
            json!({"kind": "least_squares", "control_points": "auto", "max_control_points": {"u": 9, "v": 2}}),
            "/method/max_control_points/v",
            "degree",
        ),
    ] {
        server
            .assert_refused(&surface(shape, method), pointer, reason)
            .await;
    }
}

/// Where the number of control points is limited, spans that are furthest from the data get knots first: a chirp with 20
/// had the curve of seven.
#[tokio::test]
async fn limited_fits_use_what_they_may() {
    let server = Server::start().await;
    let t: Vec<f64> = (0..400).map(|i| f64::from(i) / 399.0).collect();
    let points: Vec<_> = t.iter().map(|t| [*t, 0.2 * (40.0 * t * t).sin()]).collect();
    let mut errors = Vec::new();
    for most in [7, 12, 20] {
        let more = json!({"max_control_points": most});
        let story = server
            .stream(&automatic(json!({"points": points}), 1e-6, more))
            .await;
        assert_eq!(story.state(), "exhausted", "{}", story.end);
        let last = story.iterations.len() - 1;
        let used = story.iterations[last]["control_points"]
            .as_array()
            .unwrap()
            .len();
        assert!(used <= most, "{used}");
        errors.push(story.error(last));
    }
    assert!(
        errors[1] < 0.97 * errors[0] && errors[2] < 0.9 * errors[1],
        "{errors:?}"
    );
}
