//! Numbers near the ends of their range: no state that claims success stands beside a number that is
//! not finite, and files hold finite numbers or are refused.

use serde_json::{Value, json};

use crate::support::{Server, base};

/// Random numbers, the same in every run.
struct Random(u64);

impl Random {
    /// In [0, 1).
    fn unit(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    fn of<T: Clone>(&mut self, choices: &[T]) -> T {
        choices[(self.unit() * choices.len() as f64) as usize].clone()
    }

    fn chance(&mut self, part: f64) -> bool {
        self.unit() < part
    }

    /// From a denormal number to the largest one, mostly near an end of the range, or of the range of
    /// numbers whose squares are in it.
    fn magnitude(&mut self) -> f64 {
        let ends = [
            (300.0, 308.2),
            (-323.0, -300.0),
            (140.0, 170.0),
            (-170.0, -140.0),
            (-10.0, 10.0),
        ];
        if self.chance(0.1) {
            return self.of(&[5e-324, 2.3e-308, 1.79e308, 1.0, 3.5e38, 1e154]);
        }
        let (low, high) = self.of(&ends);
        10_f64.powf(self.between(low, high))
    }
}

/// How the coordinates of a job are made.
enum Coordinates {
    Alike(f64),
    ByLane(Vec<f64>),
    Each,
    Mixed(f64),
}

impl Coordinates {
    fn new(random: &mut Random, dimension: usize) -> Self {
        match random.of(&[0, 1, 2, 3]) {
            0 => Self::Alike(random.magnitude()),
            1 => Self::ByLane((0..dimension).map(|_| random.magnitude()).collect()),
            2 => Self::Each,
            _ => Self::Mixed(random.magnitude()),
        }
    }

