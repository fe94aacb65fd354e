//! Where least-squares fits end: at the minimum, by all that is known of it.

use serde_json::{Value, json};

use crate::support::Server;

fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("{value} is no number"))
}

/// A noisy curve with dense points at one end: the columns of A differ by far.
fn uneven() -> Vec<[f64; 2]> {
    (0..400)
        .map(|i| (f64::from(i) / 399.0).powi(4) * 12.0 + f64::from(i) * 1e-3)
        .zip(0..)
        .map(|(x, i)| {
            let i = f64::from(i);
            [
                x,
                (2.0 * x).sin() + 0.02 * (37.0 * i).sin() + 0.02 * (53.0 * i).cos(),
            ]
        })
        .collect()
}

fn job(points: &[[f64; 2]], control_points: usize, variant: &str) -> Value {
    json!({
        "curve": {"points": points},
        "method": {"kind": "least_squares", "control_points": control_points, "variant": variant},
        "stop": {"tolerance": 0, "max_iterations": 100_000},
    })
}

/// A solution of the normal equations is the minimum at iteration 1, and there is nothing left to do.
#[tokio::test]
async fn direct_is_at_the_minimum_at_once() {
    let server = Server::start().await;
    let story = server.stream(&job(&uneven(), 120, "direct")).await;
    assert_eq!(story.state(), "stalled");
    assert_eq!(story.end["reason"], "minimum");
    assert_eq!(story.iterations.len(), 2);
    assert!(number(&story.end["error"]["gradient"]) < 1e-24);
}

/// `minimum` is said where the gradient says so, however unlike the columns of A are.
#[tokio::test]
async fn slow_variants_reach_the_minimum() {
    let server = Server::start().await;
    let points = uneven();
    let least = server.fit(&job(&points, 120, "direct")).await;
    let least = number(&least["error"]["rms"]);
    for variant in ["diagonal", "lspia", "cg"] {
        let found = server.fit(&job(&points, 120, variant)).await;
        assert_eq!(found["state"], "stalled", "{variant}");
        assert_eq!(found["reason"], "minimum");
        // The sum of squares is within a millionth, hence its root within half of one.
        let rms = number(&found["error"]["rms"]);
        assert!(rms / least - 1.0 < 0.5e-6, "{variant}: {}", rms / least);
    }
}

/// With a step as short as this one the residual changes by less than a millionth in each iteration,
/// however far the minimum is.
#[tokio::test]
async fn small_steps_are_no_end() {
    let server = Server::start().await;
    let points = uneven();
    let least = server.fit(&job(&points, 120, "direct")).await;
    let mut slow = job(&points, 120, "lspia");
    slow["method"]["mu"] = json!(1e-9);
    slow["stop"]["max_iterations"] = json!(20);
    let story = server.stream(&slow).await;
    let rms = |k: usize| number(&story.iterations[k]["error"]["rms"]);
    assert!(1.0 - rms(1) / rms(0) < 1e-6);
    assert!(rms(0) > 1.26 * number(&least["error"]["rms"]));
    assert_eq!(story.state(), "exhausted");
}

/// Data that lie on a curve with such knots leave nothing but rounding.
#[tokio::test]
async fn exact_data_end_at_rounding() {
    let server = Server::start().await;
    let t: Vec<f64> = (0..=100).map(|i| f64::from(i) / 100.0).collect();
    let points: Vec<[f64; 2]> = t.iter().map(|t| [100.0 + t, t * t * t - t]).collect();
    for variant in ["cg", "direct", "diagonal"] {
        let found = server
            .fit(&json!({
                "curve": {"points": points, "parameters": t},
                "method": {"kind": "least_squares", "control_points": 9, "variant": variant},
                "stop": {"tolerance": 0, "max_iterations": 100_000},
            }))
            .await;
        assert_eq!(found["state"], "stalled", "{variant}: {found}");
        assert_eq!(found["reason"], "rounding", "{variant}");
        assert!(number(&found["error"]["max"]) < 2e-12, "{variant}");
    }
}

/// A step of the solution leads a surface, with holes or without, to where conjugate gradients end.
#[tokio::test]
async fn surfaces_are_at_the_minimum_at_once() {
    let server = Server::start().await;
    let whole = crate::data::peaks(16);
    let mut holed = whole.clone();
    holed[3][4] = Value::Null;
    holed[9][11] = Value::Null;
    for points in [whole, holed] {
        let fit = async |variant: &str, iterations: usize| {
            let asked = json!({
                "surface": {"points": points},
                "method": {
                    "kind": "least_squares", "control_points": {"u": 8, "v": 7}, "variant": variant,
                },
                "stop": {"tolerance": 0, "max_iterations": iterations},
            });
            number(&server.fit(&asked).await["error"]["rms"])
        };
        let (least, found) = (fit("cg", 1000).await, fit("direct", 1).await);
        assert!((found / least - 1.0).abs() < 1e-6, "{found} {least}");
        assert!(found < least * (1.0 + 1e-12), "{found} {least}");
    }
}
