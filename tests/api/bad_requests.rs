//! Everything that can be wrong with the body of a request is answered with what, where and why.

use serde_json::{Value, json};

use crate::data;
use crate::support::{Server, base, problem};

/// A body that is wrong, with the status, the pointer and a part of the reason that is expected.
struct Bad {
    body: String,
    status: u16,
    pointer: Option<&'static str>,
    reason: &'static str,
}

fn bad(body: Value, pointer: &'static str, reason: &'static str) -> Bad {
    text(&body.to_string(), 422, Some(pointer), reason)
}

fn text(body: &str, status: u16, pointer: Option<&'static str>, reason: &'static str) -> Bad {
    Bad {
        body: body.to_owned(),
        status,
        pointer,
        reason,
    }
}

/// A curve through four points with one thing changed.
fn curve(field: &str, value: Value) -> Value {
    let mut job = json!({"curve": {"points": [[0, 0], [1, 2], [3, 1], [4, 4]]}});
    job["curve"][field] = value;
    job
}

fn bspline(basis: Value) -> Value {
    let mut basis = basis;
    basis["kind"] = json!("bspline");
    curve("basis", basis)
}

fn surface(field: &str, value: Value) -> Value {
    let mut job = json!({"surface": {"points": data::peaks(4)}});
    job["surface"][field] = value;
    job
}

fn stop(rules: Value) -> Value {
    let mut job = curve("parameters", json!("uniform"));
    job["stop"] = rules;
    job
}

fn not_json() -> Vec<Bad> {
    vec![
        text("", 400, None, "the body is empty"),
        text("hello", 400, None, "expected value at line 1 column 1"),
        text(
            "{\"curve\": ",
            400,
            Some("/curve"),
            "the body ends where a value should be",
        ),
        text(
            "{\"curve\":{\"points\":[[0,0],[1,NaN]]}}",
            400,
            Some("/curve/points/1/1"),
            "no NaN",
        ),
        text(
            "{\"curve\":{\"points\":[[0,0],[Infinity,1]]}}",
            400,
            Some("/curve/points/1/0"),
            "no Infinity",
        ),
        text(
            "{\"curve\":{\"points\":[[0,0],[1,1]]}} x",
            400,
            None,
            "something follows",
        ),
        text(
            "{\"curve\":{\"points\":[[0,0],[1,1],]}}",
            400,
            None,
            "a comma with nothing after it",
        ),
        text(
            "\u{feff}{}",
            422,
            Some(""),
            "a curve or a surface is needed",
        ),
        text(
            &"[".repeat(100_000),
            422,
            None,
            "expected an object, found a list",
        ),
        text(
            "{\"curve\":{\"points\":[[0,0],[1e999,1]]}}",
            422,
            Some("/curve/points/1/0"),
            "the number at line 1 column",
        ),
        text(
            "{\"curve\":{\"points\":[[0,0],[-1e400,1]]}}",
            422,
            Some("/curve/points/1/0"),
            "64-bit floating-point numbers",
        ),
    ]
}

