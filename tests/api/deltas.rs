//! Streams that say by how much numbers differ from those that the reader has.

use base64_simd::STANDARD;
use futures_util::StreamExt;
use serde_json::{Value, json};

use crate::data;
use crate::messages as pb;
use crate::messages::iteration::Geometry;
use crate::messages_over_rest;
use crate::rpc::{self, Messages};
use crate::support::{Server, Story, assert_query_refused, base, events, levels, problem, thinned};

/// The whole numbers of a packed array, coordinate by coordinate.
pub fn unpacked(bytes: &[u8], places: usize, dimension: usize) -> Vec<i64> {
    let (mut at, mut numbers) = (0, Vec::new());
    for _ in 0..dimension {
        for start in (0..places).step_by(256) {
            let (width, count) = (usize::from(bytes[at]), (places - start).min(256));
            assert!(width <= 32);
            let bit = |k: usize| u64::from(bytes[at + 1 + k / 8] >> (k % 8) & 1);
            for i in 0..count {
                let z = (0..width).fold(0, |z, k| z | bit(i * width + k) << k);
                let half = (z >> 1) as i64;
                numbers.push(if z & 1 == 1 { -half - 1 } else { half });
            }
            at += 1 + (count * width).div_ceil(8);
        }
    }
    assert_eq!(at, bytes.len(), "all bytes are read");
    numbers
}

/// Moves numbers, point by point, by steps.
pub fn moved(numbers: &mut [f64], step: f64, bytes: &[u8], dimension: usize) {
    assert!(
        step.is_normal() && step.to_bits() << 12 == 0,
        "{step} is a power of two"
    );
    let places = numbers.len() / dimension;
    for (k, d) in unpacked(bytes, places, dimension).into_iter().enumerate() {
        numbers[k % places * dimension + k / places] += step * d as f64;
    }
}

fn bytes(text: &Value) -> Vec<u8> {
    STANDARD.decode_to_vec(text.as_str().unwrap()).unwrap()
}

/// The numbers of a complete array.
fn complete(text: &Value, encoding: &Value) -> Vec<f64> {
    let bytes = bytes(text);
    match encoding.as_str().unwrap() {
        "base64" => bytes
            .as_chunks()
            .0
            .iter()
            .map(|it| f64::from_le_bytes(*it))
            .collect(),
        "base64_f32" => bytes
            .as_chunks()
            .0
            .iter()
            .map(|it| f32::from_le_bytes(*it).into())
            .collect(),
        other => panic!("{other} is not complete"),
    }
}

const ARRAYS: [(&str, &str); 3] = [
    ("control_points", "step"),
    ("samples", "step"),
    ("weights", "weight_step"),
];

/// What a reader has, array by array.
#[derive(Clone, Debug, Default)]
struct Reader {
    arrays: [Vec<f64>; 3],
}

impl Reader {
    /// Takes an event, which is compared with the same one in base64.
    fn take(&mut self, event: &Value, exact: &Value) {
        let is_delta = event["encoding"] == "delta";
        assert_eq!(event["shape"], exact["shape"]);
        for ((name, step), numbers) in ARRAYS.iter().zip(&mut self.arrays) {
            let Some(text) = event.get(name) else {
                assert!(exact.get(name).is_none(), "{name}");
                continue;
            };
            let exact_numbers = complete(&exact[name], &exact["encoding"]);
            let largest = exact_numbers.iter().fold(0.0, |a: f64, x| a.max(x.abs()));
            let rounding = largest * f64::EPSILON;
            if !is_delta {
                *numbers = complete(text, &event["encoding"]);
                if event["encoding"] == "base64" {
                    assert_eq!(*numbers, exact_numbers);
                }
                let error = exact["error"]["max"].as_f64().unwrap();
                let bound = if *name == "weights" {
                    error * largest
                } else {
                    error
                };
                assert_near(numbers, &exact_numbers, bound / 128.0 + rounding);
                continue;
            }
            let step = event[step].as_f64().unwrap();
            let dimension = match *name {
                "weights" => 1,
                _ => event["shape"]
                    .as_array()
                    .unwrap()
                    .last()
                    .unwrap()
                    .as_u64()
                    .unwrap(),
            };
            moved(numbers, step, &bytes(text), dimension as usize);
            assert_near(numbers, &exact_numbers, step / 2.0 + rounding);
            if *name != "weights" {
                let error = exact["error"]["max"].as_f64().unwrap();
                assert!(
                    step <= error / 64.0 || step <= 2.0 * rounding,
                    "{step} {error}"
                );
            }
        }
        for (name, expected) in exact.as_object().unwrap() {
            let is_array = ARRAYS.iter().any(|(array, _)| array == name);
            // Those of samples are in complete events.
            let is_left_out = name == "parameters" && event["encoding"] != "base64";
            if !is_array && !is_left_out && name != "encoding" {
                assert_eq!(&event[name], expected, "{name}");
            }
        }
    }
}

