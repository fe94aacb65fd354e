//! Sparse square matrices by rows, whose diagonal is 1.

/// The rows of a square matrix whose diagonal is 1.
#[derive(Debug)]
pub(crate) struct SparseRows {
    /// Where each row starts, and the last one ends.
    starts: Vec<u32>,
    /// The columns of the entries beside the diagonal, increasing in each row.
    columns: Vec<u32>,
    values: Vec<f64>,
}

impl SparseRows {
    /// No rows yet, with room for some.
    pub(crate) fn with_room(rows: usize, entries: usize) -> Self {
        let mut starts = Vec::with_capacity(rows + 1);
        starts.push(0);
        Self {
            starts,
            columns: Vec::with_capacity(entries),
            values: Vec::with_capacity(entries),
        }
    }

    /// Appends a row of entries beside the diagonal, whose columns increase.
    pub(crate) fn push(&mut self, entries: impl Iterator<Item = (u32, f64)>) {
        for (column, value) in entries {
            self.columns.push(column);
            self.values.push(value);
        }
        self.starts.push(self.columns.len() as u32);
    }

    /// The number of rows.
    pub(super) fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// The entries of a row beside the diagonal.
    pub(super) fn entries(&self, row: usize) -> impl Iterator<Item = (usize, f64)> {
        let range = self.starts[row] as usize..self.starts[row + 1] as usize;
        let columns = self.columns[range.clone()].iter();
        columns
            .zip(&self.values[range])
            .map(|(&column, &value)| (column as usize, value))
    }

    /// The sum of a row times a vector, without the diagonal.
    fn beside(&self, row: usize, x: &[f64]) -> f64 {
        self.entries(row).map(|(column, a)| a * x[column]).sum()
    }

    /// `y = A x`.
    pub(super) fn apply(&self, x: &[f64], y: &mut [f64]) {
        for (row, y) in y.iter_mut().enumerate() {
            *y = x[row] + self.beside(row, x);
        }
    }

    /// `b − A x`.
    pub(super) fn residual(&self, b: &[f64], x: &[f64]) -> Vec<f64> {
        let rows = b.iter().zip(x).enumerate();
        rows.map(|(row, (b, own))| b - own - self.beside(row, x))
            .collect()
    }

    /// A sweep of Gauss and Seidel for `A x = b`, from the last row on or from the first.
    pub(super) fn sweep(&self, b: &[f64], x: &mut [f64], is_backward: bool) {
        for k in 0..self.len() {
            let row = if is_backward { self.len() - 1 - k } else { k };
            x[row] = b[row] - self.beside(row, x);
        }
    }
}
