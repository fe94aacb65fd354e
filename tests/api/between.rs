//! What fits do between their data.

use serde_json::{Value, json};

use crate::support::{Server, Story, base};

/// The outline of a bracket in mm: a point every three along one edge and the fillet, only the ends of the others.
fn bracket() -> Vec<[f64; 2]> {
    let edge = (0..=10).map(|i| [3.0 * f64::from(i), 0.0]);
    let fillet = (1..10).map(|k| f64::from(k) * std::f64::consts::FRAC_PI_2 / 10.0);
    let fillet = fillet.map(|a| [30.0 + 50.0 * a.sin(), 50.0 - 50.0 * a.cos()]);
    let corners = [[80.0, 50.0], [80.0, 62.0], [0.0, 62.0], [0.0, 12.0]];
    edge.chain(fillet).chain(corners).collect()
}

/// The largest distance of samples from the polygon through points.
fn from_polygon(samples: &Value, polygon: &[[f64; 2]]) -> f64 {
    let distance = |x: [f64; 2]| {
        let edges = polygon.windows(2).map(|edge| {
            let [a, b] = [edge[0], edge[1]];
            let (chord, to) = ([b[0] - a[0], b[1] - a[1]], [x[0] - a[0], x[1] - a[1]]);
            let square = chord[0].hypot(chord[1]).powi(2);
            let s = ((chord[0] * to[0] + chord[1] * to[1]) / square).clamp(0.0, 1.0);
            (to[0] - s * chord[0]).hypot(to[1] - s * chord[1])
        });
        edges.fold(f64::INFINITY, f64::min)
    };
    let points = samples.as_array().unwrap().iter();
    let points = points.map(|it| [0, 1].map(|c| it[c].as_f64().unwrap()));
    points.map(distance).fold(0.0, f64::max)
}

/// The numbers of lists in lists.
fn numbers(of: &Value) -> Vec<f64> {
    match of.as_array() {
        Some(list) => list.iter().flat_map(numbers).collect(),
        None => vec![of.as_f64().unwrap()],
    }
}

fn codes(of: &Value) -> Vec<&str> {
    let all = of["warnings"].as_array().unwrap().iter();
    all.map(|it| it["code"].as_str().unwrap()).collect()
}

/// Within the tolerance at all points such an outline was left by kilometres.
#[tokio::test]
async fn an_outline_with_long_edges_stays_near_them() {
    let server = Server::start().await;
    let points = bracket();
    for tolerance in [0.05, 0.005] {
        let job = json!({
            "curve": {"points": points},
            "method": {"kind": "least_squares", "control_points": "auto"},
            "stop": {"tolerance": tolerance},
        });
        let fitted = server.fit(&job).await;
        assert_eq!(fitted["state"], "converged", "{fitted}");
        assert!(fitted["error"]["max"].as_f64().unwrap() <= tolerance);
        assert_eq!(codes(&fitted), ["rounded_corners"], "{fitted}");
        let path = format!("{}/result?view=samples&samples=4000", base(&fitted));
        let off = from_polygon(&server.json(&path).await["samples"], &points);
        // The longest edge.
        assert!(off < 80.0, "{tolerance}: {off}");
    }
}

/// Runge's function at equal steps of [-1, 1].
fn runge(count: usize) -> Vec<f64> {
    let x = |i: usize| 2.0 * i as f64 / (count - 1) as f64 - 1.0;
    (0..count)
        .map(|i| 1.0 / (1.0 + 25.0 * x(i) * x(i)))
        .collect()
}

/// Polynomials through Runge's function leave it near its ends. The distances were computed with numpy from the
/// definition, in steps of a sixteenth of each gap.
#[tokio::test]
async fn polynomials_leave_runges_function() {
    let server = Server::start().await;
    for (count, expected) in [
        (12, 0.539_932_180_405_81),
        (16, 2.088_147_065_199_9),
        (20, 8.568_870_042_65),
    ] {
        let points: Vec<[f64; 1]> = runge(count).into_iter().map(|y| [y]).collect();
        let job = json!({
            "curve": {"points": points, "parameters": "uniform", "basis": {"kind": "bernstein"}},
            "method": "direct",
        });
        let fitted = server.fit(&job).await;
        assert_eq!(fitted["reason"], "between", "{fitted}");
        let between = fitted["error"]["between"].as_f64().unwrap();
        // The condition of the matrix times rounding.
        assert!(
            (between / expected - 1.0).abs() < 1e-9,
            "{count}: {between}"
        );
    }
}

