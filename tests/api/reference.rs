//! Random problems over all methods, with the errors that an independent numpy implementation found.

use std::collections::BTreeMap;

use serde_json::Value;

use crate::support::Server;

/// Each case is a job and the largest distance at its first levels. Both programs round, and λ_min
/// and ρ come from iterations that end at 1e-13.
#[tokio::test]
async fn errors_equal_those_of_numpy() {
    const TOLERANCE: f64 = 1e-11;
    let text = include_str!("../golden/reference.json");
    let cases: Vec<Value> = serde_json::from_str(text).unwrap();
    assert!(cases.len() >= 200);
    let server = Server::start().await;
    let mut worst: BTreeMap<&str, f64> = BTreeMap::new();
    for case in &cases {
        let name = case["name"].as_str().unwrap();
        let story = server.stream(&case["job"]).await;
        let expected: Vec<f64> = case["errors"]
            .as_array()
            .unwrap()
            .iter()
            .map(|error| error.as_f64().unwrap())
            .collect();
        let scale = expected.iter().copied().fold(0.0, f64::max);
        // Adaptive and exact fits can end before the last of the levels.
        let levels = story.iterations.len().min(expected.len());
        assert!(
            levels == expected.len() || story.state() == "converged",
            "{name}"
        );
        for (k, expected) in expected.iter().take(levels).enumerate() {
            let deviation = (story.error(k) - expected).abs() / scale;
            assert!(deviation < TOLERANCE, "{name}, level {k}: {deviation}");
            let worst = worst.entry(name).or_default();
            *worst = worst.max(deviation);
        }
    }
    assert!(worst.len() >= 40, "methods and bases: {worst:?}");
}