fn assert_near(found: &[f64], expected: &[f64], bound: f64) {
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(expected) {
        let same = found == expected || (found.is_nan() && expected.is_nan());
        assert!(
            same || (found - expected).abs() <= bound,
            "{found} {expected} {bound}"
        );
    }
}

fn encoding(event: &Value) -> &str {
    event["encoding"].as_str().unwrap()
}

/// Reads events as a reader that gets them all, beside those in base64; checks that the last one is exact.
fn follow(deltas: &[Value], exact: &[Value]) {
    let mut reader = Reader::default();
    assert_ne!(encoding(&deltas[0]), "delta");
    for event in deltas {
        let k = &event["iteration"];
        let same = exact.iter().find(|it| &it["iteration"] == k).unwrap();
        reader.take(event, same);
    }
    assert_eq!(deltas.last(), exact.last());
}

fn jobs() -> Vec<(&'static str, Value, &'static str)> {
    let weights: Vec<f64> = (0..300).map(|i| 1.0 + f64::from(i % 3)).collect();
    let fixed = json!({"points": [[1, 0], [0.6, 0.8], [0, 1]], "weights": [1, 1.25, 2], "basis": {"kind": "bspline", "degree": 2}});
    let scaled = |scale: f64| {
        let points = data::wave(50);
        let scaled = |x: &Value| json!(x.as_f64().unwrap() * scale);
        let point = |p: &Value| p.as_array().unwrap().iter().map(scaled).collect::<Value>();
        points
            .as_array()
            .unwrap()
            .iter()
            .map(point)
            .collect::<Value>()
    };
    let method = json!({"kind": "least_squares", "control_points": "auto"});
    let number = |i: usize, k: usize| (i as f64 * 0.1 + k as f64).sin() * (k + 1) as f64;
    let many: Vec<Vec<f64>> = (0..300)
        .map(|i| (0..7).map(|k| number(i, k)).collect())
        .collect();
    vec![
        ("a curve", json!({"curve": {"points": data::wave(300)}}), ""),
        (
            "samples",
            json!({"curve": {"points": data::wave(300)}}),
            "&view=samples&samples=300",
        ),
        (
            "many coordinates",
            json!({"curve": {"points": many}, "stop": {"tolerance": 1e-9}}),
            "",
        ),
        (
            "one coordinate",
            json!({"curve": {"points": [[1], [2], [4]], "closed": true, "basis": {"kind": "bspline", "degree": 2}}}),
            "",
        ),
        (
            "changing weights",
            json!({"curve": {"points": data::wave(300), "weights": weights}}),
            "",
        ),
        (
            "their samples",
            json!({"curve": {"points": data::wave(300), "weights": weights}}),
            "&view=samples",
        ),
        (
            "fixed weights",
            json!({"curve": fixed, "rational": "fixed"}),
            "",
        ),
        (
            "a surface",
            json!({"surface": {"points": data::peaks(20), "closed": {"u": true, "v": false}}}),
            "",
        ),
        (
            "samples of a surface",
            json!({"surface": {"points": data::peaks(20)}}),
            "&view=samples&samples=30x20",
        ),
        (
            "a slow fit",
            json!({"curve": {"points": data::wave(300)}, "method": {"kind": "transpose"}, "stop": {"tolerance": 0, "max_iterations": 200}}),
            "",
        ),
        (
            "errors that grow",
            json!({"curve": {"points": data::lemniscate(), "parameters": "uniform", "basis": {"kind": "said_ball"}}, "method": {"kind": "extended", "start": "data"}, "stop": {"tolerance": 1e-6}}),
            "",
        ),
        (
            "large numbers",
            json!({"curve": {"points": scaled(1e200)}}),
            "",
        ),
        (
            "small numbers",
            json!({"curve": {"points": scaled(1e-200)}}),
            "",
        ),
        (
            "as few as needed",
            json!({"curve": {"points": data::wave(400)}, "method": method, "stop": {"tolerance": 1e-4}}),
            "",
        ),
        (
            "down to the rounding",
            json!({"curve": {"points": data::wave(300)}, "stop": {"tolerance": 0, "max_iterations": 100}}),
            "",
        ),
    ]
}

