//! The faces of meshes as triangles, and the piece of a mesh whose vertices are the points of a surface.

use std::collections::{HashMap, HashSet};

use super::error::FileError;
use super::imported::Hints;
use super::part::Part;
use piad_fit::data::Points;
use piad_fit::parameters::{MAX_TRIANGLES, pieces};

/// The hint that chooses a piece.
const PIECE: &str = "piece";

/// No vertex.
const NONE: u32 = u32::MAX;

/// The triangles of faces.
#[derive(Debug, Default)]
pub(super) struct Faces {
    pub(super) triangles: Vec<[u32; 3]>,
}

impl Faces {
    /// Appends a polygon as a fan of triangles around its first corner.
    ///
    /// # Errors
    ///
    /// If there are more triangles than the limit.
    pub(super) fn push(&mut self, corners: &[u32], line: Option<usize>) -> Result<(), FileError> {
        if self.triangles.len() + corners.len().saturating_sub(2) > MAX_TRIANGLES {
            let detail = format!("there are more than {MAX_TRIANGLES} triangles, the limit");
            return Err(FileError::new(line, detail));
        }
        if let [first, rest @ ..] = corners {
            let pairs = rest.windows(2);
            let triangle = |pair: &[u32]| Some([*first, *pair.first()?, *pair.last()?]);
            self.triangles.extend(pairs.filter_map(triangle));
        }
        Ok(())
    }

    /// The triangles between renumbered vertices; triangles with an omitted vertex are omitted.
    pub(super) fn renumbered(mut self, numbers: &[u32]) -> Self {
        self.triangles = renumbered(&self.triangles, numbers);
        self
    }
}

/// The error for an index of a vertex, from 0, that does not exist.
pub(super) fn not_there(index: &str, count: usize, format: &str, line: Option<usize>) -> FileError {
    let detail = format!("there is no vertex {index}, the file has {count}, from 0 ({format})");
    FileError::new(line, detail)
}

fn renumbered(triangles: &[[u32; 3]], numbers: &[u32]) -> Vec<[u32; 3]> {
    let number = |index: u32| numbers.get(index as usize).copied().unwrap_or(NONE);
    let moved = triangles.iter().map(|it| it.map(number));
    moved.filter(|it| !it.contains(&NONE)).collect()
}

/// Keeps the vertices and the triangles of one piece of a mesh: the largest one, or that of the hints. Vertices at the
/// same place are merged.
///
/// # Errors
///
/// There are fewer pieces than the number of the one in the hints.
pub(super) fn take_piece(part: &mut Part, hints: &Hints) -> Result<(), FileError> {
    let first = first_there(&part.points);
    let all = renumbered(&part.triangles, &first);
    let mut seen = HashSet::new();
    let is_new = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle;
        let mut sorted = *triangle;
        sorted.sort_unstable();
        a != b && b != c && c != a && seen.insert(sorted)
    };
    let mut triangles: Vec<[u32; 3]> = all.into_iter().filter(is_new).collect();
    let left_out = part.triangles.len() - triangles.len();
    let branching = leave_branches_out(&mut triangles);
    let of = pieces(&triangles);
    let count = of.iter().max().map_or(0, |last| *last as usize + 1);
    let wanted = hints.piece.unwrap_or(1);
    if count == 0 || wanted == 0 || wanted > count {
        let detail = match count {
            0 => "the file has no triangles, and so no pieces of a mesh".to_owned(),
            1 => "the mesh of the file is one piece: piece 1".to_owned(),
            _ => format!("the mesh of the file has pieces 1 to {count}, the largest first"),
        };
        return match (hints.piece, count) {
            (None, 0) => {
                part.triangles.clear();
                Ok(())
            }
            _ => Err(FileError::of_hint(PIECE, detail)),
        };
    }
    let mut numbers = of.iter();
    triangles.retain(|_| {
        numbers
            .next()
            .is_some_and(|piece| *piece as usize + 1 == wanted)
    });
    let before = part.points.len();
    let merged = first
        .iter()
        .enumerate()
        .filter(|(index, first)| *index != **first as usize);
    let merged = merged.count();
    keep_used(part, &triangles);
    let kept = part.points.len();
    part.notices
        .push(notice(wanted, count, (part.triangles.len(), kept)));
    let rest = before - merged - kept;
    let said = [
        (
            merged,
            "are at the place of another one, and are one with it",
        ),
        (rest, "are in no triangle of it, and are left out"),
    ];
    for (count, what) in said {
        if count > 0 {
            part.notices
                .push(format!("{count} vertices of the file {what}."));
        }
    }
    if branching > 0 {
        part.notices.push(format!(
            "{branching} triangles are left out, with which the mesh branches at an edge, or touches itself in a point."
        ));
    }
    if left_out > 0 {
        part.notices.push(format!(
            "{left_out} triangles without three corners, or between those of another one, are left out."
        ));
    }
    Ok(())
}

