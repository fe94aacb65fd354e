//! The cost of differences of iterations, compared with copying the same numbers.

use std::hint::black_box;
use std::time::Duration;

use crate::timing::{Candidate, medians};

// They belong to the binary crate, which benches cannot use.
#[expect(dead_code, reason = "nothing is read here")]
#[path = "../../src/job/deltas/lanes.rs"]
mod lanes;
#[expect(dead_code, reason = "nothing is read here")]
#[path = "../../src/job/deltas/packed.rs"]
mod packed;

use lanes::{Lanes, Target, step};

const PLACES: usize = 10_000;
const DIMENSION: usize = 3;

/// The least error of iterations; steps are fine enough for it.
const ERROR: f64 = 0.25;

/// Measures applying integer steps to an array, and copying it coordinate by coordinate, with one
/// thread.
pub(crate) fn report(time: Duration) {
    let target = |k: u32| {
        let numbers: Vec<f64> = (0..PLACES * DIMENSION).map(|i| number(i, k)).collect();
        Target {
            places: PLACES,
            dimension: DIMENSION,
            at_once: 384,
            fill: Box::new(move |start, to| {
                to.copy_from_slice(&numbers[start..start + to.len()]);
            }),
        }
    };
    let targets = [target(0), target(1)];
    let mut lanes = Lanes::of(&targets[0]).expect("finite numbers");
    let step = step(ERROR, lanes.largest());
    let mut turn = 0;
    let mut candidates: Vec<Candidate> = vec![
        (
            "copying it coordinate by coordinate",
            Box::new(|| {
                black_box(Lanes::of(&targets[0]));
            }),
        ),
        (
            "writing its difference",
            Box::new(|| {
                turn = 1 - turn;
                black_box(lanes.follow(&targets[turn], step));
            }),
        ),
    ];
    let each = medians(&mut candidates, time);
    for ((name, _), seconds) in candidates.iter().zip(each) {
        let nanoseconds = seconds * 1e9 / (PLACES * DIMENSION) as f64;
        println!("| a coordinate alone, {name} | {nanoseconds:.1} |");
    }
}

/// A coordinate of an iteration, within half a unit of those of other iterations.
fn number(i: usize, k: u32) -> f64 {
    let noise = (i * i % 977) as f64 / 977.0 - 0.5;
    (i as f64 * 0.001).sin() * 10.0 + 0.5_f64.powi(k as i32) * noise
}