/// The warning is there when the fit has ended, with the place and the distances.
#[tokio::test]
async fn fits_that_leave_their_points_are_warned_of() {
    let server = Server::start().await;
    let runge = runge(16);
    let row = |i: usize| {
        let point = |j: usize| [i as f64, j as f64, runge[i] * runge[j]];
        (0..runge.len()).map(point).collect::<Vec<_>>()
    };
    let heights: Vec<Vec<[f64; 3]>> = (0..runge.len()).map(row).collect();
    let jobs = [
        (
            json!({"curve": {"points": bracket(), "parameters": "uniform", "basis": {"kind": "bernstein"}}, "method": "direct"}),
            "/curve/points/",
        ),
        (
            json!({"surface": {"points": heights, "basis": {"kind": "bernstein"}}, "method": "direct"}),
            "/surface/points/",
        ),
    ];
    for (job, pointer) in jobs {
        let fitted = server.fit(&job).await;
        assert_eq!(
            (&fitted["state"], &fitted["reason"]),
            (&json!("stalled"), &json!("between")),
            "{fitted}"
        );
        assert!(codes(&fitted).contains(&"between_points"), "{fitted}");
        // It is known of the last iteration alone, once a fit has ended.
        assert!(
            fitted["error"]["between"].as_f64().unwrap() > 1.0,
            "{fitted}"
        );
        let last = format!("{}/iterations/last", base(&fitted));
        assert!(server.json(&last).await["error"]["between"].is_null());
        let mut warnings = fitted["warnings"].as_array().unwrap().iter();
        let warning = warnings.find(|it| it["code"] == "between_points").unwrap();
        let input = server.json(&format!("{}/input", base(&fitted))).await;
        let at = warning["pointer"].as_str().unwrap();
        assert!(
            at.starts_with(pointer) && input.pointer(at).is_some(),
            "{warning}"
        );
        let list = server
            .json(&format!("{}/deviation?list=true", base(&fitted)))
            .await;
        let each: Vec<f64> = numbers(&list["between"]);
        let gaps = if pointer == "/curve/points/" {
            bracket().len() - 1
        } else {
            15 * 15
        };
        assert_eq!(each.len(), gaps);
        // In large steps a part of it is missed.
        let most = each.iter().copied().fold(0.0, f64::max);
        let between = fitted["error"]["between"].as_f64().unwrap();
        assert!(
            (0.75 * between..=between).contains(&most),
            "{most} of {between}"
        );
        let detail = warning["detail"].as_str().unwrap();
        for part in ["between point ", " of freedom", "fairness"] {
            assert!(detail.contains(part), "{detail}");
        }
        let events = server.get(&format!("{}/events", base(&fitted)));
        let story = Story::read(events.send().await.unwrap()).await;
        assert!(
            codes(&story.job).contains(&"between_points"),
            "{}",
            story.job
        );
        assert_eq!(story.end["warnings"], fitted["warnings"]);
        assert_eq!(story.end["error"], fitted["error"]);
        // Also of a stream that begins before the fit.
        let live = server.stream(&job).await;
        assert_eq!(live.end["warnings"], fitted["warnings"]);
    }
    let even: Vec<[f64; 2]> = (0..40)
        .map(|i| 0.2 * f64::from(i))
        .map(|t| [t, t.sin()])
        .collect();
    let fitted = server.fit(&json!({"curve": {"points": even}})).await;
    assert!(codes(&fitted).is_empty(), "{fitted}");
    assert_eq!(
        (&fitted["state"], &fitted["error"]["between"]),
        (&json!("converged"), &json!(0.0))
    );
}

/// A tube that is projected to a plane.
#[tokio::test]
async fn parameters_that_fold_are_named() {
    let server = Server::start().await;
    let tube: Vec<[f64; 3]> = (0..2000)
        .map(f64::from)
        .map(|i| {
            (
                6.2 * (0.754_877_666 * i).fract(),
                5.0 * (0.569_840_291 * i).fract(),
            )
        })
        .map(|(angle, along)| [angle.cos(), along, angle.sin()])
        .collect();
    let job = |parameters: Value| {
        json!({
            "surface": {"scattered": tube, "parameters": parameters},
            "method": {"kind": "least_squares", "control_points": 8},
            "stop": {"tolerance": 1e-2},
        })
    };
    let folded = server.fit(&job(json!({"project": "xy"}))).await;
    assert_eq!(
        (&folded["state"], &folded["reason"]),
        (&json!("stalled"), &json!("minimum")),
        "{folded}"
    );
    assert_eq!(codes(&folded), ["folded_parameters"], "{folded}");
    for detail in [&folded["detail"], &folded["warnings"][0]["detail"]] {
        assert!(detail.as_str().unwrap().contains("fold"), "{folded}");
    }
    let unrolled: Vec<[f64; 2]> = (0..2000)
        .map(f64::from)
        .map(|i| {
            [
                6.2 * (0.754_877_666 * i).fract(),
                5.0 * (0.569_840_291 * i).fract(),
            ]
        })
        .collect();
    let unrolled = server.fit(&job(json!(unrolled))).await;
    assert!(codes(&unrolled).is_empty(), "{unrolled}");
}
