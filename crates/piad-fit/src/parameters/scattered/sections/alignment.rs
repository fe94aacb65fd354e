//! Starts and directions of sections, aligned with the section before.

use super::polyline::Polyline;
use crate::data::vectors::{dot, minus};

/// The fewest and the most places at which two sections are compared.
const MIN_SAMPLES: usize = 16;
const MAX_SAMPLES: usize = 256;

/// The number of places at which sections are compared.
pub(super) fn places(sections: &[Polyline]) -> usize {
    let edges = sections.iter().map(Polyline::edges).max();
    (2 * edges.unwrap_or(0)).clamp(MIN_SAMPLES, MAX_SAMPLES)
}

/// A section as the surface takes it.
#[derive(Clone, Debug)]
pub(super) struct Alignment {
    /// True if it goes the other way than its points.
    is_reversed: bool,
    /// The part of its length after which it starts.
    start: f64,
    /// Places at equal steps along it.
    pub(super) places: Vec<[f64; 3]>,
}

impl Alignment {
    /// A section aligned with the one before it, with this number of places.
    pub(super) fn after(before: Option<&Self>, section: &Polyline, count: usize) -> Self {
        let as_given = Self::new(section, false, 0.0, count);
        let Some(before) = before else {
            return as_given;
        };
        if section.is_closed {
            return as_given.turned(section, &before.places);
        }
        let reversed = Self::new(section, true, 1.0, count);
        let [given, turned] = [&as_given, &reversed].map(|it| squares(&it.places, &before.places));
        if turned < given { reversed } else { as_given }
    }

    /// A section that starts after a part of its length.
    fn new(section: &Polyline, is_reversed: bool, start: f64, count: usize) -> Self {
        let steps = match section.is_closed {
            true => count,
            false => count - 1,
        };
        let mut alignment = Self {
            is_reversed,
            start,
            places: Vec::new(),
        };
        let parts = (0..count).map(|k| k as f64 / steps as f64);
        if !section.is_closed {
            alignment.places = section.at(parts);
            if is_reversed {
                alignment.places.reverse();
            }
            return alignment;
        }
        // From the start to the end, and on from the beginning.
        let own = |part: f64| match is_reversed {
            true => start - part,
            false => start + part,
        };
        let mut order: Vec<(usize, f64)> =
            parts.map(|part| fraction(own(part))).enumerate().collect();
        order.sort_by(|a, b| a.1.total_cmp(&b.1));
        let places = section.at(order.iter().map(|(_, part)| *part));
        alignment.places = vec![[0.0; 3]; count];
        for ((k, _), place) in order.into_iter().zip(places) {
            alignment.places[k] = place;
        }
        alignment
    }

    /// A closed section with the sense and the start with which the sum of squared distances from others is least. The
    /// start is between two places: at the least value of the parabola of three of these sums.
    fn turned(self, section: &Polyline, others: &[[f64; 3]]) -> Self {
        let count = self.places.len();
        let sum = |is_reversed: bool, shift: usize| -> f64 {
            let own = |k: usize| match is_reversed {
                true => self.places[(count + shift - k) % count],
                false => self.places[(shift + k) % count],
            };
            others
                .iter()
                .enumerate()
                .map(|(k, other)| square(own(k), *other))
                .sum()
        };
        let mut least = (f64::INFINITY, false, 0.0);
        for is_reversed in [false, true] {
            let sums: Vec<f64> = (0..count).map(|shift| sum(is_reversed, shift)).collect();
            let Some(shift) = (0..count).min_by(|a, b| sums[*a].total_cmp(&sums[*b])) else {
                continue;
            };
            if sums[shift] < least.0 {
                let beside = [sums[(shift + count - 1) % count], sums[(shift + 1) % count]];
                let bend = beside[0] - 2.0 * sums[shift] + beside[1];
                let part = match bend > 0.0 {
                    true => 0.5 * (beside[0] - beside[1]) / bend,
                    false => 0.0,
                };
                least = (
                    sums[shift],
                    is_reversed,
                    (shift as f64 + part) / count as f64,
                );
            }
        }
        let (_, is_reversed, start) = least;
        Self::new(section, is_reversed, fraction(start), count)
    }

    /// The parameter from 0 to 1 of a place after a part of the section's own length.
    pub(super) fn parameter(&self, part: f64) -> f64 {
        let from_start = match self.is_reversed {
            true => self.start - part,
            false => part - self.start,
        };
        match (0.0..=1.0).contains(&from_start) {
            true => from_start,
            false => fraction(from_start),
        }
    }
}

/// The fractional part.
fn fraction(x: f64) -> f64 {
    let fraction = x.rem_euclid(1.0);
    if fraction < 1.0 { fraction } else { 0.0 }
}

fn square(a: [f64; 3], b: [f64; 3]) -> f64 {
    let between = minus(a, b);
    dot(between, between)
}

fn squares(some: &[[f64; 3]], others: &[[f64; 3]]) -> f64 {
    some.iter().zip(others).map(|(a, b)| square(*a, *b)).sum()
}
