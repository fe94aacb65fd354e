//! The points of a part of a file, before it is known to be a curve or a surface.

use super::error::FileError;
use super::imported::chosen;
use crate::wgs84::Origin;
use piad_fit::data::{Grid, Points};

/// The output of a reader: the parts of a file, each a curve, a surface or a cloud.
#[derive(Debug, Default)]
pub(super) struct Parts {
    pub(super) parts: Vec<Part>,
    /// Notices about the file as a whole, in sentences.
    pub(super) notices: Vec<String>,
}

/// The points of one part, in the order of the file.
#[derive(Debug)]
pub(super) struct Part {
    pub(super) points: Points,
    /// The line of each point, from 1; empty for files without lines.
    pub(super) lines: Vec<u32>,
    /// The indices of points before which there were blank lines.
    pub(super) breaks: Vec<usize>,
    pub(super) order: Order,
    /// True if the curve is closed according to the file; its first point is kept once.
    pub(super) closed: bool,
    /// The indices of points that are missing in a grid, increasing; their coordinates mean nothing.
    pub(super) missing: Vec<usize>,
    /// The triangles of a mesh, by the indices of points.
    pub(super) triangles: Vec<[u32; 3]>,
    /// The time of each point in seconds from the first one, if the file has times.
    pub(super) times: Option<Vec<f64>>,
    /// True if the times are the parameters by default.
    pub(super) times_are_parameters: bool,
    /// The origin of the first two coordinates, if they were longitudes and latitudes.
    pub(super) origin: Option<Origin>,
    pub(super) name: Option<String>,
    pub(super) notices: Vec<String>,
}

/// What a file determines of the order of points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Order {
    /// Nothing: their order is detected.
    #[default]
    Unsaid,
    /// They follow each other along a curve.
    Curve,
    /// They are rows of a surface.
    Rows(Grid),
    /// They are sections of a surface, between which are the breaks.
    Sections,
    /// None: they are a cloud, or the vertices of a mesh.
    None,
}

impl Part {
    /// Points and their lines, if there are enough.
    ///
    /// # Errors
    ///
    /// If there are fewer than two.
    pub(super) fn new(points: Points, lines: Vec<u32>) -> Result<Self, FileError> {
        check_count(points.len())?;
        Ok(Self {
            points,
            lines,
            breaks: Vec::new(),
            order: Order::Unsaid,
            closed: false,
            missing: Vec::new(),
            triangles: Vec::new(),
            times: None,
            times_are_parameters: false,
            origin: None,
            name: None,
            notices: Vec::new(),
        })
    }

    /// Points of this order.
    ///
    /// # Errors
    ///
    /// If there are fewer than two.
    pub(super) fn ordered(
        points: Points,
        lines: Vec<u32>,
        order: Order,
    ) -> Result<Self, FileError> {
        let part = Self::new(points, lines)?;
        Ok(Self { order, ..part })
    }

    /// Counts the lines of a table that begins this many lines below the start of its file.
    pub(super) fn move_down(&mut self, lines: usize) {
        let lines = u32::try_from(lines).unwrap_or(u32::MAX);
        for line in &mut self.lines {
            *line = line.saturating_add(lines);
        }
    }

    /// Keeps the points of these indices, which increase.
    pub(super) fn keep(&mut self, kept: &[usize]) {
        let lanes = self.points.lanes().iter();
        let lanes: Vec<Vec<f64>> = lanes.map(|lane| chosen(lane, kept)).collect();
        self.points = Points::from_lanes(lanes);
        self.lines = chosen(&self.lines, kept);
        self.times = self.times.take().map(|times| chosen(&times, kept));
        for index in &mut self.breaks {
            *index = kept.partition_point(|it| it < index);
        }
    }

    /// The number of points of each of the parts between the breaks.
    pub(super) fn counts(&self) -> Vec<usize> {
        let starts = [0].into_iter().chain(self.breaks.iter().copied());
        let ends = self.breaks.iter().copied().chain([self.points.len()]);
        starts.zip(ends).map(|(start, end)| end - start).collect()
    }

    /// The parts between the blank lines.
    ///
    /// # Errors
    ///
    /// If one of them has one point, at its line.
    pub(super) fn split(self) -> Result<Vec<Self>, FileError> {
        let ends = self.breaks.iter().copied().chain([self.points.len()]);
        let mut start = 0;
        let part = |end: usize| {
            let range = start..end;
            start = end;
            let cut = |lane: &[f64]| lane.get(range.clone()).unwrap_or_default().to_vec();
            let points = Points::from_lanes(self.points.lanes().iter().map(|lane| cut(lane)));
            let lines = self.lines.get(range.clone()).unwrap_or_default().to_vec();
            if range.len() < 2 {
                let line = lines.first().map_or(1, |line| *line as usize);
                let detail = "this part has one point, and a curve has at least 2";
                return Err(FileError::at(line, detail));
            }
            Ok(Self {
                times: self.times.as_deref().map(cut),
                order: self.order,
                times_are_parameters: self.times_are_parameters,
                origin: self.origin,
                ..Self::new(points, lines)?
            })
        };
        ends.map(part).collect()
    }
}

impl From<Part> for Parts {
    fn from(part: Part) -> Self {
        Self {
            parts: vec![part],
            notices: Vec::new(),
        }
    }
}

/// The error for a file without points.
pub(super) const NO_POINTS: &str = "there are no points in the file";

/// Refuses fewer than two points.
pub(super) fn check_count(count: usize) -> Result<(), FileError> {
    let detail = match count {
        0 => NO_POINTS,
        1 => "there is one point in the file, and a curve has at least 2",
        _ => return Ok(()),
    };
    Err(FileError::of_file(detail))
}
