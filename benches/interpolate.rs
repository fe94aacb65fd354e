//! Interpolates given points, for comparison with other programs: `benches/scipy/compare.py` runs it.
//!
//! ```sh
//! cargo bench --bench interpolate -- POINTS METHOD TOLERANCE RESULT
//! ```
//! POINTS are little-endian 64-bit numbers x, y, z; RESULT gets the control points in the same
//! format. Chord length, cubic, not-a-knot. Prints seconds, iterations and the largest distance as
//! JSON.

#![expect(clippy::print_stdout, reason = "the result is printed")]

use std::error::Error;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;
use std::{fs, io};

use clap::Parser;
use piad_fit::basis::{BasisChoice, Knots};
use piad_fit::data::{Grid, Points};
use piad_fit::engine::{
    DirectionChoice, Iteration, Problem, Request, System, Tolerance, parameters,
};
use piad_fit::invalid::Axis;
use piad_fit::method::Method;
use piad_fit::parameters::Parametrization;

/// As in the program.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

#[derive(Parser)]
struct Options {
    points: PathBuf,
    /// `direct` or `chebyshev`.
    method: String,
    /// The largest distance.
    tolerance: f64,
    result: PathBuf,
    /// The number of runs; the median is reported.
    #[arg(long, default_value_t = 5)]
    runs: usize,
    /// Given by `cargo bench`.
    #[arg(long, hide = true)]
    bench: bool,
}

fn main() -> Result<(), Box<dyn Error>> {
    let options = Options::parse();
    let method = match options.method.as_str() {
        "direct" => Method::Direct,
        "chebyshev" => Method::Chebyshev,
        other => return Err(format!("there is no method {other}").into()),
    };
    let points = read(&options.points)?;
    let mut runs = Vec::new();
    let mut last = None;
    for _ in 0..options.runs.max(1) {
        let points = points.clone();
        let begin = Instant::now();
        let iteration = fit(points, method.clone(), options.tolerance)?;
        runs.push(begin.elapsed().as_secs_f64());
        last = Some(iteration);
    }
    runs.sort_by(f64::total_cmp);
    let iteration = last.ok_or("nothing was run")?;
    write(&options.result, iteration.control_points())?;
    let level = iteration.level();
    let (seconds, iterations, max) = (runs[runs.len() / 2], level.iteration, level.error.max);
    let result = serde_json::json!({"seconds": seconds, "iterations": iterations, "max": max});
    println!("{result}");
    Ok(())
}

/// From points to control points: parameters, knots, matrix, iteration.
fn fit(points: Points, method: Method, tolerance: f64) -> Result<Iteration, Box<dyn Error>> {
    let grid = Grid {
        rows: points.len(),
        columns: 1,
    };
    let chord_length = Parametrization::ChordLength;
    let placed = parameters(chord_length, &points, grid, None, Axis::U, false);
    let parameters = placed.map_err(|reason| format!("{reason:?}"))?.values;
    let knots = not_a_knot(&parameters);
    let request = Request {
        method,
        tolerance: Some(Tolerance::Absolute(tolerance)),
        max_iterations: 10_000,
        ..Request::new(
            points,
            grid,
            DirectionChoice::new(
                BasisChoice::BSpline {
                    degree: 3,
                    knots: Knots::Explicit(Arc::new(knots)),
                },
                Parametrization::Explicit(parameters),
            ),
            None,
        )
    };
    let problem = Problem::new(request).map_err(|reason| format!("{reason:?}"))?;
    let mut iteration = Iteration::start(Arc::new(System::new(Arc::new(problem))));
    while iteration.outcome().is_none() {
        iteration.steps(usize::MAX, &mut |_| ());
    }
    Ok(iteration)
}

/// The knots of a cubic spline at its data, without the second and the last but one (the default
/// of `scipy.interpolate.make_interp_spline`).
fn not_a_knot(parameters: &[f64]) -> Vec<f64> {
    let n = parameters.len();
    let (first, inner, last) = (parameters[0], &parameters[2..n - 2], parameters[n - 1]);
    [&[first; 4], inner, &[last; 4]].concat()
}

fn read(path: &PathBuf) -> io::Result<Points> {
    let bytes = fs::read(path)?;
    let (numbers, _) = bytes.as_chunks::<8>();
    let mut points = Points::new(3);
    for point in numbers.chunks_exact(3) {
        let place: Vec<f64> = point
            .iter()
            .map(|bytes| f64::from_le_bytes(*bytes))
            .collect();
        points.push(&place);
    }
    Ok(points)
}

fn write(path: &PathBuf, points: &Points) -> io::Result<()> {
    let numbers = (0..points.len()).flat_map(|i| points.point(i));
    fs::write(
        path,
        numbers.flat_map(f64::to_le_bytes).collect::<Vec<u8>>(),
    )
}
