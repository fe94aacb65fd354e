//! Every method with every basis, for curves and surfaces, with and without weights: either it
//! converges to the interpolant, or it is refused with a reason.

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::{Value, json};

use crate::support::{Server, base, problem};

/// Bases by the name that the documentation gives them, with what is special about them.
const BASES: [&str; 5] = [
    "B-spline",
    "closed B-spline",
    "Bernstein",
    "Said–Ball",
    "Wang–Ball",
];

const RATIONAL: [&str; 3] = ["plain", "homogeneous", "fixed"];

/// A pseudo-random number in [0, 1), the same in every run.
fn noise(seed: &mut u64) -> f64 {
    *seed = seed
        .wrapping_mul(6_364_136_223_846_793_005)
        .wrapping_add(1_442_695_040_888_963_407);
    (*seed >> 11) as f64 / (1_u64 << 53) as f64
}

const ROWS: usize = 5;
const COLUMNS: usize = 4;

/// Points near an ellipse, convex but for nothing: any method can fit them.
fn curve_points(seed: &mut u64) -> Value {
    let points: Vec<[f64; 2]> = (0..ROWS)
        .map(|i| i as f64 + 0.2 * noise(seed))
        .map(|a| [3.0 * a.cos(), 2.0 * a.sin()])
        .collect();
    json!(points)
}

fn surface_points(seed: &mut u64) -> Value {
    let rows: Vec<Vec<[f64; 3]>> = (0..ROWS)
        .map(|i| {
            (0..COLUMNS)
                .map(|j| {
                    [
                        i as f64 + 0.3 * noise(seed),
                        j as f64 + 0.3 * noise(seed),
                        noise(seed),
                    ]
                })
                .collect()
        })
        .collect();
    json!(rows)
}

fn weights(count: usize, seed: &mut u64) -> Vec<f64> {
    (0..count).map(|_| 0.8 + 0.4 * noise(seed)).collect()
}

/// A job with everything but the method.
fn job(basis: &str, surface: bool, rational: &str, seed: &mut u64) -> Value {
    let kind = match basis {
        "Bernstein" => "bernstein",
        "Said–Ball" => "said_ball",
        "Wang–Ball" => "wang_ball",
        _ => "bspline",
    };
    let mut shape = json!({"basis": {"kind": kind}, "parameters": "uniform"});
    if basis == "closed B-spline" {
        shape["closed"] = json!(true);
    }
    if basis.ends_with("B-spline") {
        shape["basis"]["degree"] = json!(3);
        shape["parameters"] = json!("chord_length");
    }
    if rational != "plain" {
        shape["weights"] = if !surface {
            json!(weights(ROWS, seed))
        } else if rational == "fixed" {
            json!({"u": weights(ROWS, seed), "v": weights(COLUMNS, seed)})
        } else {
            json!(
                (0..ROWS)
                    .map(|_| weights(COLUMNS, seed))
                    .collect::<Vec<_>>()
            )
        };
    }
    let mut job = if surface {
        shape["points"] = surface_points(seed);
        json!({"surface": shape})
    } else {
        shape["points"] = curve_points(seed);
        json!({"curve": shape})
    };
    if rational != "plain" {
        job["rational"] = json!(rational);
    }
    job["stop"] = json!({"relative_tolerance": 1e-12, "max_iterations": 1_000_000});
    job
}

