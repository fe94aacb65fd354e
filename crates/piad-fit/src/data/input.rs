//! Input types for points and grids of points.

use super::grid::Grid;
use super::points::{MAX_DIMENSION, Points};
use crate::invalid::{Invalid, Place};

/// Points of R^d, d = 1, 2, 3: slices of arrays or of vectors, or a flat slice with the number of coordinates of a point.
pub trait IntoPoints {
    /// The points in their order.
    ///
    /// # Errors
    ///
    /// The first point that has another number of coordinates than the first one, or numbers of coordinates that no
    /// point has.
    fn into_points(self) -> Result<Points, Invalid>;
}

/// A grid of points: rows of equal length.
pub trait IntoGrid {
    /// The points row by row, and their arrangement.
    ///
    /// # Errors
    ///
    /// The first row that is not as long as the first one, and those of [`IntoPoints`].
    fn into_grid(self) -> Result<(Points, Grid), Invalid>;
}

/// Points of slices, all with the same number of coordinates.
fn gather<'a>(points: impl Iterator<Item = &'a [f64]> + Clone) -> Result<Points, Invalid> {
    let dimension = points.clone().next().map_or(1, <[f64]>::len);
    check(dimension)?;
    let mut gathered = Points::new(dimension);
    for (index, point) in points.enumerate() {
        if point.len() != dimension {
            let detail = format!(
                "point {index} has {} coordinates, and the first one has {dimension}",
                point.len()
            );
            return Err(Invalid::at(Place::Point(index), detail));
        }
        gathered.push(point);
    }
    Ok(gathered)
}

fn check(dimension: usize) -> Result<(), Invalid> {
    match (1..=MAX_DIMENSION).contains(&dimension) {
        true => Ok(()),
        false => Err(Invalid::at(
            Place::Points,
            format!("points have 1 to {MAX_DIMENSION} coordinates, not {dimension}"),
        )),
    }
}

impl IntoPoints for Points {
    fn into_points(self) -> Result<Points, Invalid> {
        Ok(self)
    }
}

/// A slice of points, each an array or a vector of coordinates.
impl<P: AsRef<[f64]>> IntoPoints for &[P] {
    fn into_points(self) -> Result<Points, Invalid> {
        gather(self.iter().map(AsRef::as_ref))
    }
}

impl<P: AsRef<[f64]>> IntoPoints for &Vec<P> {
    fn into_points(self) -> Result<Points, Invalid> {
        self.as_slice().into_points()
    }
}

impl<P: AsRef<[f64]>, const N: usize> IntoPoints for &[P; N] {
    fn into_points(self) -> Result<Points, Invalid> {
        self.as_slice().into_points()
    }
}

/// Coordinates of point after point, and how many each has.
impl IntoPoints for (&[f64], usize) {
    fn into_points(self) -> Result<Points, Invalid> {
        let (flat, dimension) = self;
        check(dimension)?;
        match flat.len().is_multiple_of(dimension) {
            true => Ok(Points::from_flat(dimension, flat)),
            false => Err(Invalid::at(
                Place::Points,
                format!(
                    "{} numbers are not points of {dimension} coordinates",
                    flat.len()
                ),
            )),
        }
    }
}

/// Rows of points.
impl<P: AsRef<[f64]>> IntoGrid for &[Vec<P>] {
    fn into_grid(self) -> Result<(Points, Grid), Invalid> {
        let columns = self.first().map_or(0, Vec::len);
        if let Some(row) = self.iter().position(|row| row.len() != columns) {
            let detail = format!(
                "row {row} has {} points, and the first one has {columns}",
                self[row].len()
            );
            return Err(Invalid::at(Place::Points, detail));
        }
        let points = gather(self.iter().flatten().map(AsRef::as_ref))?;
        let rows = self.len();
        Ok((points, Grid { rows, columns }))
    }
}

impl<P: AsRef<[f64]>> IntoGrid for &Vec<Vec<P>> {
    fn into_grid(self) -> Result<(Points, Grid), Invalid> {
        self.as_slice().into_grid()
    }
}

/// Points row by row, and their arrangement.
impl IntoGrid for (Points, Grid) {
    fn into_grid(self) -> Result<(Points, Grid), Invalid> {
        let (points, grid) = self;
        match grid.rows.checked_mul(grid.columns) == Some(points.len()) {
            true => Ok((points, grid)),
            false => Err(Invalid::at(
                Place::Points,
                format!(
                    "{} points are not {} rows of {}",
                    points.len(),
                    grid.rows,
                    grid.columns
                ),
            )),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_named() {
        let rows = [vec![1.0, 2.0], vec![1.0]];
        let message = rows.into_points().unwrap_err().to_string();
        assert_eq!(
            message,
            "point 1 has 1 coordinates, and the first one has 2"
        );
        for (flat, dimension) in [(&[1.0; 5][..], 2), (&[1.0; 4], 0), (&[1.0; 34], 17)] {
            assert!((flat, dimension).into_points().is_err());
        }
        let grid = vec![vec![[0.0; 3]; 2], vec![[0.0; 3]; 3]];
        let message = grid.into_grid().unwrap_err().to_string();
        assert_eq!(message, "row 1 has 3 points, and the first one has 2");
    }
}
