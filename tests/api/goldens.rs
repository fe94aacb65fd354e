//! The numbers that the papers print, to the printed digit.

use serde_json::{Value, json};

use crate::data;
use crate::support::{Server, Story};

/// Compares with a number as it is printed: the difference is at most half of the last digit, and
/// a hair for values that lie on the edge.
fn assert_printed(story: &Story, level: usize, printed: &str) {
    let (mantissa, exponent) = printed.split_once('e').unwrap_or((printed, "0"));
    let decimals = mantissa
        .split_once('.')
        .map_or(0, |(_, digits)| digits.len());
    let unit = 10f64.powi(exponent.parse::<i32>().unwrap() - decimals as i32);
    let expected: f64 = printed.parse().unwrap();
    let error = story.error(level);
    assert!(
        (error - expected).abs() <= 0.5001 * unit,
        "level {level}: {error} is printed as {printed}"
    );
}

async fn fit(job: Value, levels: usize) -> Story {
    let server = Server::start().await;
    let mut job = job;
    job["stop"] = json!({"tolerance": 0, "max_iterations": levels});
    let story = server.stream(&job).await;
    assert_eq!(story.iterations.len(), levels + 1);
    assert_eq!(story.state(), "exhausted");
    story
}

/// DP07, Table 1, Bernstein column.
#[tokio::test]
async fn lemniscate_bernstein() {
    let job = json!({"curve": {
        "points": data::lemniscate(), "basis": {"kind": "bernstein"}, "parameters": "uniform",
    }});
    let story = fit(job, 40).await;
    for (level, printed) in [
        (0, "4.620135e-1"),
        (10, "1.012377e-1"),
        (20, "5.637195e-2"),
        (30, "3.579771e-2"),
        (40, "2.466991e-2"),
    ] {
        assert_printed(&story, level, printed);
    }
}

/// DP07, Table 1, Said–Ball column.
#[tokio::test]
async fn lemniscate_said_ball() {
    let job = json!({"curve": {
        "points": data::lemniscate(), "basis": {"kind": "said_ball"}, "parameters": "uniform",
    }});
    let story = fit(job, 40).await;
    for (level, printed) in [
        (0, "5.470408e-1"),
        (10, "1.618460e-1"),
        (20, "9.293990e-2"),
        (30, "6.853643e-2"),
        (40, "5.330010e-2"),
    ] {
        assert_printed(&story, level, printed);
    }
}

/// LBW05, Fig. 5; level 10 is .0894082, which the paper prints rounded down at every digit.
#[tokio::test]
async fn helix_bernstein() {
    let job = json!({"curve": {
        "points": data::helix(), "basis": {"kind": "bernstein"}, "parameters": "uniform",
    }});
    let story = fit(job, 60).await;
    for (level, printed) in [
        (0, "7.8931e-1"),
        (10, "8.9408e-2"),
        (20, "2.8426e-2"),
        (30, "1.3637e-2"),
        (40, "7.9672e-3"),
        (50, "5.2059e-3"),
        (60, "3.6700e-3"),
    ] {
        assert_printed(&story, level, printed);
    }
}

/// LBW05, Fig. 6. At level 50 the paper's last digit is rounding; level 60 is its rounding floor.
#[tokio::test]
async fn helix_cubic_bspline() {
    let job = json!({"curve": {
        "points": data::helix(),
        "basis": {"kind": "bspline", "degree": 3, "knots": "data"},
        "parameters": "chord_length",
        "ends": "repeated",
    }});
    let story = fit(job, 60).await;
    for (level, printed) in [
        (0, "1.0245e-1"),
        (10, "1.6375e-4"),
        (20, "1.5577e-6"),
        (30, "1.8920e-8"),
        (40, "2.5245e-10"),
        (50, "3.548e-12"),
    ] {
        assert_printed(&story, level, printed);
    }
    assert!(story.error(60) < 1e-13);
}

/// LBW05, Fig. 9 and LWD04, Fig. 6; level 0 as corrected (1.868059, misprinted in both).
#[tokio::test]
async fn peaks_bicubic() {
    let job = json!({"surface": {
        "points": data::peaks(11),
        "basis": {"kind": "bspline", "degree": 3, "knots": "data"},
        "parameters": "chord_length",
        "ends": "repeated",
    }});
    let story = fit(job, 60).await;
    for (level, printed) in [
        (0, "1.868059"),
        (2, "3.5526e-1"),
        (3, "2.422128e-1"),
        (4, "1.7233e-1"),
        (10, "4.1888e-2"),
        (15, "1.528187e-2"),
        (20, "5.2065e-3"),
        (40, "3.1430e-4"),
        (50, "8.2850e-5"),
        (60, "2.3009e-5"),
    ] {
        assert_printed(&story, level, printed);
    }
    // Both papers print level 30, one of them rounded down: 1.269593267e-3.
    assert!((story.error(30) - 1.269593267e-3).abs() < 5e-11);
}