/// All methods with all their variants, under the names of the documentation's table.
fn methods(surface: bool) -> Vec<(&'static str, Value)> {
    let all: Value = if surface {
        let pairs = (0..ROWS).flat_map(|i| (0..COLUMNS).map(move |j| [i, j]));
        json!(pairs.collect::<Vec<_>>())
    } else {
        json!((0..ROWS).collect::<Vec<_>>())
    };
    let control_points = if surface {
        json!({"u": ROWS, "v": COLUMNS})
    } else {
        json!(ROWS)
    };
    let mut methods = vec![
        ("global", json!({"kind": "global"})),
        ("weighted", json!({"kind": "weighted"})),
        ("weighted", json!({"kind": "weighted", "omega": 0.9})),
        ("local", json!({"kind": "local", "indices": all})),
        ("adaptive", json!({"kind": "adaptive", "threshold": 1e-12})),
        ("extended", json!({"kind": "extended"})),
        ("extended", json!({"kind": "extended", "start": "data"})),
        ("transpose", json!({"kind": "transpose"})),
        ("chebyshev", json!({"kind": "chebyshev"})),
        ("convex", json!({"kind": "convex"})),
        (
            "least_squares",
            json!({"kind": "least_squares", "control_points": control_points, "variant": "cg"}),
        ),
    ];
    if surface {
        methods.push((
            "local, row by row",
            json!({"kind": "local", "sweeps": "rows"}),
        ));
        methods.push((
            "local, column by column",
            json!({"kind": "local", "sweeps": "columns"}),
        ));
    }
    methods
}

/// All numbers within lists.
fn numbers(value: &Value, into: &mut Vec<f64>) {
    match value {
        Value::Array(list) => list.iter().for_each(|value| numbers(value, into)),
        Value::Number(number) => into.push(number.as_f64().unwrap()),
        _ => {}
    }
}

/// Points of the fitted curve or surface.
async fn geometry(server: &Server, job: &Value) -> Vec<f64> {
    let path = job["links"]["result"].as_str().unwrap();
    let samples = if job["kind"] == "curve" {
        "101"
    } else {
        "31x31"
    };
    let result = server
        .json(&format!("{path}?view=samples&samples={samples}"))
        .await;
    let mut all = Vec::new();
    numbers(&result["samples"], &mut all);
    all
}

/// With as many control points as data, least squares on the knots of interpolation is interpolation.
fn with_the_same_knots(job: &Value, limit: &Value) -> Value {
    let mut job = job.clone();
    let shape = if job["curve"].is_null() {
        "surface"
    } else {
        "curve"
    };
    if job[shape]["basis"]["kind"] == "bspline" && job[shape]["closed"].is_null() {
        let explicit = |direction: Option<&str>| {
            let knots = direction.map_or(&limit["knots"], |d| &limit["knots"][d]);
            json!({"kind": "bspline", "degree": 3, "knots": knots})
        };
        job[shape]["basis"] = if shape == "curve" {
            explicit(None)
        } else {
            json!({"u": explicit(Some("u")), "v": explicit(Some("v"))})
        };
    }
    job.as_object_mut()
        .unwrap()
        .retain(|_, value| !value.is_null());
    job
}

/// Which bases each method converges with, by shape and use of weights.
type Outcomes = BTreeMap<(String, String), Vec<&'static str>>;

async fn try_all(server: &Server) -> Outcomes {
    let mut outcomes = Outcomes::new();
    let mut seed = 11;
    for surface in [false, true] {
        for rational in RATIONAL {
            for basis in BASES {
                let mut job = job(basis, surface, rational, &mut seed);
                // Knots that interpolation and least squares can share.
                if basis == "B-spline" {
                    let shape = if surface { "surface" } else { "curve" };
                    job[shape]["basis"]["knots"] = json!("averaged");
                }
                job["method"] = json!({"kind": "direct"});
                let limit = server.fit(&job).await;
                let ended = limit["state"].as_str().unwrap();
                assert!(
                    ["converged", "stalled"].contains(&ended),
                    "direct, {basis}: {limit}"
                );
                let expected = geometry(server, &limit).await;
                let limit = server
                    .json(limit["links"]["result"].as_str().unwrap())
                    .await;
                for (name, method) in methods(surface) {
                    let mut job = match name {
                        "least_squares" => with_the_same_knots(&job, &limit),
                        _ => job.clone(),
                    };
                    job["method"] = method;
                    let place = (name.to_owned(), format!("{surface} {rational}"));
                    let bases = outcomes.entry(place).or_default();
                    if converges(server, &job, &expected).await && !bases.contains(&basis) {
                        bases.push(basis);
                    }
                }
            }
        }
    }
    outcomes
}

