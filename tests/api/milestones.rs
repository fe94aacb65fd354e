//! Streams that show the first iteration to reach each of some distances.

use std::time::Duration;

use futures_util::StreamExt;
use serde_json::{Value, json};

use crate::data;
use crate::support::{Server, Story, assert_query_refused, base, events, read_thinned, thinned};

/// What a stream with milestones has to show of a whole one.
fn expected(story: &Story, milestones: &[f64]) -> Vec<Value> {
    let mut left = milestones.to_vec();
    let mut shown = Vec::new();
    for iteration in &story.iterations {
        let error = iteration["error"]["max"].as_f64().unwrap();
        let reached = left.iter().filter(|m| error <= **m).count();
        if reached > 0 {
            let mut iteration = iteration.clone();
            iteration["milestone"] = json!(left[reached - 1]);
            left.drain(..reached);
            shown.push(iteration);
        }
    }
    // The final geometry comes last, whatever it has reached.
    let last = story.iterations.last().unwrap();
    if shown.last().map(|it| &it["iteration"]) != Some(&last["iteration"]) {
        shown.push(last.clone());
    }
    shown
}

#[tokio::test]
async fn the_first_iteration_to_reach_each_is_shown() {
    let server = Server::start().await;
    // Errors that fall, and errors that grow for a while.
    let extended = json!({
        "curve": {"points": data::lemniscate(), "parameters": "uniform", "basis": {"kind": "said_ball"}},
        "method": {"kind": "extended", "start": "data"},
        "stop": {"tolerance": 1e-6},
    });
    for (job, milestones) in [
        (data::small_job(), vec![1e-1, 1e-2, 1e-3]),
        (data::small_job(), vec![1e3, 1e-1, 3e-5, 2e-5, 1e-5, 1e-30]),
        (data::small_job(), vec![1e-30]),
        (extended, vec![0.5, 1e-2, 1e-6]),
    ] {
        let story = server.stream(&job).await;
        let text: Vec<String> = milestones.iter().map(ToString::to_string).collect();
        let query = format!("milestones={}", text.join(","));
        let path = format!("{}/events?{query}", base(&story.job));
        let (shown, end) = thinned(&server, &path, None).await;
        assert_eq!(shown, expected(&story, &milestones));
        assert_eq!(end, story.end);
        // While the job runs, and after it, it is the same.
        let request = server.post(&format!("/v1/jobs?{query}"));
        let request = request.header("accept", "text/event-stream");
        let (live, _) = read_thinned(request.json(&job).send().await.unwrap()).await;
        assert_eq!(live, shown);
        // A client that comes back after any of them gets the rest.
        for (index, iteration) in shown.iter().enumerate() {
            let id = iteration["iteration"].to_string();
            let (rest, _) = thinned(&server, &path, Some(&id)).await;
            assert_eq!(rest, shown[index + 1..]);
        }
    }
}

#[tokio::test]
async fn resuming_between_milestones() {
    let server = Server::start().await;
    let story = server.stream(&data::small_job()).await;
    let milestones = [1e-1, 1e-3, 1e-6];
    let all = expected(&story, &milestones);
    let path = format!("{}/events?milestones=0.1,0.001,0.000001", base(&story.job));
    for k in 0..story.iterations.len() {
        let (rest, _) = thinned(&server, &path, Some(&k.to_string())).await;
        let after = |it: &&Value| it["iteration"].as_u64().unwrap() > k as u64;
        assert_eq!(rest, all.iter().filter(after).cloned().collect::<Vec<_>>());
    }
    // A ring of one frame makes no difference.
    let server = Server::with(|config| config.ring = "1B".parse().unwrap()).await;
    let request = server.post("/v1/jobs?milestones=0.1,0.001,0.000001");
    let request = request.header("accept", "text/event-stream");
    let response = request.json(&data::small_job()).send().await.unwrap();
    let (shown, _) = read_thinned(response).await;
    assert_eq!(shown, all);
}

#[tokio::test]
async fn milestones_go_with_every_form() {
    let server = Server::start().await;
    let story = server.stream(&data::small_job()).await;
    let base = base(&story.job);
    for form in [
        "view=errors",
        "view=samples",
        "encoding=base64",
        "digits=auto",
        "view=samples&encoding=base64_f32",
    ] {
        let (all, _) = thinned(&server, &format!("{base}/events?{form}"), None).await;
        let path = format!("{base}/events?{form}&milestones=1e-2,1e-4");
        let (shown, _) = thinned(&server, &path, None).await;
        let milestones: Vec<&Value> = shown.iter().map(|it| &it["milestone"]).collect();
        let expected = [&json!(1e-2), &json!(1e-4), &Value::Null];
        assert_eq!(milestones, expected, "{form}");
        assert_eq!(shown[2]["iteration"], all.last().unwrap()["iteration"]);
        for mut iteration in shown {
            let k = iteration["iteration"].as_u64().unwrap() as usize;
            iteration.as_object_mut().unwrap().shift_remove("milestone");
            assert_eq!(iteration, all[k]);
        }
    }
    // NDJSON is JSON.
    let path = format!("{base}/events?milestones=1e-2");
    let request = server.get(&path).header("accept", "application/x-ndjson");
    let text = request.send().await.unwrap().text().await.unwrap();
    let lines: Vec<Value> = text
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    assert_eq!(lines.len(), 4);
    assert_eq!(lines[1]["data"]["milestone"], json!(1e-2));
    // None at all is the usual stream.
    let (all, _) = thinned(&server, &format!("{base}/events?milestones="), None).await;
    assert_eq!(all, story.iterations);
}