    fn point(&self, random: &mut Random, dimension: usize) -> Vec<f64> {
        (0..dimension)
            .map(|c| {
                let x = random.between(-1.0, 1.0);
                match self {
                    Self::Alike(size) => x * size,
                    Self::ByLane(sizes) => x * sizes[c],
                    Self::Each => x * random.magnitude(),
                    Self::Mixed(size) => random.of(&[0.0, x, x * size]),
                }
            })
            .collect()
    }
}

fn weights(random: &mut Random, count: usize) -> Vec<f64> {
    let kind = random.of(&[0, 1, 2]);
    let weight = |random: &mut Random| match kind {
        0 => random.between(0.5, 2.0),
        1 => 10_f64.powf(random.between(-300.0, 300.0)),
        _ => random.of(&[1e-300, 1e300, 1.0, 5e-324, 1e308]),
    };
    (0..count).map(|_| weight(random)).collect()
}

/// Degrees, bases, weights, methods and stop rules of all kinds.
fn job(random: &mut Random) -> Value {
    let dimension = random.of(&[1, 2, 3]);
    let coordinates = Coordinates::new(random, dimension);
    let surface = random.chance(0.3);
    let line = |count: usize, random: &mut Random| -> Vec<Vec<f64>> {
        (0..count)
            .map(|_| coordinates.point(random, dimension))
            .collect()
    };
    let (rows, columns) = match surface {
        true => (random.of(&[3, 4, 5]), random.of(&[3, 4, 6])),
        false => (random.of(&[3, 5, 8, 12]), 1),
    };
    let mut shape = json!({
        "parameters": random.of(&["uniform", "chord_length", "centripetal"]),
        "basis": random.of(&[
            json!({"kind": "bspline", "degree": 1}), json!({"kind": "bspline", "degree": 2}),
            json!({"kind": "bspline", "degree": 3}), json!({"kind": "bspline", "degree": 5}),
            json!({"kind": "bernstein"}), json!({"kind": "said_ball"}), json!({"kind": "wang_ball"}),
        ]),
    });
    if shape["basis"]["kind"] == "bspline" && random.chance(0.25) {
        shape["closed"] = json!(true);
    }
    let weighted = random.chance(0.5);
    let fixed = weighted && random.chance(0.4);
    if surface {
        shape["points"] = (0..rows).map(|_| json!(line(columns, random))).collect();
    } else {
        shape["points"] = json!(line(rows, random));
    }
    if weighted {
        shape["weights"] = match (surface, fixed) {
            (false, _) => json!(weights(random, rows)),
            (true, true) => json!({"u": weights(random, rows), "v": weights(random, columns)}),
            (true, false) => (0..rows).map(|_| json!(weights(random, columns))).collect(),
        };
    }
    let mut job = json!({
        (if surface { "surface" } else { "curve" }): shape,
        "method": method(random, rows, columns),
        "stop": stop(random),
    });
    if fixed {
        job["rational"] = json!("fixed");
    }
    job
}

fn method(random: &mut Random, rows: usize, columns: usize) -> Value {
    let surface = columns > 1;
    let kinds = [
        "global",
        "weighted",
        "local",
        "adaptive",
        "extended",
        "transpose",
        "convex",
        "chebyshev",
        "direct",
        "least_squares",
        "least_squares",
    ];
    let mut method = json!({"kind": random.of(&kinds)});
    match method["kind"].as_str().unwrap() {
        "adaptive" => method["threshold"] = json!(random.magnitude()),
        "local" if surface => method["indices"] = json!([[0, 1], [1, 1]]),
        "local" => method["indices"] = json!([0, 2]),
        "least_squares" => {
            method["control_points"] = match surface {
                true => json!({"u": rows - 1, "v": columns - 1}),
                false => json!(rows - 1),
            };
            method["variant"] = json!(random.of(&["diagonal", "lspia", "cg"]));
            if method["variant"] == "lspia" {
                method["mu"] = json!(random.magnitude());
            }
        }
        _ => {}
    }
    method
}

fn stop(random: &mut Random) -> Value {
    let mut stop = json!({"max_iterations": random.of(&[0, 1, 5, 40])});
    let tolerance = random.magnitude();
    match random.of(&[0, 1, 2]) {
        0 => stop["tolerance"] = json!(random.of(&[0.0, tolerance, 1e308, 1.7e308, 1e-3])),
        1 => stop["relative_tolerance"] = json!(random.of(&[0.0, 1e-9, tolerance, 1e308, 0.5])),
        _ => {}
    }
    stop
}

/// Where a document has null.
fn nulls(value: &Value, path: &str, found: &mut Vec<String>) {
    match value {
        Value::Null => found.push(path.to_owned()),
        Value::Array(items) => {
            let all = items.iter().enumerate();
            all.for_each(|(i, item)| nulls(item, &format!("{path}/{i}"), found));
        }
        Value::Object(fields) => {
            let all = fields.iter();
            all.for_each(|(name, item)| nulls(item, &format!("{path}/{name}"), found));
        }
        _ => {}
    }
}

/// Fields that may be null: missing texts and arrays, values of methods that are not computed, rates of exact fits, and
/// unknown predictions.
const ABSENT: [&str; 18] = [
    "/name",
    "/reason",
    "/detail",
    "/stream",
    "/rational",
    "/knots",
    "/knots/u",
    "/knots/v",
    "/weights",
    "/weights/u",
    "/weights/v",
    "/iteration",
    "/error",
    "/started_at",
    "/finished_at",
    "/method/omega",
    "/predicted/rate",
    "/predicted/iterations",
];

/// What is null although it should be a number.
fn not_finite(value: &Value) -> Vec<String> {
    let mut found = Vec::new();
    nulls(value, "", &mut found);
    found.retain(|path| !ABSENT.contains(&path.as_str()));
    found
}

/// True if a text has NaN or infinity in place of a number.
fn has_words(text: &str) -> bool {
    let words = text.split(|c: char| !c.is_ascii_alphanumeric());
    words
        .into_iter()
        .any(|word| ["nan", "inf", "infinity"].contains(&word.to_lowercase().as_str()))
}

/// The accessors of a binary glTF file, and the numbers of its buffer.
fn check_gltf(bytes: &[u8]) {
    let length = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    let json_end = 20 + length(12);
    let document: Value = serde_json::from_slice(&bytes[20..json_end]).unwrap();
    assert_eq!(not_finite(&document), Vec::<String>::new());
    let binary = &bytes[json_end + 8..];
    for accessor in document["accessors"].as_array().unwrap() {
        if accessor["componentType"] == 5126 {
            let view = &document["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
            let part = |name: &str| view[name].as_u64().unwrap() as usize;
            let numbers = binary[part("byteOffset")..][..part("byteLength")].chunks_exact(4);
            for number in numbers {
                assert!(f32::from_le_bytes(number.try_into().unwrap()).is_finite());
            }
        }
    }
}

async fn check_files(server: &Server, path: &str, job: &Value) {
    for format in ["step", "iges", "obj", "svg", "csv", "dxf", "gltf"] {
        let answer = server
            .get(&format!("{path}/result/{format}"))
            .send()
            .await
            .unwrap();
        let status = answer.status().as_u16();
        let body = answer.bytes().await.unwrap();
        if status != 200 {
            assert_eq!(status, 409, "{format} {job}");
            let problem: Value = serde_json::from_slice(&body).unwrap();
            assert!(problem["detail"].as_str().unwrap().len() > 20, "{problem}");
        } else if format == "gltf" {
            check_gltf(&body);
        } else {
            let text = std::str::from_utf8(&body).unwrap();
            assert!(!has_words(text), "{format} {job}\n{text}");
        }
    }
}

async fn check(server: &Server, job: &Value) -> String {
    let request = server.post("/v1/jobs").header("prefer", "wait=100");
    let answer = request.json(job).send().await.unwrap();
    let status = answer.status().as_u16();
    let made: Value = answer.json().await.unwrap();
    if status == 422 {
        return "refused".to_owned();
    }
    assert_eq!(status, 201, "{job}\n{made}");
    assert!(made["stop"]["tolerance"].is_f64(), "{job}\n{made}");
    assert!(made["progress"].is_f64(), "{job}\n{made}");
    let state = made["state"].as_str().unwrap();
    let path = base(&made);
    let result = server.get(&format!("{path}/result")).send().await.unwrap();
    if result.status() == 200 {
        let result: Value = result.json().await.unwrap();
        if state == "converged" {
            for document in [&made, &result] {
                assert_eq!(
                    not_finite(document),
                    Vec::<String>::new(),
                    "{job}\n{document}"
                );
            }
        }
        if state == "converged" {
            let grid = if job["surface"].is_null() { "9" } else { "5x5" };
            let samples = server
                .json(&format!("{path}/result?view=samples&samples={grid}"))
                .await;
            assert_eq!(
                not_finite(&samples),
                Vec::<String>::new(),
                "{job}\n{samples}"
            );
        }
        // Coordinates at infinity are null, and so are infinite distances; weights are numbers.
        let mut paths = not_finite(&result);
        paths.retain(|path| path.starts_with("/weights") || path.starts_with("/knots"));
        assert_eq!(paths, Vec::<String>::new(), "{job}\n{result}");
    } else {
        assert_eq!(state, "failed", "{job}\n{made}");
    }
    check_files(server, path, job).await;
    state.to_owned()
}

#[tokio::test]
async fn success_and_files_are_finite() {
    let server = Server::start().await;
    let mut random = Random(20_260_101);
    let mut states = std::collections::BTreeMap::new();
    for _ in 0..1500 {
        let job = job(&mut random);
        *states.entry(check(&server, &job).await).or_insert(0) += 1;
    }
    // All ends occur, so that each of them is looked at.
    for state in ["refused", "converged", "exhausted", "failed", "stalled"] {
        assert!(states.get(state) > Some(&0), "{states:?}");
    }
}

/// A tolerance beyond the range of numbers was infinite, and anything converged.
#[tokio::test]
async fn tolerances_beyond_the_range_of_numbers_are_refused() {
    let server = Server::start().await;
    let job = json!({
        "curve": {"points": [[0, 0], [1e9, 1], [2e9, 5]]},
        "stop": {"relative_tolerance": 1e300},
    });
    server
        .assert_refused(&job, "/stop/relative_tolerance", "exceeds the range")
        .await;
}

/// Products of weights and coordinates that underflow would be other points.
#[tokio::test]
async fn weights_that_lose_the_data_are_refused() {
    let server = Server::start().await;
    let job = json!({
        "curve": {"points": [[1.5, 0], [0.1, 1], [2, 5]], "weights": [1, 1e-320, 1]},
    });
    server
        .assert_refused(&job, "/curve/weights/1", "scale the weights up")
        .await;
}

/// The eigenvalues of such a matrix are not found, which must be detected in bounded time.
#[tokio::test]
async fn extreme_weights_are_answered() {
    let server = Server::start().await;
    let job = json!({
        "curve": {
            "points": [[0.004], [-0.0014], [-0.0094], [-0.00996]], "basis": {"kind": "wang_ball"},
            "weights": [1e-300, 1, 2.811701414408077e273, 5e-324], "parameters": "uniform",
        },
        "rational": "fixed", "method": {"kind": "weighted"}, "stop": {"max_iterations": 5},
    });
    check(&server, &job).await;
}