fn wrong_shape() -> Vec<Bad> {
    vec![
        bad(json!([]), "", "expected an object"),
        bad(json!({}), "", "a curve or a surface is needed"),
        bad(json!({"curve": null}), "", "a curve or a surface is needed"),
        bad(
            json!({"curve": {"points": [[0], [1]]}, "surface": {"points": [[[0], [1]], [[2], [3]]]}}),
            "/surface",
            "it cannot have a surface as well",
        ),
        bad(
            json!({"curve": {}}),
            "/curve",
            "the field \"points\" is missing",
        ),
        bad(json!({"curv": {}}), "/curv", "unknown field \"curv\""),
        bad(
            curve("degre", json!(3)),
            "/curve/degre",
            "unknown field \"degre\"",
        ),
        bad(
            curve("points", json!("many")),
            "/curve/points",
            "expected a list of points",
        ),
        bad(
            curve("points", json!([])),
            "/curve/points",
            "at least 2 points",
        ),
        bad(curve("points", json!([[1, 2]])), "/curve/points", "1 given"),
        bad(
            curve("points", json!([[0, 0], 1])),
            "/curve/points/1",
            "a list of 1 to 16 numbers",
        ),
        bad(
            curve("points", json!([[0, 0], []])),
            "/curve/points/1",
            "found 0 of them",
        ),
        bad(
            curve("points", json!([vec![0; 17], vec![1; 17]])),
            "/curve/points/0",
            "found 17 of them",
        ),
        bad(
            curve("points", json!([[0, 0], [1, 1], [2, 2, 2]])),
            "/curve/points/2",
            "3 coordinates, the first has 2",
        ),
        bad(
            curve("points", json!([[0, 0], [1, "1"]])),
            "/curve/points/1/1",
            "expected a number",
        ),
        bad(
            curve("points", json!([[0, 0], [1, null]])),
            "/curve/points/1/1",
            "null",
        ),
        bad(
            surface("points", json!([[0, 0], [1, 1]])),
            "/surface/points/0",
            "expected a row of points",
        ),
        bad(
            surface("points", json!([[[0, 0], [0, 1]]])),
            "/surface/points",
            "1 given",
        ),
        bad(
            surface("points", json!([[[0, 0]], [[1, 0]]])),
            "/surface/points",
            "1 given",
        ),
        bad(
            surface("points", json!([[[0, 0], [0, 1]], [[1, 0]]])),
            "/surface/points/1",
            "1 points, the first row has 2",
        ),
        bad(
            surface("points", json!([[[0, 0], [0, 1]], [[1, 0], [1, 1, 1]]])),
            "/surface/points/1/1",
            "3 coordinates",
        ),
        bad(
            json!({"name": 7, "curve": {"points": [[0], [1]]}}),
            "/name",
            "expected a string",
        ),
        bad(
            json!({"name": "n".repeat(201), "curve": {"points": [[0], [1]]}}),
            "/name",
            "longer than 200",
        ),
    ]
}

/// Lists for objects and objects for names: other readers of JSON take them.
fn wrong_form() -> Vec<Bad> {
    vec![
        bad(
            json!(["n", {"points": [[0], [1]]}]),
            "",
            "expected an object",
        ),
        bad(
            curve("basis", json!(["bspline", 2])),
            "/curve/basis",
            "expected",
        ),
        bad(
            curve("basis", json!({"kind": {"bspline": null}})),
            "/curve/basis/kind",
            "expected the name of a kind of",
        ),
        bad(
            json!({"curve": [[[0], [1]]]}),
            "/curve",
            "expected an object",
        ),
        bad(stop(json!([1e-3, null, 5])), "/stop", "expected an object"),
        bad(
            stop(json!({"max_iterations": 1000.5})),
            "/stop/max_iterations",
            "expected a whole number",
        ),
        text("{\"name\":\"\\ud800\"}", 400, None, "hex escape"),
    ]
}

