//! How many iterations are forecast, and how many it takes: over sizes, degrees, bases, methods and
//! tolerances, at the start and while the fit runs.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use crate::data;
use crate::support::{Server, base, read_thinned};

/// A test problem, and the group under which the table has it.
struct Case {
    group: &'static str,
    job: Value,
}

/// A smooth curve, or one with noise.
fn curve(count: usize, noisy: bool) -> Value {
    let points: Vec<[f64; 2]> = (0..count)
        .map(|i| {
            let t = i as f64 / count as f64;
            let noise = if noisy {
                (i as f64 * 12.9898).sin() * 0.8 / count as f64
            } else {
                0.0
            };
            [(7.0 * t).cos() + noise, (5.0 * t).sin() + t - noise]
        })
        .collect();
    json!(points)
}

/// A basis; the parameters are uniform unless it says something else.
#[derive(Clone, Copy)]
enum Basis {
    Ball,
    Bernstein,
    /// B-splines of a degree over chord lengths.
    Spline(usize),
    /// B-splines of a degree.
    UniformSpline(usize),
}

fn job(points: &Value, basis: Basis, method: &Value, tolerance: f64) -> Value {
    let parameters = match basis {
        Basis::Spline(_) => "chord_length",
        _ => "uniform",
    };
    let basis = match basis {
        Basis::Ball => of_kind("said_ball"),
        Basis::Bernstein => of_kind("bernstein"),
        Basis::Spline(degree) | Basis::UniformSpline(degree) => of_degree(degree),
    };
    json!({
        "curve": {"points": points, "basis": basis, "parameters": parameters},
        "method": method,
        "stop": {"relative_tolerance": tolerance, "max_iterations": 200_000},
        "stream": {"view": "errors"},
    })
}

/// A basis or a method of which nothing else is to be said.
fn of_kind(kind: &str) -> Value {
    json!({"kind": kind})
}

fn of_degree(degree: usize) -> Value {
    json!({"kind": "bspline", "degree": degree})
}

/// The methods that adjust all control points at once.
fn methods() -> [Value; 3] {
    ["global", "weighted", "chebyshev"].map(of_kind)
}

fn local(indices: impl IntoIterator<Item = usize>) -> Value {
    json!({"kind": "local", "indices": indices.into_iter().collect::<Vec<_>>()})
}

fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    let mut add = |group, job| cases.push(Case { group, job });
    of_papers(&mut add);
    for tolerance in [1e-3, 1e-6, 1e-9] {
        splines(tolerance, &mut add);
        local_fits(tolerance, &mut add);
        other_methods(tolerance, &mut add);
        uneven_splines_and_surfaces(tolerance, &mut add);
    }
    bernstein(&mut add);
    cases
}