#[tokio::test]
async fn each_event_is_near_its_iteration_and_the_last_is_exact() {
    let server = Server::start().await;
    for (name, job, view) in jobs() {
        let story = server.stream(&job).await;
        let path = format!("{}/events?encoding=", base(&story.job));
        let (exact, end) = thinned(&server, &format!("{path}base64{view}"), None).await;
        let (deltas, same_end) = thinned(&server, &format!("{path}delta{view}"), None).await;
        assert_eq!(end, same_end, "{name}");
        assert_eq!(levels(&deltas), levels(&exact), "{name}");
        follow(&deltas, &exact);
        let count = deltas.iter().filter(|it| encoding(it) == "delta").count();
        if deltas.len() > 4 && !name.ends_with("needed") {
            assert!(
                count >= deltas.len() / 2,
                "{name}: {count} of {}",
                deltas.len()
            );
        }
        // The same while it runs.
        let request = server.post(&format!("/v1/jobs?encoding=delta{view}"));
        let request = request.header("accept", "text/event-stream").json(&job);
        let live = Story::read(request.send().await.unwrap()).await;
        assert_eq!(live.iterations, deltas, "{name}");
    }
}

#[tokio::test]
async fn knots_come_with_complete_events() {
    let server = Server::start().await;
    let job = jobs()
        .into_iter()
        .find(|(name, ..)| name.ends_with("needed"))
        .unwrap()
        .1;
    let story = server.stream(&job).await;
    let path = format!("{}/events?encoding=delta", base(&story.job));
    let (deltas, _) = thinned(&server, &path, None).await;
    let knots = deltas.iter().filter(|it| it.get("knots").is_some());
    assert!(knots.clone().count() > 1);
    assert!(knots.clone().all(|it| encoding(it) != "delta"));
    assert!(deltas.iter().any(|it| encoding(it) == "delta"));
}

#[tokio::test]
async fn resumed_streams_start_with_a_complete_event() {
    let server = Server::start().await;
    let story = server.stream(&data::small_job()).await;
    let path = format!("{}/events?encoding=", base(&story.job));
    let (exact, _) = thinned(&server, &format!("{path}base64"), None).await;
    for k in 0..exact.len() - 1 {
        let (deltas, _) = thinned(&server, &format!("{path}delta"), Some(&k.to_string())).await;
        assert_eq!(levels(&deltas), levels(&exact[k + 1..]));
        follow(&deltas, &exact);
    }
}

