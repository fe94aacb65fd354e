//! Samples along curves, for all formats that have them.

use super::error::{ExportError, NetIndex};
use super::nurbs::Nurbs;
use super::options::Options;
use piad_fit::engine::arc_length::ArcLength;
use piad_fit::engine::nurbs::{Jet, SpanParameter, steps_between};

/// The most samples at equal distances.
pub(super) const MOST_SPACED: usize = 1_000_000;

/// The part of a step that is rounding: a length of ten spacings has ten steps.
const ROUNDING: f64 = 1e-9;

/// The sites of samples along a curve, from one end to the other: the requested number, or a suitable number with at
/// most this number of steps. They are at equal steps in each knot span, or at equal distances along the curve.
pub(super) fn along_curve(
    nurbs: &Nurbs,
    options: &Options,
    most: usize,
) -> Result<Vec<SpanParameter>, ExportError> {
    let samples = options.samples.map(|grid| grid.rows);
    let steps = samples.map_or_else(|| nurbs.u.steps(most), steps_between);
    match options.is_by_length() {
        false => Ok(nurbs.u.sites(steps)),
        true => by_length(nurbs, options, steps),
    }
}

/// Sites at equal distances: with the chosen spacing, or a little less so that they end at the end of the curve, or
/// with this number of steps.
pub(super) fn by_length(
    nurbs: &Nurbs,
    options: &Options,
    steps: usize,
) -> Result<Vec<SpanParameter>, ExportError> {
    let mut lengths = ArcLength::new(nurbs);
    let total = lengths.total();
    if !total.is_finite() {
        return Err(ExportError::Extent);
    }
    let Some(spacing) = options.spacing else {
        return Ok(lengths.sites(steps));
    };
    let steps = (total / spacing - ROUNDING).ceil().max(1.0);
    if steps >= MOST_SPACED as f64 {
        return Err(ExportError::TooManySamples {
            spacing,
            length: total,
            most: MOST_SPACED,
        });
    }
    Ok(lengths.sites(steps as usize))
}

/// The points of samples. Those that are not finite are refused: sums can overflow although the control points do
/// not.
pub(super) fn finite(jets: &[Jet], columns: Option<usize>) -> Result<Vec<[f64; 3]>, ExportError> {
    let points: Vec<[f64; 3]> = jets.iter().map(|jet| jet.point).collect();
    for (index, point) in points.iter().enumerate() {
        let coordinates = point.iter().enumerate();
        if let Some((coordinate, &value)) = coordinates.into_iter().find(|(_, x)| !x.is_finite()) {
            return Err(ExportError::NotFinite {
                what: "sample",
                place: NetIndex::new(index, columns),
                coordinate,
                value,
            });
        }
    }
    Ok(points)
}
