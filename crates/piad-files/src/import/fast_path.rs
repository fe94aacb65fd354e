//! A fast path for lines that hold one point like those before them: most lines of every large file. All threads read
//! pieces, a limited number at a time, as these are in memory twice until they are copied to their place.

use rayon::prelude::*;

use super::layout::Layout;
use super::line::is_comment;
use piad_fit::data::MAX_DIMENSION;

/// The least length of a text for which this pays.
const LEAST: usize = 64 * 1024;

/// The length of text that a thread reads at a time.
const PIECE: usize = 256 * 1024;

/// The number of pieces that each thread reads before they are copied to their place.
const PIECES: usize = 4;

/// The most numbers of a line that are read: coordinates, and a time.
const MOST_LANES: usize = MAX_DIMENSION + 1;

/// The points of some lines.
#[derive(Debug, Default)]
pub(super) struct Piece {
    /// Their coordinates.
    pub(super) lanes: Vec<Vec<f64>>,
    /// The line of each point, from 0.
    pub(super) lines: Vec<u32>,
    /// The indices of points before which there were blank lines.
    pub(super) breaks: Vec<usize>,
    /// The number of its lines.
    pub(super) count: u32,
}

/// Reads the points of a text, piece by piece, and copies each to its place. `None` if the text is short or a line is
/// anything but a point in plain numbers and gaps, or blank.
pub(super) fn points(
    text: &str,
    end: char,
    layout: &Layout,
    mut put: impl FnMut(&[Piece]),
) -> Option<()> {
    if text.len() < LEAST {
        return None;
    }
    for pieces in pieces(text, end).chunks(PIECES * rayon::current_num_threads()) {
        let read = |piece: &&str| read(piece, end, layout);
        let pieces: Option<Vec<Piece>> = pieces.par_iter().map(read).collect();
        put(&pieces?);
    }
    Some(())
}

/// The number of lines of a text.
pub(super) fn count_lines(text: &str, end: char) -> usize {
    let ends = memchr::memchr_iter(end as u8, text.as_bytes()).count();
    ends + usize::from(!text.ends_with(end))
}

/// The text in pieces of whole lines, each without its last end of line.
fn pieces(mut text: &str, end: char) -> Vec<&str> {
    let mut pieces = Vec::with_capacity(text.len() / PIECE + 1);
    let bytes_until_end = |text: &str| {
        let rest = text.as_bytes().get(PIECE..)?;
        let place = rest.iter().position(|byte| *byte == end as u8)?;
        Some(PIECE + place)
    };
    while let Some((piece, rest)) = bytes_until_end(text).and_then(|at| text.split_at_checked(at)) {
        pieces.push(piece);
        text = rest.strip_prefix(end).unwrap_or(rest);
    }
    pieces.push(text);
    pieces
}

fn read(text: &str, end: char, layout: &Layout) -> Option<Piece> {
    let dimension = layout.lanes();
    let lines = count_lines(text, end);
    let mut piece = Piece {
        lanes: (0..dimension).map(|_| Vec::with_capacity(lines)).collect(),
        lines: Vec::with_capacity(lines),
        ..Piece::default()
    };
    let mut point = [0.0; MOST_LANES];
    let point = point.get_mut(..dimension)?;
    for line in text.split(end) {
        let line = layout.trimmed(line);
        // Most lines begin with a number, which is seen at once.
        let is_number = matches!(line.as_bytes(), [b'0'..=b'9' | b'+' | b'-' | b'.', ..]);
        if !is_number && line.trim().is_empty() {
            piece.breaks.push(piece.lines.len());
        } else if is_number || !is_comment(line) {
            layout.plain_point(line, point)?;
            for (lane, x) in piece.lanes.iter_mut().zip(&*point) {
                lane.push(*x);
            }
            piece.lines.push(piece.count);
        }
        piece.count += 1;
    }
    Some(piece)
}
