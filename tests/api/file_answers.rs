//! What answers say of a file that is the body: what was understood, and what is doubtful.

use prost::Message;
use serde_json::{Value, json};

use crate::files::{read, send};
use crate::messages as pb;
use crate::support::{Server, Story, base, problem};

/// What was understood of a file stands in every answer for it, and in none for other bodies.
#[tokio::test]
async fn notices_stand_in_all_answers() {
    let server = Server::start().await;
    let outline = "2,0\n3,1\n3,2\n2,3\n1,3\n0,2\n0,1\n1,0\n2,0\n";
    let notices = read(&server, outline).await["notices"].clone();
    assert_eq!(notices.as_array().unwrap().len(), 1);
    let response = send(&server, "/v1/jobs", "text/csv", outline).await;
    let job: Value = response.json().await.unwrap();
    assert_eq!(job["notices"], notices, "{job:#}");
    let shown = server.json(base(&job)).await;
    assert_eq!(shown["notices"], notices);
    let result = server.json(&format!("{}/result", base(&job))).await;
    assert_eq!(result["notices"], notices);
    let fit: Value = send(&server, "/v1/fit", "text/csv", outline)
        .await
        .json()
        .await
        .unwrap();
    assert_eq!(fit["notices"], notices, "{fit:#}");
    let request = server
        .post("/v1/jobs/stream")
        .header("content-type", "text/csv");
    let story = Story::read(request.body(outline).send().await.unwrap()).await;
    assert_eq!(story.job["notices"], notices);
    let message = server.post("/v1/fit").header("content-type", "text/csv");
    let message = message
        .header("accept", "application/x-protobuf")
        .body(outline);
    let message = message.send().await.unwrap().bytes().await.unwrap();
    let message = pb::FitResult::decode(message).unwrap();
    assert_eq!(json!(message.notices), notices);
    // An edit has no file, and neither has a job in JSON.
    let edit = json!({"points": [{"index": 0, "point": [2, 0.1]}]});
    let edit = server.post(&format!("{}/edits", base(&job))).json(&edit);
    let edit: Value = edit.send().await.unwrap().json().await.unwrap();
    assert_eq!(
        (&edit["kind"], edit.get("notices")),
        (&json!("curve"), None)
    );
    let plain = server.fit(&crate::data::small_job()).await;
    assert_eq!(plain.get("notices"), None);
}

/// Items of a batch say what fits of their own say.
#[tokio::test]
async fn items_of_batches_have_the_notices_of_fits() {
    let server = Server::start().await;
    let point = |i: u32| {
        let (x, y) = (f64::from(i * 37 % 97), f64::from(i * 53 % 89));
        json!([x, y, (0.05 * x).sin() + 0.01 * y])
    };
    let points: Vec<Value> = (0..200).map(point).collect();
    let method = json!({"kind": "least_squares", "variant": "direct", "control_points": 5});
    let scattered = json!({"surface": {"scattered": points}, "method": method});
    let response = server.post("/v1/fit").json(&scattered).send().await;
    let fit: Value = response.unwrap().json().await.unwrap();
    let notice = fit["notices"][0].as_str().unwrap();
    assert!(notice.contains("plane"), "{notice}");
    let batch = json!({"items": [scattered, crate::data::small_job()]});
    let response = server.post("/v1/batch").json(&batch).send().await;
    let text = response.unwrap().text().await.unwrap();
    let lines = text.lines().map(|line| serde_json::from_str(line).unwrap());
    let lines: Vec<Value> = lines.collect();
    assert_eq!(lines[0]["notices"], fit["notices"], "{text}");
    assert_eq!(lines[1].get("notices"), None);
}

/// Points without an order are no curve; they are scattered points of a surface, or meant as they are.
#[tokio::test]
async fn points_without_order_are_no_curve() {
    let server = Server::start().await;
    let place = |i: u32| {
        (
            f64::from(i * 37 % 151).sin() * 5.0,
            f64::from(i * 37 % 151).cos() * 3.0,
        )
    };
    let line = |i: u32| {
        let (x, y) = (place(i).0 + 0.01 * f64::from(i * 53 % 151), place(i).1);
        format!("{x} {y} {}\n", 0.1 * x * y)
    };
    let cloud: String = (0..151).map(line).collect();
    for path in [
        "/v1/points",
        "/v1/jobs",
        "/v1/fit",
        "/v1/jobs?curve.degree=3",
    ] {
        let (status, answer) = problem(send(&server, path, "text/csv", &cloud).await).await;
        assert_eq!(status, 422, "{path}");
        let detail = answer["detail"].as_str().unwrap();
        assert!(detail.contains("curve.order=given"), "{detail}");
        assert!(detail.contains("curve.order=nearest"), "{detail}");
    }
    let shown = send(&server, "/v1/points?curve.order=given", "text/csv", &cloud).await;
    let shown: Value = shown.json().await.unwrap();
    assert_eq!(shown["curve"]["points"].as_array().unwrap().len(), 151);
    for parameters in ["auto", "project"] {
        let path = format!("/v1/points?surface.parameters={parameters}");
        let shown: Value = send(&server, &path, "text/csv", &cloud)
            .await
            .json()
            .await
            .unwrap();
        assert_eq!(shown["surface"]["scattered"].as_array().unwrap().len(), 151);
    }
    let rows = "0 0 1\n0 1 2\n\n1 0 3\n1 1 5\n";
    let path = "/v1/points?surface.parameters=auto";
    let (status, answer) = problem(send(&server, path, "text/csv", rows).await).await;
    let parameter = &answer["errors"][0]["parameter"];
    assert_eq!((status, parameter), (400, &json!("surface.parameters")));
    let wrong = send(
        &server,
        "/v1/points?surface.parameters=sphere",
        "text/csv",
        &cloud,
    )
    .await;
    let (status, answer) = problem(wrong).await;
    let parameter = &answer["errors"][0]["parameter"];
    assert_eq!((status, parameter), (400, &json!("surface.parameters")));
    let query = "?surface=%7B%7D&method.kind=least_squares&method.control_points=4";
    let response = send(&server, &format!("/v1/jobs{query}"), "text/csv", &cloud).await;
    let job: Value = response.json().await.unwrap();
    assert!(
        job["notices"][0].as_str().unwrap().contains("no order"),
        "{job:#}"
    );
    let input = server.json(&format!("{}/input", base(&job))).await;
    assert_eq!(input["surface"]["parameters"], "auto");
    let (status, answer) =
        problem(send(&server, "/v1/jobs?curve.order=x", "text/csv", &cloud).await).await;
    assert_eq!(
        (status, &answer["errors"][0]["parameter"]),
        (400, &json!("curve.order"))
    );
    // A request has its points in the order that it says, and is warned.
    let mut job = json!({"curve": shown["curve"].clone(), "method": "direct"});
    let warned = server.fit(&job).await;
    assert_eq!(warned["warnings"][0]["code"], "unordered", "{warned:#}");
    assert_eq!(warned["warnings"][0]["pointer"], "/curve/points");
    job["curve"]["points"].as_array_mut().unwrap().truncate(4);
    assert_eq!(server.fit(&job).await["warnings"], json!([]));
}