/// The most rounds in which triangles are left out.
const ROUNDS: usize = 100;

/// Leaves triangles out until each edge has one or two, and those around each vertex are one fan: of an edge with more the
/// later ones, of a vertex those of the smaller fans. Returns how many.
fn leave_branches_out(triangles: &mut Vec<[u32; 3]>) -> usize {
    let before = triangles.len();
    for _ in 0..ROUNDS {
        let kept = unbranched(triangles);
        if kept.iter().all(|is_kept| *is_kept) {
            break;
        }
        let mut kept = kept.into_iter();
        triangles.retain(|_| kept.next() == Some(true));
    }
    before - triangles.len()
}

/// Which triangles are kept in a round.
fn unbranched(triangles: &[[u32; 3]]) -> Vec<bool> {
    let mut kept = vec![true; triangles.len()];
    let mut drop = |triangle: usize| {
        if let Some(is_kept) = kept.get_mut(triangle) {
            *is_kept = false;
        }
    };
    // Each edge with its triangle, and the corners of this at its ends, the lower vertex first.
    let mut edges: Vec<([u32; 2], [usize; 2])> = Vec::with_capacity(3 * triangles.len());
    for (t, &[a, b, c]) in triangles.iter().enumerate() {
        for (from, to, k) in [(a, b, 0), (b, c, 1), (c, a, 2)] {
            let corners = [3 * t + k, 3 * t + (k + 1) % 3];
            edges.push(match from < to {
                true => ([from, to], corners),
                false => ([to, from], [corners[1], corners[0]]),
            });
        }
    }
    edges.sort_unstable();
    let mut fans = Fans::new(3 * triangles.len());
    for same in edges.chunk_by(|a, b| a.0 == b.0) {
        same.iter()
            .skip(2)
            .for_each(|(_, [corner, _])| drop(corner / 3));
        if let [(_, one), (_, other), ..] = same {
            one.iter().zip(other).for_each(|(a, b)| fans.join(*a, *b));
        }
    }
    // The fans around each vertex: all corners of a vertex, with the first corner of their fan.
    let mut corners: Vec<(u32, usize)> = Vec::with_capacity(3 * triangles.len());
    for (corner, vertex) in triangles.iter().flatten().enumerate() {
        corners.push((*vertex, fans.first(corner)));
    }
    let mut sizes = vec![0_u32; corners.len()];
    for (_, fan) in &corners {
        if let Some(size) = sizes.get_mut(*fan) {
            *size += 1;
        }
    }
    let size = |fan: usize| sizes.get(fan).copied().unwrap_or_default();
    let mut largest: HashMap<u32, usize> = HashMap::new();
    for &(vertex, fan) in &corners {
        let most = largest.entry(vertex).or_insert(fan);
        if (size(fan), std::cmp::Reverse(fan)) > (size(*most), std::cmp::Reverse(*most)) {
            *most = fan;
        }
    }
    for (corner, (vertex, fan)) in corners.iter().enumerate() {
        if largest.get(vertex) != Some(fan) {
            drop(corner / 3);
        }
    }
    kept
}

/// Corners of triangles that are joined.
struct Fans(Vec<usize>);

impl Fans {
    fn new(count: usize) -> Self {
        Self((0..count).collect())
    }

    /// The first corner of a fan.
    fn first(&mut self, mut of: usize) -> usize {
        while let Some(&above) = self.0.get(of).filter(|above| **above != of) {
            let next = self.0.get(above).copied().unwrap_or(above);
            if let Some(place) = self.0.get_mut(of) {
                *place = next;
            }
            of = next;
        }
        of
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.first(a), self.first(b));
        if let Some(place) = self.0.get_mut(a.max(b)) {
            *place = a.min(b);
        }
    }
}