fn wrong_basis() -> Vec<Bad> {
    let knots = |knots: Value| bspline(json!({"degree": 2, "knots": knots}));
    vec![
        bad(
            curve("basis", json!({"kind": "spline"})),
            "/curve/basis/kind",
            "unknown kind of",
        ),
        bad(
            curve("basis", json!({"degree": 3})),
            "/curve/basis",
            "the field \"kind\" is missing",
        ),
        bad(
            curve("basis", json!("spline")),
            "/curve/basis",
            "unknown kind of basis",
        ),
        bad(
            curve("basis", json!(3)),
            "/curve/basis",
            "expected an object with a kind, or the name of a kind",
        ),
        bad(
            bspline(json!({"order": 4})),
            "/curve/basis/order",
            "unknown field \"order\"",
        ),
        bad(
            bspline(json!({"degree": 0})),
            "/curve/basis/degree",
            "below 1",
        ),
        bad(bspline(json!({"degree": -1})), "/curve/basis/degree", "-1"),
        bad(
            bspline(json!({"degree": 2.5})),
            "/curve/basis/degree",
            "2.5",
        ),
        bad(
            bspline(json!({"degree": 1001})),
            "/curve/basis/degree",
            "above 1000",
        ),
        bad(
            bspline(json!({"degree": 4, "knots": "averaged"})),
            "/curve/basis/degree",
            "at least 5 points with averaged knots, 4 given",
        ),
        bad(
            curve("basis", json!({"kind": "bernstein", "degree": 3})),
            "/curve/basis/degree",
            "no degree to choose",
        ),
        bad(
            curve("basis", json!({"kind": "bernstein", "knots": "data"})),
            "/curve/basis/knots",
            "no knots to choose",
        ),
        bad(
            bspline(json!({"knots": "mean"})),
            "/curve/basis/knots",
            "unknown rule for knots \"mean\"",
        ),
        bad(
            knots(json!([0, 0, 0, 1, 1, 1])),
            "/curve/basis/knots",
            "6 knots given",
        ),
        bad(
            knots(json!([0, 0, 0, 0.5, 0.4, 1, 1])),
            "/curve/basis/knots/4",
            "less than the one before",
        ),
        bad(
            knots(json!([0, 0, 0.1, 0.5, 1, 1, 1])),
            "/curve/basis/knots/2",
            "clamped",
        ),
        bad(
            knots(json!([0, 0, 0, 0, 1, 1, 1])),
            "/curve/basis/knots/3",
            "more than degree = 2 times",
        ),
        bad(
            knots(json!([0, 0, 0, "x", 1, 1, 1])),
            "/curve/basis/knots/3",
            "expected a number",
        ),
        bad(
            bspline(json!({"degree": 1, "knots": [0, 0, 0.9, 0.95, 1, 1]})),
            "/curve/basis/knots",
            "Schoenberg–Whitney: parameter 2",
        ),
        bad(
            surface("basis", json!({"u": {"kind": "bspline"}})),
            "/surface/basis",
            "the field \"v\" is missing",
        ),
        bad(
            surface(
                "basis",
                json!({"u": {"kind": "bspline"}, "v": {"kind": "bspline", "degree": 0}}),
            ),
            "/surface/basis/v/degree",
            "below 1",
        ),
        bad(
            surface(
                "basis",
                json!({"u": {"kind": "bspline"}, "v": {"kind": "bspline"}, "w": 1}),
            ),
            "/surface/basis/w",
            "unknown field \"w\"",
        ),
    ]
}

fn wrong_parameters() -> Vec<Bad> {
    vec![
        bad(
            curve("parameters", json!("cord")),
            "/curve/parameters",
            "unknown rule for parameters \"cord\"",
        ),
        bad(
            curve("parameters", json!(7)),
            "/curve/parameters",
            "or a list of numbers",
        ),
        bad(
            curve("parameters", json!([0, 1, 2])),
            "/curve/parameters",
            "3 parameters for 4 points",
        ),
        bad(
            curve("parameters", json!([0, 1, 1, 2])),
            "/curve/parameters/2",
            "not greater than the one before",
        ),
        bad(
            curve("parameters", json!([0, 2, 1, 3])),
            "/curve/parameters/2",
            "strictly increase",
        ),
        bad(
            curve("parameters", json!([0, 1, 2, null])),
            "/curve/parameters/3",
            "null",
        ),
        bad(
            curve("parameters", json!([-1e308, 0, 1, 1e308])),
            "/curve/parameters",
            "range of 64-bit numbers",
        ),
        bad(
            curve("points", json!([[0, 0], [1, 1], [1, 1], [2, 0]])),
            "/curve/points/2",
            "point 2 equals point 1",
        ),
        bad(
            json!({"curve": {"points": [[5], [5], [6]], "parameters": "centripetal"}}),
            "/curve/points/1",
            "centripetal",
        ),
        bad(
            surface(
                "points",
                json!([[[0, 0], [0, 1]], [[0, 0], [0, 1]], [[1, 0], [1, 1]]]),
            ),
            "/surface/points/1",
            "line 1 equal those of line 0",
        ),
        bad(
            surface("points", json!([[[0, 0], [0, 0]], [[1, 0], [1, 0]]])),
            "/surface/points/0/1",
            "line 1 equal those of line 0",
        ),
        bad(
            surface("parameters", json!({"u": "uniform", "v": [0, 1, 2]})),
            "/surface/parameters/v",
            "3 parameters for 4 points",
        ),
        bad(
            curve("points", json!([[-1e308], [1e308]])),
            "/curve/points",
            "more than the range",
        ),
    ]
}

