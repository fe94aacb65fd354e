//! The `stream` object of a job: how its streams go if they do not say it themselves.

use serde_json::{Value, json};

use crate::data;
use crate::support::{Server, base, levels, problem, read_thinned, thinned};

fn with_stream(mut job: Value, stream: Value) -> Value {
    job["stream"] = stream;
    job
}

/// What a query says for one stream, the object says for all.
#[tokio::test]
async fn the_object_is_the_query_of_all_streams() {
    let server = Server::start().await;
    let curve = data::small_job();
    let surface = json!({"surface": {"points": data::peaks(8)}});
    let local =
        json!({"curve": {"points": data::helix()}, "method": {"kind": "local", "indices": [3]}});
    for (job, stream, query) in [
        (&curve, json!({}), ""),
        (
            &curve,
            json!({"view": "samples", "samples": 7, "every": 5}),
            "view=samples&samples=7&every=5",
        ),
        (
            &surface,
            json!({"view": "samples", "samples": "4x3"}),
            "view=samples&samples=4x3",
        ),
        (
            &curve,
            json!({"milestones": [0.1, 1e-2, 1e-7]}),
            "milestones=1e-1,1e-2,1e-7",
        ),
        (&curve, json!({"milestones": []}), ""),
        (
            &curve,
            json!({"encoding": "base64", "on_disconnect": "continue"}),
            "encoding=base64",
        ),
        (
            &curve,
            json!({"digits": "auto", "pace": "all"}),
            "digits=auto",
        ),
        (&local, json!({"changed": true}), "changed=true"),
        (&curve, json!({"view": null, "every": null}), ""),
    ] {
        let request = server
            .post("/v1/jobs")
            .header("accept", "text/event-stream");
        let body = with_stream(job.clone(), stream.clone());
        let (posted, _) = read_thinned(request.json(&body).send().await.unwrap()).await;
        let plain = server.fit(job).await;
        let path = format!("{}/events?{query}", base(&plain));
        let (expected, _) = thinned(&server, &path, None).await;
        assert_eq!(posted, expected, "{stream}");
        // The streams of the job have the settings requested with it.
        let created = server.fit(&body).await;
        let path = format!("{}/events", base(&created));
        assert_eq!(thinned(&server, &path, None).await.0, expected, "{stream}");
    }
}

#[tokio::test]
async fn a_query_overrides_the_object() {
    let server = Server::start().await;
    let plain = server.stream(&data::small_job()).await;
    let all = &plain.iterations;
    let job = with_stream(
        data::small_job(),
        json!({"every": 5, "view": "samples", "samples": 9}),
    );
    let job = server.fit(&job).await;
    assert_eq!(
        job["stream"],
        json!({"view": "samples", "samples": 9, "every": 5})
    );
    let path = format!("{}/events", base(&job));
    let (whole, _) = thinned(
        &server,
        &format!("{path}?every=1&view=control_points"),
        None,
    )
    .await;
    assert_eq!(&whole, all);
    let (errors, _) = thinned(&server, &format!("{path}?view=errors"), None).await;
    assert!(errors[0].get("samples").is_none() && errors[1]["iteration"] == 5);
    let (samples, _) = thinned(&server, &format!("{path}?samples=4"), None).await;
    assert_eq!(samples[0]["samples"].as_array().unwrap().len(), 4);
    let milestones = format!("{path}?every=1&milestones=0.01");
    let (reached, _) = thinned(&server, &milestones, None).await;
    assert_eq!(reached.len(), 2);
    for (stream, query) in [
        (json!({"changed": true}), "changed=false"),
        (json!({"milestones": [0.1]}), "milestones="),
        (json!({"encoding": "base64"}), "encoding=json"),
        (json!({"digits": "auto"}), "digits=full"),
        (
            json!({"pace": "latest", "on_disconnect": "cancel"}),
            "pace=all&on_disconnect=continue",
        ),
    ] {
        let job = server.fit(&with_stream(data::small_job(), stream)).await;
        let path = format!("{}/events?{query}", base(&job));
        assert_eq!(&thinned(&server, &path, None).await.0, all, "{query}");
        // Single iterations and results do not care.
        let single = server.json(&format!("{}/iterations/3", base(&job))).await;
        assert_eq!(single, all[3]);
    }
    // Together with the job as well.
    let request = server
        .post("/v1/jobs?every=10")
        .header("accept", "text/event-stream");
    let body = with_stream(data::small_job(), json!({"every": 5}));
    let (posted, _) = read_thinned(request.json(&body).send().await.unwrap()).await;
    assert_eq!(levels(&posted)[1], 10);
}

