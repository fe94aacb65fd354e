use super::*;
use std::f64::consts::TAU;

/// Uniform numbers between -1 and 1, the same in each run.
fn random() -> impl FnMut() -> f64 {
    let mut state = 11_u64;
    move || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

fn along(points: &Points, closed: bool) -> Vec<usize> {
    let along = Along {
        points,
        parameters: None,
        closed,
    };
    find(&along, points.magnitude() * ROUNDING, |_| false)
}

fn curve(count: usize, at: impl Fn(f64) -> [f64; 2]) -> Points {
    let points = (0..count).flat_map(|i| at(i as f64 / (count - 1) as f64));
    Points::from_flat(2, &points.collect::<Vec<_>>())
}

/// The number of moved points that are not found, and of others that are.
fn errors(moved: &[usize], found: &[usize]) -> [usize; 2] {
    let without =
        |some: &[usize], others: &[usize]| some.iter().filter(|it| !others.contains(it)).count();
    [without(moved, found), without(found, moved)]
}

/// Points of a curve that are moved by 10 to 30 times the noise of all: nearly all are found, and hardly any other.
#[test]
fn outliers_of_curves_are_found() {
    let mut random = random();
    for (noise, part, share_missed) in [
        (1e-9, 0.01, 0.04),
        (0.3, 0.01, 0.04),
        (0.3, 0.05, 0.06),
        (0.3, 0.15, 0.12),
    ] {
        let (mut all, mut missed, mut others) = (0, 0, 0);
        for _ in 0..20 {
            let mut points = curve(200, |s| {
                [100.0 * s, 20.0 * (7.0 * s).sin() + 8.0 * (17.0 * s).cos()]
            });
            let moved: Vec<usize> = (0..200).filter(|_| random().abs() < part).collect();
            for i in 0..200 {
                let [mut x, mut y] = [0, 1].map(|_| noise * (random() + random() + random()));
                if moved.contains(&i) {
                    let angle = random() * TAU;
                    let size = f64::max(noise, 0.1) * (20.0 + 10.0 * random());
                    (x, y) = (x + size * angle.cos(), y + size * angle.sin());
                }
                let [px, py] = [0, 1].map(|c| points.lane(c)[i]);
                points.set(i, [px + x, py + y]);
            }
            let [not_found, found] = errors(&moved, &along(&points, false));
            (all, missed, others) = (all + moved.len(), missed + not_found, others + found);
        }
        let most = (share_missed * all as f64).ceil() as usize;
        assert!(
            missed <= most && others <= 4,
            "{noise:e} {part}: {missed} of {all} missed, {others} others"
        );
    }
}

/// Corners, coarse circles, noses of airfoils and noise have none.
#[test]
fn right_points_are_no_outliers() {
    for count in [8, 9, 13, 24, 100, 1000] {
        let mut circle = curve(count + 1, |s| [(TAU * s).cos(), (TAU * s).sin()]);
        circle.truncate(count);
        for closed in [false, true] {
            assert_eq!(along(&circle, closed), [0; 0], "{count} {closed}");
        }
    }
    let zigzag = curve(61, |s| [100.0 * s, ((100.0 * s) % 40.0 - 20.0).abs()]);
    assert_eq!(along(&zigzag, false), [0; 0]);
    let step = curve(101, |s| [s, if s < 0.4987 { 0.0 } else { 1.0 }]);
    assert_eq!(along(&step, false), [0; 0]);
    let half = |x: f64| {
        let powers = 0.2969 * x.sqrt() - 0.126 * x - 0.3516 * x * x + 0.2843 * x.powi(3);
        0.6 * (powers - 0.1015 * x.powi(4))
    };
    for count in [21, 35, 61, 121] {
        let section = curve(count, |s| {
            let x = (1.0 + (TAU * s).cos()) / 2.0;
            [x, half(x) * if s < 0.5 { 1.0 } else { -1.0 }]
        });
        assert_eq!(along(&section, false), [0; 0], "{count}");
    }
    let mut random = random();
    for _ in 0..50 {
        let mut noisy = curve(200, |s| [100.0 * s, 0.0]);
        for i in 0..200 {
            let place = [0, 1].map(|c| noisy.lane(c)[i] + random() + random() + random());
            noisy.set(i, place);
        }
        assert_eq!(along(&noisy, false), [0; 0]);
    }
}

/// Points of a wavy surface with a narrow hill that are moved away from it by 50 times the noise or more.
#[test]
fn outliers_of_surfaces_are_found() {
    let mut random = random();
    for (noise, part) in [(0.0, 0.01), (0.01, 0.01), (0.01, 0.05), (0.01, 0.15)] {
        let (mut points, mut moved) = (Points::new(3), Vec::new());
        let mut parameters = [Vec::new(), Vec::new()];
        for i in 0..3000 {
            let [x, y] = [0, 1].map(|_| (random() + 1.0) / 2.0);
            let hill = (-((x - 0.5).powi(2) + (y - 0.5).powi(2)) / 0.0072).exp();
            let mut z = 0.3 * (5.0 * x).sin() * (4.0 * y).cos() + 0.2 * hill;
            z += noise * (random() + random() + random());
            if random().abs() < part {
                moved.push(i);
                z += (1.5 + random()) * random().signum();
            }
            points.push(&[x, y, z]);
            parameters[0].push(x);
            parameters[1].push(100.0 * y);
        }
        let found = find(
            &Cloud::new(&points, &parameters, &isolated(&points)),
            0.0,
            |_| false,
        );
        let [missed, others] = errors(&moved, &found);
        assert!(
            missed == 0 && others <= 2,
            "{noise} {part}: {missed} of {} missed, {others} others",
            moved.len()
        );
    }
}
