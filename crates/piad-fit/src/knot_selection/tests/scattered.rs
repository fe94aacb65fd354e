//! Surfaces of scattered points.

use super::surface::{all, bicubic, franke, is_inserted};
use super::*;
use crate::knot_selection::surface::{ScatteredData, SurfaceSchedule};
use crate::knot_selection::values::Values;

/// Numbers of [0, 1) that look random: the fractions of multiples of the golden ratio and such.
fn spread(count: usize) -> [Vec<f64>; 2] {
    // The inverses of the plastic number and of its square.
    let steps = [0.754_877_666_246_693, 0.569_840_290_998_053];
    steps.map(|step| (1..=count).map(|i| (i as f64 * step).fract()).collect())
}

/// The points of a function of (u, v).
fn points_of([u, v]: &[Vec<f64>; 2], f: impl Fn(f64, f64) -> [f64; 3]) -> Points {
    let mut points = Points::new(3);
    u.iter().zip(v).for_each(|(&u, &v)| points.push(&f(u, v)));
    points
}

fn fit(
    points: &Points,
    parameters: &[Vec<f64>; 2],
    settings: Settings<2>,
) -> (Vec<Arc<Level<2>>>, Option<Outcome>) {
    let parameters = parameters.clone().map(Arc::new);
    let data = ScatteredData::new(points, &parameters, [false; 2], settings.tolerance);
    let options = settings.options(&parameters);
    all(SurfaceSchedule::new(Box::new(data), options))
}

/// As few points as need a control point each: the normal equations of these have a condition of 1e10, and are still
/// solved.
#[test]
fn few_points_are_met_with_as_many_control_points() {
    let steps = [0.618_033_988_749_895, 0.754_877_666_246_693];
    let parameters = steps.map(|step| {
        (1..=100)
            .map(|i| (0.5 + f64::from(i) * step).fract())
            .collect()
    });
    let points = points_of(&parameters, |u, v| [u, v, franke(u, v)]);
    let (levels, outcome) = fit(&points, &parameters, bicubic(3e-3));
    let last = levels.last().unwrap();
    assert_eq!(
        outcome,
        Some(Outcome::Converged),
        "{:e}",
        last.distances.max
    );
    assert!(last.count() <= 100);
}

/// Each level is as far from the data as it says, insertion keeps the surface, and fewer control
/// points do than scipy needs.
#[test]
fn hills() {
    let parameters = spread(1500);
    let points = points_of(&parameters, |u, v| [u, v, franke(u, v)]);
    // With scipy 1.17.1, `SmoothBivariateSpline`, the best of twenty smoothing factors; and ours.
    for (tolerance, scipy, ours) in [(1e-2, 156, 90), (1e-3, 306, 210), (1e-4, 729, 460)] {
        let (levels, outcome) = fit(&points, &parameters, bicubic(tolerance));
        assert_eq!(outcome, Some(Outcome::Converged));
        assert_eq!(levels[0].counts(), [4, 4]);
        let last = levels.last().unwrap();
        assert!(last.distances.max <= tolerance);
        assert!(last.count() <= ours && ours < scipy, "{}", last.count());
        for pair in levels.windows(2).filter(|pair| is_inserted(pair)) {
            let mut each = pair[0].distances.each.iter().zip(&pair[1].distances.each);
            assert!(each.all(|(a, b)| (a - b).abs() < 1e-13));
        }
        // Between the data it is as near.
        let [u, v] = &parameters;
        for i in 0..300 {
            let (u, v) = (
                u[i].midpoint(u[i + 700]).clamp(0.02, 0.98),
                v[i].midpoint(v[i + 700]).clamp(0.02, 0.98),
            );
            let distance = place(last, u, v)[2] - franke(u, v);
            assert!(distance.abs() < 2.0 * tolerance, "{tolerance}: {distance}");
        }
    }
}

/// The order of the data does not matter, nor, but for rounding, how far away they are.
#[test]
fn any_order_and_any_place() {
    let parameters = spread(700);
    let points = points_of(&parameters, |u, v| [u, v, franke(u, v)]);
    let (levels, _) = fit(&points, &parameters, bicubic(1e-2));
    let last = levels.last().unwrap();
    let reversed = |lane: &[f64]| lane.iter().rev().copied().collect::<Vec<f64>>();
    let back = Points::from_lanes(points.lanes().iter().map(|lane| reversed(lane)));
    let back_parameters = [0, 1].map(|axis| reversed(&parameters[axis]));
    let (other, _) = fit(&back, &back_parameters, bicubic(1e-2));
    assert_eq!(other.len(), levels.len());
    for (one, other) in levels.iter().zip(&other) {
        assert_eq!(one.control_points, other.control_points);
        assert_eq!(one.distances.each, reversed(&other.distances.each));
    }
    let far = points_of(&parameters, |u, v| {
        [u + 1048576.0, v - 1048576.0, franke(u, v) + 65536.0]
    });
    let (levels, outcome) = fit(&far, &parameters, bicubic(1e-2));
    assert_eq!(outcome, Some(Outcome::Converged));
    assert_eq!(levels.last().unwrap().counts(), last.counts());
}

/// A cylinder needs knots in one direction only, and a plane none; both at all degrees.
#[test]
fn knots_go_where_they_are_needed() {
    let parameters = spread(900);
    for degree in [1, 2, 3, 5] {
        let settings = |tolerance| Settings {
            degrees: [degree; 2],
            ..bicubic(tolerance)
        };
        let wave = points_of(&parameters, |u, v| [u, v, (9.0 * v).sin()]);
        let (levels, outcome) = fit(&wave, &parameters, settings(1e-2));
        assert_eq!(outcome, Some(Outcome::Converged));
        let counts = levels.last().unwrap().counts();
        assert_eq!(counts[0], degree + 1, "degree {degree}: {counts:?}");
        let plane = points_of(&parameters, |u, v| [u, v, 2.0 * u - v]);
        let (levels, outcome) = fit(&plane, &parameters, settings(1e-9));
        assert_eq!((levels.len(), outcome), (1, Some(Outcome::Converged)));
    }
}