/// The notice about a piece.
fn notice(piece: usize, count: usize, (triangles, points): (usize, usize)) -> String {
    match (count, piece) {
        (1, _) => format!(
            "The points are the {points} vertices of a mesh with {triangles} triangles, which give them parameters."
        ),
        (_, 1) => format!(
            "The mesh has {count} pieces: the points are the {points} vertices of the largest one, whose {triangles} triangles give them parameters."
        ),
        _ => format!(
            "The mesh has {count} pieces: the points are the {points} vertices of piece {piece}, whose {triangles} triangles give them parameters."
        ),
    }
}

/// For each point the first one at its place; 0 and -0 are the same.
fn first_there(points: &Points) -> Vec<u32> {
    let mut known: HashMap<Vec<u64>, u32> = HashMap::with_capacity(points.len());
    (0..points.len())
        .map(|index| {
            let place = points.point(index).map(|x| (x + 0.0).to_bits()).collect();
            *known.entry(place).or_insert(index as u32)
        })
        .collect()
}

/// Keeps the points that are corners of triangles.
fn keep_used(part: &mut Part, triangles: &[[u32; 3]]) {
    let mut numbers = vec![NONE; part.points.len()];
    for &index in triangles.iter().flatten() {
        if let Some(number) = numbers.get_mut(index as usize) {
            *number = 0;
        }
    }
    let kept: Vec<usize> = (0..numbers.len())
        .filter(|&index| numbers.get(index) == Some(&0))
        .collect();
    for (number, &index) in kept.iter().enumerate() {
        if let Some(place) = numbers.get_mut(index) {
            *place = number as u32;
        }
    }
    part.keep(&kept);
    part.triangles = renumbered(triangles, &numbers);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::import::tests::HINTS;
    use crate::import::{Imported, Kind, read};

    fn surface(text: &str, piece: Option<usize>) -> Result<Imported, String> {
        let kind = Some(Kind::Surface);
        let hints = Hints {
            kind,
            piece,
            ..HINTS
        };
        read(text.as_bytes(), &hints).map_err(|errors| errors.to_string())
    }

    /// A square of four triangles around a middle, a triangle beside it, and a vertex of neither.
    const VERTICES: [&str; 9] = [
        "0 0 0", "2 0 0", "2 2 0", "0 2 0", "1 1 1", "5 0 0", "7 0.5 0", "5 1 3", "9 9 9",
    ];

    fn obj() -> String {
        let vertices = VERTICES.map(|vertex| format!("v {vertex}\n"));
        let faces = "f 1 2 5\nf 2/1 3/2/2 5//3\nf 3 4 5\nf -6 -9 -5\nf 6 7 8\nf 8 7 6\nf 1 2 2\n";
        format!("o cap\n{}{faces}", vertices.concat())
    }

    #[test]
    fn the_largest_piece_is_taken() {
        let whole = surface(&obj(), None).unwrap();
        assert_eq!(whole.points.len(), 5);
        assert_eq!(
            whole.triangles,
            [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]
        );
        assert_eq!(whole.lines, [2, 3, 4, 5, 6]);
        assert_eq!(
            whole.notices,
            [
                "The file has a mesh of 9 vertices and 7 faces (OBJ).",
                "The mesh has 2 pieces: the points are the 5 vertices of the largest one, whose 4 triangles give them parameters.",
                "4 vertices of the file are in no triangle of it, and are left out.",
                "2 triangles without three corners, or between those of another one, are left out.",
            ]
        );
        let second = surface(&obj(), Some(2)).unwrap();
        assert_eq!(
            (second.points.len(), &second.triangles[..]),
            (3, &[[0, 1, 2]][..])
        );
        for piece in [0, 3] {
            let error = surface(&obj(), Some(piece)).unwrap_err();
            assert!(error.contains("pieces 1 to 2"), "{error}");
        }
    }

    /// A mesh that branches at an edge and touches itself in a vertex loses the smaller part there.
    #[test]
    fn branches_are_left_out() {
        let mut triangles: Vec<[u32; 3]> = (0..6).map(|k| [0, k + 1, (k + 1) % 6 + 1]).collect();
        assert_eq!(leave_branches_out(&mut triangles), 0);
        // A fan of two beside vertex 0, and a third triangle on an edge.
        triangles.extend([[0, 10, 11], [0, 11, 12], [1, 2, 13]]);
        assert_eq!(leave_branches_out(&mut triangles), 2);
        triangles.push([2, 1, 14]);
        assert_eq!(leave_branches_out(&mut triangles), 1);
        assert_eq!(triangles.len(), 7);
    }

    /// The same mesh in all formats.
    #[test]
    fn all_formats_have_faces() {
        let vertices = VERTICES.map(|vertex| format!("{vertex}\n")).concat();
        let faces = "3 0 1 4\n4 1 2 3 4\n3 3 0 4\n3 5 6 7\n";
        let off = format!("OFF\n9 4 0\n{vertices}{faces}");
        let ply = format!(
            "ply\nformat ascii 1.0\nelement vertex 9\nproperty float x\nproperty float y\nproperty float z\nelement edge 1\nproperty int a\nelement face 4\nproperty uchar red\nproperty list uchar int vertex_indices\nend_header\n{vertices}7\n{}",
            faces
                .replace("\n3 ", "\n9 3 ")
                .replace("\n4 ", "\n9 4 ")
                .replacen("3 0", "9 3 0", 1)
        );
        let expected = [[0, 1, 4], [1, 2, 3], [1, 3, 4], [3, 0, 4]];
        for text in [&off, &ply] {
            let mesh = surface(text, None).unwrap();
            assert_eq!(
                (mesh.points.len(), &mesh.triangles[..]),
                (5, &expected[..]),
                "{text}"
            );
        }
        let corner = |index: u32| format!("vertex {}\n", VERTICES[index as usize]);
        let facet = |it: &[u32; 3]| {
            format!(
                "facet\nouter loop\n{}endloop\nendfacet\n",
                it.map(corner).concat()
            )
        };
        let facets: String = expected.iter().map(facet).collect();
        let stl = surface(&format!("solid\n{facets}endsolid\n"), None).unwrap();
        assert_eq!(stl.points.len(), 5);
        assert_eq!(stl.triangles, [[0, 1, 2], [1, 3, 4], [1, 4, 2], [4, 0, 2]]);
        // A file without faces is a cloud.
        let cloud = surface(&format!("OFF\n9 0 0\n{vertices}"), None).unwrap();
        assert_eq!((cloud.points.len(), cloud.triangles.len()), (9, 0));
        let error = surface(&format!("OFF\n9 0 0\n{vertices}"), Some(1)).unwrap_err();
        assert!(error.contains("no triangles"), "{error}");
    }

    /// Faces between vertices that are not there.
    #[test]
    fn wrong_faces_are_refused() {
        let vertices = VERTICES.map(|vertex| format!("{vertex}\n")).concat();
        let ply = format!(
            "ply\nformat ascii 1.0\nelement vertex 9\nproperty float x\nproperty float y\nproperty float z\nelement face 2\nproperty list uchar int vertex_index\nend_header\n{vertices}"
        );
        for (text, expected) in [
            (
                obj() + "f 1 2 10\n",
                "line 18: there is no vertex 10, the file has 9 (OBJ)",
            ),
            (
                obj() + "f 1 2\n",
                "line 18: a face has at least 3 corners, and this one 2 (OBJ)",
            ),
            (
                obj() + "f 1 2 x\n",
                "line 18: \"x\" is not the number of a vertex (OBJ)",
            ),
            (
                format!("OFF\n9 1 0\n{vertices}3 0 1 9\n"),
                "line 12: there is no vertex 9, the file has 9, from 0 (OFF)",
            ),
            (
                format!("OFF\n9 1 0\n{vertices}3 0 1\n"),
                "line 12: this face has 2 corners, and says that it has 3 (OFF)",
            ),
            (
                format!("OFF\n9 2 0\n{vertices}3 0 1 2\n"),
                "the file has 1 faces, and says that it has 2 (OFF)",
            ),
            (
                format!("{ply}3 0 1 2\n"),
                "the file has 1 faces, and says that it has 2 (PLY)",
            ),
            (
                format!("{ply}3 0 1 2\n3 0 1 -1\n"),
                "line 20: there is no vertex -1, the file has 9, from 0 (PLY)",
            ),
        ] {
            assert_eq!(surface(&text, None).unwrap_err(), expected, "{text}");
        }
    }
}