fn of_papers(add: &mut impl FnMut(&'static str, Value)) {
    let global = of_kind("global");
    for tolerance in [0.3, 0.1, 0.03, 0.01, 1e-3] {
        for (points, basis) in [
            (data::lemniscate(), Basis::Bernstein),
            (data::lemniscate(), Basis::Ball),
            (data::helix(), Basis::Bernstein),
            (data::helix(), Basis::Spline(3)),
        ] {
            let job = job(&points, basis, &global, tolerance);
            add("papers' curves", job);
        }
    }
}

fn splines(tolerance: f64, add: &mut impl FnMut(&'static str, Value)) {
    for method in &methods() {
        for (count, noisy) in [
            (5, true),
            (20, false),
            (100, true),
            (1000, false),
            (1000, true),
        ] {
            let group = if count < 1000 {
                "B-splines, 5 to 100 points"
            } else {
                "B-splines, 1,000 points"
            };
            for degree in [2, 3, 5] {
                let points = curve(count, noisy);
                add(
                    group,
                    job(&points, Basis::Spline(degree), method, tolerance),
                );
            }
        }
        let group = "B-splines, 20,000 to 50,000 points";
        for (points, degree) in [(curve(20_000, true), 3), (curve(50_000, false), 5)] {
            add(
                group,
                job(&points, Basis::Spline(degree), method, tolerance),
            );
        }
    }
}

fn local_fits(tolerance: f64, add: &mut impl FnMut(&'static str, Value)) {
    for method in [local([499, 500, 501]), local(200..240)] {
        for degree in [3, 5, 7] {
            let job = job(
                &curve(1000, true),
                Basis::Spline(degree),
                &method,
                tolerance,
            );
            add("local, of 1,000 points", job);
        }
    }
    let of_twenty = local([9, 10, 11]);
    let job = job(&curve(20, false), Basis::Bernstein, &of_twenty, tolerance);
    add("Bernstein, 20 points", job);
}

fn other_methods(tolerance: f64, add: &mut impl FnMut(&'static str, Value)) {
    let least_squares = json!({"kind": "least_squares", "control_points": 30});
    let adaptive = json!({"kind": "adaptive", "threshold": tolerance});
    for (count, method) in [
        (40, of_kind("transpose")),
        (40, of_kind("convex")),
        (200, least_squares),
        (200, adaptive),
    ] {
        let job = job(&curve(count, true), Basis::Spline(3), &method, tolerance);
        add("other methods", job);
    }
}

fn uneven_splines_and_surfaces(tolerance: f64, add: &mut impl FnMut(&'static str, Value)) {
    for method in &methods() {
        for degree in [3, 5] {
            let job = job(&uneven(2000), Basis::Spline(degree), method, tolerance);
            add("uneven B-splines, 2,000 points", job);
            let surface = json!({
                "surface": {"points": data::peaks(80), "basis": of_degree(degree)},
                "method": method,
                "stop": {"relative_tolerance": tolerance, "max_iterations": 20_000},
            });
            add("surfaces, 80 × 80 points", surface);
        }
    }
}

fn bernstein(add: &mut impl FnMut(&'static str, Value)) {
    let global = of_kind("global");
    let job = |points: &Value, method: &Value, tolerance| {
        job(points, Basis::Bernstein, method, tolerance)
    };
    for tolerance in [0.1, 0.03, 0.01, 3e-3] {
        for method in &methods() {
            for count in [12, 20] {
                let job = job(&curve(count, true), method, tolerance);
                add("Bernstein, 12 and 20 points", job);
            }
        }
    }
    for tolerance in [1e-4, 1e-5, 1e-6] {
        for points in [data::lemniscate(), curve(20, false)] {
            let job = job(&points, &global, tolerance);
            add("Bernstein, small tolerances", job);
        }
    }
    for tolerance in [0.03, 0.01, 3e-3, 1e-3, 3e-4] {
        for count in [24, 30, 40] {
            for noisy in [false, true] {
                let job = job(&curve(count, noisy), &global, tolerance);
                add("Bernstein, 24 to 40 points", job);
            }
        }
    }
}

/// Points whose distances differ by two orders of magnitude.
fn uneven(count: usize) -> Value {
    let mut x = 0.0;
    let points: Vec<[f64; 2]> = (0..count)
        .map(|i| {
            x += 10_f64.powf((i as f64 * 2.3).sin());
            [x, (i as f64 * 1.7).sin()]
        })
        .collect();
    json!(points)
}

/// By which factor forecasts are wrong.
fn factor(predicted: f64, needed: f64) -> f64 {
    let (p, n) = (predicted.max(1.0), needed.max(1.0));
    (p / n).max(n / p)
}

/// The factors of a case: at the start, and after a quarter, a half and three quarters of the levels.
async fn factors(server: &Server, case: &Case) -> Option<[Option<f64>; 4]> {
    let ended = server.fit(&case.job).await;
    let successful = ended["state"] == "converged" || ended["state"] == "stalled";
    let needed = ended["iteration"].as_u64().filter(|_| successful)?;
    assert_eq!(
        ended["predicted"]["iterations"].as_u64().unwrap_or(needed),
        needed,
        "{ended:#}"
    );
    let every = needed.div_ceil(4).max(1);
    let path = format!("{}/events?every={every}", base(&ended));
    let answer = server.get(&path).send().await.unwrap();
    let (iterations, _) = read_thinned(answer).await;
    let said = |k: usize| {
        let event = iterations.get(k)?;
        let predicted = event["predicted"].as_f64()?;
        Some(factor(predicted, needed as f64))
    };
    Some([said(0), said(1), said(2), said(3)])
}

/// The median of the factors that are shown, how many are, and how many of these are within three.
struct Summary {
    median: f64,
    count: usize,
    within: usize,
}

impl Summary {
    fn of(mut factors: Vec<f64>) -> Option<Self> {
        factors.sort_by(f64::total_cmp);
        let within = factors.iter().filter(|factor| **factor <= 3.0).count();
        let median = *factors.get(factors.len() / 2)?;
        assert!(median <= 3.0, "{factors:?}");
        Some(Self {
            median,
            count: factors.len(),
            within,
        })
    }
}

fn cell(factors: Vec<f64>) -> String {
    match Summary::of(factors) {
        None => "–".to_owned(),
        Some(Summary {
            median,
            count,
            within,
        }) => format!("{median:.2} ({within} of {count})"),
    }
}

/// Prints the table of docs/evidence/validation.md.
#[allow(clippy::print_stdout, reason = "the table is for people")]
#[tokio::test]
async fn forecasts_are_within_a_factor_of_three() {
    let server = Server::start().await;
    let mut groups: BTreeMap<&str, Vec<[Option<f64>; 4]>> = BTreeMap::new();
    for case in cases() {
        if let Some(factors) = factors(&server, &case).await {
            groups.entry(case.group).or_default().push(factors);
        }
    }
    println!("| problems | fits | at the start | after ¼ | after ½ | after ¾ |");
    println!("|---|---|---|---|---|---|");
    let mut all: [Vec<f64>; 4] = Default::default();
    for (group, factors) in &groups {
        let cells = [0, 1, 2, 3].map(|k| {
            let shown: Vec<f64> = factors.iter().filter_map(|it| it[k]).collect();
            all[k].extend(&shown);
            cell(shown)
        });
        println!("| {group} | {} | {} |", factors.len(), cells.join(" | "));
    }
    let fits: usize = groups.values().map(Vec::len).sum();
    // Most are predicted at the start, and nearly all of these within the factor.
    let start = Summary::of(all[0].clone()).unwrap();
    assert!(start.count * 5 > 4 * fits && start.within * 20 > 19 * start.count);
    println!("| all | {fits} | {} |", all.map(cell).join(" | "));
}

/// The fits of the first complaints: forecasts by λ_min were 10,561, 33,325, 130, 1,457 and 1.6e9.
#[tokio::test]
async fn forecasts_do_not_wait_for_the_end_of_the_spectrum() {
    let server = Server::start().await;
    let (global, local) = (of_kind("global"), local([9, 10, 11]));
    for job in [
        job(&data::lemniscate(), Basis::Bernstein, &global, 0.01),
        job(&data::lemniscate(), Basis::Bernstein, &global, 1e-3),
        job(&curve(1000, true), Basis::Spline(3), &local, 1e-6),
        job(&curve(1000, true), Basis::Spline(5), &local, 1e-6),
        job(&curve(20, false), Basis::Bernstein, &local, 1e-6),
    ] {
        let story = server.stream(&job).await;
        assert_eq!(story.state(), "converged");
        let needed = story.end["iterations"].as_f64().unwrap();
        let predicted = story.job["predicted"]["iterations"].as_f64().unwrap();
        assert!(factor(predicted, needed) < 1.5, "{predicted} {needed}");
    }
}

/// A fit that is too long to be tried: nothing is said at the start but what its block says, and soon
/// it is known.
#[tokio::test]
async fn long_fits_are_predicted_while_they_run() {
    let server = Server::start().await;
    let (points, basis) = (curve(120_000, true), Basis::UniformSpline(3));
    let mut global = job(&points, basis, &of_kind("global"), 1e-9);
    // With estimated ends the fit ends before anything can be predicted.
    global["curve"]["ends"] = json!("repeated");
    let story = server.stream(&global).await;
    assert_eq!(story.state(), "converged");
    assert_eq!(story.job["predicted"]["iterations"], Value::Null);
    let needed = story.iterations.len() - 1;
    for k in needed / 2..=needed {
        let predicted = story.iterations[k]["predicted"].as_f64().unwrap();
        assert!(
            factor(predicted, needed as f64) < 1.5,
            "{k}: {predicted} {needed}"
        );
    }
    let local = local([60_000, 60_001, 60_002]);
    let story = server.stream(&job(&points, basis, &local, 1e-9)).await;
    let needed = story.end["iterations"].as_f64().unwrap();
    let predicted = story.job["predicted"]["iterations"].as_f64().unwrap();
    assert!(factor(predicted, needed) <= 3.0, "{predicted} {needed}");
    // Of three inner points the block is (4 1 0; 1 4 1; 0 1 4)/6.
    let least = (4.0 - 2.0_f64.sqrt()) / 6.0;
    let found = story.job["method"]["lambda_min"].as_f64().unwrap();
    assert!((found - least).abs() < 1e-6, "{found} {least}");
}
