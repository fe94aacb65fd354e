//! Distances from the data along a curve and over a surface: the largest distance of the data points of each piece, or
//! the interpolated value for a piece without any; or the deviation of the fit between neighbours, if that is more.

use std::ops::RangeInclusive;

use super::measured::Measured;
use super::scale::Heat;
use crate::export::deviation::Deviations;
use piad_fit::engine::nurbs::SpanParameter;
use piad_fit::engine::{Direction, Problem};

/// The heat of the pieces of a curve between sites.
pub(super) fn of_pieces(
    problem: &Problem,
    measured: &Measured,
    sites: &[SpanParameter],
) -> Vec<Heat> {
    let deviations = &measured.deviations;
    let line = Line::new(problem.u(), &deviations.u, sites);
    let mut values = line.spread(&deviations.distances);
    fill(&mut values, 1);
    for (value, gaps) in values.iter_mut().zip(gaps(problem.u(), sites)) {
        *value = measured.between[gaps]
            .iter()
            .copied()
            .fold(*value, f64::max);
    }
    let heat = |value| Heat::of(value, measured.most);
    values.into_iter().map(heat).collect()
}

/// The heat of the faces of a surface between sites, row by row.
pub(super) fn of_faces(
    problem: &Problem,
    measured: &Measured,
    (rows, columns): (&[SpanParameter], &[SpanParameter]),
) -> Vec<Heat> {
    let deviations = &measured.deviations;
    let Some(across) = problem.v() else {
        return Vec::new();
    };
    let width = columns.len() - 1;
    let u = Line::new(problem.u(), &deviations.u, rows);
    let v = Line::new(across, &deviations.v, columns);
    let mut values = match deviations.scattered {
        true => binned(deviations, &u, &v),
        false => {
            let along = deviations.distances.chunks_exact(deviations.v.len());
            let narrow: Vec<f64> = along.flat_map(|row| v.spread(row)).collect();
            let column = |j: usize| {
                let values: Vec<f64> = narrow.iter().skip(j).step_by(width).copied().collect();
                u.spread(&values)
            };
            let columns: Vec<Vec<f64>> = (0..width).map(column).collect();
            let place = |i: usize| columns.iter().map(move |column| column[i]);
            (0..rows.len() - 1).flat_map(place).collect()
        }
    };
    fill(&mut values, width);
    if !measured.between.is_empty() {
        let cells = across.explicit_parameters().len() - 1;
        let (along, across) = (gaps(problem.u(), rows), gaps(across, columns));
        let faces = along
            .iter()
            .flat_map(|u| across.iter().map(move |v| (u, v)));
        for (value, (u, v)) in values.iter_mut().zip(faces) {
            for row in u.clone() {
                let cells = &measured.between[row * cells..][v.clone()];
                *value = cells.iter().copied().fold(*value, f64::max);
            }
        }
    }
    let heat = |value| Heat::of(value, measured.most);
    values.into_iter().map(heat).collect()
}

/// The gaps between the data of a direction that each piece between sites touches.
fn gaps(direction: &Direction, sites: &[SpanParameter]) -> Vec<RangeInclusive<usize>> {
    let parameters = direction.explicit_parameters();
    let last = parameters.len() - 2;
    let gap = |t: f64| {
        // A closed direction may begin in its last gap.
        let turn = direction.period().filter(|_| t < parameters[0]);
        let t = t + turn.unwrap_or(0.0);
        let after = parameters.partition_point(|it| *it <= t);
        after.saturating_sub(1).min(last)
    };
    let pieces = sites.windows(2).map(|ends| {
        let width = ends[1].t - ends[0].t;
        let [from, to] = [0.01, 0.99].map(|part| gap(ends[0].t + part * width));
        from..=to.max(from)
    });
    pieces.collect()
}

/// The parameters of data points in one direction, and the pieces between which they lie.
struct Line<'a> {
    parameters: &'a [f64],
    breaks: Vec<f64>,
    period: Option<f64>,
}

impl<'a> Line<'a> {
    fn new(direction: &Direction, parameters: &'a [f64], sites: &[SpanParameter]) -> Self {
        Self {
            parameters,
            breaks: sites.iter().map(|site| site.t).collect(),
            period: direction.period(),
        }
    }

    fn pieces(&self) -> usize {
        self.breaks.len() - 1
    }

    /// The piece that a parameter lies in.
    fn piece(&self, t: f64) -> usize {
        let after = self.breaks.partition_point(|it| *it <= t);
        after.saturating_sub(1).min(self.pieces() - 1)
    }

    /// From values at increasing parameters to values of the pieces.
    fn spread(&self, values: &[f64]) -> Vec<f64> {
        let mut spread = vec![f64::NAN; self.pieces()];
        for (&t, &value) in self.parameters.iter().zip(values) {
            let piece = &mut spread[self.piece(t)];
            *piece = piece.max(value);
        }
        for (piece, ends) in spread.iter_mut().zip(self.breaks.windows(2)) {
            let middle = (ends[0] + ends[1]) / 2.0;
            let after = self.parameters.partition_point(|it| *it <= middle);
            if piece.is_nan() {
                *piece = self.between(values, after, middle);
            }
        }
        spread
    }

