//! Files of points as bodies: shown as JSON, and fitted.

use reqwest::Response;
use serde_json::{Value, json};

use crate::support::{Server, Story, base, problem};

const WING: &str = "NACA 2412\n1 0.0013\n0.95 0.0114\n0.9 0.0208\n0.8 0.0375\n0.7 0.0518\n";

/// A height field as lines, with blank lines between rows or without.
fn field(between: &str) -> String {
    let row = |i: u32| {
        let point = |j: u32| format!("{i},{j},{}\n", i * i + j);
        (0..4).map(point).collect::<String>()
    };
    (0..5).map(row).collect::<Vec<_>>().join(between)
}

pub(crate) async fn send(server: &Server, path: &str, media_type: &str, body: &str) -> Response {
    let request = server.post(path).header("content-type", media_type);
    let request = request.header("prefer", "wait=100");
    request.body(body.to_owned()).send().await.unwrap()
}

pub(crate) async fn read(server: &Server, body: &str) -> Value {
    let response = send(server, "/v1/points", "text/plain", body).await;
    assert_eq!(response.status(), 200, "{body}");
    response.json().await.unwrap()
}

/// Posts points that are fitted; gives the job as it was accepted.
async fn input(server: &Server, query: &str, body: &str) -> Value {
    let response = send(server, &format!("/v1/jobs{query}"), "text/csv", body).await;
    let status = response.status();
    let job: Value = response.json().await.unwrap();
    assert_eq!(status, 201, "{query}: {job:#}");
    server.json(&format!("{}/input", base(&job))).await
}

#[tokio::test]
async fn files_are_shown_as_jobs_have_them() {
    let server = Server::start().await;
    let wing = read(&server, WING).await;
    assert_eq!(wing["name"], "NACA 2412");
    assert_eq!(wing["curve"]["points"][1], json!([0.95, 0.0114]));
    assert_eq!(wing["notices"], json!([]));
    assert_eq!(wing.get("surface"), None);
    for between in ["", "\n"] {
        let surface = read(&server, &field(between)).await;
        let points = &surface["surface"]["points"];
        assert_eq!(points.as_array().unwrap().len(), 5);
        assert_eq!(
            points[2],
            json!([
                [2.0, 0.0, 4.0],
                [2.0, 1.0, 5.0],
                [2.0, 2.0, 6.0],
                [2.0, 3.0, 7.0]
            ])
        );
        assert!(
            surface["notices"][0]
                .as_str()
                .unwrap()
                .contains("5 rows of 4")
        );
    }
    // What is shown is a job, all but the notices.
    let mut job = read(&server, &field("")).await;
    job.as_object_mut().unwrap().remove("notices");
    assert_eq!(server.fit(&job).await["state"], "converged");
    // Nothing is kept.
    assert_eq!(
        server.json("/v1/jobs").await["jobs"]
            .as_array()
            .unwrap()
            .len(),
        1
    );
    let response = send(
        &server,
        "/v1/points?surface.size=2x2",
        "text/csv",
        "0 0\n0 1\n1 0\n1 1\n",
    )
    .await;
    let shown: Value = response.json().await.unwrap();
    assert_eq!(
        shown["surface"]["points"],
        json!([[[0.0, 0.0], [0.0, 1.0]], [[1.0, 0.0], [1.0, 1.0]]])
    );
}

#[tokio::test]
async fn outlines_that_come_back_are_closed() {
    let server = Server::start().await;
    let outline = "2,0\n3,1\n3,2\n2,3\n1,3\n0,2\n0,1\n1,0\n2,0\n";
    let shown = read(&server, outline).await;
    assert_eq!(shown["curve"]["closed"], true);
    assert_eq!(shown["curve"]["points"].as_array().unwrap().len(), 8);
    assert!(shown["notices"][0].as_str().unwrap().contains("is closed"));
    for (query, closed) in [
        ("", json!(true)),
        ("?curve.closed=true", json!(true)),
        ("?curve.basis.kind=bspline", json!(true)),
        ("?curve.closed=false", json!(false)),
        ("?curve.basis.kind=bernstein", Value::Null),
        ("?curve.ends=natural", Value::Null),
    ] {
        let job = input(&server, query, outline).await;
        let count = if closed == true { 8 } else { 9 };
        let points = job["curve"]["points"].as_array().unwrap().len();
        assert_eq!(points, count, "{query}");
        let asked = job["curve"].get("closed").filter(|it| **it == true);
        assert_eq!(asked.is_some(), closed == true, "{query}: {job:#}");
    }
    // The same as a JSON array, in which the point recurs up to rounding.
    let array = "[[2,0],[3,1],[3,2],[2,3],[1,3],[0,2],[0,1],[1,0],[2,2.4e-16]]";
    let shown = read(&server, array).await;
    assert_eq!(shown["curve"]["closed"], true, "{shown:#}");
    assert!(shown["notices"][0].as_str().unwrap().contains("is closed"));
    let expected = input(&server, "", outline).await;
    assert_eq!(input(&server, "", array).await, expected);
    assert_eq!(input(&server, "?curve.closed=true", array).await, expected);
    // A trailing edge is an end.
    let wing = read(&server, "1 0\n.5 .06\n0 0\n.5 -.04\n1 0\n").await;
    assert_eq!(wing["curve"].get("closed"), None);
    assert_eq!(wing["curve"]["points"].as_array().unwrap().len(), 5);
}

