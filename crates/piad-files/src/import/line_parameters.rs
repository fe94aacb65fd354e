//! The parameters of the rows and columns of a grid with gaps, from x and y: distances between points are unreliable
//! where some are missing.

use piad_fit::data::{Grid, Points};

/// The parameters of rows and of columns, from 0 to 1, if all points that are there have x and y of their row and column.
pub(super) fn of_lattice(points: &Points, missing: &[usize], grid: Grid) -> Option<[Vec<f64>; 2]> {
    // Of heights there is nothing but z.
    if points.dimension() != 3 {
        return None;
    }
    let kept: Vec<usize> = (0..points.len())
        .filter(|index| missing.binary_search(index).is_err())
        .collect();
    let rows = places(points, &kept, grid.rows, |index| index / grid.columns)?;
    let columns = places(points, &kept, grid.columns, |index| index % grid.columns)?;
    Some([rows, columns])
}

/// The parameters of rows or columns, if x or y is the same in each of them and goes one way.
fn places(
    points: &Points,
    kept: &[usize],
    count: usize,
    line_of: impl Fn(usize) -> usize,
) -> Option<Vec<f64>> {
    points.lanes().iter().take(2).find_map(|lane| {
        let mut values = vec![None; count];
        for &index in kept {
            let (place, x) = (values.get_mut(line_of(index))?, *lane.get(index)?);
            if *place.get_or_insert(x) != x {
                return None;
            }
        }
        scaled(&values.into_iter().collect::<Option<Vec<f64>>>()?)
    })
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
    fn grids_with_gaps_have_the_parameters_of_their_lattice() {
        let text = "x,y,z\n0,0,1\n0,1,2\n0,4,3\n2,0,nan\n2,1,1\n2,4,2\n3,0,1\n3,1,0\n3,4,1\n";
        let file = read(text.as_bytes(), &HINTS).unwrap();
        assert_eq!(file.missing, [3]);
        let [u, v] = file.line_parameters.unwrap();
        assert_eq!(u, [0.0, 2.0 / 3.0, 1.0]);
        assert_eq!(v, [0.0, 0.25, 1.0]);
        let whole = read(text.replace("nan", "5").as_bytes(), &HINTS).unwrap();
        assert_eq!(whole.line_parameters, None);
        // Engines compute the same for heights.
        let rows = read(b"[[1, 2, null, 4],\n[5, 6, 7, 8]]", &HINTS).unwrap();
        assert_eq!(rows.line_parameters, None);
    }
}