fn wrong_rules() -> Vec<Bad> {
    let method = |method: Value| {
        let mut job = curve("parameters", json!("uniform"));
        job["method"] = method;
        job
    };
    vec![
        bad(
            method(json!({"kind": "magic"})),
            "/method/kind",
            "unknown kind of",
        ),
        bad(
            method(json!({})),
            "/method",
            "the field \"kind\" is missing",
        ),
        bad(
            method(json!({"kind": ["global"]})),
            "/method/kind",
            "expected the name of a kind of",
        ),
        bad(
            method(json!({"kind": "global", "omega": 1})),
            "/method/omega",
            "unknown field \"omega\"; there are no settings",
        ),
        bad(
            stop(json!({"tolerance": -1})),
            "/stop/tolerance",
            "zero or greater",
        ),
        bad(
            stop(json!({"relative_tolerance": -1e-9})),
            "/stop/relative_tolerance",
            "zero or greater",
        ),
        bad(
            stop(json!({"tolerance": "small"})),
            "/stop/tolerance",
            "expected a number",
        ),
        bad(
            stop(json!({"tolerance": 1, "relative_tolerance": 1})),
            "/stop/relative_tolerance",
            "tolerance is given",
        ),
        bad(
            stop(json!({"max_iterations": -1})),
            "/stop/max_iterations",
            "-1",
        ),
        bad(
            stop(json!({"max_iterations": 1.5})),
            "/stop/max_iterations",
            "1.5",
        ),
        bad(
            stop(json!({"max_iterations": 1_000_000_001})),
            "/stop/max_iterations",
            "limit of this server",
        ),
        bad(
            stop(json!({"iterations": 5})),
            "/stop/iterations",
            "unknown field \"iterations\"",
        ),
    ]
}

#[tokio::test]
async fn bodies() {
    let server = Server::start().await;
    let cases: Vec<Bad> = [
        not_json(),
        wrong_shape(),
        wrong_form(),
        wrong_basis(),
        wrong_parameters(),
        wrong_rules(),
    ]
    .into_iter()
    .flatten()
    .collect();
    assert!(cases.len() >= 40);
    let mut surprises = Vec::new();
    for case in &cases {
        let request = server
            .post("/v1/jobs")
            .header("content-type", "application/json");
        let response = request.body(case.body.clone()).send().await.unwrap();
        let (status, problem) = problem(response).await;
        let detail = problem["detail"].as_str().unwrap();
        let error = &problem["errors"][0];
        let pointed = case.pointer.is_none_or(|pointer| {
            error["pointer"] == pointer && !error["detail"].as_str().unwrap().is_empty()
        });
        if status != case.status || !detail.contains(case.reason) || !pointed {
            let shown: String = case.body.chars().take(200).collect();
            surprises.push(format!("{shown}\n{problem:#}"));
        }
    }
    assert!(surprises.is_empty(), "{}", surprises.join("\n\n"));
    // None of them left anything behind, and the server continues.
    assert_eq!(server.json("/v1/jobs").await["jobs"], json!([]));
    let job = server.fit(&data::small_job()).await;
    assert_eq!(job["state"], "converged");
}

/// The maximum number of reported errors of a body.
const MOST_TOLD: usize = 16;