/// However a job ends: the final geometry comes with all digits, after the job and while it runs.
#[tokio::test]
async fn the_final_geometry_comes_last() {
    let server = Server::start().await;
    let mut exhausted = data::small_job();
    exhausted["stop"] = json!({"tolerance": 0, "max_iterations": 12});
    let mut none = data::small_job();
    none["stop"] = json!({"max_iterations": 0});
    for job in [data::small_job(), exhausted, none] {
        let story = server.stream(&job).await;
        let last = story.iterations.last().unwrap();
        for query in [
            "milestones=1e-300",
            "milestones=10,1e-1",
            "milestones=1e-1&digits=auto",
        ] {
            let path = format!("{}/events?{query}", base(&story.job));
            let (shown, end) = thinned(&server, &path, None).await;
            assert_eq!(
                &shown.last().unwrap()["control_points"],
                &last["control_points"]
            );
            assert_eq!(end["iterations"], last["iteration"]);
            let request = server.post(&format!("/v1/jobs?{query}"));
            let request = request.header("accept", "text/event-stream");
            let (live, _) = read_thinned(request.json(&job).send().await.unwrap()).await;
            assert_eq!(live, shown);
        }
    }
}

/// A stream that shows nothing for long is kept open, and ends with its job.
#[tokio::test]
async fn a_long_way_to_a_milestone() {
    let server = Server::with(|config| config.heartbeat = Duration::from_millis(20)).await;
    let job = server.create(&data::endless_job()).await;
    for milestones in ["1e-300", "1000,100,1e-300", "1000"] {
        let path = format!("{}/events?view=errors&milestones={milestones}", base(&job));
        let mut bytes = server.get(&path).send().await.unwrap().bytes_stream();
        let mut text = String::new();
        while text.matches(": still here\n\n").count() < 3 {
            text.push_str(std::str::from_utf8(&bytes.next().await.unwrap().unwrap()).unwrap());
        }
        let shown = text.matches("event: iteration").count();
        assert_eq!(shown, usize::from(milestones.starts_with("1000")), "{text}");
    }
    let path = format!("{}/events?view=errors&milestones=1000", base(&job));
    let mut stream = events(server.get(&path).send().await.unwrap());
    stream.next().await.unwrap();
    assert_eq!(
        stream.next().await.unwrap().data["milestone"],
        json!(1000.0)
    );
    let cancel = server.post(&format!("{}/cancel", base(&job)));
    assert_eq!(cancel.send().await.unwrap().status(), 200);
    let end = stream.next().await.unwrap();
    assert_eq!(
        (end.name.as_str(), &end.data["state"]),
        ("end", &json!("cancelled"))
    );
    server.stop().await;
}

#[tokio::test]
async fn milestones_that_make_no_sense_are_refused() {
    let server = Server::start().await;
    let job = server.fit(&data::small_job()).await;
    let path = format!("{}/events", base(&job));
    let many: Vec<String> = (1..=101).map(|i| format!("1e-{i}")).collect();
    let many = format!("milestones={}", many.join(","));
    for (query, parameter, reason) in [
        ("milestones=0", "milestones", "positive"),
        ("milestones=-1", "milestones", "positive"),
        ("milestones=NaN", "milestones", "positive finite"),
        ("milestones=inf,1", "milestones", "positive finite"),
        ("milestones=1e999", "milestones", "positive finite"),
        ("milestones=0.1,", "milestones", "\"\""),
        ("milestones=0.1;0.01", "milestones", "\"0.1;0.01\""),
        ("milestones=0.1,0.2", "milestones", "decrease"),
        ("milestones=0.1,0.1", "milestones", "decrease"),
        (&many, "milestones", "more than 100"),
        (
            "milestones=0.1&every=2",
            "milestones",
            "choose the iterations",
        ),
        ("milestones=0.1&pace=latest", "milestones", "skipped"),
        (
            "milestones=0.1&changed=true",
            "changed",
            "none can be skipped",
        ),
    ] {
        assert_query_refused(&server, &path, query, parameter, reason).await;
    }
    // What says nothing forbids nothing.
    let neutral = "milestones=0.1&every=1&pace=all&changed=false";
    let (shown, _) = thinned(&server, &format!("{path}?{neutral}"), None).await;
    assert_eq!(shown.len(), 2);
    let single = format!("{}/iterations/0", base(&job));
    assert_query_refused(
        &server,
        &single,
        "milestones=1",
        "milestones",
        "there is no such parameter",
    )
    .await;
}