#[tokio::test]
async fn errors_name_their_lines() {
    let server = Server::start().await;
    for path in ["/v1/points", "/v1/jobs"] {
        let response = send(&server, path, "text/csv", "x,y\n1,2\n\n3,oops\n4,5,6\n").await;
        let (status, answer) = problem(response).await;
        assert_eq!(
            (status, &answer["type"]),
            (422, &json!("/problems/invalid-fit"))
        );
        let expected = json!([
            {"line": 4, "detail": "column 2: \"oops\" is no number"},
            {"line": 5, "detail": "3 columns here, and 2 in the first line of numbers"},
        ]);
        assert_eq!(answer["errors"], expected, "{path}");
        assert!(
            answer["detail"]
                .as_str()
                .unwrap()
                .starts_with("line 4: column 2")
        );
        for (body, media_type, status) in [
            ("", "text/csv", 422),
            ("# nothing", "text/csv", 422),
            ("2948", "text/csv", 422),
            ("{\"curve\": {}}", "text/plain", 422),
            ("1,2\n3,4", "text/html", 415),
            ("1,2\n3,4", "text/csv; charset=utf-16", 415),
            ("\u{feff}1,2\n3", "text/csv", 422),
        ] {
            let response = send(&server, path, media_type, body).await;
            assert_eq!(problem(response).await.0, status, "{path} {body:?}");
        }
    }
    for size in ["3", "1x4", "axb", "3x"] {
        let response = send(
            &server,
            &format!("/v1/points?surface.size={size}"),
            "text/csv",
            WING,
        )
        .await;
        let (status, answer) = problem(response).await;
        assert_eq!(
            (status, &answer["errors"][0]["parameter"]),
            (400, &json!("surface.size"))
        );
    }
    let response = send(&server, "/v1/points?surface.size=2x2", "text/csv", WING).await;
    let (status, answer) = problem(response).await;
    assert_eq!(status, 422);
    assert!(
        answer["detail"]
            .as_str()
            .unwrap()
            .contains("5 points, which are not 2 rows of 2")
    );
}

/// Rows of heights and rows of points as JSON arrays are surfaces.
#[tokio::test]
async fn rows_in_arrays_are_surfaces() {
    let server = Server::start().await;
    let heights = json!([
        [1, 2, 3, 4, 3],
        [2, 3, 1, 2, 4],
        [1, 0, null, 2, 1],
        [3, 1, 2, 2, 2]
    ]);
    let shown = read(&server, &heights.to_string()).await;
    let row = &shown["surface"]["points"][2];
    assert_eq!(row, &json!([[1.0], [0.0], null, [2.0], [1.0]]), "{shown:#}");
    assert!(shown["notices"][0].as_str().unwrap().contains("heights"));
    let query = "?method.kind=least_squares&method.control_points=4";
    let job = input(&server, query, &heights.to_string()).await;
    assert_eq!(job["surface"]["points"][3][1], json!([1.0]), "{job:#}");
    let rows = json!([[[0, 0, 1], [0, 1, 2]], [[1, 0, 1], [1.5, 1, 0]]]);
    let job = input(&server, "?surface.degree=1", &rows.to_string()).await;
    assert_eq!(job["surface"]["points"][1][1], json!([1.5, 1.0, 0.0]));
    let ragged = "[[1,2,3,4],\n[1,2,3]]";
    let (status, answer) = problem(send(&server, "/v1/jobs", "text/csv", ragged).await).await;
    assert_eq!(
        (status, &answer["errors"][0]["line"]),
        (422, &json!(2)),
        "{answer:#}"
    );
}