/// The error names the query parameter, and how to override the conflicting setting.
#[tokio::test]
async fn a_query_that_does_not_go_with_the_object() {
    let server = Server::start().await;
    for (stream, query, parameter, hint) in [
        (
            json!({"every": 5}),
            "milestones=0.1",
            "milestones",
            "every=1 overrides",
        ),
        (
            json!({"milestones": [0.1]}),
            "every=5",
            "every",
            "milestones= overrides",
        ),
        (
            json!({"changed": true}),
            "digits=auto",
            "digits",
            "changed=false overrides",
        ),
        (
            json!({"encoding": "base64"}),
            "view=errors",
            "view",
            "encoding=json overrides",
        ),
        (
            json!({"view": "errors"}),
            "samples=5",
            "samples",
            "add view=samples",
        ),
    ] {
        let job = server.fit(&with_stream(data::small_job(), stream)).await;
        let request = server.get(&format!("{}/events?{query}", base(&job)));
        let (status, problem) = problem(request.send().await.unwrap()).await;
        assert_eq!(status, 400);
        assert_eq!(problem["errors"][0]["parameter"], parameter, "{problem:#}");
        assert!(
            problem["detail"].as_str().unwrap().contains(hint),
            "{problem:#}"
        );
    }
}

/// The object is a part of the job: its input has it, and edits keep it unless they have their own.
#[tokio::test]
async fn inputs_and_edits_have_the_object() {
    let server = Server::start().await;
    let stream = json!({"view": "samples", "samples": 9, "milestones": [0.1, 1e-3]});
    let job = server
        .fit(&with_stream(data::small_job(), stream.clone()))
        .await;
    let input = server.json(&format!("{}/input", base(&job))).await;
    assert_eq!(input["stream"], stream);
    assert_eq!(server.fit(&input).await["stream"], stream);
    let plain = server.fit(&data::small_job()).await;
    let input = server.json(&format!("{}/input", base(&plain))).await;
    assert!(input.get("stream").is_none() && plain["stream"].is_null());
    let edits = format!("{}/edits", base(&job));
    let edit = async |body: &Value| {
        let response = server.post(&edits).json(body).send().await.unwrap();
        assert_eq!(response.status(), 201);
        response.json::<Value>().await.unwrap()
    };
    let moved = json!([{"index": 3, "point": [2.5, 0.5]}]);
    let kept = edit(&json!({"points": moved})).await;
    assert_eq!(kept["stream"], stream);
    let other = json!({"encoding": "base64_f32"});
    let replaced = edit(&json!({"points": moved, "stream": other})).await;
    assert_eq!(replaced["stream"], other);
    // It must suit the edited data.
    let far = json!({"points": [{"index": 3, "point": [1e36, 0.5]}], "stream": other});
    let (status, problem) = problem(server.post(&edits).json(&far).send().await.unwrap()).await;
    assert_eq!(status, 422);
    assert_eq!(problem["errors"][0]["pointer"], "/stream/encoding");
}

/// A request that is repeated with its key may ask for another stream, within reason.
#[tokio::test]
async fn repeated_requests_are_checked_as_well() {
    let server = Server::start().await;
    let job = json!({"curve": {"points": [[0, 0], [1e36, 1e36], [2e36, 0], [3e36, 1e36]]}});
    let post = async |query: &str| {
        let request = server.post(&format!("/v1/jobs?{query}"));
        let request = request.header("accept", "text/event-stream");
        let request = request.header("idempotency-key", "k").json(&job);
        request.send().await.unwrap()
    };
    assert_eq!(post("encoding=base64").await.status(), 200);
    assert_eq!(post("milestones=1e30").await.status(), 200);
    let (status, problem) = problem(post("encoding=base64_f32").await).await;
    assert_eq!(status, 400);
    assert_eq!(problem["errors"][0]["parameter"], "encoding");
}

