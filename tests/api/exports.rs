//! Results and iterations as files, over HTTP. What stands in them is checked with the export itself,
//! and by other people's software.

use piad_files::export::{Format, check_shape};
use serde_json::{Value, json};

use crate::data;
use crate::support::{Server, problem};

fn path(job: &Value) -> &str {
    job["links"]["self"].as_str().unwrap()
}

async fn fetch(server: &Server, path: &str, format: Format) -> Vec<u8> {
    let by_path = server.get(&format!("{path}/{}", format.extension()));
    let by_header = server.get(path).header("accept", format.media_type());
    let mut files = Vec::new();
    for request in [by_path, by_header] {
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
            let surface = job["kind"] == "surface";
            if format == Format::Gpx || check_shape(format, surface, 3).is_err() {
                continue;
            }
            let file = fetch(&server, &result, format).await;
            let begins = match format {
                Format::Step => "ISO-10303-21;",
                Format::Iges => "",
                Format::Obj => "#",
                Format::Gltf => "glTF",
                Format::Stl => "piad",
                Format::Ply => "ply\n",
                Format::GeoJson | Format::Gpx => "{",
                Format::Dxf => "999\n",
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
async fn samples_have_the_requested_number() {
    let server = Server::start().await;
    let curve = server
        .fit(&json!({"curve": {"points": data::helix()}}))
        .await;
    let surface = server
        .fit(&json!({"surface": {"points": data::peaks(9)}}))
        .await;
    for (job, samples, lines) in [(&curve, "17", 17), (&surface, "4x5", 20)] {
        let csv = format!("{}/result/csv?samples={samples}", path(job));
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
async fn drawings_have_the_requested_samples() {
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
    let faces = |svg: &str| svg.matches(" stroke-width=\".5\"").count();
    for (job, samples, expected) in [
        (&curve, "2", 1),
        (&curve, "17", 16),
        (&curve, "5001", 5000),
        (&surface, "2x2", 1),
        (&surface, "4x5", 12),
        (&surface, "150x80", 149 * 79),
    ] {
        for part in ["result", "iterations/1"] {
            let svg = format!("{}/{part}/svg?samples={samples}", path(job));
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

fn dots(svg: &str) -> usize {
    let inside = svg.split("<svg width").nth(1).unwrap();
    let inside = inside.split("</svg>").next().unwrap();
    match inside.split_once("<g class=\"data\">") {
        Some((_, group)) => group
            .split("</g>")
            .next()
            .unwrap()
            .matches("<circle")
            .count(),
        None => inside.matches("<circle class=\"data\"").count(),
    }
}

/// Dots of dense data would hide the drawing: they are there on request, or where there is room.
#[tokio::test]
async fn drawings_show_data_points_where_there_is_room() {
    let server = Server::start().await;
    let few = json!({"surface": {"points": data::peaks(9)}});
    let many = json!({"surface": {"points": data::peaks(45)},
        "method": {"kind": "least_squares", "control_points": {"u": 9, "v": 9}}});
    let curve = json!({"curve": {"points": data::helix()}});
    for (job, count, auto) in [(few, 81, 81), (many, 45 * 45, 0), (curve, 30, 30)] {
        let job = server.fit(&job).await;
        for (choice, expected) in [
            ("", auto),
            ("?dots=auto", auto),
            ("?dots=on", count),
            ("?dots=off", 0),
        ] {
            let url = format!("{}/result/svg{choice}", path(&job));
            let svg = server.get(&url).send().await.unwrap().text().await.unwrap();
            assert_eq!(dots(&svg), expected, "{count}{choice}");
            assert_eq!(svg.contains(">data points</text>"), expected > 0);
        }
        for (query, parameter) in [
            ("/svg?dots=yes", "dots"),
            ("/svg?dots=", "dots"),
            ("/step?dots=on", "dots"),
            ("?dots=on", "dots"),
            ("/svg?samples=1001x1000", "samples"),
        ] {
            let url = format!("{}/result{query}", path(&job));
            let (status, problem) = problem(server.get(&url).send().await.unwrap()).await;
            assert_eq!(status, 400, "{query}");
            assert_eq!(problem["errors"][0]["parameter"], parameter, "{query}");
        }
    }
}

/// Colours show the distance at each data point; the legend goes up to the largest, which is the error.
#[tokio::test]
async fn drawings_show_how_far_the_data_are() {
    let server = Server::start().await;
    let rows = |count: usize| -> Vec<Value> {
        let place =
            |i: usize, j: usize| [i as f64, j as f64, f64::from(u8::from(i == 5 && j == 2))];
        (0..count)
            .map(|i| json!((0..9).map(|j| place(i, j)).collect::<Vec<_>>()))
            .collect()
    };
    let sparse = json!({"kind": "least_squares", "control_points": {"u": 4, "v": 4}});
    let mut gaps = rows(9);
    gaps[3][3] = Value::Null;
    let scattered: Vec<[f64; 3]> = (0..400)
        .map(|k| [f64::from(k % 20), f64::from(k / 20), f64::from(k % 7)])
        .collect();
    for job in [
        json!({"surface": {"points": rows(9)}, "method": sparse}),
        json!({"surface": {"points": gaps}, "method": sparse}),
        json!({"surface": {"scattered": scattered, "parameters": {"project": "xy"}}, "method": sparse}),
        json!({"curve": {"points": data::lemniscate()}, "stop": {"max_iterations": 2}}),
        json!({"curve": {"points": data::helix(), "basis": {"kind": "bernstein"}}, "stop": {"max_iterations": 2}}),
        json!({"curve": {"points": [[0, 0], [1, 1], [2, 0], [3, 5]], "basis": {"kind": "bspline", "degree": 1}}}),
    ] {
        let job = server.fit(&job).await;
        let result = server.json(&format!("{}/result", path(&job))).await;
        let error = result["error"]["max"].as_f64().unwrap();
        let url = format!("{}/result/svg", path(&job));
        let svg = server.get(&url).send().await.unwrap().text().await.unwrap();
        if error == 0.0 {
            assert!(!svg.contains("class=\"legend\""));
            continue;
        }
        let legend = svg.split("class=\"legend\"").nth(1).unwrap();
        let last = legend.split("text-anchor=\"middle\">").nth(5).unwrap();
        let text = last.split('<').next().unwrap();
        let (mantissa, power) = text.split_once("·10").unwrap_or((text, ""));
        let power = power.replace('⁻', "-");
        let digits = power.chars().map(|c| match c {
            '-' => '-',
            '¹' => '1',
            '²' => '2',
            '³' => '3',
            c => char::from_digit(u32::from(c) - 0x2070, 10).unwrap(),
        });
        let power: i32 = digits.collect::<String>().parse().unwrap_or(0);
        let most = mantissa.parse::<f64>().unwrap() * 10_f64.powi(power);
        assert!((most - error).abs() < 0.06 * error, "{most} {error}");
        assert!(svg.contains("@media (prefers-color-scheme:dark)"));
    }
}

/// Triangles and vertices of meshes are as many as the samples give, down to the least there can be.
#[tokio::test]
async fn meshes_have_the_requested_samples() {
    let server = Server::start().await;
    let peaks = server
        .fit(&json!({"surface": {"points": data::peaks(9)}}))
        .await;
    let line = server
        .fit(&json!({"curve": {"points": [[0, 0], [3, 4]], "basis": {"kind": "bernstein"}}}))
        .await;
    let helix = server
        .fit(&json!({"curve": {"points": data::helix()}}))
        .await;
    let get = async |job: &Value, file: &str| {
        let url = format!("{}/result/{file}", path(job));
        server.get(&url).send().await.unwrap()
    };
    for (samples, rows, columns) in [("2x2", 2, 2), ("4x7", 4, 7), ("256x2", 256, 2)] {
        let stl = get(&peaks, &format!("stl?samples={samples}"))
            .await
            .bytes()
            .await
            .unwrap();
        let count = u32::from_le_bytes(stl[80..84].try_into().unwrap()) as usize;
        assert_eq!(count, 2 * (rows - 1) * (columns - 1), "{samples}");
        assert_eq!(stl.len(), 84 + 50 * count);
        let dxf = get(&peaks, &format!("dxf?samples={samples}"))
            .await
            .text()
            .await
            .unwrap();
        let vertices = dxf.matches("\nVERTEX\n").count();
        assert!(
            vertices >= rows * columns && dxf.contains("\n 71\n"),
            "{samples}"
        );
    }
    for (job, file, vertices, spatial) in [
        (&line, "dxf?samples=2", 2, false),
        (&helix, "dxf?samples=1500", 1500, true),
    ] {
        let dxf = get(job, file).await.text().await.unwrap();
        assert_eq!(dxf.matches("\nVERTEX\n").count(), vertices);
        assert_eq!(dxf.contains("\n 70\n8\n"), spatial);
    }
    let (status, problem) = problem(get(&peaks, "dxf?samples=257x3").await).await;
    assert_eq!(status, 409);
    assert!(
        problem["detail"].as_str().unwrap().contains("at most 256"),
        "{problem}"
    );
}

/// Files declare the requested unit; their coordinates are the same in each.
#[tokio::test]
async fn units_are_declared() {
    let server = Server::start().await;
    for job in [
        json!({"curve": {"points": data::helix()}}),
        json!({"surface": {"points": data::peaks(9)}}),
    ] {
        let job = server.fit(&job).await;
        let file = async |name: &str| {
            let url = format!("{}/result/{name}", path(&job));
            server.get(&url).send().await.unwrap().text().await.unwrap()
        };
        let millimetres = file("step").await;
        assert!(millimetres.contains("#10=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.));"));
        assert_eq!(file("step?units=mm").await, millimetres);
        let points = |text: &str| text.split_once("#22=").unwrap().1.to_owned();
        for (unit, declared) in [
            ("m", "#10=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT($,.METRE.));"),
            (
                "in",
                "#10=(CONVERSION_BASED_UNIT('INCH',#20)LENGTH_UNIT()NAMED_UNIT(#21));",
            ),
        ] {
            let step = file(&format!("step?units={unit}")).await;
            assert!(step.contains(declared), "{unit}");
            assert_eq!(points(&step), points(&millimetres), "{unit}");
        }
        for (unit, declared) in [("mm", ",2,2HMM,"), ("m", ",6,1HM,"), ("in", ",1,2HIN,")] {
            let iges = file(&format!("iges?units={unit}")).await;
            let global = iges.lines().filter(|line| &line[72..73] == "G");
            let global: String = global.map(|line| line[..72].trim_end()).collect();
            assert!(global.contains(declared), "{global}");
        }
        for query in [
            "/step?units=cm",
            "/obj?units=mm",
            "/gltf?units=m",
            "/svg?units=in",
            "/csv?units=mm",
            "/stl?units=mm",
            "/dxf?units=mm",
            "?units=mm",
        ] {
            let url = format!("{}/result{query}", path(&job));
            let (status, problem) = problem(server.get(&url).send().await.unwrap()).await;
            assert_eq!(status, 400, "{query}");
            assert_eq!(problem["errors"][0]["parameter"], "units", "{query}");
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
    let svg = format!("{}/result/svg", path(&job));
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
        (&steep, "stl", "a curve has none"),
        (&values, "dxf", "one coordinate"),
    ] {
        let url = format!("{}/result/{format}", path(job));
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
        ("?format=step", "format"),
        ("/svg?view=errors", "view"),
        ("/csv?encoding=base64", "encoding"),
        ("/csv?digits=auto", "digits"),
        ("/csv?samples=1", "samples"),
        ("/csv?samples=3x3", "samples"),
    ] {
        let url = format!("{}/result{query}", path(&steep));
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
        let others = [Format::Stl, Format::Ply, Format::Gpx];
        for format in Format::ALL.into_iter().filter(|it| !others.contains(it)) {
            let ending = format.extension();
            let exact = exact.trim_end_matches(&format!(".{ending}")).to_owned();
            let ascii = ascii.trim_end_matches(&format!(".{ending}")).to_owned();
            for (part, number) in [("result", ""), ("iterations/3", "-3")] {
                let found = disposition(format!("{}/{part}/{ending}", path(&job))).await;
                let expected = format!(
                    "inline; filename=\"{ascii}{number}.{ending}\"; filename*=UTF-8''{exact}{number}.{ending}"
                );
                assert_eq!(found, expected, "{name:?}");
            }
        }
    }
    // JSON and messages are kept in files, too.
    let job = named(Some("Flügel")).await;
    for (part, file) in [
        ("result", "Fl%C3%BCgel.json"),
        ("iterations/3?encoding=base64", "Fl%C3%BCgel-3.json"),
        ("input", "Fl%C3%BCgel-input.json"),
    ] {
        let found = disposition(format!("{}/{part}", path(&job))).await;
        assert!(
            found.ends_with(&format!("filename*=UTF-8''{file}")),
            "{found}"
        );
    }
    for name in [None, Some("…/…"), Some(".."), Some("")] {
        let job = named(name).await;
        let found = disposition(format!("{}/result/step", path(&job))).await;
        let file = match name {
            Some("…/…") => "___".to_owned(),
            _ => format!("piad-{}", job["id"].as_str().unwrap()),
        };
        assert!(
            found.contains(&format!("filename=\"{file}.step\"")),
            "{found}"
        );
    }
}

#[tokio::test]
async fn files_follow_the_options() {
    let server = Server::start().await;
    let curve = server
        .fit(&json!({"curve": {"points": data::helix()}}))
        .await;
    let surface = server
        .fit(&json!({"surface": {"points": data::peaks(9)}}))
        .await;
    let get = async |job: &Value, file: &str| {
        let address = format!("{}/result/{file}", path(job));
        server.get(&address).send().await.unwrap()
    };
    for (file, counted, count) in [
        ("svg?style=path", "<path ", 1),
        ("dxf?version=r2000", "\nSPLINE\n", 1),
        ("dxf?version=r12&samples=50", "\nVERTEX\n", 50),
        ("geojson?by=length&samples=20&origin=48.1,11.5", "],[", 19),
        ("gpx?origin=48.1,11.5&samples=30", "<trkpt", 30),
    ] {
        let response = get(&curve, file).await;
        let status = response.status();
        let text = response.text().await.unwrap();
        assert_eq!(status, 200, "{file}: {text}");
        assert_eq!(text.matches(counted).count(), count, "{file}: {text}");
    }
    for (job, file, parameter) in [
        (&curve, "gpx", "origin"),
        (&curve, "gpx?origin=91,0", "origin"),
        (&curve, "gpx?origin=north", "origin"),
        (&curve, "csv?spacing=0", "spacing"),
        (&curve, "csv?spacing=1e-9", "spacing"),
        (&curve, "csv?spacing=few", "spacing"),
        (&curve, "csv?by=angle", "by"),
        (&curve, "step?spacing=1", "spacing"),
        (&curve, "csv?style=path", "style"),
        (&curve, "svg?style=plain", "style"),
        (&curve, "svg?version=r2000", "version"),
        (&surface, "csv?by=length", "spacing"),
        (&curve, "?style=path", "style"),
    ] {
        let file = file.to_owned();
        let address = match file.strip_prefix('?') {
            Some(query) => format!("{}/result?{query}", path(job)),
            None => format!("{}/result/{file}", path(job)),
        };
        let (status, reported) = problem(server.get(&address).send().await.unwrap()).await;
        assert!(status == 400 || status == 409, "{file}: {reported:#}");
        if status == 400 {
            assert_eq!(
                reported["errors"][0]["parameter"], parameter,
                "{file}: {reported:#}"
            );
        }
    }
}
