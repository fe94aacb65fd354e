//! Theorems about rates, eigenvalues and exactness, and their values in the `job` event.

use serde_json::{Value, json};

use crate::data;
use crate::numbers::largest_difference;
use crate::support::{Server, Story};

fn uniform_line(n: usize) -> Value {
    let points: Vec<[f64; 2]> = (0..=n)
        .map(|i| i as f64)
        .map(|x| [x, (x * 0.9).sin()])
        .collect();
    json!(points)
}

async fn run(curve: Value, method: Value, tolerance: f64) -> Story {
    let server = Server::start().await;
    let job = json!({
        "curve": curve,
        "method": method,
        "stop": {"tolerance": tolerance, "max_iterations": 100_000},
    });
    server.stream(&job).await
}

fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("{value} is no number"))
}

/// Uniform cubics with n = 10: global .6551; with many points 2/3, weighted 1/2, Chebyshev 2 − √3.
#[tokio::test]
async fn rates_of_uniform_cubics() {
    let curve = |n| json!({"points": uniform_line(n), "parameters": "uniform"});
    let story = run(curve(10), json!({"kind": "global"}), 1e-9).await;
    assert!((number(&story.job["predicted"]["rate"]) - 0.6551).abs() < 5e-5);
    for (method, limit) in [
        ("global", 2.0 / 3.0),
        ("weighted", 0.5),
        ("chebyshev", 2.0 - 3f64.sqrt()),
    ] {
        let story = run(curve(1000), json!({"kind": method}), 1e-9).await;
        assert_eq!(story.state(), "converged");
        let rate = number(&story.job["predicted"]["rate"]);
        assert!((rate - limit).abs() < 1e-4, "{method}: {rate}");
        let lambda = number(&story.job["method"]["lambda_min"]);
        assert!((lambda - 1.0 / 3.0).abs() < 1e-4, "{method}: {lambda}");
        // The prediction is asymptotic: it is near, and it is not exceeded by much.
        let predicted = number(&story.job["predicted"]["iterations"]);
        let taken = number(&story.end["iterations"]);
        assert!(
            (taken - predicted).abs() <= 0.3 * predicted + 3.0,
            "{method}: {taken}, {predicted}"
        );
        let last = story.iterations.last().unwrap();
        assert!(number(&last["rate"]) < limit + 0.15, "{method}: {last}");
    }
    let story = run(curve(1000), json!({"kind": "weighted"}), 1e-9).await;
    assert!((number(&story.job["method"]["omega"]) - 1.5).abs() < 1e-3);
    let chosen = run(curve(10), json!({"kind": "weighted", "omega": 1.25}), 1e-9).await;
    assert_eq!(chosen.job["method"]["omega"], 1.25);
}

/// Surfaces: λ_min is the product: global 8/9, weighted 4/5, Chebyshev 1/2.
#[tokio::test]
async fn rates_of_uniform_bicubics() {
    let server = Server::start().await;
    for (method, limit) in [("global", 8.0 / 9.0), ("weighted", 0.8), ("chebyshev", 0.5)] {
        let job = json!({
            "surface": {"points": data::peaks(60), "parameters": "uniform"},
            "method": {"kind": method},
            "stop": {"tolerance": 1e-6},
        });
        let story = server.stream(&job).await;
        assert_eq!(story.state(), "converged");
        let rate = number(&story.job["predicted"]["rate"]);
        assert!((rate - limit).abs() < 2e-3, "{method}: {rate}");
    }
}

/// The least eigenvalue of the Bernstein operator at t = i/m is m!/m^m.
#[tokio::test]
async fn least_eigenvalue_of_the_bernstein_operator() {
    for m in [2_usize, 3, 5, 8, 12] {
        let curve = json!({
            "points": uniform_line(m), "parameters": "uniform", "basis": {"kind": "bernstein"},
        });
        let story = run(curve, json!({"kind": "chebyshev"}), 1e-3).await;
        let exact: f64 = (1..=m).map(|i| i as f64 / m as f64).product();
        let lambda = number(&story.job["method"]["lambda_min"]);
        assert!(
            (lambda / exact - 1.0).abs() < 1e-6,
            "m = {m}: {lambda} {exact}"
        );
    }
}