/// Readers that leave out iterations follow from one that they get to the next.
#[tokio::test]
async fn streams_may_leave_out_iterations() {
    let server = Server::start().await;
    let story = server.stream(&data::small_job()).await;
    let path = format!("{}/events?encoding=", base(&story.job));
    for query in [
        "every=3",
        "milestones=1e-2,1e-3,1e-5,1e-7",
        "every=3&view=control_points",
    ] {
        let (some, _) = thinned(&server, &format!("{path}base64&{query}"), None).await;
        for after in [None, Some("4")] {
            let (deltas, _) = thinned(&server, &format!("{path}delta&{query}"), after).await;
            let rest = some.len() - deltas.len();
            assert_eq!(levels(&deltas), levels(&some[rest..]));
            follow(&deltas, &some);
            assert!(deltas.iter().any(|it| encoding(it) == "delta"));
        }
    }
    // The newest iterations of a job that runs.
    let job = data::endless_job();
    let request = server.post("/v1/jobs?encoding=delta&pace=latest");
    let request = request.header("accept", "text/event-stream").json(&job);
    let mut stream = events(request.send().await.unwrap());
    let created = stream.next().await.unwrap().data;
    let mut reader = Reader::default();
    for _ in 0..20 {
        let event = stream.next().await.unwrap().data;
        let k = &event["iteration"];
        let path = format!("{}/iterations/{k}?encoding=base64", base(&created));
        reader.take(&event, &server.json(&path).await);
    }
}

/// Readers in step and readers that lag behind get the same content.
#[tokio::test]
async fn readers_at_any_pace_get_the_same() {
    let server = Server::start().await;
    let mut job = data::endless_job();
    job["stream"] = json!({"encoding": "delta"});
    let created = server.create(&job).await;
    let path = format!("{}/events", base(&created));
    let mut readers = Vec::new();
    for _ in 0..4 {
        readers.push(events(server.get(&path).send().await.unwrap()));
    }
    let mut reported: Vec<Vec<Value>> = vec![Vec::new(); readers.len()];
    for round in 0..60 {
        for (index, reader) in readers.iter_mut().enumerate() {
            // Some read several at once, and some later.
            let pace = index + 1;
            let count = if round % pace == index { pace } else { 0 };
            for _ in 0..count {
                reported[index].push(reader.next().await.unwrap().data);
            }
        }
    }
    assert!(
        reported
            .iter()
            .all(|it| encoding(it.last().unwrap()) == "delta")
    );
    for other in &reported[1..] {
        assert_eq!(other, &reported[0][..other.len()]);
    }
    let cancel = server.post(&format!("{}/cancel", base(&created)));
    cancel.send().await.unwrap();
}

#[tokio::test]
async fn each_step_is_made_once() {
    let server = Server::start().await;
    let created = server.fit(&data::small_job()).await;
    let path = format!("{}/events?encoding=delta", base(&created));
    let read = async || thinned(&server, &path, None).await.0;
    let (one, two, three) = tokio::join!(read(), read(), read());
    assert!(one == two && two == three);
    let made = server.metrics().await["piad_encodings_total"];
    assert!(made <= (one.len() + 4) as f64, "{made} of {}", one.len());
}

/// A server that has no room for what its readers have sends all events complete.
#[tokio::test]
async fn without_memory_all_events_are_complete() {
    let server = Server::with(|config| config.memory = Some("16MiB".parse().unwrap())).await;
    for (count, is_small) in [(10_000, true), (30_000, false)] {
        let mut job = fifty(count);
        job["stop"]["max_iterations"] = json!(5);
        let created = server.fit(&job).await;
        let path = format!("{}/events?encoding=", base(&created));
        let (exact, _) = thinned(&server, &format!("{path}base64"), None).await;
        let (deltas, _) = thinned(&server, &format!("{path}delta"), None).await;
        follow(&deltas, &exact);
        let has = deltas.iter().any(|it| encoding(it) == "delta");
        assert_eq!(has, is_small, "{count}");
    }
}

