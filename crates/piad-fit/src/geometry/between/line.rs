//! The gaps between the data of a direction, and the places in them that are examined.

use crate::basis::direction::Direction;

/// The steps in which a gap is examined closely.
const CLOSER: usize = 16;

/// The gaps between successive data of a direction.
pub(super) struct Line {
    /// The data at both ends.
    pub(super) ends: Vec<[usize; 2]>,
    /// Their parameters.
    ranges: Vec<[f64; 2]>,
    pub(super) places: Vec<Place>,
}

/// A place in a gap.
#[derive(Clone, Copy)]
pub(super) struct Place {
    pub(super) parameter: f64,
    pub(super) gap: usize,
    /// The part of the gap that is before it.
    pub(super) part: f64,
}

impl Line {
    /// Between data with these indices, with places at some parts of each gap, and of each span of knots, as these can be
    /// shorter.
    pub(super) fn new(direction: &Direction, data: &[usize], parts: &[f64]) -> Self {
        let all = parameters(direction, data);
        let gaps = all.len() - 1;
        let inside = |[from, to]: [f64; 2]| {
            let parts = parts.iter();
            parts.map(move |part| (1.0 - part) * from + part * to)
        };
        let place = |gap: usize, parameter: f64| Place {
            parameter,
            gap,
            part: (parameter - all[gap]) / (all[gap + 1] - all[gap]),
        };
        let in_gaps = (0..gaps).flat_map(|gap| {
            let parameters = inside([all[gap], all[gap + 1]]);
            parameters.map(move |t| place(gap, t))
        });
        // Where knots are at the data, spans are gaps.
        let is_no_gap = |[from, to]: &[f64; 2]| {
            let gap = all.partition_point(|start| start < from);
            all.get(gap..gap + 2) != Some(&[*from, *to])
        };
        let in_spans = spans(direction).filter(is_no_gap);
        let in_spans = in_spans.flat_map(inside).filter_map(|t| {
            // The knots of a closed direction with corners begin at the first of them.
            let turn = direction.period().filter(|_| t >= all[gaps]);
            let t = t - turn.unwrap_or(0.0);
            let gap = all.partition_point(|start| *start <= t).checked_sub(1)?;
            (gap < gaps).then(|| place(gap, t))
        });
        Self {
            ends: (0..gaps)
                .map(|i| [data[i], data[(i + 1) % data.len()]])
                .collect(),
            ranges: (0..gaps).map(|i| [all[i], all[i + 1]]).collect(),
            places: in_gaps.chain(in_spans).collect(),
        }
    }

    /// Across a curve: one line.
    pub(super) fn single() -> Self {
        Self {
            ends: vec![[0, 0]],
            ranges: vec![[0.0; 2]],
            places: vec![Place {
                parameter: 0.0,
                gap: 0,
                part: 0.0,
            }],
        }
    }

    pub(super) fn count(&self) -> usize {
        self.ends.len()
    }

    /// Places in small steps in one gap.
    pub(super) fn closer(&self, gap: usize) -> Vec<Place> {
        let [from, to] = self.ranges[gap];
        let place = |part: f64| Place {
            parameter: (1.0 - part) * from + part * to,
            gap,
            part,
        };
        let steps = if from < to { CLOSER } else { 2 };
        (1..steps).map(|k| place(k as f64 / steps as f64)).collect()
    }
}

/// The spans of the knots of a direction.
pub(super) fn spans(direction: &Direction) -> impl Iterator<Item = [f64; 2]> {
    let (low, high) = direction.basis.domain();
    let knots = direction.basis.knots().unwrap_or_default().to_vec();
    let pairs = 1..knots.len();
    let spans = pairs.map(move |i| [knots[i - 1], knots[i]]);
    spans.filter(move |&[from, to]| low <= from && from < to && to <= high)
}

/// The parameters of some data of a direction, of a closed one also the first of them after a period.
pub(super) fn parameters(direction: &Direction, data: &[usize]) -> Vec<f64> {
    let t = &direction.parameters;
    let again = direction.period().map(|period| t[data[0]] + period);
    data.iter().map(|&i| t[i]).chain(again).collect()
}
