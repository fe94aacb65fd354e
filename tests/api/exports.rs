//! Results and iterations as files, over HTTP. What stands in them is checked with the export itself,
//! and by other people's software.

use piad::export::Format;
use serde_json::{Value, json};

use crate::data;
use crate::support::{Server, problem};

fn path(job: &Value) -> &str {
    job["links"]["self"].as_str().unwrap()
}

async fn fetch(server: &Server, path: &str, format: Format) -> Vec<u8> {
    let by_parameter = server.get(&format!("{path}?format={}", format.extension()));
    let by_header = server.get(path).header("accept", format.media_type());
    let mut files = Vec::new();
    for request in [by_parameter, by_header] {
        let response = request.send().await.unwrap();
        assert_eq!(response.status(), 200, "{path} {format}");
        assert_eq!(response.headers()["content-type"], format.media_type());
        let disposition = response.headers()["content-disposition"].to_str().unwrap();
        let ending = format!(".{}", format.extension());
        assert!(
            disposition.contains(&format!("{ending}\"; ")),
            "{disposition}"
        );
        assert!(disposition.ends_with(&ending), "{disposition}");
        files.push(response.bytes().await.unwrap().to_vec());
    }
    assert_eq!(files[0], files[1], "the same level is the same file");
    files.remove(0)
}

#[tokio::test]
async fn every_format_of_curves_and_surfaces() {
    let server = Server::start().await;
    let curve = json!({"name": "wing ⟨α⟩", "curve": {"points": data::helix()}});
    let surface = json!({"surface": {"points": data::peaks(9)}});
    for job in [curve, surface] {
        let job = server.fit(&job).await;
        let result = format!("{}/result", path(&job));
        for format in Format::ALL {
            let file = fetch(&server, &result, format).await;
            let begins = match format {
                Format::Step => "ISO-10303-21;",
                Format::Iges => "",
                Format::Obj => "#",
                Format::Gltf => "glTF",
                Format::Svg => "<?xml",
                Format::Csv => "",
            };
            assert!(file.starts_with(begins.as_bytes()), "{format}");
            assert!(file.len() > 500, "{format}");
        }
    }
}

/// Files hold the very numbers of the JSON, of any iteration.
#[tokio::test]
async fn files_have_the_numbers_of_the_iteration() {
    let server = Server::start().await;
    let job = server
        .fit(&json!({"curve": {"points": data::helix()}}))
        .await;
    for k in ["0", "3", "last"] {
        let level = format!("{}/iterations/{k}", path(&job));
        let frame = server.json(&level).await;
        let step = fetch(&server, &level, Format::Step).await;
        let step = String::from_utf8(step).unwrap();
        let obj = String::from_utf8(fetch(&server, &level, Format::Obj).await).unwrap();
        let vertices: Vec<Vec<f64>> = obj
            .lines()
            .filter_map(|line| line.strip_prefix("v "))
            .map(|line| line.split(' ').map(|x| x.parse().unwrap()).collect())
            .collect();
        let points = frame["control_points"].as_array().unwrap();
        assert_eq!(json!(vertices), json!(points));
        for point in points {
            let x = point[0].as_f64().unwrap();
            let written = format!("{x:E}");
            let digits = written.split(['E', '.', '-']).next().unwrap();
            assert!(step.contains(digits), "{x}");
        }
        assert!(step.matches("CARTESIAN_POINT").count() >= points.len());
    }
}

#[tokio::test]
async fn samples_are_as_many_as_asked_for() {
    let server = Server::start().await;
    let curve = server
        .fit(&json!({"curve": {"points": data::helix()}}))
        .await;
    let surface = server
        .fit(&json!({"surface": {"points": data::peaks(9)}}))
        .await;
    for (job, samples, lines) in [(&curve, "17", 17), (&surface, "4x5", 20)] {
        let csv = format!("{}/result?format=csv&samples={samples}", path(job));
        let csv = server.get(&csv).send().await.unwrap().text().await.unwrap();
        assert_eq!(csv.lines().count(), lines + 1, "a line for the names");
        let wanted = format!("{}/result?view=samples&samples={samples}", path(job));
        let wanted = server.json(&wanted).await;
        let last = csv
            .lines()
            .last()
            .unwrap()
            .split(',')
            .map(|x| x.parse::<f64>().unwrap());
        let last: Vec<f64> = last.collect();
        let mut expected = wanted["samples"]
            .as_array()
            .unwrap()
            .last()
            .unwrap()
            .clone();
        if let Some(point) = expected
            .as_array()
            .unwrap()
            .last()
            .filter(|it| it.is_array())
        {
            expected = point.clone();
        }
        let parameters = last.len() - 3;
        assert_eq!(json!(last[parameters..]), expected);
    }
}

/// A drawing goes through the samples: pieces of a curve between them, faces of a surface.
#[tokio::test]
async fn drawings_have_as_many_samples_as_asked_for() {
    let server = Server::start().await;
    let curve = server
        .fit(&json!({"curve": {"points": data::helix()}}))
        .await;
    let surface = server
        .fit(&json!({"surface": {"points": data::peaks(9)}}))
        .await;
    let pieces = |svg: &str| {
        let path = svg.split("<path class=\"curve\" d=\"").nth(1).unwrap();
        path.split('"').next().unwrap().matches('C').count()
    };
    // Besides faces only the background has a colour of its own.
    let faces = |svg: &str| svg.matches(" fill=\"#").count() - 1;
    for (job, samples, expected) in [
        (&curve, "2", 1),
        (&curve, "17", 16),
        (&curve, "5001", 5000),
        (&surface, "2x2", 1),
        (&surface, "4x5", 12),
        (&surface, "150x80", 149 * 79),
    ] {
        for part in ["result", "iterations/1"] {
            let svg = format!("{}/{part}?format=svg&samples={samples}", path(job));
            let text = server.get(&svg).send().await.unwrap().text().await.unwrap();
            let drawn = if job["kind"] == "curve" {
                pieces(&text)
            } else {
                faces(&text)
            };
            assert_eq!(drawn, expected, "{part} {samples}");
        }
    }
}

