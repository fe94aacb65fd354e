//! The cost of a fit before its first level.

use std::hint::black_box;
use std::sync::Arc;
use std::time::Duration;

use piad_fit::data::Grid;
use piad_fit::engine::{Iteration, Problem, least_eigenvalue};
use piad_fit::method::Method;

use super::problems;
use super::timing::{Candidate, medians};

/// Prints a table.
pub(crate) fn report(time: Duration) {
    println!("\nBefore the first level, in milliseconds, and the levels that follow\n");
    println!("| curve | parameters, knots | collocation matrix | λ_min | level 0 | an iteration |");
    println!("|---|---|---|---|---|---|");
    for count in [100, 1000, 10_000, 100_000, 1_000_000] {
        line(count, time);
    }
}

fn line(count: usize, time: Duration) {
    let system = problems::curve(count, Method::Global);
    let problem = Arc::clone(system.problem());
    let grid = Grid {
        rows: count,
        columns: 1,
    };
    let request = || problems::request(problem.data().clone(), grid, Method::Global);
    let mut iteration = Iteration::start(Arc::clone(&system));
    let mut candidates: Vec<Candidate> = vec![
        (
            "problem",
            Box::new(|| {
                black_box(Problem::new(request()).expect("valid"));
            }),
        ),
        (
            "collocation",
            Box::new(|| {
                black_box(problem.tensor());
            }),
        ),
        (
            "spectrum",
            Box::new(|| {
                let tensor = system.collocation().tensor();
                black_box(tensor.map(|tensor| least_eigenvalue(&tensor.u)));
            }),
        ),
        (
            "level 0",
            Box::new(|| {
                black_box(Iteration::start(Arc::clone(&system)));
            }),
        ),
        (
            "iteration",
            Box::new(|| {
                black_box(iteration.step());
            }),
        ),
    ];
    let seconds = medians(&mut candidates, time);
    let [problem, collocation, spectrum, level, step] = seconds[..] else {
        unreachable!("five were measured");
    };
    let ms = |seconds: f64| seconds * 1e3;
    println!(
        "| {count} | {:.3} | {:.3} | {:.3} | {:.3} | {:.4} |",
        ms(problem),
        ms(collocation),
        ms(spectrum),
        ms(level),
        ms(step)
    );
}