/// The limits are those of jobs.
#[tokio::test]
async fn files_have_the_limits_of_jobs() {
    let server = Server::with(|config| {
        config.max_points = 10;
        config.max_body = bytesize::ByteSize(200);
    })
    .await;
    for path in ["/v1/points", "/v1/jobs"] {
        let response = send(&server, path, "text/csv", &"1,2\n".repeat(11)).await;
        let (status, answer) = problem(response).await;
        assert_eq!((status, &answer["errors"][0]["line"]), (422, &json!(11)));
        let response = send(&server, path, "text/csv", &"1,2\n".repeat(100)).await;
        assert_eq!(problem(response).await.0, 413);
    }
}

/// The query says what JSON says, and means the same.
#[tokio::test]
async fn files_are_fitted_like_json() {
    let server = Server::start().await;
    let mut job = read(&server, WING).await;
    job.as_object_mut().unwrap().remove("notices");
    let plain = server.fit(&job).await;
    let expected = server.json(&format!("{}/input", base(&plain))).await;
    assert_eq!(input(&server, "", WING).await, expected);

    job["name"] = json!("17");
    job["curve"]["degree"] = json!(2);
    job["curve"]["parameters"] = json!([0, 1, 2, 3, 4]);
    job["curve"]["ends"] = json!({"start": "natural", "end": {"tangent": [1, 0]}});
    job["curve"]["degree"] = json!(3);
    job["method"] = json!({"kind": "weighted", "omega": 0.5});
    job["stop"] = json!({"tolerance": 1e-4, "max_iterations": 50});
    let plain = server.fit(&job).await;
    let expected = server.json(&format!("{}/input", base(&plain))).await;
    let query = "?name=17&curve.degree=3&curve.parameters=%5B0,1,2,3,4%5D&curve.ends.start=natural&curve.ends.end.tangent=%5B1,0%5D&method.kind=weighted&method.omega=0.5&stop.tolerance=1e-4&stop.max_iterations=50";
    assert_eq!(input(&server, query, WING).await, expected);

    // A surface by its rows, by what is said, and scattered.
    let rows = input(&server, "", &field("")).await;
    assert_eq!(rows["surface"]["points"].as_array().unwrap().len(), 5);
    let sized = input(&server, "?surface.size=4x5&surface.degree=2", &field("")).await;
    assert_eq!(sized["surface"]["points"].as_array().unwrap().len(), 4);
    let curve = input(&server, "?curve.degree=2", &field("")).await;
    assert_eq!(curve["curve"]["points"].as_array().unwrap().len(), 20);
    let cloud = "0 0 0\n1 0.1 1\n2 0 0\n0 1 1\n1.1 1 2\n2 1.2 1\n0 2 0\n1 2 1\n2 2 0\n0.5 0.5 1\n1.5 1.5 1\n";
    let query = "?surface.parameters=project&surface.degree=1&method.kind=least_squares&method.control_points=2";
    let scattered = input(&server, query, cloud).await;
    assert_eq!(
        scattered["surface"]["scattered"].as_array().unwrap().len(),
        11
    );

    // Streams, too, with their own parameters beside.
    let request = server.post("/v1/jobs/stream?every=2&method=direct&encoding=base64");
    let request = request.header("content-type", "text/csv").body(WING);
    let story = Story::read(request.send().await.unwrap()).await;
    assert_eq!(story.state(), "converged");
}

/// Errors are located where the value was written: in a line, or in the query.
#[tokio::test]
async fn errors_of_jobs_have_locations() {
    let server = Server::start().await;
    let near = "# too near for chord lengths\n0,0\n1e17,1\n# another\n1e17,2\n2e17,0\n3e17,1\n";
    let response = send(&server, "/v1/jobs", "text/csv", near).await;
    let (status, answer) = problem(response).await;
    assert_eq!(
        (status, &answer["errors"][0]["line"]),
        (422, &json!(5)),
        "{answer:#}"
    );
    for (query, status, parameter) in [
        ("curve.degre=3", 422, "curve.degre"),
        ("curve.degree=three", 422, "curve.degree"),
        ("curve.degree=0", 422, "curve.degree"),
        ("method.kind=magic", 422, "method.kind"),
        ("stop.tolerance=-1", 422, "stop.tolerance"),
        ("shape=curve", 422, "shape"),
        ("curve=5", 422, "curve"),
        ("stop=5&stop.tolerance=1", 400, "stop.tolerance"),
        ("curve.degree=2&curve.degree=3", 400, "curve.degree"),
        ("curve..degree=2", 400, "curve..degree"),
        ("curve.points=%5B%5D", 400, "curve.points"),
        ("a.b.c.d.e.f.g.h=1", 400, "a.b.c.d.e.f.g.h"),
        ("surface.degree=2", 400, "surface.size"),
        ("surface.size=7", 400, "surface.size"),
        ("curve.degree=2&surface.degree=2", 422, "surface"),
        ("every=0", 400, "every"),
    ] {
        let response = send(
            &server,
            &format!("/v1/jobs/stream?{query}"),
            "text/csv",
            WING,
        )
        .await;
        assert_eq!(response.status(), status, "{query}");
        let (_, answer) = problem(response).await;
        let errors = answer["errors"].as_array().unwrap();
        assert!(
            errors.iter().any(|it| it["parameter"] == parameter),
            "{query}: {answer:#}"
        );
    }
    // Edits have no points of their own.
    let job = server.fit(&crate::data::small_job()).await;
    let response = send(&server, &format!("{}/edits", base(&job)), "text/csv", WING).await;
    assert_eq!(problem(response).await.0, 415);
}

