//! What is accepted but doubtful: it is said in the job and in its event stream, and what an end means.

use std::f64::consts::PI;

use serde_json::{Value, json};

use crate::messages as pb;
use crate::rpc::connect;
use crate::support::{Server, Story, base};

/// A planar curve through points of a wave.
fn curve(count: usize, basis: &Value) -> Value {
    let points: Vec<[f64; 2]> = (0..count)
        .map(|i| [i as f64, (i as f64 * 0.9).sin()])
        .collect();
    json!({"curve": {"points": points, "basis": basis}})
}

fn surface(rows: usize, columns: usize, basis: &Value) -> Value {
    let row = |i: usize| -> Vec<[f64; 3]> {
        (0..columns)
            .map(|j| [i as f64, j as f64, (i as f64 + 0.7 * j as f64).sin()])
            .collect()
    };
    let points: Vec<_> = (0..rows).map(row).collect();
    json!({"surface": {"points": points, "basis": basis}})
}

/// The codes and pointers of the warnings of a job or of its event.
fn warnings(job: &Value) -> Vec<(String, String)> {
    let texts = |name: &str, it: &Value| it[name].as_str().unwrap().to_owned();
    let all = job["warnings"].as_array().unwrap().iter();
    // What is found out at the end of a fit has tests of its own.
    let all = all.filter(|it| it["code"] != "between_points");
    all.map(|it| {
        assert!(!texts("detail", it).is_empty());
        (texts("code", it), texts("pointer", it))
    })
    .collect()
}

fn expect(job: &Value, expected: &[(&str, &str)]) {
    let found = warnings(job);
    let found: Vec<_> = found
        .iter()
        .map(|(a, b)| (a.as_str(), b.as_str()))
        .collect();
    assert_eq!(found, expected, "{job:#}");
}

/// The job, its event and whatever follows say the same, and the pointer leads somewhere.
async fn expect_everywhere(server: &Server, job: &Value, expected: &[(&str, &str)]) -> Story {
    let created = server.fit(job).await;
    expect(&created, expected);
    let path = base(&created).to_owned();
    let input = server.json(&format!("{path}/input")).await;
    for (_, pointer) in expected {
        assert!(input.pointer(pointer).is_some(), "{pointer}: {input:#}");
    }
    let listed = server.json("/v1/jobs?limit=1").await;
    expect(&listed["jobs"][0], expected);
    let events = server.get(&format!("{path}/events"));
    let story = Story::read(events.send().await.unwrap()).await;
    expect(&story.job, expected);
    story
}

#[tokio::test]
async fn degrees_that_few_points_do_not_deserve_are_warned_of() {
    let server = Server::start().await;
    let degree = |degree: usize| json!({"kind": "bspline", "degree": degree});
    let few = ("few_points", "/curve/basis/degree");
    let repeated = |count: usize, of: usize| {
        let mut job = curve(count, &degree(of));
        job["curve"]["ends"] = json!("repeated");
        job
    };
    expect_everywhere(&server, &repeated(3, 5), &[few]).await;
    expect_everywhere(&server, &repeated(5, 5), &[few]).await;
    expect_everywhere(&server, &repeated(6, 5), &[]).await;
    let even = ("even_degree", "/curve/basis/degree");
    // Averaged knots are usual, but for so few points.
    expect_everywhere(&server, &repeated(4, 4), &[few]).await;
    expect_everywhere(&server, &curve(9, &degree(4)), &[]).await;
    let at_data = json!({"kind": "bspline", "degree": 4, "knots": "data"});
    expect_everywhere(&server, &curve(9, &at_data), &[even]).await;
    // Midway between the parameters, and averaged, knots of even degree are at their best.
    let mut closed = curve(9, &degree(4));
    closed["curve"]["closed"] = json!(true);
    expect_everywhere(&server, &closed, &[]).await;
    let averaged = json!({"kind": "bspline", "degree": 4, "knots": "averaged"});
    expect_everywhere(&server, &curve(9, &averaged), &[]).await;
    expect_everywhere(&server, &curve(9, &json!({"kind": "bernstein"})), &[]).await;
    // Nor are the knots of fewer control points at the data (Piegl & Tiller (9.68)).
    let mut fewer = curve(9, &degree(4));
    fewer["method"] = json!({"kind": "least_squares", "control_points": 6});
    expect_everywhere(&server, &fewer, &[]).await;

    let story = expect_everywhere(&server, &repeated(3, 5), &[few]).await;
    let detail = story.job["warnings"][0]["detail"].as_str().unwrap();
    assert!(detail.contains("use at most degree 2"), "{detail}");
    assert!(detail.contains("\"estimated\""), "{detail}");
    let mut one = curve(3, &degree(5));
    one["curve"]["ends"] = json!({"start": "repeated", "end": "estimated"});
    expect_everywhere(&server, &one, &[few]).await;
}

