//! A grid with gaps as scattered points, for fits that choose the number of their control points.

use super::imported::{Imported, chosen};
use piad_fit::data::{Grid, Points};

impl Imported {
    /// The points that a grid with gaps has, as scattered points of a surface with the parameters that they have in it.
    #[must_use]
    pub fn into_scattered(mut self) -> Self {
        let Some(grid) = self.grid.take() else {
            return self;
        };
        let missing = std::mem::take(&mut self.missing);
        let kept: Vec<usize> = (0..self.points.len())
            .filter(|index| missing.binary_search(index).is_err())
            .collect();
        let of_rows = places(&self.points, &kept, grid.rows, |index| index / grid.columns);
        let of_columns = places(&self.points, &kept, grid.columns, |index| {
            index % grid.columns
        });
        let parameters = kept.iter().map(|index| {
            let Grid { columns, .. } = grid;
            let place = |places: &[f64], at: usize| places.get(at).copied().unwrap_or_default();
            [
                place(&of_rows, index / columns),
                place(&of_columns, index % columns),
            ]
        });
        self.surface_parameters = Some(parameters.collect());
        let lanes = self.points.lanes().iter();
        let lanes: Vec<Vec<f64>> = lanes.map(|lane| chosen(lane, &kept)).collect();
        self.points = Points::from_lanes(lanes);
        self.lines = chosen(&self.lines, &kept);
        self.notices.push(format!(
            "The fit chooses the number of its control points: the {} points that are there are fitted as scattered points.",
            kept.len()
        ));
        self.unordered = true;
        self
    }
}

/// The parameters of rows or columns, from 0 to 1: as x or y has them, if one of these is the same in each of them, else at
/// equal steps.
fn places(
    points: &Points,
    kept: &[usize],
    count: usize,
    line_of: impl Fn(usize) -> usize,
) -> Vec<f64> {
    // Of heights there is nothing but z.
    let across = if points.dimension() == 3 { 2 } else { 0 };
    let by_coordinate = points.lanes().iter().take(across).find_map(|lane| {
        let mut values = vec![None; count];
        for &index in kept {
            let (place, x) = (values.get_mut(line_of(index))?, *lane.get(index)?);
            if *place.get_or_insert(x) != x {
                return None;
            }
        }
        scaled(&values.into_iter().collect::<Option<Vec<f64>>>()?)
    });
    let steps = count.saturating_sub(1).max(1) as f64;
    by_coordinate.unwrap_or_else(|| (0..count).map(|i| i as f64 / steps).collect())
}

/// The values from 0 to 1 instead of from the first to the last, if they go one way.
fn scaled(values: &[f64]) -> Option<Vec<f64>> {
    let (first, last) = (values.first()?, values.last()?);
    let scaled: Vec<f64> = values
        .iter()
        .map(|x| (x - first) / (last - first))
        .collect();
    let increases = scaled.windows(2).all(|pair| pair.first() < pair.last());
    increases.then_some(scaled)
}

#[cfg(test)]
mod tests {
    use crate::import::read;
    use crate::import::tests::HINTS;

    #[test]
    fn grids_with_gaps_keep_their_parameters() {
        let text = "x,y,z\n0,0,1\n0,1,2\n0,4,3\n2,0,nan\n2,1,1\n2,4,2\n3,0,1\n3,1,0\n3,4,1\n";
        let file = read(text.as_bytes(), &HINTS).unwrap();
        assert_eq!(file.missing, [3]);
        let scattered = file.into_scattered();
        assert_eq!((scattered.points.len(), scattered.lines.len()), (8, 8));
        assert!(scattered.grid.is_none() && scattered.missing.is_empty());
        let parameters = scattered.surface_parameters.unwrap();
        assert_eq!(parameters[3], [2.0 / 3.0, 0.25]);
        assert_eq!((parameters[0], parameters[7]), ([0.0, 0.0], [1.0, 1.0]));
        // Rows without a gap stay as they are.
        let rows = read(b"[[1, 2, null, 4],\n[5, 6, 7, 8]]", &HINTS).unwrap();
        let parameters = rows.into_scattered().surface_parameters.unwrap();
        assert_eq!(parameters[2], [0.0, 1.0]);
        assert_eq!(parameters[4], [1.0, 1.0 / 3.0]);
    }
}
