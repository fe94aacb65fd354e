//! The minimum memory traffic of a sweep: reads and writes the same numbers, and computes only a
//! sum for each number written.

use std::hint::black_box;

use rayon::prelude::*;

/// The numbers that a sweep reads (X, P, the entries of B) and writes (X').
pub(crate) struct Traffic {
    read: Vec<Vec<f64>>,
    written: Vec<Vec<f64>>,
    parts: usize,
}

impl Traffic {
    /// Arrays of `points` numbers each, moved in this many parts by the threads of the pool. Each
    /// written array is the sum of two or three read ones.
    pub(crate) fn new(points: usize, read: usize, written: usize, parts: usize) -> Self {
        let array = |k: usize| (0..points).map(|i| (i + k) as f64).collect();
        Self {
            read: (0..read).map(array).collect(),
            written: (0..written).map(array).collect(),
            parts,
        }
    }

    /// Moves everything once.
    pub(crate) fn run(&mut self) {
        let length = self.written[0].len().div_ceil(self.parts);
        let streams = self.read.len() / self.written.len();
        for (written, read) in self.written.iter_mut().zip(self.read.chunks(streams)) {
            let chunks = written.par_chunks_mut(length).enumerate();
            chunks.for_each(|(part, written)| {
                let read = |k: usize| read.get(k).map(|array| &array[part * length..]);
                let read = [read(0), read(1), read(2)];
                pulp::Arch::new().dispatch(Sum { read, written });
            });
        }
        black_box(&self.written);
    }
}

/// The sum of two or three arrays, compiled for several instruction sets.
struct Sum<'a> {
    read: [Option<&'a [f64]>; 3],
    written: &'a mut [f64],
}

impl pulp::NullaryFnOnce for Sum<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let written = self.written.iter_mut();
        match self.read {
            [Some(a), Some(b), Some(c)] => {
                for (written, ((a, b), c)) in written.zip(a.iter().zip(b).zip(c)) {
                    *written = a + b + c;
                }
            }
            [Some(a), Some(b), None] => {
                for (written, (a, b)) in written.zip(a.iter().zip(b)) {
                    *written = a + b;
                }
            }
            _ => unreachable!("two or three arrays"),
        }
    }
}
