//! Noise of unknown size, for which the data choose the fairness.

use serde_json::{Value, json};

use crate::automatic::value;
use crate::numbers::{flat, numbers};
use crate::support::{Server, base, problem};

/// Normal deviates, the same in each run: sums of twelve uniform ones.
fn deviates() -> impl FnMut() -> f64 {
    let mut state = 7_u64;
    let mut uniform = move || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    move || (0..12).map(|_| uniform()).sum::<f64>() - 6.0
}

/// Points of a curve about 100 wide, and the same with noise of 1.5 in each coordinate.
fn data() -> [Vec<[f64; 2]>; 2] {
    let mut deviate = deviates();
    let exact: Vec<[f64; 2]> = (0..150)
        .map(|i| f64::from(i) / 149.0)
        .map(|s| [100.0 * s, 20.0 * (7.0 * s).sin() + 8.0 * (17.0 * s).cos()])
        .collect();
    let noisy = exact
        .iter()
        .map(|point| point.map(|x| x + 1.5 * deviate()))
        .collect();
    [exact, noisy]
}

/// The rms of the distances of a result from points at its parameters.
fn rms(result: &Value, from: &[[f64; 2]]) -> f64 {
    let (knots, t) = (numbers(&result["knots"]), numbers(&result["parameters"]));
    let net: Vec<Vec<f64>> = result["control_points"]
        .as_array()
        .unwrap()
        .iter()
        .map(numbers)
        .collect();
    let squares = t.iter().zip(from).map(|(t, point)| {
        let at = value(&knots, 3, &net, *t);
        (at[0] - point[0]).powi(2) + (at[1] - point[1]).powi(2)
    });
    (squares.sum::<f64>() / from.len() as f64).sqrt()
}

/// The fit is much nearer to the truth than its data are, and as near as the best of ten values of fairness; the chosen
/// value is reported.
#[tokio::test]
async fn fairness_follows_the_noise() {
    let server = Server::start().await;
    let [exact, noisy] = data();
    let fit = async |method: Value| {
        let job = json!({"curve": {"points": noisy}, "method": method});
        let job = server.fit(&job).await;
        let result = server.json(&format!("{}/result", base(&job))).await;
        (rms(&result, &exact), result, job)
    };
    let with = |count: Value, fairness: Value| json!({"kind": "least_squares", "control_points": count, "fairness": fairness, "end_points": "free"});
    let mut best = f64::INFINITY;
    for power in -11..-1 {
        let (rms, ..) = fit(with(json!(60), json!(10_f64.powi(power)))).await;
        best = best.min(rms);
    }
    for count in [json!(60), json!("auto")] {
        let (rms, result, job) = fit(with(count.clone(), json!("auto"))).await;
        assert!(rms < 1.05 * best && rms < 1.45, "{count}: {rms} of {best}");
        let chosen = result["fairness"].as_f64().unwrap();
        assert!((1e-9..1e-3).contains(&chosen), "{chosen}");
        assert_eq!(job["method"]["fairness"], chosen);
        // The input has the requested value.
        let input = server.json(&format!("{}/input", base(&job))).await;
        assert_eq!(input["method"]["fairness"], "auto");
    }
}

/// Heights of a hill and a valley on a grid of places, without noise and with it, some of them missing or not.
fn heights(missing: bool) -> [Vec<Vec<Value>>; 2] {
    let mut deviate = deviates();
    let mut rows = [Vec::new(), Vec::new()];
    for i in 0..31 {
        let [mut exact, mut noisy] = [Vec::new(), Vec::new()];
        for j in 0..26 {
            let z = (0.2 * f64::from(i)).sin() * (0.25 * f64::from(j)).cos();
            let noise = deviate();
            let is_there = !missing || (i * 7 + j * 3) % 11 != 0;
            exact.push(json!(z));
            noisy.push(if is_there {
                json!(z + 0.1 * noise)
            } else {
                Value::Null
            });
        }
        rows[0].push(exact);
        rows[1].push(noisy);
    }
    rows
}

/// Grids, also with missing points, come nearer to the truth than their data, and nearly as near as with the best number.
#[tokio::test]
async fn noise_of_grids_is_smoothed() {
    let server = Server::start().await;
    for missing in [false, true] {
        let [exact, noisy] = heights(missing);
        let fit = async |fairness: Value| {
            let method = json!({"kind": "least_squares", "control_points": {"u": 14, "v": 12}, "fairness": fairness, "end_points": "free"});
            let job = json!({"surface": {"points": noisy}, "method": method});
            let job = server.fit(&job).await;
            let path = format!("{}/result?view=samples&samples=31x26", base(&job));
            let samples = flat(&server.json(&path).await["samples"]);
            let truth = exact.iter().flatten().map(|z| z.as_f64().unwrap());
            let squares = truth.zip(&samples).map(|(z, sample)| (z - sample).powi(2));
            let rms = (squares.sum::<f64>() / samples.len() as f64).sqrt();
            (rms, job)
        };
        let mut best = f64::INFINITY;
        for power in -9..0 {
            best = best.min(fit(json!(10_f64.powi(power))).await.0);
        }
        let (rms, job) = fit(json!("auto")).await;
        assert!(
            rms < 1.1 * best && rms < 0.035,
            "{missing}: {rms} of {best}"
        );
        assert!(job["method"]["fairness"].as_f64().unwrap() > 0.0);
    }
}

#[tokio::test]
async fn what_the_data_do_not_choose_is_named() {
    let server = Server::start().await;
    let [_, noisy] = data();
    let heights: Vec<Vec<[f64; 3]>> = (0..6)
        .map(|i| (0..6).map(|j| [f64::from(i), f64::from(j), 0.0]).collect())
        .collect();
    let curve = json!({"points": noisy});
    let settings = |count: Value, field: &str, value: Value| json!({"kind": "least_squares", "control_points": count, "fairness": "auto", field: value});
    let plain = |count: Value| settings(count, "variant", json!("cg"));
    let constraints = settings(json!(20), "constraints", json!([{"index": 9}]));
    let exact = json!({"points": data()[0]});
    for (job, reason) in [
        (
            json!({"curve": exact, "method": plain(json!(150))}),
            "there is nothing to smooth",
        ),
        (
            json!({"surface": {"points": heights}, "method": plain(json!("auto"))}),
            "do not smooth a surface",
        ),
        (
            json!({"surface": {"points": heights}, "method": settings(json!(4), "end_points", json!("interpolated"))}),
            "corners",
        ),
        (
            json!({"surface": {"points": heights}, "method": plain(json!(4))}),
            "there is nothing to smooth",
        ),
        (
            json!({"curve": curve, "method": constraints}),
            "constraints",
        ),
        (
            json!({"curve": {"points": noisy, "corners": [70]}, "method": plain(json!(20))}),
            "corners",
        ),
        (
            json!({"curve": curve, "method": {"kind": "least_squares", "control_points": "auto", "fairness": "auto"}, "stop": {"tolerance": 1}}),
            "tolerance",
        ),
        (
            json!({"curve": curve, "method": settings(json!(20), "fairness", json!("much"))}),
            "auto",
        ),
    ] {
        let (status, problem) =
            problem(server.post("/v1/jobs").json(&job).send().await.unwrap()).await;
        assert_eq!(status, 422, "{job}");
        assert_eq!(
            problem["errors"][0]["pointer"], "/method/fairness",
            "{problem:#}"
        );
        let detail = problem["errors"][0]["detail"].as_str().unwrap();
        assert!(detail.contains(reason), "{detail}");
    }
}
