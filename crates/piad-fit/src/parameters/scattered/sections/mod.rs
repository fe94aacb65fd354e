//! Sections: curves across a surface, each with its own number of points.
//!
//! v of a point is its chord length along its section, as a part of that of the section, times the mean length of all
//! sections. u of a section is the mean distance between the sections before it: of places at equal steps along them. Closed
//! sections are turned so that these distances are least: each starts and goes around as it suits the one before it
//! ([`alignment`]). Sections that cross each other are refused ([`crossing`]).

mod alignment;
mod crossing;
mod polyline;
mod stack;

use std::sync::Arc;

use super::pairs::{Domain, Pairs};
use crate::data::points::Points;
use crate::data::vectors::{in_space, length, minus};
use crate::interrupt;
use crate::invalid::{Axis, Invalid, Place};

pub use stack::is_stack;

use alignment::Alignment;
use polyline::Polyline;

/// Points that are sections, one after the other.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Sections {
    /// The number of points of each.
    pub counts: Arc<Vec<usize>>,
    /// True if the last point of each is followed by its first one. Without it that is so where these are near each other
    /// in all sections.
    pub closed: Option<bool>,
}

impl Sections {
    /// Sections with these numbers of points.
    pub fn new(counts: impl Into<Vec<usize>>) -> Self {
        Self {
            counts: Arc::new(counts.into()),
            closed: None,
        }
    }

    /// The default degrees of a surface: three, or less where there are few sections or points in them.
    #[must_use]
    pub fn usual_degrees(&self) -> [usize; 2] {
        let most = self.counts.iter().max().copied().unwrap_or_default();
        [self.counts.len(), most].map(|count| count.saturating_sub(1).clamp(1, 3))
    }

    /// Those of some of the points, whose indices increase.
    pub(crate) fn of(&self, indices: &[usize]) -> Self {
        let mut start = 0;
        let kept = self.counts.iter().map(|count| {
            let end = start + count;
            let [before, after] =
                [start, end].map(|it| indices.partition_point(|&index| index < it));
            start = end;
            after - before
        });
        Self {
            counts: Arc::new(kept.collect()),
            closed: self.closed,
        }
    }

    /// u between the sections, and v along them, closed also where requested.
    pub(super) fn parameters(&self, points: &Points, closed: [bool; 2]) -> Result<Pairs, Invalid> {
        let [u_is_closed, v_is_closed] = closed;
        let requested = v_is_closed.then_some(true).or(self.closed);
        let sections = self.polylines(points, requested)?;
        let mean = sections.iter().map(Polyline::length).sum::<f64>() / sections.len() as f64;
        let count = alignment::places(&sections);
        let (mut all_u, mut all_v) = (Vec::new(), Vec::new());
        let mut u = 0.0;
        let first = Alignment::after(None, &sections[0], count);
        let mut last = first.clone();
        for (index, section) in sections.iter().enumerate() {
            interrupt::check();
            if index > 0 {
                let next = Alignment::after(Some(&last), section, count);
                u += step(index, &sections, [&last, &next])?;
                last = next;
            }
            all_v.extend(section.parts().map(|part| last.parameter(part) * mean));
            all_u.resize(all_v.len(), u);
        }
        let around = u + distance(&last.places, &first.places);
        let is_closed = sections.iter().all(|section| section.is_closed);
        let domain = |is_closed, period| match is_closed {
            true => Domain::Closed(period),
            false => Domain::Data,
        };
        Ok(Pairs {
            values: Arc::new(Points::from_lanes([all_u, all_v])),
            domains: [domain(u_is_closed, around), domain(is_closed, mean)],
        })
    }

    /// The same with defaults filled in.
    pub(super) fn known(&self, points: &Points) -> Result<Self, Invalid> {
        let is_closed = self
            .polylines(points, self.closed)?
            .iter()
            .all(|it| it.is_closed);
        Ok(Self {
            closed: Some(is_closed),
            ..self.clone()
        })
    }

    /// The sections one by one, closed or open as requested, or by their ends.
    fn polylines(&self, points: &Points, closed: Option<bool>) -> Result<Vec<Polyline>, Invalid> {
        let counts = &self.counts;
        if counts.len() < 2 {
            let count = counts.len();
            let detail = format!("a surface through sections has two of them or more, not {count}");
            return Err(Invalid::at(Place::Parameters(Axis::U), detail));
        }
        let (sum, expected) = (
            counts
                .iter()
                .fold(0, |sum: usize, it| sum.saturating_add(*it)),
            points.len(),
        );
        if sum != expected {
            let detail = format!("the sections have {sum} points, and {expected} are given");
            return Err(Invalid::at(Place::Parameters(Axis::U), detail));
        }
        let mut start = 0;
        let sections = counts.iter().enumerate().map(|(index, &count)| {
            let places = (start..start + count).map(|at| in_space(points.point(at)));
            start += count;
            let section = Polyline::new(places.collect(), closed == Some(true));
            section.ok_or_else(|| {
                let detail = match closed {
                    Some(true) => format!("section {index} has {count} points: a closed one has at least three, which are not all in one place"),
                    _ => format!("section {index} has {count} points: it has at least two, which are not all in one place"),
                };
                wrong(index, detail)
            })
        });
        let sections = sections.collect::<Result<Vec<_>, _>>()?;
        let come_back = closed.is_none() && sections.iter().all(Polyline::comes_back);
        Ok(match come_back {
            true => sections.into_iter().map(Polyline::closed).collect(),
            false => sections,
        })
    }
}

/// The distance of a section from the one before it.
fn step(
    index: usize,
    sections: &[Polyline],
    [before, next]: [&Alignment; 2],
) -> Result<f64, Invalid> {
    let step = distance(&before.places, &next.places);
    let detail = if step.is_nan() || step <= 0.0 {
        format!("section {index} is the same as section {}", index - 1)
    } else if crossing::cross(&sections[index - 1], &sections[index]) {
        format!(
            "section {index} crosses section {}: a surface goes from each section to the next one",
            index - 1
        )
    } else {
        return Ok(step);
    };
    Err(wrong(index, detail))
}

/// The mean distance of places.
fn distance(some: &[[f64; 3]], others: &[[f64; 3]]) -> f64 {
    let pairs = some.iter().zip(others);
    pairs.map(|(a, b)| length(minus(*b, *a))).sum::<f64>() / some.len() as f64
}

/// A validation error in a section.
fn wrong(index: usize, detail: String) -> Invalid {
    Invalid::at(Place::Section(index), detail)
}

#[cfg(test)]
mod tests;
