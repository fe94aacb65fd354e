//! The pieces between the corners of a fit that chooses its knots: each is such a fit by itself.

use std::ops::Range;
use std::sync::Arc;

use super::Problem;
use super::corners::{ends_of_pieces, unrolled};
use super::request::{Request, Tolerance};
use crate::basis::choice::{Corners, DirectionChoice};
use crate::data::grid::Grid;
use crate::data::points::Points;
use crate::invalid::{Axis, Invalid, Place};
use crate::knot_selection::edges::Edges;
use crate::knot_selection::guide::Guide;
use crate::method::{AS_MANY_AS_DATA, EndPoints, LeastSquares, Method};
use crate::parameters::Parametrization;

impl Problem {
    /// The data points at the corners of a curve.
    pub(crate) fn corners(&self) -> Option<&[usize]> {
        match (&self.request.u.corners, &self.request.v) {
            (Some(Corners::At(corners)), None) => Some(corners),
            _ => None,
        }
    }

    /// The data points at the ends of the pieces between corners, with indices beyond their number on a closed curve.
    fn ends_of_pieces(&self) -> Option<Vec<usize>> {
        let count = self.grid().count();
        Some(ends_of_pieces(self.corners()?, count, self.u().is_closed()))
    }

    /// The data of each piece between corners, with indices beyond their number on a closed curve.
    pub(crate) fn data_of_pieces(&self) -> Option<Vec<Range<usize>>> {
        let ends = self.ends_of_pieces()?;
        Some(ends.windows(2).map(|ends| ends[0]..ends[1] + 1).collect())
    }

    /// The most control points that the pieces can have together.
    pub(super) fn most_control_points_of_pieces(&self) -> Option<usize> {
        let data = self.data_of_pieces()?;
        let fewest = self.u().basis.degree() + 1;
        let most = |data: &Range<usize>| self.most_beside_data(data.len()).max(fewest);
        Some(data.iter().map(most).sum())
    }

    /// The largest number of control points of a curve with this number of data, and points between them.
    pub(super) fn most_beside_data(&self, data: usize) -> usize {
        match self.request.polyline {
            true => Edges::most(data),
            false => Guide::most_control_points(data),
        }
    }

    /// The pieces between corners as problems of their own, which begin where this one begins.
    pub(crate) fn pieces(&self) -> Result<Vec<Arc<Self>>, Invalid> {
        let Some((data, (settings, _))) = self.data_of_pieces().zip(self.method().automatic())
        else {
            return Ok(Vec::new());
        };
        let degree = self.u().basis.degree();
        let most = self.shares(&data, settings.u)?;
        let starts = self.starts_of_pieces(&data);
        let corners = self.corners().unwrap_or_default();
        let t = unrolled(&self.u().parameters, corners, self.u().period());
        let piece = |(i, data): (usize, &Range<usize>)| {
            // One edge is a straight line without points on it.
            let is_polyline = self.request.polyline && data.len() > 2;
            let indices = data.clone().map(|index| index % self.grid().count());
            let points = self.data().selected(indices.clone());
            let weights = settings.data_weights.as_ref();
            let weights = weights.map(|all| indices.map(|index| all[index]).collect());
            // Few data do not determine control points that move on from others.
            let start = starts.get(i).filter(|_| data.len() > degree || is_polyline);
            let (start, breaks) = start.cloned().unzip();
            let choice = DirectionChoice {
                closed: false,
                corners: Some(Corners::At(Arc::new([]))),
                parameters: Parametrization::Explicit(Arc::new(t[data.clone()].to_vec())),
                ..self.request.u.clone()
            };
            let grid = Grid {
                rows: data.len(),
                columns: 1,
            };
            let request = Request {
                method: Method::LeastSquares(LeastSquares {
                    u: most[i],
                    ends: EndPoints::Usual,
                    data_weights: weights,
                    ..settings.clone()
                }),
                start: start.map(Arc::new),
                start_breaks: breaks.map(|breaks| vec![Arc::new(breaks)]),
                polyline: is_polyline,
                tolerance: Some(Tolerance::Absolute(self.tolerance)),
                max_iterations: self.max_iterations(),
                ..Request::new(points, grid, choice, None)
            };
            Self::new(request).map(Arc::new)
        };
        data.iter().enumerate().map(piece).collect()
    }

    /// The largest number of control points of each piece: what is allowed beyond the fewest is shared by numbers of
    /// data.
    fn shares(&self, data: &[Range<usize>], most: usize) -> Result<Vec<usize>, Invalid> {
        let degree = self.u().basis.degree();
        let fewest = data.len() * degree + usize::from(!self.u().is_closed());
        let Some(others) = most.checked_sub(fewest) else {
            let corners = self.corners().map_or(0, <[usize]>::len);
            let detail = format!(
                "a curve of degree {degree} with {corners} corners has at least {fewest} control points, not {most}"
            );
            return Err(Invalid::at(Place::ControlPoints(Axis::U), detail));
        };
        let all: usize = data.iter().map(Range::len).sum();
        let share = |data: &Range<usize>| match most >= all {
            true => AS_MANY_AS_DATA,
            false => degree + 1 + others * data.len() / all,
        };
        Ok(data.iter().map(share).collect())
    }

    /// The control points and the breaks with which each piece begins, if this problem has a start.
    fn starts_of_pieces(&self, data: &[Range<usize>]) -> Vec<(Points, Vec<f64>)> {
        let breaks = self
            .request
            .start_breaks
            .as_ref()
            .and_then(|all| all.first());
        let Some((start, breaks)) = self.start().zip(breaks) else {
            return Vec::new();
        };
        let (degree, direction) = (self.u().basis.degree(), self.u());
        let corners = self.corners().unwrap_or_default();
        let t = unrolled(&direction.parameters, corners, direction.period());
        let last = breaks.len() - 1;
        let place = |end: usize| breaks.partition_point(|knot| *knot < t[end]).min(last);
        let start_of = |data: &Range<usize>| {
            let (from, to) = (place(data.start), place(data.end - 1));
            // The knot of a corner comes p times.
            let first = if from == 0 { 0 } else { from + degree - 1 };
            let functions = first..to + degree;
            let control_points = functions.map(|j| direction.free_index(j));
            (start.selected(control_points), breaks[first..=to].to_vec())
        };
        data.iter().map(start_of).collect()
    }
}