/// The same key stands for the same file with the same query.
#[tokio::test]
async fn keys_know_the_query() {
    let server = Server::start().await;
    let post = async |query: &str| {
        let request = server.post(&format!("/v1/jobs{query}"));
        let request = request.header("content-type", "text/csv");
        let request = request.header("idempotency-key", "one").body(WING);
        request.send().await.unwrap()
    };
    let first: Value = post("?curve.degree=2").await.json().await.unwrap();
    let again: Value = post("?curve.degree=2").await.json().await.unwrap();
    assert_eq!(first["id"], again["id"]);
    let (status, answer) = problem(post("?curve.degree=3").await).await;
    assert_eq!(
        (status, &answer["type"]),
        (422, &json!("/problems/key-taken"))
    );
}

/// Browsers send plain texts for any page without asking; such a page makes no jobs.
#[tokio::test]
async fn pages_of_other_origins_create_no_jobs_without_permission() {
    let server = Server::start().await;
    for (origin, media_type, status) in [
        ("https://evil.example", "text/plain", 415),
        ("null", "text/plain", 415),
        (server.url.as_str(), "text/plain", 201),
        ("https://cad.example", "text/csv", 201),
    ] {
        let request = server.post("/v1/jobs").header("origin", origin);
        let request = request.header("content-type", media_type).body(WING);
        assert_eq!(request.send().await.unwrap().status(), status, "{origin}");
    }
}

/// Large files are shown whole, and do not keep others waiting.
#[tokio::test]
async fn large_files_are_shown() {
    let server = Server::start().await;
    let line = |i: u32| format!("{},{},{}\n", f64::from(i) * 0.1, i % 7, i % 11);
    let text: String = (0..100_000).map(line).collect();
    let shown = read(&server, &text).await;
    let points = shown["curve"]["points"].as_array().unwrap();
    assert_eq!(points.len(), 100_000);
    assert_eq!(points[99_999], json!([99_999.0 * 0.1, 4.0, 9.0]));
}

/// Two curves with a blank line between them.
const TWO: &str = "x,y\n0,0\n1,2\n2,1\n\n5,5\n6,7\n7,9\n8,6\n";

#[tokio::test]
async fn one_part_of_a_file_is_fitted() {
    let server = Server::start().await;
    for path in ["/v1/points", "/v1/jobs", "/v1/fit"] {
        for (query, detail) in [
            ("", "the file has 2 parts"),
            ("?part=3", "the file has parts 1 to 2"),
            ("?part=top", "no part of the file is called \"top\""),
        ] {
            let response = send(&server, &format!("{path}{query}"), "text/csv", TWO).await;
            let (status, answer) = problem(response).await;
            assert_eq!(status, 422, "{path}{query}");
            let error = &answer["errors"][0];
            assert_eq!(error["parameter"], "part", "{answer:#}");
            assert!(
                error["detail"].as_str().unwrap().starts_with(detail),
                "{answer:#}"
            );
        }
    }
    let second = input(&server, "?part=2", TWO).await;
    let expected = json!([[5.0, 5.0], [6.0, 7.0], [7.0, 9.0], [8.0, 6.0]]);
    assert_eq!(second["curve"]["points"], expected);
    let shown = send(&server, "/v1/points?part=2", "text/csv", TWO).await;
    let shown: Value = shown.json().await.unwrap();
    assert_eq!(shown["curve"]["points"], expected);
    assert!(shown["notices"][0].as_str().unwrap().contains("2 parts"));
}

/// The lines of an answer to a batch.
async fn lines_of(response: Response) -> Vec<Value> {
    let text = response.text().await.unwrap();
    let line = |line| serde_json::from_str(line).unwrap();
    text.lines().map(line).collect()
}