/// True if the fit ends at the limit; otherwise it must have been refused.
async fn converges(server: &Server, job: &Value, expected: &[f64]) -> bool {
    let request = server.post("/v1/jobs").header("prefer", "wait=100");
    let response = request.json(job).send().await.unwrap();
    if response.status() == 422 {
        let (_, problem) = problem(response).await;
        let pointer = problem["errors"][0]["pointer"].as_str().unwrap();
        assert_eq!(pointer, "/method", "{problem:#}");
        return false;
    }
    assert_eq!(response.status(), 201);
    let mut fitted: Value = response.json().await.unwrap();
    // A million iterations may take longer on a busy machine.
    while fitted["finished_at"].is_null() {
        tokio::time::sleep(std::time::Duration::from_millis(100)).await;
        fitted = server.json(base(&fitted)).await;
    }
    // Convexity can cost the rest of the way, as the documentation says.
    if fitted["reason"] == "convexity" {
        assert_eq!(job["method"]["kind"], "convex");
        return true;
    }
    let found = geometry(server, &fitted).await;
    assert_eq!(found.len(), expected.len(), "{job}");
    // The diagonals of the bounding boxes are longer than this.
    let size = 5.0;
    for (found, expected) in found.iter().zip(expected) {
        let deviation = (found - expected).abs() / size;
        assert!(deviation < 1e-9, "{deviation}\n{job}\n{fitted:#}");
    }
    true
}

/// The table of the documentation is what happens.
#[tokio::test]
async fn every_combination_converges_or_is_refused() {
    let server = Server::start().await;
    let outcomes = try_all(&server).await;
    let cell = |name: &str, surface: bool, rational: &str| {
        let place = (name.to_owned(), format!("{surface} {rational}"));
        match outcomes.get(&place) {
            None => "–".to_owned(),
            Some(bases) if bases.is_empty() => "–".to_owned(),
            Some(bases) if bases.len() == BASES.len() => "all".to_owned(),
            Some(bases) => bases.join(", "),
        }
    };
    let documentation = include_str!("../../docs/explanation/methods.md");
    let mut names: Vec<&str> = methods(true).iter().map(|(name, _)| *name).collect();
    names.dedup();
    let rows: Vec<String> = names
        .iter()
        .map(|name| {
            let cells: Vec<String> = [false, true]
                .into_iter()
                .flat_map(|surface| RATIONAL.map(|rational| cell(name, surface, rational)))
                .collect();
            format!("| {name} | {} |", cells.join(" | "))
        })
        .collect();
    for row in &rows {
        assert!(
            documentation.contains(row),
            "the table should be\n{}",
            rows.join("\n")
        );
    }
}

/// Wang–Ball with parameters that make classical PIA diverge, and with complex eigenvalues.
#[tokio::test]
async fn methods_that_cannot_converge_are_refused_beforehand() {
    let server = Server::start().await;
    let diverging = [0.0, 0.48, 0.77, 0.94, 0.95, 0.98, 1.0];
    let complex = [0.0, 0.12, 0.13, 0.15, 0.7, 0.75, 1.0];
    for (parameters, method, reason) in [
        (diverging, "global", "diverges"),
        (diverging, "chebyshev", "positive real eigenvalues"),
        (complex, "chebyshev", "positive real eigenvalues"),
        (complex, "weighted", "positive real eigenvalues"),
        (complex, "global", ""),
        (diverging, "extended", ""),
        (diverging, "transpose", ""),
        (diverging, "direct", ""),
    ] {
        let points: Vec<[f64; 2]> = (0..7)
            .map(f64::from)
            .map(|x| [x, (x - 3.0).powi(2)])
            .collect();
        let job = json!({
            "curve": {"points": points, "parameters": parameters, "basis": {"kind": "wang_ball"}},
            "method": {"kind": method},
            "stop": {"max_iterations": 10},
        });
        let response = server.post("/v1/jobs").json(&job).send().await.unwrap();
        if reason.is_empty() {
            assert_eq!(response.status(), 201, "{method}");
            continue;
        }
        let (status, answer) = problem(response).await;
        assert_eq!(status, 422);
        assert_eq!(answer["errors"][0]["pointer"], "/method");
        assert!(
            answer["detail"].as_str().unwrap().contains(reason),
            "{answer:#}"
        );
    }
}