#[tokio::test]
async fn objects_are_read_to_the_letter() {
    let server = Server::start().await;
    for (stream, pointer, reason) in [
        (json!([]), "/stream", "an object"),
        (json!({"everyy": 1}), "/stream/everyy", "unknown field"),
        (
            json!({"last_event_id": "3"}),
            "/stream/last_event_id",
            "unknown field",
        ),
        (json!({"every": 0}), "/stream/every", "positive"),
        (json!({"every": "5"}), "/stream/every", "whole number"),
        (json!({"every": 1.5}), "/stream/every", "whole number"),
        (json!({"view": "all"}), "/stream/view", "unknown choice"),
        (
            json!({"view": {"errors": null}}),
            "/stream/view",
            "the name of",
        ),
        (
            json!({"samples": 9}),
            "/stream/samples",
            "view is not samples",
        ),
        (
            json!({"view": "samples", "samples": "9x9"}),
            "/stream/samples",
            "200 for a curve",
        ),
        (
            json!({"view": "samples", "samples": "9"}),
            "/stream/samples",
            "whole number for a curve",
        ),
        (
            json!({"view": "samples", "samples": 1}),
            "/stream/samples",
            "at least 2",
        ),
        (
            json!({"view": "samples", "samples": 9_999_999}),
            "/stream/samples",
            "1000000 in all",
        ),
        (json!({"milestones": 0.1}), "/stream/milestones", "list"),
        (
            json!({"milestones": [0.1, "x"]}),
            "/stream/milestones/1",
            "number",
        ),
        (
            json!({"milestones": [0.1, 0.2]}),
            "/stream/milestones/1",
            "decrease",
        ),
        (
            json!({"milestones": [0.0]}),
            "/stream/milestones/0",
            "positive",
        ),
        (
            json!({"milestones": vec![1; 101]}),
            "/stream/milestones/100",
            "at most 100",
        ),
        (json!({"pace": "fast"}), "/stream/pace", "all, latest"),
        (
            json!({"changed": "true"}),
            "/stream/changed",
            "true or false",
        ),
        (json!({"encoding": "hex"}), "/stream/encoding", "base64_f32"),
        (json!({"digits": 3}), "/stream/digits", "the name of"),
        (
            json!({"on_disconnect": "stop"}),
            "/stream/on_disconnect",
            "continue, cancel",
        ),
        (
            json!({"milestones": [0.1], "every": 2}),
            "/stream/milestones",
            "do not go together",
        ),
        (
            json!({"changed": true, "every": 2}),
            "/stream/changed",
            "do not go together",
        ),
        (
            json!({"changed": true, "encoding": "base64"}),
            "/stream/changed",
            "do not go together",
        ),
        (
            json!({"digits": "auto", "encoding": "base64"}),
            "/stream/digits",
            "do not go together",
        ),
        (
            json!({"view": "errors", "encoding": "base64"}),
            "/stream/encoding",
            "do not go together",
        ),
    ] {
        let job = with_stream(data::small_job(), stream);
        server.assert_refused(&job, pointer, reason).await;
        // A query that would repair it does not: the object is for all streams.
        let request = server.post("/v1/jobs?every=1&changed=false&view=control_points");
        let request = request.header("accept", "text/event-stream").json(&job);
        assert_eq!(problem(request.send().await.unwrap()).await.0, 422);
    }
    let jobs = server.json("/v1/jobs").await;
    assert!(jobs["jobs"].as_array().unwrap().is_empty());
}

#[tokio::test]
async fn capabilities_name_what_streams_can_do() {
    let server = Server::start().await;
    let capabilities = server.json("/v1/capabilities").await;
    let job = server.fit(&data::small_job()).await;
    for (parameter, list) in [
        ("view", "views"),
        ("encoding", "encodings"),
        ("digits", "digits"),
        ("pace", "paces"),
    ] {
        for value in capabilities[list].as_array().unwrap() {
            let value = value.as_str().unwrap();
            let path = format!("{}/events?{parameter}={value}", base(&job));
            assert_eq!(
                server.get(&path).send().await.unwrap().status(),
                200,
                "{path}"
            );
        }
    }
    let documented = include_str!("../../docs/reference/events.md");
    for parameter in capabilities["stream"].as_array().unwrap() {
        let name = format!("`{}`", parameter.as_str().unwrap());
        assert!(
            documented.contains(&name),
            "{name} is not in docs/reference/events.md"
        );
    }
}
