//! The transformed error of the extended method, `max_i ‖(U Δ)_i‖` (Deng et al. 2013).

use serde_json::{Value, json};

use crate::data;
use crate::messages as pb;
use crate::rpc::{assert_same_iteration, connect};
use crate::support::{Server, base};

fn extended(reported: bool) -> Value {
    json!({"kind": "extended", "transformed_error": reported})
}

fn jobs(reported: bool) -> [Value; 4] {
    let method = extended(reported);
    let weights: Vec<f64> = (0..30).map(|i| 1.0 + 0.5 * f64::from(i % 3)).collect();
    let from_data = json!({"kind": "extended", "start": "data", "transformed_error": reported});
    [
        json!({"curve": {"points": data::helix()}, "method": method}),
        json!({"curve": {"points": data::lemniscate(), "basis": "bernstein"}, "method": from_data}),
        json!({"surface": {"points": data::peaks(9), "degree": 2}, "method": method}),
        json!({"curve": {"points": data::helix(), "weights": weights}, "method": method}),
    ]
}

/// All control points in a row, homogeneous ones multiplied with their weights.
fn net(iteration: &Value) -> Vec<Vec<f64>> {
    let mut points = Vec::new();
    collect(&iteration["control_points"], &mut points);
    if let Some(weights) = iteration["weights"].as_array() {
        for (point, weight) in points.iter_mut().zip(weights) {
            let weight = weight.as_f64().unwrap();
            point.iter_mut().for_each(|x| *x *= weight);
            point.push(weight);
        }
    }
    points
}

fn collect(value: &Value, points: &mut Vec<Vec<f64>>) {
    let list = value.as_array().unwrap();
    if list[0].is_number() {
        points.push(list.iter().map(|x| x.as_f64().unwrap()).collect());
    } else {
        list.iter().for_each(|value| collect(value, points));
    }
}

/// It is how far a control point moves in the next iteration, and changes nothing.
#[tokio::test]
async fn it_is_the_length_of_the_next_step() {
    let server = Server::start().await;
    for (with, without) in jobs(true).into_iter().zip(jobs(false)) {
        let (with, without) = (server.stream(&with).await, server.stream(&without).await);
        assert_eq!(with.job["method"]["transformed_error"], true);
        assert!(with.iterations.len() > 5);
        for pair in with.iterations.windows(2) {
            let moved = net(&pair[0]).into_iter().zip(net(&pair[1])).map(|(a, b)| {
                let squares = a.iter().zip(&b).map(|(a, b)| (a - b).powi(2));
                squares.sum::<f64>().sqrt()
            });
            let farthest = moved.fold(0.0, f64::max);
            let reported = pair[0]["error"]["transformed"].as_f64().unwrap();
            let magnitude = net(&pair[1])
                .concat()
                .into_iter()
                .fold(0.0, |a, b| b.abs().max(a));
            assert!(
                (reported - farthest).abs() <= 1e-13 * magnitude,
                "{reported} {farthest}"
            );
        }
        assert!(without.iterations[0]["error"].get("transformed").is_none());
        assert_eq!(with.iterations.len(), without.iterations.len());
        for (with, without) in with.iterations.iter().zip(&without.iterations) {
            assert_eq!(with["control_points"], without["control_points"]);
            for part in ["max", "rms", "sum", "at"] {
                assert_eq!(with["error"][part], without["error"][part]);
            }
        }
    }
}

/// Single iterations, jobs, messages and the request of the job.
#[tokio::test]
async fn it_is_reported_with_all_errors() {
    let server = Server::start().await;
    let [curve, ..] = jobs(true);
    let job = server.fit(&curve).await;
    assert!(job["error"]["transformed"].is_number());
    let input = server.json(&format!("{}/input", base(&job))).await;
    assert_eq!(input["method"]["transformed_error"], true);
    let json = server.json(&format!("{}/iterations/3", base(&job))).await;
    let mut client = connect(&server).await;
    let id = job["id"].as_str().unwrap().to_owned();
    let request = pb::GetIterationRequest {
        id: id.clone(),
        iteration: Some(3),
        ..Default::default()
    };
    let message = client.get_iteration(request).await.unwrap().into_inner();
    let message = message.iteration.unwrap();
    assert!(message.error.unwrap().transformed.is_some());
    assert_same_iteration(&message, &json, 0);
    let input = client.get_input(pb::GetInputRequest { id }).await.unwrap();
    let method = input.into_inner().input.unwrap().method.unwrap();
    let Some(pb::method::Kind::Extended(extended)) = method.kind else {
        panic!("another method");
    };
    assert!(extended.transformed_error);
    // An edit can ask for it.
    let [curve, ..] = jobs(false);
    let job = server.fit(&curve).await;
    let edit = json!({"method": {"kind": "extended", "transformed_error": true}, "iteration": 2});
    let edits = server.post(&format!("{}/edits", base(&job)));
    let edited = edits.header("prefer", "wait=30").json(&edit).send().await;
    let edited: Value = edited.unwrap().json().await.unwrap();
    assert!(edited["error"]["transformed"].is_number(), "{edited}");
}

#[tokio::test]
async fn it_is_a_setting_of_the_extended_method() {
    let server = Server::start().await;
    let job = |method: Value| json!({"curve": {"points": data::helix()}, "method": method});
    let pointer = "/method/transformed_error";
    let other = json!({"kind": "direct", "transformed_error": true});
    server
        .assert_refused(&job(other), pointer, "unknown field")
        .await;
    let number = json!({"kind": "extended", "transformed_error": 1});
    server
        .assert_refused(&job(number), pointer, "true or false")
        .await;
}
