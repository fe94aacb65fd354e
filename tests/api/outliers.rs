//! Points that are wrong, which robust fits leave out.

use serde_json::{Value, json};

use crate::messages as pb;
use crate::rpc::connect;
use crate::support::{Server, Story, base, problem};

const MOVED: [usize; 3] = [17, 60, 101];

/// Points of a curve about 100 wide, of which three are moved by 12.
fn points() -> Vec<[f64; 2]> {
    let at = |i: usize| {
        let s = i as f64 / 119.0;
        let up = if MOVED.contains(&i) { 12.0 } else { 0.0 };
        [100.0 * s, 20.0 * (7.0 * s).sin() + up]
    };
    (0..120).map(at).collect()
}

fn job(count: &Value, robust: bool) -> Value {
    json!({
        "curve": {"points": points()},
        "method": {"kind": "least_squares", "control_points": count, "robust": robust},
        "stop": {"tolerance": 0.05},
    })
}

/// The fit is that of the other points; the outliers stand in the first event, in the result, in messages and in pictures.
#[tokio::test]
async fn outliers_are_left_out_and_listed() {
    let server = Server::start().await;
    for count in [json!(24), json!("auto")] {
        let story = server.stream(&job(&count, true)).await;
        assert_eq!(story.state(), "converged", "{}", story.end);
        let listed = json!({"count": 3, "indices": MOVED});
        assert_eq!(story.job["outliers"], listed);
        assert_eq!(story.job["points"], 120);
        assert_eq!(story.job["warnings"], json!([]));
        let path = base(&story.job);
        let result = server.json(&format!("{path}/result")).await;
        assert_eq!(result["outliers"], listed);
        assert_eq!(result["parameters"].as_array().unwrap().len(), 120);
        let samples = format!("{path}/result?view=samples&samples=300");
        let samples = server.json(&samples).await["samples"].take();
        for point in samples.as_array().unwrap() {
            let [x, y] = [0, 1].map(|c| point[c].as_f64().unwrap());
            assert!((y - 20.0 * (0.07 * x).sin()).abs() < 0.1, "{x} {y}");
        }
        let deviation = server.json(&format!("{path}/deviation?list=true")).await;
        assert!(deviation["max"].as_f64().unwrap() < 0.06, "{deviation}");
        let distances = deviation["distances"].as_array().unwrap();
        for (index, distance) in distances.iter().enumerate() {
            assert_eq!(distance.is_null(), MOVED.contains(&index));
        }
        let picture = server.get(&format!("{path}/result/svg"));
        let picture = picture.send().await.unwrap().text().await.unwrap();
        // Two of them and the legend; the third is beyond the drawing.
        assert_eq!(picture.matches("class=\"outlier\"").count(), 2 + 1);
        let mut client = connect(&server).await;
        let request = pb::GetResultRequest {
            id: story.job["id"].as_str().unwrap().to_owned(),
            ..Default::default()
        };
        let answer = client.get_result(request).await.unwrap().into_inner();
        let outliers = answer.result.unwrap().outliers.unwrap();
        let indices = MOVED.map(|it| it as u32).to_vec();
        assert_eq!((outliers.count, outliers.indices), (3, indices));
        // What a client asks for again is the same job.
        let input = server.json(&format!("{path}/input")).await;
        assert_eq!(input["method"]["robust"], true);
        let again = server.fit(&input).await;
        let again = server.json(&format!("{}/result", base(&again))).await;
        assert_eq!(again["control_points"], result["control_points"]);
    }
}

/// Edits leave out the same points, wherever they are moved; without `robust` there is a warning.
#[tokio::test]
async fn edits_leave_out_the_same_points() {
    let server = Server::start().await;
    for count in [json!(24), json!("auto")] {
        let parent = server.fit(&job(&count, true)).await;
        let edit =
            json!({"points": [{"index": 60, "point": [50, 90]}, {"index": 61, "point": [52, -9]}]});
        let path = format!("{}/edits/stream", base(&parent));
        let edited = Story::read(server.post(&path).json(&edit).send().await.unwrap()).await;
        let left_out = json!({"count": 3, "indices": MOVED});
        assert_eq!(edited.job["outliers"], left_out);
        let largest = edited.end["error"]["max"].as_f64().unwrap();
        assert!(largest < 10.0, "{}", edited.end);
    }
    let plain = server.fit(&job(&json!(24), false)).await;
    assert_eq!(plain["warnings"][0]["code"], "spikes", "{plain}");
    assert_eq!(plain["warnings"][0]["pointer"], "/curve/points/17");
}

