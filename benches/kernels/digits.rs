//! What the digits of numbers cost alone: no JSON is written or read in less time.

use std::hint::black_box;
use std::time::Duration;

use crate::problems::spiral;
use crate::timing::{Candidate, medians};

/// Measures the shortest digits of the coordinates of a curve, and their reading, by one thread.
pub(crate) fn report(time: Duration) {
    let points = spiral(10_000);
    let numbers: Vec<f64> = (0..points.len()).flat_map(|i| points.point(i)).collect();
    let texts: Vec<String> = numbers
        .iter()
        .map(|x| zmij::Buffer::new().format(*x).to_owned())
        .collect();
    let mut candidates: Vec<Candidate> = vec![
        (
            "writing (zmij)",
            Box::new(|| {
                for x in &numbers {
                    black_box(zmij::Buffer::new().format_finite(*x));
                }
            }),
        ),
        (
            "reading (fast-float2)",
            Box::new(|| {
                for text in &texts {
                    let _ = black_box(fast_float2::parse_partial::<f64, _>(text));
                }
            }),
        ),
    ];
    let each = medians(&mut candidates, time);
    println!("\nns per number, one thread\n\n| | |\n|---|---|");
    for ((name, _), seconds) in candidates.iter().zip(each) {
        let nanoseconds = seconds * 1e9 / numbers.len() as f64;
        println!("| the digits of a coordinate alone, {name} | {nanoseconds:.1} |");
    }
}