/// Estimated ends have no copies: two points give a line, and others the polynomial through them.
#[tokio::test]
async fn perfect_fits_of_few_points_have_no_warning() {
    let server = Server::start().await;
    for count in 2..6 {
        let points: Vec<[f64; 2]> = (0..count)
            .map(|i| [f64::from(i), f64::from(i * i)])
            .collect();
        for degree in [3, 4, 5] {
            let job = json!({
                "curve": {"points": points, "degree": degree, "parameters": "uniform"},
                "method": "direct",
            });
            let story = expect_everywhere(&server, &job, &[]).await;
            assert_eq!(story.state(), "converged");
            let path = base(&story.job).to_owned();
            let samples = format!("{path}/iterations/last?view=samples&samples=9");
            let curve = server.json(&samples).await;
            for sample in curve["samples"].as_array().unwrap() {
                let (x, y) = (sample[0].as_f64().unwrap(), sample[1].as_f64().unwrap());
                let expected = if count == 2 { x } else { x * x };
                assert!((y - expected).abs() < 1e-9, "{count} {degree} {sample}");
            }
        }
    }
}

#[tokio::test]
async fn warnings_of_surfaces_name_the_direction() {
    let server = Server::start().await;
    let both = json!({"kind": "bspline", "degree": 5});
    let of_both = ("few_points", "/surface/basis/degree");
    let mut few = surface(4, 9, &both);
    few["surface"]["ends"] = json!("repeated");
    expect_everywhere(&server, &few, &[of_both]).await;
    expect_everywhere(&server, &surface(4, 9, &both), &[]).await;
    let each = json!({"u": {"kind": "bspline", "degree": 3}, "v": {"kind": "bspline", "degree": 4, "knots": "data"}});
    let of_v = ("even_degree", "/surface/basis/v/degree");
    expect_everywhere(&server, &surface(7, 8, &each), &[of_v]).await;
}

/// 36 points of a Bézier curve: intermediate errors of 1e70 leave nothing of the data.
#[tokio::test]
async fn extended_fits_that_rounding_spoils_are_warned_of() {
    let server = Server::start().await;
    let job = |count: usize| {
        let points: Vec<[f64; 2]> = (0..count)
            .map(|i| i as f64 * 2.0 * PI / (count - 1) as f64)
            .map(|a| [a.cos(), a.sin() * a.cos()])
            .collect();
        json!({
            "curve": {"points": points, "basis": {"kind": "bernstein"}, "parameters": "uniform"},
            "method": {"kind": "extended"},
        })
    };
    let story = expect_everywhere(&server, &job(36), &[("rounding", "/method")]).await;
    assert_eq!(story.end["reason"], "nilpotent");
    let left = story.end["error"]["max"].as_f64().unwrap();
    assert!(left > 1e10, "{left}");
    let detail = story.end["detail"].as_str().unwrap();
    assert!(detail.contains(&format!("{left:.3e}")), "{detail}");
    assert!(detail.contains("use direct"), "{detail}");

    let story = expect_everywhere(&server, &job(11), &[]).await;
    assert_eq!(
        (story.state(), &story.end["detail"]),
        ("converged", &Value::Null)
    );
}

