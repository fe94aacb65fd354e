//! What the server really answers is what its description says.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use crate::data;
use crate::description::Description;
use crate::support::{Server, base, problem};

/// Jobs that differ in all that makes a difference to answers.
fn jobs() -> Vec<Value> {
    let points = json!([[0, 0], [1, 2], [3, 1], [4, 4], [5, 0], [6, 2]]);
    let grid = data::peaks(5);
    vec![
        json!({"name": "plain", "curve": {"points": points}}),
        json!({"curve": {"points": points, "closed": true, "parameters": "centripetal"}, "method": {"kind": "weighted"}}),
        json!({"curve": {"points": points, "basis": {"kind": "said_ball"}}, "method": {"kind": "extended"}}),
        json!({"curve": {"points": points, "basis": {"kind": "bernstein"}}, "stop": {"max_iterations": 3}}),
        json!({"curve": {"points": points}, "method": {"kind": "local", "indices": [1, 2]}}),
        json!({"curve": {"points": points}, "method": {"kind": "adaptive", "threshold": 0.01}}),
        json!({"curve": {"points": points, "weights": [1, 2, 3, 1, 1, 1]}, "stream": {"every": 2}}),
        json!({"curve": {"points": points, "weights": [1, 2, 3, 1, 1, 1]}, "rational": "fixed"}),
        json!({"curve": {"points": points}, "method": {"kind": "least_squares", "control_points": 4}}),
        json!({"surface": {"points": grid, "basis": {"u": {"kind": "bernstein"}, "v": {"kind": "bspline", "degree": 2}}}}),
        json!({"surface": {"points": grid}, "method": {"kind": "local", "indices": [[1, 1], [2, 3]], "row_by_row": true}}),
        json!({"surface": {"points": grid, "weights": {"u": [1, 2, 1, 1, 1], "v": [1, 1, 2, 1, 1]}}, "rational": "fixed"}),
        json!({"surface": {"points": grid}, "method": {"kind": "least_squares", "control_points": {"u": 4, "v": 5}, "variant": "lspia", "mu": 0.1}, "stop": {"max_iterations": 5}}),
        overflowing(),
    ]
}

/// Control points grow until they leave the range of numbers.
fn overflowing() -> Value {
    let side = |i| if i % 2 == 0 { 2e306 } else { -2e306 };
    let points: Vec<[f64; 1]> = (0..20).map(|i| [side(i)]).collect();
    json!({
        "curve": {"points": points, "basis": {"kind": "bernstein"}, "parameters": "uniform"},
        "stop": {"tolerance": 1, "max_iterations": 100_000},
    })
}

const STREAMS: [&str; 7] = [
    "",
    "?view=samples",
    "?view=errors",
    "?every=1&changed=true",
    "?encoding=base64&every=1",
    "?view=samples&encoding=base64_f32",
    "?every=1&milestones=1,0.1,0.01",
];

const LEVELS: [&str; 5] = [
    "",
    "?view=samples",
    "?view=errors",
    "?encoding=base64",
    "?view=samples&encoding=base64",
];

#[tokio::test]
async fn jobs_and_their_geometry() {
    let server = Server::start().await;
    let description = Description::of(&server).await;
    let iteration = description.validator("Iteration");
    for body in jobs() {
        description.check("JobRequest", &body);
        let job = server.fit(&body).await;
        description.check("Job", &job);
        let path = base(&job);
        description.check("Job", &server.json(path).await);
        description.check("JobRequest", &server.json(&format!("{path}/input")).await);
        if job["state"] == "failed" {
            continue;
        }
        for query in LEVELS {
            let level = server.json(&format!("{path}/iterations/last{query}")).await;
            assert!(iteration.is_valid(&level), "{query} {level}");
            let result = server.json(&format!("{path}/result{query}")).await;
            description.check("ResultAnswer", &result);
            if !query.contains("view") {
                description.check("FitResult", &result);
            }
        }
        if job["method"]["kind"] == "local" {
            description.check("Limit", &server.json(&format!("{path}/limit")).await);
        }
    }
    description.check("JobPage", &server.json("/v1/jobs?limit=3").await);
}

/// Also as lines, which name their events.
#[tokio::test]
async fn events() {
    let server = Server::start().await;
    let description = Description::of(&server).await;
    let line = description.validator("EventLine");
    let mut seen = 0;
    for body in jobs() {
        let job = server.fit(&body).await;
        for query in STREAMS {
            let path = format!("{}/events{query}", base(&job));
            let request = server.get(&path).header("accept", "application/x-ndjson");
            let response = request.send().await.unwrap();
            if response.status() == 400 {
                description.check("Problem", &problem(response).await.1);
                continue;
            }
            assert_eq!(response.status(), 200, "{path}");
            let text = response.text().await.unwrap();
            for event in text.lines() {
                let event: Value = serde_json::from_str(event).unwrap();
                if let Err(error) = line.validate(&event) {
                    panic!("{query}: {error}: {event:#}");
                }
                seen += 1;
            }
        }
    }
    assert!(seen > 200, "{seen}");
}

#[tokio::test]
async fn server_sent_events() {
    let server = Server::start().await;
    let description = Description::of(&server).await;
    let mut schemas = BTreeMap::new();
    let event = description.component("schemas", "ServerSentEvent");
    for event in event["oneOf"].as_array().unwrap() {
        let fields = &event["properties"];
        let schema = fields["data"]["contentSchema"]["$ref"].as_str().unwrap();
        let name = fields["event"]["const"].as_str().unwrap();
        schemas.insert(name, schema.rsplit('/').next().unwrap());
    }
    let story = server.stream(&jobs()[0]).await;
    description.check(schemas["job"], &story.job);
    for data in &story.iterations {
        description.check(schemas["iteration"], data);
    }
    description.check(schemas["end"], &story.end);
}

#[tokio::test]
async fn edits() {
    let server = Server::start().await;
    let description = Description::of(&server).await;
    let parent = server.fit(&jobs()[0]).await;
    let edit = json!({"points": [{"index": 2, "point": [3, 2]}], "iteration": 1});
    description.check("EditRequest", &edit);
    let request = server.post(&format!("{}/edits", base(&parent)));
    let response = request
        .header("prefer", "wait=100")
        .json(&edit)
        .send()
        .await;
    let job: Value = response.unwrap().json().await.unwrap();
    assert_eq!(job["parent"]["iteration"], 1);
    description.check("Job", &job);
}

#[tokio::test]
async fn problems_and_the_server_itself() {
    let server = Server::start().await;
    let description = Description::of(&server).await;
    for (path, schema) in [
        ("/", "Index"),
        ("/livez", "Health"),
        ("/readyz", "Health"),
        ("/problems", "ProblemTypes"),
        ("/problems/invalid-fit", "ProblemType"),
        ("/v1/capabilities", "Capabilities"),
    ] {
        description.check(schema, &server.json(path).await);
    }
    for path in [
        "/nothing",
        "/v1/jobs/1",
        "/v1/jobs?limit=0",
        "/problems/none",
    ] {
        let (_, problem) = problem(server.get(path).send().await.unwrap()).await;
        description.check("Problem", &problem);
    }
    let response = server.post("/v1/jobs").json(&json!({"curve": 1})).send();
    let (_, problem) = problem(response.await.unwrap()).await;
    description.check("Problem", &problem);
}