/// Of a scan, and where the data choose the fairness.
#[tokio::test]
async fn scans_and_smoothed_curves_have_outliers() {
    let server = Server::start().await;
    let at = |i: usize| {
        let [x, y] = [0.754_877_67, 0.569_840_29].map(|step| (i as f64 * step).fract());
        let up = if i % 50 == 7 { 1.5 } else { 0.0 };
        [x, y, 0.2 * (4.0 * x).sin() * (3.0 * y).cos() + up]
    };
    let scan: Vec<[f64; 3]> = (0..1000).map(at).collect();
    let fitted = json!({
        "surface": {"scattered": scan, "parameters": {"project": "xy"}},
        "method": {"kind": "least_squares", "control_points": "auto", "robust": true},
        "stop": {"tolerance": 0.01},
    });
    let fitted = server.fit(&fitted).await;
    assert_eq!(fitted["state"], "converged", "{fitted}");
    let result = server.json(&format!("{}/result", base(&fitted))).await;
    let expected: Vec<usize> = (0..1000).filter(|i| i % 50 == 7).collect();
    assert_eq!(result["outliers"]["indices"], json!(expected));
    assert!(result["control_points"].as_array().unwrap().len() < 12);
    let smoothed = json!({
        "curve": {"points": points()},
        "method": {"kind": "least_squares", "control_points": "auto", "fairness": "auto", "robust": true},
    });
    let smoothed = server.fit(&smoothed).await;
    assert_eq!(smoothed["state"], "converged", "{smoothed}");
    assert!(
        smoothed["error"]["max"].as_f64().unwrap() < 0.1,
        "{smoothed}"
    );
}

/// Outliers far away from a scan turn neither its plane nor what is found among its points, also where they are many.
#[tokio::test]
async fn far_outliers_of_scans_do_not_choose_the_parameters() {
    let server = Server::start().await;
    for every in [20, 10] {
        let is_outlier = |i: &usize| i % every == 7;
        let at = |i: usize| {
            let [x, y, side] = [0.754_877_666, 0.569_840_29, 0.437_016]
                .map(|step| (0.5 + i as f64 * step).fract());
            let noise = 0.01 * (side - 0.5);
            let up = match is_outlier(&i) {
                true => {
                    (1.0 + 2.0 * side)
                        * if (i / every).is_multiple_of(2) {
                            1.0
                        } else {
                            -1.0
                        }
                }
                false => noise,
            };
            [x, y, 0.3 * (5.0 * x).sin() * (4.0 * y).cos() + up]
        };
        let scan: Vec<[f64; 3]> = (0..3000).map(at).collect();
        for parameters in ["auto", "project"] {
            let fitted = server
                .fit(&json!({
                    "surface": {"scattered": scan, "parameters": parameters},
                    "method": {"kind": "least_squares", "control_points": "auto", "robust": true},
                    "stop": {"tolerance": 0.03},
                }))
                .await;
            assert_eq!(
                fitted["state"], "converged",
                "{every} {parameters} {fitted}"
            );
            let result = server.json(&format!("{}/result", base(&fitted))).await;
            let found = result["outliers"]["indices"].as_array().unwrap();
            let expected: Vec<usize> = (0..3000).filter(is_outlier).collect();
            let missed = expected.iter().filter(|it| !found.contains(&json!(it)));
            assert_eq!(missed.count(), 0, "{every} {parameters}");
            assert!(found.len() < expected.len() + 30, "{}", found.len());
        }
    }
}

#[tokio::test]
async fn fits_that_cannot_be_robust_are_rejected_by_name() {
    let server = Server::start().await;
    let robust = json!({"kind": "least_squares", "control_points": 5, "robust": true});
    let auto = json!({"kind": "least_squares", "control_points": "auto", "robust": true});
    let text = json!({"kind": "least_squares", "control_points": 5, "robust": "yes"});
    let (few, all, ones) = (&points()[..7], points(), vec![1.0; 120]);
    let grid = vec![vec![[0.0, 0.0, 1.0]; 9]; 9];
    for (job, reason) in [
        (
            json!({"curve": {"points": few}, "method": robust}),
            "8 at least",
        ),
        (
            json!({"curve": {"points": all, "weights": ones}, "method": robust}),
            "weights",
        ),
        (
            json!({"curve": {"points": all, "polyline": true}, "method": auto}),
            "polyline",
        ),
        (
            json!({"surface": {"points": grid}, "method": robust}),
            "scattered",
        ),
        (json!({"curve": {"points": all}, "method": text}), "true"),
    ] {
        let answer = server.post("/v1/jobs").json(&job).send().await.unwrap();
        let (status, problem) = problem(answer).await;
        assert_eq!(status, 422, "{job}");
        let error = &problem["errors"][0];
        assert_eq!(error["pointer"], "/method/robust", "{problem:#}");
        assert!(
            error["detail"].as_str().unwrap().contains(reason),
            "{error}"
        );
    }
}
