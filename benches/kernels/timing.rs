//! Medians of several things that are measured in turn.
//!
//! Machines that are shared get slower and faster from second to second. What is to be compared is
//! therefore measured alternately, round by round, and the ratio is that of the medians.

use std::time::{Duration, Instant};

/// Something to measure: its name, and how to do it once.
pub(crate) type Candidate<'a> = (&'a str, Box<dyn FnMut() + 'a>);

/// Rounds, at least.
const ROUNDS: usize = 7;

/// The median of the seconds that each candidate takes, measured in turn for about `time`.
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

/// How often a candidate is run in a round, for the clock to be exact.
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