    /// The value at a parameter before data point `after`, interpolated between its neighbours.
    fn between(&self, values: &[f64], after: usize, t: f64) -> f64 {
        let last = values.len() - 1;
        let at = |index: usize| (self.parameters[index], values[index]);
        let (before, next) = match (after, self.period) {
            (0, None) => (at(0), at(0)),
            (after, None) if after > last => (at(last), at(last)),
            (0, Some(period)) => ((at(last).0 - period, at(last).1), at(0)),
            (after, Some(period)) if after > last => (at(last), (at(0).0 + period, at(0).1)),
            (after, _) => (at(after - 1), at(after)),
        };
        let width = next.0 - before.0;
        let part = if width > 0.0 {
            (t - before.0) / width
        } else {
            0.0
        };
        match (before.1.is_nan(), next.1.is_nan()) {
            (true, _) => next.1,
            (_, true) => before.1,
            _ => before.1 + part * (next.1 - before.1),
        }
    }
}

/// The largest value in each piece.
fn binned(deviations: &Deviations, u: &Line<'_>, v: &Line<'_>) -> Vec<f64> {
    let mut values = vec![f64::NAN; u.pieces() * v.pieces()];
    let sites = deviations.u.iter().zip(&deviations.v);
    for ((&s, &t), &distance) in sites.zip(&deviations.distances) {
        let value = &mut values[u.piece(s) * v.pieces() + v.piece(t)];
        *value = value.max(distance);
    }
    values
}

/// Gives pieces without a value the mean of those around them, those next to known ones first.
fn fill(values: &mut [f64], width: usize) {
    let height = values.len() / width;
    let around = |index: usize| {
        let (i, j) = (index / width, index % width);
        let rows = [
            (i > 0).then(|| index - width),
            (i + 1 < height).then(|| index + width),
        ];
        let columns = [
            (j > 0).then(|| index - 1),
            (j + 1 < width).then(|| index + 1),
        ];
        rows.into_iter().chain(columns).flatten()
    };
    let unknown = |values: &[f64], index: usize| values[index].is_nan();
    let mut next: Vec<usize> = (0..values.len())
        .filter(|&it| unknown(values, it) && around(it).any(|near| !unknown(values, near)))
        .collect();
    while !next.is_empty() {
        let mean = |&index: &usize| {
            let known = around(index).map(|it| values[it]).filter(|it| !it.is_nan());
            let (count, sum) = known.fold((0.0, 0.0), |(count, sum), it| (count + 1.0, sum + it));
            (index, sum / count)
        };
        let means: Vec<(usize, f64)> = next.iter().map(mean).collect();
        means
            .iter()
            .for_each(|&(index, value)| values[index] = value);
        let reached = means.iter().flat_map(|(index, _)| around(*index));
        next = reached.filter(|&it| unknown(values, it)).collect();
        next.sort_unstable();
        next.dedup();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(parameters: &[f64], period: Option<f64>) -> Line<'_> {
        let breaks = (0..=4).map(|i| f64::from(i) / 4.0).collect();
        Line {
            parameters,
            breaks,
            period,
        }
    }

    #[test]
    fn pieces_have_the_largest_of_their_points_or_what_lies_between_others() {
        let line = line(&[0.0, 0.1, 1.0], None);
        assert_eq!(line.spread(&[3.0, 1.0, 1.0]), [3.0, 1.0, 1.0, 1.0]);
        assert_eq!(line.spread(&[0.0, 0.0, 9.0])[3], 9.0);
        let middle = line.spread(&[0.0, 0.0, 9.0])[1];
        assert!((middle - 9.0 * (0.375 - 0.1) / 0.9).abs() < 1e-12);
    }

    #[test]
    fn behind_the_last_point_of_a_closed_direction_is_the_first() {
        let closed = line(&[0.0, 0.5], Some(1.0)).spread(&[0.0, 8.0]);
        assert_eq!(closed, [0.0, 6.0, 8.0, 2.0]);
        let open = line(&[0.0, 0.5], None).spread(&[0.0, 8.0]);
        assert_eq!(open, [0.0, 6.0, 8.0, 8.0]);
    }

    #[test]
    fn gaps_are_filled_from_their_edges() {
        let mut values = [1.0, f64::NAN, f64::NAN, f64::NAN, f64::NAN, 3.0];
        fill(&mut values, 3);
        assert_eq!(values, [1.0, 1.0, 3.0, 1.0, 3.0, 3.0]);
        let mut nothing = [f64::NAN; 4];
        fill(&mut nothing, 2);
        assert!(nothing.iter().all(|it| it.is_nan()));
    }
}