/// Drawings show how the error has fallen, where that can be computed in a moment.
#[tokio::test]
async fn drawings_have_the_history_of_the_error() {
    let server = Server::start().await;
    let job = server
        .fit(&json!({"curve": {"points": data::lemniscate()}}))
        .await;
    let svg = format!("{}/result?format=svg", path(&job));
    let text = server.get(&svg).send().await.unwrap().text().await.unwrap();
    assert!(text.contains("iteration"), "{text}");
    assert_eq!(text.matches("<svg").count(), text.matches("</svg>").count());
}

#[tokio::test]
async fn what_cannot_be_written_is_said() {
    let server = Server::start().await;
    let values = server
        .fit(&json!({"curve": {"points": [[0], [2], [1], [3]], "parameters": "uniform"}}))
        .await;
    let steep = json!({"curve": {"points": data::helix(), "basis": {"kind": "bernstein"}},
        "method": {"kind": "direct"}});
    let steep = server.fit(&steep).await;
    for (job, format, reason) in [
        (&values, "step", "one coordinate"),
        (&values, "svg", "one coordinate"),
        (&steep, "step", "degree is 29"),
        (&steep, "igs", "degree is 29"),
    ] {
        let url = format!("{}/result?format={format}", path(job));
        let (status, problem) = problem(server.get(&url).send().await.unwrap()).await;
        assert_eq!(
            (status, problem["type"].as_str()),
            (409, Some("/problems/no-export"))
        );
        let detail = problem["detail"].as_str().unwrap();
        assert!(detail.contains(reason), "{detail}");
    }
    // Values of a function are numbers all the same, and other formats take any degree.
    fetch(&server, &format!("{}/result", path(&values)), Format::Csv).await;
    fetch(&server, &format!("{}/result", path(&steep)), Format::Obj).await;

    for (query, parameter) in [
        ("format=dwg", "format"),
        ("format=STEP", "format"),
        ("format=svg&view=errors", "view"),
        ("format=csv&encoding=base64", "encoding"),
        ("format=csv&digits=auto", "digits"),
        ("format=csv&samples=1", "samples"),
        ("format=csv&samples=3x3", "samples"),
    ] {
        let url = format!("{}/result?{query}", path(&steep));
        let (status, problem) = problem(server.get(&url).send().await.unwrap()).await;
        assert_eq!(status, 400, "{query}");
        assert_eq!(problem["errors"][0]["parameter"], parameter, "{query}");
    }
    let request = server.get(&format!("{}/result", path(&steep)));
    let (status, problem) =
        problem(request.header("accept", "image/png").send().await.unwrap()).await;
    assert_eq!(status, 406);
    let detail = problem["detail"].as_str().unwrap();
    assert!(detail.contains("model/step"), "{detail}");
}

/// Files are called like their job, whatever that is called, and never like a path or a header.
#[tokio::test]
async fn downloads_are_named_after_the_job() {
    let server = Server::start().await;
    let named = async |name: Option<&str>| {
        let mut job = json!({"curve": {"points": data::helix()}});
        if let Some(name) = name {
            job["name"] = json!(name);
        }
        server.fit(&job).await
    };
    let disposition = async |path: String| {
        let response = server.get(&path).send().await.unwrap();
        assert_eq!(response.status(), 200, "{path}");
        assert!(response.headers().get("set-cookie").is_none());
        let values = response.headers().get_all("content-disposition");
        assert_eq!(values.iter().count(), 1);
        response.headers()["content-disposition"]
            .to_str()
            .unwrap()
            .to_owned()
    };
    for (name, ascii, exact) in [
        ("naca2412", "naca2412", "naca2412"),
        ("Flügel 翼", "Fl_gel _", "Fl%C3%BCgel%20%E7%BF%BC"),
        ("../../etc/passwd", "_.._etc_passwd", "_.._etc_passwd"),
        (
            "a\"\r\nSet-Cookie: b",
            "a___Set-Cookie_ b",
            "a___Set-Cookie_%20b",
        ),
        ("wing.obj", "wing.obj", "wing.obj"),
    ] {
        let job = named(Some(name)).await;
        for format in Format::ALL {
            let ending = format.extension();
            let exact = exact.trim_end_matches(&format!(".{ending}")).to_owned();
            let ascii = ascii.trim_end_matches(&format!(".{ending}")).to_owned();
            for (part, number) in [("result", ""), ("iterations/3", "-3")] {
                let found = disposition(format!("{}/{part}?format={ending}", path(&job))).await;
                let expected = format!(
                    "inline; filename=\"{ascii}{number}.{ending}\"; filename*=UTF-8''{exact}{number}.{ending}"
                );
                assert_eq!(found, expected, "{name:?}");
            }
        }
    }
    for name in [None, Some("…/…"), Some(".."), Some("")] {
        let job = named(name).await;
        let found = disposition(format!("{}/result?format=step", path(&job))).await;
        let file = match name {
            Some("…/…") => "___".to_owned(),
            _ => format!("curve-{}", job["id"].as_str().unwrap()),
        };
        assert!(
            found.contains(&format!("filename=\"{file}.step\"")),
            "{found}"
        );
    }
}
