//! Ends that are what they are called: steps that are taken, finite numbers, and memory that is needed.

use serde_json::{Value, json};

use crate::support::{Server, base, problem};

fn arc(count: usize) -> Vec<[f64; 2]> {
    let angle = |i: usize| i as f64 / (count - 1) as f64;
    (0..count)
        .map(|i| [angle(i).cos(), angle(i).sin()])
        .collect()
}

/// The data as control points are within the tolerance, and `direct` gives the curve through them.
#[tokio::test]
async fn direct_always_takes_its_step() {
    let server = Server::start().await;
    let job = |method: Value| json!({"curve": {"points": arc(4000)}, "method": method});
    let story = server.stream(&job(json!("direct"))).await;
    assert_eq!(story.state(), "converged");
    assert_eq!(story.end["iterations"], 1);
    assert!(story.error(0) < 1e-6, "{}", story.error(0));
    // What is left is rounding.
    assert!(story.error(1) < 1e-13, "{}", story.error(1));
    // Others have nothing to do, and none takes more steps than allowed.
    let global = server.fit(&job(json!("global"))).await;
    assert_eq!(
        (&global["state"], &global["iteration"]),
        (&json!("converged"), &json!(0))
    );
    let mut none = job(json!("direct"));
    none["stop"] = json!({"max_iterations": 0});
    let none = server.fit(&none).await;
    assert_eq!(
        (&none["state"], &none["iteration"]),
        (&json!("converged"), &json!(0))
    );
}

/// True if a required number is missing.
fn has_null(value: &Value) -> bool {
    match value {
        Value::Null => true,
        Value::Array(values) => values.iter().any(has_null),
        Value::Object(fields) => fields.values().any(has_null),
        _ => false,
    }
}

#[tokio::test]
async fn nothing_converges_to_numbers_that_are_not_finite() {
    let server = Server::start().await;
    let local = json!({
        "curve": {
            "points": [[0, 1e300], [1e150, 5e-324], [1e150, 3.15], [0, 1e149], [1, 1], [0, 1.004130574517691e308], [0.01, -1e300]],
            "basis": {"kind": "bernstein"}, "parameters": "uniform",
        },
        "method": {"kind": "local", "indices": [3, 5]}, "stop": {"max_iterations": 100},
    });
    let found = server.fit(&local).await;
    assert_eq!(found["state"], "failed", "{found:#}");
    // Weights of any magnitude: the unit of all of them does not matter.
    let weighted = |weights: Value, variant: &str| {
        json!({
            "curve": {"points": [[0, 0], [2, 0], [3, 2], [1, 3], [-1, 2]], "closed": true},
            "method": {"kind": "least_squares", "control_points": 4, "variant": variant, "data_weights": weights},
            "stop": {"max_iterations": 2000},
        })
    };
    for variant in ["cg", "direct", "diagonal", "lspia"] {
        let found = server
            .fit(&weighted(json!([1e-300, 1, 1e308, 1, 1]), variant))
            .await;
        assert_ne!(found["state"], "failed", "{variant}: {found:#}");
        assert!(!has_null(&found["error"]), "{variant}: {}", found["error"]);
        let result = server.json(&format!("{}/result", base(&found))).await;
        assert!(!has_null(&result["control_points"]), "{variant}");
    }
    for variant in ["cg", "direct"] {
        let plain = server.fit(&weighted(json!([1, 2, 3, 4, 5]), variant)).await;
        // A power of two.
        let unit = 2f64.powi(1000);
        let weights: Vec<f64> = (1..=5).map(|weight| f64::from(weight) * unit).collect();
        let scaled = server.fit(&weighted(json!(weights), variant)).await;
        assert_eq!(plain["error"], scaled["error"], "{variant}");
    }
}

/// Points, derivatives and their number on a wave, by 10,000 control points of 20,000 points.
fn constrained(constraints: usize, variant: &str) -> Value {
    let points: Vec<[f64; 2]> = (0..20_000)
        .map(|i| f64::from(i) / 500.0)
        .map(|x| [x, (2.0 * x).sin() + 0.01 * (91.0 * x).sin()])
        .collect();
    let constraints = (0..constraints).map(|k| {
        let index = (k + 1) * 20_000 / (constraints + 1);
        let [x, y] = points[index];
        json!({"at": {"index": index}, "point": [x, y + 0.001]})
    });
    let constraints: Vec<Value> = constraints.collect();
    json!({
        "curve": {"points": points, "parameters": "uniform"},
        "method": {
            "kind": "least_squares", "control_points": 10_000, "variant": variant, "constraints": constraints,
        },
    })
}

