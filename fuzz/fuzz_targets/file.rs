//! Files of points in all formats.

#![no_main]

use libfuzzer_sys::fuzz_target;
use piad_files::import::{Hints, read_parts};

/// Few points, so that what takes long is not what is many.
const MAX_POINTS: usize = 100_000;

fuzz_target!(|bytes: &[u8]| {
    let hints = Hints {
        most: MAX_POINTS,
        ..Hints::default()
    };
    if let Ok(parts) = read_parts(bytes, &hints) {
        for part in parts {
            assert!(part.lines.is_empty() || part.lines.len() == part.points.len());
            let coordinates = part.points.lanes().iter().flat_map(|lane| lane.iter());
            assert!(coordinates.copied().all(f64::is_finite));
        }
    }
});
