//! The polylines of OBJ files, which are lists of the numbers of their vertices.

use super::super::cloud::too_many;
use super::super::error::FileError;
use super::super::part::{Order, Part};
use crate::text::quoted;
use piad_fit::data::Points;

/// The polylines that were read so far.
pub(super) struct Polylines {
    polylines: Vec<Polyline>,
    /// The number of their points, and the most that are allowed.
    count: usize,
    most: usize,
}

struct Polyline {
    /// The indices of the vertices.
    vertices: Vec<usize>,
    name: Option<String>,
    line: usize,
    /// True if it was one line from a vertex to another, or several that follow each other.
    is_chain: bool,
}

impl Polylines {
    pub(super) fn new(most: usize) -> Self {
        Self {
            polylines: Vec::new(),
            count: 0,
            most,
        }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.polylines.is_empty()
    }

    /// Appends a polyline of these words, `vertex` or `vertex/texture`, below this number of vertices. Programs write
    /// curves as lines of two vertices, too: if one begins where the last one ended, it continues it.
    pub(super) fn push<'a>(
        &mut self,
        words: impl Iterator<Item = &'a str>,
        above: usize,
        name: Option<&str>,
        at: usize,
    ) -> Result<(), FileError> {
        let vertices = words.map(|word| vertex_index(word, above, at));
        let vertices: Vec<usize> = vertices.collect::<Result<_, _>>()?;
        if vertices.len() < 2 {
            let detail = format!(
                "a polyline has at least 2 vertices, and this one {}",
                vertices.len()
            );
            return Err(FileError::at(at, detail));
        }
        let last = self.polylines.last_mut();
        let last = last.filter(|last| last.is_chain && last.name.as_deref() == name);
        let continued = match (last, &vertices[..]) {
            (Some(last), [start, end]) => last.continues(*start, *end),
            _ => false,
        };
        self.count += match continued {
            true => 1,
            false => vertices.len(),
        };
        if !continued {
            self.polylines.push(Polyline {
                is_chain: vertices.len() == 2,
                vertices,
                name: name.map(str::to_owned),
                line: at,
            });
        }
        match self.count > self.most {
            true => Err(FileError::at(at, too_many(self.most))),
            false => Ok(()),
        }
    }

    /// The polylines as parts, with the coordinates of their vertices, and the lines of these.
    pub(super) fn parts(self, points: &Points, lines: &[u32]) -> Result<Vec<Part>, FileError> {
        let part = |polyline: Polyline| {
            let vertices = &polyline.vertices;
            if let Some(vertex) = vertices.iter().find(|vertex| **vertex >= points.len()) {
                return Err(no_vertex(*vertex as u64 + 1, points.len(), polyline.line));
            }
            let lanes = points.lanes().iter();
            let lanes: Vec<Vec<f64>> = lanes.map(|lane| chosen(lane, vertices)).collect();
            let lines = chosen(lines, vertices);
            Ok(Part {
                name: polyline.name,
                ..Part::ordered(Points::from_lanes(lanes), lines, Order::Curve)?
            })
        };
        self.polylines.into_iter().map(part).collect()
    }
}

impl Polyline {
    /// Continues a chain by a line between two vertices, if they meet. The first line of a chain has no direction yet.
    fn continues(&mut self, start: usize, end: usize) -> bool {
        let meets = |last: Option<&usize>| match last {
            Some(last) if *last == start => Some(end),
            Some(last) if *last == end => Some(start),
            _ => None,
        };
        let mut next = meets(self.vertices.last());
        if next.is_none() && self.vertices.len() == 2 {
            next = meets(self.vertices.first());
            if next.is_some() {
                self.vertices.reverse();
            }
        }
        self.vertices.extend(next);
        next.is_some()
    }
}

/// The index of a vertex in a line.
pub(super) fn vertex_index(word: &str, above: usize, at: usize) -> Result<usize, FileError> {
    index(word, above).ok_or_else(|| {
        let detail = format!("{} is not the number of a vertex (OBJ)", quoted(word));
        FileError::at(at, detail)
    })
}

/// The error for the number of a vertex that does not exist.
pub(super) fn no_vertex(number: u64, count: usize, at: usize) -> FileError {
    let detail = format!("there is no vertex {number}, the file has {count} (OBJ)");
    FileError::at(at, detail)
}

/// The index of a vertex by its number from 1, or from -1 for the last one above the line.
fn index(word: &str, above: usize) -> Option<usize> {
    let number = word.split('/').next()?.parse::<i64>().ok()?;
    match number {
        1.. => usize::try_from(number - 1).ok(),
        _ => {
            let back = usize::try_from(number.checked_neg()?).ok()?;
            above.checked_sub(back).filter(|_| back > 0)
        }
    }
}

fn chosen<T: Copy>(values: &[T], indices: &[usize]) -> Vec<T> {
    let value = |index: &usize| values.get(*index).copied();
    indices.iter().filter_map(value).collect()
}