/// Fits without the warning reach the tolerance, for all sizes and bases; fits with it do not.
#[tokio::test]
async fn extended_fits_get_there_unless_they_are_warned_of() {
    let server = Server::start().await;
    let bases = [
        json!({"kind": "bspline", "degree": 3}),
        json!({"kind": "bspline", "degree": 5}),
        json!({"kind": "bernstein"}),
        json!({"kind": "wang_ball"}),
    ];
    for basis in &bases {
        for count in [6, 12, 20, 30, 60, 150, 400] {
            let mut job = curve(count, basis);
            job["method"] = json!({"kind": "extended"});
            job["stop"] = json!({"relative_tolerance": 1e-9});
            let ended = server.fit(&job).await;
            let warned = warnings(&ended).iter().any(|(code, _)| code == "rounding");
            assert_eq!(
                warned,
                ended["state"] != "converged",
                "{basis} {count}: {ended:#}"
            );
        }
    }
}

#[tokio::test]
async fn messages_have_warnings_with_fields() {
    let server = Server::start().await;
    let repeated = pb::End {
        rule: pb::EndRule::Repeated.into(),
        ..pb::End::default()
    };
    let ends = pb::Ends {
        start: Some(repeated.clone()),
        end: Some(repeated),
    };
    let input = pb::JobInput {
        geometry: Some(pb::job_input::Geometry::Surface(pb::Surface {
            dimension: 1,
            rows: 3,
            columns: 4,
            points: (0..12).map(f64::from).collect(),
            u: Some(pb::SurfaceDirection {
                ends: Some(ends),
                ..pb::SurfaceDirection::default()
            }),
            ..pb::Surface::default()
        })),
        ..pb::JobInput::default()
    };
    let mut client = connect(&server).await;
    let request = pb::CreateJobRequest {
        input: Some(input),
        ..pb::CreateJobRequest::default()
    };
    let job = client
        .create_job(request)
        .await
        .unwrap()
        .into_inner()
        .job
        .unwrap();
    let warning = &job.warnings[0];
    assert_eq!(job.warnings.len(), 1);
    assert_eq!(warning.code(), pb::WarningCode::FewPoints);
    assert_eq!(warning.field, "surface.u.basis.degree");
    assert!(warning.detail.contains("3 points"), "{}", warning.detail);
}

/// The largest rise of a fit's distances, its job and its end.
async fn rise(server: &Server, job: &Value) -> (f64, Story) {
    let mut job = job.clone();
    job["stream"] = json!({"view": "errors"});
    let story = server.stream(&job).await;
    let errors = story.iterations.iter().map(|it| &it["error"]["max"]);
    let errors: Vec<f64> = errors.map(|max| max.as_f64().unwrap()).collect();
    let largest = errors.iter().copied().fold(0.0, f64::max);
    (largest / errors[0], story)
}

/// Points whose distances differ by four orders of magnitude.
fn uneven(count: usize) -> Vec<[f64; 2]> {
    let steps = (0..count).map(|i| 10_f64.powf(2.0 * (i as f64 * 2.3).sin()));
    let places = steps.scan(0.0, |x, step| {
        *x += step;
        Some(*x)
    });
    places
        .enumerate()
        .map(|(i, x)| [x, (i as f64 * 1.7).sin()])
        .collect()
}

