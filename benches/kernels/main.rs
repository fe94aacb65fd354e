//! The kernels, compared with their minimum cost.
//!
//! ```sh
//! cargo bench --bench kernels              # about two minutes
//! cargo bench --bench kernels -- --quick
//! ```
//!
//! Each line prints medians of interleaved measurements, in nanoseconds per point and iteration,
//! and their ratio to a loop that moves the same numbers without computing.

#![expect(
    clippy::print_stdout,
    clippy::expect_used,
    reason = "a bench prints, and stops where it cannot continue"
)]

mod differences;
mod digits;
mod problems;
mod setup;
mod timing;
mod traffic;

use std::sync::Arc;
use std::time::Duration;

use clap::Parser;
use piad_fit::engine::sweep::{LEVELS, Plan, Sweep};
use piad_fit::engine::{Iteration, System};
use piad_fit::method::Method;
use timing::{Candidate, medians};
use traffic::Traffic;

/// Levels per pass: a few, and the number that fits use.
const SEVERAL: [usize; 2] = [4, LEVELS];

#[derive(Parser)]
struct Options {
    /// Shorter measurements.
    #[arg(long)]
    quick: bool,
    /// Given by `cargo bench`.
    #[arg(long, hide = true)]
    bench: bool,
}

fn main() {
    let options = Options::parse();
    let time = Duration::from_millis(if options.quick { 300 } else { 4000 });
    let threads = rayon::current_num_threads();
    for threads in if threads > 1 {
        vec![1, threads]
    } else {
        vec![1]
    } {
        println!(
            "\n{threads} thread(s): ns per point and iteration, and ratio to the traffic alone\n"
        );
        let [some, most] = SEVERAL;
        print!("| | traffic | sweep | ratio | plain loop ");
        println!("| {some} levels in a pass | gain | {most} levels in a pass | gain |");
        println!("|---|---|---|---|---|---|---|---|---|");
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().expect("threads").install(|| sweeps(time));
    }
    setup::report(time);
    digits::report(time);
    differences::report(time);
}

fn sweeps(time: Duration) {
    for count in [10_000, 100_000, 1_000_000] {
        let name = format!("curve, {count} × 3");
        line(&name, &problems::curve(count, Method::Global), time);
    }
    let chebyshev = problems::curve(1_000_000, Method::Chebyshev);
    line("curve, 1000000 × 3, Chebyshev", &chebyshev, time);
    for side in [100, 1000] {
        let name = format!("surface, {side} × {side} × 3");
        line(&name, &problems::surface(side, Method::Global), time);
    }
}

/// Measures a sweep, several levels in a pass, the plain loop and the traffic.
fn line(name: &str, system: &Arc<System>, time: Duration) {
    let problem = system.problem();
    let points = problem.grid().count();
    let is_curve = problem.v().is_none();
    let start = || system.start();
    let usual = Plan::of(system);
    let sweep = |levels| {
        let plan = Plan { levels, ..usual };
        Sweep::with_plan(system, start(), plan)
            .expect("there are sweeps for this")
            .0
    };
    let mut one = sweep(1);
    let mut several = SEVERAL.map(|levels| (levels, sweep(levels)));
    let mut plain = Iteration::start_plain(Arc::clone(system));
    let dimension = problem.dimension();
    let steps = if matches!(problem.method(), Method::Chebyshev) {
        dimension
    } else {
        0
    };
    let banded = system.collocation().tensor();
    let banded = banded.and_then(|tensor| tensor.u.as_banded());
    let entries = banded.map_or(0, |u| u.width());
    let entries = if is_curve { entries } else { 0 };
    let mut traffic = Traffic::new(
        points,
        2 * dimension + entries + steps,
        dimension + steps,
        usual.parts,
    );
    let mut candidates: Vec<Candidate> = vec![
        ("traffic", Box::new(|| traffic.run())),
        (
            "sweep",
            Box::new(|| {
                one.step(system);
            }),
        ),
        (
            "plain",
            Box::new(|| {
                plain.step();
            }),
        ),
    ];
    if is_curve {
        for (levels, sweep) in &mut several {
            candidates.push(("several", Box::new(|| sweep.steps(system, *levels))));
        }
    }
    let each = medians(&mut candidates, time);
    let each: Vec<f64> = each
        .iter()
        .map(|seconds| seconds * 1e9 / points as f64)
        .collect();
    let (traffic, sweep, plain) = (each[0], each[1], each[2]);
    print!(
        "| {name} | {traffic:.2} | {sweep:.2} | {:.2} | {plain:.2} |",
        sweep / traffic
    );
    for (index, levels) in SEVERAL.into_iter().enumerate() {
        match each.get(3 + index) {
            Some(pass) => {
                let several = pass / levels as f64;
                print!(" {several:.2} | {:.2}× |", sweep / several);
            }
            None => print!(" | |"),
        }
    }
    println!();
}
