//! The points of clouds and meshes, one after the other, up to the limit.

use super::error::FileError;
use super::part::{Order, Part};
use crate::text::quoted;
use piad_fit::data::Points;

/// The most names that a notice lists.
const MOST_NAMES: usize = 10;

/// Points without an order.
#[derive(Debug)]
pub(super) struct Cloud {
    points: Points,
    lines: Vec<u32>,
    /// The number of points with coordinates that are infinite or NaN.
    left_out: usize,
    most: usize,
}

impl Cloud {
    /// No points, with a limit of `most`, and capacity for those that the bytes of a file can hold.
    pub(super) fn new(dimension: usize, room: usize, most: usize) -> Self {
        Self {
            points: Points::with_room(dimension, room.min(most)),
            lines: Vec::new(),
            left_out: 0,
            most,
        }
    }

    /// The number of points.
    pub(super) fn len(&self) -> usize {
        self.points.len()
    }

    /// Appends a point of this line, in formats with lines, or leaves it out if its coordinates are not finite.
    ///
    /// # Errors
    ///
    /// If there are more points than the limit.
    pub(super) fn push(&mut self, point: &[f64], line: Option<usize>) -> Result<(), FileError> {
        if !point.iter().all(|x| x.is_finite()) {
            self.left_out += 1;
            return Ok(());
        }
        if self.points.len() >= self.most {
            let detail = too_many(self.most);
            return Err(FileError::new(line, detail));
        }
        self.points.push(point);
        if let Some(line) = line {
            self.lines.push(u32::try_from(line).unwrap_or(u32::MAX));
        }
        Ok(())
    }

    /// The points and their lines, as they are.
    pub(super) fn into_points(self) -> (Points, Vec<u32>) {
        (self.points, self.lines)
    }

    /// All points as a part of a file.
    ///
    /// # Errors
    ///
    /// If there are fewer than two.
    pub(super) fn part(self, mut notices: Vec<String>) -> Result<Part, FileError> {
        match self.left_out {
            0 => {}
            count if self.points.is_empty() => {
                let detail = format!("none of the {count} points of the file has coordinates");
                return Err(FileError::of_file(detail));
            }
            1 => notices.push("1 point has no coordinates and is left out.".to_owned()),
            count => notices.push(format!(
                "{count} points have no coordinates and are left out."
            )),
        }
        let mut points = self.points;
        points.shrink_to_fit();
        Ok(Part {
            notices,
            ..Part::ordered(points, self.lines, Order::None)?
        })
    }
}

/// The error for more points than the limit.
pub(super) fn too_many(most: usize) -> String {
    format!("there are more than {most} points, the limit")
}

/// The error for a file that ends early.
pub(super) fn too_few(found: usize, said: u64, what: &str, format: &str) -> FileError {
    let detail = format!("the file has {found} {what}, and says that it has {said} ({format})");
    FileError::of_file(detail)
}

/// The notice about the vertices of a mesh, or a file without faces.
pub(super) fn mesh_notice(vertices: usize, faces: u64, format: &str) -> String {
    match faces {
        0 => format!("The points are the {vertices} vertices of the file ({format})."),
        1 => format!("The file has a mesh of {vertices} vertices and one face ({format})."),
        _ => format!("The file has a mesh of {vertices} vertices and {faces} faces ({format})."),
    }
}

/// The notice about values of points that are not coordinates, if there are any.
pub(super) fn not_read<'a>(what: &str, names: impl IntoIterator<Item = &'a str>) -> Option<String> {
    let mut names: Vec<&str> = names.into_iter().collect();
    let more = match names.len() > MOST_NAMES {
        true => ", …",
        false => "",
    };
    names.truncate(MOST_NAMES);
    let names: Vec<String> = names.into_iter().map(quoted).collect();
    let names = names.join(", ");
    (!names.is_empty()).then(|| format!("{what} of the points that are not read: {names}{more}."))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_without_coordinates_are_left_out() {
        let mut cloud = Cloud::new(2, usize::MAX, 2);
        cloud.push(&[1.0, 2.0], None).unwrap();
        cloud.push(&[f64::NAN, 2.0], None).unwrap();
        cloud.push(&[1.0, 3.0], None).unwrap();
        cloud.push(&[1.0, f64::INFINITY], None).unwrap();
        let error = cloud.push(&[1.0, 4.0], Some(7)).unwrap_err();
        assert_eq!(
            error.to_string(),
            "line 7: there are more than 2 points, the limit"
        );
        let part = cloud.part(vec![]).unwrap();
        assert_eq!(part.points.to_flat(), [1.0, 2.0, 1.0, 3.0]);
        assert_eq!(
            part.notices,
            ["2 points have no coordinates and are left out."]
        );
        let mut none = Cloud::new(1, 0, 2);
        none.push(&[f64::NAN], None).unwrap();
        let error = none.part(vec![]).unwrap_err();
        assert_eq!(
            error.detail,
            "none of the 1 points of the file has coordinates"
        );
    }

    #[test]
    fn few_names_are_listed() {
        assert_eq!(not_read("Fields", []), None);
        assert_eq!(
            not_read("Fields", ["rgb", "\n"]).unwrap(),
            "Fields of the points that are not read: \"rgb\", \"\\n\"."
        );
        let many = not_read("Fields", ["a"; 40]).unwrap();
        assert!(many.ends_with("\"a\", …."), "{many}");
    }
}
