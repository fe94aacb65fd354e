//! The cost of number texts: a lower bound for writing responses and reading requests.

use std::hint::black_box;
use std::time::Duration;

use base64_simd::{Out, STANDARD};

use crate::problems::spiral;
use crate::timing::{Candidate, medians};

/// Measures shortest digits of the coordinates of a curve, parsing them, and base64, with one
/// thread.
pub(crate) fn report(time: Duration) {
    let points = spiral(10_000);
    let numbers: Vec<f64> = (0..points.len()).flat_map(|i| points.point(i)).collect();
    let texts: Vec<String> = numbers
        .iter()
        .map(|x| zmij::Buffer::new().format(*x).to_owned())
        .collect();
    let bytes: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
    let mut text = vec![0; STANDARD.encoded_length(bytes.len())];
    let mut candidates: Vec<Candidate> = vec![
        (
            "writing base64 (base64-simd)",
            Box::new(|| {
                black_box(STANDARD.encode(&bytes, Out::from_slice(&mut text)));
            }),
        ),
        (
            "writing digits (zmij)",
            Box::new(|| {
                for x in &numbers {
                    black_box(zmij::Buffer::new().format_finite(*x));
                }
            }),
        ),
        (
            "reading digits (fast-float2)",
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
        println!("| a coordinate alone, {name} | {nanoseconds:.1} |");
    }
}