/// The Bernstein polynomial of degree m of `e^(at)` is `(1 + t (e^(a/m) − 1))^m` (the binomial theorem), so that
/// level 1, `2 P − B P`, is known for every degree and for tensor products; coordinates t are reproduced.
#[tokio::test]
async fn first_level_of_exponentials_is_known_for_every_degree() {
    /// Parameters, values, and values of the Bernstein polynomial at the parameters.
    fn line(m: usize) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
        let t: Vec<f64> = (0..=m).map(|i| i as f64 / m as f64).collect();
        let growth = (3.0 / m as f64).exp_m1();
        let polynomial = |t: &f64| (m as f64 * (t * growth).ln_1p()).exp();
        let (values, polynomial) = (t.iter().map(|t| (3.0 * t).exp()), t.iter().map(polynomial));
        let (values, polynomial) = (values.collect(), polynomial.collect());
        (t, values, polynomial)
    }
    let server = Server::start().await;
    let check = async |shape: Value, expected: Value| {
        let mut job = shape;
        job["stop"] = json!({"tolerance": 0, "max_iterations": 1});
        let story = server.stream(&job).await;
        let found = &story.iterations[1]["control_points"];
        assert!(largest_difference(found, &expected) < 1e-12 * 3f64.exp().powi(2));
    };
    for m in [2, 3, 40, 100, 317, 1000] {
        let (t, values, polynomial) = line(m);
        let points: Vec<[f64; 2]> = t.iter().zip(&values).map(|(&t, &x)| [t, x]).collect();
        let moved = values.iter().zip(&polynomial).map(|(x, b)| 2.0 * x - b);
        let expected: Vec<[f64; 2]> = t.iter().zip(moved).map(|(&t, x)| [t, x]).collect();
        let curve = json!({"points": points, "parameters": "uniform", "basis": "bernstein"});
        check(json!({"curve": curve}), json!(expected)).await;
    }
    // Fewer lines and more than a product of matrices takes at once, in both directions.
    for (m, n) in [(2, 30), (30, 2), (9, 12), (100, 7)] {
        let ((u, f, bf), (v, g, bg)) = (line(m), line(n));
        let grid = |z: &dyn Fn(usize, usize) -> f64| -> Vec<Vec<[f64; 3]>> {
            let row = |i: usize| (0..=n).map(|j| [u[i], v[j], z(i, j)]).collect();
            (0..=m).map(row).collect()
        };
        let points = grid(&|i, j| f[i] * g[j]);
        let expected = grid(&|i, j| 2.0 * f[i] * g[j] - bf[i] * bg[j]);
        let surface = json!({"points": points, "parameters": "uniform", "basis": "bernstein"});
        check(json!({"surface": surface}), json!(expected)).await;
    }
}

/// The extended method is exact after n + 1 levels from the data, n from the transformed data, and
/// on surfaces after m + n + 1; its error may grow before.
#[tokio::test]
async fn extended_fits_are_exact_when_nilpotency_says_so() {
    let server = Server::start().await;
    for (start, levels) in [("data", 11), ("transformed", 10)] {
        // Rounding leaves about 1e-8 of the condition number of B.
        for (basis, condition) in [
            ("bernstein", 3.0e3),
            ("said_ball", 7.3e3),
            ("wang_ball", 9.5e4),
        ] {
            let job = json!({
                "curve": {"points": data::lemniscate(), "parameters": "uniform", "basis": {"kind": basis}},
                "method": {"kind": "extended", "start": start},
                "stop": {"tolerance": 1e-8 * condition},
            });
            let story = server.stream(&job).await;
            // It may be within the tolerance before the last of them.
            let predicted = &story.job["predicted"]["iterations"];
            assert_eq!(*predicted, story.iterations.len() - 1);
            assert_eq!(story.state(), "converged", "{basis}");
            assert!(story.iterations.len() <= levels + 1);
            // On the way it has grown by orders of magnitude, and was not stopped for it.
            let largest = (0..story.iterations.len()).map(|k| story.error(k));
            assert!(largest.fold(0.0, f64::max) > 100.0);
        }
    }
    // Without a tolerance it ends there, and says that nothing but rounding is left.
    let job = json!({
        "surface": {"points": data::peaks(7)},
        "method": {"kind": "extended", "start": "data"},
        "stop": {"tolerance": 0},
    });
    let story = server.stream(&job).await;
    assert_eq!(story.end["iterations"], 13);
    assert_eq!(
        (story.state(), &story.end["reason"]),
        ("stalled", &json!("nilpotent"))
    );
    assert!(story.error(13) < 1e-8 && story.error(12) > 0.0);
}