/// What the server announces is what docs/reference/job.md describes and what it accepts.
#[tokio::test]
async fn capabilities_documentation_and_code_agree() {
    let documented = include_str!("../../docs/reference/job.md");
    let (settings_of_any, settings_of_least_squares) = documented
        .split_once("Settings of `least_squares`:")
        .unwrap();
    let server = Server::start().await;
    let capabilities = server.json("/v1/capabilities").await;
    let methods = capabilities["methods"].as_array().unwrap();
    let kinds: Vec<&str> = methods
        .iter()
        .map(|method| method["kind"].as_str().unwrap())
        .collect();
    for method in methods {
        let kind = method["kind"].as_str().unwrap();
        let settings: Vec<&str> = method["settings"]
            .as_array()
            .unwrap()
            .iter()
            .map(|setting| setting.as_str().unwrap())
            .collect();
        let has_row = |text: &str, start: &str| text.lines().any(|line| line.starts_with(start));
        assert!(has_row(settings_of_any, &format!("| `{kind}` |")), "{kind}");
        let page = format!("docs/explanation/methods/{kind}.md");
        let page = Path::new(env!("CARGO_MANIFEST_DIR")).join(page);
        assert!(page.is_file(), "{kind} has no page");
        for setting in &settings {
            let row = format!("| `{setting}` |");
            let is_there = match kind {
                "least_squares" => has_row(settings_of_least_squares, &row),
                _ => has_row(settings_of_any, &format!("{row} `{kind}` |")),
            };
            assert!(is_there, "{kind} {setting}");
        }
        // A setting of this method is understood, one of another is not.
        for other in [
            "omega",
            "indices",
            "sweeps",
            "threshold",
            "start",
            "transformed_error",
            "control_points",
            "variant",
            "mu",
        ] {
            let mut job =
                json!({"curve": {"points": [[0], [1], [2], [4]]}, "method": {"kind": kind}});
            job["method"][other] = json!([]);
            let response = server.post("/v1/jobs").json(&job).send().await.unwrap();
            let (status, problem) = problem(response).await;
            assert_eq!(status, 422);
            assert!(
                problem["detail"]
                    .as_str()
                    .unwrap()
                    .starts_with(&format!("/method/{other}"))
            );
        }
    }
    // The error about an unknown method lists the methods there are.
    let job = json!({"curve": {"points": [[0], [1]]}, "method": {"kind": "?"}});
    let (_, answer) = problem(server.post("/v1/jobs").json(&job).send().await.unwrap()).await;
    let known: Vec<String> = answer["detail"]
        .as_str()
        .unwrap()
        .split_once("expected one of ")
        .unwrap()
        .1
        .split(", ")
        .map(str::to_owned)
        .collect();
    assert_eq!(known, kinds);
    for basis in capabilities["bases"].as_array().unwrap() {
        let kind = basis["kind"].as_str().unwrap();
        let described = format!("\"kind\": \"{kind}\"");
        assert!(documented.contains(&described), "{kind}");
        let mut job = json!({"curve": {
            "points": [[0, 0], [1, 0], [1, 1], [0, 1]], "closed": true, "basis": {"kind": kind},
        }});
        job["method"] = json!({"kind": "direct"});
        let response = server.post("/v1/jobs").json(&job).send().await.unwrap();
        let expected = if basis["closed"] == true { 201 } else { 422 };
        assert_eq!(response.status(), expected, "{kind}");
    }
}