/// Without data in a part of the plane the surface stays there between the smallest and the largest.
#[test]
fn holes() {
    let all = spread(3000);
    let (u, v) = all[0]
        .iter()
        .zip(&all[1])
        .filter(|&(u, v)| (u - 0.5).hypot(v - 0.6) > 0.2)
        .unzip();
    let parameters = [u, v];
    let points = points_of(&parameters, |u, v| [u, v, franke(u, v)]);
    let (levels, outcome) = fit(&points, &parameters, bicubic(1e-3));
    assert_eq!(outcome, Some(Outcome::Converged));
    let last = levels.last().unwrap();
    let data = points.lane(2).iter();
    let (low, high) = data.fold((1.0, 0.0), |(low, high), &z| {
        (f64::min(low, z), f64::max(high, z))
    });
    for i in 0..400 {
        let (r, a) = (0.2 * f64::from(i % 20) / 20.0, f64::from(i));
        let (u, v) = (0.5 + r * a.cos(), 0.6 + r * a.sin());
        let z = place(last, u, v)[2];
        assert!((low..high).contains(&z), "{z}");
    }
}

/// Scattered points of a torus, closed in both directions.
#[test]
fn closed_directions() {
    let torus = |u: f64, v: f64| {
        let (a, b) = (2.0 * PI * u, 2.0 * PI * v);
        let r = 3.0 + b.cos();
        [r * a.cos(), r * a.sin(), b.sin()]
    };
    let mut parameters = spread(2000);
    parameters.iter_mut().for_each(|t| t[0] = 0.0);
    let points = points_of(&parameters, torus);
    let settings = Settings {
        periods: [Some(1.0); 2],
        ..bicubic(1e-3)
    };
    let (levels, outcome) = fit(&points, &parameters, settings);
    assert_eq!(outcome, Some(Outcome::Converged));
    assert_eq!(levels[0].counts(), [4, 4]);
    let last = levels.last().unwrap();
    assert!(last.lines.iter().all(Breaks::is_closed));
    let (open, _) = fit(&points, &parameters, bicubic(1e-3));
    assert!(last.count() < open.last().unwrap().count());
    for i in 0..50 {
        let (u, v) = (f64::from(i) / 50.0, f64::from(7 * i % 50) / 50.0);
        let pairs = place(last, u, v).into_iter().zip(torus(u, v));
        assert!(pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) < 2e-3);
    }
}

/// Data that no surface goes through, a limit, and data that hardly make a surface.
#[test]
fn what_cannot_be_fitted() {
    let parameters = spread(600);
    let points = points_of(&parameters, |u, v| [u, v, franke(u, v)]);
    let limited = Settings {
        max_control_points: [8, 30],
        ..bicubic(1e-4)
    };
    let (levels, outcome) = fit(&points, &parameters, limited);
    assert_eq!(outcome, Some(Outcome::Exhausted));
    assert!(levels.iter().all(|level| level.counts()[0] <= 8));
    // Each point twice, one unit apart.
    let twice = parameters.clone().map(|t| [t.clone(), t].concat());
    let mut points = points_of(&parameters, |u, v| [u, v, 0.0]);
    let [u, v] = &parameters;
    u.iter()
        .zip(v)
        .for_each(|(&u, &v)| points.push(&[u, v, 1.0]));
    let (levels, outcome) = fit(&points, &twice, bicubic(0.1));
    assert_eq!(outcome, Some(Outcome::Minimum));
    assert!(levels.last().unwrap().distances.max < 1.0);
}

/// Data that hardly make a surface: on a diagonal, on two lines of one u, fewer than control points.
#[test]
fn degenerate_data() {
    let t: Vec<f64> = (0..200).map(|i| f64::from(i) / 199.0).collect();
    let wave = |u: f64, v: f64| [u, v, (9.0 * u).sin() + v];
    let diagonal = [t.clone(), t.clone()];
    let (levels, outcome) = fit(&points_of(&diagonal, wave), &diagonal, bicubic(1e-3));
    assert_eq!(outcome, Some(Outcome::Converged));
    assert!(levels.last().unwrap().count() < 100);
    let lines = [
        t.iter().map(|t| (t * 97.0).floor() % 2.0).collect(),
        t.clone(),
    ];
    let (levels, outcome) = fit(&points_of(&lines, wave), &lines, bicubic(1e-3));
    assert_eq!(outcome, Some(Outcome::Converged));
    assert!(levels.last().unwrap().count() < 100);
    let few = [vec![0.0, 1.0, 0.25], vec![0.0, 0.5, 1.0]];
    let (levels, outcome) = fit(&points_of(&few, wave), &few, bicubic(1e-9));
    assert_eq!((levels.len(), outcome), (1, Some(Outcome::Converged)));
}

/// The place of a surface.
fn place(level: &Level<2>, u: f64, v: f64) -> Vec<f64> {
    let values =
        [(0, u), (1, v)].map(|(axis, t)| Values::new(&level.lines[axis], &Arc::new(vec![t])));
    let lanes = level.control_points.lanes().iter();
    let along = |lane: &[f64]| {
        let rows = Points::from_lanes(lane.chunks_exact(level.counts()[1]));
        let across: Vec<f64> = values[1].points(&rows).point(0).collect();
        values[0].points(&Points::from_lanes([across])).lane(0)[0]
    };
    lanes.map(|lane| along(lane)).collect()
}
