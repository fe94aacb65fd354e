//! Medians of interleaved measurements.
//!
//! The speed of shared machines changes from second to second. Candidates are therefore measured
//! alternately, round by round, and the ratio is that of the medians.

use std::time::{Duration, Instant};

/// A candidate: its name and one run.
pub(crate) type Candidate<'a> = (&'a str, Box<dyn FnMut() + 'a>);

/// The minimum number of rounds.
const ROUNDS: usize = 7;

/// The median seconds of each candidate, measured alternately for about `time`.
pub(crate) fn medians(candidates: &mut [Candidate<'_>], time: Duration) -> Vec<f64> {
    let repeats: Vec<u32> = candidates.iter_mut().map(|(_, run)| repeats(run)).collect();
    let mut seconds = vec![Vec::new(); candidates.len()];
    let begin = Instant::now();
    while seconds[0].len() < ROUNDS || begin.elapsed() < time {
        for (((_, run), &repeats), seconds) in candidates.iter_mut().zip(&repeats).zip(&mut seconds)
        {
            let begin = Instant::now();
            (0..repeats).for_each(|_| run());
            seconds.push(begin.elapsed().as_secs_f64() / f64::from(repeats));
        }
    }
    seconds.into_iter().map(median).collect()
}

/// The number of runs in a round, for the resolution of the clock.
fn repeats(run: &mut impl FnMut()) -> u32 {
    run();
    let begin = Instant::now();
    run();
    let once = begin.elapsed().as_secs_f64();
    (0.002 / once).clamp(1.0, 10_000.0) as u32
}

fn median(mut seconds: Vec<f64>) -> f64 {
    seconds.sort_by(f64::total_cmp);
    seconds[seconds.len() / 2]
}
