//! Sparse matrices by columns.

/// The entries of a matrix that differ from zero, column by column.
#[derive(Clone, Debug)]
pub(crate) struct Columns {
    /// Where the entries of each column start, and, one place more, where those of the last one
    /// end.
    starts: Vec<usize>,
    /// Rows and values.
    entries: Vec<(u32, f64)>,
}

impl Columns {
    /// Sorts entries (row, column, value) that come row by row, in two passes over them.
    pub(crate) fn new(
        columns: usize,
        entries: impl Iterator<Item = (usize, usize, f64)> + Clone,
    ) -> Self {
        let nonzero = || entries.clone().filter(|&(.., value)| value != 0.0);
        let mut starts = vec![0; columns + 1];
        for (_, j, _) in nonzero() {
            starts[j + 1] += 1;
        }
        for j in 0..columns {
            starts[j + 1] += starts[j];
        }
        let mut next = starts.clone();
        let mut sorted = vec![(0, 0.0); starts[columns]];
        for (i, j, value) in nonzero() {
            sorted[next[j]] = (i as u32, value);
            next[j] += 1;
        }
        Self {
            starts,
            entries: sorted,
        }
    }

    /// The entries of column `j`, rows (increasing) and values.
    pub(crate) fn column(&self, j: usize) -> &[(u32, f64)] {
        &self.entries[self.starts[j]..self.starts[j + 1]]
    }
}
