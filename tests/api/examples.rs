//! Every file under `examples` is a job that converges.

use std::fs;
use std::path::PathBuf;

use serde_json::Value;

use crate::support::Server;

fn examples() -> Vec<(String, Value)> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("examples");
    let mut examples = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path
            .extension()
            .is_some_and(|extension| extension == "json")
        {
            let name = path.file_stem().unwrap().to_string_lossy().into_owned();
            let text = fs::read_to_string(&path).unwrap();
            examples.push((name, serde_json::from_str(&text).unwrap()));
        }
    }
    examples
}

#[tokio::test]
async fn all_of_them_converge() {
    let server = Server::start().await;
    let examples = examples();
    assert!(examples.len() >= 4);
    for (name, job) in examples {
        let story = server.stream(&job).await;
        assert_eq!(story.state(), "converged", "{name}");
        let tolerance = story.job["stop"]["tolerance"].as_f64().unwrap();
        let last = story.iterations.len() - 1;
        assert!(story.error(last) <= tolerance, "{name}");
        // Where the number of control points is found, the last iteration is the best of all.
        let found = job["method"]["control_points"] == "auto";
        let before = if found { 0 } else { last - 1 };
        assert!(story.error(before) > tolerance, "{name} stops at once");
        assert_eq!(story.end["iterations"], last, "{name}");
        assert_eq!(story.job["name"], job["name"]);
    }
}

/// The airfoil's ordinates by the NACA formula (4-digit series, closed trailing edge).
#[test]
fn the_airfoil_is_a_naca_2412() {
    let examples = examples();
    let (_, job) = examples
        .iter()
        .find(|(name, _)| name == "naca2412")
        .unwrap();
    let points = job["curve"]["points"].as_array().unwrap();
    let (camber, position, thickness) = (0.02, 0.4, 0.12);
    let half = points.len() / 2;
    for (i, point) in points.iter().enumerate() {
        let angle = std::f64::consts::PI * (i as f64 - half as f64) / half as f64;
        let x = 0.5 * (1.0 - angle.cos());
        let y_thickness = 5.0
            * thickness
            * (0.2969 * x.sqrt() - 0.126 * x - 0.3516 * x * x + 0.2843 * x.powi(3)
                - 0.1036 * x.powi(4));
        let (y, slope): (f64, f64) = if x < position {
            let scale = camber / (position * position);
            (
                scale * (2.0 * position * x - x * x),
                2.0 * scale * (position - x),
            )
        } else {
            let scale = camber / (1.0 - position).powi(2);
            let ahead = 1.0 - 2.0 * position;
            (
                scale * (ahead + 2.0 * position * x - x * x),
                2.0 * scale * (position - x),
            )
        };
        let side = if i < half { 1.0 } else { -1.0 };
        let theta = slope.atan();
        let expected = [
            x - side * y_thickness * theta.sin(),
            y + side * y_thickness * theta.cos(),
        ];
        for (c, expected) in expected.iter().enumerate() {
            let given = point[c].as_f64().unwrap();
            assert!((given - expected).abs() < 1e-8, "point {i}");
        }
    }
}