#[tokio::test]
async fn the_parts_of_a_file_are_a_batch() {
    let server = Server::start().await;
    let path = "/v1/batch?curve.degree=2&stop.tolerance=1e-9";
    let response = send(&server, path, "application/octet-stream", TWO).await;
    assert_eq!(response.status(), 200);
    let lines = lines_of(response).await;
    assert_eq!(lines.len(), 3);
    assert_eq!(lines[2]["totals"]["converged"], 2, "{lines:#?}");
    for (line, points) in lines.iter().zip([3, 4]) {
        assert_eq!(line["curve"]["degree"], 2);
        let parameters = line["curve"]["parameters"].as_array().unwrap();
        assert_eq!(parameters.len(), points);
    }
    // What was understood stands in the line of each part, also of one that fails.
    let ids = "id,x,y\n7,0,0\n8,1,2\n8,1,2\n9,2,1\n\n4,0,0\n6,1e17,0\n5,1e17,1\n";
    let items = lines_of(send(&server, "/v1/batch", "text/csv", ids).await).await;
    let notices = |item: &Value| item["notices"].as_array().unwrap().len();
    assert_eq!(items[1]["state"], "failed");
    assert_eq!(
        (notices(&items[0]), notices(&items[1])),
        (3, 2),
        "{items:#?}"
    );
    let column = "(id) is not read";
    for item in &items[..2] {
        assert!(item["notices"].to_string().contains(column), "{item}");
    }
    // Errors of a part are reported in its line.
    let near = TWO.replace("2,1\n", "1e17,0\n1e17,1\n");
    let text = send(&server, "/v1/batch", "text/csv", &near).await;
    let text = text.text().await.unwrap();
    let first: Value = serde_json::from_str(text.lines().next().unwrap()).unwrap();
    assert_eq!(first["state"], "failed", "{text}");
    let pointer = first["problem"]["errors"][0]["pointer"].as_str().unwrap();
    assert!(pointer.starts_with("/items/0/curve/points"), "{text}");
    assert!(text.contains("\"converged\":1"), "{text}");
    // And errors of the file instead of a response.
    for (query, status) in [
        ("?part=3", 422),
        ("?curve.degree=x", 200),
        ("?columns=", 400),
    ] {
        let response = send(&server, &format!("/v1/batch{query}"), "text/csv", TWO).await;
        assert_eq!(response.status(), status, "{query}");
    }
}

#[tokio::test]
async fn a_batch_is_one_file_on_request() {
    let server = Server::start().await;
    let ask = async |query: &str, format: &str, body: &str| {
        let request = server.post(&format!("/v1/batch{query}"));
        let request = request.header("content-type", "text/csv");
        let request = request.header("accept", format).body(body.to_owned());
        request.send().await.unwrap()
    };
    for (query, format, counted) in [
        ("", "image/vnd.dxf", "\nPOLYLINE\n"),
        ("?version=r2000", "image/vnd.dxf", "\nSPLINE\n"),
        ("", "model/step", "B_SPLINE_CURVE_WITH_KNOTS("),
        ("?style=path&curve.degree=2", "image/svg+xml", "<path "),
        ("?spacing=0.1", "application/geo+json", "\"LineString\""),
    ] {
        let response = ask(query, format, TWO).await;
        assert_eq!(response.status(), 200, "{format}");
        assert_eq!(response.headers()["content-type"], format);
        let text = response.text().await.unwrap();
        assert_eq!(text.matches(counted).count(), 2, "{text}");
    }
    let near = TWO.replace("2,1\n", "1e17,0\n1e17,1\n");
    for (query, format, body, status, detail) in [
        ("", "model/step", near.as_str(), 422, "part 1"),
        ("", "model/stl", TWO, 409, "stl"),
        ("", "application/gpx+xml", TWO, 400, "origin"),
        ("?style=path", "model/step", TWO, 400, "style"),
        ("", "image/png", TWO, 406, ""),
    ] {
        let (found, reported) = problem(ask(query, format, body).await).await;
        assert_eq!(found, status, "{format}: {reported:#}");
        let reported = reported["detail"].as_str().unwrap();
        assert!(reported.contains(detail), "{reported}");
    }
    // The items of a batch in JSON likewise.
    let curve = json!({"name": "wing", "curve": {"points": [[0, 0], [1, 2], [3, 3], [5, 2]]}});
    let request = server.post("/v1/batch").header("accept", "image/vnd.dxf");
    let response = request
        .json(&json!({"items": [curve]}))
        .send()
        .await
        .unwrap();
    assert!(response.text().await.unwrap().contains("\n  8\nwing\n"));
}