/// Posts an invalid request and returns the locations of its errors. The detail, which is cut if there are too many,
/// names each of them, too.
async fn refused(server: &Server, path: &str, body: &Value) -> Vec<String> {
    let response = server.post(path).json(body).send().await.unwrap();
    let (status, problem) = problem(response).await;
    assert_eq!(status, 422, "{problem:#}");
    let detail = problem["detail"].as_str().unwrap();
    let errors = problem["errors"].as_array().unwrap();
    let in_text = |pointer: &str| errors.len() == MOST_TOLD || detail.contains(pointer);
    let pointers = errors
        .iter()
        .map(|error| error["pointer"].as_str().unwrap());
    pointers
        .inspect(|pointer| assert!(in_text(pointer), "{pointer}: {detail}"))
        .map(str::to_owned)
        .collect()
}

/// A small job that has ended: the path under which it is edited.
async fn edits(server: &Server) -> String {
    let parent = server.fit(&data::small_job()).await;
    format!("{}/edits", base(&parent))
}

/// The first unreadable value is reported, at any location.
#[tokio::test]
async fn the_first_unreadable_value_is_reported() {
    let server = Server::start().await;
    let job = json!({
        "curve": {"points": [[0, 0], [1, "1"], [2, 0], [null, 0], [4, 4]], "parametrs": "uniform"},
        "stop": {"tolerance": "small"},
    });
    let reported = refused(&server, "/v1/jobs", &job).await;
    assert_eq!(reported, ["/curve/points/1/1"]);
    // Before the kind of a method, too.
    let late = json!({"method": {"indices": [1, 2.5], "kind": "local"}});
    let reported = refused(&server, "/v1/jobs", &late).await;
    assert_eq!(reported, ["/method/indices/1"]);
    let edit = json!({
        "points": [{"index": 1, "point": [1, 2]}, {"point": {"x": 1, "y": 2}}],
        "method": {"kind": "weighted", "omega": "most"},
    });
    let reported = refused(&server, &edits(&server).await, &edit).await;
    assert_eq!(reported, ["/points/1/point"]);
}

/// What can be read, but is no fit, in several ways.
#[tokio::test]
async fn several_errors_of_the_fit_are_reported_together() {
    let server = Server::start().await;
    let curve = json!({
        "curve": {
            "points": [[0, 0], [1, 1], [2, 0], [4, 4]],
            "parameters": [0, 1, 1, 2],
            "weights": [1, 1, -1, 1],
        },
        "method": {"kind": "local"},
        "stop": {"tolerance": -1, "max_iterations": 2_000_000_000},
        "stream": {"every": 0},
    });
    let reported = refused(&server, "/v1/jobs", &curve).await;
    let expected = ["/stop/max_iterations", "/stream/every", "/method"];
    assert_eq!(reported, expected);
    // Without those the numbers are looked at.
    let mut curve = curve;
    curve["method"] = json!({"kind": "weighted", "omega": 3});
    curve["stop"] = json!({"tolerance": -1});
    curve["stream"] = json!({});
    let reported = refused(&server, "/v1/jobs", &curve).await;
    let expected = [
        "/stop/tolerance",
        "/method/omega",
        "/curve/parameters/2",
        "/curve/weights/2",
    ];
    assert_eq!(reported, expected);
    let surface = json!({
        "surface": {
            "points": data::peaks(4),
            "basis": {"u": {"kind": "bernstein", "degree": 3, "knots": "data"}, "v": "bspline"},
            "weights": [[1, 1]],
        },
        "stop": {"tolerance": 1, "relative_tolerance": 1},
    });
    let reported = refused(&server, "/v1/jobs", &surface).await;
    let expected = [
        "/surface/weights",
        "/surface/basis/u/degree",
        "/surface/basis/u/knots",
        "/stop/relative_tolerance",
    ];
    assert_eq!(reported, expected);

    let edit = json!({
        "points": [{"index": 1, "point": [1]}, {"index": 9999, "point": [1, 2]}, {"index": 2}],
        "method": {"kind": "adaptive"},
        "stop": {"tolerance": 1, "relative_tolerance": 1},
    });
    let reported = refused(&server, &edits(&server).await, &edit).await;
    let expected = [
        "/points/0/point",
        "/points/1/index",
        "/points/2",
        "/method",
        "/stop/relative_tolerance",
    ];
    assert_eq!(reported, expected);
}