/// With steps by the least eigenvalue the distances of these fits rise by 1e13 to 1e88.
#[tokio::test]
async fn chebyshev_steps_keep_distances_low() {
    let server = Server::start().await;
    let job = |points: Value, basis: Value| {
        json!({
            "curve": {"points": points, "basis": basis}, "method": {"kind": "chebyshev"},
            "stop": {"relative_tolerance": 1e-9, "max_iterations": 400},
        })
    };
    // Many eigenvalues nearly coincide where even degrees have their knots at the data.
    let wave = |count: usize| curve(count, &Value::Null)["curve"]["points"].clone();
    let mut jobs = Vec::new();
    for degree in [4, 6, 8] {
        let basis = json!({"kind": "bspline", "degree": degree, "knots": "data"});
        jobs.push((true, job(wave(400), basis.clone())));
        jobs.push((true, job(json!(uneven(200)), basis)));
    }
    // Those that did well before do as well now.
    for degree in [2, 3, 5] {
        let basis = json!({"kind": "bspline", "degree": degree, "knots": "data"});
        jobs.push((false, job(wave(50), basis)));
    }
    jobs.push((
        false,
        job(
            wave(300),
            json!({"kind": "bspline", "degree": 6, "knots": "averaged"}),
        ),
    ));
    for (warned, job) in jobs {
        let (rise, story) = rise(&server, &job).await;
        // The residual stays within a hundred times that of level 0, distances a little above.
        assert!(rise < 1e3, "{rise} {}", job["curve"]["basis"]);
        let codes = warnings(&story.job);
        let found = codes.iter().any(|(code, _)| code == "shorter_interval");
        assert_eq!(found, warned, "{} {codes:?}", job["curve"]["basis"]);
        if !warned {
            // Of these, degree 2 with its knots at the data swings between them.
            let swings = job["curve"]["basis"]["degree"] == 2;
            let reason = if swings {
                json!("between")
            } else {
                Value::Null
            };
            assert_eq!(story.end["reason"], reason, "{}", story.end);
        }
    }

    // Nearly singular: points hardly meet the supports of their functions, `u_i < t_i < u_{i+4}`.
    let mut knots = vec![0.0; 4];
    knots.extend((0..16).map(|i| f64::from(i) / 19.0 + 1e-6));
    knots.extend([1.0; 4]);
    let basis = json!({"kind": "bspline", "degree": 3, "knots": knots});
    let mut singular = job(wave(20), basis);
    singular["curve"]["parameters"] = json!("uniform");
    // No steps keep those low, not even the shortest: what can be said is said.
    let (risen, story) = rise(&server, &singular).await;
    assert!(risen < 1e6, "{risen}");
    assert_eq!(
        (story.state(), &story.end["reason"]),
        ("stalled", &json!("diverging"))
    );
    expect(&story.job, &[("shorter_interval", "/method")]);
}

#[tokio::test]
async fn fits_that_an_iteration_does_not_finish_are_warned_of() {
    let server = Server::start().await;
    let ill = ("ill_conditioned", "/method");
    let bernstein = json!({"kind": "bernstein"});
    for kind in ["global", "weighted"] {
        let mut job = curve(30, &bernstein);
        job["method"] = json!({"kind": kind});
        let story = expect_everywhere(&server, &job, &[ill]).await;
        assert_eq!(story.state(), "exhausted");
        // Not if the data have so little of the slowest part that it does not matter.
        job["stop"] = json!({"relative_tolerance": 0.2});
        let story = expect_everywhere(&server, &job, &[]).await;
        assert_eq!(story.state(), "converged");
    }
    expect_everywhere(
        &server,
        &curve(30, &json!({"kind": "bspline", "degree": 3})),
        &[],
    )
    .await;
}

#[tokio::test]
async fn control_points_without_data_are_warned_of() {
    let server = Server::start().await;
    let parameters: Vec<f64> = (0..30)
        .map(|i| f64::from(i) / 100.0)
        .chain([0.98, 0.99, 1.0])
        .collect();
    let points: Vec<[f64; 2]> = parameters.iter().map(|t| [*t, t * t]).collect();
    let knots = json!([
        0, 0, 0, 0, 0.1, 0.2, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1, 1, 1, 1
    ]);
    let mut job = json!({
        "curve": {
            "points": points, "parameters": parameters,
            "basis": {"kind": "bspline", "degree": 3, "knots": knots},
        },
        "method": {"kind": "least_squares", "control_points": 12},
    });
    let story = expect_everywhere(&server, &job, &[("without_data", "/method")]).await;
    // Functions 6 and 7 live on [0.4, 0.9], between the data.
    let detail = story.job["warnings"][0]["detail"].as_str().unwrap();
    assert!(detail.starts_with("2 control points"), "{detail}");
    job["curve"]["basis"]["knots"] = Value::Null;
    job["curve"]["basis"]
        .as_object_mut()
        .unwrap()
        .remove("knots");
    expect_everywhere(&server, &job, &[]).await;
}

