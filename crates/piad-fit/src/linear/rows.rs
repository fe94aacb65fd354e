//! Rows of a matrix with few consecutive entries each, collected for its triangular factor.

use super::triangular::Triangular;

/// The rows of a matrix on their way into a factorization.
#[derive(Debug)]
pub(crate) struct Rows {
    /// The place of each column in the order in which rows are narrow.
    places: Vec<u32>,
    /// The most places from the first to the last entry of a row.
    width: usize,
    kept: Kept,
}

/// The stored form of rows.
#[derive(Debug)]
enum Kept {
    Rows {
        /// The first place of each row.
        firsts: Vec<u32>,
        /// `width` numbers of each row.
        entries: Vec<f64>,
    },
    /// The sums of products of columns: of each place `width` numbers, from its own square on.
    Products(Vec<f64>),
}

impl Rows {
    /// No rows yet, of as many columns as there are places.
    pub(crate) fn new(places: Vec<u32>, width: usize) -> Self {
        Self {
            width: width.min(places.len()),
            places,
            kept: Kept::Rows {
                firsts: Vec::new(),
                entries: Vec::new(),
            },
        }
    }

    /// The same, of which only the products of columns are kept.
    pub(crate) fn of_products(places: Vec<u32>, width: usize) -> Self {
        let width = width.min(places.len());
        Self {
            kept: Kept::Products(vec![0.0; places.len() * width]),
            places,
            width,
        }
    }

    /// Adds a multiple of a row of columns and values.
    pub(crate) fn push(&mut self, row: impl Iterator<Item = (usize, f64)> + Clone, factor: f64) {
        let entries = || {
            let entries = row.clone().filter(|&(_, value)| value != 0.0);
            entries.map(|(column, value)| (self.places[column] as usize, value))
        };
        match &mut self.kept {
            Kept::Products(products) => {
                for (place, value) in entries() {
                    let later = entries().filter(|(other, _)| *other >= place);
                    let products = &mut products[place * self.width..(place + 1) * self.width];
                    later.for_each(|(other, x)| {
                        products[other - place] += (factor * value) * (factor * x);
                    });
                }
            }
            Kept::Rows {
                firsts,
                entries: numbers,
            } => {
                let Some(first) = entries().map(|(place, _)| place).min() else {
                    return;
                };
                let mut line = vec![0.0; self.width];
                for (place, value) in entries() {
                    line[place - first] += factor * value;
                }
                numbers.extend(line);
                firsts.push(first as u32);
            }
        }
    }

    /// The triangular factor; `fixed` columns are left out.
    pub(crate) fn triangular(self, fixed: impl Fn(usize) -> bool) -> Triangular {
        let (firsts, entries) = match self.kept {
            Kept::Products(products) => {
                return Triangular::of_products(self.places, self.width, products, fixed);
            }
            Kept::Rows { firsts, entries } => (firsts, entries),
        };
        let mut order: Vec<usize> = (0..firsts.len()).collect();
        order.sort_by_key(|&row| firsts[row]);
        let mut triangular = Triangular::new(self.places, self.width);
        let mut line = vec![0.0; self.width];
        for row in order {
            line.copy_from_slice(&entries[row * self.width..(row + 1) * self.width]);
            triangular.insert(&mut line, firsts[row] as usize);
        }
        triangular.leave_out(fixed);
        match triangular.is_nearly_singular() {
            true => triangular.regularized(),
            false => triangular,
        }
    }
}
