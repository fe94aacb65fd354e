//! Parameters of scattered points that fold: points with nearly the same parameters are far from each other, as those
//! on both sides of a tube that was projected to a plane. No surface is near both.

use crate::data::points::Points;
use crate::setup::Setup;

/// The points that are examined, at equal distances in the list.
const SAMPLES: usize = 96;

/// Parameters fold if more than one sample in 16 has a point with nearly the same parameters far away.
const ONE_IN: usize = 16;

/// A point is far away if its distance, relative to the bounding box's diagonal, exceeds this multiple of the
/// distance of its parameters, relative to their range. A steep surface stays below it.
const STEEP: f64 = 12.0;

/// The least distance of such a point, as a part of the bounding box's diagonal.
const FAR: f64 = 0.03;

/// Two points with nearly the same parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Fold {
    /// Their indices.
    pub points: [usize; 2],
    /// How far they are from each other.
    pub distance: f64,
}

impl Fold {
    /// The fold of scattered points where they are furthest from each other, if their parameters fold.
    pub(crate) fn of(setup: &Setup) -> Option<Self> {
        let v = setup.v().filter(|_| setup.is_scattered())?;
        let lanes = [&setup.u().parameters, &v.parameters].map(|lane| normalized(lane));
        let parameters = Points::from_lanes(lanes);
        let count = parameters.len();
        let samples = count.min(SAMPLES);
        let folds = (0..samples).filter_map(|k| Self::at(setup, &parameters, k * count / samples));
        let folds: Vec<Self> = folds.collect();
        let furthest = folds
            .iter()
            .max_by(|a, b| a.distance.total_cmp(&b.distance));
        furthest.filter(|_| folds.len() * ONE_IN > samples).copied()
    }

    /// A point and the one with the nearest parameters, if that is far away.
    fn at(setup: &Setup, parameters: &Points, index: usize) -> Option<Self> {
        let others = (0..parameters.len()).filter(|other| *other != index);
        let apart = |other: &usize| parameters.distance(index, *other);
        let nearest = others.min_by(|a, b| apart(a).total_cmp(&apart(b)))?;
        let distance = setup.points.distance(index, nearest);
        let part = distance / setup.diagonal();
        (part > FAR && part > STEEP * apart(&nearest)).then_some(Self {
            points: [index, nearest],
            distance,
        })
    }
}

/// Parameters as parts of their range.
fn normalized(lane: &[f64]) -> Vec<f64> {
    let low = lane.iter().copied().fold(f64::INFINITY, f64::min);
    let high = lane.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    lane.iter().map(|x| (x - low) / (high - low)).collect()
}