/// One point far away makes the relative tolerance so wide that the others are missed.
#[tokio::test]
async fn points_that_determine_the_bounding_box_are_warned_of() {
    let server = Server::start().await;
    let mut job = curve(60, &json!({"kind": "bspline"}));
    job["curve"]["points"][30] = json!([1e9, 0]);
    job["method"] = json!("direct");
    let outliers = ("outliers", "/curve/points");
    let story = expect_everywhere(&server, &job, &[outliers]).await;
    let detail = story.job["warnings"][0]["detail"].as_str().unwrap();
    assert!(detail.contains("tolerance in data units"), "{detail}");
    assert!(detail.contains("allows distances of 1.000e3"), "{detail}");
    // The tolerance is in data units, or there is none.
    for tolerance in [
        json!({"tolerance": 1e-6}),
        json!({"relative_tolerance": 0, "max_iterations": 2}),
    ] {
        job["stop"] = tolerance;
        expect_everywhere(&server, &job, &[]).await;
    }
    job["stop"] = json!({"relative_tolerance": 1e-9});
    expect_everywhere(&server, &job, &[outliers]).await;
    // Of many points and of a surface; but not where the points are spread.
    let mut many = curve(5000, &json!({"kind": "bspline"}));
    many["method"] = json!("direct");
    many["curve"]["points"][77] = json!([77, -1e8]);
    expect_everywhere(&server, &many, &[outliers]).await;
    let mut grid = surface(6, 7, &json!({"kind": "bspline"}));
    grid["method"] = json!("direct");
    grid["surface"]["points"][2][3] = json!([2, 3, 1e6]);
    expect_everywhere(&server, &grid, &[("outliers", "/surface/points")]).await;
    let spread: Vec<[f64; 2]> = (0..40)
        .map(|i| [1.2f64.powi(i), 0.1 * f64::from(i)])
        .collect();
    expect_everywhere(
        &server,
        &json!({"curve": {"points": spread}, "method": "direct"}),
        &[],
    )
    .await;
    let scattered: Vec<[f64; 3]> = (0..60)
        .map(f64::from)
        .map(|i| [(1.7 * i).sin(), (2.9 * i).cos(), 0.0])
        .chain([[1e6, 0.0, 0.0]])
        .collect();
    let job = json!({
        "surface": {"scattered": scattered, "parameters": "project"},
        "method": {"kind": "least_squares", "control_points": 4},
    });
    let created = server.fit(&job).await;
    let found = warnings(&created);
    assert!(
        found.contains(&("outliers".to_owned(), "/surface/scattered".to_owned())),
        "{found:?}"
    );
}

/// Global PIA of 21 points is within a hundredth of the first error after seven iterations, and Chebyshev steps take
/// thousands.
#[tokio::test]
async fn slow_chebyshev_steps_are_warned_of() {
    let server = Server::start().await;
    let mut job = curve(21, &json!({"kind": "bernstein"}));
    job["method"] = json!("chebyshev");
    job["stop"] = json!({"max_iterations": 100_000});
    expect_everywhere(&server, &job, &[("slow_steps", "/method")]).await;
    let mut spline = curve(21, &json!({"kind": "bspline", "degree": 3}));
    spline["method"] = json!("chebyshev");
    expect_everywhere(&server, &spline, &[]).await;
}

/// Coordinates near 1e12 are exact to 1e-4: what is left there is rounding, and no step that is too long.
#[tokio::test]
async fn far_from_the_origin_rounding_is_left() {
    let server = Server::start().await;
    for variant in ["direct", "cg"] {
        let points: Vec<_> = (0..60)
            .map(|i| 0.1 * f64::from(i))
            .map(|t| [1e12 + t, 1e12 + t * t, 1e12 - t])
            .collect();
        let job = json!({
            "curve": {"points": points, "parameters": "uniform"},
            "method": {"kind": "least_squares", "control_points": 8, "variant": variant},
            "stop": {"tolerance": 1e-7},
        });
        let job = server.fit(&job).await;
        assert_eq!(
            (&job["state"], &job["reason"]),
            (&json!("stalled"), &json!("rounding")),
            "{variant}: {job}"
        );
    }
}