/// The projection is small, and the bordered system is solved by the banded factor.
#[tokio::test]
async fn direct_obeys_many_constraints_of_long_curves() {
    let server = Server::with(|config| config.memory = Some(bytesize::ByteSize::mib(512))).await;
    for count in [1, 300] {
        let job = constrained(count, "direct");
        let found = server.fit(&job).await;
        assert_eq!(
            (&found["state"], &found["iteration"]),
            (&json!("converged"), &json!(1)),
            "{found:#}"
        );
        let direct = server.json(&format!("{}/result", base(&found))).await;
        let slow = server.fit(&constrained(count, "cg")).await;
        let ratio =
            slow["error"]["rms"].as_f64().unwrap() / found["error"]["rms"].as_f64().unwrap();
        assert!((ratio - 1.0).abs() < 1e-5, "{ratio}");
        // It passes through the points.
        let constraint = &job["method"]["constraints"][count / 2];
        let index = constraint["at"]["index"].as_u64().unwrap() as usize;
        let parameter = direct["parameters"][index].as_f64().unwrap();
        assert!((parameter - index as f64 / 19_999.0).abs() < 1e-12);
        let net = direct["control_points"].as_array().unwrap();
        let knots: Vec<f64> = direct["knots"]
            .as_array()
            .unwrap()
            .iter()
            .map(|it| it.as_f64().unwrap())
            .collect();
        for coordinate in 0..2 {
            let c: Vec<f64> = net
                .iter()
                .map(|point| point[coordinate].as_f64().unwrap())
                .collect();
            let value = de_boor(3, &knots, &c, parameter);
            let wanted = constraint["point"][coordinate].as_f64().unwrap();
            assert!((value - wanted).abs() < 1e-9, "{count}: {value} {wanted}");
        }
    }
}

/// The value of a B-spline.
fn de_boor(degree: usize, knots: &[f64], control_points: &[f64], t: f64) -> f64 {
    let last = control_points.len() - 1;
    let span = (degree..=last)
        .rev()
        .find(|&k| knots[k] <= t)
        .unwrap_or(degree);
    let mut d: Vec<f64> = control_points[span - degree..=span].to_vec();
    for r in 1..=degree {
        for j in (r..=degree).rev() {
            let low = knots[span - degree + j];
            let part = (t - low) / (knots[span + j + 1 - r] - low);
            d[j] = (1.0 - part) * d[j - 1] + part * d[j];
        }
    }
    d[degree]
}

/// A constraint that has several conditions does not name itself among the others.
#[tokio::test]
async fn constraints_do_not_name_themselves() {
    let server = Server::start().await;
    let row = |i: usize| -> Vec<[f64; 3]> {
        (0..9)
            .map(|j| [i as f64, j as f64, (i as f64 * 0.7 + j as f64).sin()])
            .collect()
    };
    let points: Vec<Vec<[f64; 3]>> = (0..9).map(row).collect();
    let boundary: Vec<[f64; 3]> = (0..6).map(|j| [0.0, 1.6 * f64::from(j), 1.0]).collect();
    let job = |constraints: Value| {
        json!({
            "surface": {"points": points, "parameters": "uniform"},
            "method": {"kind": "least_squares", "control_points": 6, "constraints": constraints},
        })
    };
    let asked = job(json!([
        {"at": {"index": [0, 4]}, "point": [0, 4, 7]},
        {"at": {"index": [5, 5]}, "point": [5, 5, 1]},
        {"at": {"boundary": "u_start"}, "control_points": boundary},
    ]));
    let refused = server.post("/v1/jobs").json(&asked).send().await.unwrap();
    let (_, refused) = problem(refused).await;
    let detail = refused["errors"][0]["detail"].as_str().unwrap();
    assert_eq!(refused["errors"][0]["pointer"], "/method/constraints/2");
    assert!(
        detail.contains(
            "constraint 2 cannot be obeyed together with constraint 0, with which it differs by"
        ),
        "{detail}"
    );
}