#[tokio::test]
async fn edits_begin_with_a_complete_event() {
    let server = Server::start().await;
    let parent = server.fit(&data::small_job()).await;
    let edit = |ephemeral: bool| json!({"points": [{"index": 7, "point": [2.5, 0.5]}], "ephemeral": ephemeral});
    let stream = async |encoding: &str, ephemeral: bool| {
        let path = format!("{}/edits/stream?encoding={encoding}", base(&parent));
        let request = server.post(&path).json(&edit(ephemeral));
        Story::read(request.send().await.unwrap()).await.iterations
    };
    for ephemeral in [false, true] {
        let exact = stream("base64", ephemeral).await;
        follow(&stream("delta", ephemeral).await, &exact);
    }
}

#[tokio::test]
async fn lines_are_the_same() {
    let server = Server::start().await;
    let story = server.stream(&data::small_job()).await;
    let path = format!("{}/events?encoding=delta", base(&story.job));
    let (events, _) = thinned(&server, &path, None).await;
    let request = server.get(&path).header("accept", "application/x-ndjson");
    let text = request.send().await.unwrap().text().await.unwrap();
    let lines: Vec<Value> = text
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    let iterations = lines.iter().filter(|line| line["event"] == "iteration");
    let iterations: Vec<Value> = iterations.map(|line| line["data"].clone()).collect();
    assert_eq!(iterations, events);
}

/// Takes the geometry of a message, which is compared with the same event in base64.
fn take_message(reader: &mut [Vec<f64>; 2], message: &pb::Iteration, exact: &Value) {
    let name = match exact.get("samples") {
        None => "control_points",
        Some(_) => "samples",
    };
    let error = message.error.unwrap().max;
    match message.geometry.as_ref().unwrap() {
        Geometry::ControlNet(net) => *reader = [net.points.clone(), net.weights.clone()],
        Geometry::Samples(samples) => *reader = [samples.points.clone(), Vec::new()],
        Geometry::Deltas(deltas) => {
            assert!(deltas.step <= error / 64.0);
            let count = deltas.rows * deltas.columns * deltas.dimension;
            assert_eq!(reader[0].len(), count as usize);
            moved(
                &mut reader[0],
                deltas.step,
                &deltas.points,
                deltas.dimension as usize,
            );
            if !reader[1].is_empty() {
                moved(&mut reader[1], deltas.weight_step, &deltas.weights, 1);
            }
        }
        Geometry::Changes(_) => panic!("these are something else"),
    }
    for (numbers, name) in reader.iter().zip([name, "weights"]) {
        let exact = exact.get(name).map(|text| complete(text, &json!("base64")));
        assert_near(numbers, &exact.unwrap_or_default(), error / 64.0);
    }
}

#[tokio::test]
async fn messages_say_the_same() {
    let server = Server::start().await;
    let mut client = rpc::connect(&server).await;
    for (name, job, view) in jobs() {
        if !["weights", "surface", "samples", "many"]
            .iter()
            .any(|it| name.contains(it))
        {
            continue;
        }
        let created = server.fit(&job).await;
        let path = format!("{}/events?encoding=", base(&created));
        let (exact, _) = thinned(&server, &format!("{path}base64{view}"), None).await;
        let request = server.get(&format!("{path}delta{view}"));
        let request = request.header("accept", "application/x-protobuf");
        let rest = messages_over_rest::events(request.send().await.unwrap()).await;
        let samples = view.split("samples=").nth(1).unwrap_or_default();
        let mut samples = samples.split('x').map(|it| it.parse().unwrap_or_default());
        let options = pb::StreamOptions {
            json_encoding: pb::JsonEncoding::Delta.into(),
            view: match view {
                "" => pb::View::ControlPoints.into(),
                _ => pb::View::Samples.into(),
            },
            samples_u: samples.next().unwrap_or_default(),
            samples_v: samples.next().unwrap_or_default(),
            ..pb::StreamOptions::default()
        };
        let id = created["id"].as_str().unwrap();
        let called = Messages::read(rpc::watch(&mut client, id, None, options).await).await;
        assert_eq!(rest.iterations, called.iterations, "{name}");
        let mut reader = <[Vec<f64>; 2]>::default();
        for (message, exact) in rest.iterations.iter().zip(&exact) {
            take_message(&mut reader, message, exact);
        }
        let is_delta = |it: &&pb::Iteration| matches!(it.geometry, Some(Geometry::Deltas(_)));
        let count = rest.iterations.iter().filter(is_delta).count();
        assert_eq!(count, exact.len() - 2, "{name}");
        let last = exact.last().unwrap();
        let last = ["control_points", "samples"].map(|name| last.get(name));
        let last = last.into_iter().flatten().next().unwrap();
        assert_eq!(reader[0], complete(last, &json!("base64")));
    }
}