/// All neighbours that are equal, and all else that is wrong, in one answer.
#[tokio::test]
async fn all_equal_neighbours_are_reported_together() {
    let server = Server::start().await;
    let job = json!({
        "curve": {"points": [[0, 0], [1, 1], [1, 1], [2, 0], [3, 0], [3, 0], [3, 0], [4, 1]]},
        "method": {"kind": "weighted", "omega": 7},
    });
    let reported = refused(&server, "/v1/jobs", &job).await;
    let expected = [
        "/method/omega",
        "/curve/points/2",
        "/curve/points/5",
        "/curve/points/6",
    ];
    assert_eq!(reported, expected);
    let closed =
        json!({"curve": {"points": [[0, 0], [1, 1], [1, 1], [2, 0], [0, 0]], "closed": true}});
    let reported = refused(&server, "/v1/jobs", &closed).await;
    assert_eq!(reported, ["/curve/points/2", "/curve/points/4"]);
    // Lines of a surface, and the error of the other direction.
    let row = |x: f64| -> Vec<[f64; 3]> { (0..4).map(|j| [x, f64::from(j), 0.0]).collect() };
    let rows: Vec<_> = [0.0, 0.0, 1.0, 2.0, 2.0].into_iter().map(row).collect();
    let job = json!({"surface": {"points": rows, "degree": {"u": 3, "v": 0}}});
    let reported = refused(&server, "/v1/jobs", &job).await;
    let expected = [
        "/surface/points/1",
        "/surface/points/4",
        "/surface/degree/v",
    ];
    assert_eq!(reported, expected);
    // With any number of points, and up to the limit of errors.
    let points: Vec<[f64; 2]> = (0..40_000).map(|i| [f64::from(i / 2 * 2), 0.0]).collect();
    let response = server
        .post("/v1/jobs")
        .json(&json!({"curve": {"points": points}}));
    let (_, refusal) = problem(response.send().await.unwrap()).await;
    let errors = refusal["errors"].as_array().unwrap();
    assert_eq!(errors.len(), 16);
    assert_eq!(errors[15]["pointer"], "/curve/points/31");
    let last = errors[15]["detail"].as_str().unwrap();
    assert!(last.ends_with("there are more of them"), "{last}");
}

/// Errors of a setting list the known ones and a correction.
#[tokio::test]
async fn refusals_say_what_to_write_instead() {
    let server = Server::start().await;
    let points = data::wave(12);
    let method = |method: Value| json!({"curve": {"points": points}, "method": method});
    let curve = |curve: Value| {
        let mut job = json!({"curve": curve});
        job["curve"]["points"] = json!(points);
        job
    };
    let mut least_squares = curve(json!({"ends": "natural"}));
    least_squares["method"] = json!({"kind": "least_squares", "control_points": 5});
    for (job, pointer, detail) in [
        (
            method(json!({"kind": "weighted", "omga": 1})),
            "/method/omga",
            "unknown field \"omga\"; expected one of omega",
        ),
        // The kind may come last.
        (
            method(json!({"a_setting": 1, "kind": "extended"})),
            "/method/a_setting",
            "unknown field \"a_setting\"; expected one of start, transformed_error",
        ),
        (
            method(json!({"kind": "direct", "omga": 1})),
            "/method/omga",
            "unknown field \"omga\"; there are no settings",
        ),
        (
            method(json!({"kind": "least_squares", "control_points": 30})),
            "/method/control_points",
            "give at least 2 and at most 12, or up to 24 together with \"fairness\"",
        ),
        (
            least_squares,
            "/curve/ends",
            "name the end_points of the method \"interpolated\" or \"free\"",
        ),
        (
            curve(json!({"ends": "natural", "degree": 2})),
            "/curve/ends",
            "natural ends are those of cubic B-splines; this one has degree 2",
        ),
        (
            curve(json!({"ends": {"end": "estimated"}, "degree": 4})),
            "/curve/ends",
            "use an odd degree, or knots \"data\"",
        ),
    ] {
        server.assert_refused(&job, pointer, detail).await;
    }
}