/// Deng13, example 2: the first row of U, seen as level 0 of unit vectors, and the residual.
#[tokio::test]
async fn the_example_of_deng() {
    let server = Server::start().await;
    for (j, expected) in [0.7232, 0.4068, 0.1808, 0.0452, 0.0]
        .into_iter()
        .enumerate()
    {
        let mut points = [[0.0]; 5];
        points[j] = [1.0];
        let job = json!({
            "curve": {"points": points, "parameters": "uniform", "basis": {"kind": "wang_ball"}},
            "method": {"kind": "extended"},
            "stop": {"max_iterations": 0},
        });
        let story = server.stream(&job).await;
        let entry = number(&story.iterations[0]["control_points"][0][0]);
        assert!((entry - expected).abs() <= 5.001e-5, "{j}: {entry}");
    }
    let points: Vec<[f64; 2]> = (0..5)
        .map(|i| f64::from(i) * std::f64::consts::FRAC_PI_4)
        .map(|a| [a.cos(), a.sin()])
        .collect();
    for (start, levels) in [("transformed", 4), ("data", 5)] {
        let job = json!({
            "curve": {"points": points, "parameters": "uniform", "basis": {"kind": "wang_ball"}},
            "method": {"kind": "extended", "start": start},
            "stop": {"tolerance": 0},
        });
        let story = server.stream(&job).await;
        assert_eq!(story.iterations.len(), levels + 1);
        // The last row of U is a unit vector, which saves a level from the data.
        assert!(story.error(4) < 1e-13 && story.error(levels) < 1e-13);
        assert!(story.error(3) > 0.1);
    }
}

/// `direct` is the limit at once; what is left is rounding, and it says so.
#[tokio::test]
async fn direct_fits_are_done_in_one_iteration() {
    let server = Server::start().await;
    for shape in [
        json!({"curve": {"points": data::helix()}}),
        json!({"surface": {"points": data::peaks(20)}}),
        json!({"curve": {"points": data::wave(500), "closed": true}}),
    ] {
        let mut job = shape;
        job["method"] = json!({"kind": "direct"});
        job["stop"] = json!({"relative_tolerance": 1e-13});
        let story = server.stream(&job).await;
        assert_eq!(story.state(), "converged");
        assert_eq!(story.end["iterations"], 1);
        job["stop"] = json!({"tolerance": 0});
        let story = server.stream(&job).await;
        assert!(story.iterations.len() < 10);
        assert!(["stalled", "converged"].contains(&story.state()));
    }
}

/// Uniform cubic of 1001 points to 1e-9: global 38 iterations, weighted 23, Chebyshev 13.
#[tokio::test]
async fn acceleration_saves_iterations() {
    let mut taken = Vec::new();
    for method in ["global", "weighted", "chebyshev"] {
        let curve = json!({"points": uniform_line(1000), "parameters": "uniform"});
        let story = run(curve, json!({"kind": method}), 1e-9).await;
        taken.push(number(&story.end["iterations"]));
    }
    assert!(
        taken[0] > 1.5 * taken[1] && taken[1] > 1.5 * taken[2],
        "{taken:?}"
    );
}