/// 50 iterations of a curve in space.
pub fn fifty(count: usize) -> Value {
    let points: Vec<[f64; 3]> = (0..count)
        .map(|i| 40.0 * i as f64 / count as f64)
        .map(|t| {
            [
                t.cos() * (3.0 + (7.0 * t).sin()),
                t.sin() * 3.0,
                t / 3.0 + (3.0 * t).cos(),
            ]
        })
        .collect();
    json!({"curve": {"points": points}, "stop": {"tolerance": 0, "max_iterations": 50}})
}

/// The bytes of a stream in each encoding.
pub async fn sizes(server: &Server, job: &Value) -> Vec<(&'static str, usize)> {
    let created = server.fit(job).await;
    let mut sizes = Vec::new();
    for encoding in ["json", "base64", "base64_f32", "delta"] {
        let path = format!(
            "{}/events?describe=none&encoding={encoding}",
            base(&created)
        );
        let mut response = server.get(&path).send().await.unwrap();
        let mut size = 0;
        while let Some(bytes) = response.chunk().await.unwrap() {
            size += bytes.len();
        }
        sizes.push((encoding, size));
    }
    sizes
}

#[tokio::test]
async fn a_stream_takes_a_fifth_of_its_bytes() {
    let server = Server::start().await;
    let sizes = sizes(&server, &fifty(10_000)).await;
    assert!(sizes[3].1 * 5 <= sizes[1].1, "{sizes:?}");
}

#[tokio::test]
async fn choices_that_do_not_go_with_differences_are_refused() {
    let server = Server::start().await;
    let job = server.fit(&data::small_job()).await;
    let base = base(&job);
    let refused = async |resource: &str, query: &str, parameter: &str, reason: &str| {
        assert_query_refused(
            &server,
            &format!("{base}/{resource}"),
            query,
            parameter,
            reason,
        )
        .await;
    };
    refused(
        "events",
        "encoding=delta&changed=true",
        "changed",
        "do not go together",
    )
    .await;
    refused(
        "events",
        "encoding=delta&digits=auto",
        "digits",
        "do not go together",
    )
    .await;
    refused(
        "events",
        "encoding=delta&view=errors",
        "encoding",
        "without geometry",
    )
    .await;
    refused(
        "iterations/3",
        "encoding=delta",
        "encoding",
        "delta is for streams",
    )
    .await;
    refused(
        "result",
        "encoding=delta",
        "encoding",
        "delta is for streams",
    )
    .await;
    for path in ["/v1/fit", "/v1/batch"] {
        let request = server.post(&format!("{path}?encoding=delta"));
        let refused = request.json(&data::small_job()).send().await.unwrap();
        let (status, problem) = problem(refused).await;
        let parameter = &problem["errors"][0]["parameter"];
        assert_eq!((status, parameter), (400, &json!("encoding")), "{path}");
    }
    for (stream, pointer) in [
        (
            json!({"encoding": "delta", "changed": true}),
            "/stream/changed",
        ),
        (
            json!({"encoding": "delta", "digits": "auto"}),
            "/stream/digits",
        ),
        (
            json!({"encoding": "delta", "view": "errors"}),
            "/stream/encoding",
        ),
    ] {
        let mut job = data::small_job();
        job["stream"] = stream;
        server
            .assert_refused(&job, pointer, "do not go together")
            .await;
    }
}
