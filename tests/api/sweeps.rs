//! Local fits of surfaces line by line: sweeps by rows and by columns.

use serde_json::{Value, json};

use crate::data;
use crate::messages as pb;
use crate::rpc::connect;
use crate::support::{Server, Story, base};

fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("{value} is no number"))
}

/// 9 × 7 points of `peaks`, or 7 × 9 with rows and columns exchanged.
fn points(exchanged: bool) -> Value {
    let peaks = data::peaks(9);
    let (rows, columns) = if exchanged { (7, 9) } else { (9, 7) };
    let point = |i: usize, j: usize| {
        let (i, j) = if exchanged { (j, i) } else { (i, j) };
        peaks[i][j].clone()
    };
    let row = |i| (0..columns).map(|j| point(i, j)).collect::<Value>();
    (0..rows).map(row).collect()
}

fn job(exchanged: bool, sweeps: &Value, pairs: Option<&[[usize; 2]]>) -> Value {
    let mut method = json!({"kind": "local"});
    for (name, value) in sweeps.as_object().unwrap() {
        method[name] = value.clone();
    }
    if let Some(pairs) = pairs {
        let exchange = |&[i, j]: &[usize; 2]| if exchanged { [j, i] } else { [i, j] };
        method["indices"] = json!(pairs.iter().map(exchange).collect::<Vec<_>>());
    }
    json!({
        "surface": {"points": points(exchanged)},
        "method": method,
        "stop": {"tolerance": 1e-6, "max_iterations": 100_000},
    })
}

/// The errors and the numbers of moved points of all levels.
fn levels(story: &Story) -> Vec<(f64, u64)> {
    assert_eq!(story.state(), "converged");
    let level = |it: &Value| (number(&it["error"]["max"]), it["moved"].as_u64().unwrap());
    story.iterations.iter().map(level).collect()
}

/// By columns is by rows of the surface whose rows and columns are exchanged, level by level.
#[tokio::test]
async fn columns_are_rows_of_the_exchanged_surface() {
    let server = Server::start().await;
    let pairs: &[[usize; 2]] = &[[2, 3], [5, 3], [2, 4], [7, 1], [4, 4]];
    let (rows, columns) = (json!({"sweeps": "rows"}), json!({"sweeps": "columns"}));
    for pairs in [None, Some(pairs)] {
        let by_rows = server.stream(&job(true, &rows, pairs)).await;
        let by_columns = server.stream(&job(false, &columns, pairs)).await;
        let (by_rows, by_columns) = (levels(&by_rows), levels(&by_columns));
        assert_eq!(by_rows.len(), by_columns.len());
        for (a, b) in by_rows.iter().zip(&by_columns) {
            assert!((a.0 - b.0).abs() < 1e-12 && a.1 == b.1, "{a:?} {b:?}");
        }
        // Never more than one column moves.
        let most = by_columns.iter().map(|(_, moved)| *moved).max();
        assert_eq!(most, Some(if pairs.is_some() { 2 } else { 9 }));
    }
}

/// Only points of one column move from a level to the next, and nothing else by a bit.
#[tokio::test]
async fn one_column_moves_at_a_time() {
    let server = Server::start().await;
    let mut job = job(false, &json!({"sweeps": "columns"}), None);
    job["stop"]["max_iterations"] = json!(40);
    let story = server.stream(&job).await;
    let net = |k: usize| story.iterations[k]["control_points"].as_array().unwrap();
    for k in 1..story.iterations.len() {
        let mut columns = Vec::new();
        // An end copy in front and one behind, in both directions.
        for i in 1..10 {
            let changed = (1..8).filter(|&j| net(k)[i][j] != net(k - 1)[i][j]);
            columns.extend(changed);
        }
        columns.sort_unstable();
        columns.dedup();
        assert!(columns.len() <= 1, "{k}: {columns:?}");
    }
}

/// The request is returned unchanged, also as a message.
#[tokio::test]
async fn sweeps_are_kept() {
    let server = Server::start().await;
    for sweeps in ["rows", "columns"] {
        let fitted = server
            .fit(&job(false, &json!({"sweeps": sweeps}), None))
            .await;
        let input = server.json(&format!("{}/input", base(&fitted))).await;
        let again = server.fit(&input).await;
        for part in ["method", "error", "iteration"] {
            assert_eq!(again[part], fitted[part], "{part}");
        }
        let mut client = connect(&server).await;
        let id = fitted["id"].as_str().unwrap().to_owned();
        let input = client.get_input(pb::GetInputRequest { id }).await;
        let input = input.unwrap().into_inner().input.unwrap();
        let request = pb::CreateJobRequest {
            input: Some(input.clone()),
            ..Default::default()
        };
        client.create_job(request).await.unwrap();
        let Some(pb::method::Kind::Local(local)) = input.method.unwrap().kind else {
            panic!("another method");
        };
        let expected = match sweeps {
            "rows" => pb::method::Sweeps::Rows,
            _ => pb::method::Sweeps::Columns,
        };
        assert_eq!(local.sweeps(), expected);
        let edit = json!({"points": [{"index": [3, 3], "point": [0, 0, 0]}]});
        let edits = server.post(&format!("{}/edits", base(&fitted)));
        let edited = edits.header("prefer", "wait=30").json(&edit).send().await;
        let edited: Value = edited.unwrap().json().await.unwrap();
        assert_eq!(edited["state"], "converged");
        assert_eq!(edited["method"]["sweeps"], sweeps);
    }
}

#[tokio::test]
async fn wrong_sweeps_are_refused() {
    let server = Server::start().await;
    for (sweeps, reason) in [
        (json!({"sweeps": "diagonals"}), "unknown kind of sweeps"),
        (json!({"sweeps": true}), "rows"),
    ] {
        let job = job(false, &sweeps, Some(&[[1, 1]]));
        server.assert_refused(&job, "/method/sweeps", reason).await;
    }
    for sweeps in ["columns", "rows"] {
        let mut job = json!({"curve": {"points": data::helix()}, "method": {"kind": "local"}});
        job["method"]["sweeps"] = json!(sweeps);
        server
            .assert_refused(&job, "/method/sweeps", "a curve has no rows")
            .await;
    }
    let global = json!({"surface": {"points": data::peaks(9)}, "method": {"kind": "global", "sweeps": "rows"}});
    server
        .assert_refused(&global, "/method/sweeps", "unknown field")
        .await;
    // In messages.
    let mut client = connect(&server).await;
    for sweeps in [17, -1] {
        let local = pb::method::Local {
            sweeps,
            ..Default::default()
        };
        let surface = pb::Surface {
            dimension: 1,
            rows: 2,
            columns: 2,
            points: vec![0.0, 1.0, 3.0, 1.0],
            ..pb::Surface::default()
        };
        let input = pb::JobInput {
            geometry: Some(pb::job_input::Geometry::Surface(surface)),
            method: Some(pb::Method {
                kind: Some(pb::method::Kind::Local(local)),
            }),
            ..pb::JobInput::default()
        };
        let request = pb::CreateJobRequest {
            input: Some(input),
            ..Default::default()
        };
        let refused = client.create_job(request).await.unwrap_err();
        assert!(
            refused.message().contains("input.method.local.sweeps"),
            "{refused:?}"
        );
    }
}
