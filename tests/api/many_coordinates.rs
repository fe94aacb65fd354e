//! Curves through points with more than three coordinates, such as the angles of joints.

use prost::Message;
use serde_json::{Value, json};

use crate::messages as pb;
use crate::messages::fit_result::Geometry;
use crate::numbers::flat;
use crate::support::{Server, base, problem};

/// Angles of the joints of an arm at this number of moments.
fn poses(count: usize, joints: usize) -> Vec<Vec<f64>> {
    let angle = |i: usize, joint: usize| {
        let t = 8.0 * i as f64 / count as f64;
        (t + 0.9 * joint as f64).sin() / (1.0 + joint as f64) + 0.1 * t
    };
    let pose = |i| (0..joints).map(|joint| angle(i, joint)).collect();
    (0..count).map(pose).collect()
}

/// With parameters that are given, each coordinate is fitted by itself: together they are the same numbers.
#[tokio::test]
async fn each_coordinate_is_fitted_as_by_itself() {
    let server = Server::start().await;
    let (count, joints) = (1201, 7);
    let poses = poses(count, joints);
    let times: Vec<f64> = (0..count).map(|i| i as f64).collect();
    let stop = json!({"max_iterations": 6, "tolerance": 0});
    let fewer = json!({"kind": "least_squares", "control_points": 90, "variant": "direct"});
    for method in [json!("global"), json!("weighted"), json!("direct"), fewer] {
        let fit = async |points: &[Vec<f64>]| {
            let curve = json!({"points": points, "parameters": times});
            let job = json!({"curve": curve, "method": method, "stop": stop});
            let job = server.fit(&job).await;
            server.json(&format!("{}/result", base(&job))).await
        };
        let all = fit(&poses).await;
        let all = flat(&all["control_points"]);
        for joint in [0, 3, 6] {
            let angles: Vec<Vec<f64>> = poses.iter().map(|pose| vec![pose[joint]]).collect();
            let alone = fit(&angles).await;
            let alone = flat(&alone["control_points"]);
            let found: Vec<f64> = all.iter().skip(joint).step_by(joints).copied().collect();
            assert_eq!(found.len(), alone.len());
            for (found, alone) in found.iter().zip(&alone) {
                assert!(
                    (found - alone).abs() < 1e-13,
                    "{method} {joint}: {found} {alone}"
                );
            }
        }
    }
}

/// In all views, encodings and formats that hold numbers; an edit moves a point of them.
#[tokio::test]
async fn what_holds_numbers_has_all_coordinates() {
    let server = Server::start().await;
    for joints in [4, 7, 16] {
        let points = poses(1100, joints);
        let auto = json!({"kind": "least_squares", "control_points": "auto"});
        for method in [json!("direct"), auto] {
            let job =
                json!({"curve": {"points": points}, "method": method, "stop": {"tolerance": 1e-4}});
            let job = server.fit(&job).await;
            assert_eq!(job["state"], "converged", "{job:#}");
            let path = base(&job);
            let result = server.json(&format!("{path}/result")).await;
            assert_eq!(
                result["control_points"][0].as_array().unwrap().len(),
                joints
            );
            for encoding in ["base64", "base64_f32"] {
                let binary = server
                    .json(&format!("{path}/result?encoding={encoding}"))
                    .await;
                crate::encodings::assert_same(&binary, &result, "control_points");
            }
            let request = server.get(&format!("{path}/result"));
            let request = request.header("accept", "application/x-protobuf");
            let bytes = request.send().await.unwrap().bytes().await.unwrap();
            let message = pb::FitResult::decode(bytes).unwrap();
            let Some(Geometry::ControlNet(net)) = message.geometry else {
                panic!("it has control points");
            };
            assert!(net.points == flat(&result["control_points"]), "{joints}");
            let samples = server
                .json(&format!("{path}/result?view=samples&samples=11"))
                .await;
            let samples = samples["samples"].as_array().unwrap().clone();
            let answer = server.get(&format!("{path}/result/csv?samples=11"));
            let table = answer.send().await.unwrap().text().await.unwrap();
            let mut lines = table.lines();
            let names: Vec<String> = (1..=joints).map(|k| format!("x{k}")).collect();
            assert_eq!(lines.next(), Some(&*format!("t,{}", names.join(","))));
            for (line, sample) in lines.zip(&samples) {
                let numbers: Vec<f64> = line.split(',').map(|x| x.parse().unwrap()).collect();
                assert_eq!(numbers[1..], flat(sample));
            }
            let moved = json!({"points": [{"index": 3, "point": vec![0.25; joints]}]});
            let edit = server
                .post(&format!("{path}/edits"))
                .json(&moved)
                .send()
                .await;
            let edit: Value = edit.unwrap().json().await.unwrap();
            let input = server.json(&format!("{}/input", base(&edit))).await;
            assert_eq!(input["curve"]["points"][3], json!(vec![0.25; joints]));
        }
    }
}

#[tokio::test]
async fn what_has_no_place_for_them_is_refused_by_name() {
    let server = Server::start().await;
    let row = |i| {
        (0..4)
            .map(|j| vec![f64::from(i * j); 4])
            .collect::<Vec<_>>()
    };
    let rows: Vec<Vec<Vec<f64>>> = (0..4).map(row).collect();
    for (job, pointer, reason) in [
        (
            json!({"curve": {"points": poses(9, 17)}}),
            "/curve/points/0",
            "a list of 1 to 16 numbers, found 17",
        ),
        (
            json!({"surface": {"points": rows}}),
            "/surface/points/0/0",
            "a list of 1 to 3 numbers, found 4",
        ),
        (
            json!({"surface": {"scattered": poses(60, 4), "parameters": "project"}, "method": {"kind": "least_squares", "control_points": 4}}),
            "/surface/scattered",
            "points of a surface have 1 to 3 coordinates, not 4",
        ),
    ] {
        server.assert_refused(&job, pointer, reason).await;
    }
    let job = server
        .fit(&json!({"curve": {"points": poses(9, 4)}, "method": "direct"}))
        .await;
    for format in ["step", "igs", "dxf", "obj", "glb", "svg"] {
        let answer = server.get(&format!("{}/result/{format}", base(&job)));
        let (status, problem) = problem(answer.send().await.unwrap()).await;
        assert_eq!(status, 409, "{format}");
        let reported = problem.to_string();
        assert!(
            reported.contains("these points have 4 coordinates"),
            "{reported}"
        );
    }
}
